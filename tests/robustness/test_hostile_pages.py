"""Markup in every text of a result: none of it is markup of its page, or reaches a terminal."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from support import PROJECT

import symgen
from symgen.report.store import load_result, result_page

WRITTEN = PROJECT / "tests" / "reference" / "schemas"
EVIL = '"></script><script>alert(1)</script><img src=x onerror=alert(2)>\x1b]0;x\x07'
Place = tuple[str | int, ...]


def places(content: Any, above: Place = ()) -> Iterator[Place]:
    """Yield where texts are."""
    if isinstance(content, (dict, list)):
        keys = content if isinstance(content, dict) else range(len(content))
        for key in keys:
            yield from places(content[key], (*above, key))
    elif isinstance(content, str):
        yield above


def put(content: Any, place: Place) -> Any:
    """Return a content with the evil text at a place."""
    spoiled = json.loads(json.dumps(content))
    node = spoiled
    for key in place[:-1]:
        node = node[key]
    node[place[-1]] = EVIL
    return spoiled


def accepted(folder: Path, name: str, content: Any) -> bool:
    """Whether a result is read; it is refused in a plain line."""
    (folder / name).write_text(json.dumps(content))
    try:
        load_result(folder)
    except symgen.SymgenError as error:
        assert "\x1b" not in str(error)
        return False
    return True


@pytest.mark.parametrize(
    "kind", ["estimate-1", "estimate-2", "diagnosis-1", "diagnosis-1-effect", "payload-1",
             "payload-1-frame", "prediction-2"],
)  # fmt: skip
def test_no_text_of_a_result_is_markup_of_its_page(kind: str, tmp_path: Path) -> None:
    """One of all places that are alike; all that are not refused stand in one page."""
    name = f"{kind.split('-')[0]}.json"
    shutil.copytree(WRITTEN / kind, tmp_path / kind)
    content = json.loads((tmp_path / kind / name).read_text("utf-8"))
    alike = {tuple(k if isinstance(k, str) else 0 for k in p): p for p in places(content)}
    done = 0
    for place in alike.values():
        spoiled = put(content, place)
        if accepted(tmp_path / kind, name, spoiled):
            content, done = spoiled, done + 1
    assert done > 2
    accepted(tmp_path / kind, name, content)
    page = result_page(load_result(tmp_path / kind))
    assert "onerror=alert(2)" in page  # it is there, as a text
    for raw in ("<img src=x", "<script>alert", "</script><script>a", "\x1b"):
        assert raw not in page

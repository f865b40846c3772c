"""Results that older commands wrote are read by newer ones: a file of every schema, as written.

schemas/KIND-VERSION holds them; curves are cut after a few samples, rejections after three.
"""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from browser import Page
from support import PROJECT

import symgen
from symgen.report.store import load_result, result_page

WRITTEN = Path(__file__).with_name("schemas")
RESULTS = [p for p in sorted(WRITTEN.iterdir()) if not p.name.startswith("manifest")]
#: What nothing reads again.
ONLY_WRITTEN = {
    "symgen.trajectory/1",
    "symgen.comparison/1",
    "symgen.samples/1",
}


def _content(folder: Path) -> dict[str, object]:
    kind = folder.name.split("-")[0]
    return dict(json.loads((folder / f"{kind}.json").read_text("utf-8")))


@pytest.mark.parametrize("folder", RESULTS, ids=lambda p: p.name)
def test_a_result_of_every_schema_is_read_and_printed(folder, command):
    kind, version = folder.name.split("-")[:2]
    content = _content(folder)
    assert content["schema"] == f"symgen.{kind}/{version}"
    result = load_result(folder)
    assert result.robot == "planar2r"
    code, out, err = command("report", folder)
    assert (code, err) == (0, "")
    # The numbers of the file are those that are printed.
    if kind == "estimate":
        assert [(p.name, p.value) for p in result.parameters] == [
            (p["name"], p["value"]) for p in content["parameters"]
        ]
        known = [p for p in content["parameters"] if p["relative_std_percent"] <= 30]
        shown = dict(re.findall(r"^([A-Z]+\d\w*) +(\S+)", out, re.MULTILINE))
        off = {p["name"]: abs(float(shown[p["name"]]) - p["value"]) for p in known}
        assert all(off[p["name"]] < min(p["std"], 5e-3 * abs(p["value"])) for p in known)
        said = []
    elif kind == "prediction":
        assert result.error.relative == content["torque_error"]["relative"]
        said = [f"{100 * x:#.3g}" for x in content["torque_error"]["per_joint"]]
    elif kind == "diagnosis":
        said = [content["verdict"], *(e["name"] for e in content["effects"])]
    elif kind == "study":
        assert result.to_json() == content
        said = [f"{p['value']:.4g}" for p in content["results"][0]["parameters"]]
    elif kind == "simulation":
        assert result.to_json() == {"driven_by": "torque", **content}
        last = [f["horizons"][-1]["position_error"] for f in content["files"]]
        said = [f"{100 * x:#.3g}".rstrip(".") + " %" for x in last]
    else:
        assert result.mass.value == content["mass"]["value"]
        said = [f"{content['mass']['value']:.5g}"[:4]]
    for text in said:
        assert text in out
    _on_the_page_too(out, result_page(result))


def _on_the_page_too(out: str, html: str) -> None:
    """What the terminal says, the page says: cells of tables, figures, verdict and reasons."""
    page = " ".join(Page(html).text.split())
    for line in out.splitlines():
        if line.startswith(("run: ", "repair: ", "note: ", "next: ", "residuals: ", "bias and std",
                            "at once, ")):  # fmt: skip
            continue
        for cell in re.split(r"\s{2,}", line.removeprefix("verdict: ").removeprefix("  - ")):
            words = cell.strip().split(": ", 1) if line.count(": ") == 1 else [cell.strip()]
            for text in words:
                assert text.lower() in page.lower(), line


@pytest.mark.parametrize("folder", RESULTS, ids=lambda p: p.name)
def test_an_unknown_key_is_refused_by_its_name(folder, tmp_path):
    copy = shutil.copytree(folder, tmp_path / folder.name)
    kind = folder.name.split("-")[0]
    inner = {"estimate": "residual", "diagnosis": "gap", "prediction": "band", "payload": "mass"}
    for place in ("", inner.get(kind, "")):
        content = _content(folder)
        (content[place] if place else content)["surprise"] = 1
        (copy / f"{kind}.json").write_text(json.dumps(content))
        with pytest.raises(symgen.ParameterError, match=rf"{kind}\.json.*surprise: an unknown key"):
            load_result(copy)


def test_an_estimate_of_any_version_gives_parameters(command, tmp_path):
    for folder in RESULTS:
        if folder.name.startswith("estimate"):
            arguments = ("--parameters", folder / "estimate.json", "--duration", "1")
            into = tmp_path / f"{folder.name}.csv"
            code, _, err = command("simulate", "planar2r", *arguments, "--into", into)
            assert code == 0, err


def test_every_schema_that_the_code_names_has_a_file_here():
    code = "".join(p.read_text("utf-8") for p in (PROJECT / "symgen").rglob("*.py"))
    named = set(re.findall(r"symgen\.[a-z]+/[0-9]+", code))
    assert named - ONLY_WRITTEN == {str(_content(p)["schema"]) for p in WRITTEN.iterdir()}


def test_curves_without_a_law_of_an_older_diagnosis_are_left_out(tmp_path):
    folder = shutil.copytree(WRITTEN / "diagnosis-1", tmp_path / "old")
    content = _content(WRITTEN / "diagnosis-1") | {"free_functions": [{"joint": 1}]}
    (folder / "diagnosis.json").write_text(json.dumps(content), "utf-8")
    assert load_result(folder).verdict == content["verdict"]


def _horizon(seconds: float) -> dict[str, object]:
    return {"seconds": seconds, "position_error": 0.1, "spread": 0.01, "per_joint": [0.1, 0.1]}


#: Result, key of the file, its value, and words of the message.
DAMAGED = [
    ("estimate-2", "torque_residual.validation.relative", -1e308, "1e+100"),
    ("estimate-2", "torque_residual.validation.relative", -0.5, "at least 0"),
    ("estimate-2", "torque_residual.validation.per_joint", [0.1], "another number of joints"),
    ("estimate-2", "parameters.0.std", -1.0, "parameters.0.std"),
    ("estimate-2", "uses.simulation.before", [_horizon(0.5)], "other times"),
    ("estimate-2", "band.cutoff_hz", 1e-320, "band"),
    ("payload-1", "residual.joints_before", [0.1] * 3, "another number of joints"),
    ("payload-1", "joints", [], "another number of joints"),
    ("payload-1", "mass.std", -1.0, "mass.std"),
    ("simulation-1", "files", [], "no horizons"),
    ("simulation-1", "files.1.horizons", [_horizon(0.2)], "other times"),
    ("study-1", "results.0.parameters.0.std", -1.0, "std"),
    ("study-1", "joints", 5, "an unknown key"),
    ("diagnosis-1", "joints", 5, "an unknown key"),
    ("diagnosis-1", "gap.before.per_joint", [0.1] * 3, "another number of joints"),
]


@pytest.mark.parametrize(("kind", "key", "value", "words"), DAMAGED)
def test_a_damaged_result_is_refused_in_a_line(kind, key, value, words, tmp_path, command):
    folder = shutil.copytree(WRITTEN / kind, tmp_path / kind)
    content = _content(folder)
    if key == "uses.simulation.before":
        content["uses"]["simulation"]["horizons"] = [_horizon(0.2)]
    *groups, last = (int(part) if part.isdecimal() else part for part in key.split("."))
    inner = content
    for group in groups:
        inner = inner[group]
    inner[last] = value
    (folder / f"{kind.split('-')[0]}.json").write_text(json.dumps(content), "utf-8")
    code, _, err = command("report", folder)
    assert (code, err.count("\n")) == (2, 1), err
    assert words in err


@pytest.mark.parametrize(
    "t",
    [[0.0, 0.1, 0.1], [0.2, 0.1, 0.0], [0.0, 1e-320, 2e-320], [0.0, 1e308, 1.5e308], [0.0, 0.1]],
)
def test_curves_at_times_that_no_log_has_are_refused_in_a_line(t, tmp_path, command):
    folder = shutil.copytree(WRITTEN / "estimate-2", tmp_path / "damaged")
    index = {"traces": [{"log": "a.csv", "kind": "validation", "quantity": "torque"}]}
    arrays = {f"trace0_{name}": np.ones((3, 2)) for name in ("measured", "predicted")}
    text = np.frombuffer(json.dumps(index).encode(), dtype=np.uint8)
    np.savez(folder / "curves.npz", index=text, trace0_t=np.array(t), **arrays)
    code, _, err = command("report", folder, "--into", tmp_path / "page.html")
    assert (code, err.count("\n")) == (2, 1), err
    assert "curves.npz: damaged" in err

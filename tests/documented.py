"""The code blocks of the documentation, and how tests run them."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from support import PROJECT

DOCS = PROJECT / "docs"
PAGES = sorted(p for p in DOCS.glob("*.md")) + [PROJECT / "README.md"]
EXAMPLES = sorted((DOCS / "examples").glob("*.py"))
#: A fence with what stands above it for the tests: <!-- test: slow, exit 1 -->
_BLOCK = re.compile(
    r"(?:^<!-- test: (?P<told>[^>]*) -->\n)?^```(?P<kind>\w+)(?: title=\"(?P<file>[^\"]+)\")?\n"
    r"(?P<code>.*?)^```$",
    re.M | re.S,
)
#: What is shown and not run: output, equations, drawings of the tree.
SHOWN = {"output", "text", "math"}
#: A block that is a file of docs/files.
_FILE = re.compile(r'--8<-- "(?P<name>[^"]+)"\n')
_NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]\d+)?")


@dataclass(frozen=True)
class Block:
    """A fenced block of a page.

    Attributes:
        line: where it begins.
        kind: language.
        file: the name of the file that it is; empty where it is run.
        told: words for the tests: "slow", "exit 1", "needs NAME" (a program or a module), "by NAME"
            (another test that runs it).
        code: its text.
    """

    line: int
    kind: str
    file: str
    told: tuple[str, ...]
    code: str

    @property
    def slow(self) -> bool:
        """Whether it waits for -m slow."""
        return "slow" in self.told

    @property
    def elsewhere(self) -> str:
        """The test that runs it instead."""
        return next((w.removeprefix("by ") for w in self.told if w.startswith("by ")), "")

    @property
    def missing(self) -> str:
        """The first thing that it needs and that is not here: a program, or a module."""
        for word in self.told:
            name = word.removeprefix("needs ")
            if name != word and not (shutil.which(name) or find_spec(name)):
                return name
        return ""

    @property
    def code_expected(self) -> int:
        """The exit code that the page promises."""
        return next((int(w.split()[1]) for w in self.told if w.startswith("exit ")), 0)


def blocks(page: Path) -> Iterator[Block]:
    """Yield the fenced blocks of a page."""
    text = page.read_text("utf-8")
    for m in _BLOCK.finditer(text):
        told = tuple(w.strip() for w in (m["told"] or "").split(",") if w.strip())
        line = text.count("\n", 0, m.start("code"))
        included = _FILE.fullmatch(m["code"])
        code = (DOCS / "files" / included["name"]).read_text("utf-8") if included else m["code"]
        yield Block(line, m["kind"], m["file"] or "", told, code)


def assert_same_output(got: str, want: str) -> None:
    """Check that two texts have the same words, and numbers that are 2 % apart at most.

    A number with a decimal point may also differ by one in its last digit.
    """
    assert _NUMBER.sub("#", got).split() == _NUMBER.sub("#", want).split(), got
    for pair in zip(_NUMBER.findall(got), _NUMBER.findall(want), strict=True):
        number, wanted = map(float, pair)
        mantissa, _, exponent = pair[1].partition("e")
        decimals = len(mantissa.partition(".")[2])
        digit = 1.01 * 10.0 ** (int(exponent or 0) - decimals) if decimals else 0.0
        assert abs(number - wanted) <= abs(wanted) / 50 + digit, pair


def assert_quoted(quotation: str, printed: str) -> None:
    """Check that the parts of a quotation were printed in their order; "..." is between them."""
    begin = 0
    for part in quotation.split("..."):
        words = (_NUMBER.pattern.join(map(re.escape, _NUMBER.split(w))) for w in part.split())
        found = re.compile(r"\s+".join(words)).search(printed, begin)
        assert found, f"not printed: {part}\nprinted: {printed[begin:]}"
        assert_same_output(found[0], part)
        begin = found.end()


def shell(code: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run lines of a shell in a folder, with this Python's symgen first on the path."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    # the package under test, whether it is installed or not
    environment = os.environ | {
        "PATH": path, "OPENBLAS_NUM_THREADS": "1", "PYTHONPATH": str(PROJECT), "MPLBACKEND": "agg",
    }  # fmt: skip
    return subprocess.run(
        ["bash", "-euo", "pipefail", "-c", code], cwd=folder, env=environment,
        capture_output=True, text=True, timeout=900,
    )  # fmt: skip

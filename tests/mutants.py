"""Faults put into the code one at a time, and whether its quick tests see them.

    python tests/mutants.py GROUP COUNT [--seed WORD] [--reached FILE]
    python tests/mutants.py GROUP 0 --at PLACE... [--reached FILE]
    python tests/mutants.py --again GROUP PLACE TEST...

Prints a line for each mutant of the group, COUNT of them drawn at random, or those at some PLACES
among all: killed, and by which test, or survived. `--again` shows a mutant to one TEST. The code is
copied into a folder of its own.
Libraries are imported once, and every mutant runs in a fork of that process. All tests run once
without a change, and which lines each one reaches is noted: a mutant is shown to the tests that
reach it, the quickest first, up to the first that fails. `--reached` keeps what they reach in a
file: for the group "project", all of symgen/, they take a quarter of an hour.
"""

from __future__ import annotations

import argparse
import ast
import importlib
import json
import os
import random
import shutil
import signal
import sys
import tempfile
import threading
import traceback
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from itertools import accumulate
from pathlib import Path
from typing import Any

PROJECT = Path(__file__).resolve().parents[1]
#: A mutant may take so many seconds, and so many times what its tests compute: more is seen, too.
SECONDS, TIMES = 60.0, 20.0
#: The quickest tests that reach it, of so many seconds in all, are shown to a mutant.
SHOWN = 25.0
_PASSED, _UNREAD = "passed", "exit 4"
#: Folders of tests that show mutants of the whole project, and the longest of their files, s.
_READING = ("generated", "identities", "reference", "robustness", "unit", "workflow")
LONG = 35.0

_S, _E = "symgen/symbolic/", "symgen/estimation/"


def _importing(package: str) -> list[str]:
    """Return the tests of units and references that import something of a package."""
    paths = sorted(
        p for part in ("unit", "reference") for p in (PROJECT / "tests" / part).glob("*.py")
    )
    return [p.relative_to(PROJECT).as_posix() for p in paths if package in p.read_text("utf-8")]


def _of_a_file_up_to(seconds: float) -> list[str]:
    """Return the files of tests, without those of emitted C, that take so many seconds at most."""
    known = json.loads((PROJECT / "tests" / "durations.json").read_text("utf-8"))
    files = {name: taken for name, taken in known.items() if "::" not in name}
    del files["robustness/test_mutation.py"]
    return [f"tests/{name}" for name, taken in files.items()
            if name.split("/")[0] in _READING and taken <= seconds]  # fmt: skip


#: Group: what is changed, and the tests that look.
GROUPS: dict[str, tuple[list[str], list[str]]] = {
    "minimal": (
        [f"{_S}{n}.py" for n in
         ("base_parameters", "elimination", "independence", "regrouping", "relations")],
        [*(f"tests/unit/test_{n}.py" for n in
           ("base_parameters", "elimination_in_blocks", "elimination", "independence",
            "regrouping", "relations")),
         "tests/reference/test_base_parameters.py"],
    ),
    "estimation": (
        sorted(p.relative_to(PROJECT).as_posix()
               for folder in (_E, "symgen/faults") for p in (PROJECT / folder).glob("[a-z]*.py")),
        [*dict.fromkeys((*_importing("symgen.estimation"), *_importing("symgen.faults"))),
         *(f"tests/unit/test_{n}.py" for n in ("drive", "log", "mask")),
         *(f"tests/workflow/test_{n}.py" for n in
           ("channel_faults", "logs", "methods", "out_of_core", "static"))],
    ),
    "score": (
        ["symgen/estimation/predictive_score.py"], ["tests/unit/test_predictive_score.py"]
    ),
    "project": (
        sorted(p.relative_to(PROJECT).as_posix() for p in (PROJECT / "symgen").rglob("[a-z]*.py")),
        _of_a_file_up_to(LONG),
    ),
}  # fmt: skip
_OTHER: dict[type[ast.AST], type[ast.AST]] = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq, ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Is: ast.IsNot, ast.IsNot: ast.Is,
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult, ast.Mod: ast.FloorDiv, ast.Pow: ast.Mult, ast.MatMult: ast.Mult,
    ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip


@dataclass
class Mutant:
    """One changed place.

    Attributes:
        place: number among all of its group.
        file, line: where.
        text: the whole line.
        was, now: the changed expression.
        killed_by: the first test that failed; "" where all passed.
        seconds: that this test takes.
    """

    place: int
    file: str
    line: int
    text: str
    was: str
    now: str
    killed_by: str = ""
    seconds: float = 0.0


@dataclass
class Reached:
    """What tests reach when nothing is changed.

    Attributes:
        seconds: of every test.
        lines: file and line, with the tests that run it; "" for what is run before any test.
    """

    seconds: dict[str, float] = field(default_factory=dict)
    lines: dict[tuple[str, int], set[str]] = field(default_factory=lambda: defaultdict(set))

    def tests(self, file: str, first: int, last: int) -> list[str]:
        """Return the tests that run one of some lines, the quickest first, of SHOWN s in all.

        What runs on import counts for every test that runs anything of the file.
        """
        found = {t for k in range(first, last + 1) for t in self.lines.get((file, k), ())}
        if "" in found:
            found = {t for (name, _), tests in self.lines.items() if name == file for t in tests}
        ordered = sorted(found - {""}, key=lambda t: self.seconds.get(t, 0.0))
        ends = accumulate(self.seconds.get(t, 0.0) for t in ordered)
        return [t for k, (t, end) in enumerate(zip(ordered, ends, strict=True))
                if k == 0 or end <= SHOWN]  # fmt: skip


def changed(node: ast.AST) -> bool:
    """Change a node in place, where it is one that can be changed."""
    if isinstance(node, ast.Compare):
        node.ops[0] = _OTHER[type(node.ops[0])]()  # type: ignore[assignment]
    elif isinstance(node, (ast.BinOp, ast.BoolOp, ast.AugAssign)) and type(node.op) in _OTHER:
        node.op = _OTHER[type(node.op)]()  # type: ignore[assignment]
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        node.op = ast.UAdd()
    elif isinstance(node, ast.Constant) and type(node.value) in (int, float, bool):
        old = node.value
        node.value = not old if isinstance(old, bool) else old * 2 or 1
    elif isinstance(node, (ast.If, ast.IfExp, ast.While)):
        node.test = ast.UnaryOp(ast.Not(), node.test)
    else:
        return False
    return True


def nodes_of(tree: ast.Module) -> list[ast.AST]:
    """Return the nodes of code, without annotations."""
    out: list[ast.AST] = []
    waiting: list[ast.AST] = [tree]
    while waiting:
        node = waiting.pop()
        out.append(node)
        for name, value in ast.iter_fields(node):
            if name not in ("annotation", "returns", "decorator_list"):
                inner = value if isinstance(value, list) else [value]
                waiting += [x for x in inner if isinstance(x, ast.AST)]
    return out


def places(group: str) -> list[tuple[str, int]]:
    """Return every place of a group that can be changed: a file, and the number of a node in it."""
    out = []
    for file in GROUPS[group][0]:
        nodes = nodes_of(ast.parse((PROJECT / file).read_text("utf-8")))
        out += [(file, k) for k, node in enumerate(nodes) if changed(node)]
    return out


def mutant(place: int, file: str, k: int) -> tuple[Mutant, str]:
    """Return the mutant of a place, and the text of its file."""
    source = (PROJECT / file).read_text("utf-8")
    tree = ast.parse(source)
    node: Any = nodes_of(tree)[k]
    was = shown(node)
    changed(node)
    text = source.splitlines()[node.lineno - 1].strip()
    return Mutant(place, file, node.lineno, text, was, shown(node)), ast.unparse(tree)


def now_at(group: str, wanted: Sequence[dict[str, Any]]) -> list[list[int]]:
    """Return the places at which some mutants now stand: same file, text of the line, and change.

    Only places on such lines are changed and printed, which would take minutes for all of a group.
    """
    lines = {(m["file"], m["text"]) for m in wanted}
    read = {}
    for file in {m["file"] for m in wanted if (PROJECT / m["file"]).is_file()}:
        source = (PROJECT / file).read_text("utf-8")
        read[file] = source.splitlines(), nodes_of(ast.parse(source))
    found = defaultdict(list)
    for place, (file, k) in enumerate(places(group)):
        texts, nodes = read.get(file, ((), ()))
        if nodes and (file, texts[nodes[k].lineno - 1].strip()) in lines:
            found[key(vars(mutant(place, file, k)[0]))].append(place)
    return [found[key(m)] for m in wanted]


def key(mutant: dict[str, Any]) -> tuple[str, ...]:
    """What a mutant is, wherever its line now stands."""
    return mutant["file"], mutant["text"], mutant["was"], mutant["now"]


def shown(node: Any) -> str:
    """Return what is changed of a node, as text."""
    part = node.test if isinstance(node, (ast.If, ast.While)) else node
    return ast.unparse(ast.fix_missing_locations(part))


def _statement(file: str, line: int) -> tuple[int, int]:
    """Return the first and last line of the statement at a line, without the statements in it."""
    first, last = line, line
    for node in ast.walk(ast.parse((PROJECT / file).read_text("utf-8"))):
        if isinstance(node, ast.stmt) and node.lineno <= line <= (node.end_lineno or 0):
            body = getattr(node, "body", None)
            end = body[0].lineno - 1 if body else node.end_lineno
            if line <= max(end, node.lineno) and node.lineno <= first:
                first, last = node.lineno, max(end, node.lineno)
    return first, last


class _First:
    """Remembers the first test that fails."""

    def __init__(self) -> None:
        self.name = ""

    def pytest_runtest_logreport(self, report: Any) -> None:
        if report.failed and not self.name:
            self.name = report.nodeid


class _Recorder(_First):
    """Notes which lines of some files each test runs, and how long it takes."""

    def __init__(self, files: Sequence[Path]) -> None:
        super().__init__()
        self.files = {str(f): f for f in files}
        self.now, self.begun = "", 0.0
        self.found = Reached()
        threading.settrace(self.trace)
        sys.settrace(self.trace)

    def trace(self, frame: Any, *_: Any) -> Any:
        """Follow frames of the files alone."""
        return self.line if frame.f_code.co_filename in self.files else None

    def line(self, frame: Any, event: str, _: Any) -> Any:
        """Note a line."""
        if event == "line":
            self.found.lines[frame.f_code.co_filename, frame.f_lineno].add(self.now)
        return self.line

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        self.now, self.begun = nodeid, sum(os.times()[:4])

    def pytest_runtest_logfinish(self, nodeid: str) -> None:
        # Of computing, its children's too: a busy machine changes nothing.
        self.now, self.found.seconds[nodeid] = "", sum(os.times()[:4]) - self.begun


def _in_fork(run: Callable[[], str], seconds: float) -> str:
    """Return what a function returns in a fork of this process, "" where that ends silently."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        try:  # it must never come back into what the parent does
            os.setsid()
            with os.fdopen(writing, "w") as pipe:
                pipe.write(run())
        except BaseException:
            traceback.print_exc()
        finally:
            os._exit(0)
    os.close(writing)

    def late(*_: object) -> None:
        os.killpg(child, signal.SIGKILL)

    signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    with os.fdopen(reading) as pipe:
        said = pipe.read()
    signal.setitimer(signal.ITIMER_REAL, 0)
    _, status = os.waitpid(child, 0)
    return f"more than {seconds:.0f} s" if os.WIFSIGNALED(status) and not said else said


def _tested(copy: Path, tests: Sequence[str], plugin: _First, unchanged: bool = False) -> str:
    """Run tests in this process; return what failed first, or "passed"."""
    sink = os.open(os.devnull, os.O_WRONLY)
    os.dup2(sink, 1)
    if not os.environ.get("SYMGEN_SHOWN"):
        os.dup2(sink, 2)
    os.chdir(copy)
    sys.path[:0] = [str(copy), str(copy / "tests")]
    # Without any change all that is imported is compiled, once; a change is newer than that.
    sys.dont_write_bytecode = not unchanged
    import pytest

    options = ["-x", "-q", "-p", "no:cacheprovider", f"--basetemp={copy / 'temporary'}"]
    code = pytest.main([*options, *tests], plugins=[plugin])
    return plugin.name or (_PASSED if code == 0 else f"exit {int(code)}")


class Copy:
    """The code in a folder of its own, in which it is changed and tested."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        for name in ("symgen", "templates", "tests", "generated"):
            ignored = shutil.ignore_patterns("__pycache__", "c" if name == "tests" else "")
            shutil.copytree(PROJECT / name, folder / name, ignore=ignored)
        shutil.copy(PROJECT / "pyproject.toml", folder)

    def reached(
        self, files: Sequence[str], tests: Sequence[str], kept: Path | None = None
    ) -> Reached:
        """Return what tests reach of files, from the file where that is kept.

        Raises:
            AssertionError: the tests fail without any change.
        """

        def run() -> str:
            plugin = _Recorder([self.folder / f for f in files])
            failed = _tested(self.folder, tests, plugin, unchanged=True)
            found = plugin.found
            lines = [[Path(f).relative_to(self.folder).as_posix(), k, sorted(tests)]
                     for (f, k), tests in found.lines.items()]  # fmt: skip
            return json.dumps([failed, found.seconds, lines])

        known = kept is not None and kept.exists()
        said = kept.read_text("utf-8") if kept and known else _in_fork(run, 3600.0)
        failed, seconds, lines = json.loads(said)
        assert failed == _PASSED, f"without any change: {failed}"
        if kept and not known:
            kept.write_text(said, "utf-8")
        out = Reached(seconds)
        for file, k, tests_ in lines:
            out.lines[file, k] |= set(tests_)
        return out

    def failing(self, found: Mutant, text: str, tests: Sequence[str], seconds: float) -> str:
        """Return the first of the tests that fails with a mutant, "" where none does."""
        if not tests:
            return ""
        file = self.folder / found.file
        original = file.read_text("utf-8")
        file.write_text(text, "utf-8")
        try:
            said = _in_fork(lambda: _tested(self.folder, tests, _First()), seconds)
        finally:
            file.write_text(original, "utf-8")
        if said == _UNREAD:  # for the mutant, or for names that pytest does not read anyway
            read = [t for t in tests if self.reads(t)]
            if len(read) < len(tests):
                return self.failing(found, text, read, seconds)
        return "" if said == _PASSED else said or "the process died"

    def reads(self, test: str) -> bool:
        """Whether pytest finds a test by its name, without any change."""
        options = ["--collect-only", test]
        return _in_fork(lambda: _tested(self.folder, options, _First()), SECONDS) == _PASSED


def tried(group: str, chosen: Sequence[int], kept: Path | None = None) -> Iterator[Mutant]:
    """Yield the mutants of some places, after the tests that reach them have run.

    Args:
        group: of GROUPS.
        chosen: the places.
        kept: file that holds what the tests reach; it is written where it is absent.

    Raises:
        AssertionError: the tests fail without any change.
    """
    files, tests = GROUPS[group]
    every = places(group)
    with tempfile.TemporaryDirectory() as folder:
        copy = Copy(Path(folder).resolve())
        reached = copy.reached(files, tests, kept)
        for place in chosen:
            found, text = mutant(place, *every[place])
            known = reached.tests(found.file, *_statement(found.file, found.line))
            seconds = SECONDS + TIMES * sum(reached.seconds[t] for t in known)
            found.killed_by = copy.failing(found, text, known, seconds)
            found.seconds = round(reached.seconds.get(found.killed_by, 0.0), 2)
            yield found


def again(killed: Sequence[tuple[str, str, str]]) -> Iterator[Mutant]:
    """Yield mutants, each a group, a place and the one test that it is shown to.

    Raises:
        AssertionError: one of the tests fails without any change.
    """
    every = {group: places(group) for group in {group for group, _, _ in killed}}
    with tempfile.TemporaryDirectory() as folder:
        copy = Copy(Path(folder).resolve())
        tests = sorted({test for _, _, test in killed})
        failed = _in_fork(lambda: _tested(copy.folder, tests, _First(), unchanged=True), SECONDS)
        assert failed == _PASSED, f"without any change: {failed}"
        for group, place, test in killed:
            found, text = mutant(int(place), *every[group][int(place)])
            found.killed_by = copy.failing(found, text, [test], SECONDS)
            yield found


def main() -> None:
    """Try the mutants that the command line asks for."""
    parser = argparse.ArgumentParser()
    parser.add_argument("group", choices=GROUPS, nargs="?")
    parser.add_argument("count", type=int, nargs="?", default=0)
    parser.add_argument("--seed", default="1")
    parser.add_argument("--at", type=int, nargs="*", default=())
    parser.add_argument("--reached", type=Path)
    parser.add_argument("--again", nargs=3, action="append", metavar=("GROUP", "PLACE", "TEST"))
    asked = parser.parse_args()
    sys.dont_write_bytecode = True
    # What every fork needs and takes seconds to load.
    for library in ("pytest", "sympy", "casadi", "pyarrow.parquet", "pydantic",
                    "click", "rich.console", "jinja2", "cffi", "scipy.stats", "scipy.signal",
                    "statsmodels.api"):  # fmt: skip
        importlib.import_module(library)

    if asked.again:
        found = again(asked.again)
    else:
        draw = random.Random(f"{asked.group} {asked.seed}")
        # In any order, so that those that were tried when somebody stops it are a sample, too.
        chosen = asked.at or draw.sample(range(len(places(asked.group))), asked.count)
        found = tried(asked.group, chosen, asked.reached)
    for m in found:
        print(json.dumps(asdict(m)), flush=True)


if __name__ == "__main__":
    main()

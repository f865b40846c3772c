"""Faults put into the code one at a time, and whether its quick tests see them.

    python tests/mutants.py GROUP COUNT [PLACE...]

Prints a line for each mutant of the group, COUNT of them drawn with a fixed seed, or those at some
PLACES among all: killed, and by which test, or survived. The code is copied into a folder of its
own. Libraries are imported once, and every mutant runs in a fork of that process.
"""

from __future__ import annotations

import ast
import json
import os
import random
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

PROJECT = Path(__file__).resolve().parents[1]
SECONDS = 240.0  # more is a fault that is seen
_PASSED = "passed"

_S, _E = "symgen/symbolic/", "symgen/estimation/"
#: Group: what is changed, and the tests that look.
GROUPS: dict[str, tuple[list[str], list[str]]] = {
    "minimal": (
        [f"{_S}{name}.py" for name in ("elimination", "independence", "regrouping", "relations")],
        ["tests/unit/test_elimination_in_blocks.py", "tests/reference/test_base_parameters.py"],
    ),
    "estimation": (
        [f"{_E}{n}.py" for n in ("decimation", "estimators", "instrumental", "regression")],
        ["tests/unit/test_decimation.py", "tests/unit/test_whiteness.py",
         "tests/reference/test_estimators.py"],
    ),
    "select": (["symgen/diagnosis/select.py"], ["tests/unit/test_select.py"]),
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
    """

    place: int
    file: str
    line: int
    text: str
    was: str
    now: str
    killed_by: str = ""


def _changed(node: ast.AST) -> bool:
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


def _nodes(tree: ast.Module) -> list[ast.AST]:
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
        nodes = _nodes(ast.parse((PROJECT / file).read_text("utf-8")))
        out += [(file, k) for k, node in enumerate(nodes) if _changed(node)]
    return out


def mutant(place: int, file: str, k: int) -> tuple[Mutant, str]:
    """Return the mutant of a place, and the text of its file."""
    source = (PROJECT / file).read_text("utf-8")
    tree = ast.parse(source)
    node: Any = _nodes(tree)[k]
    text = source.splitlines()[node.lineno - 1].strip()

    def shown() -> str:
        part = node.test if isinstance(node, (ast.If, ast.While)) else node
        return ast.unparse(ast.fix_missing_locations(part))

    was = shown()
    _changed(node)
    return Mutant(place, file, node.lineno, text, was, shown()), ast.unparse(tree)


class _First:
    """Remembers the first test that fails."""

    def __init__(self) -> None:
        self.name = ""

    def pytest_runtest_logreport(self, report: Any) -> None:
        if report.failed and not self.name:
            self.name = report.nodeid


def _run(copy: Path, tests: Sequence[str]) -> str:
    """Run tests in a fork; return what failed first, "" where nothing did."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        try:  # it must never come back into what the parent does
            os.write(writing, (_tested(copy, tests) or _PASSED).encode())
        except BaseException:
            traceback.print_exc()
        finally:
            os._exit(0)
    os.close(writing)
    until = time.monotonic() + SECONDS
    with os.fdopen(reading, "rb") as pipe:
        while os.waitpid(child, os.WNOHANG) == (0, 0):
            if time.monotonic() > until:
                os.killpg(child, signal.SIGKILL)
                os.waitpid(child, 0)
                return f"more than {SECONDS:g} s"
            time.sleep(0.02)
        said = pipe.read().decode()
    return "" if said == _PASSED else said or "the process died"


def _tested(copy: Path, tests: Sequence[str]) -> str:
    """Run tests in this process; return what failed first, "" where nothing did."""
    os.setsid()
    sink = os.open(os.devnull, os.O_WRONLY)
    os.dup2(sink, 1)
    if not os.environ.get("SYMGEN_SHOWN"):
        os.dup2(sink, 2)
    os.chdir(copy)
    sys.path[:0] = [str(copy), str(copy / "tests")]
    sys.dont_write_bytecode = True
    import pytest

    first = _First()
    options = ["-x", "-q", "-p", "no:cacheprovider", f"--basetemp={copy / 'temporary'}"]
    code = pytest.main([*options, *tests], plugins=[first])
    return first.name or ("" if code == 0 else f"exit {int(code)}")


def tried(group: str, count: int, wanted: Sequence[int] = ()) -> Iterator[Mutant]:
    """Yield mutants, `count` at random or those at some places, after their tests have run.

    Raises:
        AssertionError: the tests fail without any change.
    """
    tests = GROUPS[group][1]
    every = places(group)
    chosen = wanted or sorted(random.Random(group).sample(range(len(every)), count))
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder)
        for name in ("symgen", "templates", "tests", "generated"):
            ignored = shutil.ignore_patterns("__pycache__", "c" if name == "tests" else "")
            shutil.copytree(PROJECT / name, copy / name, ignore=ignored)
        shutil.copy(PROJECT / "pyproject.toml", copy)
        failed = _run(copy, tests)
        assert not failed, f"without any change: {failed}"
        for place in chosen:
            found, text = mutant(place, *every[place])
            original = (copy / found.file).read_text("utf-8")
            (copy / found.file).write_text(text, "utf-8")
            found.killed_by = _run(copy, tests)
            (copy / found.file).write_text(original, "utf-8")
            yield found


def main() -> None:
    """Try the mutants that the command line asks for."""
    group, count, *wanted = sys.argv[1:]
    sys.dont_write_bytecode = True
    import casadi  # noqa: F401  (what every fork needs, and takes seconds to load)
    import pyarrow  # noqa: F401
    import scipy.stats  # noqa: F401
    import sympy  # noqa: F401

    for found in tried(group, int(count), [int(p) for p in wanted]):
        print(json.dumps(asdict(found)), flush=True)


if __name__ == "__main__":
    main()

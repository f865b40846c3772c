"""Check of generated packages: generate again, compare, evaluate against 50-digit values."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np

from symgen.codegen.model import Model, derive
from symgen.codegen.package import SCHEMA, SourceTree, generate
from symgen.codegen.values import Values
from symgen.codegen.verification import TOLERANCE
from symgen.data.raw import FloatArray
from symgen.errors import PackageError, ParameterError
from symgen.robot.toml_io import read_robot
from symgen.runtime.build import find_compiler
from symgen.runtime.evaluator import Evaluator, load
from symgen.runtime.stack import worst_case_stack
from symgen.schemas import from_json, read_json

_BUILT = (".o", ".obj", ".a", ".so", ".out")  # what a compiler leaves beside the sources


@dataclass(frozen=True)
class Checked:
    """Result of checking a package.

    Attributes:
        folder: the package.
        differences: one line for each file that differs from a newly generated one.
        errors: measured largest relative error of (backend, kernel) against 50 digits.
        rank: the exact rank, proved again.
        stacks: worst-case stack of each function as this compiler builds it, in bytes, without
            libm; None if it was not measured.
    """

    folder: Path
    differences: tuple[str, ...]
    errors: tuple[tuple[str, str, float], ...]
    rank: int
    stacks: Mapping[str, int] | None


def check(
    folder: str | Path, *, meter: Callable[[float], None] = lambda _: None
) -> tuple[Checked, ...]:
    """Check a package, or every package in a folder.

    Args:
        folder: folder of a package, or of several packages.
        meter: called with the part that is done, from 0 to 1.

    Raises:
        PackageError: there is no package, or a manifest cannot be read.
    """
    path = Path(folder)
    if (path / "manifest.json").is_file():
        return (_check_one(path),)
    found = sorted(p.parent for p in path.glob("*/manifest.json"))
    if not found:
        raise PackageError(
            f"{path}: no generated package (manifest.json) is here or one level down"
        )
    out = []
    for k, package in enumerate(found, 1):
        out.append(_check_one(package))
        meter(k / len(found))
    return tuple(out)


@dataclass(frozen=True)
class Options:
    """The options with which a package was generated."""

    target: str
    dtype: str
    kernels: tuple[str, ...]
    tex: bool = False
    prefix: str | None = None
    values: Values | None = None
    loops: str = "auto"


def read_options(folder: Path) -> Options:
    """Return the options of a package, from its manifest.

    Raises:
        PackageError: the manifest has no options.
    """
    path = folder / "manifest.json"
    try:
        options = read_json(path, SCHEMA).get("options")
        return from_json(Options, options if isinstance(options, dict) else {}, path)
    except ParameterError as error:
        raise PackageError(str(error)) from error


def _check_one(folder: Path) -> Checked:
    options, robot = read_options(folder), read_robot(folder / "robot.toml")
    try:
        model = derive(robot, options.kernels)
        tree = generate(model, **vars(options))
    except (PackageError, ParameterError) as error:
        raise PackageError(f"{folder / 'manifest.json'}: {error}") from error
    # Measured on the tree written now, at its points: the folder's own are compared with these.
    errors = _errors(model, tree)
    tolerance = TOLERANCE["double"]  # this machine evaluates in double, whatever the package does
    differences = _differences(folder, tree) + tuple(
        f"{kernel}: error {error:.1e} of {backend} exceeds {tolerance:g}"
        for backend, kernel, error in errors
        if not error <= tolerance
    )
    return Checked(folder, differences, errors, model.base.proof.rank, _stacks(tree))


def _stacks(tree: SourceTree) -> dict[str, int] | None:
    compiler = find_compiler()
    if compiler is None or not tree.library:
        return None
    worst = worst_case_stack(tree.library, compiler)
    prefix = f"{tree.name}_"
    return worst and {
        name.removeprefix(prefix): size
        for name, size in sorted(worst.items())
        if name.startswith(prefix)
    }


def _differences(folder: Path, tree: SourceTree) -> tuple[str, ...]:
    out = []
    # The package's own folders are looked into; what else stands there is not ours to judge.
    folders = {folder, *((folder / name).parent for name in tree.files)}
    present = {
        path.relative_to(folder).as_posix()
        for place in folders
        if place.is_dir()
        for path in place.iterdir()
        if path.is_file() and not path.name.startswith(".")
    }
    for name, content in tree.files.items():
        if name not in present:
            out.append(f"{name}: missing")
            continue
        found = (folder / name).read_bytes()
        if found == content:
            continue
        out.append(f"{name}: line {_first_difference(found, content)} differs")
    strange = sorted(n for n in present - set(tree.files) if not n.endswith(_BUILT))
    out += [f"{name}: not part of the package" for name in strange]
    return tuple(out)


def _first_difference(a: bytes, b: bytes) -> int:
    pairs = enumerate(zip_longest(a.splitlines(), b.splitlines()), 1)
    return next((number for number, (left, right) in pairs if left != right), 1)


def _casadi_error(text: str, verification: Mapping[str, Any]) -> Iterator[tuple[str, str, float]]:
    """Yield the error of every function of NAME_casadi.py, whose text symgen has just written.

    The file of the package is compared with this text, and never run.
    """
    functions: dict[str, Any] = {"__name__": "casadi_source"}
    exec(compile(text, "casadi_source", "exec"), functions)
    for name, points in verification["points"].items():
        function = functions[name]()
        answers = (function.call(list(point.values())) for point in points)
        found = [np.concatenate([np.array(y).ravel() for y in answer]) for answer in answers]
        yield "casadi", name, _worst(found, verification["expected"][name])


def _errors(model: Model, tree: SourceTree) -> tuple[tuple[str, str, float], ...]:
    """Measure the kernels of this machine against the manifest's 50-digit values."""
    verification = json.loads(tree.files["manifest.json"])["verification"]
    source = tree.files.get(f"{tree.name}_casadi.py")
    out = list(_casadi_error(source.decode(), verification)) if source is not None else []
    if find_compiler() is not None:
        evaluator = load(model, backend="c")
        out += [
            ("c", name, _worst(_answers(evaluator, name, points), verification["expected"][name]))
            for name, points in verification["points"].items()
        ]
    return tuple(out)


def _answers(
    evaluator: Evaluator, name: str, points: list[dict[str, list[float]]]
) -> list[FloatArray]:
    results = (evaluator[name](**point) for point in points)
    return [
        np.concatenate([np.ravel(a) for a in (r if isinstance(r, tuple) else (r,))])
        for r in results
    ]


def _worst(found: list[FloatArray], expected: list[list[str]]) -> float:
    """Return the largest error at any point, relative to the largest entry there."""
    exact = np.array(expected, dtype=np.float64)
    scale = np.abs(exact).max(initial=0)
    return float(np.abs(np.array(found) - exact).max(initial=0) / (scale or 1.0))

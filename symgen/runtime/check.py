"""Check of generated packages: generate again, compare, evaluate against 50-digit values."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np

from symgen.codegen.casadi_model import casadi_function
from symgen.codegen.model import Model, derive
from symgen.codegen.package import SCHEMA, SourceTree, generate
from symgen.codegen.values import Values
from symgen.codegen.verification import TOLERANCE
from symgen.errors import PackageError, ParameterError
from symgen.robot.toml_io import read_robot
from symgen.runtime import confined
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
    # Measured at the points of the tree written now: the folder's own are compared with these.
    fresh = json.loads(tree.files["manifest.json"])
    errors = _errors(model, fresh)
    tolerance = TOLERANCE["double"]  # this machine evaluates in double, whatever the package does
    differences = _differences(folder, tree, model) + tuple(
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


def _differences(folder: Path, tree: SourceTree, model: Model) -> tuple[str, ...]:
    out = []
    points = json.loads(tree.files["manifest.json"])["verification"]["points"]
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
        if name.endswith(".casadi"):
            kernel = model.kernel(name.removeprefix(f"{tree.name}_").removesuffix(".casadi"))
            assert kernel is not None
            if not confined.available():
                out.append(f"{name}: other bytes, and only Linux can look at them without risk")
            elif not _same_value(found, casadi_function(model, kernel), points[kernel.name]):
                out.append(f"{name}: computes something else")
        else:
            out.append(f"{name}: line {_first_difference(found, content)} differs")
    strange = sorted(n for n in present - set(tree.files) if not n.endswith(_BUILT))
    out += [f"{name}: not part of the package" for name in strange]
    return tuple(out)


def _first_difference(a: bytes, b: bytes) -> int:
    pairs = enumerate(zip_longest(a.splitlines(), b.splitlines()), 1)
    return next((number for number, (left, right) in pairs if left != right), 1)


def _same_value(
    found: bytes, function: Any, points: Sequence[Mapping[str, Sequence[float]]]
) -> bool:
    """Whether a .casadi file of unknown origin computes the same values as a new one.

    Another version of CasADi writes other bytes for the same function. The comparison uses the
    points of the kernel's verification. The file is never loaded in this process.
    """
    inputs = [list(point.values()) for point in points]
    answer = confined.values(found, inputs)
    if answer is None or answer[0] != confined.sizes(function) or len(answer[1]) != len(inputs):
        return False
    for values, row in zip(inputs, answer[1], strict=True):
        y = np.concatenate([np.array(v).ravel("F") for v in function.call(values)])
        scale = max(1.0, float(np.abs(y).max(initial=0)))
        if len(row) != len(y) or not np.allclose(row, y, rtol=0, atol=1e-13 * scale):
            return False
    return True


def _errors(model: Model, manifest: Mapping[str, Any]) -> tuple[tuple[str, str, float], ...]:
    """Measure the kernels of this machine against the manifest's 50-digit values."""
    evaluators = [load(model, backend="casadi")]
    if find_compiler() is not None:
        evaluators.append(load(model, backend="c"))
    verification = manifest["verification"]
    return tuple(
        (evaluator.backend, name, _error(evaluator, name, points, verification["expected"][name]))
        for evaluator in evaluators
        for name, points in verification["points"].items()
    )


def _error(
    evaluator: Evaluator, name: str, points: list[dict[str, list[float]]], expected: list[list[str]]
) -> float:
    """Return the largest error at any point, relative to the largest entry there."""
    results = (evaluator[name](**point) for point in points)
    found = [
        np.concatenate([np.ravel(a) for a in (r if isinstance(r, tuple) else (r,))])
        for r in results
    ]
    exact = np.array(expected, dtype=np.float64)
    scale = np.abs(exact).max(initial=0)
    return float(np.abs(np.array(found) - exact).max(initial=0) / (scale or 1.0))

"""Check values of every kernel: seeded points, and outputs computed with 50 digits."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from decimal import Context, Decimal, localcontext
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen import names
from symgen.codegen.kernel import LINK, Kernel
from symgen.codegen.model import Model, regrouping
from symgen.codegen.panels import LARGEST
from symgen.robot.body import Body
from symgen.robot.types import Robot
from symgen.symbolic.energy import stacked
from symgen.symbolic.tape import Numbers

DIGITS = 50
SEED = 1988
POINTS = 4  # for a kernel whose outputs have at most LARGEST entries
_WRITTEN = 20  # digits of the values in the manifest
#: Largest accepted error of a compiled kernel, relative to its largest entry at all points.
TOLERANCE = {"double": 1e-13, "float": 2e-5}


def verification(model: Model, kernels: Sequence[Kernel]) -> dict[str, Any]:
    """Return the points (input -> values) and the expected outputs, by kernel."""
    import mpmath

    draw = random.Random(SEED)
    X = [round(x, 6) for x in physical_parameters(model, draw)]
    at: dict[str, Any] = {}
    written: dict[str, Any] = {}
    for kernel in kernels:
        points = [
            {
                name: X[: len(symbols)]
                if name == "X"
                else [kernel.first + point % len(symbols)]
                if name == LINK
                else [round(draw.uniform(-2.0, 2.0), 6) for _ in symbols]
                for name, symbols in kernel.tape.inputs
            }
            for point in range(_points(kernel))
        ]
        expected = evaluate(kernel, model, points, DIGITS)
        at[kernel.name] = points
        # Values below these digits are zero. The check is relative to the largest value.
        rows = [[v if abs(v) >= 10.0**-DIGITS else 0 for v in row] for row in expected]
        exact = [[mpmath.mpf(str(v), dps=DIGITS) for v in row] for row in rows]
        written[kernel.name] = [[str(mpmath.nstr(v, _WRITTEN)) for v in row] for row in exact]
    return {"points": at, "expected": written}


def _points(kernel: Kernel) -> int:
    """Return the number of points, which is smaller for kernels with many outputs."""
    return max(1, min(POINTS, POINTS * LARGEST // max(1, kernel.size)))


def checked_kernel(kernel: Kernel, verified: Mapping[str, Any]) -> dict[str, Any]:
    """Return the data of a kernel for the template of NAME_check.c.

    Args:
        kernel: kernel of the package.
        verified: points and expected values, from `verification`.
    """
    places = verified["points"][kernel.name]
    points = {}
    for a in kernel.inputs:
        found = [point[a.name] for point in places]
        same = not a.written and all(values == found[0] for values in found)
        points[a.name] = found[:1] if same else found
    rows = verified["expected"][kernel.name]
    expected = [_listed([float(v) for v in row]) for row in rows]
    return {"kernel": kernel, "points": points, "expected": expected}


def _listed(values: Sequence[float]) -> str:
    """Return the entries of an array in C and C++, which fill the rest with zeros."""
    texts = [repr(v) if v else "0" for v in values]
    while len(texts) > 1 and texts[-1] == "0":
        texts.pop()
    return ", ".join(texts)


def physical_parameters(model: Model, draw: random.Random, error: float = 0.0) -> list[float]:
    """Return the base parameters of a physically possible robot: solid links, positive friction.

    Args:
        model: a model of `derive`.
        draw: random numbers.
        error: relative error of all parameters of a joint and its link, positive for odd joint
            numbers and negative for even ones. The robot with errors is still physically possible.
    """
    standard: dict[str, float] = {}
    for parameter in model.base.standard:
        if parameter.prefix not in names.LINK:
            standard[parameter.name] = draw.uniform(0.1, 1.0)
        elif parameter.prefix == names.INERTIA[0]:
            suffix = parameter.name.removeprefix(parameter.prefix)
            keys = (f"{prefix}{suffix}" for prefix in names.LINK)
            body = _solid(parameter.joint, draw)
            standard |= dict(zip(keys, body.standard, strict=True))
    values = [
        standard[p.name] * (1 + error if p.joint % 2 else 1 - error) for p in model.base.standard
    ]
    X: list[float] = (regrouping(model) @ values).tolist()
    return X


def _solid(number: int, draw: random.Random) -> Body:
    """Return a point-symmetric body whose centre is not at the origin."""
    mass = draw.uniform(1.0, 3.0)
    centre = np.array([draw.uniform(-0.2, 0.2) for _ in range(3)])
    return Body(number, mass, centre, draw.uniform(0.05, 0.2) * np.eye(3))


def evaluate(
    kernel: Kernel, model: Model, points: Sequence[Mapping[str, Sequence[float]]], digits: int
) -> NDArray[Any]:
    """Evaluate a kernel at some points with many digits.

    Returns:
        Decimal numbers, (points, size): the entries of the outputs, without guards.
    """
    inputs = {}
    for name, symbols in kernel.tape.inputs:
        links = range(kernel.first, kernel.first + len(symbols))
        rows = [
            [int(link == point[name][0]) for link in links] if name == LINK else point[name]
            for point in points
        ]
        inputs[name] = list(np.array([[Decimal(repr(x)) for x in row] for row in rows]).T)
    with localcontext(Context(prec=digits + 10)):
        values = kernel.tape.run(_arithmetic(model.robot, digits), inputs)
    return stacked(values[: kernel.size], len(points))


@lru_cache(maxsize=4)
def _arithmetic(robot: Robot, digits: int) -> Numbers:
    """Return arithmetic of arrays with many digits. It caches the constants of the robot."""
    import mpmath

    context = mpmath.mp.clone()
    context.dps = digits + 10

    def on_arrays(name: str) -> Any:
        function = getattr(context, name)
        return np.frompyfunc(lambda x: Decimal(str(function(x))), 1, 1)

    functions = {f: on_arrays(f) for f in ("sin", "cos", "tanh", "exp", "log", "sign")}
    functions["abs"] = abs
    return Numbers(robot.values(), functions, lambda e: Decimal(str(e)), digits + 10)

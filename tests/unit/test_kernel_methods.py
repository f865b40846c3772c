"""The methods of an evaluator are its kernels: names, arguments, results, and what is missing."""

from __future__ import annotations

import inspect
import re

import numpy as np
import pytest

import symgen
from symgen.codegen.recipes import STANDARD
from symgen.runtime.evaluator import Evaluator

ROBOTS = {
    "fixed": '[robot]\nname = "m"\n[[joint]]\nfriction = ["coulomb"]\n[[joint]]\nd = 0.5\n',
    "sprung": '[robot]\nname = "m"\n[[joint]]\n[[joint]]\nd = 0.5\n'
    '[[effect]]\nname = "gravity_spring"\njoints = [2]\n',
    "input": '[robot]\nname = "free"\ngravity = "input"\n[[joint]]\n[[joint]]\nalpha = 1.0\n',
}


@pytest.fixture(scope="module", params=ROBOTS)
def evaluator(request) -> symgen.Evaluator:
    robot = symgen.parse_robot(ROBOTS[request.param])
    every = tuple(k.name for k in symgen.derive(robot, "all").kernels)
    return symgen.load(symgen.derive(robot, (*every, *STANDARD)), backend="casadi")


def test_every_kernel_is_a_method_that_is_documented_with_its_arguments(evaluator) -> None:
    draw = np.random.default_rng(3)
    source = inspect.getsource(Evaluator)
    for kernel in evaluator.model.kernels:
        name, inputs = kernel.name, [n for n, _ in kernel.tape.inputs]
        if name != "friction_power":
            (said,) = re.findall(rf'    {name}: _(Arrays?)\n    """Of \(([\w, ]*)\): ', source)
            assert said[1].removesuffix(", g").split(", ") == [n for n in inputs if n != "g"]
            assert (said[0] == "Arrays") == (len(kernel.outputs) > 1)
        values = {n: draw.normal(size=len(symbols)) for n, symbols in kernel.tape.inputs}
        values |= {"link": 2} if "link" in values else {}
        values |= {"X": _physical(evaluator)} if "X" in values else {}
        found = getattr(evaluator, name)(*values.values())
        first, *last = values
        expected = evaluator[name](values[first], **{n: values[n] for n in last})
        several = len(kernel.outputs) > 1
        for a, b in zip(*(x if several else (x,) for x in (found, expected)), strict=True):
            np.testing.assert_array_equal(a, b)


def _physical(evaluator: symgen.Evaluator) -> np.ndarray:
    """X of two bodies, so that M is positive definite."""
    standard = {"ZZ": 2.0, "XX": 2.0, "YY": 2.0, "M": 1.0, "IA": 0.1}
    given = [standard.get(p.name[:-1], 0.0) for p in evaluator.model.base.standard]
    return np.asarray(evaluator.base_parameters(given))


def test_a_kernel_that_is_not_there_is_named() -> None:
    small = symgen.load("planar2r", backend="casadi")
    assert small.energy_regressor([0.1, 0.2], [1.0, -1.0]).shape == (4,)
    assert small.friction_power([[0.1, 0.2]], [[1.0, -1.0]]).shape == (1, 0)
    with pytest.raises(symgen.ParameterError, match=r"'mass_matrix' is not in this model.*energy"):
        small.mass_matrix([0.1, 0.2], [1.0] * 4)

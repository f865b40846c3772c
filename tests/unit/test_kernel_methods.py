"""The methods of an evaluator are its kernels: names, arguments, results, and what is missing."""

from __future__ import annotations

import forms
import numpy as np
import pytest

import symgen
from symgen.codegen.definition import GRAVITY
from symgen.codegen.kernels import KERNELS

ROBOTS = {
    "fixed": '[robot]\nname = "m"\n[[joint]]\nfriction = ["coulomb"]\n[[joint]]\nd = 0.5\n',
    "sprung": '[robot]\nname = "m"\n[[joint]]\n[[joint]]\nd = 0.5\n'
    '[[effect]]\nname = "gravity_spring"\njoints = [2]\n',
    "floating": '[robot]\nname = "m"\nbase = "floating"\n[[joint]]\n[[joint]]\nd = 0.5\n',
    "input": '[robot]\nname = "free"\ngravity = "input"\n[[joint]]\n[[joint]]\nalpha = 1.0\n',
}


SIZES = {"n": 2, "m": 2, "links": 2}


@pytest.fixture(scope="module", params=ROBOTS)
def evaluator(request) -> symgen.Evaluator:
    robot = symgen.parse_robot(ROBOTS[request.param])
    return symgen.load(symgen.derive(robot, tuple(KERNELS)), backend="casadi")


@pytest.mark.parametrize("name", KERNELS)
def test_a_kernel_has_the_arrays_of_its_entry(evaluator, name: str) -> None:
    kernel, definition = evaluator.model.kernel(name), KERNELS[name]
    if kernel is None:
        assert definition.exists is not None or evaluator.model.robot.base not in definition.bases
        return
    floating = evaluator.model.robot.floating
    definition = definition.floating if floating else definition
    base = evaluator.model.base
    standard = len(base.standard)
    sizes = SIZES | ({"m": 8} if floating else {})
    sizes |= {"p": len(base.parameters), "p_inertial": base.inertial, "s": standard}
    inputs = [
        a for a in definition.inputs if a.name != GRAVITY or evaluator.model.robot.gravity_input
    ]
    assert [a.name for a in kernel.inputs] == [a.name for a in inputs]
    for a, argument in zip(inputs, kernel.inputs, strict=True):
        shape = [size if isinstance(size, int) else sizes[size.symbol] for size in a.shape]
        assert argument.plain or [argument.size] == shape
    values = {a.name: np.full(a.size, 0.3) for a in kernel.inputs}
    values |= {"link": 2} if "link" in values else {}
    values |= {"mass": 0.1} if "mass" in values else {}
    values |= {"X": _physical(evaluator)} if "X" in values else {}
    returned = getattr(evaluator, name)(*values.values())
    first, *last = values
    expected = evaluator[name](values[first], **{n: values[n] for n in last})
    several = len(definition.outputs) > 1
    returned, expected = (x if several else (x,) for x in (returned, expected))
    for array, output, again in zip(definition.outputs, returned, expected, strict=True):
        assert output.ndim == len(array.shape)
        np.testing.assert_array_equal(output, again)


def test_the_stub_is_that_of_the_list() -> None:
    assert forms.STUB.read_text("utf-8") == forms.stub()


def test_help_describes_a_method() -> None:
    assert symgen.Evaluator.mass_matrix.__doc__.startswith("Mass matrix M(q).")


def _physical(evaluator: symgen.Evaluator) -> np.ndarray:
    """X of two bodies, so that M is positive definite."""
    standard = {"ZZ": 2.0, "XX": 2.0, "YY": 2.0, "M": 1.0, "IA": 0.1}
    standard = {f"{name}{k}": value for name, value in standard.items() for k in (0, 1, 2)}
    given = [standard.get(p.name, 0.0) for p in evaluator.model.base.standard]
    return np.asarray(evaluator.base_parameters(given))


def test_a_kernel_that_is_not_there_is_named() -> None:
    small = symgen.load("planar2r", backend="casadi")
    assert small.energy_regressor([0.1, 0.2], [1.0, -1.0]).shape == (4,)
    assert small.friction_power([[0.1, 0.2]], [[1.0, -1.0]]).shape == (1, 0)
    with pytest.raises(symgen.ParameterError, match=r"'mass_matrix' is not in this model.*energy"):
        small.mass_matrix([0.1, 0.2], [1.0] * 4)

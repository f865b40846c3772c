"""The written order of steps: nothing is used before it is made, and fewer values wait."""

from __future__ import annotations

import pytest
import sympy as sp

import symgen
from symgen.codegen.kernels import Kernel
from symgen.codegen.schedule import Steps, scheduled

KERNELS = ("energy_regressor", "torque_regressor", "inverse_dynamics", "mass_matrix")


def kernels(robot: str) -> tuple[Kernel, ...]:
    return symgen.derive(symgen.read_robot(robot), KERNELS).kernels


def waiting(steps: Steps) -> int:
    """The sum, over the steps, of how many values are made and will still be used."""
    last: dict[sp.Symbol, int] = {}
    for i, (_, expr) in enumerate(steps):
        last |= dict.fromkeys(expr.free_symbols, i)
    return sum(last[s] - i for i, (s, _) in enumerate(steps) if s in last)


@pytest.mark.parametrize("robot", ["planar2r", "tx40", "panda", "wam7"])
def test_the_same_steps_each_after_what_it_needs(robot):
    for kernel in kernels(robot):
        made = {s for _, group in kernel.tape.inputs for s in group}
        made |= {s for s, _ in kernel.tape.constants}
        order = scheduled(kernel.tape.steps)
        assert sorted(map(str, order)) == sorted(map(str, kernel.tape.steps))
        for symbol, expr in order:
            assert expr.free_symbols <= made
            made.add(symbol)


@pytest.mark.parametrize("robot", ["tx40", "panda"])
def test_fewer_values_wait_than_in_the_order_of_the_derivation(robot):
    for kernel in kernels(robot):
        assert waiting(scheduled(kernel.tape.steps)) < waiting(kernel.tape.steps)


def test_steps_that_nothing_joins_keep_their_order():
    x = sp.Symbol("x", real=True)
    steps = tuple((sp.Symbol(f"s{i}", real=True), i * x) for i in range(2, 9))
    assert scheduled(steps) == steps
    assert scheduled(()) == ()

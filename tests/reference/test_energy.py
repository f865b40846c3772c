"""The energy columns against 50-digit transforms and Pinocchio; operation counts against peers."""

from __future__ import annotations

import numpy as np
import pytest
from oracles.exact import exact_energy_regressor
from oracles.transforms import Arm, column_names, energy_regressor
from support import sampled

import symgen

PAPER_COUNTS = {  # mul, add: measured figures of hand-tuned recursions
    "tx40": (117, 45),
    "panda": (146, 60),
    "puma560": (124, 51),
    "wam7": (144, 58),
}


def _arm(robot: symgen.Robot) -> Arm:
    values = robot.values()

    def number(expr: object) -> float:
        return float(expr.subs(values).evalf(30))  # type: ignore[attr-defined]

    table = {
        key: [number(getattr(j, key)) for j in robot.joints]
        for key in ("gamma", "b", "alpha", "d", "theta", "r")
    }
    return Arm.from_table(
        {
            "sigma": [j.sigma for j in robot.joints],
            "ant": [j.antecedent for j in robot.joints],
            "gravity": [number(g) for g in robot.gravity],
            **table,
        }
    )


# The joints of sr400 that follow others have an oracle of their own, in test_closed_loops.
OPEN = [name for name in symgen.library() if name != "sr400"]


@pytest.mark.parametrize("name", sampled(OPEN, 3))
def test_base_columns_equal_plain_transforms(name: str) -> None:
    robot = symgen.read_robot(name)
    model = symgen.derive(robot)
    arm, rotor = _arm(robot), [j.rotor_inertia for j in robot.joints]
    draw = np.random.default_rng(3)
    q, qd = draw.uniform(-2, 2, (2, 50, robot.n))
    names = list(column_names(arm, rotor))
    kept = [names.index(p.head) for p in model.base.parameters if p.inertial]
    expected = energy_regressor(arm, q, qd, rotor)[:, kept]
    got = symgen.load(model).energy_regressor(q, qd)
    np.testing.assert_allclose(
        got - got[0], expected - expected[0], atol=1e-12 * np.abs(expected).max()
    )


@pytest.mark.parametrize("name", sampled(["planar2r", "scara", "stanford", "panda"], 2))
def test_base_columns_equal_fifty_digits(name: str) -> None:
    robot = symgen.read_robot(name)
    model = symgen.derive(robot)
    arm, rotor = _arm(robot), [j.rotor_inertia for j in robot.joints]
    draw = np.random.default_rng(5)
    q, qd = np.round(draw.uniform(-2, 2, (2, 3, robot.n)), 6)
    names = list(column_names(arm, rotor))
    kept = [names.index(p.head) for p in model.base.parameters if p.inertial]
    exact = exact_energy_regressor(arm, q, qd, rotor)
    expected = np.array(exact, dtype=object)[:, kept]
    difference = (expected - expected[0]).astype(float)
    for backend in ("auto", "casadi"):
        got = symgen.load(model, backend=backend).energy_regressor(q, qd)
        error = np.abs((got - got[0]) - difference).max() / np.abs(difference).max()
        assert error < 1e-13, (backend, error)


@pytest.mark.parametrize("name", sampled(PAPER_COUNTS, 2))
def test_operation_counts_are_at_most_those_of_a_hand_tuned_recursion(name: str) -> None:
    operations = symgen.derive(symgen.read_robot(name)).kernels[0].tape.operations
    mul, add = PAPER_COUNTS[name]
    assert operations.mul <= mul
    assert operations.add <= add
    assert operations.sincos == symgen.read_robot(name).n - 1

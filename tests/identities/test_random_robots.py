"""On random serial and tree arms, revolute, prismatic and fixed: model = oracle, base = rank."""

from __future__ import annotations

import numpy as np
import pytest
from oracles.numeric_rank import NoGapError, count_base_parameters, difference_matrix, random_states
from oracles.random_arms import random_arm, random_parameters
from oracles.transforms import energy_regressor, parameter_vector
from support import robot_of, sampled

import symgen

FRICTION = [(), ("coulomb", "viscous"), ("coulomb", "viscous", "offset"), ("offset",)]
# 300 robots in all: 240 of up to 5 joints, 60 of up to 8.
ROBOTS = [(seed, 5) for seed in range(240)] + [(1000 + seed, 8) for seed in range(60)]


def _model(seed: int, most: int, friction: tuple[str, ...]):
    arm = random_arm(seed, max_joints=most)
    rotor = bool(seed % 3)
    return arm, rotor, symgen.derive(robot_of(arm, friction, rotor))


@pytest.mark.parametrize("block", sampled(range(10), 3))
def test_count_equals_numeric_rank_and_regrouping_reproduces_every_column(block: int) -> None:
    for seed, most in ROBOTS[block::10]:
        friction = FRICTION[seed % 4]
        arm, rotor, model = _model(seed, most, friction)
        try:
            expected = count_base_parameters(arm, rotor, friction)
        except NoGapError:
            continue
        base = model.base
        assert len(base.parameters) == expected == base.proof.rank, seed
        W, names = difference_matrix(arm, rotor, friction)
        column = dict(zip(names, W.T, strict=True))
        kept = {p.head for p in base.parameters}
        # X_base = X_head + sum c X_d means that column d = sum of c times the heads' columns.
        rebuilt = {name: np.zeros(len(W)) for name in names if name not in kept}
        for p in base.parameters:
            for coefficient, name in p.terms:
                if name in rebuilt:
                    rebuilt[name] += float(coefficient) * column[p.head]
        for name, value in rebuilt.items():
            size = max(1.0, np.abs(W).max())
            assert np.abs(value - column[name]).max() < 1e-8 * size, (seed, name)


@pytest.mark.parametrize("block", sampled(range(4), 2))
def test_energy_in_base_parameters_is_the_energy_of_plain_transforms(block: int) -> None:
    for seed in range(2000 + 8 * block, 2008 + 8 * block):
        arm, rotor, model = _model(seed, 6, ())
        q, qd = random_states(arm, 6, seed)
        links, rotors = random_parameters(arm, seed)
        standard = parameter_vector(arm, links, rotors, rotor)
        expected = energy_regressor(arm, q, qd, rotor) @ standard
        names = [p.name for p in model.base.standard if p.inertial]
        value = dict(zip(names, standard, strict=True))
        X = [
            value[p.head] + sum(float(c) * value[n] for c, n in p.terms)
            for p in model.base.parameters
            if p.inertial
        ]
        h = symgen.load(model, backend="casadi").energy_regressor(q, qd)
        got = h @ np.array(X)
        size = np.abs(expected).max() + 1
        np.testing.assert_allclose(got - got[0], expected - expected[0], atol=1e-10 * size)

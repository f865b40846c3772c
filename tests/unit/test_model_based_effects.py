"""Torques of a robot whose lengths and gravity vary, against Pinocchio."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from oracles.hidden import machines
from oracles.random_arms import to_toml

import symgen
from symgen.hypotheses.model_based_effects import special_candidates
from symgen.symbolic.sampling import random_states
from symgen.symbolic.variation import variation


@pytest.mark.parametrize("robot", ["planar2r", "arm6r"])
def test_the_torque_of_links_with_a_free_length_and_gravity_is_pinocchios(robot: str) -> None:
    pytest.importorskip("pinocchio")
    from oracles.hidden.engines import PinocchioEngine

    machine = machines.MACHINES[robot]
    v = variation(symgen.parse_robot(to_toml(machine.arm, robot)))
    number, key = v.lengths[0]
    lengths = list(getattr(machine.arm, key))
    lengths[number - 1] += 0.07
    gravity = np.array([1.0, -2.0, 3.0])
    arm = replace(machine.arm, **{key: tuple(lengths)}, gravity=tuple(gravity))
    states = random_states(v.robot, 20)
    bare = replace(machine, arm=arm, rotor=np.zeros(machine.n))
    theirs = PinocchioEngine(bare).torque(*states)
    ours = v.torque(states, machine.links, gravity, {(number, key): 0.07})
    assert np.allclose(ours, theirs, rtol=0, atol=1e-10)


def test_a_planar_arm_feels_its_base_turn_about_its_axes_alone() -> None:
    """In a vertical plane; of the two other axes one is vertical, and one lies in the plane."""
    robot = symgen.parse_robot(machines.MACHINES["planar2r"].robot_toml())
    (tilt,) = (c for c in special_candidates(robot, ()) if c.name == "base_tilt")
    assert [name for name, _ in tilt.coefficients] == ["TZ"]

"""Offsets beside weight: what holds an arm at rest is in gravity and energy, never in friction."""

from __future__ import annotations

import random
from dataclasses import replace

import numpy as np
import pytest
from oracles.numeric_rank import difference_matrix, numeric_rank
from oracles.random_arms import random_arm, random_parameters, to_toml
from oracles.transforms import PRISMATIC, REVOLUTE, Arm
from support import parsed, sampled

import symgen

KERNELS = (
    "gravity_torque", "friction", "energy", "generalized_momentum", "inverse_dynamics",
    "base_parameters", "add_body",
)  # fmt: skip
OFFSET = ("coulomb", "viscous", "offset")
PLACES = ((0.0, 0.0, -9.81), (0.0, 9.81, 0.0), (3.1, -4.2, -8.3), (0.0, -6.0, -8.0))


def sliding_arm(seed: int) -> tuple[Arm, list[bool]]:
    """Draw an arm or a tree that begins with linear axes, and which joints have a rotor."""
    rng = random.Random(f"offsets {seed}")
    arm = random_arm(1000 + seed, min_joints=1, max_joints=5, fixed=seed % 4 == 3)
    sliding = 1 + int(rng.random() * 3)
    sigma = [PRISMATIC if j < sliding else s for j, s in enumerate(arm.sigma)]
    if rng.random() < 0.2:
        sigma[0] = REVOLUTE
    gravity = PLACES[int(rng.random() * len(PLACES))]
    rotors = [rng.random() < 0.8 for _ in sigma]
    return replace(arm, sigma=tuple(sigma), gravity=gravity), rotors


def close(found, expected, tolerance: float = 1e-9) -> None:
    expected = np.asarray(expected)
    limit = tolerance * (1 + np.abs(expected).max(initial=0.0))
    np.testing.assert_allclose(found, expected, atol=limit, rtol=0)


class Pair:
    """An arm with offsets in symgen, and in Pinocchio, which knows links and rotors only."""

    def __init__(self, seed: int) -> None:
        pytest.importorskip("pinocchio", reason="Pinocchio (pin) is not installed")
        self.arm, rotors = sliding_arm(seed)
        text = to_toml(self.arm, "arm", OFFSET, rotors)
        self.model = symgen.derive(parsed(text), KERNELS)
        self.call = symgen.load(self.model, backend="casadi")
        self.links, inertias = random_parameters(self.arm, seed)
        self.rotors = inertias * [rotors[j - 1] for j in self.arm.movable]
        self.draw = np.random.default_rng(seed)
        n = self.arm.n
        self.FS, self.FV, self.OF = self.draw.uniform(1, 20, (3, n)) * self.draw.choice([-1, 1], n)
        self.q, self.qd, self.qdd, self.end = self.draw.uniform(-1, 1, (4, n))

    def witness(self, links: np.ndarray):
        from oracles.pinocchio_arm import PinocchioArm

        return PinocchioArm(self.arm, links, self.rotors)

    def X(self) -> np.ndarray:
        joint = {j: i for i, j in enumerate(self.arm.movable)}
        values = {f"IA{j}": self.rotors[i] for j, i in joint.items()}
        for prefix in ("FS", "FV", "OF"):
            values |= {f"{prefix}{j}": getattr(self, prefix)[i] for j, i in joint.items()}
        for j, row in enumerate(self.links, start=1):
            names = "XX XY XZ YY YZ ZZ MX MY MZ M".split()
            values |= {f"{name}{j}": x for name, x in zip(names, row, strict=True)}
        standard = np.array([values[p.name] for p in self.model.base.standard])
        return np.asarray(self.call["base_parameters"](standard))


@pytest.mark.parametrize("seed", sampled(range(60), 8))
def test_what_holds_the_arm_at_rest_is_gravity_and_energy(seed: int) -> None:
    pair = Pair(seed)
    X, call, still = pair.X(), pair.call, np.zeros(pair.arm.n)
    witness = pair.witness(pair.links)

    def weight(q: np.ndarray) -> np.ndarray:
        return witness.inverse_dynamics(q, still, still)

    # An offset is in the links where weight can replace it, and in friction elsewhere.
    numbers, movable = range(1, pair.arm.links + 1), pair.arm.movable
    rotors = [p.name for p in pair.model.base.standard]
    flags = [f"IA{j}" in rotors for j in numbers]
    alone = [[OFFSET if j == k else () for j in numbers] for k in movable]
    ranks = [numeric_rank(difference_matrix(pair.arm, flags, words)[0]) for words in alone]
    bare = numeric_rank(difference_matrix(pair.arm, flags)[0])
    joined = pair.OF * (np.array(ranks) == bare)
    assert len(X) - 2 * pair.arm.n == numeric_rank(difference_matrix(pair.arm, flags, OFFSET)[0])

    close(call["gravity_torque"](pair.q, X), weight(pair.q) + joined)
    sliding = pair.FS * np.sign(pair.qd) + pair.FV * pair.qd
    close(call["friction"](pair.qd, X), sliding + pair.OF - joined)
    close(call["friction"](still, X), pair.OF - joined)
    rigid = witness.inverse_dynamics(pair.q, pair.qd, pair.qdd)
    close(call["inverse_dynamics"](pair.q, pair.qd, pair.qdd, X), rigid + sliding + pair.OF)

    kinetic, _ = call["energy"](pair.q, pair.qd, X)
    close(kinetic, witness.kinetic_energy(pair.q, pair.qd))
    rise = witness.potential_energy(pair.end) - witness.potential_energy(pair.q)
    ends = [call["energy"](q, still, X)[1] for q in (pair.end, pair.q)]
    close(ends[0] - ends[1], rise + joined @ (pair.end - pair.q))

    momentum, rate = call["generalized_momentum"](pair.q, pair.qd, X)
    close(momentum, witness.mass_matrix(pair.q) @ pair.qd)
    h = 1e-5  # d/dt (M qd) = M qdd + M' qd along the motion, = tau - friction + rate
    ahead, behind = (witness.mass_matrix(pair.q + s * pair.qd) for s in (h, -h))
    slope = (ahead - behind) @ pair.qd / (2 * h) + witness.mass_matrix(pair.q) @ pair.qdd
    close(rate, slope - rigid - joined, 1e-6)

    link = 1 + seed % pair.arm.links
    mass, com = 10.0, np.array([0.1, -0.2, 0.3])
    moment = np.array([0.9, 0.01, -0.02, 0.8, 0.03, 0.7])
    about = com @ com * np.eye(3) - np.outer(com, com)
    heavier = pair.links.copy()
    heavier[link - 1] += [*moment + mass * about[np.triu_indices(3)], *(mass * com), mass]
    witness = pair.witness(heavier)
    X = call["add_body"](X, link, mass, com, moment)
    close(call["gravity_torque"](pair.q, X), weight(pair.q) + joined)
    close(call["energy"](pair.q, pair.qd, X)[0], witness.kinetic_energy(pair.q, pair.qd))

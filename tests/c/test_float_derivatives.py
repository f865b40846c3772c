"""Derivatives of forward dynamics in float, where joints that follow others cancel motion.

M dqdd/dq + dtau/dq = 0 up to roundings of what each joint moves, not of the little that is left.
"""

from __future__ import annotations

import ctypes
import shutil
from pathlib import Path

import numpy as np
import pytest
from oracles.following import FollowingArm, following_arm
from oracles.random_arms import random_parameters
from packages import run
from support import parsed, sampled

import symgen

ROUNDING = 2.0**-24
#: Largest error in roundings of the terms of the sums.
BOUND = 16
DRAWS = 25
LINK = "XX XY XZ YY YZ ZZ MX MY MZ M".split()


class Floats:
    """The kernel of an arm, compiled in float."""

    def __init__(self, chosen: FollowingArm, folder: Path) -> None:
        model = symgen.derive(parsed(chosen.text), ("forward_dynamics_derivatives",))
        symgen.write_package(symgen.generate(model, target="c", dtype="float"), folder)
        source = "armf_forward_dynamics_derivatives.c"
        run(["cc", "-O2", "-shared", "-fPIC", source, "-lm", "-o", "arm.so"], folder)
        library = ctypes.CDLL(str(folder / "arm.so"))
        self.call = library.armf_forward_dynamics_derivatives
        self.n = model.robot.n

    def __call__(self, *inputs: np.ndarray) -> tuple[bool, np.ndarray]:
        """Return whether M is positive definite in float, and the derivatives (3, n, n)."""
        arrays = [np.ascontiguousarray(x, dtype=np.float32) for x in inputs]
        arrays += [np.empty((self.n, self.n), dtype=np.float32) for _ in range(3)]
        status = self.call(*(ctypes.c_void_p(x.ctypes.data) for x in arrays))
        return status == 0, np.array(arrays[-3:], dtype=float)


class Truth:
    """The same arm in Pinocchio, in double, over the variables of its own joints."""

    def __init__(self, chosen: FollowingArm, links: np.ndarray, rotors: np.ndarray) -> None:
        pytest.importorskip("pinocchio", reason="Pinocchio (pin) is not installed")
        from oracles.pinocchio_arm import PinocchioArm

        self.tree, self.G, self.c = PinocchioArm(chosen.arm, links, rotors), chosen.G, chosen.c

    def mass(self, q: np.ndarray) -> np.ndarray:
        return self.G.T @ self.tree.mass_matrix(self.G @ q + self.c) @ self.G

    def torque(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
        return self.G.T @ self.tree.inverse_dynamics(self.G @ q + self.c, self.G @ qd, self.G @ qdd)

    def slopes(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
        tree = (self.G @ q + self.c, self.G @ qd, self.G @ qdd)
        return self.G.T @ self.tree.inverse_dynamics_derivatives(*tree) @ self.G


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler (cc) on this machine")
@pytest.mark.parametrize("seed", sampled(range(100, 150), 0, always=[135, 147]))
def test_errors_of_derivatives_in_float_are_roundings_of_their_terms(
    seed: int, tmp_path: Path
) -> None:
    chosen = following_arm(seed, max_joints=5)
    compiled = Floats(chosen, tmp_path)
    base = symgen.derive(parsed(chosen.text), ("base_parameters",))
    regroup = symgen.load(base, backend="casadi").base_parameters
    moving, n = chosen.arm.movable, compiled.n
    draw = np.random.default_rng(seed)
    for k in range(DRAWS):
        links, _ = random_parameters(chosen.arm, 100 * seed + k)
        links = links * 10 ** draw.uniform(-5, 1, (len(links), 1))
        FS, FV, IA = draw.uniform(0, 1, n), draw.uniform(0, 1, n), 10 ** draw.uniform(-7, -1, n)
        values = {f"{p}{j + 1}": x for (j, i), x in np.ndenumerate(links) for p in [LINK[i]]}
        for prefix, row in (("FS", FS), ("FV", FV), ("IA", IA)):
            values |= {f"{prefix}{j}": x for j, x in zip(chosen.own, row, strict=True)}
        X = regroup(np.array([values[p.name] for p in base.base.standard]))
        scales = np.array([[np.pi], [3.0], [50.0]])
        q, qd, tau = np.float32(draw.uniform(-1, 1, (3, n)) * scales).astype(float)
        possible, found = compiled(q, qd, tau, X)
        rotors = np.array([values.get(f"IA{j}", 0.0) for j in moving])
        truth = Truth(chosen, links, rotors)
        M = truth.mass(q)
        if not possible:
            assert np.linalg.cond(M) > 1e5
            continue
        friction = FS * np.sign(qd) + FV * qd
        qdd = np.linalg.solve(M, tau - friction - truth.torque(q, qd, np.zeros(n)))
        by_q, by_qd = truth.slopes(q, qd, qdd)
        errors = [M @ found[0] + by_q, M @ found[1] + by_qd + np.diag(FV), M @ found[2] - np.eye(n)]
        # W (g + a + v^2): what links need that move as the fastest joint, followers included.
        W = np.abs(links).sum() + IA.sum()
        a, v = (np.abs(np.abs(chosen.G) @ np.abs(x)).max() for x in (qdd, qd))
        terms = [np.linalg.cond(M) * W * (9.81 + a + v**2), W * v + FV.max(), 1.0]
        for error, term, derivative in zip(errors, terms, found, strict=True):
            size = np.linalg.norm(M, 2) * np.linalg.norm(derivative) + term
            assert np.abs(error).max() <= BOUND * ROUNDING * size

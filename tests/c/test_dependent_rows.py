"""Tasks whose rows depend on each other: ranks with 60 digits, and bounds of rounding, beside C."""

from __future__ import annotations

import ctypes
import random
import subprocess
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from oracles.exact import MP_BACKEND, exact_angle, exact_arm
from oracles.following import following_arm
from oracles.random_arms import random_arm
from oracles.transforms import PRISMATIC, REVOLUTE, Arm, jacobians, world_transforms
from packages import c_files
from support import parsed, robot_of, sampled

import symgen
from symgen.codegen.verification import physical_parameters
from symgen.runtime.build import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
UNIT = {"double": 2.0**-53, "float": 2.0**-24}
REAL = {"double": np.float64, "float": np.float32}
OK, NOT_POSITIVE_DEFINITE = 0, 1


@dataclass(frozen=True)
class Machine:
    """A random robot; q_tree = G q + c."""

    arm: Arm
    robot: symgen.Robot
    G: np.ndarray
    c: np.ndarray

    @classmethod
    def drawn(cls, seed: int) -> Machine:
        """From 100 on, some joints follow others."""
        if seed >= 100:
            found = following_arm(seed, max_joints=7)
            return cls(found.arm, parsed(found.text), found.G, found.c)
        arm = random_arm(seed, min_joints=3, max_joints=7)
        return cls(arm, robot_of(arm), np.eye(arm.n), np.zeros(arm.n))

    def rows(self, q: np.ndarray, link: int, point: np.ndarray) -> np.ndarray:
        """Return the Jacobian (6, n) of a point, right to 50 digits."""
        tree = MP_BACKEND.array(self.G) @ MP_BACKEND.array(q)
        tree += np.array([exact_angle(c) for c in self.c], dtype=object)
        frames = world_transforms(exact_arm(self.arm), tree, MP_BACKEND)
        J = jacobians(self.arm, frames)[link - 1]
        x, y, z = frames[link - 1, :3, :3] @ MP_BACKEND.array(point)
        J[:3] += np.array([[0 * z, z, -y], [-z, 0 * z, x], [y, -x, 0 * z]]) @ J[3:]
        return J @ MP_BACKEND.array(self.G)


def rank(rows: np.ndarray) -> int:
    """Return the rank of rows with 50 right digits, by elimination with full pivoting."""
    work, found = rows.copy(), 0
    while found < min(work.shape):
        size = np.abs(work[found:, found:].astype(float))
        i, k = np.unravel_index(np.argmax(size), size.shape)
        if size[i, k] < 1e-35:
            break
        work[[found, found + i]] = work[[found + i, found]]
        work[:, [found, found + k]] = work[:, [found + k, found]]
        factors = work[found + 1 :, found] / work[found, found]
        work[found + 1 :] -= factors[:, None] * work[found]
        found += 1
    return found


def bounds(arm: Arm, q: np.ndarray, link: int, point: np.ndarray, unit: float) -> np.ndarray:
    """Return the errors (6,) of rows that the package states, for joints that follow none.

    A turn by a joint adds 7.1 roundings to the axes, and one by another angle than a quarter turn
    4.9; the addition of such an offset to q, sqrt(2) times 2 roundings of both. Lengths add up.
    """
    variable = dict(zip(arm.movable, q, strict=True))
    joints, axes, shifts, reach = arm.path(link), 0.0, 3, np.abs(point).sum()
    turning = sum(arm.sigma[j - 1] == REVOLUTE for j in joints)
    sliding = sum(arm.sigma[j - 1] == PRISMATIC for j in joints)

    def odd(angle: float) -> bool:
        return abs(angle / (np.pi / 2) - round(angle / (np.pi / 2))) > 1e-9

    for j in joints:
        gamma, b, alpha, d, theta, r = (
            getattr(arm, key)[j - 1] for key in ("gamma", "b", "alpha", "d", "theta", "r")
        )
        axes += 4.9 * (odd(gamma) + odd(alpha))
        if arm.sigma[j - 1] == REVOLUTE:
            axes += 7.1 + 2.9 * odd(theta) * (abs(variable[j]) + abs(theta))
        else:
            axes += 4.9 * odd(theta)
        lengths = [b, d, r, variable[j] if arm.sigma[j - 1] == PRISMATIC else 0]
        reach += np.abs(lengths).sum()
        shifts += np.count_nonzero(lengths)
    own = 10 * (arm.n + 2)  # five projections
    moving = np.sqrt(turning) * reach * (3 * axes + 2 * shifts + 10 + own)
    slides = np.sqrt(sliding) * (axes + own)
    return 1.01 * unit * np.repeat([moving + slides, np.sqrt(turning) * (axes + own)], 3)


def operational_space(model: symgen.Model, dtype: str, folder: Path) -> Callable[..., int]:
    """Compile the kernel of a package; the function returns its status."""
    tree = symgen.generate(model, target="c", dtype=dtype)
    symgen.write_package(tree, folder)
    compiler = find_compiler()
    assert compiler is not None
    library = folder / "library.so"
    flags = ["-std=c99", "-O1", "-shared", "-fPIC", f"-I{folder}"]
    subprocess.run([*compiler.command, *flags, *c_files(folder), "-lm", "-o", library], check=True)
    function = ctypes.CDLL(str(library))[f"{tree.name}_operational_space"]
    n = model.robot.n
    X = np.array(physical_parameters(model, random.Random(1)))
    out = [np.zeros(size, REAL[dtype]) for size in (36, 6 * n, n)]

    def status(q: np.ndarray, link: int, point: np.ndarray, chosen: np.ndarray) -> int:
        given = [q, point, np.isin(np.arange(6), chosen), np.ones(n), X]
        q, *rest = (np.ascontiguousarray(x, dtype=REAL[dtype]) for x in given)
        pointers = [ctypes.c_void_p(x.ctypes.data) for x in (q, *rest, *out)]
        found: int = function(pointers[0], ctypes.c_size_t(link), *pointers[1:])
        return found

    return status


def tasks(machine: Machine, seed: int, count: int) -> Iterator[tuple]:
    """Yield random q, link, point and two to six rows; all numbers are floats of 24 bits."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        q, point = rng.uniform(-3, 3, machine.robot.n), rng.uniform(-0.3, 0.3, 3)
        q, point = (x.astype(np.float32).astype(float) for x in (q, point))
        chosen = np.sort(rng.permutation(6)[: rng.integers(2, 7)])
        yield q, int(rng.integers(1, machine.arm.links + 1)), point, chosen


@pytest.mark.parametrize("seed", [*sampled(range(20), 1), *sampled(range(100, 110), 1)])
def test_every_task_with_dependent_rows_is_refused_and_no_other(seed: int, tmp_path: Path) -> None:
    machine = Machine.drawn(seed)
    model = symgen.derive(machine.robot, ("operational_space",))
    compiled = [operational_space(model, dtype, tmp_path / dtype) for dtype in UNIT]
    counts = [0, 0]
    for q, link, point, chosen in tasks(machine, seed, 40):
        rows = machine.rows(q, link, point)[chosen]
        expected = OK if rank(rows) == len(chosen) else NOT_POSITIVE_DEFINITE
        counts[expected] += 1
        for status in compiled:
            assert status(q, link, point, chosen) == expected
    assert counts[NOT_POSITIVE_DEFINITE] > 5


def singular(machine: Machine, rng: np.random.Generator) -> tuple | None:
    """Return a singular q, a direction from it, and a task: link, point and rows."""
    arm = machine.arm
    links = [k for k in range(1, arm.links + 1) if 2 <= len(moving(arm, k)) <= 6]
    if not links:
        return None
    for _ in range(100):
        link = int(rng.choice(links))
        columns = [arm.movable.index(j) for j in moving(arm, link)]
        chosen = np.sort(rng.permutation(6)[: len(columns)])
        point = rng.uniform(-0.3, 0.3, 3).astype(np.float32).astype(float)
        ends = rng.uniform(-3, 3, (2, arm.n))

        def volume(q, link=link, point=point, chosen=chosen, columns=columns) -> float:
            frames = world_transforms(arm, q)
            J = jacobians(arm, frames)[link - 1]
            J[:3] -= np.cross(frames[link - 1, :3, :3] @ point, J[3:], axisb=0, axisc=0)
            return np.linalg.det(J[np.ix_(chosen, columns)])

        low, high = map(volume, ends)
        if min(abs(low), abs(high)) < 1e-9 or low * high > 0:
            continue
        for _ in range(60):
            middle = ends.mean(axis=0)
            ends[int(volume(middle) * low < 0)] = middle
        return ends[0], rng.uniform(-1, 1, arm.n), link, point, chosen
    return None


def moving(arm: Arm, link: int) -> list[int]:
    return [j for j in arm.path(link)[::-1] if j in arm.movable]


@pytest.mark.parametrize("seed", sampled(range(30), 1))
def test_near_a_singular_place_rows_are_refused_within_the_bound_alone(
    seed: int, tmp_path: Path
) -> None:
    """Refused rows are dependent after changes within their bounds, so sigma <= sqrt(rows)."""
    machine, rng = Machine.drawn(seed), np.random.default_rng(seed)
    found = singular(machine, rng)
    if found is None:
        pytest.skip("no link with a singular place between two random q")
    place, direction, link, point, chosen = found
    model = symgen.derive(machine.robot, ("operational_space",))
    for dtype, unit in UNIT.items():
        status = operational_space(model, dtype, tmp_path / dtype)
        accepted = []
        for step in np.geomspace(0.1, unit, 24):
            q = (place + step * direction).astype(REAL[dtype]).astype(float)
            rows = machine.rows(q, link, point)[chosen].astype(float)
            scaled = rows / bounds(machine.arm, q, link, point, unit)[chosen, None]
            far = np.linalg.svd(scaled, compute_uv=False)[-1] > np.sqrt(len(chosen))
            accepted.append(status(q, link, point, chosen) == OK)
            assert accepted[-1] or not far
        assert accepted[0]
        assert not accepted[-1]

"""Base parameters of more than 1,000 random robots: the count of each, and a sample of them again.

The whole run takes minutes and is made on purpose:

    pytest -m slow tests/identities/test_fuzz_base_parameters.py

It writes fuzz_figures.json, one count for each robot; the default suite takes some of these robots
again and compares with the file and with the oracle.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from oracles.following import following_arm
from oracles.numeric_rank import NoGapError, count_base_parameters, difference_matrix
from oracles.random_arms import named_arm, random_arm
from oracles.transforms import PRISMATIC, Arm
from support import parsed, robot_of, sampled

import symgen

FIGURES = Path(__file__).with_name("fuzz_figures.json")
FRICTION = [(), ("coulomb", "viscous"), ("coulomb", "viscous", "offset"), ("offset",)]
# Trees with prismatic joints, several of them on the base, are where grouping by rules fails.
OPEN, FOLLOWING, NAMED = 1100, 200, 300


def _open(seed: int) -> dict[str, int]:
    """Compare one random arm with the oracle: count, and every regrouping by its columns."""
    arm = random_arm(7_000_000 + seed, max_joints=7, tree=None if seed % 2 else True)
    rotor, friction = bool(seed % 3), FRICTION[seed % 4]
    return _compared(seed, arm, robot_of(arm, friction, rotor), rotor, friction)


def _named(seed: int) -> dict[str, int]:
    """The same for an arm whose lengths are named, times roots and fractions."""
    arm, text = named_arm(9_000_000 + seed)
    return _compared(seed, arm, parsed(text, "named"), True, ())


def _compared(
    seed: int, arm: Arm, robot: symgen.Robot, rotor: bool, friction: tuple[str, ...]
) -> dict[str, int]:
    base = symgen.derive(robot, ()).base
    shape = {
        "count": len(base.parameters),
        "prismatic": sum(s == PRISMATIC for s in arm.sigma),
        "roots": sum(a == 0 for a in arm.ant),
    }
    try:
        expected = count_base_parameters(arm, rotor, friction)
    except NoGapError:
        return {**shape, "oracle": -1}
    assert len(base.parameters) == expected == base.proof.rank, seed
    W, names = difference_matrix(arm, rotor, friction)
    column = dict(zip(names, W.T, strict=True))
    kept = {p.head for p in base.parameters}
    rebuilt = {name: np.zeros(len(W)) for name in names if name not in kept}
    for p in base.parameters:
        for coefficient, name in p.terms:
            if name in rebuilt:
                rebuilt[name] += float(coefficient.subs(robot.values())) * column[p.head]
    for name, value in rebuilt.items():
        assert np.abs(value - column[name]).max() < 1e-8 * max(1.0, np.abs(W).max()), (seed, name)
    return {**shape, "oracle": expected}


def _following(seed: int) -> dict[str, int]:
    chosen = following_arm(3_000 + seed)
    count = symgen.derive(parsed(chosen.text)).base.inertial
    try:
        expected = chosen.count_base_parameters()
    except NoGapError:
        return {"count": count, "oracle": -1}
    assert count == expected, seed
    return {"count": count, "oracle": expected}


@pytest.mark.slow
def test_every_robot() -> None:
    figures = {
        "open": [_open(seed) for seed in range(OPEN)],
        "following": [_following(seed) for seed in range(FOLLOWING)],
    }
    rows = ",\n".join(
        f'  "{kind}": [\n' + ",\n".join(f"    {json.dumps(r)}" for r in found) + "\n  ]"
        for kind, found in figures.items()
    )
    FIGURES.write_text(f"{{\n{rows}\n}}\n", encoding="utf-8")


@pytest.mark.slow
def test_every_robot_with_named_lengths() -> None:
    certain = sum(_named(seed)["oracle"] >= 0 for seed in range(NAMED))
    assert certain >= 0.9 * NAMED


@pytest.mark.parametrize("start", sampled(range(4), 1))
def test_named_lengths_times_roots_and_fractions(start: int) -> None:
    for seed in range(start, NAMED, 75):
        _named(seed)


@pytest.mark.parametrize(
    ("angle", "length"),
    sampled([(a, x) for a in ("0.3", '"pi/6"')
             for x in ("sqrt(2)*L1/2", "sqrt(3)*L1/3", "2*L1/3")], 3),
)  # fmt: skip
def test_a_prismatic_joint_at_a_named_length_times_a_root(angle: str, length: str) -> None:
    joint = f'[[joint]]\nsigma = 1\ngamma = {angle}\nd = "{length}"\n'
    head = '[robot]\nname = "x"\nconvention = "modified-dh"\ngravity = [0.0, 0.0, -9.81]\n'
    robot = parsed(f"{head}[geometry]\nL1 = 0.5\n[[joint]]\n{joint}[[joint]]\n", "x")
    ours = symgen.derive(robot, ()).base
    gamma = 0.3 if angle == "0.3" else np.pi / 6
    d = {"sqrt(2)*L1/2": 0.5**1.5, "sqrt(3)*L1/3": 3**-0.5 / 2, "2*L1/3": 1 / 3}[length]
    arm = Arm.from_table({"sigma": (0, 1, 0), "gamma": (0, gamma, 0), "d": (0, d, 0)})
    friction = ("coulomb", "viscous")
    assert len(ours.parameters) == count_base_parameters(arm, True, friction)


@pytest.mark.parametrize("start", sampled(range(4), 1))
def test_a_sample_again(start: int) -> None:
    """And the figures, with the sample as it comes out today, say what was covered."""
    figures = json.loads(FIGURES.read_text("utf-8"))
    for seed in range(7 * start, OPEN, 131):
        again = _open(seed)
        assert again == figures["open"][seed], seed
        figures["open"][seed] = again
    for seed in range(start, FOLLOWING, 67):
        assert _following(seed) == figures["following"][seed], seed
    certain = [r for r in figures["open"] if r["oracle"] >= 0]
    assert len(certain) >= 1000
    assert all(r["count"] == r["oracle"] for r in certain)
    assert sum(r["prismatic"] > 0 for r in certain) >= 500
    assert sum(r["roots"] > 1 for r in certain) >= 200
    assert len([r for r in figures["following"] if r["oracle"] >= 0]) >= 190

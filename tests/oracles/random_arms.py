"""Seeded random robots whose geometry is often special, as real robots' is.

Only ``random.Random.random`` is drawn from: Python keeps its sequence from version to version.
"""

import math
import random
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from oracles.numeric_rank import friction_terms
from oracles.transforms import FIXED, GEOMETRY, PRISMATIC, REVOLUTE, Arm, rotor_flags

SPECIAL_ANGLES = (0.0, 0.0, math.pi / 2, -math.pi / 2, math.pi)


def random_arm(
    seed: int,
    min_joints: int = 1,
    max_joints: int = 8,
    tree: bool | None = None,
    fixed: bool = True,
) -> Arm:
    """Draw one robot: serial or a tree, any mix of joints, at least one of them movable.

    Args:
        seed: same seed and options, same arm.
        min_joints: smallest number of joints, fixed ones included.
        max_joints: largest number of joints.
        tree: True or False to force it; None draws it. A tree may put several joints on the base.
        fixed: whether fixed joints may appear.
    """
    rng = random.Random(f"arm {seed}")
    joints = min_joints + int(rng.random() * (max_joints - min_joints + 1))
    branched = rng.random() < 0.4 if tree is None else tree
    # How special the geometry is varies from robot to robot, from generic to all at right angles.
    special = (0.2, 0.6, 0.85, 1.0)[int(rng.random() * 4)]
    table: dict[str, list] = {key: [] for key in ("sigma", "ant", *GEOMETRY)}
    for j in range(1, joints + 1):
        table["sigma"].append(_sigma(rng, fixed))
        jump = branched and rng.random() < 0.5
        ant = int(rng.random() * j) if jump else j - 1
        table["ant"].append(ant)
        on_branch = ant != j - 1 or rng.random() < 0.1
        table["gamma"].append(_angle(rng, special) if on_branch else 0.0)
        table["b"].append(_length(rng, special) if on_branch else 0.0)
        table["alpha"].append(_angle(rng, special))
        table["d"].append(_length(rng, special))
        table["theta"].append(_angle(rng, special))
        table["r"].append(_length(rng, special))
    if all(sigma == FIXED for sigma in table["sigma"]):
        table["sigma"][0] = REVOLUTE
    return Arm.from_table({**table, "gravity": _gravity(rng)})


def random_arms(count: int, seed: int = 0, **options: int | bool | None) -> tuple[Arm, ...]:
    """Draw `count` robots; the options are those of `random_arm`."""
    return tuple(random_arm(1_000_003 * seed + i, **options) for i in range(count))


#: Named lengths of `named_arm`, m; what stands before or behind one; angles that come with them.
LENGTHS = {"L1": 0.5, "L2": 0.37}
MULTIPLES = {
    "{}": 1.0,
    "-{}": -1.0,
    "2*{}/3": 2 / 3,
    "sqrt(2)*{}/2": math.sqrt(2) / 2,
    "-sqrt(3)*{}/4": -math.sqrt(3) / 4,
    "sqrt(6)*{}": math.sqrt(6),
}
NAMED_ANGLES = {"pi/6": math.pi / 6, "pi/4": math.pi / 4, "-2*pi/3": -2 * math.pi / 3, "0.3": 0.3}


def named_arm(seed: int, max_joints: int = 4) -> tuple[Arm, str]:
    """Draw a robot whose lengths are multiples of named ones, roots among them.

    Returns:
        The table in numbers, and a robot.toml of it with the names.
    """
    arm = random_arm(seed, min_joints=2, max_joints=max_joints)
    rng = random.Random(f"names {seed}")
    table: dict[str, list] = {key: list(getattr(arm, key)) for key in GEOMETRY}
    written: dict[tuple[str, int], str] = {}
    for key in GEOMETRY:
        for j, value in enumerate(table[key]):
            length, pick, name = key in ("b", "d", "r"), rng.random(), rng.random()
            if value == 0 or (not length and abs(value) in SPECIAL_ANGLES):
                continue
            if length:
                chosen = list(LENGTHS)[int(name * len(LENGTHS))]
                text = list(MULTIPLES)[int(pick * len(MULTIPLES))]
                written[key, j] = text.format(chosen)
                table[key][j] = MULTIPLES[text] * LENGTHS[chosen]
            else:
                written[key, j] = list(NAMED_ANGLES)[int(pick * len(NAMED_ANGLES))]
                table[key][j] = NAMED_ANGLES[written[key, j]]
    arm = replace(arm, **{key: tuple(values) for key, values in table.items()})
    return arm, to_toml(arm, "named", written=written)


def random_parameters(arm: Arm, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Draw physical standard parameters.

    Returns:
        Link parameters (links, 10) in the order XX XY XZ YY YZ ZZ MX MY MZ M, from a positive mass
        density; rotor inertias (n,), positive.
    """
    rng = random.Random(f"parameters {seed}")
    rows = []
    for _ in range(arm.links):
        # Four point masses at random places always make a physical body.
        masses = np.array([0.2 + rng.random() for _ in range(4)])
        points = np.array([[rng.random() - 0.5 for _ in range(3)] for _ in range(4)])
        moment = (masses[:, None, None] * points[:, :, None] * points[:, None, :]).sum(axis=0)
        inertia = np.trace(moment) * np.eye(3) - moment
        first = masses @ points
        rows.append([*inertia[np.triu_indices(3)], *first, masses.sum()])
    return np.array(rows), np.array([0.05 + rng.random() for _ in range(arm.n)])


def to_toml(
    arm: Arm,
    name: str,
    friction: Sequence[str] | Sequence[Sequence[str]] = (),
    rotor: bool | Sequence[bool] = True,
    written: Mapping[tuple[str, int], str] | None = None,
) -> str:
    """Write a robot.toml.

    Args:
        arm: the table.
        name: a C identifier.
        friction: names for all movable joints, or one sequence of names per joint of the file.
        rotor: one flag for all joints or one per joint of the file.
        written: expressions in `LENGTHS` that stand for a key of a joint (0 the first).
    """
    written = written or {}
    gravity = ", ".join(repr(float(g)) for g in arm.gravity)
    lines = ["[robot]", f'name = "{name}"', 'convention = "modified-dh"', f"gravity = [{gravity}]"]
    if written:
        lines += ["", "[geometry]", *(f"{name} = {value!r}" for name, value in LENGTHS.items())]
    terms = dict(zip(arm.movable, friction_terms(arm, friction), strict=True))
    for j, has_rotor in enumerate(rotor_flags(arm, rotor), start=1):
        lines += ["", "[[joint]]", f"sigma = {arm.sigma[j - 1]}"]
        lines += [f"antecedent = {arm.ant[j - 1]}"]
        values = {key: repr(float(getattr(arm, key)[j - 1])) for key in GEOMETRY}
        values |= {key: f'"{text}"' for (key, at), text in written.items() if at == j - 1}
        lines += [f"{key} = {value}" for key, value in values.items()]
        if j in terms:
            quoted = ", ".join(f'"{term}"' for term in terms[j])
            lines += [f"friction = [{quoted}]", f"rotor_inertia = {str(has_rotor).lower()}"]
    return "\n".join(lines) + "\n"


def _sigma(rng: random.Random, fixed: bool) -> int:
    draw = rng.random()
    if fixed and draw < 0.12:
        return FIXED
    return PRISMATIC if draw < 0.4 else REVOLUTE


def _angle(rng: random.Random, special: float) -> float:
    pick, value = rng.random() < special, rng.random()
    if pick:
        return SPECIAL_ANGLES[int(value * len(SPECIAL_ANGLES))]
    # Away from zero and from right angles, where a rank in float64 would be uncertain.
    return round((0.2 + 1.1 * value) * (1 if rng.random() < 0.5 else -1), 3)


def _length(rng: random.Random, special: float) -> float:
    if rng.random() < 0.6 * special:
        return 0.0
    return round((0.1 + 0.9 * rng.random()) * (1 if rng.random() < 0.7 else -1), 3)


def _gravity(rng: random.Random) -> tuple[float, float, float]:
    draw, axis = rng.random(), int(rng.random() * 3)
    if draw < 0.15:
        return (0.0, 0.0, 0.0)
    if draw < 0.8:
        return tuple(-9.81 if i == axis else 0.0 for i in range(3))
    return (3.1, -4.2, -8.3)

"""Arms of special geometry, as text of a robot.toml and as plain numbers side by side.

Where exact arithmetic could go wrong: fractions of pi that are no quarter turns, decimal angles
that are commensurable, square roots beside them, named lengths and angles that are equal, zero or
multiples of each other, parallel axes, prismatic chains, several joints on the base, couplings and
payloads.
"""

from __future__ import annotations

import json
import math
import random
from dataclasses import dataclass

import numpy as np

from oracles.numeric_rank import random_states
from oracles.transforms import GEOMETRY, Arm, column_names, energy_regressor

FAMILIES = ("irrational", "named", "expressions", "parallel tree coupled", "prismatic tree coupled")
_ANGLES = (
    "0 pi/2 -pi/2 pi pi/3 pi/4 -pi/4 pi/6 pi/8 -pi/8 pi/24 pi/12 pi/5 -pi/5 2*pi/5 0.3 -0.3 0.6 "
    "-0.6 0.3+pi/2 pi/4-0.3 0.3+pi/8 pi-0.6 pi/7 -pi/7"
).split()
_LENGTHS = "0 0.2 0.4 -0.4 -0.2 sqrt(2)/5 -sqrt(2)/5 sqrt(5)/5 -sqrt(5)/5 0.31".split()
_GRAVITY = ("0 0 -9.81", "0 -9.81 0", "0 0 0", "3.1 -4.2 -8.3", "-9.81 0 0", "0 -4 -3")
_PLAIN = "0 0 pi/2 -pi/2 pi 0.3 -0.3 0.6".split()
_NAMED_ANGLES = "a c -a a-c -c".split()
_MIXED_ANGLES = "a c -a a+c -c a-c pi/2-a 2*a a+pi/8 a/2".split()
_NAMED_LENGTHS = "L1 L2 L3 -L1 -L2 L1-L2 2*L1-L2 L1+L2".split()


@dataclass(frozen=True)
class SpecialArm:
    """One arm: the file's text, the numbers, and what is declared."""

    text: str
    arm: Arm
    rotor: tuple[bool, ...]
    friction: tuple[str, ...]
    couplings: tuple[tuple[int, int, float], ...]
    payload: int | None

    def columns(self, seed: int) -> dict[str, np.ndarray]:
        """Differences of the energy columns, and of q_j for an offset, at random states."""
        names = column_names(self.arm, self.rotor)
        q, qd = random_states(self.arm, 2 * len(names) + 80, seed)
        out = dict(zip(names, energy_regressor(self.arm, q, qd, self.rotor).T, strict=True))
        at = {j: i for i, j in enumerate(self.arm.movable)}
        for j, k, ratio in self.couplings:
            out[f"IAM{k}"] = 0.5 * (qd[:, at[j]] + ratio * qd[:, at[k]]) ** 2
        if self.payload:
            for prefix in ("XX", "XY", "XZ", "YY", "YZ", "ZZ", "MX", "MY", "MZ", "M"):
                out[f"{prefix}L"] = out[f"{prefix}{self.payload}"]
        if "offset" in self.friction:
            out |= {f"OF{j}": q[:, i] for j, i in at.items()}
        return {name: column[1:] - column[0] for name, column in out.items()}


def _number(text: str, names: dict[str, float]) -> float:
    known = {"pi": math.pi, "sqrt": math.sqrt, **names}
    return float(eval(text, {"__builtins__": {}}, known))


def special_arm(family: str, seed: int) -> SpecialArm:
    """Draw an arm of a family; the same seed gives the same arm."""
    draw = random.Random(f"{family}{seed}")
    n = draw.randint(2, 5)
    geometry: dict[str, str] = {}
    if family in ("named", "expressions"):
        geometry = {"a": draw.choice(_ANGLES), "c": draw.choice(_ANGLES)}
        geometry |= {name: draw.choice(_LENGTHS) for name in ("L1", "L2", "L3")}
        if draw.random() < 0.4:
            geometry |= {"L1": "0.2", "L2": "0.4"}
        if draw.random() < 0.3:
            geometry["L2"] = geometry["L1"]
        if draw.random() < 0.3:
            geometry["c"] = geometry["a"]
    value = {name: _number(text, {}) for name, text in geometry.items()}

    def angle() -> str:
        if geometry and draw.random() < 0.5:
            return draw.choice(_NAMED_ANGLES if family == "named" else _MIXED_ANGLES)
        if family.startswith("parallel"):
            return draw.choice(["0", "0", "0", "pi", "0.3", "-0.3"])
        return draw.choice(_ANGLES if family == "irrational" else _PLAIN)

    def length() -> str:
        if geometry and draw.random() < 0.5:
            return draw.choice(_NAMED_LENGTHS)
        return "0" if draw.random() < 0.4 else draw.choice(_LENGTHS)

    slide = 0.56 if family.startswith("prismatic") else 0.2
    sigma, antecedent = [], []
    table: dict[str, list[str]] = {key: [] for key in GEOMETRY}
    for j in range(1, n + 1):
        u = draw.random()
        sigma.append(2 if u < 0.2 else 1 if u < 0.2 + slide else 0)
        before = [j - 1, j - 1, 0, draw.randrange(j)] if "tree" in family else [j - 1]
        antecedent.append(draw.choice(before))
        for key in GEOMETRY:
            rare = key in ("gamma", "b") and draw.random() < 0.7
            kind = angle if key in ("gamma", "alpha", "theta") else length
            table[key].append("0" if rare else kind())
    if all(s == 2 for s in sigma):
        sigma[0] = 0
    gravity = draw.choice(_GRAVITY).split()
    friction = draw.choice([(), ("offset",), ("coulomb", "viscous", "offset"), ("coulomb",)])
    rotor = tuple(draw.random() < 0.6 for _ in sigma)
    lines = ["[robot]", 'name = "arm"', f"gravity = {json.dumps(gravity)}"]
    if geometry:
        lines += ["[geometry]", *(f'{name} = "{text}"' for name, text in geometry.items())]
    for j in range(n):
        lines += ["[[joint]]", f"sigma = {sigma[j]}", f"antecedent = {antecedent[j]}"]
        lines += [f'{key} = "{table[key][j]}"' for key in GEOMETRY if table[key][j] != "0"]
        if sigma[j] != 2:
            words = json.dumps(list(friction))
            lines += [f"friction = {words}", f"rotor_inertia = {str(rotor[j]).lower()}"]
    couplings: tuple[tuple[int, int, float], ...] = ()
    movable = [j for j in range(1, n + 1) if sigma[j - 1] != 2]
    if "coupled" in family and len(movable) > 1:
        first, second = draw.sample(movable, 2)
        ratio = draw.choice([1.0, -1.0, 0.5, 2.0])
        couplings = ((first, second, ratio),)
        lines += ["[[coupling]]", f"joints = [{first}, {second}]", f"ratio = {ratio}"]
    payload = draw.randint(1, n) if draw.random() < 0.25 else None
    if payload:
        lines += ["[payload]", f"joint = {payload}"]
    numbers = [tuple(_number(text, value) for text in table[key]) for key in GEOMETRY]
    arm = Arm(tuple(sigma), tuple(antecedent), *numbers, gravity=tuple(map(float, gravity)))
    return SpecialArm("\n".join(lines), arm, rotor, friction, couplings, payload)

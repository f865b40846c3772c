"""Expressions of robot files, hostile and drawn: each is right, or one line, within 2 seconds."""

from __future__ import annotations

import math
import random
import time
from collections.abc import Callable

import mpmath
import numpy as np
import pytest
import sympy as sp

import symgen

pytestmark = pytest.mark.filterwarnings("ignore::symgen.SymgenWarning")  # near a fraction of pi
SECONDS = 2.0  # for one expression; each of those below takes a tenth of that or less
PLANE = """
[robot]
name = "plane"
gravity = [0.0, -9.81, 0.0]
[geometry]
L1 = 0.5
[[joint]]
{joint}
[[joint]]
d = "L1"
{effect}
"""
EFFECT = '[[effect]]\nname = "own"\njoints = [1]\ntorque = "{}"\nlinear = {{ A = "N m" }}'
TORQUE = "torque"


def robot_with(key: str, written: str) -> str:
    """A robot file with an expression at a key of joint 1, or as the torque of an effect."""
    if key == TORQUE:
        return PLANE.format(joint="", effect=EFFECT.format(written))
    return PLANE.format(joint=f'{key} = "{written}"', effect="")


def nested(function: str, depth: int, inner: str, rest: str = "") -> str:
    return f"{function}(" * depth + inner + f"{rest})" * depth


#: Refused with a line in geometry (with and without a factor A, which torques have) and in torques.
REFUSED = {
    "a tower": "9**9**9",
    "a deep tower": "(((L1**16)**16)**16)**16",
    "a long number": "9" * 900,
    "a large number": "1e101",
    "a small number": "1e-320",
    "a division by zero": "1/0",
    "a hidden division by zero": "1/(L1 - L1)",
    "zero to -1": "0**-1",
    "a root of -1": "sqrt(-1)",
    "zero by zero": "0/0",
    "nan": "nan",
    "no operand": "1 +",
    "nothing": "()",
    "10,000 terms": "+".join(["1"] * 10_000),
    "300 parentheses": "(" * 300 + "1" + ")" * 300,
    "300 signs": "-" * 300 + "1",
    "200 roots": nested("sqrt", 200, "2"),
    "a real exponent": "2**0.3",
}
#: Refused as lengths and angles.
NO_LENGTH = {
    "many products": "*".join(f"(1 + sqrt({k}))" for k in range(2, 60)) + "/1e44",
    "many quotients": "/".join(f"(1 + sqrt({k}))" for k in range(2, 60)),
    "many terms": "*".join(f"((L1 + pi + sqrt({k}))/9)**1{k}" for k in range(2, 5)),
}
#: Refused as torques.
NO_TORQUE = {
    "a large exponent": "A*pow(q1, 17)",
    "an exponential": "A*exp(1000)",
    "a pole": "A*tan(pi/2)",
    "zero to a negative power": "A*pow(0, -1)",
    **{f"200 {f}": f"A*{nested(f, 200, 'q1')}" for f in ("abs", "sign", "tan", "sin", "exp")},
    **{f"200 {f}": f"A*{nested(f, 200, 'q1', ', q2')}" for f in ("max", "min")},
    "45 tangents": f"A*{nested('tan', 45, 'q1')}",
    "many larger ones": f"A*{nested('max', 9, 'taur1', ', q2*taur1')}",
    "a load beside a position": "A*max(max(max(max(taur1, q1), q2), 2*q1), 3*q2)",
    "a long result": "A*1e99**16*q1",
    "a power without a coefficient": "A*q1 + (q1 + q2 + qd1 + qd2)**16",
    "functions without a coefficient": "A*q1 + " + "*".join(f"sin(q1 + {k})" for k in range(40)),
    "a square of the load": "A*(taur1 + q1*taur1)**2",
}
#: Right, though there is much to do: what they give AT the state below.
RIGHT = {
    "A*pow(2, 1/3)*q1": 2 ** (1 / 3) * 0.3,
    "A*pow(6, -2/3)*q1": 6 ** (-2 / 3) * 0.3,
    "A*pow(2, q1)": 2**0.3,
    "A*pow(pi, pi)*q1": math.pi**math.pi * 0.3,
    "A*pow(q2, 1/3)": 0.7 ** (1 / 3),
    "A*pow(q2, 3/2)": 0.7**1.5,
    "A*pow(q2, -3/2)": 0.7**-1.5,
    "A*q1*exp(exp(1))": 0.3 * math.exp(math.e),
    f"A*{nested('abs', 45, 'q2')}": 0.7,
    f"A*{nested('sign', 45, 'q2')}": -1.0,
    "A*max(max(q1*taur1, q2*taur1), max(qd1*taur1, qd2*taur1))": 0.6,
    "A*min(max(max(taur1, 2*taur1), 3*taur1), 4*taur1)": 3.0,
    "A*taur1*" + "*".join(f"(1 + sin({k}*q1)/{k})" for k in range(1, 30)): math.prod(
        1 + math.sin(k * 0.3) / k for k in range(1, 30)
    ),
}
AT = {"q1": "0.3", "q2": "-0.7", "qd1": "0.6", "qd2": "0.4", "taur1": "1.0", "A": "1.0"}


def read(key: str, written: str) -> symgen.Robot | None:
    """Read it, and what symgen writes of it, which is the same; None where one line refuses it."""
    begun = time.perf_counter()
    try:
        robot = symgen.parse_robot(robot_with(key, written))
    except symgen.RobotError as error:
        assert "\n" not in str(error)
        assert len(str(error)) < 1000
        assert "key" in str(error) or "effect" in str(error)
        return None
    finally:
        assert time.perf_counter() - begun < SECONDS
    assert symgen.robot_toml(symgen.parse_robot(symgen.robot_toml(robot))) == symgen.robot_toml(
        robot
    )
    return robot


def value(robot: symgen.Robot) -> float:
    """The torque of its effect AT a state."""
    torque = robot.effects[0].torque
    at = {s: sp.Rational(AT[s.name]) for s in torque.free_symbols}
    return float(torque.subs(at).evalf(20))


@pytest.fixture(scope="module", autouse=True)
def warm() -> None:
    """Load what the first robot file loads."""
    symgen.parse_robot(robot_with(TORQUE, "A*max(q1, 0)*pow(2, 1/3)"))


@pytest.mark.parametrize("key", ["d", "alpha", "r", TORQUE])
@pytest.mark.parametrize("case", REFUSED)
def test_what_has_no_value_or_no_end_is_a_line(case: str, key: str) -> None:
    assert read(key, REFUSED[case] if key != TORQUE else f"A*q1*({REFUSED[case]})") is None


@pytest.mark.parametrize("key", ["d", "alpha"])
@pytest.mark.parametrize("case", NO_LENGTH)
def test_what_is_no_length_is_a_line(case: str, key: str) -> None:
    assert read(key, NO_LENGTH[case]) is None


@pytest.mark.parametrize("case", NO_TORQUE)
def test_what_is_no_torque_is_a_line(case: str) -> None:
    assert read(TORQUE, NO_TORQUE[case]) is None


@pytest.mark.parametrize("written", RIGHT)
def test_what_is_much_is_right(written: str) -> None:
    robot = read(TORQUE, written)
    assert robot is not None
    assert value(robot) == pytest.approx(RIGHT[written], rel=1e-12)


def test_a_power_of_a_number_reaches_the_kernel() -> None:
    robot = symgen.parse_robot(robot_with(TORQUE, "A*q1**3*pow(2, 1/3)"))
    loaded = symgen.load(symgen.derive(robot, ("inverse_dynamics",)))
    X = np.zeros(len(loaded.model.base.parameters))
    X[loaded.model.base.names.index("A")] = 1.0
    tau = loaded.inverse_dynamics([0.3, 0.1], [0.0, 0.0], [0.0, 0.0], X)
    np.testing.assert_allclose(tau, [-(0.3**3) * 2 ** (1 / 3), 0.0], rtol=1e-14)


# Drawn expressions: a text of the grammar, and what mpmath computes for it.

MP = mpmath.mp.clone()
MP.dps = 60
Drawn = tuple[str, Callable[[], mpmath.mpf]]
ONE = {
    "abs": abs,
    "sign": MP.sign,
    **{name: getattr(MP, name) for name in ("sin", "cos", "tan", "tanh", "exp", "sqrt")},
}
TWO = {"min": min, "max": max, "pow": lambda x, p: MP.power(abs(x), p)}
NUMBERS = ("0", "1", "2", "0.5", "3", "1e-9", "1/3", "7", "12.5", "1e12", "16")


def drawn(draw: random.Random, depth: int) -> Drawn:
    kind = draw.choice(("leaf", "sum", "product", "quotient", "power", "one", "two", "minus"))
    if depth == 0 or kind == "leaf":
        word = draw.choice((*NUMBERS, "pi", "q1", "q2", "qd1", "qd2", "q1", "taur1"))
        number = MP.pi if word == "pi" else MP.mpf(AT.get(word, word))
        return f"({word})", lambda: number
    a, f = drawn(draw, depth - 1)
    if kind == "minus":
        return f"(-{a})", lambda: -f()
    if kind == "power":
        k = draw.choice((-3, -1, 0, 2, 3, 16, 17))
        return f"({a}**{k})", lambda: f() ** k
    if kind == "one":
        name = draw.choice(list(ONE))
        return f"{name}({a})", lambda: ONE[name](f())
    b, g = drawn(draw, depth - 1)
    if kind == "two":
        name = draw.choice(list(TWO))
        return f"{name}({a}, {b})", lambda: TWO[name](f(), g())
    sign = {"sum": draw.choice("+-"), "product": "*", "quotient": "/"}[kind]
    pairs = {
        "+": lambda: f() + g(),
        "-": lambda: f() - g(),
        "*": lambda: f() * g(),
        "/": lambda: f() / g(),
    }
    return f"({a} {sign} {b})", pairs[sign]


def test_drawn_torques_are_a_line_or_what_mpmath_computes() -> None:
    draw = random.Random(8)
    right = 0
    for _ in range(150):
        written, compute = drawn(draw, draw.randint(1, 5))
        robot = read(TORQUE, f"A*{written}")
        if robot is None:
            continue
        try:
            expected = compute()
        except (ArithmeticError, ValueError, TypeError):
            continue  # no number here: another state may have one
        if isinstance(expected, MP.mpc) or not abs(expected) < 1e9:
            continue
        assert value(robot) == pytest.approx(float(expected), rel=1e-12, abs=1e-12), written
        right += 1
    assert right > 20


@pytest.mark.parametrize("key", ["d", "alpha"])
def test_drawn_lengths_and_angles_are_a_line_or_the_same_when_written(key: str) -> None:
    draw = random.Random(9)
    words = ("L1", "pi", "sqrt(2)", "sqrt(3)", "sqrt(L1)", "0.1", "2", "1/7", "1e-3")
    kept = 0
    for _ in range(80):
        parts = [draw.choice(words)]
        for _ in range(draw.randint(0, 12)):
            parts = [f"({draw.choice('+-')}{parts[0]} {draw.choice('+-*/')} {draw.choice(words)})"]
            if draw.random() < 0.2:
                parts = [f"{parts[0]}**{draw.randint(-3, 5)}"]
        kept += read(key, parts[0]) is not None
    assert kept > 15

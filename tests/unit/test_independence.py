"""Effects that say nothing new, and those that do, by the formulas that say so."""

from __future__ import annotations

import pytest

import symgen

ARM = """
[robot]
name = "arm"
gravity = [0.0, -9.81, 0.0]
[[joint]]
friction = ["coulomb", "viscous", "offset"]
[[joint]]
d = 0.5
{more}
[[effect]]
name = "hose"
joints = {joints}
torque = "{torque}"
linear = {{ A = "N m" }}
"""


def _model(torque: str, joints: str = "[2]", more: str = "friction = []") -> object:
    return symgen.derive(symgen.parse_robot(ARM.format(torque=torque, joints=joints, more=more)))


@pytest.mark.parametrize(
    ("torque", "joints", "more"),
    [
        ("A*qd1", "[1]", "friction = []"),  # FV1
        ("3*A*sign(qd1)", "[1]", "friction = []"),  # FS1
        ("A", "[1]", "friction = []"),  # OF1
        ("A*(2 - 5*qd1)", "[1]", "friction = []"),
        ("A*(abs(qd1) - sign(qd1)*qd1)", "[1]", "friction = []"),  # zero, to the last bit
        ("A*(qd1 + sign(qd1) - 2)", "[1]", "friction = []"),
        ("A*qd2", "[2]", 'friction = ["viscous"]'),
    ],
)
def test_what_friction_and_body_say_already_is_refused(torque, joints, more) -> None:
    with pytest.raises(symgen.RobotError, match=r"effect .hose. of joint .: .* is nothing new"):
        _model(torque, joints, more)


@pytest.mark.parametrize(
    "torque",
    ["A*qd2", "A*sin(3*q2)", "A*tanh(qd2)", "A*abs(q2)", "A*exp(q2)", "A*cos(q1)", "A*qd1*q2",
     "A*sign(qd2)", "A*(qd2 + 1e-6*sin(3*q1))"],
)  # fmt: skip
def test_what_is_new_is_taken(torque: str) -> None:
    model = _model(torque)
    assert "A" in "".join(model.base.names)  # type: ignore[attr-defined]


@pytest.mark.parametrize(("share", "new"), [(1e-7, True), (1e-12, False)])
def test_a_billionth_of_a_column_is_nothing_new(share: float, new: bool) -> None:
    torque = f"A*(qd1 + {share}*sin(3*q1))"
    if new:
        _model(torque, "[1]")
    else:
        with pytest.raises(symgen.RobotError, match="is nothing new"):
            _model(torque, "[1]")


@pytest.mark.parametrize("torque", ["A/q2", "A*exp(exp(40*q2))", "A*sqrt(qd2)"])
def test_a_torque_that_is_not_finite_is_refused(torque: str) -> None:
    with pytest.raises(symgen.RobotError, match="not a finite number everywhere"):
        _model(torque)


def test_without_gravity_input_or_with_it() -> None:
    text = ARM.format(torque="A*sin(2*q1)", joints="[1]", more="friction = []")
    model = symgen.derive(symgen.parse_robot(text.replace("gravity = [0.0, -9.81, 0.0]",
                                                          'gravity = "input"')))  # fmt: skip
    assert any(name.startswith("A") for name in model.base.names)


def test_two_effects_that_are_one_are_refused_and_say_which() -> None:
    second = ARM[ARM.index("[[effect]]") :].format(joints="[2]", torque="4*B*sin(3*q2)")
    second = second.replace('"hose"', '"cable"').replace("{ A =", "{ B =")
    first = ARM.format(torque="A*sin(3*q2)", joints="[2]", more="friction = []")
    with pytest.raises(symgen.RobotError, match=r"'hose' of joint 2: A.* is nothing new"):
        symgen.derive(symgen.parse_robot(first + second))

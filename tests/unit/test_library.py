"""The library of effects: units are composed, and a table with an error is refused in one line."""

from __future__ import annotations

import pytest

from symgen.errors import RobotError
from symgen.robot.effect import definition, effect_unit

QUADRATIC = {
    "kind": "linear",
    "pattern": "velocity",
    "says": "drag",
    "torque": "-QF*qd*abs(qd)",
    "linear": {"QF": "torque/speed2"},
}


@pytest.mark.parametrize(
    ("written", "revolute", "prismatic"),
    [
        ("torque/speed2", "N m s2/rad2", "N s2/m2"),
        ("torque/speed/speed", "N m s2/rad2", "N s2/m2"),
        ("torque/speed", "N m s/rad", "N s/m"),
        ("torque/acceleration", "kg m2", "kg"),
        ("position/torque", "rad/(N m)", "m/N"),
        ("torque/position3", "N m/rad3", "N/m3"),
        ("speed", "rad/s", "m/s"),
        ("", "", ""),
    ],
)
def test_units_of_quantities_are_composed(written, revolute, prismatic):
    assert (effect_unit(written, 0), effect_unit(written, 1)) == (revolute, prismatic)


def test_a_new_law_of_friction_is_one_table():
    law = definition("quadratic_friction", QUADRATIC)
    assert law.declarable
    assert law.coefficients(3, 0) == (("QF3", "N m s2/rad2"),)


@pytest.mark.parametrize(
    ("key", "value", "accepted"),
    [
        ("kind", None, "accepted: 'linear' or 'model' or 'log'"),
        ("kind", "linaer", "accepted: 'linear' or 'model' or 'log'"),
        ("pattern", "speed", "accepted: 'velocity-sign' or"),
        ("says", None, "must be given"),
        ("says", 3, "accepted: a text"),
        ("linear", {"QF": "torque/sped"}, "accepted: torque, position, speed, acceleration"),
        ("nonlinear", {"w": [0.1, 2.0]}, "accepted: 3"),
        ("scale", {"w": "velocity"}, "accepted: 'speed' or"),
    ],
)
def test_a_wrong_table_is_refused_with_its_key_and_what_is_accepted(key, value, accepted):
    table = {k: v for k, v in {**QUADRATIC, key: value}.items() if v is not None}
    with pytest.raises(RobotError) as caught:
        definition("quadratic_friction", table)
    message = str(caught.value)
    assert message.startswith(f"[quadratic_friction], key {key!r}")
    assert accepted in message

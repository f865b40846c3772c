"""Base parameters against published tables and independent counts."""

from __future__ import annotations

import pytest
from oracles.ground_truth import TRUTH, VARIANTS
from oracles.random_arms import to_toml
from oracles.transforms import Arm
from support import robot_of, sampled

import symgen
from symgen.symbolic.base_parameters import bound


@pytest.mark.parametrize(
    ("name", "variant"),
    sampled([(n, v) for n in TRUTH for v in VARIANTS], 3, always=[(n, "ia_fric") for n in TRUTH]),
)
def test_count_equals_ground_truth(name: str, variant: str) -> None:
    entry = TRUTH[name]
    rotor, friction = VARIANTS[variant]
    robot = symgen.parse_robot(to_toml(Arm.from_table(entry), "arm", friction, rotor))
    count = len(symgen.derive(robot).base.parameters)
    assert count == entry["counts"][variant]["torque"] == entry["counts"][variant]["energy"]


def test_canonical_model_of_the_paper() -> None:
    model = symgen.derive(symgen.read_robot("planar2r"))
    assert [(p.name, p.expression) for p in model.base.parameters] == [
        ("ZZ1R", "ZZ1 + L1**2*M2"),
        ("ZZ2", "ZZ2"),
        ("MX2", "MX2"),
        ("MY2", "MY2"),
    ]


TURNED_SLIDE = """
[robot]
name = "turned_slide"
gravity = [0, 0, -9.81]
[geometry]
L1 = 0.5
L3 = 0.2
[[joint]]
alpha = "-pi/2"
d = "L1"
r = "L3"
theta = "pi/6"
[[joint]]
sigma = 1
d = "-L1"
r = "L1"
theta = "pi/6"
friction = ["coulomb", "viscous", "offset"]
"""


def test_formulas_with_roots_have_no_root_in_a_denominator() -> None:
    model = symgen.derive(symgen.parse_robot(TURNED_SLIDE))
    assert [p.expression for p in model.base.parameters[:3]] == [
        "ZZ1 + IA1 + ZZ2 - L1*sqrt(3)*MX2 + L1*MY2 - L1**2*IA2",
        "MX1 + 0.5*sqrt(3)*MX2 - 0.5*MY2 + L1*IA2",
        "MY1 + 0.5*MX2 + 0.5*sqrt(3)*MY2",
    ]


# Published: Khalil and Dombre, Modeling, Identification and Control of Robots, ch. 9, the RX 90,
# in their frames, which are those of the library; each formula is a list of its terms.
RX90 = {
    "ZZ1R": "ZZ1 + IA1 + YY2 + D3**2*M3 + YY3 + D3**2*M4 + D3**2*M5 + D3**2*M6",
    "XX2R": "XX2 - YY2 - D3**2*M3 - D3**2*M4 - D3**2*M5 - D3**2*M6",
    "XZ2R": "XZ2 - D3*MZ3",
    "ZZ2R": "ZZ2 + IA2 + D3**2*M3 + D3**2*M4 + D3**2*M5 + D3**2*M6",
    "MX2R": "MX2 + D3*M3 + D3*M4 + D3*M5 + D3*M6",
    "XX3R": "XX3 - YY3 + YY4 + 2*R4*MZ4 + R4**2*M4 + R4**2*M5 + R4**2*M6",
    "ZZ3R": "ZZ3 + YY4 + 2*R4*MZ4 + R4**2*M4 + R4**2*M5 + R4**2*M6",
    "MY3R": "MY3 + MZ4 + R4*M4 + R4*M5 + R4*M6",
    "XX4R": "XX4 - YY4 + YY5",
    "ZZ4R": "ZZ4 + YY5",
    "MY4R": "MY4 - MZ5",
    "XX5R": "XX5 - YY5 + YY6",
    "ZZ5R": "ZZ5 + YY6",
    "MY5R": "MY5 + MZ6",
    "XX6R": "XX6 - YY6",
}


def _terms(formula: str) -> set[str]:
    return set(formula.replace(" - ", " + -").split(" + "))


def test_rx90_regroups_as_published() -> None:
    base = symgen.derive(symgen.read_robot("rx90")).base
    got = {p.name: _terms(p.expression) for p in base.parameters if p.terms}
    assert got == {name: _terms(formula) for name, formula in RX90.items()}


def test_offset_of_a_vertical_prismatic_axis_joins_the_mass_and_the_rotor() -> None:
    text = """
    [robot]
    name = "scara4"
    gravity = [0, 0, "-g0"]
    [geometry]
    g0 = 9.81
    L1 = 0.5
    L2 = 0.4
    [[joint]]
    [[joint]]
    d = "L1"
    [[joint]]
    d = "L2"
    [[joint]]
    sigma = 1
    friction = ["coulomb", "viscous", "offset"]
    """
    base = symgen.derive(symgen.parse_robot(text)).base
    formula = {p.name: p.expression for p in base.parameters}
    assert formula["M4R"] == "M4 + 1/g0*OF4"
    assert formula["IA4R"] == "IA4 - 1/g0*OF4"
    assert not any(name.startswith("OF") for name in formula)


def test_the_values_of_the_file_decide_where_they_are_special() -> None:
    text = """
    [robot]
    name = "special"
    gravity = [0.0, 0.0, -9.81]
    [geometry]
    a = {a}
    L1 = 0.4
    [[joint]]
    [[joint]]
    alpha = "a"
    d = "L1"
    """
    generic = symgen.derive(symgen.parse_robot(text.format(a=0.5))).base
    special = symgen.derive(symgen.parse_robot(text.format(a=0))).base
    assert any("cos(a)" in p.expression for p in generic.parameters)
    # Parallel vertical axes: the planar arm, with its rotors.
    assert special.names[: special.inertial] == ("ZZ1R", "ZZ2", "MX2", "MY2", "IA2")
    assert special.parameters[0].expression == "ZZ1 + IA1 + 0.16*M2"
    assert len(generic.parameters) > len(special.parameters)


@pytest.mark.parametrize("name", sampled(symgen.library(), 3))
def test_bound_of_gautier_and_khalil_holds(name: str) -> None:
    robot = symgen.read_robot(name)
    assert symgen.derive(robot).base.inertial <= bound(robot)


@pytest.mark.parametrize(
    ("sigma", "most"),
    [([0], 3), ([1], 1), ([0, 0], 11), ([1, 0, 1], 14), ([0, 1], 8), ([2, 1, 0], 9),
     ([0, 2, 0], 11)],
)  # fmt: skip
def test_the_bound_counts_each_type_of_joint(sigma: list[int], most: int) -> None:
    """8 a revolute and 5 a prismatic joint, less 4, less 1 where a revolute one is first."""
    assert bound(robot_of(Arm.from_table({"sigma": sigma}))) == most


def test_generic_revolute_chain_reaches_the_bound() -> None:
    joints = "".join(
        f"[[joint]]\nalpha = {0.3 + 0.17 * j}\nd = {0.2 + 0.1 * j}\nr = {0.1 * j + 0.05}\n"
        for j in range(4)
    )
    text = f'[robot]\nname = "generic"\ngravity = [1.0, 2.0, -9.0]\n{joints}'
    robot = symgen.parse_robot(text)
    assert symgen.derive(robot).base.inertial == bound(robot) == 8 * 4 - 4 - 1


def test_commensurable_angles_share_one_circle_point() -> None:
    def count(first: str, second: str) -> int:
        text = f"""
        [robot]
        name = "angles"
        gravity = [0.0, 0.0, -9.81]
        [[joint]]
        [[joint]]
        sigma = 2
        alpha = {first}
        [[joint]]
        sigma = 2
        alpha = {second}
        [[joint]]
        sigma = 2
        alpha = {second}
        [[joint]]
        """
        return len(symgen.derive(symgen.parse_robot(text)).base.parameters)

    # -0.6 + 0.3 + 0.3 = 0: the last axis is parallel to the first only if the angles are related.
    assert count("-0.6", "0.3") < count("-0.6", "0.31")

"""SYMORO's .par: tables, variables, names without values, parameters that are numbers."""

import pytest
import sympy as sp

import symgen
from symgen.robot.formats.par import import_par

# An arm with spherical wrist, in the manner of SYMORO.
ARM = """(* Robotname = 'rx90' *)
NL = 6
NJ = 6
NF = 6
Type = 0
is_mobile = 0

(* Geometric parameters *)
ant = {0,1,2,3,4,5}
sigma = {0,0,0,0,0,0}
b = {0,0,0,0,0,0}
d = {0,0,D3,0,0,0}
r = {0,0,0,R4,0,0}
gamma = {0,0,0,0,0,0}
alpha = {0,pi/2,0,-pi/2,pi/2,-pi/2}
mu = {1,1,1,1,1,1}
theta = {th1,th2,th3,th4,th5,th6}

(* Dynamic parameters and external forces *)
XX = {XX1,XX2,XX3,XX4,XX5,XX6}
IA = {IA1,IA2,IA3,IA4,IA5,IA6}
FV = {FV1,FV2,FV3,FV4,FV5,FV6}
FX = {0,0,0,0,0,FX6}

(* Acceleration of gravity *)
G = {0,0,G3}
(* End of definition *)
"""
GEOMETRY = ("sigma", "antecedent", "gamma", "b", "alpha", "d", "theta", "r")


def changed(**entries):
    """Return the arm with other entries; a None takes one away."""
    lines = []
    for line in ARM.splitlines():
        key = line.partition("=")[0].strip()
        if key not in entries:
            lines.append(line)
        elif entries[key] is not None:
            lines.append(f"{key} = {entries[key]}")
    have = [line.partition("=")[0].strip() for line in lines]
    return "\n".join([*lines, *(f"{k} = {v}" for k, v in entries.items() if k not in have and v)])


def test_the_arm_is_that_of_the_library():
    imported = import_par(ARM)
    library = symgen.read_robot("rx90")
    for ours, theirs in zip(imported.robot.joints, library.joints, strict=True):
        assert [getattr(ours, k) for k in GEOMETRY] == [getattr(theirs, k) for k in GEOMETRY]
    assert imported.robot.gravity == library.gravity
    assert imported.parameters == ()
    got, want = (symgen.derive(r) for r in (imported.robot, library))
    assert [p.expression for p in got.base.parameters] == [
        p.expression for p in want.base.parameters
    ]


def test_names_without_values_get_different_ones_and_it_is_said():
    imported = import_par(ARM)
    values = dict(imported.robot.geometry)
    assert set(values) == {"D3", "R4"}
    assert len(set(values.values())) == 2
    assert any("not in the file" in line and "D3" in line for line in imported.assumed)


@pytest.mark.parametrize("variable", ["t2", "th2", "q2", "theta2"])
def test_an_offset_stays_when_the_variable_goes(variable):
    entry = f"{{th1,{variable} - Pi/2,th3,th4,th5,0.1 + th6}}"
    joints = import_par(changed(theta=entry)).robot.joints
    assert joints[1].theta == -sp.pi / 2
    assert joints[5].theta == sp.Rational(1, 10)


def test_prismatic_joints_and_trees():
    text = changed(
        Type="1", ant="{0,1,1,3,3,5}", sigma="{0,1,0,0,2,0}", r="{0,r2 + L2,0,R4,0,0}",
        theta="{th1,0,th3,th4,gam5,th6}", b="{0,0,B3,0,0,0}", gamma="{0,0,Pi/2,0,0,0}",
    )  # fmt: skip
    robot = import_par(text).robot
    assert [j.antecedent for j in robot.joints] == [0, 1, 1, 3, 3, 5]
    assert robot.joints[1].r == sp.Symbol("L2", real=True)
    assert robot.joints[2].gamma == sp.pi / 2
    assert robot.joints[4].friction == ()
    assert {name for name, _ in robot.geometry} == {"L2", "gam5", "B3", "D3", "R4"}


@pytest.mark.parametrize(
    ("entries", "word"),
    [
        ({"Type": "2"}, "open chain"),
        ({"ant": None}, "ant"),
        ({"ant": "{0,1,2,4,4,5}"}, "joint 4"),
        ({"d": "{0,0}"}, "d has 2 entries"),
        ({"sigma": "{2,2,2,2,2,2}"}, "theta"),
        ({"sigma": "{0,0,0,0,0,3}"}, "sigma, entry 6: '3'; accepted: 0, 1 or 2"),
        ({"theta": "{th1,th2,0,th4,th5,th6}"}, "theta, entry 3"),
        ({"theta": "{th1,2*th2,th3,th4,th5,th6}"}, "theta, entry 2"),
        ({"theta": "{th1,th2 - th1,th3,th4,th5,th6}"}, "th1"),
        ({"alpha": "{0,cos(1),0,0,0,0}"}, "cos"),
        ({"alpha": "{0,__import__('os'),0,0,0,0}"}, "__import__"),
        ({"d": "{0,0,1/0,0,0,0}"}, "joint 3"),
        ({"d": "{0,0,q2,0,0,0}"}, "q2"),
        ({"d": "{0,0,XX1,0,0,0}"}, "XX1"),
        ({"d": "{0,0,1e999,0,0,0}"}, "joint 3"),
    ],
)
def test_bad_files_are_refused_in_one_line(entries, word):
    with pytest.raises(symgen.RobotError) as caught:
        import_par(changed(**entries), "arm.par")
    message = str(caught.value)
    assert message.startswith("arm.par: ")
    assert "\n" not in message
    assert word in message


@pytest.mark.parametrize(
    ("sigma", "words"), [(None, "sigma = {...}"), ("{1e309,1qd1", "sigma, entry 1: '1e309'")]
)
def test_a_list_that_is_missing_or_does_not_end_is_refused(sigma, words):
    with pytest.raises(symgen.RobotError, match=words):
        import_par(changed(sigma=sigma))

"""Effects as columns: the same torque in every kernel, and what is refused."""

from __future__ import annotations

import re

import numpy as np
import pytest

import symgen
from symgen.robot.identifiers import is_coefficient_name

BASE = """
[robot]
name = "arm"
[[joint]]
[[joint]]
alpha = "pi/2"
[[joint]]
d = 0.4
"""
EFFECTS = """
[[effect]]
name = "gravity_spring"
joints = [2]
[[effect]]
name = "stribeck_friction"
joints = [3, 1]
nonlinear = { vs = 0.05 }
[[effect]]
name = "nonlinear_viscous_friction"
joints = [1]
nonlinear = { p = 0.6 }
[[effect]]
name = "torque_ripple"
joints = [2]
nonlinear = { k = 8 }
[[effect]]
name = "detent"
joints = [1]
torque = "-A*(q1-c)*exp(-((q1-c)/w)**2) + B*max(qd2, 0.1)*tan(q3)/(2 + cos(q1))"
linear = { A = "N m/rad", B = "N m" }
nonlinear = { c = 0.31, w = 0.18 }
"""


@pytest.fixture(scope="module")
def model() -> symgen.Model:
    return symgen.derive(symgen.parse_robot(BASE + EFFECTS), "all")


def _expected(q, qd) -> dict[str, tuple[int, float]]:
    """Column (joint, value) of every coefficient, written by hand."""
    u = (q[0] - 0.31) / 0.18
    ripple = 8 * q[1]
    return {
        "K2": (1, q[1]),
        "FST3": (2, np.sign(qd[2]) * np.exp(-((qd[2] / 0.05) ** 2))),
        "FST1": (0, np.sign(qd[0]) * np.exp(-((qd[0] / 0.05) ** 2))),
        "FVN1": (0, np.sign(qd[0]) * abs(qd[0]) ** 0.6),
        "RS2": (1, -np.sin(ripple)),
        "RC2": (1, -np.cos(ripple)),
        "A": (0, (q[0] - 0.31) * np.exp(-(u**2))),
        "B": (0, -max(qd[1], 0.1) * np.tan(q[2]) / (2 + np.cos(q[0]))),
    }


@pytest.mark.parametrize("backend", ["casadi", pytest.param("c", marks=pytest.mark.slow)])
def test_an_effect_is_the_same_column_in_every_kernel(model: symgen.Model, backend) -> None:
    evaluator = symgen.load(model, backend=backend)
    draw = np.random.default_rng(0)
    names = list(model.base.names)
    for _ in range(5):
        q, qd, qdd = draw.uniform(-1, 1, (3, 3))
        X = draw.uniform(0.1, 1, len(names))
        W = evaluator["torque_regressor"](q, qd, qdd)
        columns = _expected(q, qd)
        assert names[-len(columns) :] == list(columns)
        for name, (joint, value) in columns.items():
            expected = value * np.eye(3)[joint]
            np.testing.assert_allclose(W[:, names.index(name)], expected, atol=1e-13)
        tau = evaluator["inverse_dynamics"](q, qd, qdd, X)
        np.testing.assert_allclose(W @ X, tau, atol=1e-12)
        power = evaluator["power_regressor"](q, qd, qdd)
        np.testing.assert_allclose(power, qd @ W, atol=1e-12)
        rubbing = slice(model.inertial, None)
        np.testing.assert_allclose(evaluator["friction_power"](q, qd), power[rubbing], atol=1e-13)
        np.testing.assert_allclose(evaluator["friction_torque"](q, qd), W[:, rubbing], atol=1e-13)
        M, bias = evaluator["mass_matrix"](q, X), evaluator["bias_torque"](q, qd, X)
        np.testing.assert_allclose(M @ qdd + bias, tau, atol=1e-12)


def test_an_effect_takes_its_sign_from_the_width_of_its_joint() -> None:
    wide = BASE.replace("d = 0.4", "d = 0.4\ncoulomb_width = 0.03")
    model = symgen.derive(symgen.parse_robot(wide + EFFECTS), ["torque_regressor"])
    qd = np.array([0.02, 0.1, -0.02])
    W = symgen.load(model)["torque_regressor"](np.ones(3), qd, np.zeros(3))
    shape = np.exp(-((qd / 0.05) ** 2))
    names = list(model.base.names)
    smooth = np.tanh(qd[2] / 0.03) * shape[2]
    np.testing.assert_allclose(W[:, names.index("FST3")], [0, 0, smooth], atol=1e-13)
    np.testing.assert_allclose(W[:, names.index("FST1")], [shape[0], 0, 0], atol=1e-13)


def test_a_robot_with_effects_is_written_and_read_again(model: symgen.Model) -> None:
    assert symgen.parse_robot(symgen.robot_toml(model.robot)) == model.robot


def test_an_effect_is_identified_as_a_parameter(model: symgen.Model) -> None:
    t = np.arange(0, 20, 0.004)
    draw = np.random.default_rng(1)
    f, phase = draw.uniform(0.1, 0.9, (2, 5, 3)), draw.uniform(0, 6, (5, 3))
    q = sum(0.3 * np.sin(2 * np.pi * f[0, k] * t[:, None] + phase[k]) for k in range(5))
    spline = __import__("scipy.interpolate", fromlist=["x"]).make_interp_spline(t, q, k=5)
    qd, qdd = spline.derivative()(t), spline.derivative(2)(t)
    X = draw.uniform(0.5, 1, len(model.base.names))
    evaluator = symgen.load(model)
    tau = evaluator["inverse_dynamics"](q, qd, qdd, X)
    log = symgen.Log("made", t, q, qd, tau)
    for kind in ("torque", "momentum"):
        estimate = symgen.identify(evaluator, log, model=kind, cutoff=60.0)
        found = {p.name: p.value for p in estimate.parameters}
        for name in ("K2", "RS2", "RC2", "A", "FVN1"):
            truth = X[model.base.names.index(name)]
            assert found[name] == pytest.approx(truth, rel=0.02), (kind, name)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ('name = "torque_ripple"\njoints = [2]\nnonlinear = { k = 1 }', "RS2 is nothing new"),
        ('name = "own"\njoints = [1]\ntorque = "C*qd1"\nlinear = { C = "N" }', "C is nothing new"),
        *(
            (
                f'name = "own"\njoints = [1]\ntorque = "C*({t})"\nlinear = {{ C = "N" }}',
                "nothing new",
            )
            for t in (
                "3*sign(qd1)",
                "qd1 + sign(qd1)",
                "abs(qd1) - sign(qd1)*qd1",
                "qd1 + 1e-12*sin(3*q1)",
                "sin(3*q1)*sin(3*q1) + cos(3*q1)**2 + qd1 - 1",
            )
        ),
        ('name = "coulomb_friction"\njoints = [1]', "a word of the joint's friction: 'coulomb'"),
        ('name = "rotor_inertia"\njoints = [1]', "rotor_inertia of the joint"),
        ('name = "time_delay"\njoints = [1]', "kind log"),
        ('name = "what"\njoints = [1]', "'what' is no effect"),
        ('name = "torque_ripple"\njoints = [2]', "constants none; accepted: k"),
        ('name = "gravity_spring"\njoints = [9]', "9 is not a movable joint; accepted: 1, 2"),
        ('name = "gravity_spring"\njoints = [1, 1]', "accepted: different joints"),
        ('name = "own"\njoints = [1]\ntorque = "A*A*q1"\nlinear = { A = "N" }', "not a sum of"),
        ('name = "own"\njoints = [1]\ntorque = "A*q1 + 1"\nlinear = { A = "N" }', "not a sum of"),
        ('name = "own"\njoints = [1]\ntorque = "q1"\nlinear = { A = "N" }', "not a sum of"),
        ('name = "own"\njoints = [1]\ntorque = "A*q8"\nlinear = { A = "N" }', "found 'q8'"),
        (
            'name = "own"\njoints = [1]\ntorque = "A*q1"\nlinear = { M1 = "N" }',
            "'M1': accepted: .*not reserved",
        ),
        ('name = "own"\njoints = [1]\ntorque = "open(A)"\nlinear = { A = "N" }', "found 'open'"),
    ],
)
def test_effects_that_are_refused(table: str, message: str) -> None:
    with pytest.raises(symgen.RobotError, match=message) as caught:
        symgen.derive(symgen.parse_robot(f"{BASE}[[effect]]\n{table}\n"))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("torque", "linear", "constants", "message"),
    [
        ("energy*sin(q1)", "energy", "", "'energy': accepted: a capital letter"),
        ("JOINTS*sin(q1)", "JOINTS", "", "'JOINTS': accepted: .*not reserved"),
        ("ML*sin(q1)", "ML", "", "'ML': accepted: .*not reserved"),
        ("A*sin(q1)", "A", "A = 1", "A is declared twice"),
        ("A*sin(q1)", "A", "w = 1", "w does not occur"),
        ("A*sin(q1/w)", "A", "w = 0", "division by zero"),
        ("A*sin(q1)/(w-1)", "A", "w = 1", "division by zero"),
        ("A*pow(q1, 1000000000)", "A", "", "at most 16"),
        ("A*pow(2, 1000000000)*q1**2", "A", "", "at most 16"),
        ("A*pow(q1, p)", "A", "p = 1e9", "at most 16"),
        ("A*pow(2, p)*q1**2", "A", "p = 1e9", "at most 16"),
        ("A*pow(q1, exp(exp(exp(exp(9)))))", "A", "", "exp of a number"),
        ("A*exp(w)*q1**2", "A", "w = 1e9", "exp of a number"),
        ("A*((q1+q2)**16)**16", "A", "", "powers up to 16"),
        ("A*" + "max(q1, " * 20 + "q2" + ")" * 20, "A", "", "too many functions in each other"),
        ("A*exp(1000*q1)", "A", "", "the torque of A is not a finite number everywhere"),
        ("A*sqrt(q1) + B*sin(3*q1)", "A", "", "the torque of A is not a finite"),
    ],
)
def test_a_torque_without_value_or_end_is_refused_at_once(
    torque: str, linear: str, constants: str, message: str
) -> None:
    units = ", ".join(f'{name} = "N m"' for name in (linear, *(["B"] if "B" in torque else [])))
    text = f"[[effect]]\nname = 'own'\njoints = [1]\ntorque = '{torque}'\nlinear = {{ {units} }}\n"
    text += f"nonlinear = {{ {constants} }}\n" if constants else ""
    with pytest.raises(symgen.RobotError, match=message) as caught:
        symgen.derive(symgen.parse_robot(f"{BASE}{text}"))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("unit", ["*/ int x;", "a|b", "N\\nm", "\u00b5N", "x" * 100])
def test_a_unit_cannot_end_a_comment_or_a_table(unit: str) -> None:
    text = f'name = "own"\njoints = [1]\ntorque = "A*q1"\nlinear = {{ A = "{unit}" }}\n'
    with pytest.raises(symgen.RobotError, match="a unit in quotes"):
        symgen.parse_robot(f"{BASE}[[effect]]\n{text}")


@pytest.mark.parametrize("exponent", ["L1", "w"])
def test_a_power_is_bounded_at_the_value_of_a_length(exponent: str) -> None:
    constants = "nonlinear = { w = '2*L1' }" if exponent == "w" else ""
    text = (
        BASE.replace("[[joint]]", "[geometry]\nL1 = 1e9\n[[joint]]", 1)
        + f"""
[[effect]]
name = "own"
joints = [1]
torque = "A*pow(2, {exponent})*q1**2"
linear = {{ A = "N m" }}
{constants}
"""
    )
    with pytest.raises(symgen.RobotError, match="at most 16"):
        symgen.parse_robot(text)


def test_a_length_and_a_coefficient_of_the_library_do_not_share_a_name() -> None:
    text = BASE.replace("[[joint]]", "[geometry]\nK2 = 0.4\n[[joint]]", 1)
    with pytest.raises(symgen.RobotError, match="effect 1: K2 is declared twice"):
        symgen.parse_robot(text + '[[effect]]\nname = "gravity_spring"\njoints = [2]\n')


@pytest.mark.parametrize(
    "torque",
    ["A*pow(q1, 16)", "A*pow(q1, 4.5)", "A*pow(q1, -0.5)", "A*pow(q1, p/3)", "A*sqrt(abs(q1)**3)"],
)
def test_powers_are_written_and_read_again(torque: str) -> None:
    constants = "nonlinear = { p = 2.5 }\n" if "p/3" in torque else ""
    text = f'name = "own"\njoints = [1]\ntorque = "{torque}"\nlinear = {{ A = "N" }}\n'
    text += constants
    robot = symgen.parse_robot(f"{BASE}[[effect]]\n{text}")
    assert symgen.parse_robot(symgen.robot_toml(robot)) == robot


def test_no_word_of_the_package_is_a_coefficient() -> None:
    # A coefficient A is arm_A in C: a name of the package there would not compile, or mean that.
    robot = symgen.parse_robot(BASE + EFFECTS)
    tree = symgen.generate(symgen.derive(robot, "all"), target="c")
    paths = [p for p in tree.files if p.endswith((".c", ".h")) and "/" not in p]
    text = "".join(tree.files[p].decode() for p in paths if p != "check/arm_check.c")
    own = {p for e in robot.effects for p, _ in e.linear}
    words = set(re.findall(r"\barm_(\w+)", text)) - own
    assert {"JOINTS", "energy", "identifier", "sincos2"} <= words
    allowed = {word for word in words | {"values"} if is_coefficient_name(word)}
    assert allowed == set()


@pytest.mark.parametrize(
    "torque", ["qd1 + 1e-7*sin(3*q1)", "sign(qd1) + 1e-6*q2", "tanh(qd1)", "abs(q2)", "qd1*q2"]
)
def test_a_column_that_differs_by_a_millionth_is_new(torque: str) -> None:
    text = f'name = "own"\njoints = [1]\ntorque = "C*({torque})"\nlinear = {{ C = "N" }}\n'
    assert "C" in symgen.derive(symgen.parse_robot(f"{BASE}[[effect]]\n{text}")).base.names


def test_two_effects_that_are_one_are_refused_and_say_which() -> None:
    text = ""
    for name, torque in (("hose", "A*sin(3*q2)"), ("cable", "4*B*sin(3*q2)")):
        text += f'[[effect]]\nname = "{name}"\njoints = [2]\ntorque = "{torque}"\n'
        text += f'linear = {{ {torque.split("*sin")[0][-1]} = "N m" }}\n'
    with pytest.raises(symgen.RobotError, match=r"'hose' of joint 2: A.* is nothing new"):
        symgen.derive(symgen.parse_robot(BASE + text))


def test_an_effect_stands_once() -> None:
    with pytest.raises(symgen.RobotError, match="effect 6: K2 is declared twice"):
        symgen.parse_robot(BASE + EFFECTS + '[[effect]]\nname = "gravity_spring"\njoints = [2]\n')


@pytest.mark.parametrize(
    "torque",
    ["-A*(q1-c)*exp(-((q1-c)/w)**2)", "A*3*(q1-c)*q1*w", "A*(q1-c)/-(q1+w)*sin(2*(q1-c)*q1)"],
)
def test_a_torque_is_written_and_read_again_as_it_is(torque: str) -> None:
    effect = f"""
[[effect]]
name = "own"
joints = [1]
torque = "{torque}"
linear = {{ A = "N m" }}
nonlinear = {{ c = 0.3, w = 7 }}
"""
    robot = symgen.parse_robot(BASE + effect)
    text = symgen.robot_toml(robot)
    assert symgen.parse_robot(text) == robot
    assert symgen.robot_toml(symgen.parse_robot(text)) == text


@pytest.mark.parametrize("root", ["sqrt(1/3 - pi)", "sin(sqrt(1/3 - pi))", "(-2 - q1**2)**(1/2)"])
def test_a_torque_without_a_real_value_is_refused(root: str) -> None:
    effect = EFFECTS.split("[[effect]]")[-1].replace("-A*", f"A*{root}*")
    with pytest.raises(symgen.SymgenError, match="finite real"):
        symgen.parse_robot(f"{BASE}[[effect]]{effect}")


@pytest.mark.parametrize("torque", ["-A/q1", "-A*pow(q1, -1)", "-A*qd1/(q2*q2)"])
def test_a_torque_with_a_pole_at_the_zero_of_a_joint_is_refused(torque: str) -> None:
    text = (
        f'[[effect]]\nname = "pole"\njoints = [1]\ntorque = "{torque}"\nlinear = {{ A = "N m" }}\n'
    )
    with pytest.raises(symgen.RobotError, match="not a finite number everywhere"):
        symgen.derive(symgen.parse_robot(BASE + text))

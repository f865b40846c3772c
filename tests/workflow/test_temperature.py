"""Friction that changes with a measured temperature: found, declared, predicted, simulated.

The arm is the paper's with gravity, its rigid torques from closed forms; friction, its change and
the course of the temperature are written here.
"""

from __future__ import annotations

import numpy as np
import pytest
from oracles import planar2r

import symgen
from symgen.errors import LogError, ParameterError, RobotError

X, L1, STEP = np.array([1.702, 0.05644, 0.15, 0.075]), 0.5, 0.002
FS, FV = np.array([1.0, 0.4]), np.array([0.6, 0.25])
FST, FVT = -0.012, -0.008  # of joint 2, N m/degC and N m s/rad/degC
ROBOT = planar2r.robot_toml("warm")


def log(
    name: str, seed: int, start: float, end: float, *, known: bool = True, size: float = 1.0
) -> symgen.Log:
    """A log of 20 s over which joint 2 warms up, or cools down, and stirs about that a little."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 20.0, STEP)
    w = np.array([[0.9, 1.3], [2.1, 2.7], [3.7, 4.6]])
    a, phase = np.array([[0.7], [0.35], [0.2]]), rng.uniform(0, 2 * np.pi, w.shape)
    angle = t[:, None, None] * w + phase
    waves = (a * np.sin(angle), a * w * np.cos(angle), -a * w**2 * np.sin(angle))
    q, qd, qdd = (x.sum(axis=1) for x in waves)
    warm = end + (start - end) * np.exp(-t / 8) + 2 * np.sin(0.5 * t)
    tau = np.array([planar2r.inverse_dynamics(*s, X, L1) for s in zip(q, qd, qdd, strict=True)])
    tau += FS * np.sign(qd) + FV * qd
    tau[:, 1] += (FST * np.sign(qd[:, 1]) + FVT * qd[:, 1]) * (size * (warm - 30.0))
    tau += 0.01 * np.std(tau, axis=0) * rng.normal(size=tau.shape)
    told = np.column_stack([np.full(len(t), np.nan), np.round(warm, 1)]) if known else None
    return symgen.make_log(name, t, q + 1e-6 * rng.normal(size=q.shape), tau, qd, temp=told)


@pytest.fixture(scope="module")
def answer() -> symgen.Diagnosis:
    train = [log("train", 1, 20.0, 45.0), log("more", 3, 44.0, 30.0)]
    return symgen.diagnose(
        symgen.parse_robot(ROBOT), train, validation=[log("test", 2, 25.0, 50.0)]
    )


def test_it_is_named_with_its_coefficients(answer) -> None:
    assert [(e.name, e.joints) for e in answer.effects] == [("temperature_friction", (2,))]
    values = {p.name: p for p in answer.effects[0].parameters}
    for name, true in (("FST2", FST), ("FVT2", FVT)):
        assert values[name].value == pytest.approx(true, rel=0.1)
        assert abs(values[name].value - true) < 4 * values[name].std
    assert values["T02"].unit == "degC"
    assert answer.verdict == "explained"


def test_its_robot_file_is_read_again_and_predicts(answer, tmp_path) -> None:
    text = symgen.robot_toml(answer.extended)
    again = symgen.parse_robot(text)
    assert again == answer.extended
    parameters = tmp_path / "parameters.toml"
    lines = (f"{p.name} = {p.value!r}\n" for p in answer.parameters)
    parameters.write_text("[parameters]\n" + "".join(lines))
    cold = log("cold", 5, 10.0, 12.0)
    with_it = symgen.predict(again, cold, parameters)
    without = symgen.predict(symgen.parse_robot(ROBOT), cold, parameters)
    assert with_it.error.per_joint[1] < 0.05 < 0.1 < without.error.per_joint[1]
    # measured is what was measured, predicted is that of the temperature
    middle = slice(500, -500)
    rms = [np.std(p.torque.measured[middle, 1]) for p in (with_it, without)]
    assert rms[0] == pytest.approx(rms[1], rel=1e-9)
    estimate = symgen.identify(again, [log("a", 6, 15.0, 50.0)], model="torque")
    assert estimate.torque_validation.per_joint[1] < 0.05


def test_a_log_without_the_column_is_refused_in_a_line(answer, tmp_path) -> None:
    parameters = tmp_path / "parameters.toml"
    parameters.write_text("[parameters]\nFS1 = 1.0\n")
    with pytest.raises(LogError, match=r"temperature_friction on joint 2.*no column temp2"):
        symgen.predict(answer.extended, log("bare", 5, 10.0, 12.0, known=False), parameters)


def test_friction_that_does_not_follow_the_temperature_is_none_of_it() -> None:
    found = symgen.diagnose(
        symgen.parse_robot(ROBOT),
        [log("train", 1, 20.0, 45.0, size=0.0)],
        validation=[log("test", 2, 25.0, 50.0, size=0.0)],
    )
    assert found.verdict == "consistent"


def test_without_temperatures_it_is_no_candidate() -> None:
    found = symgen.diagnose(
        symgen.parse_robot(ROBOT),
        [log("train", 1, 20.0, 45.0, known=False)],
        validation=[log("test", 2, 25.0, 50.0, known=False)],
    )
    listed = [*(e.name for e in found.effects), *(r.name for r in found.rejected)]
    assert "temperature_friction" not in listed


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ("", "values.*none; accepted: .*FST, FVT, T0"),
        ("values = { FST = 1, FVT = 1 }", "values.*FST, FVT; accepted: .*FST, FVT, T0"),
        ("nonlinear = { T0 = 20 }", "values alone"),
        ('values = { FST = 1, FVT = 1, T0 = "x" }', "values"),
    ],
)
def test_a_declaration_without_its_values_is_refused(keys, said) -> None:
    text = f'{ROBOT}[[effect]]\nname = "temperature_friction"\njoints = [2]\n{keys}\n'
    with pytest.raises(RobotError, match=said):
        symgen.parse_robot(text)


def test_a_simulated_robot_warms_up(tmp_path) -> None:
    declared = (
        f'{ROBOT}[[effect]]\nname = "temperature_friction"\njoints = [2]\n'
        f"values = {{ FST = {FST}, FVT = {FVT}, T0 = 30.0 }}\n[limits]\n"
        "position = [[-1.5, 1.5], [-1.5, 1.5]]\nvelocity = [3.0, 3.0]\nacceleration = [9.0, 9.0]\n"
    )
    robot = symgen.parse_robot(declared)
    evaluator = symgen.load(symgen.derive(robot, "all"))
    values = {"ZZ1R": 2.0, "ZZ2R": 0.3, "FS1": 1.0, "FV1": 0.6, "FS2": 0.4, "FV2": 0.25}
    X0 = [values.get(name, 0.1) for name in evaluator.model.base.names]
    made = [
        symgen.simulate(evaluator, X0, duration=6.0, temperature=course)
        for course in ((30.0, 30.0, 10.0), (30.0, 60.0, 10.0))
    ]
    log_ = made[1].log()
    np.testing.assert_allclose(log_.temp[:, 1], 60 - 30 * np.exp(-log_.t / 10), rtol=1e-12)
    np.testing.assert_array_equal(made[0].q, made[1].q)
    more = made[1].tau[0] - made[0].tau[0]
    qd = made[0].qd[0][:, 1]
    wanted = (FST * np.sign(qd) + FVT * qd) * (log_.temp[:, 1] - 30)
    np.testing.assert_allclose(more[:, 1], wanted, atol=1e-9)
    np.testing.assert_allclose(more[:, 0], 0, atol=1e-9)
    path = tmp_path / "log.csv"
    path.write_bytes(made[1].file())
    again = symgen.read_log(path)
    np.testing.assert_allclose(again.temp, log_.temp, rtol=1e-11)
    with pytest.raises(ParameterError, match="temperature"):
        symgen.simulate(evaluator, X0, duration=6.0)

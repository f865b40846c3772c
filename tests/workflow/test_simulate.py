"""symgen simulate: motions against SciPy, Pinocchio and analytic results; what logs show."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from oracles.pinocchio_arm import PinocchioArm
from oracles.random_arms import random_arm, random_parameters
from oracles.transforms import LINK_PARAMETERS, Arm
from scipy.integrate import solve_ivp
from scipy.special import ellipj, ellipk
from support import MOVED, robot_of, sampled

import symgen
from symgen import Controller, Instruments, Recording
from symgen.experiment.reference import fourier, make_reference

SLIDER = """
[robot]
name = "slider"
gravity = [0, 0, 0]
[[joint]]
sigma = 1
rotor_inertia = false
friction = ["coulomb"]
{more}
"""
M, FS = 2.0, 1.5


def _slider(more: str = "") -> symgen.Evaluator:
    return _evaluator(symgen.parse_robot(SLIDER.format(more=more)))


def _evaluator(robot: symgen.Robot) -> symgen.Evaluator:
    return symgen.load(symgen.derive(robot, ("inverse_dynamics", "mass_matrix")))


def _values(arm: Arm, links: np.ndarray, rotor: np.ndarray | None = None) -> dict[str, float]:
    out = {
        f"{name}{j + 1}": float(x)
        for j, link in enumerate(links)
        for name, x in zip(LINK_PARAMETERS, link, strict=True)
    }
    rotors = np.zeros(arm.n) if rotor is None else rotor
    return out | {f"IA{j}": float(x) for j, x in zip(arm.movable, rotors, strict=True)}


def _played(t: np.ndarray, tau: np.ndarray) -> symgen.Log:
    """A log at rest at zero, whose torques are played."""
    zero = np.zeros_like(tau)
    return symgen.make_log("torques", t, zero, tau, zero)


@pytest.fixture(scope="module")
def arm() -> tuple[Arm, np.ndarray, np.ndarray]:
    """A random serial arm of four joints, one of them prismatic, with its parameters."""
    found = next(
        a
        for a in (random_arm(seed, 4, 4, tree=False, fixed=False) for seed in range(100))
        if sum(a.sigma) == 1
    )
    return found, *random_parameters(found, 5)


def test_a_torque_driven_arm_moves_as_scipy_and_pinocchio_say(arm) -> None:
    table, links, rotor = arm
    t = np.arange(0, 1.005, 0.01)
    tau = np.sin(np.outer(t, [3.0, 4.0, 5.0, 6.0])) * [20.0, 20.0, 5.0, 5.0]
    given = robot_of(table), _values(table, links, rotor)
    done = symgen.simulate(*given, torque=_played(t, tau))

    oracle = PinocchioArm(table, links, rotor)
    zero = np.zeros(4)

    def rate(at: float, x: np.ndarray) -> np.ndarray:
        torque = np.array([np.interp(at, t, tau[:, j]) for j in range(4)])
        bias = oracle.inverse_dynamics(x[:4], x[4:], zero)
        return np.concatenate([x[4:], np.linalg.solve(oracle.mass_matrix(x[:4]), torque - bias)])

    states = [np.zeros(8)]
    for begin, end in pairwise(t):  # the torque bends at every stamp
        found = solve_ivp(rate, (begin, end), states[-1], "DOP853", rtol=1e-11, atol=1e-12)
        states.append(found.y[:, -1])
    expected = np.array(states)
    assert np.abs(np.hstack([done.q[0], done.qd[0]]) - expected).max() < 1e-5


def test_a_free_arm_without_friction_keeps_its_energy_for_ten_seconds(arm) -> None:
    table, links, rotor = arm
    # The prismatic joint would fall for ever.
    flat = Arm.from_table({**vars(table), "sigma": [0, 0, 0, 0]})
    t = np.arange(0, 10.005, 0.01)
    done = symgen.simulate(
        robot_of(flat),
        _values(flat, links, rotor),
        torque=_played(t, np.zeros((len(t), 4))),
        initial=([0.3, -0.4, 0.5, 0.1], [1.0, -2.0, 1.5, 1.0]),
    )
    oracle = PinocchioArm(flat, links, rotor)
    kinetic = [oracle.kinetic_energy(q, v) for q, v in zip(done.q[0], done.qd[0], strict=True)]
    energy = np.array(kinetic) + [oracle.potential_energy(q) for q in done.q[0]]
    assert np.ptp(energy) < 1e-3 * max(kinetic)


def test_a_pendulum_follows_the_elliptic_functions() -> None:
    robot = symgen.parse_robot(
        '[robot]\nname = "pendulum"\ngravity = [9.81, 0, 0]\n[[joint]]\nfriction = []\n'
        "rotor_inertia = false\n"
    )
    inertia, moment, swing = 0.5, 0.8, 2.5
    t = np.arange(0, 5.001, 0.01)
    done = symgen.simulate(
        robot,
        {"ZZ1": inertia, "MX1": moment, "MY1": 0.0},
        torque=_played(t, np.zeros((len(t), 1))),
        initial=([swing], [0.0]),
    )
    w, k = np.sqrt(9.81 * moment / inertia), np.sin(swing / 2)
    sn = ellipj(ellipk(k**2) - w * t, k**2)[0]
    expected = 2 * np.arcsin(k * sn)
    assert np.abs(done.q[0, :, 0] - expected).max() < 1e-4


def test_a_load_above_the_friction_accelerates_by_the_difference() -> None:
    t = np.arange(0, 1.0005, 1e-3)
    tau = np.full((len(t), 1), -1.001 * FS)
    done = symgen.simulate(_slider(), {"M1": M, "FS1": FS}, torque=_played(t, tau))
    assert np.abs(done.q[0, :, 0] + 0.001 * FS / M * t**2 / 2).max() < 1e-4


@pytest.mark.parametrize("width", [1e-3, 1e-5])
def test_a_joint_held_by_its_friction_creeps_by_less_than_its_width(width: float) -> None:
    t = np.arange(0, 10.005, 0.01)
    tau = np.full((len(t), 1), 0.8 * FS)
    done = symgen.simulate(_slider(), {"M1": M, "FS1": FS}, torque=_played(t, tau), width=width)
    # FS tanh(v/width) = 0.8 FS
    assert done.q[0, -1, 0] == pytest.approx(10 * width * np.arctanh(0.8), rel=0.02)


COUPLED = """
[robot]
name = "wrist"
gravity = [0, 0, 0]
[[joint]]
rotor_inertia = true
friction = []
[[joint]]
alpha = "pi/2"
friction = []
[[coupling]]
joints = [1, 2]
ratio = 2.0
"""


def test_the_friction_of_a_coupled_drive_holds_both_joints_together() -> None:
    t = np.arange(0, 1.005, 0.01)
    tau = np.full((len(t), 2), [0.4, 0.8])  # along the drive, below its friction
    values = {"ZZ1R": 1.0, "XX2R": 0.0, "ZZ2": 1.0, "IAM2": 0.1, "FSM2": 1.0}
    robot = symgen.parse_robot(COUPLED)
    known = symgen.derive(robot).base.names
    X = [values.get(name, 0.0) for name in known]
    done = symgen.simulate(robot, X, torque=_played(t, tau))
    drive = done.q[0] @ [1.0, 2.0]
    assert abs(drive[-1]) < 2e-5


# --- controllers ---------------------------------------------------------------------------------

ELBOW = """
[robot]
name = "elbow"
[geometry]
L2 = 0.4
[[joint]]
friction = {friction}
[[joint]]
alpha = "pi/2"
friction = {friction}
coulomb_width = {width}
[[joint]]
d = "L2"
friction = {friction}
[limits]
velocity = [3.0, 3.0, 3.0]
torque = [60.0, 60.0, 60.0]
"""


def _elbow(friction: str, width: float = 0.0) -> tuple[symgen.Evaluator, np.ndarray]:
    robot = symgen.parse_robot(ELBOW.format(friction=friction, width=width))
    evaluator = symgen.load(symgen.derive(robot, MOVED))
    table = random_arm(1, 3, 3, tree=False, fixed=False)
    links, rotor = random_parameters(table, 8)
    given = {"FS": 0.6, "FV": 0.4, "OF": 0.2}
    values = _values(table, links, rotor) | {
        f"{k}{j}": x for k, x in given.items() for j in (1, 2, 3)
    }
    known = {p.name for p in evaluator.model.base.standard}
    from symgen.identification.parameters import base_values

    kept = {k: v for k, v in values.items() if k in known}
    return evaluator, base_values(kept, evaluator.model, "test")


@pytest.fixture(scope="module")
def elbow() -> tuple[symgen.Evaluator, np.ndarray]:
    return _elbow('["viscous", "offset"]')


@pytest.fixture(scope="module")
def clean(elbow) -> list[symgen.Log]:
    evaluator, X = elbow
    return [
        symgen.simulate(evaluator, X, duration=10, recording=Recording(rate=250), seed=s).log()
        for s in (1, 2)
    ]


@pytest.mark.parametrize("model", sampled(["energy", "momentum", "torque"], 2))
def test_a_log_without_noise_returns_the_parameters(elbow, clean, model: str) -> None:
    evaluator, X = elbow
    estimate = symgen.identify(evaluator, clean, model=model)
    assert np.abs(estimate.X / X - 1).max() < 1e-4


@pytest.mark.rounding
def test_a_log_with_dry_friction_returns_the_parameters_by_energy() -> None:
    evaluator, X = _elbow('["coulomb", "viscous"]')
    logs = [
        symgen.simulate(evaluator, X, duration=10, recording=Recording(rate=250), seed=s).log()
        for s in (1, 2)
    ]
    estimate = symgen.identify(evaluator, logs, model="energy")  # folds prefer it by 0.4 % alone
    # Friction changes its sign between samples: 2e-4 of the smallest parameter at any accuracy of
    # the simulation, of which integration and rounding add 1e-5.
    assert np.abs(estimate.X / X - 1).max() < 3e-4
    std = np.array([p.std for p in estimate.parameters])
    assert (np.abs(estimate.X - X) < 3 * std).all()


def test_a_computed_torque_that_knows_all_follows_exactly_and_one_that_does_not_is_off(
    elbow,
) -> None:
    evaluator, X = elbow
    aim = fourier(evaluator.model.robot, duration=2.0, rate=200, seed=3)
    exact = symgen.simulate(evaluator, X, trajectory=aim)
    assert np.abs(exact.q[0] - aim.q).max() < 1e-5
    for kind in ("computed-torque", "pd"):
        made = Recording(controller=Controller(kind, scale=1.2))
        wrong = symgen.simulate(evaluator, X, trajectory=aim, recording=made)
        assert 1e-4 < np.abs(wrong.q[0] - aim.q).max() < 0.1


def test_the_fourier_series_keeps_the_limits_and_begins_and_ends_at_rest() -> None:
    text = ELBOW.format(friction="[]", width=0.0) + (
        "position = [[-1.0, 2.0], [-0.2, 0.2], [0.5, 3.0]]\nacceleration = [5.0, 4.0, 30.0]\n"
    )
    robot = symgen.parse_robot(text)
    aim = fourier(robot, duration=20.0, rate=500, seed=2)
    low, high = np.array(robot.limits.position).T
    assert (aim.q >= low).all()
    assert (aim.q <= high).all()
    assert (np.abs(aim.qd) <= robot.limits.velocity).all()
    assert (np.abs(aim.qdd) <= robot.limits.acceleration).all()
    for x in (aim.qd, aim.qdd):
        assert np.abs(x[[0, -1]]).max() < 1e-9
    assert np.abs(np.gradient(aim.q, aim.t, axis=0) - aim.qd)[1:-1].max() < 1e-3


def test_a_reference_keeps_a_polynomial_of_degree_five_between_its_stamps() -> None:
    t = np.array([0.0, 0.4, 1.0, 1.7])
    curve = np.polynomial.Polynomial([0.3, -0.2, 0.5, 0.1, -0.4, 0.2])
    slopes = [curve.deriv(order) if order else curve for order in range(3)]
    aim = make_reference("curve", t, *(c(t)[:, None] for c in slopes))
    at = np.linspace(0, 1.7, 50)
    expected = np.array([c(at) for c in slopes]).T
    assert np.abs(aim.at(at)[:, :, 0] - expected).max() < 1e-12
    rest = aim.at(np.array([-1.0, 3.0]))[:, :, 0]
    assert np.allclose(rest, [[curve(0.0), 0, 0], [curve(1.7), 0, 0]], atol=1e-12)


def test_a_digital_controller_acts_as_the_sampled_double_integrator_does() -> None:
    evaluator = _slider()
    t = np.arange(0, 1.0005, 0.01)
    one = np.ones((len(t), 1))
    step = make_reference("step", t, one, 0 * one, 0 * one)
    controller = Controller("pd", bandwidth=10.0, damping=0.8, feedback="measured")
    done = symgen.simulate(
        evaluator,
        {"M1": M, "FS1": 0.0},
        trajectory=step,
        recording=Recording(controller=controller),
        initial=([0.0], [0.0]),
    )
    q = v = 0.0
    for k in range(len(t)):
        tau = M * (100 * (1 - q) - 16 * v)
        assert done.q[0, k, 0] == pytest.approx(q, abs=1e-6)
        assert done.tau[0, k, 0] == pytest.approx(tau, abs=1e-3)
        q, v = q + 0.01 * v + 0.01**2 * tau / M / 2, v + 0.01 * tau / M


# --- instruments ---------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def ramp() -> tuple[symgen.Evaluator, symgen.Log]:
    t = np.arange(0, 10.005, 0.01)
    return _slider(), _played(t, np.full((len(t), 1), 2 * FS))


def test_instruments_have_the_errors_that_they_declare(ramp) -> None:
    evaluator, log = ramp
    tools = Instruments(
        encoder_step=1.2345e-3,
        velocity_noise=0.02,
        velocity_gain=1.05,
        torque_noise=0.1,
        torque_noise_relative=0.01,
    )
    done = symgen.simulate(
        evaluator, {"M1": M, "FS1": FS}, torque=log, recording=Recording(tools), runs=4
    )
    error = done.q_log - done.q
    assert np.abs(error).max() <= 0.5 * 1.2345e-3 * (1 + 1e-9)
    counts = done.q_log / 1.2345e-3
    assert np.allclose(counts, np.round(counts), atol=1e-6)
    assert error.std() == pytest.approx(1.2345e-3 / np.sqrt(12), rel=0.05)
    assert (done.qd_log - 1.05 * done.qd).std() == pytest.approx(0.02, rel=0.05)
    assert (done.tau_log - done.tau).std() == pytest.approx(0.1 + 0.01 * 2 * FS, rel=0.05)
    lag = np.corrcoef((done.qd_log - 1.05 * done.qd)[:, :, 0])
    assert np.abs(lag[np.triu_indices(4, 1)]).max() < 0.15


@pytest.mark.parametrize("delay", [0.02, 0.034])
def test_a_delay_shows_the_motion_of_before(ramp, delay: float) -> None:
    evaluator, log = ramp
    made = Recording(Instruments(delay=delay))
    done = symgen.simulate(evaluator, {"M1": M, "FS1": FS}, torque=log, recording=made)
    then = np.maximum(done.t - delay, 0.0)
    assert np.abs(done.q_log[0, :, 0] - FS / M * then**2 / 2).max() < 1e-3
    assert np.abs(done.qd_log[0, :, 0] - FS / M * then).max() < 1e-3
    assert np.array_equal(done.tau_log, done.tau)


NOISE = Instruments(encoder_step=1e-4, position_noise=1e-4, velocity_noise=1e-2, torque_noise=0.1)


def test_a_run_is_the_same_to_the_last_bit_alone_and_among_others() -> None:
    evaluator, X = _elbow('["coulomb", "viscous"]')
    options = {
        "trajectory": fourier(evaluator.model.robot, duration=0.3, rate=1000),
        "recording": Recording(NOISE, Controller(feedback="measured"), (0.5, 0.5, 0.1)),
        "seed": 5,
    }
    many, again, few = (symgen.simulate(evaluator, X, runs=runs, **options) for runs in (6, 6, 2))
    for run in range(6):
        assert many.file(run) == again.file(run)
    for run in range(2):
        assert many.file(run) == few.file(run)
    assert many.file(0) != many.file(1)
    other = symgen.simulate(evaluator, X, runs=1, **(options | {"seed": 6}))
    assert other.file(0) != many.file(0)


# --- what is refused, and the command line -------------------------------------------------------


def test_parameters_of_no_robot_are_refused_with_the_time(elbow) -> None:
    evaluator, X = elbow
    bad = X.copy()
    bad[evaluator.model.base.names.index("ZZ1R")] = -5.0
    with pytest.raises(symgen.ParameterError, match="t = 0 s"):
        symgen.simulate(evaluator, bad, duration=1)


def test_friction_that_drives_at_rest_is_refused(ramp) -> None:
    with pytest.raises(symgen.ParameterError, match="FS1"):
        symgen.simulate(ramp[0], {"M1": M, "FS1": -0.1}, torque=ramp[1])


def test_a_motion_that_explodes_is_refused_with_joint_and_time() -> None:
    robot = symgen.parse_robot(SLIDER.format(more="").replace("coulomb", "viscous"))
    t = np.arange(0, 2.0, 1e-3)
    with pytest.raises(symgen.ParameterError, match=r"t = 0\.\d+ s"):
        symgen.simulate(robot, {"M1": 1.0, "FV1": -30.0}, torque=_played(t, 0 * t[:, None] + 1))


def test_torque_beyond_the_limits_is_refused(elbow) -> None:
    evaluator, X = elbow
    heavy = 20 * X
    with pytest.raises(symgen.ParameterError, match=r"joint \d needs .* allow 60.*accepted"):
        symgen.simulate(evaluator, heavy, duration=1, recording=Recording(rate=200))


PARAMETERS = "[parameters]\nM1 = 2.0\nFS1 = 1.5\n"


@pytest.fixture
def files(tmp_path: Path) -> list[str]:
    (tmp_path / "slider.toml").write_text(SLIDER.format(more=""))
    (tmp_path / "P.toml").write_text(PARAMETERS)
    return ["simulate", str(tmp_path / "slider.toml"), "--parameters", str(tmp_path / "P.toml")]


def test_the_command_writes_logs_that_symgen_reads(files, tmp_path: Path, command) -> None:
    out = tmp_path / "new" / "log.csv"
    more = ["--duration", "2", "--rate", "200", "--encoder", "1e-5", "--runs", "2"]
    assert command(*files, *more, "--into", out)[0] == 0
    assert sorted(p.name for p in out.parent.iterdir()) == ["log_1.csv", "log_2.csv"]
    log = symgen.read_log(out.with_name("log_1.csv"), 1)
    assert len(log.t) == 401
    again = tmp_path / "again.npz"
    assert command(*files, *more[:-2], "--into", again)[0] == 0
    assert np.allclose(symgen.read_log(again, 1).q, log.q, rtol=1e-11)


@pytest.mark.parametrize(
    ("more", "told"),
    [
        (["--into", "log.txt"], ".csv or .npz"),
        (["--into", "P.toml.csv"], "a new file"),
        (["--into", "x.csv", "--trajectory", "nowhere.csv"], "nowhere.csv"),
        (["--into", "x.csv", "--controller", "pid"], "computed-torque, pd"),
        (["--into", "x.csv", "--encoder", "-1"], "0 or more"),
        (["--into", "x.csv", "--runs", "0"], "1 run or more"),
        (["--into", "x.csv", "--duration", "nan"], "samples"),
        (["--into", "x.csv", "--torque", "tau.csv", "--trajectory", "q.csv"], "one of the two"),
    ],
)
def test_what_cannot_be_is_one_line_and_no_file(
    files, tmp_path: Path, monkeypatch, command, more: list[str], told: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("P.toml.csv").write_text("mine")
    before = sorted(tmp_path.iterdir())
    code, _, err = command(*files, *more)
    assert code == 2
    error = [line for line in err.splitlines() if "error:" in line]
    assert len(error) == 1
    assert told in error[0]
    assert sorted(tmp_path.iterdir()) == before
    assert Path("P.toml.csv").read_text() == "mine"


def test_a_trajectory_file_is_followed_and_torques_are_played(files, tmp_path, command) -> None:
    t = np.arange(0, 1.0005, 0.01)
    wanted = 0.1 * np.sin(3 * t) ** 3
    rows = [f"{a:.12g},{b:.12g}" for a, b in zip(t, wanted, strict=True)]
    (tmp_path / "q.csv").write_text("\n".join(["t,q1", *rows]))
    out = tmp_path / "a.csv"
    fast = ["--trajectory", tmp_path / "q.csv", "--bandwidth", "300"]
    assert command(*files, *fast, "--into", out)[0] == 0
    log = symgen.read_log(out, 1)
    assert np.abs(log.q[:, 0] - wanted).max() < 1e-4
    assert command(*files, "--torque", out, "--into", tmp_path / "b.csv")[0] == 0
    replayed = symgen.read_log(tmp_path / "b.csv", 1)
    assert np.abs(replayed.q - log.q).max() < 0.01

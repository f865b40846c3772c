"""Make the logs of tests/logs: robots in which something is hidden, by simulators of the tests.

`python tests/studies/make_logs.py [CASE ...]` writes CASE.npz, of all cases of STORED without one.
A file has what the user believes (`robot`), parameters of the robot before, or "", and two logs of
`rate` Hz as a recorder counts them: `train_q` (n, N) and the others are second differences of
counts, `train_q_step` is what one count is.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

TESTS = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(TESTS))

from oracles import planar2r  # noqa: E402
from oracles.arm import Arm, X  # noqa: E402
from oracles.arm import sines as waves  # noqa: E402
from oracles.hidden.engines import PinocchioEngine  # noqa: E402
from oracles.hidden.machines import MACHINES, Machine  # noqa: E402
from oracles.hidden.motion import STEP, generator  # noqa: E402
from oracles.hidden.simulate import simulate  # noqa: E402
from studies import backlash, stiction  # noqa: E402
from studies.hidden.cases import case  # noqa: E402
from studies.hidden.sizes import rms  # noqa: E402

Log = dict[str, np.ndarray]
Logs = dict[str, object]
PLANAR, ARM = MACHINES["planar2r"], MACHINES["arm3r"]
KINDS = {"train": "train", "validation": "test"}
CARRIED = 0.5  # share of the weight


def counted(robot: str, logs: dict[str, Log], rate: float, parameters: str = "") -> Logs:
    """Return what a file holds, every log at about `rate`."""
    out: Logs = {"robot": robot, "parameters": parameters}
    for kind, log in logs.items():
        step = float(log["t"][1] - log["t"][0])
        every = max(1, round(1 / (rate * step)))
        out["rate"] = 1 / (every * step)
        steps = {"q": 2e-5, "qs": 2e-5, "qd": 1e-3, "tau": 1e-3 * np.abs(log["tau"]).max()}
        for key in steps.keys() & log.keys():
            counts = np.round(np.asarray(log[key])[::every].T / steps[key]).astype(np.int32)
            begin = np.zeros((len(counts), 2), np.int32)
            out[f"{kind}_{key}"] = np.diff(counts, 2, prepend=begin)
            out[f"{kind}_{key}_step"] = steps[key]
    return out


def hidden(
    robot: str, effect: str | tuple[str, ...] | None, seed: int, misfit: float = 0.0,
    given: dict[str, float] | None = None,
) -> Logs:  # fmt: skip
    """One of the effects of studies/hidden; `given` are factors of the parameters before."""
    run = case(robot, effect, "moderate", seed, misfit=misfit)
    lines = []
    if run.given or given:
        for name, value in run.parameters.items():
            lines.append(f"{name} = {value * (given or {}).get(name, 1.0)!r}")
        lines.insert(0, "[parameters]")
    logs = {"train": run.train, "test": run.validation}
    for _, joints, truth in run.truth:
        print("   ", joints, {name: float(value) for name, value in truth.items()})
    return counted(run.robot_toml, logs, 125 if robot == "planar2r" else 100, "\n".join(lines))


def read(machine: Machine, believed: Machine, kind: str) -> Log:
    """A log of a machine that is taken for another."""
    run = simulate(machine, believed, kind, 2)
    every, rng = round(1 / (machine.rate * STEP)), generator("stored", machine.name, kind)
    q, tau = run.motion.q[::every], run.tau[::every]
    return {
        "t": run.motion.t[::every],
        "q": np.round(q / machine.resolution) * machine.resolution,
        "qd": run.motion.qd[::every] + machine.tacho * rng.normal(size=q.shape),
        "tau": tau + 0.01 * rms(tau) * rng.normal(size=tau.shape),
    }


def made(
    change: Callable[[Machine], Machine], believed: Machine = ARM, zero: float = 0.0,
    undeclared: tuple[tuple[int, str], ...] = (),
) -> Logs:  # fmt: skip
    """A machine that is changed; `zero` is taken from the position of joint 2, rad."""
    logs = {new: read(change(believed), believed, kind) for kind, new in KINDS.items()}
    for log in logs.values():
        log["q"] = log["q"] - zero * np.eye(believed.n)[1]
    return counted(believed.robot_toml(undeclared), logs, 100)


def on(joint: int, law: Callable[[np.ndarray, np.ndarray], np.ndarray], m: Machine) -> Machine:
    """The machine with one more torque on a joint (from 0), of positions and speeds."""

    def torque(_: float, q: np.ndarray, qd: np.ndarray, __: np.ndarray) -> np.ndarray:
        out = np.zeros(q.shape)
        out[..., joint] = law(q, qd)
        return out

    return replace(m, extra=(*m.extra, torque))


def carried(m: Machine) -> Machine:
    """The machine whose weight on joint 2 is carried by half."""
    links = PinocchioEngine(m)

    def weight(q: np.ndarray, _: np.ndarray) -> np.ndarray:
        rows = np.atleast_2d(q)
        return CARRIED * links.torque(rows, 0 * rows, 0 * rows)[:, 1].reshape(q.shape[:-1])

    return on(1, weight, m)


def smooth(m: Machine) -> Machine:
    """The machine whose friction of joint 2 turns over 0.15 rad/s."""
    return m.with_entry("width", 1, 0.15)


def spring(m: Machine) -> Machine:
    """The machine with a spring on joint 2."""
    return on(1, lambda q, _: -25 * (q[..., 1] - 0.6), m)


def stuck(undeclared: tuple[tuple[int, str], ...] = ()) -> Logs:
    """An arm of dry friction that moves between points and rests."""
    logs = {
        new: stiction.recorded(PLANAR, PLANAR, 30, kind, points="together")
        for kind, new in KINDS.items()
    }
    return counted(PLANAR.robot_toml(undeclared), logs, 100)


def loose(gear: backlash.Gear) -> Logs:
    """An arm with play in a gear."""
    logs = {name: backlash.recorded(100 + k, gear) for k, name in enumerate(("train", "test"))}
    return counted(backlash.ROBOT, logs, 125)


# -- the arm of closed form, its effects written here
FS, FV = np.array([1.0, 0.4]), np.array([0.6, 0.25])
DRIVE = '[drive]\nratio = [60.0, 60.0]\nposition_side = "joint"\ntorque_side = "joint"\n'
BARE = planar2r.robot_toml("bare").replace('["coulomb", "viscous"]', "[]")


def sines(seed: int, speed: float, seconds: float, step: float) -> tuple[np.ndarray, ...]:
    """t, q, qd, qdd of sums of three sines."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, seconds, step)
    w = speed * np.array([[0.9, 1.3], [2.1, 2.7], [3.7, 4.6]])
    return t, *waves(t, [[0.7], [0.35], [0.2]], w, rng.uniform(0, 2 * np.pi, w.shape))


def dahl(q: np.ndarray, _: np.ndarray) -> np.ndarray:
    """Half a N m on joint 2 of the state z, dz = dq (1 - z sign(dq))/0.1, in 50 steps a sample."""
    x = q[:, 1]
    z, out = float(np.sign(x[1] - x[0])), np.zeros_like(q)
    for k in range(1, len(x)):
        out[k - 1, 1] = 0.5 * z
        dq = (x[k] - x[k - 1]) / 50
        for _step in range(50):
            z += dq * (1 - z * np.sign(dq)) / 0.1
    out[-1, 1] = 0.5 * z
    return out


def cogging(q: np.ndarray, _: np.ndarray) -> np.ndarray:
    """0.15 N m on joint 2, four periods a turn of its motor."""
    return np.outer(np.sin(4 * 60 * q[:, 1] + 0.4), [0.0, 0.15])


def rising(_: np.ndarray, qd: np.ndarray) -> np.ndarray:
    """Friction that is less near rest, in place of the arm's own."""
    least = 1 - 0.4 * np.exp(-((qd / 0.3) ** 2))
    return FS * np.sign(qd) * (least - 1) - FV * qd


def none(q: np.ndarray, _: np.ndarray) -> np.ndarray:
    """No torque."""
    return 0 * q


def closed(
    robot: str, law: Callable[[np.ndarray, np.ndarray], np.ndarray], speed: float = 1.0,
    seconds: float = 20.0, noise: float = 1e-6, speeds: bool = True,
) -> Logs:  # fmt: skip
    """The paper's arm with friction and one more torque; `noise` is of positions, rad."""
    logs = {}
    for seed, name in ((1, "train"), (2, "test")):
        t, q, qd, qdd = sines(seed, speed, seconds, 0.008)
        tau = Arm(X, FS=FS, FV=FV).torque(q, qd, qdd) + law(q, qd)
        rng = np.random.default_rng(seed + 100)
        tau += 0.01 * np.std(tau, axis=0) * rng.normal(size=tau.shape)
        logs[name] = {"t": t, "q": q + noise * rng.normal(size=q.shape), "tau": tau}
        logs[name] |= {"qd": qd} if speeds else {}
    return counted(robot, logs, 125)


def bending(stiffness: float) -> Logs:
    """One joint that bends between motor and link, with an encoder on both, by SciPy."""
    link, motor, weight, damping = 0.9, 0.5, 18.0, 0.8  # kg m2, kg m2, N m, N m s/rad
    robot = (
        '[robot]\nname = "bends"\ngravity = [0.0, -9.81, 0.0]\n'
        '[[joint]]\nfriction = ["coulomb", "viscous"]\n'
    )
    logs = {}
    for seed, name in ((1, "train"), (3, "test")):
        rng = np.random.default_rng(seed)
        w, phase = np.array([1.1, 2.7, 5.3]), rng.uniform(0, 2 * np.pi, 3)
        a = np.array([0.8, 0.35, 0.12])

        def torque(t: Any, q: Any, qd: Any, w: Any = w, a: Any = a, phase: Any = phase) -> Any:
            angle = w * np.asarray(t)[..., None] + phase
            aim, rate = (a * np.sin(angle)).sum(-1), (a * w * np.cos(angle)).sum(-1)
            return 900.0 * (aim - q) + 60.0 * (rate - qd)

        def slopes(t: float, x: Any, torque: Any = torque) -> list[float]:
            q, qd, s, sd = x
            push = stiffness * (q - s) + damping * (qd - sd)
            dry = 0.8 * np.tanh(qd / 1e-3) + 0.6 * qd
            turned = (torque(t, q, qd) - push - dry) / motor
            return [qd, turned, sd, (push - weight * np.cos(s)) / link]

        t = np.arange(0.0, 20.0, 0.004)
        begin = float((a * np.sin(phase)).sum()), float((a * w * np.cos(phase)).sum())
        at = [*begin, begin[0] - weight * np.cos(begin[0]) / stiffness, begin[1]]
        x = solve_ivp(slopes, (0, t[-1]), at, "LSODA", t, rtol=1e-8, atol=1e-10).y
        tau = torque(t, x[0], x[1])
        tau = tau + 0.01 * np.std(tau) * rng.normal(size=len(t))
        q, qs = (y + 2e-5 * rng.normal(size=len(t)) for y in x[[0, 2]])
        qd = x[1] + 1e-3 * rng.normal(size=len(t))
        log = {"q": q, "qs": qs, "qd": qd, "tau": tau}
        logs[name] = {"t": t} | {key: y[:, None] for key, y in log.items()}
    return counted(robot, logs, 250)


CASES: dict[str, Callable[[], Logs]] = {
    "sound": partial(hidden, "arm3r", None, 3),
    "misfit": partial(hidden, "planar2r", None, 7, 0.01),
    "coulomb": partial(hidden, "planar2r", "coulomb_friction", 1),
    "viscous": partial(hidden, "planar2r", "viscous_friction", 1),
    "rotor": partial(hidden, "planar2r", "rotor_inertia", 1),
    "offset": partial(hidden, "planar2r", "torque_offset", 1),
    "asymmetric": partial(hidden, "planar2r", "asymmetric_viscous_friction", 1),
    "stribeck": partial(hidden, "planar2r", "stribeck_friction", 1),
    "nonlinear": partial(hidden, "planar2r", "nonlinear_viscous_friction", 1),
    "load_friction": partial(hidden, "arm3r", "load_dependent_friction", 3),
    "place_friction": partial(hidden, "planar2r", "position_dependent_friction", 1),
    "spring": partial(hidden, "planar2r", "gravity_spring", 1),
    "ripple": partial(hidden, "planar2r", "torque_ripple", 1),
    "coupled": partial(hidden, "planar2r", "coupled_transmission", 1),
    "cable": partial(hidden, "planar2r", "cable_torque", 1),
    "elastic": partial(hidden, "planar2r", "joint_elasticity", 1),
    "thermal": partial(hidden, "planar2r", "thermal_drift", 1),
    "contact": partial(hidden, "planar2r", "external_contact", 1),
    "bump": partial(hidden, "planar2r", "unnamed_bump", 1),
    "product": partial(hidden, "planar2r", "unnamed_product", 1),
    "tilt": partial(hidden, "planar2r", "base_tilt", 1),
    "length": partial(hidden, "arm3r", "geometry_error", 0),
    "payload": partial(hidden, "planar2r", "payload", 0),
    "gain": partial(hidden, "planar2r", "drive_gain_error", 0),
    "drifted": partial(hidden, "planar2r", None, 0, 0.0, {"FS2": 1 / 1.5}),
    "pair": partial(hidden, "planar2r", ("coulomb_friction", "gravity_spring"), 1),
    "sprung": partial(made, spring),
    "no_coulomb": partial(made, lambda m: m, undeclared=((1, "coulomb"),)),
    "carried": partial(made, carried),
    "zero": partial(made, lambda m: m, MACHINES["arm6r"], np.radians(3)),
    "smooth": partial(made, smooth),
    "stuck": stuck,
    "stuck_coulomb": partial(stuck, ((1, "coulomb"),)),
    "play": partial(loose, backlash.Gear(1, np.radians(1.0))),
    "no_play": partial(loose, backlash.Gear(1, 0.0)),
    "hysteresis": partial(closed, planar2r.robot_toml("arm"), dahl),
    "cogging": partial(closed, planar2r.robot_toml("arm") + DRIVE, cogging, 0.02, 60.0),
    "bare": partial(closed, BARE, none),
    "rising": partial(closed, BARE, rising),
    "noise": partial(closed, planar2r.robot_toml("arm"), none, noise=1e-3, speeds=False),
    "two_encoders": partial(bending, 900.0),
}
#: The cases whose logs are kept.
STORED = (
    "sound coulomb viscous rotor offset stribeck load_friction spring ripple coupled elastic "
    "contact bump tilt length payload gain drifted pair sprung no_coulomb carried smooth "
    "stuck_coulomb play hysteresis cogging bare noise two_encoders"
).split()


def main(names: list[str]) -> None:
    """Write the files."""
    folder = TESTS / "logs"
    folder.mkdir(exist_ok=True)
    for name in names or [name for name in STORED if not (folder / f"{name}.npz").exists()]:
        print(name)
        np.savez_compressed(folder / f"{name}.npz", **CASES[name]())


if __name__ == "__main__":
    main(sys.argv[1:])

"""The paper again: the example of Gautier and Khalil (1988), simulated and identified many times.

The canonical model is derived and compiled, the noisy measurements of the paper's two set-ups are
simulated, and every run is identified recursively.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.codegen.casadi_model import casadi_function
from symgen.codegen.model import Model, derive
from symgen.data.log import make_log
from symgen.data.signals import sampled
from symgen.errors import IdentificationError
from symgen.estimation.estimators import solve
from symgen.estimation.filtered import unfiltered
from symgen.estimation.integrals import cumulative_integral
from symgen.estimation.solve import SINGULAR
from symgen.estimation.system import LinearSystem, energy_equations
from symgen.experiment.reference import SAMPLES, STEP, as_csv, paper_motion
from symgen.identification.workflow import identify
from symgen.robot.toml_io import read_robot
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator, load

FloatArray = NDArray[np.float64]

X_TRUE = np.array([1.702, 0.05644, 0.15, 0.075])
NAMES = ("ZZ1R", "ZZ2", "MX2", "MY2")
PAPER_ERRORS = np.array([5.6e-4, 0.016, 0.011, 0.019])
_ENCODER_POINTS = 14_400
_TACHOMETER = np.array([0.005, 0.01])
#: Ratio of X_d to X in set-up (b), and standard deviation of the torque noise over RMS torque.
WRONG = 1.2
TORQUE_NOISE = 0.01
_SUBSTEPS = 8


@dataclass(frozen=True, eq=False)
class Runs:
    """Measured runs: t (N,), q, qd, tau (runs, N, 2)."""

    t: FloatArray
    q: FloatArray
    qd: FloatArray
    tau: FloatArray


def times() -> FloatArray:
    """Return the sampling times: 0 and the paper's 100 samples, s."""
    return np.arange(SAMPLES + 1) * np.float64(STEP)


@dataclass(frozen=True, eq=False)
class Dynamics:
    """Torques and accelerations of a robot.

    Attributes:
        inverse: casadi.Function (q, qd, qdd, X) -> tau, each a column.
        forward: casadi.Function (q, qd, tau, X) -> qdd.
    """

    inverse: Any
    forward: Any


def dynamics(robot: Robot) -> Dynamics:
    """Derive the dynamics of a robot."""
    model = derive(robot, ("inverse_dynamics", "forward_dynamics"))
    return Dynamics(*(casadi_function(model, kernel) for kernel in model.kernels))


def exact_run(dynamics: Dynamics) -> Runs:
    """Return the reference with its torque and no noise at all."""
    t = times()
    q, qd, qdd = paper_motion(t)
    return Runs(t, q[None], qd[None], _torque(dynamics, q, qd, qdd, X_TRUE)[None])


def setup_a(
    dynamics: Dynamics, runs: int, draw: np.random.Generator, *, tachometer: float = 1.0
) -> Runs:
    """Return runs that follow the reference exactly, with noisy measurements.

    Args:
        dynamics: of the robot.
        runs: how many.
        draw: of the noise.
        tachometer: factor of the tachometers' noise.
    """
    clean = exact_run(dynamics)
    t, q, qd, tau = clean.t, *(np.repeat(x, runs, 0) for x in (clean.q, clean.qd, clean.tau))
    return Runs(t, *_measured(draw, q, qd, tachometer), tau)


def setup_b(
    dynamics: Dynamics, runs: int, draw: np.random.Generator, *, tachometer: float = 1.0
) -> Runs:
    """Return runs of a simulated robot driven by wrong computed torques plus torque noise.

    The robot is integrated in 8 steps a sample; the noise is constant over a sample. Arguments as
    those of `setup_a`.
    """
    t = times()
    computed = _torque(dynamics, *paper_motion(t), WRONG * X_TRUE)
    size = TORQUE_NOISE * np.sqrt(np.mean(computed**2, axis=0))
    noise = size * draw.normal(size=(runs, len(t), 2))
    exact = _torque(dynamics, *paper_motion(stages(_SUBSTEPS)), WRONG * X_TRUE)
    true = integrated(dynamics, np.repeat(X_TRUE[None], runs, 0), exact, noise)
    return Runs(t, *_measured(draw, *true, tachometer), np.repeat(computed[None], runs, 0))


def stages(substeps: int) -> FloatArray:
    """Return the times at which an integration looks at the torque: ends and middles of steps."""
    return np.arange(2 * substeps * SAMPLES + 1) * (np.float64(STEP) / (2 * substeps))


def integrated(
    dynamics: Dynamics, X: FloatArray, tau: FloatArray, noise: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return q, qd (runs, N, 2) from the start of the reference, by Runge and Kutta's fourth order.

    Args:
        dynamics: of the robot.
        X: parameters of each run, (runs, 4).
        tau: torques at `stages` of some steps a sample.
        noise: added to the torque, constant over a sample, (runs, N, 2).
    """
    forward, substeps = dynamics.forward.map(len(X)), len(tau) // (2 * SAMPLES)
    h = STEP / substeps

    def rate(x: FloatArray, tau: FloatArray) -> FloatArray:
        return np.concatenate([x[2:], np.array(forward(x[:2], x[2:], tau, X.T))])

    x = np.repeat(np.concatenate(paper_motion(np.zeros(1))[:2], axis=1).T, len(X), axis=1)
    states = [x]
    for k in range(SAMPLES):
        for i in range(2 * k * substeps, 2 * (k + 1) * substeps, 2):
            first, middle, last = (w[:, None] + noise[:, k].T for w in tau[i : i + 3])
            a = rate(x, first)
            b = rate(x + h / 2 * a, middle)
            c = rate(x + h / 2 * b, middle)
            x = x + h / 6 * (a + 2 * b + 2 * c + rate(x + h * c, last))
        states.append(x)
    q, qd = np.split(np.array(states).transpose(2, 0, 1), 2, axis=2)
    return q, qd


def proportional_run(dynamics: Dynamics, seed: int | None = None) -> Runs:
    """Return the motion the paper warns of: joint 2 moves as joint 1 does, at half its speed."""
    t = times()
    q, qd, qdd = (np.stack([x[:, 0], 0.5 * x[:, 0]], axis=-1) for x in paper_motion(t))
    tau = _torque(dynamics, q, qd, qdd, X_TRUE)
    if seed is not None:
        (q,), (qd,) = _measured(np.random.default_rng([seed, 3]), q[None], qd[None])
    return Runs(t, q[None], qd[None], tau[None])


def _measured(
    draw: np.random.Generator, q: FloatArray, qd: FloatArray, tachometer: float = 1.0
) -> tuple[FloatArray, FloatArray]:
    """Add the encoders' error, uniform over a step, and the tachometers' noise."""
    half = math.pi / _ENCODER_POINTS
    q = q + draw.uniform(-half, half, q.shape)
    return q, qd + tachometer * _TACHOMETER * draw.normal(size=qd.shape)


def _torque(
    dynamics: Dynamics, q: FloatArray, qd: FloatArray, qdd: FloatArray, X: FloatArray
) -> FloatArray:
    """Return the torque (N, 2) of the robot with parameters X along a motion."""
    count = len(q)
    function = dynamics.inverse.map(count)
    return np.array(function(q.T, qd.T, qdd.T, np.repeat(X[:, None], count, 1))).T


#: Names of the files that are written.
MARKER, PAGE = "demo.json", "demo.html"
_SEED = 1988
# Runs whose way to the result is followed, sample by sample.
_FOLLOWED = 200


@dataclass(frozen=True, eq=False)
class Setup:
    """One of the paper's set-ups.

    Attributes:
        letter: a or b.
        words: how the measurements came about.
        runs: the simulated ones.
        history: estimates after every sample of the first runs, (F, N, 4).
        final: estimates of all runs, (R, 4).
    """

    letter: str
    words: str
    runs: Runs
    history: FloatArray
    final: FloatArray

    def summary(self) -> dict[str, Any]:
        """Return for each parameter its errors beside the paper's, for demo.json."""
        final = self.final
        error = np.abs(final / X_TRUE - 1)
        return {
            name: {
                "true": float(X_TRUE[i]),
                "mean": float(final[:, i].mean()),
                "paper_relative_error": float(PAPER_ERRORS[i]),
                "relative_error_quantiles": {
                    str(level): float(np.quantile(error[:, i], level))
                    for level in (0.05, 0.5, 0.95)
                },
                "share_below_paper": float(np.mean(error[:, i] < PAPER_ERRORS[i])),
            }
            for i, name in enumerate(NAMES)
        }

    def log(self, k: int) -> bytes:
        """Return one run as a log that `symgen identify planar2r` reads."""
        runs = self.runs
        return as_csv(runs.t, {"q": runs.q[k], "qd": runs.qd[k], "tau": runs.tau[k]}, digits=9)


@dataclass(frozen=True, eq=False)
class Reproduction:
    """What became of the paper's example.

    Attributes:
        model: the canonical one.
        backend: that evaluated it.
        count: runs of each set-up.
        exact: largest relative errors without noise, by spline integrals and on line.
        setups: a and b.
        refused: why joint speeds proportional to each other are refused, without and with noise;
            empty where they are not.
    """

    model: Model
    backend: str
    count: int
    exact: tuple[float, float]
    setups: tuple[Setup, ...]
    refused: tuple[str, str]

    def files(self) -> dict[str, bytes]:
        """Return demo.json, and two runs of each set-up as logs."""
        summary = {"schema": "symgen.demo/1", "runs": self.count, "seed": _SEED}
        told = summary | {s.letter: s.summary() for s in self.setups}
        logs = {f"setup_{s.letter}_{k + 1}.csv": s.log(k) for s in self.setups for k in range(2)}
        return {MARKER: (json.dumps(told, indent=1) + "\n").encode(), **logs}


def reproduce(runs: int, say: Callable[[str], None]) -> Reproduction:
    """Derive, simulate and identify the paper's example.

    Args:
        runs: seeded runs of each set-up.
        say: is told what is being done.
    """
    model = derive(read_robot("planar2r"))
    say("compiling the model")
    evaluator, simulated = load(model), dynamics(model.robot)
    setups = []
    for stream, letter, words, simulate in (
        (1, "a", "the robot follows the reference, the measurements are noisy", setup_a),
        (
            2,
            "b",
            f"torques computed from X_d = {WRONG:g} X, noise of "
            f"{100 * TORQUE_NOISE:g} % of RMS torque, drive a simulated robot",
            setup_b,
        ),
    ):
        say(f"({letter}) {runs} seeded runs of this set-up")
        measured = simulate(simulated, runs, np.random.default_rng([_SEED, stream]))
        rows = _rows(evaluator, measured)
        final = _solved(np.asarray(np.linalg.qr(rows, mode="r")))
        setups.append(Setup(letter, words, measured, _recursive(rows[:_FOLLOWED]), final))
    still, shaken = (proportional_run(simulated, noise) for noise in (None, 1))
    return Reproduction(
        model,
        evaluator.backend,
        runs,
        _returned(evaluator, exact_run(simulated)),
        tuple(setups),
        (_refused(evaluator, still), _refused(evaluator, shaken)),
    )


def _rows(evaluator: Evaluator, runs: Runs) -> FloatArray:
    """Return [W y] of the energy equations of every run, (runs, N, 5).

    All windows begin with the first sample, as in the paper: each new sample adds an equation.
    """
    both = [evaluator.energy_regressor(q, qd) for q, qd in zip(runs.q, runs.qd, strict=True)]
    h, power = np.stack(both), np.sum(runs.qd * runs.tau, axis=2)
    y = cumulative_integral(power.T, STEP).T
    return np.concatenate([h - h[:, :1], y[:, :, None]], axis=2)


def _solved(factors: FloatArray) -> FloatArray:
    """Return the least-squares estimates (runs, 4) of triangles of [W y]; NaN where singular."""
    p = len(X_TRUE)
    R, out = factors[:, :p, :p], np.full((len(factors), p), np.nan)
    norms = np.linalg.norm(R, axis=1, keepdims=True)
    sizes = np.linalg.svd(R / np.where(norms > 0, norms, 1.0), compute_uv=False)
    known = sizes[:, -1] > SINGULAR * sizes[:, 0]
    out[known] = np.linalg.solve(R[known], factors[known, :p, p:])[:, :, 0]
    return out


def _recursive(rows: FloatArray) -> FloatArray:
    """Return the estimate after each sample of every run, (runs, N, 4), one equation at a time."""
    out = np.full((*rows.shape[:2], len(X_TRUE)), np.nan)
    factors = rows[:, :0]
    for i in range(1, rows.shape[1]):
        longer = np.concatenate([factors, rows[:, i : i + 1]], axis=1)
        factors = np.asarray(np.linalg.qr(longer, mode="r"))
        if i > len(X_TRUE):
            out[:, i] = _solved(factors)
    return out


def _returned(evaluator: Evaluator, exact: Runs) -> tuple[float, float]:
    """Return the largest relative errors without noise: spline integrals, and on line."""
    log = make_log("exact", exact.t, exact.q[0], exact.tau[0], exact.qd[0])
    equations = energy_equations(evaluator, unfiltered(sampled(log)), 10 * STEP)
    spline = solve(LinearSystem(evaluator.model.base.names, (equations,))).X
    online = _recursive(_rows(evaluator, exact))[0, -1]
    return _worst(spline), _worst(online)


def _worst(X: FloatArray) -> float:
    return float(np.abs(X / X_TRUE - 1).max())


def _refused(evaluator: Evaluator, runs: Runs) -> str:
    """Return why a run is refused; empty where it is not."""
    log = make_log("proportional", runs.t, runs.q[0], runs.tau[0], runs.qd[0])
    try:
        identify(evaluator, log, model="energy", window=10 * STEP)
    except IdentificationError as error:
        return str(error)
    return ""

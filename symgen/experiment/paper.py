"""The example of Gautier and Khalil (1988), simulated and identified many times.

symgen derives and compiles the model of the paper, simulates noisy measurements of both set-ups,
and identifies every run recursively.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from symgen.codegen.model import derive
from symgen.data.log import make_log
from symgen.data.raw import FloatArray
from symgen.data.signals import sampled
from symgen.distributed import Say
from symgen.estimation.estimators import solve
from symgen.estimation.filtered_log import unfiltered
from symgen.estimation.integrals import cumulative_integral
from symgen.estimation.system import LinearSystem, window_equations
from symgen.experiment.reference import SAMPLES, STEP, as_csv, paper_motion
from symgen.identification.workflow import identify
from symgen.runtime.evaluator import Evaluator, load
from symgen.runtime.integrator import Motion, integrate
from symgen.runtime.plant import KERNELS, plant

X_TRUE = np.array([1.702, 0.05644, 0.15, 0.075])
NAMES = ("ZZ1R", "ZZ2", "MX2", "MY2")
PAPER_ERRORS = np.array([5.6e-4, 0.016, 0.011, 0.019])
_ENCODER_POINTS = 14_400
_TACHOMETER = np.array([0.005, 0.01])
#: Ratio of X_d to X in set-up (b), and standard deviation of the torque noise over RMS torque.
WRONG = 1.2
TORQUE_NOISE = 0.01
_ACCURACY = 1e-8  # of a step of the simulation, rad and rad/s: far below the noise


def times() -> FloatArray:
    """Return the sampling times: 0 and the paper's 100 samples, s."""
    return np.arange(SAMPLES + 1) * np.float64(STEP)


def example() -> Evaluator:
    """Load the model of the paper's robot, with the kernels that its simulation needs."""
    return load(derive("planar2r", ("energy_regressor", *KERNELS)))


def exact_run(evaluator: Evaluator) -> Motion:
    """Return the reference with its torque and no noise at all."""
    t = times()
    q, qd, qdd = paper_motion(t)
    return Motion(t, q[None], qd[None], evaluator.inverse_dynamics(q, qd, qdd, X_TRUE)[None])


def setup_a(
    evaluator: Evaluator, runs: int, draw: np.random.Generator, *, tachometer: float = 1.0
) -> Motion:
    """Return runs that follow the reference exactly, with noisy measurements.

    Args:
        evaluator: model of the robot.
        runs: number of runs.
        draw: random generator of the noise.
        tachometer: factor on the noise of the tachometers.
    """
    clean = exact_run(evaluator)
    t, q, qd, tau = clean.t, *(np.repeat(x, runs, 0) for x in (clean.q, clean.qd, clean.tau))
    return Motion(t, *_measured(draw, q, qd, tachometer), tau)


def setup_b(
    evaluator: Evaluator, runs: int, draw: np.random.Generator, *, tachometer: float = 1.0
) -> Motion:
    """Return runs of a simulated robot driven by wrong computed torques plus torque noise.

    The noise is constant over a sample. The arguments are those of `setup_a`.
    """

    def law(at: FloatArray, *_: FloatArray) -> FloatArray:
        return evaluator.inverse_dynamics(*paper_motion(at), WRONG * X_TRUE)

    t = times()
    computed = law(t)
    size = TORQUE_NOISE * np.sqrt(np.mean(computed**2, axis=0))
    noise = size * draw.normal(size=(runs, len(t), 2))
    start = (np.repeat(x, runs, axis=0) for x in paper_motion(t[:1])[:2])
    moved = integrate(plant(evaluator, X_TRUE), law, t, *start, unseen=noise, tolerance=_ACCURACY)
    return Motion(t, *_measured(draw, moved.q, moved.qd, tachometer), moved.tau)


def proportional_run(evaluator: Evaluator, seed: int | None = None) -> Motion:
    """Return a motion that the paper warns of: joint 2 moves like joint 1, at half the speed."""
    t = times()
    q, qd, qdd = (np.stack([x[:, 0], 0.5 * x[:, 0]], axis=-1) for x in paper_motion(t))
    tau = evaluator.inverse_dynamics(q, qd, qdd, X_TRUE)
    if seed is not None:
        (q,), (qd,) = _measured(np.random.default_rng([seed, 3]), q[None], qd[None])
    return Motion(t, q[None], qd[None], tau[None])


def _measured(
    draw: np.random.Generator, q: FloatArray, qd: FloatArray, tachometer: float = 1.0
) -> tuple[FloatArray, FloatArray]:
    """Add encoder errors, uniform over a step, and the noise of the tachometers."""
    half = math.pi / _ENCODER_POINTS
    q = q + draw.uniform(-half, half, q.shape)
    return q, qd + tachometer * _TACHOMETER * draw.normal(size=qd.shape)


_SEED = 1988
#: Runs whose way to the result is followed, sample by sample; the first samples determine little.
_FOLLOWED, FIRST = 200, 16


@dataclass(frozen=True, eq=False)
class Setup:
    """One of the paper's set-ups.

    Attributes:
        letter: a or b.
        words: description of the measurements.
        runs: the simulated runs.
        history: estimates of the first runs after every sample from FIRST on, (F, N - FIRST, 4).
        final: estimates of all runs, (R, 4).
    """

    letter: str
    words: str
    runs: Motion
    history: FloatArray
    final: FloatArray

    def summary(self) -> dict[str, Any]:
        """Return the errors of each parameter and those of the paper, for demo.json."""
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
    """Results for the paper's example.

    Attributes:
        evaluator: the model of the paper.
        count: number of runs of each set-up.
        exact: largest relative errors without noise, by spline integrals and on line.
        setups: set-ups a and b.
        hidden: parameters that proportional joint speeds do not determine, without and with noise.
    """

    evaluator: Evaluator
    count: int
    exact: tuple[float, float]
    setups: tuple[Setup, ...]
    hidden: tuple[tuple[str, ...], ...]

    def files(self, summary: str) -> dict[str, bytes]:
        """Return the JSON of this name, and two runs of each set-up as logs."""
        told = {"schema": "symgen.demo/1", "runs": self.count, "seed": _SEED}
        told |= {s.letter: s.summary() for s in self.setups}
        logs = {f"setup_{s.letter}_{k + 1}.csv": s.log(k) for s in self.setups for k in range(2)}
        return {summary: (json.dumps(told, indent=1) + "\n").encode(), **logs}


def reproduce(runs: int, say: Say) -> Reproduction:
    """Derive, simulate and identify the paper's example.

    Args:
        runs: number of seeded runs of each set-up.
        say: called with a text about the current step.
    """
    say("compiling the model")
    evaluator, setups = example(), []
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
        measured = simulate(evaluator, runs, np.random.default_rng([_SEED, stream]))
        rows = _rows(evaluator, measured)
        final = _solved(rows.transpose(0, 2, 1) @ rows)
        setups.append(Setup(letter, words, measured, _recursive(rows[:_FOLLOWED]), final))
    hidden = (_hidden(evaluator, proportional_run(evaluator, seed)) for seed in (None, 1))
    exact = _returned(evaluator, exact_run(evaluator))
    return Reproduction(evaluator, runs, exact, tuple(setups), tuple(hidden))


def _rows(evaluator: Evaluator, runs: Motion) -> FloatArray:
    """Return [W y] of the energy equations of every run, (runs, N, 5).

    All windows begin with the first sample, as in the paper: each new sample adds an equation.
    """
    both = [evaluator.energy_regressor(q, qd) for q, qd in zip(runs.q, runs.qd, strict=True)]
    h, power = np.stack(both), np.sum(runs.qd * runs.tau, axis=2)
    y = cumulative_integral(power.T, STEP).T
    return np.concatenate([h - h[:, :1], y[:, :, None]], axis=2)


def _solved(gram: FloatArray) -> FloatArray:
    """Return least squares (..., 4) of [W y]'[W y]; the condition number of W is below 100."""
    return np.asarray(np.linalg.solve(gram[..., :-1, :-1], gram[..., :-1, -1:])[..., 0])


def _recursive(rows: FloatArray) -> FloatArray:
    """Return the estimate after each sample of every run from FIRST on, (runs, N - FIRST, 4)."""
    return _solved(np.cumsum(rows[..., None] * rows[..., None, :], axis=1)[:, FIRST:])


def _returned(evaluator: Evaluator, exact: Motion) -> tuple[float, float]:
    """Return the largest relative errors without noise: spline integrals, and on line."""
    log = make_log("exact", exact.t, exact.q[0], exact.tau[0], exact.qd[0])
    equations = window_equations(evaluator, unfiltered(sampled(log)), "energy", 10 * STEP)
    spline = solve(LinearSystem(evaluator.model.base.names, equations)).X
    online = _recursive(_rows(evaluator, exact))[0, -1]
    return _worst(spline), _worst(online)


def _worst(X: FloatArray) -> float:
    return float(np.abs(X / X_TRUE - 1).max())


def _hidden(evaluator: Evaluator, runs: Motion) -> tuple[str, ...]:
    """Return the parameters that a run does not determine."""
    log = make_log("proportional", runs.t, runs.q[0], runs.tau[0], runs.qd[0])
    found = identify(evaluator, log, model="energy", window=10 * STEP)
    return tuple(p.name for p in found.parameters if math.isnan(p.std))

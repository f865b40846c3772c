"""Bias of least squares and of instrumental variables on the paper's example, over seeded runs.

Vectorised over the runs by plain NumPy, with the model's batch kernel; test_bias.py compares with
the estimators themselves. Runs are mirrored: the second half has the noise of the first with the
other sign, so that what is odd in the noise cancels and the bias stands out; standard errors are
those of the means of pairs.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from oracles import planar2r
from scipy.interpolate import CubicSpline

import symgen
from symgen.estimation.integrals import cumulative_integral
from symgen.experiment import paper
from symgen.experiment.reference import SAMPLES, STEP, paper_motion
from symgen.runtime.integrator import Motion

SEED = 1988
PILOTS = 20  # runs of another seed, whose joint least-squares estimate drives the simulation
WINDOW = 10  # samples of a sliding window
#: Set-ups of the paper, with the streams of their noise.
SETUPS = {"a": (paper.setup_a, 1), "b": (paper.setup_b, 2)}
TACHOMETERS = (1.0, 4.0)
MODES = ("start", "sliding")
#: Instruments along: the model under known torques with parameters of the pilot runs; the motion
#: that was commanded; the model with the parameters of least squares on the same run.
INSTRUMENTS = ("simulation", "commanded", "own simulation")


class Mirrored:
    """A generator of noise for runs, of which the second half has that of the first negated."""

    def __init__(self, draw: np.random.Generator) -> None:
        self.draw = draw

    def normal(self, *, size: tuple[int, ...]) -> np.ndarray:
        return _negated(self.draw.normal(size=((size[0] + 1) // 2, *size[1:])), size[0])

    def uniform(self, low: float, high: float, size: tuple[int, ...]) -> np.ndarray:
        return _negated(self.draw.uniform(low, high, ((size[0] + 1) // 2, *size[1:])), size[0])


def _negated(x: np.ndarray, runs: int) -> np.ndarray:
    return np.concatenate([x, -x])[:runs]


def measured(
    evaluator: symgen.Evaluator,
    setup: str,
    count: int,
    seed: int,
    tachometer: float,
    mirrored: bool,
) -> Motion:
    """Return runs of a set-up."""
    simulate, stream = SETUPS[setup]
    draw: Any = np.random.default_rng([seed, stream])
    return simulate(evaluator, count, Mirrored(draw) if mirrored else draw, tachometer=tachometer)


def free_run(X: np.ndarray, tau: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return q, qd (runs, N, 2) of the model with X (runs, 4) under known torques (N, 2).

    Runge and Kutta's fourth order, two steps a sample, all runs at once with parameters each.
    """
    known = CubicSpline(paper.times(), tau)(np.arange(4 * SAMPLES + 1) * (STEP / 4))
    h = STEP / 2

    def rate(x: np.ndarray, tau: np.ndarray) -> np.ndarray:
        return np.stack([x[1], planar2r.forward_dynamics(x[0], x[1], tau, X.T, 0.5)])

    x = np.repeat(np.stack(paper_motion(np.zeros(1))[:2]), len(X), axis=1)
    states = [x]
    for k in range(2 * SAMPLES):
        first, middle, last = known[2 * k : 2 * k + 3]
        a = rate(x, first)
        b = rate(x + h / 2 * a, middle)
        c = rate(x + h / 2 * b, middle)
        x = x + h / 6 * (a + 2 * b + 2 * c + rate(x + h * c, last))
        states += [x] if k % 2 else []
    q, qd = np.stack(states, axis=2)
    return q, qd


def rows(
    evaluator: symgen.Evaluator, q: np.ndarray, qd: np.ndarray, tau: np.ndarray, mode: str
) -> tuple[np.ndarray, np.ndarray]:
    """Return W (runs, K, 4) and y (runs, K) of the energy model."""
    runs, N, _ = q.shape
    h = evaluator.energy_regressor(q.reshape(-1, 2), qd.reshape(-1, 2)).reshape(runs, N, 4)
    power = np.einsum("rij,rij->ri", qd, tau)
    work = cumulative_integral(np.ascontiguousarray(power.T), STEP).T
    first, last = (slice(0, 1), slice(1, None)) if mode == "start" else (
        slice(None, -WINDOW), slice(WINDOW, None))  # fmt: skip
    return h[:, last] - h[:, first], work[:, last] - work[:, first]


def solutions(Z: np.ndarray, W: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return (Z'W)^-1 Z'y of every run, (runs, 4)."""
    Z = np.broadcast_to(Z, W.shape)
    left, right = np.einsum("rka,rkb->rab", Z, W), np.einsum("rka,rk->ra", Z, y)
    out: np.ndarray = np.linalg.solve(left, right[..., None])[..., 0]
    return out


def pilot(evaluator: symgen.Evaluator, setup: str, tachometer: float) -> np.ndarray:
    """Return the joint least-squares estimate of the pilot runs, (4,)."""
    runs = measured(evaluator, setup, PILOTS, SEED + 1, tachometer, False)
    W, y = rows(evaluator, runs.q, runs.qd, runs.tau, "start")
    out: np.ndarray = np.linalg.lstsq(W.reshape(-1, 4), y.ravel(), rcond=None)[0]
    return out


def instrument_motion(
    evaluator: symgen.Evaluator,
    setup: str,
    tachometer: float,
    tau: np.ndarray,
    kind: str,
    own: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Return q and qd (1 or runs, N, 2) of the motion along which instruments are taken."""
    if kind == "commanded":
        q, qd, _ = paper_motion(paper.times())
        return q[None], qd[None]
    if kind == "simulation":
        X = pilot(evaluator, setup, tachometer)[None]
        return free_run(X, tau)
    with np.errstate(all="ignore"):
        q, qd = free_run(own, tau)
    lost = ~np.isfinite(q + qd).all(axis=(1, 2))  # an estimate that no simulation survives
    q[lost], qd[lost] = q[~lost][0], qd[~lost][0]
    return q, qd


def errors(X: np.ndarray) -> dict[str, Any]:
    """Return relative bias, its standard error over pairs, and the spread of single runs."""
    half = len(X) // 2
    relative = X / paper.X_TRUE - 1
    pairs = (relative[:half] + relative[half:]) / 2
    return {
        "bias": relative.mean(axis=0).tolist(),
        "standard_error": (pairs.std(axis=0, ddof=1) / np.sqrt(half)).tolist(),
        "std_of_a_run": relative.std(axis=0, ddof=1).tolist(),
    }


def study(evaluator: symgen.Evaluator, count: int) -> Iterator[dict[str, Any]]:
    """Yield the figures of every set-up, noise and kind of window."""
    for setup in SETUPS:
        for tachometer in TACHOMETERS:
            runs = measured(evaluator, setup, count, SEED, tachometer, True)
            for mode in MODES:
                W, y = rows(evaluator, runs.q, runs.qd, runs.tau, mode)
                least = solutions(W, W, y)
                found = {"least squares": errors(least)}
                for kind in INSTRUMENTS:
                    q, qd = instrument_motion(
                        evaluator, setup, tachometer, runs.tau[0], kind, least
                    )
                    tau = np.broadcast_to(runs.tau[:1], q.shape)
                    Z, _ = rows(evaluator, q, qd, tau, mode)
                    found[kind] = errors(solutions(Z, W, y))
                yield {"setup": setup, "tachometer": tachometer, "windows": mode, **found}

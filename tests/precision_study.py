"""Do 95 % intervals hold the truth, and how well do estimates predict torque? In simulation.

Robots with known parameters move along sums of sines; encoders, tachometers and torques get noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

import symgen
from symgen.data.bandwidth import motion_bandwidth
from symgen.data.signals import prepare
from symgen.estimation.band import Band
from symgen.estimation.equation_model import EquationModel
from symgen.estimation.estimators import solve
from symgen.estimation.filtered_log import filter_log
from symgen.estimation.system import Equations, LinearSystem
from symgen.identification.instruments import with_instruments
from symgen.identification.parameters import base_values
from symgen.identification.solving import equate

ARM = """
[robot]
name = "covered"
gravity = [0.0, -9.81, 0.0]
[[joint]]
friction = ["coulomb", "viscous"]
[[joint]]
d = 0.5
friction = ["coulomb", "viscous"]
"""


@dataclass(frozen=True)
class Noise:
    """Standard deviations: encoders rad, tachometers rad/s, torque as a share of its RMS."""

    encoder: float
    tachometer: float
    torque: float


def sines(
    n: int, seconds: float, rate: float, base: float, harmonics: int, seed: int, amplitude: float
) -> tuple[np.ndarray, ...]:
    """Return t and q, qd, qdd (N, n) of a sum of sines, exact."""
    draw = np.random.default_rng(seed)
    t = np.arange(0.0, seconds, 1 / rate)
    w = 2 * np.pi * base * np.arange(1, harmonics + 1)
    a, phase = draw.normal(size=(n, harmonics)), draw.uniform(0, 2 * np.pi, (n, harmonics))
    a *= amplitude / np.sqrt(np.sum(a**2, axis=1, keepdims=True))
    angle = t[:, None, None] * w + phase
    return (
        t,
        np.sum(a * np.sin(angle), axis=2),
        np.sum(a * w * np.cos(angle), axis=2),
        np.sum(-a * w**2 * np.sin(angle), axis=2),
    )


def torque(evaluator: symgen.Evaluator, motion: Sequence[np.ndarray], X: np.ndarray) -> np.ndarray:
    """Return the torque (N, n) along a motion, block by block."""
    _, q, qd, qdd = motion
    function = evaluator["inverse_dynamics"]
    return np.asarray(function(q, qd, qdd, X))


def log(
    motion: Sequence[np.ndarray], tau: np.ndarray, noise: Noise, seed: Sequence[int]
) -> symgen.Log:
    """Return a log of noisy measurements."""
    t, q, qd, _ = motion
    draw = np.random.default_rng(list(seed))
    size = noise.torque * np.sqrt(np.mean(tau**2, axis=0))
    return symgen.make_log(
        "noisy",
        t,
        q + noise.encoder * draw.normal(size=q.shape),
        tau + size * draw.normal(size=q.shape),
        qd + noise.tachometer * draw.normal(size=q.shape),
    )


def equations_of(
    evaluator: symgen.Evaluator,
    equation_model: EquationModel,
    noisy: symgen.Log,
    band_hz: float,
    iv: bool,
) -> tuple[Equations, ...]:
    """Return the equations of a log whose tachometers are taken.

    Energy and momentum take positions and speeds as they are; for torque, whose accelerations are
    derivatives, both pass a low-pass four times as wide as that of the equations.

    Args:
        evaluator: the compiled model.
        equation_model: of the equations.
        noisy: the log.
        band_hz: in which torque equations are taken.
        iv: whether encoders give instruments, in the band of the motion.
    """
    samples = prepare(noisy)
    rate = 1 / samples.step
    cutoff = 4 * band_hz if equation_model.name == "torque" else rate / 2
    taken = filter_log(samples, Band(rate, cutoff, band_hz, "measured"))
    part = equate(evaluator, taken, equation_model)
    if iv:
        motion_hz = motion_bandwidth(samples.q, samples.step)
        free = filter_log(samples, replace(taken.band, cutoff_hz=motion_hz, velocity="derived"))
        motion = replace(taken, q=free.q, qd=free.qd)
        part = with_instruments(evaluator, part, equation_model, motion)
    return part.equations


def covered(
    evaluator: symgen.Evaluator,
    model: str,
    methods: Sequence[str],
    noise: Noise,
    seeds: Sequence[int],
) -> dict[str, np.ndarray]:
    """Return by method whether the 95 % interval of each parameter holds the truth, (runs, p)."""
    draw = np.random.default_rng(5)
    true = draw.uniform(0.1, 1.0, len(evaluator.model.base.parameters))
    motions = [sines(2, 40.0, 100.0, base, 5, k, 1.2) for k, base in enumerate((0.11, 0.17))]
    torques = [torque(evaluator, motion, true) for motion in motions]
    equation_model = EquationModel(model, 0.1)
    inside: dict[str, list[np.ndarray]] = {method: [] for method in methods}
    for seed in seeds:
        equations: list[Equations] = []
        for k, (motion, tau) in enumerate(zip(motions, torques, strict=True)):
            # The second log is noisier: that is what weights are for.
            own = Noise(noise.encoder, noise.tachometer, noise.torque * (1 + k))
            noisy = log(motion, tau, own, (seed, k))
            equations += equations_of(evaluator, equation_model, noisy, 12.0, "iv" in methods)
        system = LinearSystem(evaluator.model.base.names, tuple(equations))
        for method in methods:
            found = solve(system, method)
            std = np.sqrt(np.diag(found.covariance))
            inside[method].append(np.abs(found.X - true) < 1.96 * std)
    return {method: np.array(rows) for method, rows in inside.items()}


def tx40() -> tuple[symgen.Evaluator, np.ndarray]:
    """Return the TX40 of the library and base parameters of bodies that could be its links."""
    evaluator = symgen.load(symgen.derive(symgen.read_robot("tx40"), "all"))
    draw = np.random.default_rng(40)
    given: dict[str, float] = {}
    friction = {
        "FS": (7.14, 8.26, 6.34, 2.48, 3.03, 0.282),
        "FV": (8.05, 5.53, 1.97, 1.11, 1.86, 0.65),
        "IA": (0.362, 0.362, 0.0988, 0.0313, 0.0468, 0.0105),
        "OF": (0.392, 1.37, 0.326, -0.102, -0.0288, 0.127),
        "IAM": (0.00964,) * 6, "FVM": (0.616,) * 6, "FSM": (1.95,) * 6,
    }  # fmt: skip
    for j, mass in enumerate((9.0, 7.5, 4.0, 3.0, 1.0, 0.3), 1):
        points = draw.normal(scale=0.08, size=(12, 3)) + draw.uniform(-0.06, 0.06, 3)
        second = mass / 12 * points.T @ points
        inertia = np.trace(second) * np.eye(3) - second
        first = mass / 12 * points.sum(axis=0)
        link = (inertia[0, 0], inertia[0, 1], inertia[0, 2], inertia[1, 1], inertia[1, 2],
                inertia[2, 2], *first, mass)  # fmt: skip
        names = "XX XY XZ YY YZ ZZ MX MY MZ M".split()
        given |= {f"{name}{j}": float(v) for name, v in zip(names, link, strict=True)}
        given |= {f"{name}{j}": values[j - 1] for name, values in friction.items()}
    known = {p.name for p in evaluator.model.base.standard}
    given = {name: value for name, value in given.items() if name in known}
    return evaluator, base_values(given, evaluator.model, "truth")


def held_out(
    evaluator: symgen.Evaluator,
    true: np.ndarray,
    model: str,
    methods: Sequence[str],
    noise: Noise,
    seed: int,
) -> dict[str, np.ndarray]:
    """Return by method the relative torque error of each joint on a run without noise, (6,).

    Four Fourier runs of 20 s at 500 Hz with base frequencies of their own; windows of 0.2 s, or the
    zero-phase low-pass at 5 Hz of the torque model.
    """
    equation_model = EquationModel(model, 0.2)
    equations: list[Equations] = []
    for k, base in enumerate((0.05, 0.06, 0.07, 0.08)):
        motion = sines(6, 20.0, 500.0, base, 12, 100 + k, 1.0)
        noisy = log(motion, torque(evaluator, motion, true), noise, (seed, k))
        equations += equations_of(evaluator, equation_model, noisy, 5.0, "iv" in methods)
    system = LinearSystem(evaluator.model.base.names, tuple(equations))
    motion = sines(6, 20.0, 500.0, 0.055, 12, 99, 1.0)
    tau = torque(evaluator, motion, true)
    out = {}
    for method in methods:
        apart = torque(evaluator, motion, solve(system, method).X) - tau
        out[method] = np.sqrt(np.mean(apart**2, axis=0) / np.mean(tau**2, axis=0))
    return out

"""Precision of planned motions, compared with the best of ten random motions.

    python tests/benchmarks/bench_excite.py

Motions of 10 s on three arms. The random motions are Fourier series of five harmonics, each joint
scaled until it meets the first of its limits. Figures are medians over the parameters of the
standard deviation that the torque regressor gives for equal noise on all joints.
"""

from __future__ import annotations

import time

import numpy as np

import symgen

#: Joints, half range (rad), speed (rad/s), acceleration (rad/s2).
ARMS = {
    "panda": (7, 1.5, 1.5, 6.0),
    "ur10e": (6, 2.0, 1.5, 5.0),
    "puma560": (6, 2.0, 1.5, 5.0),
}
DURATION, HARMONICS = 10.0, 5
t = np.arange(0, DURATION, 1 / 50)
Motion = tuple[np.ndarray, ...]


def random_motion(draw: np.random.Generator, arm: str) -> Motion:
    """Return q, qd, qdd (N, n) of a random motion that uses the limits."""
    n, half, *rates = ARMS[arm]
    w = 2 * np.pi / DURATION * np.arange(1, HARMONICS + 1)
    waves = np.exp(1j * np.outer(t, w))
    speeds = draw.normal(size=(HARMONICS, n)) + 1j * draw.normal(size=(HARMONICS, n))
    q = (waves @ (speeds / (1j * w[:, None]))).real
    qd = (waves @ speeds).real
    qdd = (waves @ (speeds * 1j * w[:, None])).real
    q -= (q.max(axis=0) + q.min(axis=0)) / 2
    tops = [np.abs(x).max(axis=0) for x in (q, qd, qdd)]
    scale = np.min([half / tops[0], rates[0] / tops[1], rates[1] / tops[2]], axis=0)
    return scale * q, scale * qd, scale * qdd


def median_std(evaluator: symgen.Evaluator, motion: Motion) -> float:
    """Return the median of the standard deviations for unit noise."""
    W = np.asarray(evaluator["torque_regressor"](*motion))
    W = W.reshape(-1, W.shape[-1])
    size = np.linalg.norm(W, axis=0)
    G = (W / size).T @ (W / size)
    return float(np.median(np.sqrt(np.diag(np.linalg.inv(G))) / size))


def main() -> None:
    """Print the ratio for each arm and seed, and the processor time of derivation and search."""
    for arm, (n, half, speed, acceleration) in ARMS.items():
        evaluator = symgen.load(symgen.derive(arm, ("torque_regressor",)))
        draw = np.random.default_rng(5)
        at_random = min(median_std(evaluator, random_motion(draw, arm)) for _ in range(10))
        limits = symgen.Limits(
            position=((-half, half),) * n, velocity=(speed,) * n, acceleration=(acceleration,) * n
        )
        for seed in (0, 1):
            begun = time.process_time()
            # Ended by counts, not by time: the same figures on a slow machine.
            plan = symgen.excite(
                arm,
                limits=limits,
                motion=symgen.Motion(duration=DURATION),
                search=symgen.Search(budget=3600, seed=seed),
            )
            seconds = time.process_time() - begun
            planned = tuple(np.ascontiguousarray(plan.runs[0].at(t, order)) for order in range(3))
            ratio = median_std(evaluator, planned) / at_random
            print(f"{arm}, seed {seed}: {ratio:.2f} after {seconds:.0f} s of CPU", flush=True)


if __name__ == "__main__":
    main()

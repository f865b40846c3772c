"""What logs say beside a model: torques, regressor and residual, row by row.

Rows are the torque equations of `symgen.estimation.system`: one joint at one kept instant of the
comparison band. They are whitened by the standard deviation of their joint's residual.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from symgen.data.mask import Bools
from symgen.data.signals import lowpass, white_noise
from symgen.estimation.filtered import FilteredLog
from symgen.estimation.solve import SINGULAR, column_norms
from symgen.estimation.system import torque_rows
from symgen.runtime.evaluator import Evaluator

FloatArray = NDArray[np.float64]
#: Columns (.., m) on joints, by position of the movable joint.
Columns = Mapping[int, FloatArray]
_WHITENING = 3
_TINY = 1e-300
_SETTLING = 5
_REST = 0.005  # of the RMS speed
_BLOCKS = 20  # of time, for robust errors


@dataclass(frozen=True, eq=False)
class Scene:
    """One log of a diagnosis, or a part of it, as `symgen.estimation.filtered` has it.

    Attributes:
        log: the log in the band of the run.
        kept: the samples that rows are made of.
        name: of the log.
        mask: (N, n) where a torque has no say, in the gap neither; or None.
        noise: standard deviation of the white noise of positions and speeds, (n,) each, that of
            speeds None where they are derived from positions; None where it was not seen.
    """

    log: FilteredLog
    kept: slice
    name: str
    mask: Bools | None = None
    noise: tuple[FloatArray, FloatArray | None] | None = None

    @property
    def t(self) -> FloatArray:
        """(N,) time, s."""
        return self.log.t

    @property
    def q(self) -> FloatArray:
        """(N, n) positions below the cutoff, at full rate."""
        return self.log.q

    @property
    def qd(self) -> FloatArray:
        """(N, n) speeds below it."""
        return self.log.qd

    @property
    def qdd(self) -> FloatArray:
        """(N, n) accelerations below it."""
        return self.log.qdd

    @property
    def tau(self) -> FloatArray:
        """(N, n) measured torque, unfiltered."""
        return self.log.tau

    @property
    def step(self) -> float:
        """Sampling step, s."""
        return self.log.step

    @property
    def band(self) -> float | None:
        """Cutoff of the comparison band, Hz; None where nothing is filtered."""
        return self.log.rows.cutoff

    @property
    def wide(self) -> float | None:
        """Cutoff of the low-pass of positions and speeds, Hz; None where they pass none."""
        band = self.log.band
        return band.cutoff_hz if band.filters(self.step) else None

    @property
    def rows(self) -> slice:
        """Which of the log's own kept samples these are."""
        own = self.log.kept
        return slice(*np.searchsorted(own, [self.kept.start, self.kept.stop]))

    @cached_property
    def whole(self) -> FilteredLog:
        """The log as if it had no mask: rows near one are left out, none is weighed."""
        if self.log.mask is None:
            return self.log
        return replace(self.log, samples=replace(self.log.samples, mask=None))

    @property
    def free(self) -> Bools:
        """Where the torque is not masked, (N, n)."""
        return np.ones(self.tau.shape, dtype=bool) if self.mask is None else ~self.mask

    @cached_property
    def measured(self) -> FloatArray:
        """The measured torque in the band at the kept instants, (K, n)."""
        return self.whole.measured[self.rows]

    def smooth(self, x: FloatArray) -> FloatArray:
        """Return a signal (N, ...) in the band at full rate."""
        return x if self.band is None else lowpass(x, self.step, self.band)

    def seen(self, x: FloatArray) -> FloatArray:
        """Return a signal (N, ...) in the band at the kept instants, (K, ...)."""
        return self.whole.compared(x)[self.rows]

    def modelled(
        self, model: Callable[[FloatArray, FloatArray, FloatArray], FloatArray]
    ) -> FloatArray:
        """Return a model of q, qd, qdd in the band at the kept instants, (K, ...)."""
        return np.concatenate([x for _, x in self.whole.modelled(model)])[self.rows]

    def along(self, q: FloatArray, qd: FloatArray) -> Scene:
        """Return the scene with another motion, (N, n) each."""
        return replace(self, log=replace(self.log, q=q, qd=qd))

    def cut(self, start: float, end: float) -> Scene:
        """Return the rows of a span of time; signals keep their full length for the filter."""
        at = np.arange(len(self.t))[self.kept]
        inside = at[(self.t[at] >= start) & (self.t[at] <= end)]
        stride = self.kept.step or 1
        if len(inside) == 0:
            return replace(self, kept=slice(0, 0, stride))
        return replace(self, kept=slice(inside[0], inside[-1] + 1, stride))


def scene(log: FilteredLog) -> Scene:
    """See a log in the band of the run: rows in the comparison band."""
    samples, kept, noise = log.samples, log.kept, None
    if log.band.filters(log.step):
        wide = log.band.cutoff_hz
        derived = log.band.velocity == "derived" or samples.velocity_derived
        noise = (
            white_noise(samples.q - log.q, log.step, wide),
            None if derived else white_noise(samples.qd - log.qd, log.step, wide),
        )
    every = int(kept[1] - kept[0]) if len(kept) > 1 else 1
    reach = 0 if log.rows.cutoff is None else int(1 / (log.rows.cutoff * log.step))
    mask = None if log.mask is None else log.mask.near(reach)
    return Scene(
        log,
        slice(int(kept[0]), int(kept[-1]) + 1, every),
        log.name,
        mask=mask,
        noise=noise,
    )


@dataclass(frozen=True, eq=False)
class Evidence:
    """The rows of some logs, whitened, with what the model explains taken out.

    Attributes:
        scenes: the logs.
        W: (K, n, p) regressor of the model at K kept instants.
        y: (K, n) torque.
        X: (p,) least-squares parameters.
        sigma: (n,) standard deviation of each joint's residual.
        moves: (K, n) weight of the rows: 1.0 where the joint moves, 0.0 where it turns round and
            friction is undefined, and in between in its rests, see `symgen.estimation.cutoff`.
        block: (K,) number of the block of each instant.
        rest: (n,) sum of the squares that rows at rest leave, whitened, beyond what their weight
            lets the residual have of it: the gap counts them whole.
    """

    scenes: tuple[Scene, ...]
    W: FloatArray
    y: FloatArray
    X: FloatArray
    sigma: FloatArray
    moves: FloatArray
    block: NDArray[np.int64]
    rest: FloatArray

    @property
    def n(self) -> int:
        """Number of joints."""
        return int(self.y.shape[1])

    @cached_property
    def residual(self) -> FloatArray:
        """Whitened residual (K, n)."""
        return self.moves * (self.y - self.W @ self.X) / self.sigma

    @cached_property
    def basis(self) -> FloatArray:
        """Orthonormal basis (K, n, r) of what the whitened model can say."""
        weight = (self.moves / self.sigma)[:, :, None]
        rows = (self.W * weight).reshape(self.y.size, self.W.shape[2])
        norms = np.linalg.norm(rows, axis=0)
        if rows.shape[1] == 0:
            return np.zeros((*self.y.shape, 0))
        left, values, _ = np.linalg.svd(rows / np.where(norms > 0, norms, 1), full_matrices=False)
        kept = left[:, values > 1e-9 * values[0]]
        return np.ascontiguousarray(kept.reshape(*self.y.shape, -1))

    @cached_property
    def rank(self) -> int:
        """Number of columns, of combinations of them, that the rows tell apart."""
        weight = (self.moves / self.sigma)[:, :, None]
        rows = (self.W * weight).reshape(self.y.size, self.W.shape[2])
        R: FloatArray = np.asarray(np.linalg.qr(rows, mode="r"))
        values = np.linalg.svd(R / column_norms(R), compute_uv=False)
        return int(np.count_nonzero(values > SINGULAR * values[:1]))

    @cached_property
    def size(self) -> FloatArray:
        """RMS of the measured torque in the band, (n,); 1 where there is none."""
        measured = np.concatenate([s.measured for s in self.scenes])
        rms = np.sqrt(np.mean(measured**2, axis=0))
        return np.asarray(np.where(rms > 0, rms, 1.0))

    def with_columns(self, columns: Iterable[Columns]) -> Evidence:
        """Return the evidence of the model with more columns."""
        more = [dense(c, self.y.shape) for c in columns]
        return (
            solved(self.scenes, np.concatenate([self.W, *more], axis=2), self.y) if more else self
        )

    def gap(self) -> FloatArray:
        """Return RMS of the residual over RMS of the torque, (n,)."""
        return ratio(self.y - self.W @ self.X, self.y)


def dense(columns: Columns, shape: tuple[int, ...]) -> FloatArray:
    """Return the columns of all joints, (K, n, m), for the shape (K, n)."""
    m = next(iter(columns.values())).shape[1]
    out = np.zeros((*shape, m))
    for j, c in columns.items():
        out[:, j] = c
    return out


def ratio(error: FloatArray, torque: FloatArray) -> FloatArray:
    """Return RMS of an error over RMS of the torque by joint, (n,)."""
    size = np.sqrt(np.mean(torque**2, axis=0))
    return np.asarray(np.sqrt(np.mean(error**2, axis=0)) / np.where(size > 0, size, np.inf))


def evidence(evaluator: Evaluator, scenes: Sequence[Scene]) -> Evidence:
    """Fit the model to some logs; effects that hold the model's torque settle in a few rounds."""
    y = np.concatenate([s.measured for s in scenes])

    def fitted(X: FloatArray | None) -> Evidence:
        W = np.concatenate([torque_rows(evaluator, s.whole, X)[s.rows] for s in scenes])
        return solved(tuple(scenes), W, y)

    found = fitted(None)
    base = evaluator.model.base
    for _ in range(_SETTLING if base.linear < len(base.parameters) else 0):
        found = fitted(np.pad(found.X, (0, len(base.parameters) - len(found.X))))
    return found


def given_evidence(evaluator: Evaluator, scenes: Sequence[Scene], X: FloatArray) -> Evidence:
    """Compare a model of given parameters (p,) with some logs: y is what it misses, W is empty."""
    model = partial(torque_at, evaluator, X)
    y = np.concatenate([s.measured - s.modelled(model) for s in scenes])
    return solved(tuple(scenes), np.zeros((*y.shape, 0)), y)


def torque_at(
    evaluator: Evaluator, X: FloatArray, q: FloatArray, qd: FloatArray, qdd: FloatArray
) -> FloatArray:
    """Return the model's torque at some states, (k, n)."""
    return np.asarray(evaluator["inverse_dynamics"](q, qd, qdd, X))


def model_torque(evaluator: Evaluator, X: FloatArray, s: Scene) -> FloatArray:
    """Return the model's torque at full rate, (N, n)."""
    return torque_at(evaluator, X, s.q, s.qd, s.qdd)


def solved(scenes: tuple[Scene, ...], W: FloatArray, y: FloatArray) -> Evidence:
    """Solve y = W X, joints weighed by the standard deviation of their residual."""
    p = W.shape[2]
    moving = [_moving(s) for s in scenes]
    moves = np.concatenate([_weight(s, own) for s, own in zip(scenes, moving, strict=True)])
    count = np.maximum(moves.sum(axis=0), 1.0)
    least = 1e-6 * float(np.sqrt(np.mean(y**2))) + _TINY  # a dead channel has no spread at all
    sigma = np.maximum(np.std(y, axis=0), least)
    X = np.zeros(p)
    for _ in range(_WHITENING):
        weight = moves / sigma
        X = least_squares((W * weight[:, :, None]).reshape(y.size, p), (y * weight).ravel())
        error = moves * (y - W @ X)
        floor = np.maximum(1e-6 * np.sqrt(np.mean(y**2, axis=0)), least * 1e-3)
        sigma = np.maximum(np.sqrt(np.sum(error**2, axis=0) / count), floor)
    counts = [len(range(*s.kept.indices(len(s.t)))) for s in scenes]
    beyond = np.maximum(np.concatenate(moving) - moves**2, 0.0)
    rest = np.sum(beyond * (y - W @ X) ** 2, axis=0) / sigma**2
    return Evidence(scenes, W, y, X, sigma, moves, _blocks(counts), rest)


def _moving(s: Scene) -> FloatArray:
    """Return 1.0 where a joint moves, (K, n): not masked, faster than 0.5 % of its RMS speed."""
    speed = np.sqrt(np.mean(s.qd**2, axis=0))
    moves = np.abs(s.qd[s.kept]) > _REST * speed
    return np.asarray(moves if s.mask is None else moves & ~s.mask[s.kept], dtype=float)


def _weight(s: Scene, moving: FloatArray) -> FloatArray:
    """Return the weight of rows, (K, n): that of rests where the joint rests, else `moving`."""
    resting, known = s.log.resting, s.log.band.rests
    if resting is None or known is None:
        return moving
    weight = np.where(resting[s.rows], known.weight, moving)
    return np.asarray(weight if s.mask is None else weight * ~s.mask[s.kept])


def least_squares(A: FloatArray, b: FloatArray) -> FloatArray:
    """Solve by QR on columns of unit norm; what the rows do not determine is zero."""
    if A.shape[1] == 0:
        return np.zeros(0)
    norms = np.linalg.norm(A, axis=0)
    scale = np.where(norms > 0, norms, 1.0)
    factor: FloatArray = np.asarray(np.linalg.qr(np.column_stack([A / scale, b]), mode="r"))
    p = len(scale)
    x: FloatArray = np.linalg.lstsq(factor[:p, :p], factor[:p, p], rcond=1e-9)[0] / scale
    return x


def _blocks(counts: Sequence[int]) -> NDArray[np.int64]:
    """Number the instants of all logs by contiguous blocks of equal length; none spans two logs."""
    total = sum(counts)
    out, first = [], 0
    for count in counts:
        own = max(1, round(_BLOCKS * count / max(total, 1)))
        out.append(first + np.arange(count) * own // max(count, 1))
        first += own
    return np.concatenate(out) if out else np.zeros(0, dtype=np.int64)

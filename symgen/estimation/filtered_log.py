"""Logs in the band of a run: the data of all equations, comparisons and diagnoses."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from symgen.data.mask import Bools, Mask, resting, touched
from symgen.data.raw import Places
from symgen.data.signals import (
    MARGIN,
    Samples,
    comparison_band,
    differentiate,
    lowpass,
    lowpass_and_slopes,
    smoothed,
)
from symgen.estimation.band import Band
from symgen.estimation.decimation import BLOCK, Decimation, decimation
from symgen.estimation.floating import (
    base_motion,
    contact_jacobian,
    measured_forces,
    projected,
    touching,
)
from symgen.estimation.values import FloatArray

#: Nodes at which models are evaluated, per period of the highest frequency of interest.
_NODES = 16.0
#: Nodes per period of the cutoff for smooth functions of the motion. A product of two signals below
#: the cutoff contains nothing above twice the cutoff, so this rate is enough to avoid aliasing.
_SMOOTH = 4.0
#: Smallest weight in the comparison band of a row that is used despite a mask.
_HARDLY = 0.05
#: Periods of the comparison band over which its low-pass spreads a rest.
_REST_REACHES = 0.5
#: Speed below which a joint stands still, rad/s or m/s. Roundings of a filter are below 1e-9, and
#: their signs, which differ between machines, are no direction of motion.
_STANDS = 1e-8


@dataclass(frozen=True, eq=False)
class Nodes:
    """The motion of a log at its nodes, from which models are evaluated in the comparison band.

    Attributes:
        rows: low-pass of the comparison band on these nodes.
        motion: the arrays of `FilteredLog.motion`, (nodes, n).
        weight: (nodes, m) weight; None without a mask.
        contacts: (nodes, c, m) velocities that unknown forces keep at zero; None without any.
        base_rows: number of equations of a floating base.
    """

    rows: Decimation
    motion: tuple[FloatArray, ...]
    weight: FloatArray | None
    contacts: FloatArray | None = None
    base_rows: int = 0

    def modelled(self, model: Callable[..., FloatArray], block_size: int = BLOCK) -> FloatArray:
        """Return a model along the log, in the comparison band at the kept samples, (K, ...).

        Args:
            model: function from the arrays of `motion`, (k, n) each, to (k, ...).
            block_size: approximate number of nodes to evaluate at once.
        """

        def at(first: int, last: int) -> FloatArray:
            modelled = model(*(x[first:last] for x in self.motion))
            if self.contacts is not None:
                modelled = projected(modelled, self.contacts[first:last])
            return modelled if self.weight is None else _weighed(modelled, self.weight[first:last])

        return self.rows.filtered(at, block_size)


@dataclass(frozen=True, eq=False)
class FilteredLog:
    """One log in the band of a run; arrays at the sampling rate of the log.

    Attributes:
        samples: the log as sampled, with unfiltered torque.
        band: the filters of the run.
        q: (N, n) positions below the cutoff, rad (m).
        qd: (N, n) speeds below it: measured, or the derivative of q.
        slopes: speeds and their derivatives, both from the filter; None without a filter.
        base: specific force, angular velocity and acceleration of a base that moves, (N, 3) each,
            through the filter of the speeds; empty for a base at rest.

    A floating base has six equations, before those of the joints: m = n + 6. Else m = n.
    """

    samples: Samples
    band: Band
    q: FloatArray
    qd: FloatArray
    slopes: tuple[FloatArray, FloatArray] | None = None
    base: tuple[FloatArray, ...] = ()

    @property
    def name(self) -> str:
        """Name of the log."""
        return self.samples.name

    @property
    def t(self) -> FloatArray:
        """(N,) time, s."""
        return self.samples.t

    @property
    def base_rows(self) -> int:
        """Number of equations of a floating base."""
        robot = self.samples.robot
        return len(robot.free) if robot is not None else 0

    @property
    def width(self) -> int:
        """Number of equations, m."""
        joints: int = self.q.shape[1]
        return self.base_rows + joints

    @cached_property
    def tau(self) -> FloatArray:
        """(N, m) measured torque, N m (N), not filtered. On a floating base, it has the forces on
        the links, and unknown ones are projected out.
        """
        return measured_forces(self.samples, self._places) if self.base_rows else self.samples.tau

    @cached_property
    def _places(self) -> FloatArray:
        """Positions for Jacobians, which are the same for every cutoff, (N, n)."""
        return smoothed(self.samples.q, self.step, MARGIN * self.band.comparison_hz)

    @cached_property
    def hides(self) -> bool:
        """Whether unknown forces act at contacts."""
        return touching(self.samples) is not None

    def contacts(self, stride: int = 1) -> FloatArray | None:
        """Return the Jacobian of contacts with unknown forces, at every `stride`-th sample."""
        if self.samples.touches is None:
            return None
        every = slice(None, None, stride)
        return contact_jacobian(self.samples.cut(every), self._places[every])

    @cached_property
    def spread(self) -> Callable[[int], FloatArray]:
        """`_spread`, which keeps the last ones: every candidate of a search asks for them."""
        return lru_cache(maxsize=2)(self._spread)

    def _spread(self, stride: int) -> FloatArray:
        """Return what a torque of 1 N m of each joint adds to each equation, (k, m, n), at every
        `stride`-th sample; k = 1 if this is the same for all samples.
        """
        n = self.width - self.base_rows
        alone = np.pad(np.eye(n), ((self.base_rows, 0), (0, 0)))[None]
        J = self.contacts(stride)
        return alone if J is None else projected(np.repeat(alone, len(J), axis=0), J)

    @property
    def step(self) -> float:
        """Sampling step, s."""
        return self.samples.step

    @cached_property
    def mask(self) -> Mask | None:
        """The samples that no equation may use, (N, m). On a floating base, all equations of a
        sample have one mask.
        """
        mask = self.samples.mask
        if mask is None or not self.base_rows:
            return mask
        any_row = mask.robot | mask.joint.any(axis=1)
        return Mask(np.repeat(any_row[:, None], self.width, axis=1), mask.robot)

    @cached_property
    def unmasked(self) -> FilteredLog:
        """The log as if no sample were masked."""
        if self.mask is None:
            return self
        return replace(self, samples=replace(self.samples, mask=None))

    @cached_property
    def at_rest(self) -> Bools | None:
        """Whether joints stand still, (N, m); None if none does."""
        rests = self.band.rests
        if rests is None:
            return None
        at_rest = resting(self.samples.q, self.step, np.array(rests.slow))
        if not at_rest.any():
            return None
        return np.pad(at_rest, ((0, 0), (self.base_rows, 0))) if self.base_rows else at_rest

    def nodes(self, stride: int) -> tuple[FloatArray, FloatArray]:
        """Return positions and speeds of every `stride`-th sample."""
        return np.ascontiguousarray(self.q[::stride]), np.ascontiguousarray(self.qd[::stride])

    @cached_property
    def qdd(self) -> FloatArray:
        """(N, n) accelerations: the derivative of the speeds, rad/s2 (m/s2)."""
        if self.slopes is not None and self.slopes[0] is self.qd:
            return self.slopes[1]
        return self.rates

    @cached_property
    def rates(self) -> FloatArray:
        """(N, n) derivative of the speeds by a spline, rad/s2 (m/s2)."""
        return differentiate(self.qd, self.step)

    @property
    def motion(self) -> tuple[FloatArray, ...]:
        """The arrays that the torque model takes: q, qd, qdd, and the motion of the base."""
        return (self.q, self.qd, self.qdd, *self.base)

    @property
    def stride(self) -> int:
        """Samples from one node to the next."""
        if not self.band.filters(self.step):
            return 1
        highest = max(self.band.cutoff_hz, self.band.comparison_hz)
        return max(1, int(1 / (_NODES * highest * self.step)))

    @cached_property
    def rows(self) -> Decimation:
        """Low-pass of the comparison band on the nodes, and the samples that are kept."""
        return decimation(len(self.t), self.step, self.stride, self.band.comparison_hz)

    @property
    def kept(self) -> Places:
        """Numbers of the samples at which torques are compared and solved, (K,)."""
        return self.rows.kept

    @property
    def compared_t(self) -> FloatArray:
        """Times of the kept samples, (K,) s."""
        return self.t[self.kept]

    @cached_property
    def measured(self) -> FloatArray:
        """Measured torque in the comparison band at the kept samples, (K, n)."""
        return self.compared(self.tau)

    @property
    def smooth_stride(self) -> int:
        """Samples between the nodes that smooth functions of the motion need."""
        rows = self.rows
        if rows.cutoff is None:
            return 1
        highest = max(_SMOOTH * self.band.cutoff_hz, _NODES * rows.cutoff)
        return max(rows.stride, int(1 / (highest * self.step)))

    @cached_property
    def thinned(self) -> FilteredLog:
        """The log sampled at its nodes only, which is enough for smooth signals."""
        return self.every(self.rows.stride)

    def every(self, stride: int) -> FilteredLog:
        """Return the log at every `stride`-th sample only."""
        if stride == 1:
            return self
        samples = self.samples.cut(slice(None, None, stride))
        q, qd = self.nodes(stride)
        samples = replace(samples, step=stride * self.step)
        slopes = qd, np.ascontiguousarray(self.qdd[::stride])
        base = tuple(np.ascontiguousarray(x[::stride]) for x in self.base)
        return replace(self, samples=samples, q=q, qd=qd, slopes=slopes, base=base)

    def compared(self, x: FloatArray, stride: int | None = None) -> FloatArray:
        """Return a signal (N, n, ...) in the comparison band at the kept samples, (K, n, ...).

        Masked samples have no influence: both sides of a comparison are multiplied by `weight`
        before the low-pass.

        Args:
            x: the signal at all samples, or at the nodes only.
            stride: samples from one row of x to the next; None for either of these.
        """
        rows = self.rows
        if stride is None:
            stride = rows.stride if len(x) == rows.nodes else 1
        x = x if self.weight is None else _weighed(x, self.weight[::stride])
        if rows.cutoff is None:
            return x[self.kept]
        if stride == 1:
            return lowpass(x, self.step, rows.cutoff)[self.kept]
        return replace(rows, stride=stride).filtered(lambda first, last: x[first:last])

    @cached_property
    def weight(self) -> FloatArray | None:
        """(N, n) weight: 0 at masked samples, 1 from a quarter period away; None without a mask."""
        if self.mask is None:
            return None
        from scipy.ndimage import distance_transform_edt

        reach = max(1, round(0.25 / (self.band.comparison_hz * self.step)))
        away = [
            distance_transform_edt(~masked) if masked.any() else np.full(len(masked), reach)
            for masked in self.mask.joint.T
        ]
        return np.sin(np.pi / 2 * np.minimum(np.column_stack(away) / reach, 1.0)) ** 2

    def at_nodes(self, stride: int | None = None) -> Nodes:
        """Return the motion at every `stride`-th sample; None for `FilteredLog.stride`."""
        rows = self.rows if stride is None else replace(self.rows, stride=stride)
        every = self.stride if stride is None else stride
        motion = tuple(np.ascontiguousarray(x[::every]) for x in self.motion)
        weight = None if self.weight is None else self.weight[::every]
        return Nodes(rows, motion, weight, self.contacts(every), self.base_rows)

    @cached_property
    def resting(self) -> Bools | None:
        """Whether a rest of the joint affects a kept sample, (K, n); None if no joint rests."""
        if self.at_rest is None:
            return None
        reach = round(_REST_REACHES / (self.band.comparison_hz * self.step))
        return touched(self.at_rest, reach)[self.kept]

    def rest_weight(self, resting: Bools | None) -> FloatArray:
        """Return the weight of rows: that of the band where a rest of the joint affects them.

        Args:
            resting: (K, n) whether a rest affects a row; None, for a weight of one, without rests.
        """
        if resting is None or self.band.rests is None:
            return np.ones((1, self.width))
        weight = (*(1.0,) * self.base_rows, *self.band.rests.weight)
        return np.where(resting, weight, 1.0)

    @cached_property
    def clear(self) -> Bools:
        """Whether a sample is a period of the comparison band away from the mask, (N, n)."""
        if self.mask is None:
            return np.ones((len(self.q), self.width), dtype=bool)
        return ~self.mask.near(self.reach)

    @property
    def reach(self) -> int:
        """Number of samples before and after that a sample influences: a period of the band."""
        return 0 if self.rows.cutoff is None else int(1 / (self.rows.cutoff * self.step))

    @cached_property
    def free(self) -> Bools:
        """Whether a kept sample of a joint is out of the reach of the mask, (K, n)."""
        if self.weight is None:
            return np.ones((len(self.kept), self.width), dtype=bool)
        weight = self.weight
        if self.rows.cutoff is None:
            return weight[self.kept] > _HARDLY
        return lowpass(weight, self.step, self.rows.cutoff)[self.kept] > _HARDLY


def kept_spans(logs: Sequence[FilteredLog]) -> list[slice]:
    """Return the span of each log among the kept samples of all logs."""
    return spans_of(len(log.kept) for log in logs)


def spans_of(counts: Iterable[int]) -> list[slice]:
    """Return the places of parts of some lengths, one after the other."""
    ends = itertools.accumulate(counts, initial=0)
    return [slice(*edges) for edges in itertools.pairwise(ends)]


def _weighed(x: FloatArray, weight: FloatArray) -> FloatArray:
    """Multiply (k, n, ...) by (k, n)."""
    return (x.T * weight.T).T


def filter_log(samples: Samples, band: Band, q: FloatArray | None = None) -> FilteredLog:
    """Filter a log for the band of a run.

    Measured speeds pass the same filter as positions; derived ones are the derivative of the
    filtered positions.

    Args:
        samples: the log.
        band: band of the run.
        q: its filtered positions, if already computed and speeds are measured.
    """
    derived = band.velocity == "derived" or samples.velocity_derived
    base = base_motion(samples, band)
    qdd = None
    if not band.filters(samples.step):
        q, qd = samples.q, samples.qd
        if derived:
            qd = differentiate(q, samples.step)
    elif derived:
        q, qd, qdd = lowpass_and_slopes(samples.q, samples.step, band.cutoff_hz, 2)
    else:
        q = lowpass(samples.q, samples.step, band.cutoff_hz) if q is None else q
        qd, qdd = lowpass_and_slopes(samples.qd, samples.step, band.cutoff_hz, 1)
    qd = np.where(np.abs(qd) < _STANDS, 0.0, qd)
    return FilteredLog(samples, band, q, qd, None if qdd is None else (qd, qdd), base)


def unfiltered(samples: Samples) -> FilteredLog:
    """Return a log with unfiltered positions and speeds, for planned or simulated motion."""
    rate = 1 / samples.step
    band = Band(rate, rate / 2, comparison_band([samples]), "measured")
    return FilteredLog(samples, band, samples.q, samples.qd, base=base_motion(samples, band))

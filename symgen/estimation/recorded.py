"""A fault of channels is judged: what is left of the error of the torques when it is undone."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symgen.data.mask import Bools
from symgen.estimation.filtered import FilteredLog
from symgen.estimation.summary import Blocks, block_errors, held_out_error, placed, summary
from symgen.estimation.system import Equations, torque_equations
from symgen.runtime.evaluator import Evaluator

FloatArray = NDArray[np.float64]
Rows = Sequence[tuple[Equations, ...]]
Logs = tuple[Sequence[FilteredLog], Rows]
#: A fault is named where undoing it leaves so much of the error on folds left out, at most.
CLEARER = 0.9
STD = 3.0
_AT_REST = 1e-3  # weight of rows at rest: they are kept for what no motion determines


@dataclass(frozen=True, eq=False)
class Recorded:
    """Torques as they are recorded.

    Attributes:
        base: summary of the training logs.
        other: of the validation logs, or None.
        own: what `block_errors` are for the training logs.
    """

    base: Blocks
    other: Blocks | None
    own: FloatArray

    def left(
        self, train: Blocks, held: Callable[[], Blocks], sure: Bools | None = None
    ) -> tuple[float, float]:
        """Return what undoing a fault leaves; 1 where other logs do not confirm it.

        Args:
            train: summary of the training logs with the fault undone.
            held: gives that of the validation logs, where there are any; not asked in vain.
            sure: joints whose gain is known to be no chance; None to see that from the blocks.
        """
        after = block_errors(train, train)
        if held_out_error(after) > 1.0:  # no model at all does better: nothing is known
            return 1.0, 1.0
        share, together = what_is_left(self.own, after, sure)
        if self.other is None:
            return share, together
        # Where few blocks of the training logs hold the gain, those of other logs may be sure.
        unsure = share > CLEARER and sure is None
        if unsure:
            share, together = what_is_left(self.own, after, np.ones(self.own.shape[1], dtype=bool))
        if share > CLEARER:
            return 1.0, 1.0
        right = held()
        before, X = _shares(self.other, self.base.fit()), train.fit()
        # The fault may be one of the training logs alone.
        plain = [] if right.grams.shape != self.other.grams.shape else [_shares(self.other, X)]
        for now in (_shares(right, X), *plain):
            found = what_is_left(before, now, None if unsure else np.ones(len(before[0]), bool))
            if found[0] <= CLEARER:
                return share, together
        return 1.0, 1.0


def equations_of(evaluator: Evaluator, logs: Iterable[FilteredLog]) -> Rows:
    """Return the torque equations of logs, of which rests say nothing: they blame no channel."""
    return [
        tuple(e.with_rest_weight(_AT_REST) for e in torque_equations(evaluator, log))
        for log in logs
    ]


def with_column(
    log: FilteredLog, rows: tuple[Equations, ...], column: FloatArray
) -> tuple[Equations, ...]:
    """Return the equations of one log with one more unknown, common to its joints.

    Args:
        log: the log.
        rows: its equations, joint by joint.
        column: (K, n) of the unknown, at the kept samples.
    """
    out = []
    for j, e in enumerate(rows):
        own = column[:, j] if log.mask is None else column[log.free[:, j], j]
        out.append(replace(e, W=np.column_stack([e.W, own * e.scale]), Z=None))
    return tuple(out)


def recorded(equations: Rows, held: Rows) -> Recorded:
    n = len(equations[0])
    base = summary(placed(equations), n)
    other = summary(placed(held), n) if held else None
    return Recorded(base, other, block_errors(base, base))


def _shares(blocks: Blocks, X: FloatArray) -> FloatArray:
    """Return ||y - W X||^2 of every block over ||y||^2 of all of them, by joint, (B, m)."""
    measured = blocks.grams[:, :, -1, -1].sum(axis=0)
    errors = np.stack([blocks.errors([b], X) for b in range(len(blocks.grams))])
    return np.asarray(errors / np.where(measured > 0, measured, np.inf))


def what_is_left(
    own: FloatArray, other: FloatArray, sure: Bools | None = None
) -> tuple[float, float]:
    """Return what is left of the error of the joint that gains most, and of all; 1 for chance.

    All joints together, each in units of its own error, must gain; as must the torques themselves.
    """
    whole, rest = own.sum(axis=0), other.sum(axis=0)
    scale = 1 / np.where(whole > 0, whole, np.inf)
    together = float(np.sqrt((rest * scale).sum() / max((whole * scale).sum(), 1e-300)))
    if together >= 1.0 or rest.sum() >= whole.sum():
        return 1.0, 1.0
    gained = own - other
    deviation = gained.std(axis=0, ddof=1) * np.sqrt(len(gained))
    sure = gained.sum(axis=0) > STD * deviation if sure is None else sure
    return float(np.sqrt(rest * scale)[sure & (whole > 0)].min(initial=1.0)), together

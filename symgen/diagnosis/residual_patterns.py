"""The place of a gap: which joints, and on what each joint's residual depends.

The pattern of a joint is that of the effect which explains most of its residual, an effect of the
library that was named or any other.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symgen.diagnosis.baseline import Baseline
from symgen.diagnosis.contacts import NAME as CONTACT
from symgen.diagnosis.contacts import Contact
from symgen.diagnosis.diagnosis import Gap, Place
from symgen.diagnosis.effects import Score, candidates
from symgen.diagnosis.model_based_effects import special_candidates
from symgen.diagnosis.whitened_system import gain_of
from symgen.estimation.floor import quiet
from symgen.robot.effect import definitions

_PRICE = 0.015  # of each coefficient and constant of an effect that explains a residual
_ORGANISED = 0.3  # smallest share, less the price, that names a pattern
#: Part of a joint's squared residual that what explains it may leave.
EXPLAINED = 0.5


def _patterns(baseline: Baseline, joints: Sequence[int]) -> dict[int, str]:
    """Return the pattern of the effect that explains most of the residual of each of some joints.

    "all" where no effect explains enough of it.
    """
    base, robot = baseline.base, baseline.robot
    if not joints:
        return {}
    every = (*candidates(robot, base.logs), *special_candidates(robot, ()))
    pool = [c for c in every if not set(joints).isdisjoint(c.joints)]
    best = dict.fromkeys(joints, (_ORGANISED, "all"))
    for c, columns in zip(pool, baseline.seen(base).each(pool), strict=True):
        for j in set(joints).intersection(c.joints):
            share = gain_of(base, {j: columns[j]}) - _PRICE * (c.size + len(c.constants))
            if share > best[j][0]:
                best[j] = share, c.definition.pattern
    return {j: pattern for j, (_, pattern) in best.items()}


def places(
    baseline: Baseline,
    accepted: Sequence[Score],
    contacts: Sequence[Contact],
    before: Gap,
    floor: Gap,
    least: float,
) -> tuple[Place, ...]:
    """Return the joints with a visible gap, or the one with the largest, the largest share first.

    The pattern is that of the named effect that closes the joint's gap, if there is one. Otherwise
    it is that of the effect which alone explains most of it.

    Args:
        baseline: the declared model.
        accepted: the effects that were found.
        contacts: the contacts; the first one on a joint gives the time of its gap.
        before, floor: gap and noise floor on the held-out data.
        least: smallest torque that matters, as a part of the joint's torque.
    """
    gap, noise = np.asarray(before.per_joint), np.nan_to_num(floor.per_joint)
    excess = np.maximum(gap**2 - noise**2, 0)
    loud = [not quiet([g], [f], least) for g, f in zip(gap, noise, strict=True)]
    excess = np.where(loud if any(loud) else excess == excess.max(), excess, 0)
    if not excess.sum():
        return ()
    robot, base = baseline.robot, baseline.base
    left = baseline.beside(accepted).sigma ** 2 / base.sigma**2
    pushed = {j: c for c in reversed(contacts) for j in c.event.joints}
    order = [*map(int, np.argsort(-excess)[: int(np.count_nonzero(excess))])]
    known = {}
    for j in order:
        named = [
            s.candidate.definition.pattern
            for s in accepted
            if not s.candidate.definition.own and j in (s.candidate.joints or range(robot.n))
        ]
        contact = pushed.get(j)
        if contact is not None and contact.gain > 1 - EXPLAINED:
            known[j] = definitions()[CONTACT].pattern
        elif named and left[j] < EXPLAINED:
            known[j] = named[0]
    known |= _patterns(baseline, [j for j in order if j not in known])
    out = []
    for j in order:
        contact = pushed.get(j)
        time = None if contact is None else (contact.event.start, contact.event.end)
        share = float(excess[j] / excess.sum())
        out.append(Place(robot.movable[j].number, share, known[j], time))
    return tuple(out)

"""Names that a misfit without a name would have got as well.

Where more than noise is left, there is something on the joint that no effect is: a torque of some
unknown shape, a smooth function of the motion. It repeats with the motion, so that neither blocks
of time nor folds nor another log tell it from an effect; and of many candidates one always
resembles it. How much, random smooth functions say:

    f = sum of sin(w' x + phase),  x the positions and speeds of the joint and of another one

over their spread, w standard normal: a Gaussian field with a range of about one spread (Rahimi and
Recht 2007). Of such a torque, in the band and beside the model, the best of all candidates on the
joint explains a share; what an effect explains, over that and what is left above the noise, has to
be larger than that share is in all but 1 of 20 draws, every joint counted. A misfit of one shape
alone, one bend or bump, resembles some effect more often than that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from symgen.diagnosis.search import Search, Selection
from symgen.diagnosis.select import Score, project
from symgen.diagnosis.whitened_system import Columns, WhitenedSystem
from symgen.estimation.filtered import FilteredLog

FloatArray = NDArray[np.float64]
_DRAWS, _SINES, _ALLOWED = 400, 24, 0.05
_SEED = 11


def beyond_misfit(selection: Selection, search: Search, noise: FloatArray) -> Selection:
    """Take names away that a misfit would have got as well, the least sure one first.

    Args:
        selection: of the search.
        search: with its candidates.
        noise: (n,) standard deviation of the torque's noise in the band.
    """
    base, accepted = search.baseline.base, list(selection.accepted)
    withdrawn: list[Score] = []
    bars: dict[tuple[int, ...], float] = {}
    while accepted:
        asked = [s for s in accepted if _of_one_joint(s) and not s.candidate.measured]
        shares = [share_of_unknown(base, accepted, s, noise) for s in asked]
        below = []
        for s, share in zip(asked, shares, strict=True):
            joints = s.candidate.joints
            if share < _SURE and joints not in bars:
                bars[joints] = chance_share(search, joints)
            if share < _SURE and share < bars[joints]:
                below.append((share / bars[joints], share, s))
        if not below:
            break
        _, share, worst = min(below, key=lambda entry: entry[0])
        accepted = [s for s in accepted if s is not worst]
        fault = (
            f"it is {100 * share:.2g} % of what it leaves with it; of a torque of any shape some "
            f"effect explains {100 * bars[worst.candidate.joints]:.2g} % by chance"
        )
        withdrawn.append(replace(worst, fault=fault))
    rejected = (*withdrawn, *selection.rejected)
    return replace(selection, accepted=tuple(accepted), rejected=rejected)


def _of_one_joint(score: Score) -> bool:
    """Whether an effect is a torque of one joint alone: a length, say, shows on others, too."""
    joints = score.candidate.joints
    return len(joints) == 1 and all(j == joints[0] or not c.any() for j, c in score.columns.items())


#: Shares that no bar reaches.
_SURE = 0.95


def share_of_unknown(
    base: WhitenedSystem, accepted: Sequence[Score], own: Score, noise: FloatArray
) -> float:
    """Return what an effect explains beside the others, over that and what is left above noise."""
    joints = list(own.candidate.joints)
    rest = base.with_columns(s.columns for s in accepted if s is not own)
    p = project(rest, own.columns)
    if p.free.shape[2] == 0:
        return 0.0
    explained = p.free @ p.fit
    gained = float(np.sum(explained[:, joints] ** 2))
    left = rest.residual[:, joints] - explained[:, joints]
    hiss = rest.moves[:, joints] * noise[joints] / rest.sigma[joints]
    unknown = max(float(np.sum(left**2) - np.sum(hiss**2)), 0.0)
    return gained / max(gained + unknown, 1e-300)


def chance_share(search: Search, joints: tuple[int, ...]) -> float:
    """Return the share of a random smooth torque that some candidate on a joint explains.

    Returns:
        The quantile that 1 of 20 draws of all joints is beyond.
    """
    (j,) = joints
    base = search.baseline.base
    drawn = _drawn(base, j)
    best = np.zeros(drawn.shape[1])
    for _, columns in search.on_joints(joints):
        free = _orthonormal(base, columns, j)
        best = np.maximum(best, np.sum((free.T @ drawn) ** 2, axis=0))
    return float(np.quantile(best, 1 - _ALLOWED / base.n))


def _orthonormal(base: WhitenedSystem, columns: Columns, j: int) -> FloatArray:
    """Return an orthonormal basis of what a candidate has apart from the model, (K, r)."""
    free = project(base, columns).free[:, j]
    size = np.linalg.norm(free, axis=0)
    return np.asarray(free / np.where(size > 0, size, 1.0))


def _drawn(base: WhitenedSystem, j: int) -> FloatArray:
    """Return random smooth torques on a joint, apart from the model, of unit size, (K, draws)."""
    rng = np.random.default_rng(_SEED)
    n = base.n
    others = rng.integers(0, n, _DRAWS)
    w = rng.normal(size=(_DRAWS, _SINES, 4))
    phase = rng.uniform(0, 2 * np.pi, (_DRAWS, _SINES))
    spread = [np.concatenate([getattr(s, key) for s in base.logs]).std(axis=0) for key in _STATE]
    unit = [np.where(x > 0, x, 1.0) for x in spread]
    seen = np.concatenate([_fields(s, j, others, w, phase, unit) for s in base.logs])
    out = seen * (base.moves[:, j] / base.sigma[j])[:, None]
    basis = base.basis[:, j]
    # on the one joint the model's columns of all joints have a say
    out = out - basis @ (basis.T @ out)
    return np.asarray(out / np.maximum(np.linalg.norm(out, axis=0), 1e-300))


_STATE = ("q", "qd")


def _fields(
    s: FilteredLog,
    j: int,
    others: NDArray[np.int64],
    w: FloatArray,
    phase: FloatArray,
    unit: Sequence[FloatArray],
) -> FloatArray:
    """Return random fields along a log at the kept instants, (K, draws)."""
    q, qd = s.q[s.kept] / unit[0], s.qd[s.kept] / unit[1]
    out = np.empty((len(q), len(others)))
    for d, k in enumerate(others):
        x = np.stack([q[:, j], q[:, k], qd[:, j], qd[:, k]], axis=1)
        out[:, d] = np.sin(x @ w[d].T + phase[d]).sum(axis=1)
    return out

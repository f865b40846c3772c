"""Number of base parameters by singular values of random energy differences, in float64."""

from collections.abc import Sequence

import numpy as np

from oracles.transforms import PRISMATIC, Arm, column_names, energy_regressor

FRICTION = ("coulomb", "viscous", "offset")
# Root mean square below which a column is rounding noise: samples, lengths and gravity are of the
# order of 1 to 10, so real columns are above 1e-5 and noise is below 1e-13.
NOISE = 1e-10
# Relative singular values: kept ones are above, dropped ones below, and none may lie between.
KEPT, DROPPED = 1e-8, 1e-12
GAP = 1e4


class NoGapError(ArithmeticError):
    """The singular values do not fall into a kept and a dropped group."""


def friction_terms(arm: Arm, friction: Sequence[str] | Sequence[Sequence[str]]) -> tuple:
    """Friction of every movable joint, in file order.

    Args:
        arm: the table.
        friction: names for all movable joints, or one sequence of names per joint of the file.

    Returns:
        One tuple of names per movable joint.
    """
    if all(isinstance(entry, str) for entry in friction):
        per_joint = [tuple(friction)] * arm.links
    else:
        per_joint = [tuple(entry) for entry in friction]
    if len(per_joint) != arm.links or not {t for e in per_joint for t in e} <= set(FRICTION):
        raise ValueError(f"friction of {arm.links} joints, any of {FRICTION}: {friction}")
    return tuple(per_joint[j - 1] for j in arm.movable)


def random_states(arm: Arm, samples: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Random q, qd of shape (samples, n): any angle, +-1 m, +-2 rad/s or m/s."""
    rng = np.random.default_rng(seed)
    reach = [1.0 if arm.sigma[j - 1] == PRISMATIC else np.pi for j in arm.movable]
    q = rng.uniform(-1.0, 1.0, (samples, arm.n)) * reach
    return q, rng.uniform(-2.0, 2.0, (samples, arm.n))


def difference_matrix(
    arm: Arm,
    rotor: bool | Sequence[bool] = True,
    friction: Sequence[str] | Sequence[Sequence[str]] = (),
    seed: int = 0,
    samples: int | None = None,
) -> tuple[np.ndarray, tuple[str, ...]]:
    """Random rows h(x) - h(x0) and their column names.

    The standard inertial columns come first, then ``OFj`` with the column q_j - q_j0 for the
    joints that declare an offset. FS and FV have no column: theirs are integrals along the path.
    """
    names = column_names(arm, rotor)
    offsets = [i for i, terms in enumerate(friction_terms(arm, friction)) if "offset" in terms]
    names += tuple(f"OF{arm.movable[i]}" for i in offsets)
    q, qd = random_states(arm, 1 + (samples or 2 * len(names) + 30), seed)
    columns = np.hstack([energy_regressor(arm, q, qd, rotor), q[:, offsets]])
    return columns[1:] - columns[0], names


def numeric_rank(matrix: np.ndarray) -> int:
    """Rank with a proof of distance: columns of unit norm, and a clear gap after the last kept one.

    A column that is negligible in absolute terms is set to zero, not scaled: brought to unit norm,
    pure rounding noise counts as a parameter.

    Raises:
        NoGapError: a singular value or a column is too small to be kept and too large to be
            rounding, or the last kept value is not 1e4 times the first dropped one.
    """
    norm = np.sqrt(np.mean(matrix**2, axis=0))
    real = norm > NOISE
    if np.any(real & (norm < GAP * NOISE)):
        raise NoGapError(f"columns neither noise nor signal: {norm[real].min():.1e}")
    if not real.any():
        return 0
    unit = matrix[:, real] / np.linalg.norm(matrix[:, real], axis=0)
    values = np.linalg.svd(unit, compute_uv=False)
    values = values / values[0]
    rank = int(np.count_nonzero(values > DROPPED))
    first_dropped = max(values[rank] if rank < len(values) else 0.0, 1e-16)
    if values[rank - 1] < max(KEPT, GAP * first_dropped):
        raise NoGapError(f"kept {values[rank - 1]:.1e}, dropped {first_dropped:.1e}")
    return rank


def count_base_parameters(
    arm: Arm,
    rotor: bool | Sequence[bool] = True,
    friction: Sequence[str] | Sequence[Sequence[str]] = (),
    seed: int = 0,
) -> int:
    """Number of identifiable combinations of the standard parameters.

    FS and FV add one each: the integrals of |qd| and qd**2 between two states take any value above
    a bound that depends on the path, so that no function of the states replaces them. An offset is
    conservative and takes part in the rank.

    Args:
        arm: the table.
        rotor: rotor inertias; one flag for all joints or one per joint of the file.
        friction: names among coulomb, viscous, offset, for all or one sequence per joint.
        seed: of the random samples.

    Raises:
        NoGapError: the count is not certain in float64.
    """
    matrix, _ = difference_matrix(arm, rotor, friction, seed)
    terms = friction_terms(arm, friction)
    dissipative = sum(name != "offset" for names in terms for name in set(names))
    return numeric_rank(matrix) + dissipative

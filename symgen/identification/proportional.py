"""Joints that move in proportion, so that the logs cannot tell their parameters apart."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np

from symgen.errors import IdentificationError
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.solve import column_norms
from symgen.robot.types import Robot

#: Two speeds are proportional if the sine of the angle between them is below this.
PROPORTIONAL = 0.03


@contextmanager
def blame_motion(fault: str) -> Iterator[None]:
    """Add a fault of the motion to the error that the data do not determine the parameters.

    Raises:
        IdentificationError: the data do not determine the parameters.
    """
    try:
        yield
    except IdentificationError as error:
        raise IdentificationError(f"{error}; {fault}" if fault else str(error)) from error
    except np.linalg.LinAlgError as error:
        raise IdentificationError(
            "the information matrix is singular: these data do not determine the parameters"
            + (f"; {fault}" if fault else "")
        ) from error


def proportional_joints(logs: Sequence[FilteredLog]) -> tuple[tuple[int, ...], ...]:
    """Return the groups of joints whose speeds are proportional in all logs.

    The arm then moves like one with fewer degrees of freedom, and the information matrix is
    singular (a warning of Gautier and Khalil).

    Args:
        logs: logs in the band of the campaign.
    """
    from scipy.sparse.csgraph import connected_components

    qd = np.concatenate([log.qd for log in logs])
    if not qd.size:
        return ()
    unit = qd / column_norms(qd)
    cosines = unit.T @ unit
    sines = np.sqrt(np.maximum(0.0, 1 - cosines**2))
    count, label = connected_components(sines < PROPORTIONAL, directed=False)
    groups = (np.flatnonzero(label == k) for k in range(count))
    return tuple(tuple(map(int, group)) for group in groups if len(group) > 1)


def motion_fault(proportional: Sequence[Sequence[int]], robot: Robot) -> str:
    """Return a text that says why a motion cannot excite a model, or "".

    Args:
        proportional: groups of joints whose speeds are proportional.
        robot: gives the names of joints.
    """
    return "; ".join(
        f"the speeds of {robot.listed(group)} are proportional to each other "
        "throughout; move the joints independently"
        for group in proportional
    )

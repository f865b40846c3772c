"""Gaps of diagnoses that tests write by hand."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symgen.diagnosis.diagnosis import Gap


def whole_gap(per_joint: Sequence[float]) -> Gap:
    """Return a gap of joints of equal torque."""
    return Gap(tuple(per_joint), float(np.sqrt(np.mean(np.square(per_joint)))))

"""The study of the on-line identifier, with few samples."""

from __future__ import annotations

import shutil

import numpy as np
import pytest
from support import sampled
from workflow.identifier_study import ANY_ROBOT, CASES, Online, moving, plant, studied

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="no C compiler (gcc)")
RUNS = [(case, model, dtype) for case in CASES for model in ("energy", "momentum")
        for dtype in ("double", "float")]  # fmt: skip


@pytest.mark.parametrize(("case", "model", "dtype"), sampled(RUNS, 6))
def test_the_identifier_is_right_within_its_standard_deviation(case, model, dtype) -> None:
    """Drift is over ten memories, not over a thousand: it is left to the study."""
    row = studied(case, model, dtype, 100_000)
    if case == "rest":
        most = 1e-6 if dtype == "double" else 1e-3
        assert row.change <= most
        assert row.std_change <= most
        assert row.excited[1] < 0.01
    if case != "drift":
        assert row.above < 0.05
        assert row.gravity < 0.002
    else:
        assert row.gravity < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("case", ANY_ROBOT)
@pytest.mark.parametrize("dtype", ["double", "float"])
@pytest.mark.parametrize("model", ["energy", "momentum"])
@pytest.mark.parametrize("robot", ["panda", "ur10e"])
def test_arms_of_six_and_seven_joints(robot, model, dtype, case) -> None:
    """A load of 2 kg and outliers at the start, after 60 s each; wild samples throughout.

    4 standard deviations; those of windows that overlap are too small by up to a fifth.
    """
    row = studied(case, model, dtype, 60_000 if case == "load" else 1_000, robot)
    assert row.worst < 4 / 0.8
    assert row.gravity < 0.005


def test_outliers_that_do_not_stand_in_a_row_are_refused_however_many_they_are() -> None:
    """A torque that is 1000 times too large, once in two seconds; what is right stands between.

    The noise is such that hardly an equation agrees to a thousandth of the largest.
    """
    X = plant()[1]
    rng = np.random.default_rng(6)
    q, qd, tau = moving(0, 120_000, X)
    tau += 30.0 * rng.standard_normal(tau.shape)
    clean, spoiled = Online("energy", "double"), Online("energy", "double")
    clean.feed(q, qd, tau)
    tau[20_000::2_000] *= 1000.0
    spoiled.feed(q, qd, tau)
    (_, expected), (found, std) = clean.read(), spoiled.read()
    assert (std < 1.5 * expected).all()
    assert (np.abs(found - X) < 4 * std).all()

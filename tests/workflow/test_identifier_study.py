"""The study of the on-line identifier, with few samples."""

from __future__ import annotations

import shutil

import numpy as np
import pytest
from studies.identifier_study import (
    ANY_ROBOT,
    CASES,
    NOISE,
    Online,
    gravity_error,
    loaded,
    moving,
    plant,
    studied,
)
from support import sampled

import symgen

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


def gripped(robot: str, model: str, forgetting: float, seconds: int) -> None:
    """A load of 2 kg: no X without the status "changing" is worse than the X before, after 2 s.

    So long take eight windows, where the equation of a window may be too small to tell.
    """
    evaluator, X = plant(robot)
    identifier = symgen.Identifier(evaluator, 200, forgetting=forgetting, model=model)
    rng = np.random.default_rng(7)

    def changing(begin: int, true: np.ndarray) -> bool:
        parts = moving(begin, 1000, true, robot=robot)
        noisy = [x + s * rng.standard_normal(x.shape)
                 for x, s in zip(parts, NOISE.values(), strict=True)]  # fmt: skip
        for k, (q, qd, tau) in enumerate(zip(*noisy, strict=True)):
            identifier.step(q, qd, tau, 1e-3 * (begin + k))
        return identifier.status == "changing"

    assert not any(changing(1000 * k, X) for k in range(seconds))
    true, changed = loaded(robot), 0
    before = gravity_error(evaluator, identifier.read()[0], true)
    for k in range(seconds, 2 * seconds):
        waits = changing(1000 * k, true)
        error = gravity_error(evaluator, identifier.read()[0], true)
        changed += waits
        if waits:
            assert error == pytest.approx(before, rel=0.05)
        elif k > seconds + 1:
            assert error < before / 3
    assert changed > 0
    assert error < 0.01


@pytest.mark.parametrize("model", ["energy", "momentum"])
@pytest.mark.parametrize("forgetting", [1.0, 0.9995])
def test_x_of_before_is_read_until_a_gripped_load_is_known(model, forgetting) -> None:
    gripped("pair", model, forgetting, 12)


@pytest.mark.slow
@pytest.mark.parametrize("forgetting", [1.0, 0.9999, 0.9995, 0.999])
@pytest.mark.parametrize("model", ["energy", "momentum"])
@pytest.mark.parametrize("robot", ["panda", "puma560"])
def test_a_gripped_load_on_arms_of_six_and_seven_joints(robot, model, forgetting) -> None:
    """The energy model knows it after 60 s at the latest."""
    gripped(robot, model, forgetting, 60)

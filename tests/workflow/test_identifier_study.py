"""The study of the on-line identifier, with few samples."""

from __future__ import annotations

import shutil

import pytest
from support import sampled
from workflow.identifier_study import CASES, studied

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

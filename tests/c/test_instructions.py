"""Worst case on a Cortex-M7: instructions are counted as QEMU executes them."""

from __future__ import annotations

from pathlib import Path

import cortex_m7
import pytest
from cortex_m7 import instructions, sizes
from support import PROJECT

TABLE = PROJECT / "docs" / "worst_case.md"
pytestmark = pytest.mark.skipif(
    bool(cortex_m7.missing()), reason=f"{cortex_m7.missing()} is not on this machine"
)


@pytest.mark.parametrize("name", ["planar2r", "puma560"])
def test_in_double_no_kernel_takes_more_for_one_input_than_for_another(
    name: str, complete, tmp_path: Path
) -> None:
    counts = instructions(complete(name, "double"), tmp_path)
    assert len(counts) >= 13
    assert {k: set(v) for k, v in counts.items() if len(set(v)) > 1 or len(v) != 4} == {}
    assert 2 * counts["gravity_torque"][0] < counts["forward_dynamics"][0] < 3000


def test_far_angles_take_longer_as_the_header_says(complete, tmp_path: Path) -> None:
    near, far = instructions(complete("planar2r", "double"), tmp_path, (1.0, 1e6))["jacobian"]
    assert far > 2 * near


def test_in_single_precision_libm_takes_what_differs(complete, tmp_path: Path) -> None:
    counts = instructions(complete("puma560", "float"), tmp_path)
    for name, found in counts.items():
        assert max(found) - min(found) <= 6 * 60, name  # six angles at most
    assert len(set(counts["friction_power"])) == 1


def test_smooth_friction_takes_the_time_of_tanh(complete, tmp_path: Path) -> None:
    counts = instructions(complete("rich", "double"), tmp_path)
    assert len(set(counts["friction_power"])) > 1
    assert len(set(counts["mass_matrix"])) == 1


@pytest.mark.parametrize("dtype", ["double", "float"])
def test_the_table_is_what_is_counted(dtype: str, complete, tmp_path: Path) -> None:
    package = complete("planar2r", dtype)
    counts, bytes_of = instructions(package, tmp_path), sizes(package, tmp_path)
    rows = [line.split("|")[1:-1] for line in TABLE.read_text().splitlines() if line[:2] == "| "]
    found = {
        row[1].strip(): (
            int(row[2 if dtype == "double" else 4]),
            int(row[3 if dtype == "double" else 5]),
        )
        for row in rows
        if row[0].strip() == "planar2r"
    }
    assert set(found) == set(counts)
    for kernel, (count, size) in found.items():  # other versions of gcc may differ by little
        assert count == pytest.approx(max(counts[kernel]), rel=0.1, abs=20), kernel
        assert size == pytest.approx(bytes_of[kernel], rel=0.15, abs=60), kernel

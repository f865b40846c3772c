"""Worst case on a Cortex-M7: instructions are counted as QEMU executes them."""

from __future__ import annotations

import json
from pathlib import Path

import cortex_m7
import pytest
from cortex_m7 import instructions, sizes
from support import PROJECT

import symgen

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


def rows_of(page: Path) -> dict[str, list[str]]:
    """The rows of a README's table of instructions, by kernel."""
    text = page.read_text().partition("## Worst case on a Cortex-M7")[2].partition("\n## ")[0]
    listed = [line.split("|")[1:-1] for line in text.splitlines() if line[:3] == "| `"]
    return {row[0].strip(" `"): [cell.strip() for cell in row[1:]] for row in listed}


@pytest.mark.parametrize("name", ["planar2r", "puma560", "panda"])
def test_readmes_have_the_table_of_their_kernels(name: str) -> None:
    here = rows_of(PROJECT / "generated" / name / "README.md")
    manifest = json.loads((PROJECT / "generated" / name / "manifest.json").read_text())
    assert set(here) == {f"{name}_{kernel['name']}" for kernel in manifest["kernels"]}
    lines = [line.split("|")[1:-1] for line in TABLE.read_text().splitlines()]
    there = {
        f"{name}_{row[1].strip()}": [cell.strip() for cell in row[2:]]
        for row in lines
        if row and row[0].strip() == name
    }
    assert here == there


def test_a_robot_of_another_geometry_has_no_figures(tmp_path: Path) -> None:
    text = symgen.robot_toml(symgen.read_robot("planar2r")).replace("L1 = 0.5", "L1 = 0.6")
    other = symgen.derive(symgen.parse_robot(text), ("jacobian",))
    symgen.write_package(symgen.generate(other, target="c"), tmp_path / "planar2r")
    assert rows_of(tmp_path / "planar2r" / "README.md") == {}


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

"""The example of a package: it builds without a warning, and does what it says, or says no."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from packages import STRICT, STRICT_CXX, c_files, objects, run, write

Packages = Callable[[str, str], Path]
#: A robot of the library; everything that the format has; gravity as an input.
ROBOTS = [
    pytest.param("planar2r", "double"),
    pytest.param("puma560", "double", marks=pytest.mark.slow),
    pytest.param("rich", "float", marks=pytest.mark.slow),
    pytest.param("leaning", "double", marks=pytest.mark.slow),
]
needs_cc = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler on this machine")


def controller(package: Path) -> Path:
    """The example's source."""
    return package / "example" / f"{package.name}_controller.c"


def output_of(program: Path, cwd: Path) -> tuple[list[float], float, float, float]:
    """Run the example: errors of the parameters in turn, tracking errors, their ratio."""
    printed = run([program], cwd)
    figures = [float(x) for x in re.findall(r"(\S+) of their norm wrong", printed)]
    model, pd, ratio = (
        float(re.search(rf"^{label}: (\S+)$", printed, re.MULTILINE)[1])
        for label in ("computed torque", "PD", "ratio")
    )
    assert ratio == pytest.approx(pd / model, rel=0.02)
    return figures, model, pd, ratio


@needs_cc
@pytest.mark.parametrize(("name", "dtype"), ROBOTS)
def test_computed_torque_beats_pd_and_the_identifier_finds_the_truth(
    name: str, dtype: str, complete: Packages, tmp_path: Path
) -> None:
    package = complete(name, dtype)
    sources = [controller(package), *objects(package)]
    run(["cc", *STRICT, "-O2", f"-I{package}", *sources, "-lm", "-o", "controller"], tmp_path)
    figures, model, pd, ratio = output_of(tmp_path / "controller", tmp_path)
    assumed, *identified = figures
    assert 0.005 < assumed < 0.06  # 5 % of every part, in sums that may cancel
    assert len(identified) == 4
    assert identified[-1] < min(2e-3, identified[0] * 1.5, assumed / 20)
    assert 1e-6 < model < 5e-3  # rad: neither perfect nor lost
    assert 1e-3 < pd < 5e-2
    assert ratio >= 10


@needs_cc
def test_the_example_says_no_when_its_model_is_of_another_robot(
    complete: Packages, tmp_path: Path
) -> None:
    package = complete("planar2r", "double")
    simulated = package / "example" / f"{package.name}_simulated.h"
    text = simulated.read_text()
    begin = text.index("ASSUMED[] = {")
    end = text.index("};", begin)
    values = re.sub(r"-?\d+\.\d+", lambda v: repr(float(v[0]) * 0.5), text[begin:end])
    (tmp_path / simulated.name).write_text(text[:begin] + values + text[end:])
    shutil.copy(controller(package), tmp_path / "controller.c")
    run(["cc", f"-I{package}", "controller.c", *objects(package), "-lm", "-o", "c"], tmp_path)
    with pytest.raises(AssertionError, match=r"ratio: [0-9]\.[0-9]"):
        run([tmp_path / "c"], tmp_path)


@pytest.mark.slow
@needs_cc
def test_the_readme_says_how_to_build_and_run_it(complete: Packages, tmp_path: Path) -> None:
    package = complete("planar2r", "double")
    text = (package / "README.md").read_text()
    library = re.search(r"By hand: `(.+?)`", text)
    example = re.search(r"`(cc [^`]+ && ./controller)`", text)
    assert library is not None
    assert example is not None
    shutil.copytree(package, tmp_path / "copy")
    run(["sh", "-c", f"{library[1]} && {example[1]}"], tmp_path / "copy")


@pytest.mark.slow
@pytest.mark.parametrize("compiler", ["gcc", "clang", "g++", "clang++"])
@pytest.mark.parametrize(("name", "dtype"), ROBOTS)
def test_every_kernel_and_the_example_are_free_of_warnings_as_c99_and_cxx11(
    compiler: str, name: str, dtype: str, complete: Packages, tmp_path: Path
) -> None:
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not on this machine")
    package = complete(name, dtype)
    flags = STRICT_CXX if compiler.endswith("++") else STRICT
    programs = sorted((package / "example").glob("*.c"))
    assert len(programs) == 1
    files = [*c_files(package, check=True), *programs]
    run([compiler, *flags, "-fsyntax-only", f"-I{package}", *files], tmp_path)


def test_a_package_without_its_kernels_has_no_example(tmp_path: Path) -> None:
    energy = ("energy_regressor", "friction_power")
    dynamics = ("inverse_dynamics", "forward_dynamics", "mass_matrix")
    for number, kernels in enumerate((energy, dynamics, (*energy, *dynamics[:2]))):
        package = write("planar2r", "double", tmp_path / str(number), kernels)
        assert not (package / "example").exists()
        for file in ("README.md", "CMakeLists.txt"):
            assert "controller" not in (package / file).read_text()

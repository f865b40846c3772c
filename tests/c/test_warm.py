"""The code of kernels is warmed by NAME_warm, and unused kernels still leave a program."""

from __future__ import annotations

import re
import shutil
from collections.abc import Sequence
from pathlib import Path

import pytest
from packages import STRICT, run

import symgen

KERNELS = ("mass_matrix", "gravity_torque")
#: Every function has a page of its own, which the program can protect.
PAGES = ["-falign-functions=4096"]
#: reads(f, kernel): whether f reads the page of a kernel.
READS = """
#include <setjmp.h>
#include <signal.h>
#include <stdio.h>
#include <sys/mman.h>
#include "left.h"
#include "right.h"

static sigjmp_buf back;

static void caught(int number)
{
    siglongjmp(back, number);
}

static int reads(void (*warm)(void), void *kernel)
{
    volatile int read = 0;
    mprotect(kernel, 1, PROT_NONE);
    if (sigsetjmp(back, 1)) {
        read = 1;
    } else {
        warm();
    }
    mprotect(kernel, 1, PROT_READ | PROT_EXEC);
    return read;
}
"""
TWO = """
int main(void)
{
    double q[2] = {0.1, 0.2}, X[4] = {3.5, 0.06, 0.124, 0.006}, M[4];
    left_mass_matrix(q, X, M);
    signal(SIGSEGV, caught);
    void *mass = (void *)left_mass_matrix, *gravity = (void *)right_gravity_torque;
    printf("%d%d%d%d\\n", reads(left_warm, mass), reads(right_warm, mass),
        reads(left_warm, gravity), reads(right_warm, gravity));
    return !(M[0] > 0.0);
}
"""
#: What each of two shared libraries with the same package shows of it.
SHOWN = """
#include "left.h"
__attribute__((visibility("default"))) void WHICH_warm(void) { left_warm(); }
__attribute__((visibility("default"))) void *WHICH_kernel(void) { return (void *)left_mass_matrix; }
"""
LIBRARIES = """
void one_warm(void);
void *one_kernel(void);
void two_warm(void);
void *two_kernel(void);

int main(void)
{
    signal(SIGSEGV, caught);
    printf("%d%d%d%d\\n", reads(one_warm, one_kernel()), reads(two_warm, one_kernel()),
        reads(one_warm, two_kernel()), reads(two_warm, two_kernel()));
    return 0;
}
"""
ONE_KERNEL = """
#include "left.h"
int main(void)
{
    double q[2] = {0.1, 0.2}, X[4] = {3.5, 0.06, 0.124, 0.006}, M[4];
    WARM
    left_mass_matrix(q, X, M);
    return M[0] > 0.0;
}
"""
M7 = "arm-none-eabi-gcc -mcpu=cortex-m7 -mfpu=fpv5-d16 -mfloat-abi=hard"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The packages left and right of one robot, in one folder."""
    folder = tmp_path_factory.mktemp("warm")
    model = symgen.derive("planar2r", KERNELS)
    for name in ("left", "right"):
        for path, content in symgen.generate(model, target="c", prefix=name).files.items():
            if "/" not in path:
                (folder / path).write_bytes(content)
    return folder


def sources(folder: Path, *names: str) -> list[Path]:
    """The kernels of packages, and their warm-up."""
    return [folder / f"{name}_{part}.c" for name in names for part in (*KERNELS, "warm")]


def built(compiler: str, flags: Sequence[str], files: Sequence[str | Path], cwd: Path) -> None:
    """Compile and link, if the compiler is here."""
    command = compiler.split()
    if shutil.which(command[0]) is None:
        pytest.skip(f"{command[0]} is not on this machine")
    run([*command, *flags, *files, "-lm"], cwd)


@pytest.mark.parametrize(
    ("compiler", "flags"),
    [
        ("gcc", "-O0"),
        ("gcc", "-O2 -flto"),
        ("gcc", "-O2 -fvisibility=hidden -static"),
        ("gcc", "-O2 -ffunction-sections -Wl,--gc-sections"),
        ("gcc", "-O2 -ffunction-sections -Wl,--gc-sections -fuse-ld=gold"),
        ("clang", "-O2 -ffunction-sections -Wl,--gc-sections"),
        ("g++ -x c++", "-O2"),
        ("clang++ -x c++", "-O2"),
    ],
)
def test_a_package_reads_the_code_of_its_kernels_only(compiler, flags, folder, tmp_path) -> None:
    program = tmp_path / "program.c"
    program.write_text(READS + TWO)
    files = [program, *sources(folder, "left", "right")]
    built(compiler, [*flags.split(), *PAGES, f"-I{folder}", "-o", "program"], files, tmp_path)
    assert run([tmp_path / "program"], tmp_path) == "1001\n"


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_shared_libraries_read_their_own_code(compiler, folder, tmp_path) -> None:
    hidden = ["-O2", "-fPIC", "-shared", "-fvisibility=hidden", f"-I{folder}"]
    for name in ("one", "two"):
        shown = tmp_path / f"{name}.c"
        shown.write_text(SHOWN.replace("WHICH", name))
        files = [shown, *sources(folder, "left")]
        built(compiler, [*hidden, *PAGES, "-o", f"lib{name}.so"], files, tmp_path)
        symbols = run(["readelf", "-W", "--dyn-syms", f"lib{name}.so"], tmp_path)
        assert set(re.findall(r"(\w+) +\d+ __st\w+_code", symbols)) <= {"HIDDEN"}
    program = tmp_path / "program.c"
    program.write_text(READS + LIBRARIES)
    linked = ["-L.", "-lone", "-ltwo", "-Wl,-rpath,.", f"-I{folder}", "-o", "program"]
    built(compiler, [], [program, *linked], tmp_path)
    assert run([tmp_path / "program"], tmp_path) == "1001\n"


@pytest.mark.parametrize(
    ("compiler", "warm"),
    [("gcc", ""), ("gcc -flto", "left_warm();"), (f"{M7} --specs=nosys.specs", "left_warm();")],
)
def test_unused_kernels_leave_a_program(compiler, warm, folder, tmp_path) -> None:
    program = tmp_path / "program.c"
    program.write_text(ONE_KERNEL.replace("WARM", warm))
    flags = [*STRICT, "-O2", "-ffunction-sections", "-Wl,--gc-sections", f"-I{folder}"]
    files = [program, *sources(folder, "left")]
    built(compiler, [*flags, "-o", "program"], files, tmp_path)
    kept = re.findall(r" left_(\w+)", run(["nm", "program"], tmp_path))
    assert sorted(kept) == (["mass_matrix", "warm"] if warm else ["mass_matrix"])

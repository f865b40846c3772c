"""The worst-case stack that `symgen check` prints, against stacks painted and read at run time."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from packages import run

import symgen
from symgen.runtime.build import Compiler, find_compiler
from symgen.runtime.stack import worst_case_stack

needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not on this machine")

# Calls a function on a painted stack of its own and prints how deep the paint is gone. sin and cos
# are leaves of this file, so that nothing is left to libm.
PAINT = """#define _GNU_SOURCE
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "puma560_identifier.h"

double sin(double x) { return x * (1.0 - x * x / 6.0); }
double cos(double x) { return 1.0 - x * x / 2.0; }
void sincos(double x, double *s, double *c) { *s = x; *c = 1.0; }

enum { SIZE = 1 << 17, P = puma560_PARAMETERS };
static double q[6] = { .3, .4, .5, .6, .7, .8 }, X[P], out[600], more[600];
static union { puma560_identifier head; char bytes[puma560_IDENTIFIER_BYTES(3)]; } memory;

static void step(void)
{
    for (int k = 0; k < 200; k++) {
        q[k % 6] += 0.1;
        puma560_identifier_step(&memory, q, q, q, 0.001);
    }
}
static void nothing(void) { }
static void coriolis(void) { puma560_coriolis(q, q, X, out); }
static void momentum(void) { puma560_momentum_regressor(q, q, out, more); }
static void torque(void) { puma560_inverse_dynamics(q, q, q, X, out); }
static puma560_least_squares *rows = &memory.head.least_squares;
static void merge(void) { puma560_least_squares_merge(rows, rows); }

static void *call(void *f)
{
    (*(void (**)(void))f)();
    return NULL;
}

static long depth(void (*f)(void))
{
    char *stack = aligned_alloc(4096, SIZE);
    pthread_attr_t attributes;
    pthread_t thread;
    long i = 0;
    memset(stack, 0x5a, SIZE);
    pthread_attr_init(&attributes);
    pthread_attr_setstack(&attributes, stack, SIZE);
    pthread_create(&thread, &attributes, call, &f);
    pthread_join(thread, NULL);
    while (stack[i] == 0x5a) {
        i++;
    }
    free(stack);
    return SIZE - i;
}

int main(void)
{
    const long base = depth(nothing);
    puma560_identifier_init(&memory, sizeof memory, 3, puma560_WINDOW_SLIDING, 1);
    printf("coriolis %ld\\n", depth(coriolis) - base);
    printf("momentum_regressor %ld\\n", depth(momentum) - base);
    printf("inverse_dynamics %ld\\n", depth(torque) - base);
    printf("identifier_step %ld\\n", depth(step) - base);
    printf("least_squares_merge %ld\\n", depth(merge) - base);
    return 0;
}
"""


def sources(package: Path) -> dict[str, bytes]:
    """The library part of a package."""
    files = [f for f in package.iterdir() if f.suffix in (".c", ".h")]
    return {f.name: f.read_bytes() for f in files if not f.name.endswith("_check.c")}


@pytest.mark.parametrize("command", ["gcc", "clang"])
def test_no_run_goes_deeper_than_the_bound_nor_far_from_it(command, complete, tmp_path) -> None:
    if shutil.which(command) is None:
        pytest.skip(f"{command} is not on this machine")
    library = sources(complete("puma560", "double"))
    compiler = find_compiler(command)
    assert compiler is not None
    bound = worst_case_stack(library, compiler)
    assert bound is not None
    for name, content in library.items():
        (tmp_path / name).write_bytes(content)
    (tmp_path / "paint.c").write_text(PAINT)
    flags = ["-O2", "-ffp-contract=off", "-fno-builtin", "-pthread", "-Wno-all"]
    files = [n for n in library if n.endswith(".c")]
    run([command, "-std=gnu11", *flags, "-c", "paint.c"], tmp_path)
    run([command, "-std=c99", *flags[:2], "-c", *files], tmp_path)
    link = ["-Wl,-z,now", "-lm", "-o", "paint"]  # a lazy symbol is looked up on the caller's stack
    run([command, "-pthread", *sorted(tmp_path.glob("*.o")), *link], tmp_path)
    for line in run([tmp_path / "paint"], tmp_path).splitlines():
        name, used = line.split()
        # The caller's frame and the ends that `nothing` leaves unpainted: some words.
        assert int(used) - 64 <= bound[f"puma560_{name}"] <= int(used) + 256, (line, bound)


@needs_gcc
def test_callees_add_up_along_the_deepest_path() -> None:
    code = b"""
__attribute__((noinline)) static void leaf(volatile char *p) { volatile char a[1000]; a[0] = *p; }
__attribute__((noinline)) static void flat(volatile char *p) { volatile char a[10]; a[0] = *p; }
void top(volatile char *p) { volatile char a[500]; a[1] = 0; flat(p); leaf(p); flat(a); }
"""
    compiler = find_compiler("gcc")
    assert compiler is not None
    worst = worst_case_stack({"a.c": code}, compiler)
    assert worst is not None
    assert 1000 <= worst["leaf"] <= 1040
    assert 1500 <= worst["top"] <= 1580


@needs_gcc
@pytest.mark.parametrize(
    "code",
    [
        b"int f(int n) { volatile int a[9]; a[0] = n; return n ? f(n - 1) + a[0] * f(n / 2) : 0; }"
        b"int g(int n); int h(int n) { volatile int a = g(n); return a; }"
        b"int g(int n) { volatile int a = n ? h(n - 1) : 0; return a; }",
        b"int f(int n) { volatile int a[n]; a[0] = 1; return a[0]; }",
        b"not C",
    ],
    ids=["recursive", "unbounded", "broken"],
)
def test_what_has_no_bound_is_not_measured(code: bytes) -> None:
    compiler = find_compiler("gcc")
    assert compiler is not None
    assert worst_case_stack({"a.c": code}, compiler) is None


def test_a_compiler_that_does_not_count_is_told_apart(tmp_path: Path) -> None:
    other = tmp_path / "other"
    other.write_text("#!/bin/sh\nexit 0\n")
    other.chmod(0o755)
    assert worst_case_stack({"a.c": b""}, Compiler((str(other),), "other")) is None


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler on this machine")
def test_check_reports_every_function_of_the_library(complete, tmp_path) -> None:
    package = shutil.copytree(complete("planar2r", "float"), tmp_path / "planar2r")
    (found,) = symgen.check(package)
    assert found.differences == ()
    if found.stacks is None:
        pytest.skip("the compiler has no -fstack-usage")
    for name in ("inverse_dynamics", "inverse_dynamics_batch", "identifier_step"):
        assert 0 < found.stacks[name] < 4096
    (package / "example" / "planar2r_controller.c").write_text("spoiled\n")
    (package / "example" / "other.c").write_text("\n")
    (found,) = symgen.check(package)
    assert found.differences == (
        "example/planar2r_controller.c: line 1 differs",
        "example/other.c: not part of the package",
    )

"""The C under clang's sanitizers and its fuzzer, and under every warning that it has.

A short run by default; a long one, a million inputs for each package, on purpose:

    pytest -m slow tests/c/test_sanitizers.py

SYMGEN_FUZZ sets the number of inputs.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from functools import cache
from pathlib import Path

import pytest
from packages import c_files, run, write

CLANG = shutil.which("clang")
SAMPLE = int(os.environ.get("SYMGEN_FUZZ", "1000"))
ALL = int(os.environ.get("SYMGEN_FUZZ", "1000000"))
SANITIZERS = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
PACKAGES = [("planar2r", "double"), pytest.param("rich", "float", marks=pytest.mark.slow)]

#: What -Weverything asks beyond C99 or beyond reason, and why it is left.
EXCEPTIONS = {
    "padded": "the head of a state has bytes of padding; it is no format of a file",
    "declaration-after-statement": "C99 has it, C89 had not",
    "conditional-uninitialized": "arrays filled by loops of a fixed length above 0",
    "unsafe-buffer-usage": "every pointer of C (clang 16 and later)",
    "unknown-warning-option": "older clangs do not know all of these",
}

HARNESS = """
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "NAME.h"
#include "NAME_identifier.h"
#include "NAME_identifier_momentum.h"

#define N NAME_JOINTS
#define P NAME_PARAMETERS
#define MOST 12 /* samples of a log */

typedef struct { const uint8_t *at; size_t left; } input;

static uint8_t byte(input *in)
{
    return in->left > 0 ? (in->left--, *in->at++) : 0;
}

/* Mostly numbers of a robot, and now and then any pattern of bits. */
static NAME_real number(input *in)
{
    const uint8_t kind = byte(in);
    if (kind < 8) {
        NAME_real any = 0;
        if (in->left >= sizeof any) {
            memcpy(&any, in->at, sizeof any);
            in->at += sizeof any;
            in->left -= sizeof any;
        }
        return any;
    }
    return (NAME_real)((int)kind - 128) / (NAME_real)16;
}

static int numbers(input *in, NAME_real *x, int count)
{
    int finite = 1;
    for (int i = 0; i < count; i++) {
        x[i] = number(in);
        finite = finite && isfinite(x[i]);
    }
    return finite;
}

#define require(held) ((held) ? (void)0 : broken(#held, __LINE__))

static void broken(const char *what, int line)
{
    fprintf(stderr, "broken: %s, line %d\\n", what, line);
    abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in = {data, size};
    const size_t window = byte(&in) % 12;
    const int mode = (int)(byte(&in) % 5) - 1;
    const int momentum = byte(&in) & 1;
    const NAME_real forgetting = (NAME_real)byte(&in) / (NAME_real)200;
    const size_t offset = byte(&in) < 8 ? 1 : 0;
    const size_t bytes = byte(&in) % 16 == 0
        ? byte(&in)
        : (momentum ? NAME_identifier_momentum_size(window) : NAME_identifier_size(window));
    /* To the byte: one beyond is seen. */
    unsigned char *memory = malloc(bytes + offset + 1);
    unsigned char *before = malloc(bytes + offset + 1);
    memset(memory, 0x5a, bytes + offset + 1);
    memcpy(before, memory, bytes + offset + 1);
    void *state = memory + offset;
    const int refused = momentum
        ? NAME_identifier_momentum_init(state, bytes, window, mode, forgetting)
        : NAME_identifier_init(state, bytes, window, mode, forgetting);
    if (offset != 0 || !(forgetting > 0 && forgetting <= 1) || mode < 0 || mode > 2) {
        require(refused);
    }
    if (refused) {
        require(memcmp(memory, before, bytes + offset + 1) == 0);
        free(memory);
        free(before);
        return 0;
    }
    require((momentum ? NAME_identifier_momentum_init(before, bytes, window, mode, forgetting)
                      : NAME_identifier_init(before, bytes, window, mode, forgetting)) == 0);
    NAME_least_squares other;
    require(NAME_least_squares_init(&other, 1) == 0);
    NAME_real q[N], qd[N], tau[N], X[P], kept[P], std[P], row[P], rss;
    int samples = 0;
    while (in.left > 0) {
        switch (byte(&in) % 8) {
        default: {
            const int finite = numbers(&in, q, N) & numbers(&in, qd, N) & numbers(&in, tau, N);
            const NAME_real dt = number(&in);
            const int failed = NAME_identifier_step(state, q, qd, tau, dt);
            if (!finite || (samples > 0 && !(dt > 0 && isfinite(dt)))) {
                require(failed);
            }
            if (!failed) { /* the twin never sees what is refused */
                require(NAME_identifier_step(before, q, qd, tau, dt) == 0);
                samples++;
                if (mode == NAME_WINDOW_START && (NAME_identifier_status(state) & NAME_OUTLIER)) {
                    samples = 0; /* it has begun anew */
                }
            }
            break;
        }
        case 4: { /* a log at once is its samples one by one */
            NAME_real t[MOST], Q[MOST * N], QD[MOST * N], TAU[MOST * N];
            const size_t count = byte(&in) % (MOST + 1);
            (void)(numbers(&in, t, MOST) & numbers(&in, Q, MOST * N) & numbers(&in, QD, MOST * N)
                   & numbers(&in, TAU, MOST * N));
            const int stopped = NAME_identifier_run(state, count, t, Q, QD, TAU);
            int refused_at = 0;
            NAME_identifier_restart(before);
            for (size_t k = 0; k < count && refused_at == 0; k++) {
                const NAME_real dt = k > 0 ? t[k] - t[k - 1] : 0;
                if ((k == 0 && !isfinite(t[0])) ||
                    NAME_identifier_step(before, Q + k * N, QD + k * N, TAU + k * N, dt) != 0) {
                    refused_at = (int)k + 1;
                }
            }
            require(stopped == refused_at);
            require(NAME_identifier_status(state) == NAME_identifier_status(before));
            samples = 0;
            NAME_identifier_restart(state);
            NAME_identifier_restart(before);
            break;
        }
        case 5: {
            for (int i = 0; i < P; i++) {
                X[i] = kept[i] = (NAME_real)i;
            }
            const int missing = NAME_identifier_read(state, X, byte(&in) & 1 ? std : NULL);
            require(missing == NAME_identifier_read(before, kept, NULL));
            require(memcmp(X, kept, sizeof X) == 0);
            require(NAME_identifier_excited(state, X) == missing);
            (void)numbers(&in, q, N);
            require(NAME_identifier_rest(state, q) == NAME_identifier_rest(before, q));
            break;
        }
        case 6: {
            const int finite = numbers(&in, row, P);
            NAME_least_squares copy = other;
            NAME_real innovation = 7, leverage = 7, u[P];
            if (NAME_least_squares_foresee(&other, row, 1, u, &innovation, &leverage) != 0) {
                require(innovation == 7 && leverage == 7);
            }
            require(memcmp(&copy, &other, sizeof copy) == 0);
            const int failed = NAME_least_squares_update(&other, row, number(&in));
            require(finite || failed);
            if (failed) {
                require(memcmp(&copy, &other, sizeof copy) == 0);
            }
            break;
        }
        case 7:
            switch (byte(&in) % 3) {
            case 0:
                NAME_least_squares_merge(&other, NAME_identifier_state(state));
                break;
            case 1: { /* in pieces as at once */
                NAME_least_squares_solution found = {0};
                const int missing = NAME_least_squares_solve(&other, X, std, &rss);
                NAME_least_squares_begin(&found, &other);
                while (NAME_least_squares_proceed(&found, 1 + byte(&in) % 3) > 0) {
                }
                require(found.missing == missing);
                require(missing != 0 || memcmp(found.X, X, sizeof X) == 0);
                break;
            }
            default:
                NAME_identifier_restart(state);
                NAME_identifier_restart(before);
                samples = 0;
                break;
            }
            break;
        }
    }
    free(memory);
    free(before);
    return 0;
}
"""


def _reason(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Why this machine cannot fuzz, "" where it can."""
    if CLANG is None:
        return "clang is not on this machine"
    folder = tmp_path_factory.mktemp("probe")
    (folder / "probe.c").write_text(
        "int LLVMFuzzerTestOneInput(const unsigned char *d, unsigned long n);\n"
        "int LLVMFuzzerTestOneInput(const unsigned char *d, unsigned long n)"
        "{ return (int)(n > 4 && d[0] > 255); }\n"
    )
    command = [CLANG, "-fsanitize=fuzzer,address,undefined", "probe.c", "-o", "probe"]
    done = subprocess.run(command, cwd=folder, capture_output=True)
    return "" if done.returncode == 0 else "clang has no fuzzer here (libclang-rt-*-dev)"


@pytest.fixture(scope="session")
def instrumented(tmp_path_factory: pytest.TempPathFactory):
    """Compile a package with its check program and the harness for sanitizers and fuzzer, once."""
    reason = _reason(tmp_path_factory)

    @cache
    def build(name: str, dtype: str) -> Path:
        if reason:
            pytest.skip(reason)
        folder = write(name, dtype, tmp_path_factory.mktemp("fuzz") / name, "all")
        (folder / "harness.c").write_text(HARNESS.replace("NAME", name))
        flags = ["-std=c99", "-g", "-O1", "-fsanitize=fuzzer-no-link", *SANITIZERS]
        run([str(CLANG), *flags, "-c", *c_files(folder, check=True)], folder)
        return folder

    return build


@pytest.fixture(scope="session")
def fuzzer(instrumented):
    """Link the harness of a package, once."""

    @cache
    def build(name: str, dtype: str) -> Path:
        folder = instrumented(name, dtype)
        files = [file for file in folder.glob("*.o") if "check" not in file.stem]
        run([str(CLANG), "-fsanitize=fuzzer", *SANITIZERS, *files, "-lm", "-o", "harness"], folder)
        return folder / "harness"

    return build


def _fuzz(harness: Path, count: int) -> None:
    command = [harness, f"-runs={count}", "-seed=1", "-max_len=3000", "-rss_limit_mb=2000"]
    done = subprocess.run(
        [*command, "-timeout=10", "-print_final_stats=1"],
        cwd=harness.parent,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    assert f"number_of_executed_units: {count}" in done.stderr, done.stderr[-1000:]


@pytest.mark.parametrize(("name", "dtype"), PACKAGES)
def test_state_functions_hold_on_any_input_for_a_while(fuzzer, name, dtype):
    _fuzz(fuzzer(name, dtype), SAMPLE)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "dtype"), PACKAGES)
def test_state_functions_hold_on_any_input(fuzzer, name, dtype):
    _fuzz(fuzzer(name, dtype), ALL)


@pytest.mark.parametrize(("name", "dtype"), PACKAGES)
def test_every_kernel_computes_its_values_under_the_sanitizers(instrumented, name, dtype):
    """The package's own program, which knows 50-digit values of every kernel at some points."""
    folder = instrumented(name, dtype)
    files = [file for file in folder.glob("*.o") if file.stem != "harness"]
    run([str(CLANG), *SANITIZERS, *files, "-lm", "-o", "checked"], folder)
    run([folder / "checked"], folder)


@pytest.mark.slow
@pytest.mark.skipif(CLANG is None, reason="clang is not on this machine")
@pytest.mark.parametrize(("name", "dtype"), PACKAGES)
def test_clang_with_every_warning_is_silent(name, dtype, tmp_path):
    package = write(name, dtype, tmp_path / name, "all")
    left = [f"-Wno-{warning}" for warning in EXCEPTIONS]
    files = c_files(package, check=True)
    command = [str(CLANG), "-std=c99", "-Weverything", "-Werror", *left, "-fsyntax-only"]
    run([*command, *files], package)

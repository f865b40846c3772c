"""Kernels on panels, as a program in C calls them: against single calls, at every width."""

from __future__ import annotations

import random
import re
import shutil
import subprocess
from functools import cache
from pathlib import Path

import pytest
from jinja2 import Template
from packages import RICH, STRICT, run, write
from support import sampled

import symgen
from symgen.codegen.verification import physical_parameters

KERNELS = ("energy_regressor", "inverse_dynamics", "forward_dynamics")
MACHINES = {
    "sse2": (["cc"], "__SSE2__", 16, ()),
    "avx": (["cc", "-mavx"], "__AVX__", 32, ()),
    "avx2": (["cc", "-mavx2", "-mfma"], "__AVX2__", 32, ()),
    "avx512": (["cc", "-mavx512f", "-mfma"], "__AVX512F__", 64, ()),
    "clang": (["clang", "-march=native"], "", 0, ()),
    "portable": (["cc", "-U__SSE2__"], "", None, ()),
    "neon": (["aarch64-linux-gnu-gcc", "-static"], "", 16, ("qemu-aarch64",)),
}
# Rows with gaps, X of each sample; X shared; rows without gaps (NULL). The last row ends where its
# array ends. Every number of a panel counts: zeros were put there once, and what is behind the last
# sample repeats it.
PROGRAM = """
#include "rich.h"
#include "rich_panels.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef rich_real real;

static unsigned long long state = 1u;

static double drawn(void)
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (double)(state >> 40) / 16777216.0 * 6.0 - 3.0;
}

static const double possible[] = { {{ X }} };

static real *filled(size_t N, size_t size, size_t stride, int X)
{
    const size_t count = (N - 1u) * stride + size;
    real *out = malloc(count * sizeof(real));
    for (size_t i = 0u; i < count; ++i) {
        const size_t row = (stride == 0u) ? 0u : i / stride;
        const size_t place = i - row * stride;
        out[i] = (real)drawn();
        if (X && place < sizeof possible / sizeof possible[0]) {
            out[i] = (real)(possible[place] * (1.0 + 0.01 * (double)row));
        }
    }
    return out;
}

static real *zeros(size_t count)
{
    real *out = aligned_alloc(64u, (count * sizeof(real) + 63u) / 64u * 64u);
    memset(out, 0, count * sizeof(real));
    return out;
}

static double differs(const real *one, const real *other, size_t size, size_t step)
{
    double worst = 0.0, scale = 1e-30;
    for (size_t i = 0u; i < size; ++i) {
        const double error = fabs((double)one[i] - (double)other[i * step]);
        worst = (error <= worst) ? worst : error;
        scale = fmax(scale, fabs((double)one[i]));
    }
    return worst / scale;
}

int main(void)
{
    int failed = 0;
{% for k in kernels %}
{% set f, size = "rich_" + k.name, k.outputs[0].size %}
{% set given = k.inputs|map(attribute="name")|join(", ") %}
    const size_t W_{{ k.name }} = {{ f }}_width();
    for (size_t try = 0u; try < 18u; ++try) {
        const size_t W = W_{{ k.name }}, form = try % 3u;
        const size_t N = (size_t[]) { 1u, W - 1u, W, W + 1u, 3u * W, 3u * W + 2u }[try / 3u];
        const size_t whole = (N + W - 1u) / W * W;
        size_t gaps[8], rows[8];
{% for a in k.inputs %}
        gaps[{{ loop.index0 }}] = {{ a.size + 3 }}u;
        rows[{{ loop.index0 }}] = {{ 0 if a.shared else a.size }}u;
{% endfor %}
        const size_t *strides = (form == 0u) ? gaps : rows, *told = (form == 2u) ? NULL : strides;
        double worst = 0.0;
        int status = 0;
        if (N == 0u) {
            continue;
        }
{% for a in k.inputs %}
{% set at = loop.index0 %}
        real *{{ a.name }} = filled(N, {{ a.size }}u, strides[{{ at }}], {{ (a.name == "X")|int }});
{% endfor %}
        const size_t size = {{ size }}u;
        real one[{{ size }}], *row = zeros(whole * size), *panel = zeros(whole * size);
        const int of_rows = {{ f }}_rows(0, N, told, {{ given }}, row);
        const int of_panels = {{ f }}_panels(1, N, told, {{ given }}, panel);
        for (size_t i = 0u; i < whole; ++i) {
            const size_t s = (i < N) ? i : (N - 1u);
            {{ "status |= " if k.fallible }}{{ f }}(
{% for a in k.inputs %}
                &{{ a.name }}[s * strides[{{ loop.index0 }}]],
{% endfor %}
                one);
            const double of_row = differs(one, &row[s * size], size, 1u);
            const double of_panel = differs(one, &panel[i / W * W * size + i % W], size, W);
            worst = (of_row <= worst) ? worst : of_row;
            worst = (of_panel <= worst) ? worst : of_panel;
        }
        if (!(worst <= {{ tolerance }}) || (of_rows != status) || (of_panels != status)) {
            printf("{{ f }}: form %zu, N %zu, width %zu: %g, status %d %d %d\\n", form, N, W, worst,
                status, of_rows, of_panels);
            failed = 1;
        }
{% for a in k.inputs %}
        free({{ a.name }});
{% endfor %}
        free(row);
        free(panel);
    }
    printf("{{ k.name }} %zu\\n", W_{{ k.name }});
{% endfor %}
    return failed;
}
"""


@cache
def macros(*command: str) -> str:
    """What a compiler defines on this machine."""
    return subprocess.run(
        [*command, "-dM", "-E", "-x", "c", "/dev/null"], capture_output=True, text=True, check=True
    ).stdout


@pytest.mark.parametrize(
    ("machine", "dtype"),
    [("neon", "double"), *sampled([(m, d) for m in MACHINES for d in ("double", "float")], 3)],
)
def test_panels_and_rows_are_single_calls_with_any_strides(machine, dtype, tmp_path: Path) -> None:
    command, needed, width, emulator = MACHINES[machine]
    for tool in (command[0], *emulator):
        if shutil.which(tool) is None:
            pytest.skip(f"{tool} is not on this machine")
    if needed and not re.search(rf"^#define {needed}\b", macros("cc", "-march=native"), re.M):
        pytest.skip(f"this processor has no {needed}")
    name = "rich"
    package = write(name, dtype, tmp_path / name, KERNELS)
    model = symgen.derive(symgen.parse_robot(RICH), KERNELS)
    X = ", ".join(str(float(x)) for x in physical_parameters(model, random.Random(1)))
    tolerance = "1e-11" if dtype == "double" else "2e-3"  # of forward dynamics: that of its matrix
    written = Template(PROGRAM, trim_blocks=True, keep_trailing_newline=True).render(
        X=X, kernels=model.kernels, tolerance=tolerance
    )
    (tmp_path / "program.c").write_text(written)
    sources = [package / f"{name}_{k}{part}.c" for k in KERNELS for part in ("", "_panels")]
    options = [*STRICT, "-std=c11", f"-I{package}", "-O1", "-o", "p"]
    run([*command, *options, "program.c", *sources, "-lm"], tmp_path)
    done = run([*emulator, tmp_path / "p"], tmp_path)
    widths = {int(line.split()[1]) for line in done.splitlines()}
    lane = 8 if dtype == "double" else 4
    if width != 0:
        assert widths == {1 if width is None else width // lane}
    assert len(done.splitlines()) == len(KERNELS)

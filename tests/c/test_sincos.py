"""The packages' own cosine and sine of several angles, against mpmath and libm."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from pathlib import Path

import mpmath
import numpy as np
import pytest

import symgen

HEADER = Path(symgen.__file__).parents[1] / "templates" / "c" / "runtime" / "math.h"
LOOP = """
void all{n}(size_t N, const double *x, double *c, double *s)
{{
    for (size_t k = 0; k + {n}u <= N; k += {n}u) {{
        const arm_angles{n} a = arm_sincos{n}(x + k);
        for (size_t i = 0; i < {n}u; ++i) {{
            c[k + i] = a.c[i];
            s[k + i] = a.s[i];
        }}
    }}
}}
"""
STRICT = "-std=c99 -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Werror"
CASES = {
    "gcc": ["gcc", "-O2"],
    "gcc, no optimisation": ["gcc", "-O0"],
    "gcc, fused": ["gcc", "-O2", "-march=native", "-ffp-contract=fast"],
    "clang, fused": ["clang", "-O2", "-march=native"],
}
FAST = {
    "gcc": ["gcc", "-O2", "-ffast-math"],
    "clang": ["clang", "-O2", "-ffast-math"],
    "clang, reassociating": ["clang", "-O2", "-funsafe-math-optimizations"],  # says so by no macro
}


def library(folder: Path, command: list[str]) -> ctypes.CDLL:
    """Compile loops over the functions; skip where the compiler is missing."""
    if shutil.which(command[0]) is None:
        pytest.skip(f"{command[0]} is not on this machine")
    (folder / "arm_math.h").write_text(HEADER.read_text().replace("NAME", "arm"))
    source = '#include "arm_math.h"\n' + "".join(LOOP.format(n=n) for n in (1, 2, 4))
    (folder / "all.c").write_text(source)
    # Linked apart: -ffast-math would otherwise flush the subnormal numbers of this process.
    link = [command[0], "-shared", "all.o", "-o", "all.so", "-lm"]
    for step in ([*command, *STRICT.split(), "-fPIC", "-c", "all.c"], link):
        done = subprocess.run(step, cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
    return ctypes.CDLL(str(folder / "all.so"))


def turned(lib: ctypes.CDLL, n: int, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return cosines and sines of angles, n at a time."""
    c, s = np.empty_like(x), np.empty_like(x)
    pointers = [a.ctypes.data_as(ctypes.c_void_p) for a in (x, c, s)]
    getattr(lib, f"all{n}")(ctypes.c_size_t(len(x)), *pointers)
    return c, s


def exact(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return cosines and sines, each as a double and what is missing to 60 digits, (2, N)."""
    context = mpmath.mp.clone()
    context.dps = 60
    out = []
    for function in (context.cos, context.sin):
        values = [function(context.mpf(float(v))) for v in x]
        head = np.array([float(v) for v in values])
        rest = [float(v - context.mpf(h)) for v, h in zip(values, head.tolist(), strict=True)]
        out.append(np.array([head, rest]))
    return out[0], out[1]


def ulps(found: np.ndarray, expected: np.ndarray) -> float:
    head, rest = expected
    return float(np.max(np.abs((found - head) - rest) / np.spacing(np.abs(head))))


def angles() -> np.ndarray:
    """Draw angles: near and far, tiny, at multiples of pi/4 and the doubles beside them."""
    draw = np.random.default_rng(3)
    with mpmath.workdps(40):
        quarters = [float(int(k) * mpmath.pi / 4) for k in draw.integers(-31000, 31000, 700)]
        quarters += [float(k * mpmath.pi / 4) for k in range(-40, 41)]
    beside = np.concatenate([np.nextafter(quarters, np.inf), np.nextafter(quarters, -np.inf)])
    spread = [draw.uniform(-b, b, 1000) for b in (3.2, 30.0, 24000.0)]
    tiny = 10.0 ** draw.uniform(-300, 0, 200)
    x = np.concatenate([quarters, beside, *spread, tiny, [0.0]])
    return np.resize(x, len(x) // 4 * 4)


@pytest.mark.parametrize("case", CASES)
def test_cosine_and_sine_are_right_to_about_one_unit_in_the_last_place(case, tmp_path):
    lib, x = library(tmp_path, CASES[case]), angles()
    expected = exact(x)
    for n in (1, 2, 4):
        for found, reference in zip(turned(lib, n, x), expected, strict=True):
            assert ulps(found, reference) < 1.3


@pytest.mark.parametrize("case", CASES)
def test_far_angles_are_those_of_libm_and_nan_stays_nan(case, tmp_path):
    lib = library(tmp_path, CASES[case])
    x = np.array([1e5, -2e6, 1e22, 0.3, -1e300, 1.0, 2.0, 100001.0])
    for n in (1, 2, 4):
        for found, reference in zip(turned(lib, n, x), exact(x), strict=True):
            assert ulps(found, reference) < 1.3
        for bad in (np.nan, np.inf, -np.inf):
            c, s = turned(lib, n, np.full(4, bad))
            assert np.isnan(c).all()
            assert np.isnan(s).all()


@pytest.mark.parametrize("case", FAST)
def test_fast_math_cannot_undo_the_reduction(case, tmp_path):
    lib, x = library(tmp_path, FAST[case]), angles()
    for found, reference in zip(turned(lib, 4, x), exact(x), strict=True):
        assert ulps(found, reference) < 2.0

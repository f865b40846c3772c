"""Compiler flags for this processor, by one rule from the predefined macros of the compiler.

Kernels are straight-line code. Fused multiply-add makes it faster; vectorisation by gcc and clang
does not. Panels are already vectors, as wide as those of the processor.
`tests/benchmarks/bench_kernels.py --flags ROBOT` compares these flags with others.
"""

from __future__ import annotations

from symgen.runtime.build import Compiler, native

#: Flags of kernels, and the macros of a processor that supports them.
_FMA = ("__FMA__",)
_STRAIGHT = ("-mfma", "-fno-tree-slp-vectorize")
#: Flags of panels, the widest first, and the macros of a processor that supports them.
_AVX512 = ("__AVX512F__", "__AVX512DQ__", "__AVX512VL__", "__AVX512BW__", "__FMA__")
_WIDEST = ("-mavx512f", "-mavx512dq", "-mavx512vl", "-mavx512bw", "-mfma",
           "-mprefer-vector-width=512")  # fmt: skip
_AVX2 = ("__AVX2__", "__FMA__")
_WIDE = ("-mavx2", "-mfma")


def kernel_flags(compiler: Compiler) -> tuple[str, ...]:
    """Return the flags for single calls on this computer."""
    return _STRAIGHT if _has(compiler, _FMA) else ()


def panel_flags(compiler: Compiler) -> tuple[str, ...]:
    """Return the flags for panels of samples on this computer."""
    if _has(compiler, _AVX512):
        return _WIDEST
    return _WIDE if _has(compiler, _AVX2) else ()


def _has(compiler: Compiler, wanted: tuple[str, ...]) -> bool:
    """Return whether the compiler predefines these macros for this processor."""
    macros = {line.split()[1] for line in native(compiler).splitlines() if line}
    return macros.issuperset(wanted)

"""CUDA: NAME.cu, every function with a batch for arrays of states in device memory."""

from __future__ import annotations

from symgen.codegen.backends import Package, c


def files(package: Package) -> dict[str, str]:
    """Return NAME.cu and its header."""
    name = package.name
    kernels = [c.described(package, kernel, False) for kernel in package.kernels if kernel.batch]
    source = c.runtime_source("math.h", package.model.robot.gravity_input, package.dtype)
    marked = source.replace("static inline", "[[maybe_unused]] NAME_FUNCTION static inline")
    math = marked.replace("NAME", name).strip()
    return {
        f"{name}.cu": package.render("c/cuda.cu", kernels=kernels, math=math),
        f"{name}_cuda.h": package.render("c/cuda.h", kernels=kernels),
    }

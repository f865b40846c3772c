"""Kernels on panels, for batches: a panel stores as many samples as a vector register.

symgen compiles a kernel for panels on first use, with flags for such code. This takes about a
second, and is worthwhile for many samples. The values equal those of the single call to rounding,
for any N and any position in the batch.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from symgen.codegen.backends import c
from symgen.codegen.kernel import Kernel
from symgen.codegen.model import Model
from symgen.errors import ParameterError
from symgen.runtime.build import Compiler, build_module
from symgen.runtime.calls import Bound, FloatArray, buffers, checked, result
from symgen.runtime.flags import panel_flags

_LINE = 64  # bytes of a cache line, to which outputs are aligned


class Panels:
    """One kernel, compiled for panels.

    Attributes:
        kernel: the kernel.
        width: number of samples in a panel: 8, 4, 2 or, without vectors, 1.
    """

    def __init__(self, model: Model, compiler: Compiler, kernel: Kernel) -> None:
        """Compile and load the kernel, or load it from the cache.

        Raises:
            BuildError: the compiler fails.
        """
        name = f"{model.robot.name}_{kernel.name}"
        listed = kernel.listed("double", batch=True)
        declarations = (
            f"size_t {name}_width(void);\n"
            f"int {name}_rows(int stream, size_t N, const size_t *strides, {listed});\n"
            f"int {name}_panels(int stream, size_t N, const size_t *strides, {listed});\n"
        )
        sources = c.functions(model, (kernel.name,), panels=True)
        module = build_module(sources, declarations, compiler, panel_flags(compiler))
        self.kernel = kernel
        self.width = int(getattr(module.lib, f"{name}_width")())
        self._ffi = module.ffi
        self._rows = getattr(module.lib, f"{name}_rows")
        self._panels = getattr(module.lib, f"{name}_panels")

    def __call__(self, *inputs: ArrayLike) -> FloatArray | tuple[FloatArray, ...]:
        """Evaluate a batch, inputs (N, n); outputs (N, ...) are as those of `KernelFunction`.

        Raises:
            ParameterError: a shape is wrong, or M is not positive definite (forward_dynamics).
        """
        arrays, count = checked(self.kernel, inputs)
        if count is None:
            raise ParameterError(f"{self.kernel.name}: panels take a batch; accepted: (N, n)")
        outputs = [aligned((count, *o.shape)) for o in self.kernel.outputs]
        pointers = [self._ffi.from_buffer("double *", a) for a in (*arrays, *outputs)]
        # Not past the cache, because new pages from the operating system are already in it.
        status = self._rows(0, count, self._ffi.NULL, *pointers)
        found: FloatArray | tuple[FloatArray, ...] = result(self.kernel, outputs, status)
        return found

    def bind(self, count: int, *, rows: bool = True, stream: bool = False) -> Bound:
        """Return the kernel on fixed buffers of a batch.

        Args:
            count: number N of samples.
            rows: if True, outputs have the shape (N, ...). Otherwise they are panels, (ceil(N /
                width), size, width), which need no transposition. Entry [k, i, l] is output i of
                sample k width + l; entries after the last sample repeat it. Entries that are zero
                for every sample are written once, so panels are read-only.
            stream: whether to write outputs past the cache, for outputs larger than the cache.
        """
        inputs, _ = buffers(self.kernel, count)
        blocks = -(-count // self.width)
        outputs = tuple(
            aligned((count, *o.shape) if rows else (blocks, o.size, self.width))
            for o in self.kernel.outputs
        )
        pointers = [self._ffi.from_buffer("double *", a) for a in (*inputs, *outputs)]
        function = self._rows if rows else self._panels
        for out in outputs if not rows else ():
            out.fill(0.0)
            out.setflags(write=False)
        return Bound(inputs, outputs, lambda: function(stream, count, self._ffi.NULL, *pointers))


def aligned(shape: tuple[int, ...]) -> FloatArray:
    """Return an array that begins at a cache line."""
    size = int(np.prod(shape))
    room = np.empty(size + _LINE // 8)
    start = -room.ctypes.data % _LINE // 8
    return room[start : start + size].reshape(shape)

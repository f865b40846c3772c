"""Rows of a regressor evaluated and folded at once: nothing of a long log is ever stored."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symgen.codegen.folding import fold_sources, foldable
from symgen.codegen.kernels import Kernel
from symgen.codegen.package import library
from symgen.errors import BuildError, ParameterError
from symgen.runtime.build import build_module, find_compiler
from symgen.runtime.calls import FloatArray, checked
from symgen.runtime.evaluator import Evaluator
from symgen.runtime.flags import panel_flags
from symgen.runtime.panels import aligned

_BLOCK = 512  # samples of a block without a compiler
METHODS = ("normal", "orthogonal")


@dataclass(frozen=True, eq=False)
class Folded:
    """What rows A = w [W, y] leave behind for least squares.

    Attributes:
        triangle: (p + 1, p + 1), upper triangular R with R'R = A'A and no negative diagonal; the
            last column is of y: W X = y has the normal equations R11' R11 X = R11' r, and the
            square of the last entry is the residual's sum of squares. None where only sums of
            products are known.
        products: (p + 1, p + 1), A'A.
        rows: how many rows were folded.
    """

    triangle: FloatArray | None
    products: FloatArray
    rows: int

    def merge(self, other: Folded) -> Folded:
        """Return what the rows of both leave behind; the order does not matter but for rounding.

        A triangle survives where both have one.
        """
        triangle = None
        if self.triangle is not None and other.triangle is not None:
            triangle = _upright(_qr(np.vstack([self.triangle, other.triangle])))
        return Folded(triangle, self.products + other.products, self.rows + other.rows)

    def solve(self) -> tuple[FloatArray, float]:
        """Return X of the least squares and the residual's sum of squares.

        From the triangle where there is one (errors grow with the condition number of W), else
        from the normal equations with columns scaled to norm one (with its square).

        Raises:
            ParameterError: the rows do not determine X.
        """
        if self.triangle is not None:
            left: FloatArray = self.triangle[:-1, :-1]
            right: NDArray[Any] = self.triangle[:-1, -1]
            rss = float(self.triangle[-1, -1] ** 2)
            if not np.diag(left).all():
                raise ParameterError("the rows do not determine X; accepted: more rows")
        else:
            scale = np.sqrt(np.diag(self.products))[:-1]
            scale[scale == 0] = 1.0
            try:
                root = np.linalg.cholesky(self.products[:-1, :-1] / np.outer(scale, scale))
            except np.linalg.LinAlgError:
                raise ParameterError(
                    "the rows do not determine X; accepted: more rows, or method='orthogonal'"
                ) from None
            left = root.T * scale
            right = np.asarray(np.linalg.solve(root, self.products[:-1, -1] / scale))
            rss = max(float(self.products[-1, -1] - right @ right), 0.0)
        return np.asarray(np.linalg.solve(left, right), dtype=np.float64), rss


class Fold:
    """Folds samples of one regressor: W X = y, with a row or a row a joint for each sample.

    The rows of a block of samples are evaluated on panels and folded while they are in the cache:
    into W'W by sums of products kept apart for each lane, or into a triangle by blocked Householder
    reflections (TSQR). Without a compiler NumPy folds the blocks.

    Attributes:
        kernel: the regressor.
        method: "normal" (sums of products), or "orthogonal" (a triangle, at twice the time).
    """

    def __init__(self, evaluator: Evaluator, kernel: str, method: str = "normal") -> None:
        """Compile, or load what was compiled before.

        Args:
            evaluator: from `symgen.load`.
            kernel: torque_regressor, power_regressor or another with columns.
            method: one of METHODS.

        Raises:
            ParameterError: there is no such kernel or method, or it has no columns.
            BuildError: the compiler fails.
        """
        if method not in METHODS:
            raise ParameterError(f"method {method!r}; accepted: {', '.join(METHODS)}")
        self._function = evaluator[kernel]
        self.kernel: Kernel = self._function.kernel
        self.method = method
        if not foldable(self.kernel):
            raise ParameterError(f"{kernel} has no columns; accepted: a regressor with one output")
        (output,) = self.kernel.outputs
        self._columns = len(output.columns)
        self._rows = output.size // self._columns
        self._library = None
        if evaluator.backend == "c":
            compiler = find_compiler()
            if compiler is None:
                raise BuildError("the evaluator's compiler is gone")
            model = evaluator.model
            sources = library(model, ())
            sources |= fold_sources(model, self.kernel)
            name = f"{model.robot.name}_{kernel}"
            arrays = ", ".join(f"const double *{a}" for a, _ in self.kernel.tape.inputs)
            declarations = (
                f"size_t {name}_fold_size(void);\n"
                f"void {name}_fold(size_t N, {arrays}, const double *y, const double *weights, "
                "int varying, int orthogonal, void *room, double *out);\n"
            )
            flags = panel_flags(compiler).flags.flags
            self._library = build_module(sources, declarations, compiler, flags)
            self._fold = getattr(self._library.lib, f"{name}_fold")
            self._size = int(getattr(self._library.lib, f"{name}_fold_size")())

    def __call__(
        self, inputs: Sequence[ArrayLike], y: ArrayLike, weights: ArrayLike = 1.0
    ) -> Folded:
        """Fold the rows of N samples.

        Args:
            inputs: arrays (N, n) of the kernel: q, qd (and qdd), rad, rad/s, rad/s2.
            y: right-hand side: (N,) for one row a sample, (N, n) for a row a joint.
            weights: what each row is multiplied by: a number, one for each row of a sample, or an
                array of y's shape. 0 leaves a row of finite numbers out.

        Raises:
            ParameterError: a shape is wrong.
        """
        arrays, count = checked(self.kernel, inputs)
        if count is None:
            raise ParameterError(f"{self.kernel.name}: a fold takes a batch; accepted: (N, n)")
        right = np.ascontiguousarray(y, dtype=np.float64)
        expected = (count,) if self._rows == 1 else (count, self._rows)
        if right.shape not in (expected, (count, self._rows)):
            raise ParameterError(f"y has shape {right.shape}; accepted: {expected}")
        scale = np.ascontiguousarray(weights, dtype=np.float64)
        varying = scale.size == right.size and scale.ndim == right.ndim and count > 1
        if not varying:
            try:
                scale = np.ascontiguousarray(np.broadcast_to(scale, (self._rows,)))
            except ValueError:
                raise ParameterError(
                    f"weights have shape {scale.shape}; accepted: a number, ({self._rows},) or "
                    f"{expected}"
                ) from None
        if self._library is None:
            return self._plain(arrays, right.reshape(count, -1), scale.reshape(-1, self._rows))
        out = np.empty((self._columns + 1,) * 2)
        room = aligned((self._size // 8 + 1,))
        pointers = [
            self._library.ffi.from_buffer("double *", a) for a in (*arrays, right, scale, room, out)
        ]
        self._fold(
            count, *pointers[:-2], varying, self.method == "orthogonal", pointers[-2], pointers[-1]
        )
        rows = count * self._rows
        if self.method == "normal":
            return Folded(None, out, rows)
        triangle = _upright(out)
        return Folded(triangle, triangle.T @ triangle, rows)

    def _plain(self, arrays: Sequence[FloatArray], y: FloatArray, scale: FloatArray) -> Folded:
        folded = Folded(None, np.zeros((self._columns + 1,) * 2), 0)
        if self.method == "orthogonal":
            folded = Folded(folded.products, folded.products, 0)
        weights = np.broadcast_to(scale, y.shape)
        for at in range(0, len(y), _BLOCK):
            part = slice(at, at + _BLOCK)
            W = self._function(*(a[part] for a in arrays)).reshape(-1, self._columns)
            A = np.hstack([W, y[part].reshape(-1, 1)]) * weights[part].reshape(-1, 1)
            triangle = None
            if self.method == "orthogonal":
                triangle = _padded(_qr(A), self._columns + 1)
            folded = folded.merge(Folded(triangle, A.T @ A, len(A)))
        return folded


def _qr(A: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.qr(A, mode="r"), dtype=np.float64)


def _padded(R: FloatArray, size: int) -> FloatArray:
    out = np.zeros((size, size))
    out[: min(len(R), size)] = R[:size]
    return out


def _upright(R: FloatArray) -> FloatArray:
    """Return a triangle with no negative number on its diagonal: the one that QR makes unique."""
    R = np.triu(R[: R.shape[1]])
    return R * np.where(np.diag(R) < 0, -1.0, 1.0)[:, None]

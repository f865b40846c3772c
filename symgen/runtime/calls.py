"""What a call of a kernel is given and gives back: arrays checked, buffers bound, statuses read."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symgen.codegen.kernels import LINK, SCALARS, SHARED, Kernel
from symgen.errors import ParameterError
from symgen.robot.expressions import shortened

FloatArray = NDArray[np.float64]
NOT_POSITIVE_DEFINITE = 1  # as NAME.h numbers them; a batch has the bits of all its samples
NOT_FINITE = 2


@dataclass(frozen=True, eq=False)
class Bound:
    """A kernel on buffers of its own: write the inputs, call, read `out`.

    Attributes:
        inputs: one array for each input of the kernel, to be written in place.
        outputs: one array for each output, overwritten by each call.
        call: evaluates the kernel; no checks, no allocation. In C it returns the kernel's status.
    """

    inputs: tuple[FloatArray, ...]
    outputs: tuple[FloatArray, ...]
    call: Callable[[], Any]

    @property
    def out(self) -> FloatArray:
        """The first output."""
        return self.outputs[0]

    def __call__(self) -> None:
        self.call()


def checked(kernel: Kernel, inputs: Sequence[ArrayLike]) -> tuple[list[FloatArray], int | None]:
    """Return the inputs as C-contiguous arrays, and N for a batch (None for one sample)."""
    expected = kernel.tape.inputs
    if len(inputs) == len(expected) - 1 and expected[-1][0] == "g":
        raise ParameterError(
            f"{kernel.name}: gravity is an input of this robot; accepted: g behind the other "
            "arrays, or a robot file whose gravity is three numbers"
        )
    if len(inputs) != len(expected):
        raise ParameterError(
            f"{kernel.name} takes {len(expected)} arrays ({', '.join(n for n, _ in expected)}), "
            f"{len(inputs)} were given"
        )
    arrays = [
        _numbers(kernel, name, len(symbols), given)
        for (name, symbols), given in zip(expected, inputs, strict=True)
    ]
    lead = arrays[0].shape[:-1] if kernel.batch else ()
    for i, ((name, symbols), array) in enumerate(zip(expected, arrays, strict=True)):
        if name == LINK and array.size == 1 and array.item() in range(1, len(symbols) + 1):
            arrays[i] = array.reshape(1)
        elif name == LINK:
            raise _not_accepted(kernel, name, len(symbols), inputs[i])
        elif name in SCALARS and array.size == 1:
            arrays[i] = array.reshape(1)
        elif name == "X" and array.ndim == 1 and len(array) >= len(symbols):
            arrays[i] = array[: len(symbols)]
        elif name == "g" and array.shape == (len(symbols),):
            pass
        elif name == "X":
            raise ParameterError(
                f"{kernel.name}: X has shape {array.shape}; accepted: ({len(symbols)},) or longer"
            )
        elif name == "g":
            raise ParameterError(
                f"{kernel.name}: g has shape {array.shape}; accepted: (3,), for all samples"
            )
        elif array.ndim not in (1, 2) or array.shape != (*lead, len(symbols)):
            raise ParameterError(
                f"{kernel.name}: {name} has shape {array.shape}; "
                f"accepted: ({len(symbols)},) or (N, {len(symbols)}), the same N for all"
            )
    return arrays, (lead[0] if lead else None)


def _numbers(kernel: Kernel, name: str, size: int, given: ArrayLike) -> FloatArray:
    try:
        return np.ascontiguousarray(given, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise _not_accepted(kernel, name, size, given) from error


def _not_accepted(kernel: Kernel, name: str, size: int, given: ArrayLike) -> ParameterError:
    accepted = f"the number of a joint, 1 to {size}" if name == LINK else "an array of numbers"
    return ParameterError(
        f"{kernel.name}: {name} is {shortened(repr(given))}; accepted: {accepted}"
    )


def result(kernel: Kernel, outputs: Sequence[FloatArray], status: int) -> Any:
    """Return one output or the tuple of all; refuse what has no meaning."""
    if status & NOT_POSITIVE_DEFINITE:
        raise ParameterError(
            f"{kernel.name}: the mass matrix is not positive definite; accepted: parameters X of a "
            "robot that can exist"
        )
    if status:
        raise ParameterError(
            f"{kernel.name}: an input or what came of it is not finite; accepted: finite numbers"
        )
    return outputs[0] if len(outputs) == 1 else tuple(outputs)


def buffers(
    kernel: Kernel, count: int | None
) -> tuple[tuple[FloatArray, ...], tuple[FloatArray, ...]]:
    plain = {LINK, *SCALARS, *(o.name for o in kernel.outputs)}
    if plain.intersection(name for name, _ in kernel.tape.inputs) or not (
        kernel.batch or not count
    ):
        raise ParameterError(f"{kernel.name} has no fixed buffers; accepted: plain calls")
    lead = () if count is None else (count,)
    inputs = tuple(
        np.zeros((*(() if name in SHARED else lead), len(symbols)))
        for name, symbols in kernel.tape.inputs
    )
    return inputs, tuple(np.zeros((*lead, *o.shape)) for o in kernel.outputs)

"""Arguments and results of kernel calls: checked arrays, fixed buffers, status codes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from symgen.codegen.kernel import LINK, Argument, Kernel
from symgen.data.raw import FloatArray as FloatArray
from symgen.errors import ParameterError, shortened
from symgen.names import FREE_BASE

NOT_POSITIVE_DEFINITE = 1  # as in NAME.h; the status of a batch has the bits of all its samples
NOT_FINITE = 2
_MOVING = "the motion of the base is an input of this robot; accepted: {} behind the other arrays"
#: Message for a call without the inputs of the base.
_BASE = dict.fromkeys(FREE_BASE, _MOVING) | {
    "g": "gravity is an input of this robot; accepted: g behind the other arrays, or a robot file "
    "whose gravity is three numbers"
}


@dataclass(frozen=True, eq=False)
class Bound:
    """A kernel on fixed buffers: write the inputs, call, read `out`.

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
    expected = kernel.inputs
    base = tuple(a.name for a in expected if a.name in _BASE)
    if base and len(inputs) == len(expected) - len(base):
        listed = " and ".join(", ".join(base).rsplit(", ", 1))
        raise ParameterError(f"{kernel.name}: {_BASE[base[-1]].format(listed)}")
    if len(inputs) != len(expected):
        raise ParameterError(
            f"{kernel.name} takes {len(expected)} arrays ({', '.join(a.name for a in expected)}), "
            f"{len(inputs)} were given"
        )
    arrays: list[FloatArray] = []
    lead: tuple[int, ...] = ()
    first = next((a for a in expected if not a.shared), None)
    for a, given in zip(expected, inputs, strict=True):
        try:
            array = np.ascontiguousarray(given, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise _not_accepted(kernel, a, f"is {shortened(repr(given))}") from error
        if a.link and (array.size != 1 or array.flat[0] not in range(a.first, a.last + 1)):
            raise _not_accepted(kernel, a, f"is {shortened(repr(given))}")
        if a.plain and array.size == 1:
            array = array.reshape(1)
        elif a.name == "X" and array.ndim == 1 and len(array) >= a.size:
            array = array[: a.size]
        else:
            if a is first and kernel.batch and array.ndim == 2:
                lead = array.shape[:1]
            if array.shape != ((a.size,) if a.shared else (*lead, a.size)) or a.name == "X":
                raise _not_accepted(kernel, a, f"has shape {array.shape}")
        arrays.append(array)
    return arrays, (lead[0] if lead else None)


def _not_accepted(kernel: Kernel, a: Argument, problem: str) -> ParameterError:
    accepted = {
        LINK: f"the number of a joint, {a.first} to {a.last}",
        "X": f"({a.size},) or longer",
        "g": f"({a.size},), for all samples",
    }
    shapes = f"({a.size},) or (N, {a.size}) numbers, the same N for all"
    return ParameterError(
        f"{kernel.name}: {a.name} {problem}; accepted: {accepted.get(a.name, shapes)}"
    )


def result(kernel: Kernel, outputs: Sequence[FloatArray], status: int) -> Any:
    """Return one output, or the tuple of all; raise an error for a status other than OK.

    Args:
        kernel: the kernel.
        outputs: the arrays filled by the call.
        status: the status of the call.
    """
    if status & NOT_POSITIVE_DEFINITE:
        failures = dict.fromkeys(kernel.guards)
        raise ParameterError(f"{kernel.name}: {', or '.join(failures)}")
    if status:
        raise ParameterError(
            f"{kernel.name}: an input or what came of it is not finite; accepted: finite numbers"
        )
    return outputs[0] if len(outputs) == 1 else tuple(outputs)


def buffers(
    kernel: Kernel, count: int | None
) -> tuple[tuple[FloatArray, ...], tuple[FloatArray, ...]]:
    """Return arrays for the inputs and outputs of one sample, or of `count`."""
    if any(a.plain or (a.read and a.written) for a in kernel.arguments) or (
        count and not kernel.batch
    ):
        raise ParameterError(f"{kernel.name} has no fixed buffers; accepted: plain calls")
    lead = () if count is None else (count,)
    inputs = tuple(np.zeros((*(() if a.shared else lead), a.size)) for a in kernel.inputs)
    return inputs, tuple(np.zeros((*lead, *o.shape)) for o in kernel.outputs)

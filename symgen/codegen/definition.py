"""The definition of a kernel: its inputs, its outputs, and its derivation."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import sympy as sp

from symgen.codegen.kernel import Kernel, Output
from symgen.robot.types import Robot
from symgen.symbolic import dynamics
from symgen.symbolic.base_parameters import BaseParameters
from symgen.symbolic.tape import Tape

#: Input of kernels that depend on gravity, for a robot whose gravity is an input. If the base has
#: an IMU, the motion of the base replaces it.
GRAVITY = "g"
#: Reason why a kernel does not exist if the base has an IMU.
FIXED_BASE = (
    "holds for a base at rest, and the base of {} has an IMU: what moves the base adds energy and "
    "momentum that no log contains"
)
#: Message for a pivot of the mass matrix that is not positive, with the remedy.
_NO_MASS = (
    "the mass matrix is not positive definite; accepted: parameters X of a robot that can exist"
)
#: The same for the guards before the pivots.
_NO_LOAD = (
    "an effect of the load leaves no unique acceleration; accepted: coefficients for which its "
    "torque stays below that of the load"
)


@dataclass(frozen=True)
class Subject:
    """The basis of a derivation: a robot and its base parameters."""

    robot: Robot
    base: BaseParameters


@dataclass(frozen=True)
class Size:
    """A number of entries that depends on the robot."""

    symbol: str
    count: Callable[[Subject], int]


@dataclass(frozen=True)
class Columns:
    """One column for each parameter of a set.

    Attributes:
        symbol: the number of columns in documents.
        parameters: returns the name of each parameter, and its index among the derived columns.
    """

    symbol: str
    parameters: Callable[[Subject], list[tuple[str, int]]]


@dataclass(frozen=True)
class Array:
    """An input or output of a kernel: its name and shape, () for a scalar."""

    name: str
    shape: tuple[int | Size | Columns, ...]

    @property
    def text(self) -> str:
        """Name and shape in documents, such as "M (n, n)"."""
        sizes = [str(s) if isinstance(s, int) else s.symbol for s in self.shape]
        comma = "," if len(sizes) == 1 else ""
        return f"{self.name} ({', '.join(sizes)}{comma})" if sizes else self.name

    def output(self, s: Subject) -> Output:
        """Return the array for one robot."""
        sizes: list[int] = []
        columns: tuple[str, ...] = ()
        for size in self.shape:
            if isinstance(size, Columns):
                columns = tuple(name for name, _ in size.parameters(s))
                sizes.append(len(columns))
            else:
                sizes.append(size if isinstance(size, int) else size.count(s))
        return Output(self.name, tuple(sizes), columns)


Derivation = Callable[[Subject, Sequence[Array]], Tape]


@dataclass(frozen=True)
class KernelDefinition:
    """The definition of a kernel.

    Attributes:
        group: its row in the table of documents.
        name: its name in the interface.
        doc: description; see kernels.toml.
        inputs: the input arrays; g only if gravity is an input of the robot.
        outputs: the output arrays.
        tape: derives the program. After the entries of the arrays, its outputs are guards. The last
            n guards are the pivots of the mass matrix; guards before them concern load effects.
        exists: whether a robot has it.
        lacks: content that a robot without this kernel lacks, for the message.
        batch: whether there is a version for N samples.
        standard: whether it concerns standard parameters; it is then written only on request.
        named: whether it is written only by name.
        fixed_base: whether it exists only for a fixed base.
    """

    group: str
    name: str
    doc: str
    inputs: tuple[Array, ...]
    outputs: tuple[Array, ...]
    tape: Derivation
    exists: Callable[[Subject], bool] | None = None
    lacks: str = ""
    batch: bool = True
    standard: bool = False
    named: bool = False
    fixed_base: bool = False

    @property
    def documented(self) -> str:
        """The docstring of the method of an evaluator: meaning, inputs and outputs."""
        text = self.doc.format(linear="p", standard="model.base.standard")
        read = ", ".join(a.text for a in self.inputs if a.name != GRAVITY)
        if any(a.name == GRAVITY for a in self.inputs):
            read += ", and g (3,) if gravity is an input of the robot"
            if not self.fixed_base:
                read += ", or f (3,), w (3,), wd (3,) if its base has an IMU"
        written = ", ".join(a.text for a in self.outputs)
        return f"{text[0].upper()}{text[1:]}.\n\nInputs: {read}.\nOutputs: {written}."

    def absent(self, s: Subject) -> str:
        """Return the reason why a robot has no such kernel; "" if it has one."""
        if self.exists is not None and not self.exists(s):
            return f"{s.robot.name} has {self.lacks}"
        if self.fixed_base and s.robot.imu:
            return f"it {FIXED_BASE.format(s.robot.name)}"
        return ""

    def derive(self, s: Subject) -> Kernel | None:
        """Return the kernel of a robot; None if the robot has none."""
        if self.absent(s):
            return None
        outputs = tuple(array.output(s) for array in self.outputs)
        tape = self.tape(s, self.inputs)
        last = self.outputs[-1].shape[-1]
        if isinstance(last, Columns):
            rows = sum(math.prod(o.shape[:-1]) for o in outputs)
            width = len(tape.outputs) // rows
            places = [place for _, place in last.parameters(s)]
            tape = tape.keep([row * width + place for row in range(rows) for place in places])
        count = len(tape.outputs) - sum(o.size for o in outputs)
        pivots = min(count, s.robot.n)
        guards = (*(count - pivots) * [_NO_LOAD], *pivots * [_NO_MASS])
        linear = s.base.linear if s.robot.loaded else "p"
        names = ", ".join(p.name for p in s.base.standard)
        doc = self.doc.format(linear=linear, standard=names)
        return Kernel(self.name, doc, tape, outputs, guards, self.batch)


def of_robot(derive: Callable[[Robot], Tape]) -> Derivation:
    """Return the derivation of a kernel from the robot alone."""
    return lambda s, _: derive(s.robot)


def of_base(derive: Callable[[Robot, BaseParameters], Tape]) -> Derivation:
    """Return the derivation of a kernel that regroups parameters."""
    return lambda s, _: derive(s.robot, s.base)


def of_plant(derive: Callable[[dynamics.Plant], Any]) -> Derivation:
    """Return the derivation of a kernel that reads X, or its inertial part."""

    def tape(s: Subject, inputs: Sequence[Array]) -> Tape:
        plant = dynamics.plant(s.robot, s.base)
        read = {a.name: a.output(s).size for a in inputs if a.name != GRAVITY}
        count = read.pop("X")
        return plant.close([*read], _entries(derive(plant), s.robot.numbers), count)

    return tape


def _entries(derived: Any, numbers: Sequence[int]) -> list[sp.Expr]:
    """Return the row-major entries of a derivation, for movable joints only.

    Args:
        derived: values or rows by joint, a list of entries, or several of these.
        numbers: the numbers of the movable joints.
    """
    if isinstance(derived, tuple):
        return [entry for part in derived for entry in _entries(part, numbers)]
    if not isinstance(derived, dict):
        return list(derived)
    rows = [derived[j] for j in numbers]
    if not isinstance(rows[0], dict):
        return rows
    return [row.get(k, sp.S.Zero) for row in rows for k in numbers]

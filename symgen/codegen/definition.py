"""The definition of a kernel: its inputs, its outputs, and its derivation."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import sympy as sp

from symgen import names
from symgen.codegen.kernel import Kernel, Output
from symgen.robot.types import Robot
from symgen.symbolic import dynamics
from symgen.symbolic.base_parameters import BaseParameters
from symgen.symbolic.tape import Tape

#: Input of kernels that depend on gravity, for a robot whose gravity is an input. If the base has
#: an IMU, the motion of the base replaces it.
GRAVITY = "g"
#: Reasons why a kernel does not exist for a base.
NOT_FOR = {
    "fixed": "holds for a floating base, and the base of {} is fixed",
    "imu": "holds for a base at rest, and the base of {} has an IMU: what moves the base adds "
    "energy and momentum that no log contains",
    "floating": "holds for a base at rest, and the base of {} floats",
}
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
        outputs: the output arrays; those without entries are dropped.
        tape: derives the program. After the entries of the arrays, its outputs are guards. The last
            m guards are the pivots of the mass matrix; guards before them concern load effects.
        exists: whether a robot has it.
        lacks: content that a robot without this kernel lacks, for the message.
        batch: whether there is a version for N samples.
        standard: whether it concerns standard parameters; it is then written only on request.
        named: whether it is written only by name.
        bases: the bases for which it exists.
        excluded: why a floating base has none.
        floating: the definition for a floating base, whose inputs include those of the base.
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
    bases: tuple[str, ...] = names.BASES
    excluded: str = ""
    floating: KernelDefinition | None = None

    @property
    def documented(self) -> str:
        """The docstring of the method of an evaluator: meaning, inputs and outputs."""
        if self.floating is None or "floating" not in self.bases:
            return self._described
        return f"{self._described}\n\nFloating base: {self.floating._described}"

    @property
    def _described(self) -> str:
        text = self.doc.format(linear="p", standard="model.base.standard")
        read = ", ".join(a.text for a in self.inputs if a.name != GRAVITY)
        if any(a.name == GRAVITY for a in self.inputs):
            read += ", and g (3,) if gravity is an input of the robot"
            if "imu" in self.bases:
                read += ", or f (3,), w (3,), wd (3,) if its base has an IMU"
        written = ", ".join(a.text for a in self.outputs)
        return f"{text[0].upper()}{text[1:]}.\n\nInputs: {read}.\nOutputs: {written}."

    def absent(self, s: Subject) -> str:
        """Return the reason why a robot has no such kernel; "" if it has one."""
        if s.robot.base not in self.bases:
            reason = f"it {NOT_FOR[s.robot.base].format(s.robot.name)}"
            return f"{reason}: {self.excluded}" if self.excluded and s.robot.floating else reason
        if self.exists is not None and not self.exists(s):
            return f"{s.robot.name} has {self.lacks}"
        return ""

    def derive(self, s: Subject) -> Kernel | None:
        """Return the kernel of a robot; None if the robot has none."""
        if self.absent(s):
            return None
        if s.robot.floating and self.floating is not None:
            return replace(self.floating, floating=None).derive(s)
        every = (array.output(s) for array in self.outputs)
        outputs = tuple(o for o in every if o.size or s.robot.n)
        tape = self.tape(s, self.inputs)
        last = self.outputs[-1].shape[-1]
        if isinstance(last, Columns):
            rows = sum(math.prod(o.shape[:-1]) for o in outputs)
            width = len(tape.outputs) // rows
            places = [place for _, place in last.parameters(s)]
            tape = tape.keep([row * width + place for row in range(rows) for place in places])
        count = len(tape.outputs) - sum(o.size for o in outputs)
        pivots = min(count, len(s.robot.equations))
        guards = (*(count - pivots) * [_NO_LOAD], *pivots * [_NO_MASS])
        linear = s.base.linear if s.robot.loaded else "p"
        listed = ", ".join(p.name for p in s.base.standard)
        doc = self.doc.format(linear=linear, standard=listed)
        first = 0 if s.robot.floating else 1
        return Kernel(self.name, doc, tape, outputs, guards, self.batch, first)


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
        base = {GRAVITY, *names.FREE_BASE}
        read = {a.name: a.output(s).size for a in inputs if a.name not in base}
        count = read.pop("X")
        return plant.close([*read], _entries(derive(plant), s.robot.equations), count)

    return tape


def _entries(derived: Any, numbers: Sequence[int]) -> list[sp.Expr]:
    """Return the row-major entries of a derivation, for movable joints and a free base only.

    Args:
        derived: values or rows by joint, a list of entries, or several of these.
        numbers: the numbers of the equations.
    """
    if isinstance(derived, tuple):
        return [entry for part in derived for entry in _entries(part, numbers)]
    if not isinstance(derived, dict):
        return list(derived)
    rows = [derived[j] for j in numbers if j in derived]
    if not rows or not isinstance(rows[0], dict):
        return rows
    return [row.get(k, sp.S.Zero) for row in rows for k in numbers]

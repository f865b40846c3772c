"""The compiler from a robot to its kernels."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from symgen.codegen.definition import Subject
from symgen.codegen.derivations import Derivations
from symgen.codegen.kernel import Kernel
from symgen.codegen.kernels import ENERGY, KERNELS, SETS, expanded
from symgen.errors import ParameterError
from symgen.robot.effect import require_constants
from symgen.robot.nominal import nominal
from symgen.robot.toml_io import read_robot
from symgen.robot.types import Robot
from symgen.symbolic.base_parameters import BaseParameters, find_base
from symgen.symbolic.energy import energy_tape
from symgen.symbolic.independence import require_new_columns
from symgen.symbolic.parameters import standard_parameters
from symgen.symbolic.practical import practical_base


@dataclass(frozen=True)
class Model:
    """The model of a robot: base parameters with their proof, and kernels."""

    robot: Robot
    base: BaseParameters
    kernels: tuple[Kernel, ...]

    def __repr__(self) -> str:
        """Return the name of the robot and the numbers of joints and parameters."""
        count = len(self.base.parameters)
        return f"<Model {self.robot.name}: {self.robot.n} joints, {count} base parameters>"

    def __reduce__(self) -> tuple[Callable[..., Model], tuple[Robot, tuple[str, ...]]]:
        """Pickle the robot and the names of its kernels; unpickling derives or finds them again."""
        return derive, (self.robot, tuple(k.name for k in self.kernels))

    def _repr_html_(self) -> str:
        return self.base._repr_html_()

    def _repr_latex_(self) -> str:
        from symgen.codegen.latex import regroupings

        return regroupings(self.base)

    def closed_form(self, kernel: str) -> tuple[sp.Expr, ...] | None:
        """Return the output entries of a kernel as expressions; see `symgen.codegen.latex`.

        Args:
            kernel: the name of a derived kernel.

        Returns:
            The entries in row-major order; None if one of them has more than 200 operations.

        Raises:
            ParameterError: the model has no such kernel.
        """
        from symgen.codegen.latex import closed_form

        found = self.kernel(kernel)
        if found is None:
            known = ", ".join(k.name for k in self.kernels)
            raise ParameterError(f"kernel {kernel!r}; accepted: {known}")
        return closed_form(found)

    @property
    def inertial(self) -> int:
        """Number of inertial base parameters, which come first in X."""
        return self.base.inertial

    def kernel(self, name: str) -> Kernel | None:
        """Return the kernel with this name, or None."""
        return next((k for k in self.kernels if k.name == name), None)


@contextmanager
def uncollected() -> Iterator[None]:
    """Suspend Python's search for garbage cycles: expressions are many and contain none.

    At the end, all objects pass to the oldest generation. Otherwise the search would begin at once.
    """
    collecting = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collecting:
            gc.freeze()
            gc.unfreeze()
            gc.enable()


@uncollected()
def derive(
    robot: Robot | str | Path,
    kernels: Sequence[str] | str = ENERGY,
    *,
    meter: Callable[[float], None] = lambda _: None,
) -> Model:
    """Derive the model of a robot in its base parameters.

    Named lengths stay symbols. If their values in the file give a different minimal set than
    generic values, the model uses the values.

    Args:
        robot: the robot, its path, or a library name.
        kernels: names of the kernels to derive, "all" (without those of standard parameters and of
            loads) and "payload" among them; the energy model by default.
        meter: called with the finished share, from 0 to 1.

    Raises:
        SymgenError: the base parameters could not be proved.
        ParameterError: there is no such kernel.
        RobotError: there is no such robot, a constant of an effect is a range, or an effect is
            a combination of others.
    """
    robot = read_robot(robot)
    chosen = expanded([kernels] if isinstance(kernels, str) else kernels)
    for name in chosen:
        if name not in KERNELS:
            known = ", ".join((*SETS, *KERNELS))
            raise ParameterError(f"kernel {name!r}; accepted: some of {known}")
    require_constants(robot.sought)
    before = Derivations.of(robot)
    base, at_values = before.have("base", partial(_proved, robot))
    subject = Subject(robot.with_values() if at_values else robot, base)
    derived: list[Kernel] = []
    for name, definition in KERNELS.items():
        if name not in chosen:
            continue
        kernel = before.have(name, partial(definition.derive, subject))
        if kernel is not None:
            derived.append(kernel)
        meter(len(derived) / len(chosen))
    return Model(robot, base, tuple(derived))


def _proved(robot: Robot) -> tuple[BaseParameters, bool]:
    """Return the base parameters, and whether they hold only at the values of the lengths."""
    base, at_values = _base(robot)
    drawn = nominal(robot)
    if not robot.exact and drawn != robot:
        base = practical_base(robot, base, _base(drawn)[0])
    if robot.effects:
        require_new_columns(robot, base)
    return base, at_values


def _base(robot: Robot) -> tuple[BaseParameters, bool]:
    """Return the base parameters of a geometry, and whether they hold only at its values."""
    standard = standard_parameters(robot)
    base = find_base(robot, standard, energy_tape(robot))
    if base is not None:
        return base, False
    plain = robot.with_values()
    base = find_base(plain, standard, energy_tape(plain), at_values=True)
    assert base is not None
    return base, True


def regrouping(model: Model) -> NDArray[np.float64]:
    """Return G (p, s) of X = G s, from standard to base parameters, at the lengths of the robot."""
    base, numbers = model.base, model.robot.values()
    place = {p.name: k for k, p in enumerate(base.standard)}
    G = np.zeros((len(base.parameters), len(base.standard)))
    for row, p in enumerate(base.parameters):
        G[row, p.index] = 1.0
        for c, name in p.terms:
            G[row, place[name]] = float(c.subs(numbers).evalf(30))
    return G

"""derive: the whole compiler from a robot to its kernels, in the order of its stages."""

from __future__ import annotations

from dataclasses import dataclass

from symgen.robot.types import Robot
from symgen.symbolic import friction
from symgen.symbolic.base_parameters import BaseParameters, find_base
from symgen.symbolic.energy import energy_tape
from symgen.symbolic.parameters import standard_parameters
from symgen.symbolic.tape import Tape


@dataclass(frozen=True)
class Kernel:
    """One function of the model: what it computes, as a tape, and the shape of its output.

    Attributes:
        name: the contract's name, for example energy_regressor.
        tape: the program.
        shape: shape of the output array.
        columns: name of the parameter behind each column of the output.
    """

    name: str
    tape: Tape
    shape: tuple[int, ...]
    columns: tuple[str, ...]


@dataclass(frozen=True)
class Model:
    """The derived model of a robot: base parameters with their proof, and kernels."""

    robot: Robot
    base: BaseParameters
    kernels: tuple[Kernel, ...]

    @property
    def inertial(self) -> int:
        """Number of inertial base parameters: the first entries of X."""
        return self.base.inertial

    def kernel(self, name: str) -> Kernel | None:
        """Return the kernel of this name, or None where the model has none."""
        return next((k for k in self.kernels if k.name == name), None)


def derive(robot: Robot) -> Model:
    """Derive the energy model of a robot in its base parameters.

    Named lengths stay symbols, unless the file's values give another minimal set than generic
    ones: then the file's decide, and the model has numbers in their place.

    Args:
        robot: the mechanism.

    Raises:
        SymgenError: the base parameters could not be proved.
    """
    standard = standard_parameters(robot)
    energy = energy_tape(robot)
    base = find_base(robot, standard, energy)
    if base is None:
        plain = robot.with_values()
        energy = energy_tape(plain)
        base = find_base(plain, standard, energy, at_values=True)
    assert base is not None
    kept = [p for p in base.parameters if p.inertial]
    kernels = [
        Kernel(
            "energy_regressor",
            energy.keep([p.index for p in kept]),
            (len(kept),),
            tuple(p.name for p in kept),
        )
    ]
    rest = [p for p in base.parameters if not p.inertial]
    if rest:
        first = next(i for i, p in enumerate(standard) if not p.inertial)
        power = friction.power_tape(robot).keep([p.index - first for p in rest])
        kernels.append(Kernel("friction_power", power, (len(rest),), tuple(p.name for p in rest)))
    return Model(robot, base, tuple(kernels))

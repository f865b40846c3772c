"""The kernels of a model: name, what it computes, and how its tape is derived.

One table; a kernel is added by one entry.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import sympy as sp

from symgen.robot.types import Robot
from symgen.symbolic import dynamics, friction, placement, regressor
from symgen.symbolic.base_parameters import BaseParameters
from symgen.symbolic.tape import Tape

#: Input that is the number of a link; on the tape, one symbol for each link: 1 at its own, else 0.
LINK = "link"
#: Inputs that are plain numbers.
SCALARS = ("mass",)
#: Arrays that all samples of a batch share.
SHARED = ("X", "g")


@dataclass(frozen=True)
class Output:
    """One array that a kernel writes: name, shape, and the parameter behind each column."""

    name: str
    shape: tuple[int, ...]
    columns: tuple[str, ...] = ()

    @property
    def size(self) -> int:
        """Number of entries."""
        out = 1
        for extent in self.shape:
            out *= extent
        return out


@dataclass(frozen=True)
class Kernel:
    """One function of the model.

    Attributes:
        name: the contract's name, for example energy_regressor.
        doc: what it computes, in a line.
        tape: the program; its outputs are those of all arrays, one after the other, then `guards`
            numbers that must be positive for the result to have a meaning.
        outputs: the arrays it writes.
        guards: how many.
        batch: whether there is a form for N samples at once.
    """

    name: str
    doc: str
    tape: Tape
    outputs: tuple[Output, ...]
    guards: int = 0
    batch: bool = True

    @property
    def size(self) -> int:
        """Number of entries of all outputs."""
        return sum(output.size for output in self.outputs)


@dataclass(frozen=True)
class Subject:
    """What a kernel is derived from."""

    robot: Robot
    base: BaseParameters
    energy: Tape

    @property
    def inertial(self) -> list[int]:
        """Positions of the inertial base parameters among the standard ones."""
        return [p.index for p in self.base.parameters if p.inertial]

    @property
    def linear(self) -> list[int]:
        """Positions of the base parameters with a column among the standard ones."""
        return [p.index for p in self.base.parameters[: self.base.linear]]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the base parameters with a column."""
        return self.base.names[: self.base.linear]

    @property
    def columns(self) -> int:
        """Number of standard parameters with a column."""
        return sum(not p.load for p in self.base.standard)

    @property
    def numbers(self) -> list[int]:
        """Numbers of the movable joints."""
        return [j.number for j in self.robot.movable]


def _energy_regressor(s: Subject) -> Kernel:
    names = s.names[: s.base.inertial]
    return Kernel(
        "energy_regressor",
        "columns DE + DU of kinetic plus potential energy: E + U = out . X",
        s.energy.keep(s.inertial),
        (Output("out", (len(names),), names),),
    )


def _friction_power(s: Subject) -> Kernel | None:
    names, kept, _ = _friction_columns(s)
    if not names:
        return None
    return Kernel(
        "friction_power",
        f"columns of the power that friction takes: P = out . {_slice(s)}",
        friction.power_tape(s.robot).keep(kept),
        (Output("out", (len(names),), names),),
    )


def _friction_torque(s: Subject) -> Kernel | None:
    names, kept, count = _friction_columns(s)
    if not names:
        return None
    return Kernel(
        "friction_torque",
        f"columns of friction torque: out {_slice(s)}",
        friction.torque_tape(s.robot).keep(_rows(s.robot.n, count, kept)),
        (Output("out", (s.robot.n, len(names)), names),),
    )


def _slice(s: Subject) -> str:
    """Return the part of X that goes with the columns of friction, as headers write it."""
    return f"X[p_inertial..{s.base.linear if s.robot.loaded else 'p'})"


def _friction_columns(s: Subject) -> tuple[tuple[str, ...], list[int], int]:
    """Return the base parameters of friction, their positions, and the count of standard ones."""
    first = sum(p.inertial for p in s.base.standard)
    kept = [i - first for i in s.linear if i >= first]
    return s.names[s.base.inertial :], kept, s.columns - first


def _power_regressor(s: Subject) -> Kernel:
    return Kernel(
        "power_regressor",
        "columns of power: qd' tau = out . X, the rate of energy plus friction",
        regressor.power_tape(s.robot).keep(s.linear),
        (Output("out", (len(s.names),), s.names),),
    )


def _torque_regressor(s: Subject) -> Kernel:
    return Kernel(
        "torque_regressor",
        "columns of torque: tau = out X, friction included",
        regressor.torque_tape(s.robot).keep(_rows(s.robot.n, s.columns, s.linear)),
        (Output("out", (s.robot.n, len(s.names)), s.names),),
    )


def _momentum_regressor(s: Subject) -> Kernel:
    names, n = s.names[: s.base.inertial], s.robot.n
    count = sum(p.inertial for p in s.base.standard)
    rows = _rows(n, count, s.inertial)
    kept = rows + [n * count + i for i in rows]
    shape = (n, len(names))
    return Kernel(
        "momentum_regressor",
        "columns of p = dT/dqd and of dL/dq: dp/dt = tau - friction + dL/dq",
        regressor.momentum_tape(s.robot).keep(kept),
        (Output("p_out", shape, names), Output("dl_out", shape, names)),
    )


def _rows(n: int, count: int, kept: Sequence[int]) -> list[int]:
    return [j * count + i for j in range(n) for i in kept]


def _inverse_dynamics(s: Subject) -> Kernel:
    p = dynamics.plant(s.robot, s.base)
    torque = dynamics.inverse_dynamics(p)
    tape = p.close(("q", "qd", "qdd"), [torque[j] for j in s.numbers])
    doc = "torque of a motion: tau = M qdd + C qd + g + friction"
    return Kernel("inverse_dynamics", doc, tape, (Output("tau", (s.robot.n,)),))


def _bias_torque(s: Subject) -> Kernel:
    p = dynamics.plant(s.robot, s.base)
    torque = dynamics.inverse_dynamics(p, accelerating=False)
    tape = p.close(("q", "qd"), [torque[j] for j in s.numbers])
    return Kernel("bias_torque", "h = C qd + g + friction", tape, (Output("h", (s.robot.n,)),))


def _gravity_torque(s: Subject) -> Kernel:
    p = dynamics.plant(s.robot, s.base)
    torque = dynamics.gravity_torque(p)
    tape = p.close(("q",), [torque[j] for j in s.numbers], inertial=True)
    doc = "torque that holds the arm at rest, without friction"
    return Kernel("gravity_torque", doc, tape, (Output("tau", (s.robot.n,)),))


def _mass_matrix(s: Subject) -> Kernel:
    p = dynamics.plant(s.robot, s.base)
    entries = dynamics.dense(dynamics.mass_matrix(p), s.numbers)
    tape = p.close(("q",), entries, inertial=True)
    return Kernel("mass_matrix", "mass matrix M(q)", tape, (Output("M", (s.robot.n,) * 2),))


def _coriolis(s: Subject) -> Kernel:
    p = dynamics.plant(s.robot, s.base)
    entries = dynamics.dense(dynamics.coriolis(p), s.numbers)
    tape = p.close(("q", "qd"), entries, inertial=True)
    doc = "C(q, qd) with C qd the Coriolis torques and dM/dt - 2 C skew-symmetric"
    return Kernel("coriolis", doc, tape, (Output("C", (s.robot.n,) * 2),))


def _forward_dynamics(s: Subject) -> Kernel:
    p = dynamics.plant(s.robot, s.base)
    qdd, pivots = dynamics.forward_dynamics(p)
    tape = p.close(("q", "qd", "tau"), [*qdd, *pivots])
    doc = "accelerations under torques tau; not 0 where M is not positive definite"
    if s.robot.loaded:
        doc += ", or a share of the load lets nothing through"
    return Kernel("forward_dynamics", doc, tape, (Output("qdd", (s.robot.n,)),), len(pivots))


def _energy(s: Subject) -> Kernel:
    p = dynamics.plant(s.robot, s.base)
    tape = p.close(("q", "qd"), dynamics.energies(p), inertial=True)
    doc = "kinetic energy T and potential energy U, U up to a constant"
    return Kernel("energy", doc, tape, (Output("T_out", (1,)), Output("U_out", (1,))))


def _frames(s: Subject) -> Kernel:
    tape = placement.frames_tape(s.robot)
    doc = "homogeneous transforms 0T_j of all links, fixed ones included"
    return Kernel("frames", doc, tape, (Output("T_out", (len(s.robot.joints), 4, 4)),))


def _jacobian(s: Subject) -> Kernel:
    tape = placement.jacobian_tape(s.robot)
    doc = "Jacobian of the last frame that moves, in frame 0: rows of velocity, then of turning"
    return Kernel("jacobian", doc, tape, (Output("J_out", (6, s.robot.n)),))


RECIPES: dict[str, Callable[[Subject], Kernel | None]] = {
    "energy_regressor": _energy_regressor,
    "friction_power": _friction_power,
    "friction_torque": _friction_torque,
    "power_regressor": _power_regressor,
    "momentum_regressor": _momentum_regressor,
    "torque_regressor": _torque_regressor,
    "inverse_dynamics": _inverse_dynamics,
    "mass_matrix": _mass_matrix,
    "gravity_torque": _gravity_torque,
    "coriolis": _coriolis,
    "bias_torque": _bias_torque,
    "forward_dynamics": _forward_dynamics,
    "energy": _energy,
    "frames": _frames,
    "jacobian": _jacobian,
}
#: What identification by energy needs.
ENERGY = ("energy_regressor", "friction_power")
ALL = tuple(RECIPES)


def regrouped(
    base: BaseParameters, standard: Sequence[float], numbers: dict[sp.Symbol, sp.Expr]
) -> list[float]:
    """Return base parameters X from standard ones: X_b = X_head + sum of c X_d."""
    value = dict(zip((p.name for p in base.standard), standard, strict=True))
    return [
        value[p.head] + sum(float(c.subs(numbers).evalf(30)) * value[name] for c, name in p.terms)
        for p in base.parameters
    ]

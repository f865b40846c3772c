"""The table of kernels: name, description, and derivation of the tape.

A new kernel is one entry.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, partial
from typing import Any

import sympy as sp

from symgen.codegen.kernels import NO_MASS, Kernel, Output
from symgen.robot.types import Robot
from symgen.symbolic import (
    derivatives,
    dynamics,
    energy,
    forward,
    friction,
    passive,
    placement,
    regressor,
    regrouping,
)
from symgen.symbolic.base_parameters import BaseParameters
from symgen.symbolic.tape import Tape


@dataclass(frozen=True)
class Subject:
    """Input of a derivation: robot and parameters."""

    robot: Robot
    base: BaseParameters

    @cached_property
    def kernel(self) -> Callable[[str], Kernel | None]:
        """Return a function that derives a kernel by its name, each one once."""
        return cache(lambda name: RECIPES[name](name, self))

    @property
    def inertial(self) -> list[int]:
        """Positions of the inertial base parameters among the standard parameters."""
        return [p.index for p in self.base.parameters if p.inertial]

    @property
    def linear(self) -> list[int]:
        """Positions of the base parameters with a column among the standard parameters."""
        return [p.index for p in self.base.parameters[: self.base.linear]]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the base parameters with a column."""
        return self.base.names[: self.base.linear]

    @property
    def all_names(self) -> tuple[str, ...]:
        """Names of the standard parameters with a column."""
        return tuple(p.name for p in self.base.standard if not p.load)

    @property
    def own(self) -> int:
        """Number of inertial standard parameters, which come first."""
        return sum(p.inertial for p in self.base.standard)

    @property
    def friction(self) -> list[int]:
        """Positions of the base parameters of friction and effects among their standard ones."""
        return [i - self.own for i in self.linear if i >= self.own]

    @property
    def rubbing(self) -> tuple[str, ...]:
        """Names of the base parameters of friction and effects."""
        return self.names[self.base.inertial :]

    def rows(self, count: int, kept: Sequence[int]) -> list[int]:
        """Return the row-major indices of some columns of an (n, count) matrix."""
        return [j * count + i for j in range(self.robot.n) for i in kept]

    def entries(self, found: Any) -> list[sp.Expr]:
        """Return the row-major entries of a derivation, for movable joints only.

        Args:
            found: values or rows by joint, a list of entries, or several of these.
        """
        if isinstance(found, tuple):
            return [entry for part in found for entry in self.entries(part)]
        if not isinstance(found, dict):
            return list(found)
        numbers = self.robot.numbers
        rows = [found[j] for j in numbers]
        if not isinstance(rows[0], dict):
            return rows
        return [row.get(k, sp.S.Zero) for row in rows for k in numbers]


Recipe = Callable[[str, Subject], Kernel | None]

#: What guards say that are not pivots of the mass matrix, and what to do.
_NO_LOAD = (
    "an effect of the load leaves no unique acceleration; accepted: coefficients for which its "
    "torque stays below that of the load"
)


def _of_tape(
    doc: str,
    outputs: str,
    derive: Callable[[Subject], Tape],
    *,
    batch: bool = True,
) -> Recipe:
    """Return the recipe of a kernel; tape outputs after those of `outputs` are guards.

    The last n guards are pivots of the mass matrix. Guards before them are about effects of the
    load.

    Args:
        doc: description.
        outputs: names and shapes, "M n n; h n", with the numbers of joints `n`, of links `links`,
            and of base parameters `p`.
        derive: function that derives the tape.
        batch: whether there is a version for N samples.
    """

    def recipe(name: str, s: Subject) -> Kernel:
        counts = {"n": s.robot.n, "links": len(s.robot.joints), "p": len(s.base.parameters)}
        arrays, tape = [], derive(s)
        for output in outputs.split(";"):
            array, *shape = output.split()
            arrays.append(Output(array, tuple(counts.get(k) or int(k) for k in shape)))
        count = len(tape.outputs) - sum(array.size for array in arrays)
        pivots = min(count, s.robot.n)
        guards = (*(count - pivots) * [_NO_LOAD], *pivots * [NO_MASS])
        return Kernel(name, doc, tape, tuple(arrays), guards, batch)

    return recipe


def _of_plant(
    doc: str,
    inputs: str,
    outputs: str,
    derive: Callable[[dynamics.Plant], Any],
    *,
    inertial: bool = False,
) -> Recipe:
    """Return the recipe of a kernel that is linear or rational in X."""

    def tape(s: Subject) -> Tape:
        p = dynamics.plant(s.robot, s.base)
        return p.close(inputs.split(), s.entries(derive(p)), inertial=inertial)

    return _of_tape(doc, outputs, tape)


def _columns(
    name: str, doc: str, tape: Tape, names: tuple[str, ...], *lead: int, outputs: str = "out"
) -> Kernel:
    """Return a kernel with one column for each parameter."""
    arrays = (Output(output, (*lead, len(names)), names) for output in outputs.split())
    return Kernel(name, doc, tape, tuple(arrays))


def _friction_power(name: str, s: Subject) -> Kernel | None:
    kept = s.friction
    doc = f"columns of the power that friction takes: P = out . {_slice(s)}"
    return _columns(name, doc, friction.power_tape(s.robot).keep(kept), s.rubbing) if kept else None


def _friction_torque(name: str, s: Subject) -> Kernel | None:
    kept, doc = s.friction, f"columns of friction torque: out {_slice(s)}"
    if not kept:
        return None
    tape = friction.torque_tape(s.robot).keep(s.rows(len(s.all_names) - s.own, kept))
    return _columns(name, doc, tape, s.rubbing, s.robot.n)


def _slice(s: Subject) -> str:
    """Return the part of X for the columns of friction, as text for headers."""
    return f"X[p_inertial..{s.base.linear if s.robot.loaded else 'p'})"


def _momentum_regressor(name: str, s: Subject) -> Kernel:
    first = s.rows(s.own, s.inertial)
    kept = first + [s.robot.n * s.own + i for i in first]
    return _columns(
        name,
        "columns of p = dT/dqd and of dL/dq: dp/dt = tau - friction + dL/dq",
        regressor.momentum_tape(s.robot).keep(kept),
        s.names[: s.base.inertial],
        s.robot.n,
        outputs="p_out dl_out",
    )


def _forward_dynamics(name: str, s: Subject) -> Kernel | None:
    doc = "accelerations under torques tau; not 0 where M is not positive definite"
    if s.robot.loaded:
        doc += ", or a share of the load lets nothing through"
    return _of_plant(doc, "q qd tau", "qdd n", forward.forward_dynamics)(name, s)


def _effects(name: str, s: Subject) -> Kernel | None:
    doc = "torque of the declared effects; with friction and the rigid body it is inverse_dynamics"
    inputs = "q qd qdd"
    kernel = _of_plant(doc, inputs, "tau n", dynamics.effect_torques)
    return kernel(name, s) if s.robot.effects else None


def _base_parameters(name: str, s: Subject) -> Kernel | None:
    order = ", ".join(p.name for p in s.base.standard)
    doc = f"X from the standard parameters, in this order: {order}"
    tape = regrouping.base_parameters_tape(s.robot, s.base)
    return _of_tape(doc, "X p", lambda _: tape, batch=False)(name, s)


RECIPES: dict[str, Recipe] = {
    "energy_regressor": lambda name, s: _columns(
        name,
        "columns DE + DU of kinetic plus potential energy: E + U = out . X",
        energy.energy_tape(s.robot).keep(s.inertial),
        s.names[: s.base.inertial],
    ),
    "friction_power": _friction_power,
    "friction_torque": _friction_torque,
    "power_regressor": lambda name, s: _columns(
        name,
        "columns of power: qd' tau = out . X, the rate of energy plus friction",
        regressor.power_tape(s.robot).keep(s.linear),
        s.names,
    ),
    "momentum_regressor": _momentum_regressor,
    "torque_regressor": lambda name, s: _columns(
        name,
        "columns of torque: tau = out X, friction included",
        regressor.torque_tape(s.robot).keep(s.rows(len(s.all_names), s.linear)),
        s.names,
        s.robot.n,
    ),
    "inverse_dynamics": _of_plant(
        "torque of a motion: tau = M qdd + C qd + g + friction",
        "q qd qdd",
        "tau n",
        dynamics.inverse_dynamics,
    ),
    "mass_matrix": _of_plant(
        "mass matrix M(q)",
        "q",
        "M n n",
        dynamics.mass_matrix,
        inertial=True,
    ),
    "gravity_torque": _of_plant(
        "torque that holds the arm at rest, without friction",
        "q",
        "tau n",
        dynamics.gravity_torque,
        inertial=True,
    ),
    "coriolis": _of_plant(
        "C(q, qd) with C qd the Coriolis torques and dM/dt - 2 C skew-symmetric",
        "q qd",
        "C n n",
        dynamics.coriolis,
        inertial=True,
    ),
    "bias_torque": _of_plant(
        "h = C qd + g + friction",
        "q qd",
        "h n",
        partial(dynamics.inverse_dynamics, accelerating=False),
    ),
    "forward_dynamics": _forward_dynamics,
    "energy": _of_plant(
        "kinetic energy T and potential energy U, U up to a constant",
        "q qd",
        "T_out 1; U_out 1",
        dynamics.energies,
        inertial=True,
    ),
    "frames": _of_tape(
        "homogeneous transforms 0T_j of all links, fixed ones included",
        "T_out links 4 4",
        lambda s: placement.frames_tape(s.robot),
    ),
    "jacobian": _of_tape(
        "Jacobian of the last frame that moves, in frame 0: rows of velocity, then of turning",
        "J_out 6 n",
        lambda s: placement.jacobian_tape(s.robot),
    ),
    "slotine_li_regressor": lambda name, s: _columns(
        name,
        "columns of M qddr + C(q, qd) qdr + g + friction(qd) = out X, C of Christoffel's symbols",
        regressor.slotine_li_tape(s.robot).keep(s.rows(len(s.all_names), s.linear)),
        s.names,
        s.robot.n,
    ),
    "slotine_li_torque": _of_plant(
        "M qddr + C(q, qd) qdr + g + friction(qd), C of Christoffel's symbols",
        "q qd qdr qddr",
        "tau n",
        passive.slotine_li_torque,
    ),
    "generalized_momentum": _of_plant(
        "p = M qd and rate = C' qd - g: dp/dt = tau - friction + rate",
        "q qd",
        "p_out n; rate_out n",
        passive.generalized_momentum,
        inertial=True,
    ),
    "friction": _of_plant(
        "torque of the friction that joints and couplings declare; effects are not in it",
        "qd",
        "tau n",
        dynamics.joint_friction,
    ),
    "effects": _effects,
    "inverse_dynamics_derivatives": _of_plant(
        "dtau/dq and dtau/dqd; dtau/dqdd is mass_matrix; the derivative of sign(qd) is 0",
        "q qd qdd",
        "dq_out n n; dqd_out n n",
        derivatives.inverse_dynamics_derivatives,
    ),
    "forward_dynamics_derivatives": _of_plant(
        "dqdd/dq, dqdd/dqd and dqdd/dtau; the derivative of sign(qd) is 0",
        "q qd tau",
        "dq_out n n; dqd_out n n; dtau_out n n",
        derivatives.forward_dynamics_derivatives,
    ),
    "solve_mass_matrix": _of_plant(
        "x of M(q) x = b",
        "q b",
        "x n",
        forward.solve_mass_matrix,
        inertial=True,
    ),
    "mass_matrix_factor": _of_plant(
        "M = L D L' with ones on the diagonal of L and zeros below it; for projections solve with "
        "L from its last row",
        "q",
        "L_out n n; D_out n",
        forward.mass_matrix_factor,
        inertial=True,
    ),
    "link_jacobian": _of_tape(
        "Jacobian, in frame 0, of a point in the frame of a link: velocity, then turning",
        "J 6 n",
        lambda s: placement.link_jacobian_tape(s.robot),
    ),
    "link_drift": _of_tape(
        "dJ/dt qd of a point in the frame of a link: its acceleration without qdd, in frame 0",
        "a 6",
        lambda s: placement.link_drift_tape(s.robot),
    ),
    "base_parameters": _base_parameters,
    "add_body": _of_tape(
        "fix a body on a link, in X: its mass, the centre of mass in the frame of the link, and "
        "inertia XX XY XZ YY YZ ZZ about that; mass and inertia negative: take it off",
        "X p",
        lambda s: regrouping.add_body_tape(s.robot, s.base),
        batch=False,
    ),
    "standard_energy_regressor": lambda name, s: _columns(
        name,
        "columns DE and DU of kinetic and of potential energy in every standard parameter",
        energy.separate_tape(s.robot),
        tuple(p.name for p in s.base.standard if p.inertial),
        outputs="kinetic_out potential_out",
    ),
    "standard_torque_regressor": lambda name, s: _columns(
        name,
        "columns of torque in every standard parameter, friction included",
        regressor.torque_tape(s.robot),
        s.all_names,
        s.robot.n,
    ),
}
#: Kernels that only robots with friction or effects have.
FRICTION = ("friction_power", "friction_torque", "effects")
#: Kernels of standard parameters, written only on request.
STANDARD = ("standard_energy_regressor", "standard_torque_regressor")
ALL = tuple(name for name in RECIPES if name not in STANDARD)

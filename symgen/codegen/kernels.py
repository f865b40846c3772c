"""The kernels: one entry each, from which all their forms are made.

An entry states the name, a description, the inputs and outputs with their shapes, and the
derivation. C declarations, batches, panels, CasADi functions, the manifest, the methods of an
evaluator with their stub, and the table of docs/c.md follow from it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import sympy as sp

from symgen.codegen.kernel import Kernel, Output
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

#: What is wrong with a call whose pivot of the mass matrix is not positive, and what to do.
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
    """What a kernel is derived from: a robot and its base parameters."""

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
        parameters: returns the name of each parameter, and its place among the columns derived.
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
        """The shape in documents, such as "(n, p)"."""
        sizes = [str(s) if isinstance(s, int) else s.symbol for s in self.shape]
        return f"({sizes[0]},)" if len(sizes) == 1 else f"({', '.join(sizes)})"

    def output(self, s: Subject) -> Output:
        """Return the array of one robot."""
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
class Definition:
    """The definition of a kernel.

    Attributes:
        group: its row in documents.
        name: its name in the interface.
        doc: description; {linear} stands for the end of the parameters with a column, {standard}
            for the names of the standard parameters.
        inputs: the arrays that it reads; g only where gravity is an input of the robot.
        outputs: the arrays that it writes.
        tape: derives the program. Its outputs after those of the arrays are guards, the last n of
            them the pivots of the mass matrix; guards before them are about effects of the load.
        exists: whether a robot has it.
        batch: whether there is a version for N samples.
        standard: whether it is about standard parameters, and written only on request.
    """

    group: str
    name: str
    doc: str
    inputs: tuple[Array, ...]
    outputs: tuple[Array, ...]
    tape: Derivation
    exists: Callable[[Subject], bool] | None = None
    batch: bool = True
    standard: bool = False

    @property
    def documented(self) -> str:
        """The description of the evaluator's method: meaning, inputs and outputs."""
        text = self.doc.format(linear="p", standard="model.base.standard")
        inputs = [a for a in self.inputs if a is not G]
        read = ", ".join(f"{a.name} {a.text}" if a.shape else a.name for a in inputs)
        if G in self.inputs:
            read += ", and g (3,) if gravity is an input of the robot"
        written = ", ".join(f"{a.name} {a.text}" for a in self.outputs)
        return f"{text[0].upper()}{text[1:]}.\n\nInputs: {read}.\nOutputs: {written}."

    def derive(self, s: Subject) -> Kernel | None:
        """Return the kernel of a robot; None if the robot has none."""
        if self.exists is not None and not self.exists(s):
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


def _linear(s: Subject) -> list[tuple[str, int]]:
    """Return the base parameters with a column."""
    return [(b.name, b.index) for b in s.base.parameters[: s.base.linear]]


def _inertial(s: Subject) -> list[tuple[str, int]]:
    return [(b.name, b.index) for b in s.base.parameters if b.inertial]


def _rubbing(s: Subject) -> list[tuple[str, int]]:
    """Return the base parameters of friction and effects, which stand behind the inertial ones."""
    first = sum(p.inertial for p in s.base.standard)
    return [(name, place - first) for name, place in _linear(s) if place >= first]


def _standard(s: Subject, *, inertial: bool) -> list[tuple[str, int]]:
    """Return the standard parameters with a column, or the inertial ones."""
    kept = [p.name for p in s.base.standard if (p.inertial if inertial else not p.load)]
    return [(name, place) for place, name in enumerate(kept)]


_N = Size("n", lambda s: s.robot.n)
_LINKS = Size("links", lambda s: len(s.robot.joints))
_P = Size("p", lambda s: len(s.base.parameters))
_P_INERTIAL = Size("p_inertial", lambda s: s.base.inertial)
_S = Size("s", lambda s: len(s.base.standard))
_LINEAR = Columns("p", _linear)
_INERTIAL = Columns("p_inertial", _inertial)
_RUBBING = Columns("p - p_inertial", _rubbing)
_STANDARD = Columns("s", partial(_standard, inertial=False))
_STANDARD_INERTIAL = Columns("s_inertial", partial(_standard, inertial=True))

Q = Array("q", (_N,))
QD = Array("qd", (_N,))
QDD = Array("qdd", (_N,))
TAU = Array("tau", (_N,))
QDR = Array("qdr", (_N,))
QDDR = Array("qddr", (_N,))
B = Array("b", (_N,))
X = Array("X", (_P,))
X_INERTIAL = Array("X", (_P_INERTIAL,))
STANDARD = Array("standard", (_S,))
LINK = Array("link", ())
POINT = Array("point", (3,))
MASS = Array("mass", ())
COM = Array("com", (3,))
INERTIA = Array("inertia", (6,))
#: Gravity, of kernels that depend on it.
G = Array("g", (3,))


def _of_robot(derive: Callable[[Robot], Tape]) -> Derivation:
    return lambda s, _: derive(s.robot)


def _of_base(derive: Callable[[Robot, BaseParameters], Tape]) -> Derivation:
    return lambda s, _: derive(s.robot, s.base)


def _of_plant(derive: Callable[[dynamics.Plant], Any]) -> Derivation:
    """Return the derivation of a kernel that reads X."""

    def tape(s: Subject, inputs: Sequence[Array]) -> Tape:
        plant = dynamics.plant(s.robot, s.base)
        states = [a.name for a in inputs if a.name not in (X.name, G.name)]
        entries = _entries(derive(plant), s.robot.numbers)
        return plant.close(states, entries, inertial=X_INERTIAL in inputs)

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


DEFINITIONS = (
    Definition(
        "regressors",
        "energy_regressor",
        "columns DE + DU of kinetic plus potential energy: E + U = out . X",
        (Q, QD, G),
        (Array("out", (_INERTIAL,)),),
        _of_robot(energy.energy_tape),
    ),
    Definition(
        "regressors",
        "friction_power",
        "columns of the power that friction takes: P = out . X[p_inertial..{linear})",
        (Q, QD),
        (Array("out", (_RUBBING,)),),
        _of_robot(friction.power_tape),
        exists=lambda s: bool(_rubbing(s)),
    ),
    Definition(
        "regressors",
        "friction_torque",
        "columns of friction torque: out X[p_inertial..{linear})",
        (Q, QD),
        (Array("out", (_N, _RUBBING)),),
        _of_robot(friction.torque_tape),
        exists=lambda s: bool(_rubbing(s)),
    ),
    Definition(
        "regressors",
        "power_regressor",
        "columns of power: qd' tau = out . X, the rate of energy plus friction",
        (Q, QD, QDD, G),
        (Array("out", (_LINEAR,)),),
        _of_robot(regressor.power_tape),
    ),
    Definition(
        "regressors",
        "momentum_regressor",
        "columns of p = dT/dqd and of dL/dq: dp/dt = tau - friction + dL/dq",
        (Q, QD, G),
        (Array("p_out", (_N, _INERTIAL)), Array("dl_out", (_N, _INERTIAL))),
        _of_robot(regressor.momentum_tape),
    ),
    Definition(
        "regressors",
        "torque_regressor",
        "columns of torque: tau = out X, friction included",
        (Q, QD, QDD, G),
        (Array("out", (_N, _LINEAR)),),
        _of_robot(regressor.torque_tape),
    ),
    Definition(
        "dynamics",
        "inverse_dynamics",
        "torque of a motion: tau = M qdd + C qd + g + friction",
        (Q, QD, QDD, X, G),
        (TAU,),
        _of_plant(dynamics.inverse_dynamics),
    ),
    Definition(
        "dynamics",
        "mass_matrix",
        "mass matrix M(q)",
        (Q, X_INERTIAL),
        (Array("M", (_N, _N)),),
        _of_plant(dynamics.mass_matrix),
    ),
    Definition(
        "dynamics",
        "gravity_torque",
        "torque that holds the arm at rest, without friction",
        (Q, X_INERTIAL, G),
        (TAU,),
        _of_plant(dynamics.gravity_torque),
    ),
    Definition(
        "dynamics",
        "coriolis",
        "C(q, qd) with C qd the Coriolis torques and dM/dt - 2 C skew-symmetric",
        (Q, QD, X_INERTIAL),
        (Array("C", (_N, _N)),),
        _of_plant(dynamics.coriolis),
    ),
    Definition(
        "dynamics",
        "bias_torque",
        "h = C qd + g + friction",
        (Q, QD, X, G),
        (Array("h", (_N,)),),
        _of_plant(partial(dynamics.inverse_dynamics, accelerating=False)),
    ),
    Definition(
        "dynamics",
        "forward_dynamics",
        "accelerations under torques tau; not 0 where M is not positive definite",
        (Q, QD, TAU, X, G),
        (QDD,),
        _of_plant(forward.forward_dynamics),
    ),
    Definition(
        "dynamics",
        "energy",
        "kinetic energy T and potential energy U, U up to a constant",
        (Q, QD, X_INERTIAL, G),
        (Array("T_out", (1,)), Array("U_out", (1,))),
        _of_plant(dynamics.energies),
    ),
    Definition(
        "kinematics",
        "frames",
        "homogeneous transforms 0T_j of all links, fixed ones included",
        (Q,),
        (Array("T_out", (_LINKS, 4, 4)),),
        _of_robot(placement.frames_tape),
    ),
    Definition(
        "kinematics",
        "jacobian",
        "Jacobian of the last frame that moves, in frame 0: rows of velocity, then of turning",
        (Q,),
        (Array("J_out", (6, _N)),),
        _of_robot(placement.jacobian_tape),
    ),
    Definition(
        "control",
        "slotine_li_regressor",
        "columns of M qddr + C(q, qd) qdr + g + friction(qd) = out X, C of Christoffel's symbols",
        (Q, QD, QDR, QDDR, G),
        (Array("out", (_N, _LINEAR)),),
        _of_robot(regressor.slotine_li_tape),
    ),
    Definition(
        "control",
        "slotine_li_torque",
        "M qddr + C(q, qd) qdr + g + friction(qd), C of Christoffel's symbols",
        (Q, QD, QDR, QDDR, X, G),
        (TAU,),
        _of_plant(passive.slotine_li_torque),
    ),
    Definition(
        "control",
        "generalized_momentum",
        "p = M qd and rate = C' qd - g: dp/dt = tau - friction + rate",
        (Q, QD, X_INERTIAL, G),
        (Array("p_out", (_N,)), Array("rate_out", (_N,))),
        _of_plant(passive.generalized_momentum),
    ),
    Definition(
        "dynamics",
        "friction",
        "torque of the friction that joints and couplings declare; effects are not in it",
        (QD, X),
        (TAU,),
        _of_plant(dynamics.joint_friction),
    ),
    Definition(
        "dynamics",
        "effects",
        "torque of the declared effects; with friction and the rigid body it is inverse_dynamics",
        (Q, QD, QDD, X, G),
        (TAU,),
        _of_plant(dynamics.effect_torques),
        exists=lambda s: bool(s.robot.effects),
    ),
    Definition(
        "derivatives",
        "inverse_dynamics_derivatives",
        "dtau/dq and dtau/dqd; dtau/dqdd is mass_matrix; the derivative of sign(qd) is 0",
        (Q, QD, QDD, X, G),
        (Array("dq_out", (_N, _N)), Array("dqd_out", (_N, _N))),
        _of_plant(derivatives.inverse_dynamics_derivatives),
    ),
    Definition(
        "derivatives",
        "forward_dynamics_derivatives",
        "dqdd/dq, dqdd/dqd and dqdd/dtau; the derivative of sign(qd) is 0",
        (Q, QD, TAU, X, G),
        (Array("dq_out", (_N, _N)), Array("dqd_out", (_N, _N)), Array("dtau_out", (_N, _N))),
        _of_plant(derivatives.forward_dynamics_derivatives),
    ),
    Definition(
        "mass matrix",
        "solve_mass_matrix",
        "x of M(q) x = b",
        (Q, B, X_INERTIAL),
        (Array("x", (_N,)),),
        _of_plant(forward.solve_mass_matrix),
    ),
    Definition(
        "mass matrix",
        "mass_matrix_factor",
        "M = L D L' with ones on the diagonal of L and zeros below it; for projections solve with "
        "L from its last row",
        (Q, X_INERTIAL),
        (Array("L_out", (_N, _N)), Array("D_out", (_N,))),
        _of_plant(forward.mass_matrix_factor),
    ),
    Definition(
        "kinematics",
        "link_jacobian",
        "Jacobian, in frame 0, of a point in the frame of a link: velocity, then turning",
        (Q, LINK, POINT),
        (Array("J", (6, _N)),),
        _of_robot(placement.link_jacobian_tape),
    ),
    Definition(
        "kinematics",
        "link_drift",
        "dJ/dt qd of a point in the frame of a link: its acceleration without qdd, in frame 0",
        (Q, QD, LINK, POINT),
        (Array("a", (6,)),),
        _of_robot(placement.link_drift_tape),
    ),
    Definition(
        "at run time",
        "base_parameters",
        "X from the standard parameters, in this order: {standard}",
        (STANDARD,),
        (X,),
        _of_base(regrouping.base_parameters_tape),
        batch=False,
    ),
    Definition(
        "at run time",
        "add_body",
        "fix a body on a link, in X: its mass, the centre of mass in the frame of the link, and "
        "inertia XX XY XZ YY YZ ZZ about that; mass and inertia negative: take it off",
        (X, LINK, MASS, COM, INERTIA),
        (X,),
        _of_base(regrouping.add_body_tape),
        batch=False,
    ),
    Definition(
        "with `--standard`",
        "standard_energy_regressor",
        "columns DE and DU of kinetic and of potential energy in every standard parameter",
        (Q, QD, G),
        (
            Array("kinetic_out", (_STANDARD_INERTIAL,)),
            Array("potential_out", (_STANDARD_INERTIAL,)),
        ),
        _of_robot(energy.separate_tape),
        standard=True,
    ),
    Definition(
        "with `--standard`",
        "standard_torque_regressor",
        "columns of torque in every standard parameter, friction included",
        (Q, QD, QDD, G),
        (Array("out", (_N, _STANDARD)),),
        _of_robot(regressor.torque_tape),
        standard=True,
    ),
)
KERNELS = {d.name: d for d in DEFINITIONS}
#: Kernels that are not about standard parameters.
ALL = tuple(d.name for d in DEFINITIONS if not d.standard)
#: Kernels that identification with the energy model needs.
ENERGY = ("energy_regressor", "friction_power")

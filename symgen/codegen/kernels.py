"""The kernels: one definition each, from which all their forms are made.

A definition has the name, a description, the inputs and outputs with their shapes, and the
derivation. C declarations, batches, panels, CasADi functions, the manifest, the methods of an
evaluator with their stub, and the table of docs/c.md follow from it.
"""

from __future__ import annotations

from functools import partial

from symgen.codegen.definition import (
    GRAVITY,
    Array,
    Columns,
    KernelDefinition,
    Size,
    Subject,
    of_base,
    of_plant,
    of_robot,
)
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


def _linear(s: Subject) -> list[tuple[str, int]]:
    """Return the base parameters with a column."""
    return [(b.name, b.index) for b in s.base.parameters[: s.base.linear]]


def _inertial(s: Subject) -> list[tuple[str, int]]:
    return [(b.name, b.index) for b in s.base.parameters if b.inertial]


def _rubbing(s: Subject) -> list[tuple[str, int]]:
    """Return the base parameters of friction and effects, which follow the inertial ones."""
    first = sum(p.inertial for p in s.base.standard)
    return [(name, place - first) for name, place in _linear(s) if place >= first]


def _rubs(s: Subject) -> bool:
    """Return whether a robot has friction or effects with columns."""
    return bool(_rubbing(s))


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
_ALL_STANDARD = Columns("s", partial(_standard, inertial=False))
_STANDARD_INERTIAL = Columns("s_inertial", partial(_standard, inertial=True))

_Q = Array("q", (_N,))
_QD = Array("qd", (_N,))
_QDD = Array("qdd", (_N,))
_TAU = Array("tau", (_N,))
_QDR = Array("qdr", (_N,))
_QDDR = Array("qddr", (_N,))
_B = Array("b", (_N,))
_X = Array("X", (_P,))
_X_INERTIAL = Array("X", (_P_INERTIAL,))
_STANDARD = Array("standard", (_S,))
_LINK = Array("link", ())
_POINT = Array("point", (3,))
_MASS = Array("mass", ())
_COM = Array("com", (3,))
_INERTIA = Array("inertia", (6,))
#: Gravity, for kernels that depend on it.
_G = Array(GRAVITY, (3,))


DEFINITIONS = (
    KernelDefinition(
        "regressors",
        "energy_regressor",
        "columns DE + DU of kinetic plus potential energy: E + U = out . X",
        (_Q, _QD, _G),
        (Array("out", (_INERTIAL,)),),
        of_robot(energy.energy_tape),
        fixed_base=True,
    ),
    KernelDefinition(
        "regressors",
        "friction_power",
        "columns of the power that friction takes: P = out . X[p_inertial..{linear})",
        (_Q, _QD),
        (Array("out", (_RUBBING,)),),
        of_robot(friction.friction_power_tape),
        exists=_rubs,
        fixed_base=True,
    ),
    KernelDefinition(
        "regressors",
        "friction_torque",
        "columns of friction torque: out X[p_inertial..{linear})",
        (_Q, _QD),
        (Array("out", (_N, _RUBBING)),),
        of_robot(friction.friction_torque_tape),
        exists=_rubs,
    ),
    KernelDefinition(
        "regressors",
        "power_regressor",
        "columns of power: qd' tau = out . X, the rate of energy plus friction",
        (_Q, _QD, _QDD, _G),
        (Array("out", (_LINEAR,)),),
        of_robot(regressor.power_tape),
        fixed_base=True,
    ),
    KernelDefinition(
        "regressors",
        "momentum_regressor",
        "columns of p = dT/dqd and of dL/dq: dp/dt = tau - friction + dL/dq",
        (_Q, _QD, _G),
        (Array("p_out", (_N, _INERTIAL)), Array("dl_out", (_N, _INERTIAL))),
        of_robot(regressor.momentum_tape),
        fixed_base=True,
    ),
    KernelDefinition(
        "regressors",
        "torque_regressor",
        "columns of torque: tau = out X, friction included",
        (_Q, _QD, _QDD, _G),
        (Array("out", (_N, _LINEAR)),),
        of_robot(regressor.torque_tape),
    ),
    KernelDefinition(
        "dynamics",
        "inverse_dynamics",
        "torque of a motion: tau = M qdd + C qd + g + friction",
        (_Q, _QD, _QDD, _X, _G),
        (_TAU,),
        of_plant(dynamics.inverse_dynamics),
    ),
    KernelDefinition(
        "dynamics",
        "mass_matrix",
        "mass matrix M(q)",
        (_Q, _X_INERTIAL),
        (Array("M", (_N, _N)),),
        of_plant(dynamics.mass_matrix, inertial=True),
    ),
    KernelDefinition(
        "dynamics",
        "gravity_torque",
        "torque of gravity on the links, without springs and friction",
        (_Q, _X_INERTIAL, _G),
        (_TAU,),
        of_plant(dynamics.gravity_torque, inertial=True),
    ),
    KernelDefinition(
        "dynamics",
        "coriolis",
        "C(q, qd) with C qd the Coriolis torques and dM/dt - 2 C skew-symmetric",
        (_Q, _QD, _X_INERTIAL),
        (Array("C", (_N, _N)),),
        of_plant(dynamics.coriolis, inertial=True),
        fixed_base=True,
    ),
    KernelDefinition(
        "dynamics",
        "bias_torque",
        "h = C qd + g + friction",
        (_Q, _QD, _X, _G),
        (Array("h", (_N,)),),
        of_plant(partial(dynamics.inverse_dynamics, accelerating=False)),
    ),
    KernelDefinition(
        "dynamics",
        "forward_dynamics",
        "accelerations under torques tau; not 0 where M is not positive definite",
        (_Q, _QD, _TAU, _X, _G),
        (_QDD,),
        of_plant(forward.forward_dynamics),
    ),
    KernelDefinition(
        "dynamics",
        "energy",
        "kinetic energy T and potential energy U, U up to a constant",
        (_Q, _QD, _X_INERTIAL, _G),
        (Array("T_out", (1,)), Array("U_out", (1,))),
        of_plant(dynamics.energies, inertial=True),
        fixed_base=True,
    ),
    KernelDefinition(
        "kinematics",
        "frames",
        "homogeneous transforms 0T_j of all links, fixed ones included",
        (_Q,),
        (Array("T_out", (_LINKS, 4, 4)),),
        of_robot(placement.frames_tape),
    ),
    KernelDefinition(
        "kinematics",
        "jacobian",
        "Jacobian of the last frame that moves, in frame 0: rows of velocity, then of turning",
        (_Q,),
        (Array("J_out", (6, _N)),),
        of_robot(placement.jacobian_tape),
    ),
    KernelDefinition(
        "control",
        "slotine_li_regressor",
        "columns of M qddr + C(q, qd) qdr + g + friction(qd) = out X, C of Christoffel's symbols",
        (_Q, _QD, _QDR, _QDDR, _G),
        (Array("out", (_N, _LINEAR)),),
        of_robot(regressor.slotine_li_tape),
        fixed_base=True,
    ),
    KernelDefinition(
        "control",
        "slotine_li_torque",
        "M qddr + C(q, qd) qdr + g + friction(qd), C of Christoffel's symbols",
        (_Q, _QD, _QDR, _QDDR, _X, _G),
        (_TAU,),
        of_plant(passive.slotine_li_torque),
        fixed_base=True,
    ),
    KernelDefinition(
        "control",
        "generalized_momentum",
        "p = M qd and rate = C' qd - g: dp/dt = tau - friction + rate",
        (_Q, _QD, _X_INERTIAL, _G),
        (Array("p_out", (_N,)), Array("rate_out", (_N,))),
        of_plant(passive.generalized_momentum, inertial=True),
        fixed_base=True,
    ),
    KernelDefinition(
        "dynamics",
        "friction",
        "torque of the friction that joints and couplings declare; effects are not in it",
        (_QD, _X),
        (_TAU,),
        of_plant(dynamics.joint_friction),
    ),
    KernelDefinition(
        "dynamics",
        "effects",
        "torque of the declared effects; with friction and the rigid body it is inverse_dynamics",
        (_Q, _QD, _QDD, _X, _G),
        (_TAU,),
        of_plant(dynamics.effect_torques),
        exists=lambda s: bool(s.robot.effects),
        lacks="no effects",
    ),
    KernelDefinition(
        "derivatives",
        "inverse_dynamics_derivatives",
        "dtau/dq and dtau/dqd; dtau/dqdd is mass_matrix; the derivative of sign(qd) is 0",
        (_Q, _QD, _QDD, _X, _G),
        (Array("dq_out", (_N, _N)), Array("dqd_out", (_N, _N))),
        of_plant(derivatives.inverse_dynamics_derivatives),
    ),
    KernelDefinition(
        "derivatives",
        "forward_dynamics_derivatives",
        "dqdd/dq, dqdd/dqd and dqdd/dtau; the derivative of sign(qd) is 0",
        (_Q, _QD, _TAU, _X, _G),
        (Array("dq_out", (_N, _N)), Array("dqd_out", (_N, _N)), Array("dtau_out", (_N, _N))),
        of_plant(derivatives.forward_dynamics_derivatives),
    ),
    KernelDefinition(
        "mass matrix",
        "solve_mass_matrix",
        "x of M(q) x = b",
        (_Q, _B, _X_INERTIAL),
        (Array("x", (_N,)),),
        of_plant(forward.solve_mass_matrix, inertial=True),
    ),
    KernelDefinition(
        "mass matrix",
        "mass_matrix_factor",
        "M = L D L' with ones on the diagonal of L and zeros below it; for projections solve with "
        "L from its last row",
        (_Q, _X_INERTIAL),
        (Array("L_out", (_N, _N)), Array("D_out", (_N,))),
        of_plant(forward.mass_matrix_factor, inertial=True),
    ),
    KernelDefinition(
        "kinematics",
        "link_jacobian",
        "Jacobian, in frame 0, of a point in the frame of a link: velocity, then turning",
        (_Q, _LINK, _POINT),
        (Array("J", (6, _N)),),
        of_robot(placement.link_jacobian_tape),
    ),
    KernelDefinition(
        "kinematics",
        "link_drift",
        "dJ/dt qd of a point in the frame of a link: its acceleration without qdd, in frame 0",
        (_Q, _QD, _LINK, _POINT),
        (Array("a", (6,)),),
        of_robot(placement.link_drift_tape),
    ),
    KernelDefinition(
        "at run time",
        "base_parameters",
        "X from the standard parameters, in this order: {standard}",
        (_STANDARD,),
        (_X,),
        of_base(regrouping.base_parameters_tape),
        batch=False,
    ),
    KernelDefinition(
        "at run time",
        "add_body",
        "fix a body on a link, in X: its mass, the centre of mass in the frame of the link, and "
        "inertia XX XY XZ YY YZ ZZ about that; mass and inertia negative: take it off",
        (_X, _LINK, _MASS, _COM, _INERTIA),
        (_X,),
        of_base(regrouping.add_body_tape),
        batch=False,
    ),
    KernelDefinition(
        "with `--standard`",
        "standard_energy_regressor",
        "columns DE and DU of kinetic and of potential energy in every standard parameter",
        (_Q, _QD, _G),
        (
            Array("kinetic_out", (_STANDARD_INERTIAL,)),
            Array("potential_out", (_STANDARD_INERTIAL,)),
        ),
        of_robot(energy.separate_tape),
        standard=True,
        fixed_base=True,
    ),
    KernelDefinition(
        "with `--standard`",
        "standard_torque_regressor",
        "columns of torque in every standard parameter, friction included",
        (_Q, _QD, _QDD, _G),
        (Array("out", (_N, _ALL_STANDARD)),),
        of_robot(regressor.torque_tape),
        standard=True,
    ),
)
KERNELS = {d.name: d for d in DEFINITIONS}
#: Kernels that do not concern standard parameters.
ALL = tuple(d.name for d in DEFINITIONS if not d.standard)
#: Kernels that identification with the energy model needs.
ENERGY = ("energy_regressor", "friction_power")

"""Kernels for control and for changes at run time, and those over standard parameters."""

from __future__ import annotations

from collections.abc import Callable

from symgen.codegen.kernels import Kernel, Output, Subject
from symgen.symbolic import (
    derivatives,
    dynamics,
    energy,
    forward,
    passive,
    points,
    regressor,
    regrouping,
)

Recipe = Callable[[Subject], Kernel | None]


def _slotine_li_regressor(s: Subject) -> Kernel:
    return Kernel(
        "slotine_li_regressor",
        "columns of M qddr + C(q, qd) qdr + g + friction(qd) = out X, C of Christoffel's symbols",
        regressor.slotine_li_tape(s.robot).keep(s.rows),
        (Output("out", (s.robot.n, len(s.names)), s.names),),
    )


def _slotine_li_torque(s: Subject) -> Kernel:
    p = dynamics.plant(s.robot, s.base)
    torque = passive.slotine_li_torque(p)
    tape = p.close(("q", "qd", "qdr", "qddr"), [torque[j] for j in s.numbers])
    doc = "M qddr + C(q, qd) qdr + g + friction(qd), C of Christoffel's symbols"
    return Kernel("slotine_li_torque", doc, tape, (Output("tau", (s.robot.n,)),))


def _generalized_momentum(s: Subject) -> Kernel:
    p = dynamics.plant(s.robot, s.base)
    momentum, rate = passive.generalized_momentum(p)
    outputs = [momentum[j] for j in s.numbers] + [rate[j] for j in s.numbers]
    return Kernel(
        "generalized_momentum",
        "p = M qd and rate = C' qd - g: dp/dt = tau - friction + rate",
        p.close(("q", "qd"), outputs, inertial=True),
        (Output("p_out", (s.robot.n,)), Output("rate_out", (s.robot.n,))),
    )


def _friction(s: Subject) -> Kernel:
    p = dynamics.plant(s.robot, s.base)
    torque = dynamics.joint_friction(p)
    tape = p.close(("qd",), [torque[j] for j in s.numbers])
    doc = "torque of the friction that joints and couplings declare; effects are not in it"
    return Kernel("friction", doc, tape, (Output("tau", (s.robot.n,)),))


def _inverse_dynamics_derivatives(s: Subject) -> Kernel:
    p = dynamics.plant(s.robot, s.base)
    by_q, by_qd = derivatives.inverse_dynamics_derivatives(p)
    outputs = [*dynamics.dense(by_q, s.numbers), *dynamics.dense(by_qd, s.numbers)]
    return Kernel(
        "inverse_dynamics_derivatives",
        "dtau/dq and dtau/dqd; dtau/dqdd is mass_matrix; the derivative of sign(qd) is 0",
        p.close(("q", "qd", "qdd"), outputs),
        tuple(Output(name, (s.robot.n,) * 2) for name in ("dq_out", "dqd_out")),
    )


def _forward_dynamics_derivatives(s: Subject) -> Kernel:
    p = dynamics.plant(s.robot, s.base)
    *slopes, guards = derivatives.forward_dynamics_derivatives(p)
    outputs = [entry for rows in slopes for entry in dynamics.dense(rows, s.numbers)]
    return Kernel(
        "forward_dynamics_derivatives",
        "dqdd/dq, dqdd/dqd and dqdd/dtau; the derivative of sign(qd) is 0",
        p.close(("q", "qd", "tau"), [*outputs, *guards]),
        tuple(Output(name, (s.robot.n,) * 2) for name in ("dq_out", "dqd_out", "dtau_out")),
        len(guards),
    )


def _solve_mass_matrix(s: Subject) -> Kernel:
    p = dynamics.plant(s.robot, s.base)
    x, pivots = forward.solve_mass_matrix(p)
    tape = p.close(("q", "b"), [*x, *pivots], inertial=True)
    doc = "x of M(q) x = b"
    return Kernel("solve_mass_matrix", doc, tape, (Output("x", (s.robot.n,)),), len(pivots))


def _mass_matrix_factor(s: Subject) -> Kernel:
    p = dynamics.plant(s.robot, s.base)
    L, D = forward.mass_matrix_factor(p)
    n = s.robot.n
    return Kernel(
        "mass_matrix_factor",
        "M = L D L' with ones on the diagonal of L and zeros below it; for projections solve with "
        "L from its last row",
        p.close(("q",), [*dynamics.dense(L, s.numbers), *D, *D], inertial=True),
        (Output("L_out", (n, n)), Output("D_out", (n,))),
        n,
    )


def _link_jacobian(s: Subject) -> Kernel:
    return Kernel(
        "link_jacobian",
        "Jacobian, in frame 0, of a point in the frame of a link: velocity, then turning",
        points.link_jacobian_tape(s.robot),
        (Output("J", (6, s.robot.n)),),
    )


def _link_drift(s: Subject) -> Kernel:
    return Kernel(
        "link_drift",
        "dJ/dt qd of a point in the frame of a link: its acceleration without qdd, in frame 0",
        points.link_drift_tape(s.robot),
        (Output("a", (6,)),),
    )


def _standard_energy_regressor(s: Subject) -> Kernel:
    names = tuple(p.name for p in s.base.standard if p.inertial)
    return Kernel(
        "standard_energy_regressor",
        "columns DE and DU of kinetic and of potential energy in every standard parameter",
        energy.separate_tape(s.robot),
        tuple(Output(f"{name}_out", (len(names),), names) for name in ("kinetic", "potential")),
    )


def _standard_torque_regressor(s: Subject) -> Kernel:
    names = tuple(p.name for p in s.base.standard if not p.load)
    return Kernel(
        "standard_torque_regressor",
        "columns of torque in every standard parameter, friction included",
        regressor.torque_tape(s.robot),
        (Output("out", (s.robot.n, len(names)), names),),
    )


def _base_parameters(s: Subject) -> Kernel:
    names = ", ".join(p.name for p in s.base.standard)
    return Kernel(
        "base_parameters",
        f"X from the standard parameters, in this order: {names}",
        regrouping.base_parameters_tape(s.robot, s.base),
        (Output("X", (len(s.base.parameters),)),),
        batch=False,
    )


def _add_body(s: Subject) -> Kernel:
    return Kernel(
        "add_body",
        "fix a body on a link, in X: its mass, the centre of mass in the frame of the link, and "
        "inertia XX XY XZ YY YZ ZZ about that; mass and inertia negative: take it off",
        regrouping.add_body_tape(s.robot, s.base),
        (Output("X", (len(s.base.parameters),)),),
        batch=False,
    )


RECIPES: dict[str, Recipe] = {
    "slotine_li_regressor": _slotine_li_regressor,
    "slotine_li_torque": _slotine_li_torque,
    "generalized_momentum": _generalized_momentum,
    "friction": _friction,
    "inverse_dynamics_derivatives": _inverse_dynamics_derivatives,
    "forward_dynamics_derivatives": _forward_dynamics_derivatives,
    "solve_mass_matrix": _solve_mass_matrix,
    "mass_matrix_factor": _mass_matrix_factor,
    "link_jacobian": _link_jacobian,
    "link_drift": _link_drift,
    "base_parameters": _base_parameters,
    "add_body": _add_body,
    "standard_energy_regressor": _standard_energy_regressor,
    "standard_torque_regressor": _standard_torque_regressor,
}

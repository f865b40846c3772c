"""The kernels of a model: name, what it computes, and how its tape is derived.

One table; a kernel is added by one entry here or in `control_recipes`.
"""

from __future__ import annotations

from symgen.codegen import control_recipes
from symgen.codegen.control_recipes import Recipe
from symgen.codegen.kernels import Kernel, Output, Subject, rows
from symgen.symbolic import dynamics, forward, friction, placement, regressor
from symgen.symbolic.joined import joined


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
        friction.torque_tape(s.robot).keep(rows(s.robot.n, count, kept)),
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
        regressor.torque_tape(s.robot).keep(s.rows),
        (Output("out", (s.robot.n, len(s.names)), s.names),),
    )


def _momentum_regressor(s: Subject) -> Kernel:
    names, n = s.names[: s.base.inertial], s.robot.n
    count = sum(p.inertial for p in s.base.standard)
    first = rows(n, count, s.inertial)
    kept = first + [n * count + i for i in first]
    shape = (n, len(names))
    return Kernel(
        "momentum_regressor",
        "columns of p = dT/dqd and of dL/dq: dp/dt = tau - friction + dL/dq",
        regressor.momentum_tape(s.robot).keep(kept),
        (Output("p_out", shape, names), Output("dl_out", shape, names)),
    )


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
    qdd, pivots = forward.forward_dynamics(p)
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


def _all_terms(s: Subject) -> Kernel:
    parts = [
        recipe(s) for recipe in (_mass_matrix, _bias_torque, _gravity_torque, _jacobian, _frames)
    ]
    return Kernel(
        "all_terms",
        "mass_matrix, bias_torque, gravity_torque, jacobian and frames in one call, which turns "
        "each angle once",
        joined(s.robot, [k.tape for k in parts], ("q", "qd", "X")),
        tuple(output for k in parts for output in k.outputs),
    )


RECIPES: dict[str, Recipe] = {
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
    "all_terms": _all_terms,
    **control_recipes.RECIPES,
}
#: Kernels that a robot without friction or effects does not have.
FRICTION = ("friction_power", "friction_torque")
#: Kernels over standard parameters, which a package has on request.
STANDARD = ("standard_energy_regressor", "standard_torque_regressor")
ALL = tuple(name for name in RECIPES if name not in STANDARD)

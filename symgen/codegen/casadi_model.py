"""A tape as a CasADi Function: the same steps, run on SX symbols."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import sympy as sp

from symgen.codegen.kernels import LINK, Kernel
from symgen.codegen.model import Model
from symgen.errors import ParameterError
from symgen.symbolic.friction import torque_tape
from symgen.symbolic.tape import Numbers


def arithmetic(values: Mapping[sp.Symbol, sp.Expr]) -> Numbers:
    """Return the arithmetic of CasADi expressions for `Tape.run`."""
    import casadi

    names = ("sin", "cos", "fabs", "tanh", "exp", "log", "sign")
    functions = {name.replace("fabs", "abs"): getattr(casadi, name) for name in names}
    return Numbers(values, functions)


def casadi_function(model: Model, kernel: Kernel, *, flat: bool = False) -> Any:
    """Return a kernel as a casadi.Function of column vectors (q, qd, ...).

    Args:
        model: the derived model; its robot gives the named lengths their values.
        kernel: one of its kernels. Each output is a matrix of the kernel's shape, a vector a
            column; 4x4 frames stand one below the other. It is NaN where a guard is not positive: a
            mass matrix that is not positive definite, or a link that the robot does not have.
        flat: whether every output is a column (size, 1), row-major, which is what maps over
            samples want.
    """
    import casadi

    tape = kernel.tape
    inputs = {
        name: casadi.SX.sym(name, 1 if name == LINK else len(symbols))
        for name, symbols in tape.inputs
    }
    entries = {
        name: [vector == i for i in range(1, len(symbols) + 1)]
        if name == LINK
        else casadi.vertsplit(vector)
        for (name, symbols), vector in zip(tape.inputs, inputs.values(), strict=True)
    }
    values = tape.run(arithmetic(model.robot.values()), entries)
    out, at = [], 0
    for output in kernel.outputs:
        column = casadi.vertcat(*values[at : at + output.size]) if output.size else casadi.SX(0, 1)
        if not flat and len(output.shape) > 1 and output.size:
            width = output.shape[-1]
            column = casadi.reshape(column, width, output.size // width).T
        out.append(column)
        at += output.size
    known = [casadi.sum1(casadi.vertcat(*entries[LINK]))] if kernel.links else []
    for guard in (*values[at:], *known):
        out = [casadi.if_else(guard > 0, array, casadi.SX.nan(*array.shape)) for array in out]
    names = [output.name for output in kernel.outputs]
    return casadi.Function(
        function_name(model.robot.name, kernel.name),
        list(inputs.values()),
        out,
        list(inputs),
        [f"{name}_out" if name in inputs else name for name in names],
    )


@dataclass(frozen=True, eq=False)
class Dynamics:
    """Torques and accelerations by differentiating the energy model.

    Attributes:
        inverse: casadi.Function (q, qd, qdd, X) -> tau, each a column.
        forward: casadi.Function (q, qd, tau, X) -> qdd.
    """

    inverse: Any
    forward: Any


def dynamics(model: Model) -> Dynamics:
    """Derive inverse and forward dynamics from the energy kernel by automatic differentiation.

    With H = h(q, qd) . X the total energy and U = H(q, 0) its potential part, L = H - 2 U and

        tau = d/dt dL/dqd - dL/dq + friction,    M = d2L/dqd2      (Lagrange)

    Args:
        model: the derived model; X is in its base parameters.

    Raises:
        ParameterError: the robot has effects that hold the model's own torque.
    """
    import casadi

    robot, base = model.robot, model.base
    if robot.loaded:
        raise ParameterError("effects of kind model; accepted: a robot whose effects have columns")
    n, p, inertial = robot.n, len(base.parameters), model.inertial
    q, qd, qdd, tau, X = (
        casadi.SX.sym(name, size)
        for name, size in (("q", n), ("qd", n), ("qdd", n), ("tau", n), ("X", p))
    )
    kernel = model.kernel("energy_regressor")
    assert kernel is not None
    energy = casadi_function(model, kernel)
    total = casadi.dot(energy(q, qd), X[:inertial])
    lagrangian = total - 2 * casadi.dot(energy(q, casadi.SX.zeros(n)), X[:inertial])
    momentum = casadi.gradient(lagrangian, qd)
    rest = casadi.jtimes(momentum, q, qd) - casadi.gradient(lagrangian, q)
    if p > inertial:
        columns = torque_tape(robot).run(
            arithmetic(robot.values()), {"q": casadi.vertsplit(q), "qd": casadi.vertsplit(qd)}
        )
        count = len(base.standard) - sum(s.inertial for s in base.standard)
        first = len(base.standard) - count
        kept = [b.index - first for b in base.parameters if not b.inertial]
        for k, j in ((k, j) for k in range(len(kept)) for j in range(n)):
            rest[j] += columns[j * count + kept[k]] * X[inertial + k]
    mass = casadi.jacobian(momentum, qd)
    name = function_name(robot.name, "")
    return Dynamics(
        casadi.Function(f"{name}_inverse", [q, qd, qdd, X], [casadi.mtimes(mass, qdd) + rest]),
        casadi.Function(f"{name}_forward", [q, qd, tau, X], [casadi.solve(mass, tau - rest)]),
    )


def function_name(robot: str, kernel: str) -> str:
    """Return a name that CasADi accepts: no double and no trailing underscores."""
    return re.sub("_+", "_", f"{robot}_{kernel}").strip("_")


def serialized(function: Any) -> bytes:
    """Return the content of a .casadi file: what `casadi.Function.load` reads."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "function.casadi"
        function.save(str(path))
        return path.read_bytes()

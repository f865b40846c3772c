"""Convert a tape to a CasADi Function by running its steps on SX symbols."""

from __future__ import annotations

import re
from typing import Any

from symgen.codegen.kernel import LINK, Kernel
from symgen.codegen.model import Model
from symgen.symbolic.tape import Numbers, Values


def arithmetic(values: Values) -> Numbers:
    """Return the arithmetic of CasADi expressions for `Tape.run`."""
    import casadi

    names = ("sin", "cos", "fabs", "tanh", "exp", "log", "sign")
    functions = {name.replace("fabs", "abs"): getattr(casadi, name) for name in names}
    return Numbers(values, functions)


def casadi_function(model: Model, kernel: Kernel, *, flat: bool = False) -> Any:
    """Return a kernel as a casadi.Function of column vectors (q, qd, ...).

    Args:
        model: the derived model; its robot has the values of the named lengths.
        kernel: one of its kernels. Each output is a matrix with the shape of the kernel; vectors
            are columns, and 4x4 frames are stacked. An output is NaN if a guard is not positive:
            the mass matrix is not positive definite, or the robot has no such link.
        flat: whether every output is a column (size, 1) in row-major order, for maps over samples.
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
    out = []
    for output, part in kernel.split(values):
        column = casadi.vertcat(*part) if part else casadi.SX(0, 1)
        if not flat and len(output.shape) > 1 and output.size:
            width = output.shape[-1]
            column = casadi.reshape(column, width, output.size // width).T
        out.append(column)
    known = [casadi.sum1(casadi.vertcat(*entries[LINK]))] if kernel.links else []
    for guard in (*values[kernel.size :], *known):
        out = [casadi.if_else(guard > 0, array, casadi.SX.nan(*array.shape)) for array in out]
    names = [output.name for output in kernel.outputs]
    return casadi.Function(
        re.sub("_+", "_", f"{model.robot.name}_{kernel.name}").strip("_"),  # as CasADi accepts
        list(inputs.values()),
        out,
        list(inputs),
        [f"{name}_out" if name in inputs else name for name in names],
    )

"""A tape as a CasADi Function: the same steps, run on SX symbols."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import sympy as sp

from symgen.codegen.model import Kernel, Model
from symgen.symbolic.tape import Numbers


def arithmetic(values: Mapping[sp.Symbol, sp.Expr]) -> Numbers:
    """Return the arithmetic of CasADi expressions for `Tape.run`."""
    import casadi

    functions = {
        "sin": casadi.sin, "cos": casadi.cos, "abs": casadi.fabs, "tanh": casadi.tanh,
        "sign": casadi.sign,
    }
    return Numbers(values, functions)


def casadi_function(model: Model, kernel: Kernel) -> Any:
    """Return a kernel as a casadi.Function of column vectors (q, qd, ...).

    Args:
        model: the derived model; its robot gives the named lengths their values.
        kernel: one of its kernels; the output is a column of shape (prod(shape), 1), row-major.
    """
    import casadi

    tape = kernel.tape
    inputs = {name: casadi.SX.sym(name, len(symbols)) for name, symbols in tape.inputs}
    entries = {name: casadi.vertsplit(vector) for name, vector in inputs.items()}
    out = tape.run(arithmetic(model.robot.values()), entries)
    return casadi.Function(
        function_name(model.robot.name, kernel.name),
        list(inputs.values()),
        [casadi.vertcat(*out) if out else casadi.SX(0, 1)],
        list(inputs),
        ["out"],
    )


def function_name(robot: str, kernel: str) -> str:
    """Return a name that CasADi accepts: no double and no trailing underscores."""
    return re.sub("_+", "_", f"{robot}_{kernel}").strip("_")


def serialized(function: Any) -> bytes:
    """Return the content of a .casadi file: what `casadi.Function.load` reads."""
    text: str = function.serialize()
    return text.encode("ascii")


def deserialized(content: bytes) -> Any:
    """Return the Function in a .casadi file."""
    import casadi

    return casadi.Function.deserialize(content.decode("ascii"))

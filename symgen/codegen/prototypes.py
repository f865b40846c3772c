"""The arguments of a kernel as C declares them.

An array stands with its length (`const double X[62]`): compilers then warn of a short one.
A link is a number of the robot file, a mass a plain number; what a kernel changes in place is both
input and output. Batch forms take N samples of every array but those that all samples share.
"""

from __future__ import annotations

from dataclasses import dataclass

from symgen.codegen.kernels import LINK, SCALARS, SHARED, Kernel


@dataclass(frozen=True)
class Argument:
    """One argument of a kernel in C.

    Attributes:
        name: as the contract has it.
        single: its declaration for one sample.
        batch: its declaration for N samples.
        step: what the loop over N samples passes on for sample k.
    """

    name: str
    single: str
    batch: str
    step: str


def arguments(kernel: Kernel, real: str) -> tuple[Argument, ...]:
    """Return the arguments of a kernel, inputs first.

    Args:
        kernel: what is called.
        real: the floating type.
    """
    written = {o.name for o in kernel.outputs}
    out = []
    for name, symbols in kernel.tape.inputs:
        if name == LINK:
            out.append(_plain(name, "size_t"))
        elif name in SCALARS:
            out.append(_plain(name, real))
        else:
            kind = real if name in written else f"const {real}"
            out.append(_array(name, len(symbols), kind))
    known = {a.name for a in out}
    out += [_array(o.name, o.size, real) for o in kernel.outputs if o.name not in known]
    return tuple(out)


def _plain(name: str, kind: str) -> Argument:
    return Argument(name, f"{kind} {name}", f"{kind} {name}", name)


def _array(name: str, size: int, kind: str) -> Argument:
    step = name if name in SHARED else f"&{name}[k * {size}u]"
    return Argument(name, f"{kind} {name}[{size}]", f"{kind} *{name}", step)


def declarations(prefix: str, kernel: Kernel, real: str) -> tuple[str, ...]:
    """Return the prototypes of a kernel: for one sample, and for N where it has such a form."""
    listed, returns = arguments(kernel, real), "int" if kernel.fallible else "void"
    out = [f"{returns} {prefix}_{kernel.name}({', '.join(a.single for a in listed)});"]
    if kernel.batch:
        inputs = ", ".join(["size_t N", *(a.batch for a in listed)])
        out.append(f"{returns} {prefix}_{kernel.name}_batch({inputs});")
    return tuple(out)

"""JAX and PyTorch: NAME_jax.py and NAME_torch.py, a function of arrays for every kernel.

The code is straight-line, so that the libraries can transform and differentiate it.
"""

from __future__ import annotations

from typing import Any

from symgen.codegen.backends import Package
from symgen.codegen.kernel import LINK, Kernel
from symgen.codegen.python_printer import PythonPrinter, Vocabulary, docstring, wrapped

#: Names of the template in every function.
_LOCAL = ("leading", "batch", "zero", "guards", "cosines", "sines", "kept", "places", "tuple")


def files(package: Package, library: str, name: str, kept: str = "") -> dict[str, str]:
    """Return the module with a function for each kernel, over arrays with leading axes.

    Args:
        package: the package.
        library: the library of arrays: a file of templates/arrays, with its words.
        name: name of the library in the module.
        kept: the word of `Vocabulary`.
    """
    vocabulary = Vocabulary(
        library=name,
        absolute="abs",
        indexed=False,
        selected="(link == {number}) * (zero + 1.0)",
        inverse="1.0 / _positive({value})",
        logarithm="_log({value})",
        turned="_turned([{angles}])",
        kept=kept,
        taken=_LOCAL,
    )
    robot = package.model.robot
    kernels = [_described(k, PythonPrinter(k, robot, vocabulary)) for k in package.kernels]
    text = package.render("arrays/kernels.py", kernels=kernels, library=library, lib=name)
    return {f"{package.name}_{library}.py": text}


def _described(kernel: Kernel, printer: PythonPrinter) -> dict[str, Any]:
    """Return the data of a kernel for the template."""
    words = {name: [printer.word[s] for s in symbols] for name, symbols in kernel.tape.inputs}
    guards = list(map(printer.expression, printer.guards))
    if LINK in words:  # one of them is 1
        guards.append(" + ".join(words[LINK]))
    return {
        "name": kernel.name,
        "doc": docstring(kernel),
        "inputs": kernel.inputs,
        "sized": next(a.name for a in kernel.inputs if not a.plain),
        "entries": {name: wrapped(entries) for name, entries in words.items()},
        "guards": wrapped(guards),
        "outputs": [_distinct(output) for output in printer.outputs()],
        "lines": list(printer.lines()),
    }


def _distinct(output: dict[str, Any]) -> dict[str, Any]:
    """Return an output with each entry once, and the places of its entries among these.

    Regressors have many zeros, and a mass matrix has its entries twice.
    """
    entries = output["entries"]
    place = {entry: k for k, entry in enumerate(dict.fromkeys(entries))}
    repeated = len(place) < len(entries)
    places = [str(place[entry]) for entry in entries] if repeated else []
    return {**output, "entries": wrapped(list(place)), "places": wrapped(places)}

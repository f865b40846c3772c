"""Straight-line functions of arrays, for libraries that transform and differentiate them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from symgen.codegen.backends import Package
from symgen.codegen.kernel import LINK, Argument, Kernel
from symgen.codegen.python_printer import PythonPrinter, Vocabulary, docstring, wrapped
from symgen.robot.types import Robot

#: Names of the template in every function.
_LOCAL = (
    *("batch", "zero", "guards", "cosines", "sines", "kept", "places"),
    *("_stacked", "_valid", "_positive", "_turned", "_kept"),
)


@dataclass(frozen=True)
class Library:
    """A library of arrays, for templates/arrays/kernels.py.

    Attributes:
        title: its name in text.
        needs: what the module needs.
        file: its file in templates/arrays, with its import and the functions that differ.
        name: its name in the module.
        convert: its function that turns an argument into an array.
        unpack: text of the entries of {array} along its last axis.
        transforms: one sentence on what its transformations do with the functions.
        kept: the word of `Vocabulary`.
    """

    title: str
    needs: str
    file: str
    name: str
    convert: str
    unpack: str
    transforms: str
    kept: str = ""


def array_source(package: Package, library: Library, module: str) -> str:
    """Return a module with a function for each kernel, over arrays with leading axes.

    Args:
        package: the package.
        library: the library of arrays.
        module: name of the module.
    """
    robot = package.model.robot
    kernels = [_described(kernel, robot, library) for kernel in package.kernels]
    return package.render("arrays/kernels.py", module=module, kernels=kernels, library=library)


def _described(kernel: Kernel, robot: Robot, library: Library) -> dict[str, Any]:
    """Return the data of a kernel for the template."""
    vocabulary = Vocabulary(
        library=library.name,
        absolute="abs",
        indexed=False,
        selected="(link == {number}) * (zero + 1.0)",
        inverse="1.0 / _positive({value})",
        turned="_turned([{angles}])",
        kept=library.kept,
        taken=_LOCAL,
    )
    printer = PythonPrinter(kernel, robot, vocabulary)
    guards = [printer.expression(e) for e in printer.guards]
    words = {name: [printer.word[s] for s in symbols] for name, symbols in kernel.tape.inputs}
    if LINK in words:  # one of them is 1
        guards.append(" + ".join(words[LINK]))
    inputs = [
        {"name": a.name, "entries": [] if a.plain else wrapped(words[a.name])}
        for a in kernel.inputs
    ]
    return {
        "name": kernel.name,
        "doc": docstring(kernel),
        "returns": [o.name for o in kernel.outputs],
        "inputs": inputs,
        "leading": [_leading(a) for a in kernel.inputs],
        "first": f"{kernel.inputs[0].name}[..., 0]",
        "guards": wrapped(guards),
        "outputs": [_distinct(output) for output in printer.outputs()],
        "lines": list(printer.lines()),
    }


def _distinct(output: dict[str, Any]) -> dict[str, Any]:
    """Return an output with each entry once, and the places of its entries among these.

    Regressors have many zeros, and a mass matrix has its entries twice.
    """
    entries = output["entries"]
    distinct = list(dict.fromkeys(entries))
    place = {entry: k for k, entry in enumerate(distinct)}
    places = [str(place[entry]) for entry in entries]
    repeated = len(distinct) < len(entries)
    return {
        **output,
        "entries": wrapped(distinct),
        "places": wrapped(places) if repeated else [],
    }


def _leading(argument: Argument) -> str:
    """Return the text of the leading axes of an input."""
    return f"{argument.name}.shape" if argument.plain else f"{argument.name}.shape[:-1]"

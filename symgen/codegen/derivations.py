"""What was derived of a robot before, as text on disk: a second run of a robot derives nothing.

A text is found by the digest of the robot's file, of the sources that derive and print, and of
SymPy's version; it is read by the grammar below and never run. Where it cannot be kept or read, the
derivation is made again.

    expression = NAME (a symbol) | INTEGER | [INTEGER, INTEGER] | [OPERATION, expression, ...]
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import sympy as sp

from symgen.cache import keep_text, kept_text, private_folder
from symgen.codegen.kernels import Kernel, Output
from symgen.errors import BuildError
from symgen.files import templates
from symgen.robot.toml_text import robot_toml
from symgen.robot.types import Robot
from symgen.symbolic.base_parameters import BaseParameter, BaseParameters, Proof
from symgen.symbolic.parameters import Parameter
from symgen.symbolic.tape import Tape, real_symbol

Derived = TypeVar("Derived")
_symbol = cache(real_symbol)
_NUMBERS = {"Pi": sp.pi, "Exp1": sp.E}
_OPERATIONS: Mapping[str, Callable[..., sp.Expr]] = {
    f.__name__: f
    for f in (sp.Add, sp.Mul, sp.Pow, sp.sin, sp.cos, sp.tanh, sp.exp, sp.log, sp.sign, sp.Abs)
}


@dataclass(frozen=True)
class Derivations:
    """The kept derivations of a robot.

    Attributes:
        folder: in which they are kept; None where there is no such folder.
        key: digest of the robot, the sources and SymPy.
    """

    folder: Path | None
    key: str

    @classmethod
    def of(cls, robot: Robot) -> Derivations:
        """Return the derivations of a robot."""
        try:
            folder = private_folder()
        except BuildError:  # said where it matters: when a module is compiled
            folder = None
        digest = hashlib.sha256(f"{_code()}\n{robot_toml(robot)}".encode())
        return cls(folder, f"derived-{digest.hexdigest()[:32]}")

    def have(
        self,
        name: str,
        derive: Callable[[], Derived],
        write: Callable[[Derived], Any],
        read: Callable[[Any], Derived],
    ) -> Derived:
        """Return what was kept under a name, or derive it and keep it.

        Args:
            name: of the derivation.
            derive: it.
            write: it as JSON; a KeyError says that this cannot be.
            read: it from JSON.
        """
        if self.folder is None:
            return derive()
        text = kept_text(self.folder, f"{self.key}-{name}")
        if text is not None:
            return read(json.loads(text))
        found = derive()
        try:
            text = json.dumps(write(found))
        except KeyError:  # a function that the grammar lacks
            return found
        keep_text(self.folder, f"{self.key}-{name}", text)
        return found

    def sources(self, kernels: tuple[Kernel, ...], write: Callable[[], dict[str, bytes]]) -> Any:
        """Return the C sources of some kernels as they were kept, or write and keep them."""
        try:
            digest = hashlib.sha256(json.dumps([write_kernel(k) for k in kernels]).encode())
        except KeyError:  # a number or a function that the grammar lacks
            return write()
        return self.have(
            f"sources-{digest.hexdigest()[:32]}",
            write,
            lambda files: {name: content.decode() for name, content in files.items()},
            lambda files: {name: content.encode() for name, content in files.items()},
        )


@cache
def _code() -> str:
    """Return the digest of all that derives and prints."""
    digest = hashlib.sha256(sp.__version__.encode())
    package = Path(__file__).resolve().parents[1]
    folders = [*(package / name for name in ("robot", "symbolic", "codegen")), templates() / "c"]
    files = [package / "names.py", *(p for folder in folders for p in sorted(folder.rglob("*")))]
    for file in (p for p in files if p.suffix not in ("", ".pyc")):
        digest.update(file.name.encode() + b"\0" + file.read_bytes() + b"\0")
    return digest.hexdigest()


def write_kernel(kernel: Kernel | None) -> Any:
    """Return a kernel as JSON.

    Raises:
        KeyError: it holds a function that the grammar lacks.
    """
    if kernel is None:
        return None
    tape = kernel.tape
    return {
        "about": [kernel.name, kernel.doc, kernel.guards, kernel.batch],
        "outputs": [[o.name, o.shape, o.columns] for o in kernel.outputs],
        "inputs": [[name, [s.name for s in symbols]] for name, symbols in tape.inputs],
        "constants": [[s.name, _written(e)] for s, e in tape.constants],
        "steps": [[s.name, _written(e)] for s, e in tape.steps],
        "entries": [_written(e) for e in tape.outputs],
    }


def read_kernel(text: Any) -> Kernel | None:
    """Return the kernel that `write_kernel` wrote."""
    if text is None:
        return None
    tape = Tape(
        tuple((name, tuple(map(_symbol, symbols))) for name, symbols in text["inputs"]),
        tuple((_symbol(s), _read(e)) for s, e in text["constants"]),
        tuple((_symbol(s), _read(e)) for s, e in text["steps"]),
        tuple(map(_read, text["entries"])),
    )
    name, doc, guards, batch = text["about"]
    outputs = tuple(Output(o, tuple(shape), tuple(c)) for o, shape, c in text["outputs"])
    return Kernel(name, doc, tape, outputs, guards, batch)


def write_base(base: BaseParameters) -> Any:
    """Return base parameters with their proof as JSON."""
    return {
        "parameters": [
            [p.name, p.index, [[_written(c), n] for c, n in p.terms], p.unit, p.inertial]
            for p in base.parameters
        ],
        "standard": [list(vars(p).values()) for p in base.standard],
        "no_effect": base.no_effect,
        "proof": list(vars(base.proof).values()),
    }


def read_base(text: Any) -> BaseParameters:
    """Return the base parameters that `write_base` wrote."""
    parameters = tuple(
        BaseParameter(name, index, tuple((_read(c), n) for c, n in terms), unit, inertial)
        for name, index, terms, unit, inertial in text["parameters"]
    )
    standard = tuple(Parameter(*about) for about in text["standard"])
    rank, primes, seeds, *counts = text["proof"]
    proof = Proof(rank, tuple(primes), tuple(seeds), *counts)
    return BaseParameters(parameters, standard, tuple(text["no_effect"]), proof)


def _written(e: sp.Expr) -> Any:
    if e.is_Symbol:
        return e.name
    if e.is_Rational:
        return int(e) if e.is_Integer else [int(e.p), int(e.q)]
    name = type(e).__name__
    if name not in _NUMBERS and name not in _OPERATIONS:
        raise KeyError(name)
    return [name, *map(_written, e.args)]


def _read(text: Any) -> sp.Expr:
    if isinstance(text, str):
        return _symbol(text)
    if isinstance(text, int):
        return sp.Integer(text)
    name, *rest = text
    if isinstance(name, int):
        return sp.Rational(name, *rest)
    if name in _NUMBERS:
        return _NUMBERS[name]
    return _OPERATIONS[name](*map(_read, rest), evaluate=False)

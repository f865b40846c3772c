"""A disk cache of derivations: a second run of a robot derives nothing.

The key is the digest of the robot file, of the sources that derive and print, and of SymPy's
version. The grammar below reads a cached text; the text is never run. If the cache fails, symgen
derives again.

    value = TEXT | INTEGER | null | [NAME, value, ...]

where NAME is a key of `_MADE`: a symgen value with its fields, a tuple, a number, a symbol or an
operation of SymPy.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields, is_dataclass
from functools import cache, lru_cache, partial
from pathlib import Path
from typing import Any, TypeVar

import sympy as sp

from symgen.cache import keep_text, kept_text, private_folder
from symgen.codegen.kernels import Kernel, Output
from symgen.distributed import digest
from symgen.errors import BuildError
from symgen.files import templates
from symgen.robot.toml_text import robot_toml
from symgen.robot.types import Robot
from symgen.symbolic.base_parameters import BaseParameter, BaseParameters, Proof
from symgen.symbolic.parameters import Parameter
from symgen.symbolic.tape import Tape, real_symbol

Derived = TypeVar("Derived")
_VALUES = (BaseParameter, BaseParameters, Kernel, Output, Parameter, Proof, Tape)
_OPERATIONS = (sp.Add, sp.Mul, sp.Pow, sp.sin, sp.cos, sp.tanh, sp.exp, sp.log, sp.sign, sp.Abs)
#: NAME -> function that builds the value from its parts.
_MADE: Mapping[str, Callable[..., Any]] = {
    "tuple": lambda *entries: entries,
    "Symbol": cache(real_symbol),
    "Rational": sp.Rational,
    "Pi": lambda: sp.pi,
    "Exp1": lambda: sp.E,
    **{kind.__name__: kind for kind in _VALUES},
    **{f.__name__: partial(f, evaluate=False) for f in _OPERATIONS},
}


@dataclass(frozen=True)
class Derivations:
    """The cached derivations of a robot.

    Attributes:
        folder: its folder in the cache, by the digest of the robot, the sources and SymPy; or None.
    """

    folder: Path | None

    @classmethod
    def of(cls, robot: Robot) -> Derivations:
        """Return the derivations of a robot."""
        try:
            folder = private_folder()
        except BuildError:  # reported later, when a module is compiled
            return cls(None)
        return cls(folder / f"derived-{digest(_code(), robot_toml(robot))[:32]}")

    def have(self, name: str, derive: Callable[[], Derived]) -> Derived:
        """Return a cached derivation, or derive and cache it.

        Args:
            name: name of the derivation.
            derive: function that derives it.
        """
        if self.folder is None:
            return derive()
        text = kept_text(self.folder, f"derived-{name}")
        if text is not None:
            kept: Derived = read(json.loads(text))
            return kept
        found = derive()
        try:
            text = json.dumps(written(found))
        except KeyError:  # a number or a function that the grammar lacks
            return found
        keep_text(self.folder, f"derived-{name}", text)
        return found

    def sources(
        self, kernels: tuple[Kernel, ...], write: Callable[[], Mapping[str, bytes]]
    ) -> Mapping[str, bytes]:
        """Return the cached C sources of some kernels, or write and cache them."""
        try:
            text = json.dumps(written(kernels))
        except KeyError:  # a number or a function that the grammar lacks
            return write()
        return self._files(f"sources-{digest(text)[:32]}", write)

    def package(self, write: Callable[[], Mapping[str, bytes]]) -> Mapping[str, bytes]:
        """Return the cached files of the robot's package with all kernels, or write and cache."""
        return self._files("package", write)

    def _files(self, name: str, write: Callable[[], Mapping[str, bytes]]) -> Mapping[str, bytes]:
        files = self.have(name, lambda: tuple((k, x.decode("latin-1")) for k, x in write().items()))
        return {path: text.encode("latin-1") for path, text in files}


@cache
def _code() -> str:
    """Return the digest of all sources and templates that derive and print."""
    package = Path(__file__).resolve().parents[1]
    folders = [*(package / name for name in ("robot", "symbolic", "codegen")), templates()]
    files = [package / "names.py", *(p for folder in folders for p in sorted(folder.rglob("*")))]
    code = [file for file in files if file.suffix not in ("", ".pyc")]
    return digest(sp.__version__, *(f.name for f in code), *(f.read_bytes() for f in code))


def written(value: Any) -> Any:
    """Return a value as JSON.

    Raises:
        KeyError: the grammar lacks a number or a function of the value.
    """
    if value is None or isinstance(value, (str, int)):
        return value
    if isinstance(value, sp.Basic):
        return _expression(value)
    parts = [getattr(value, f.name) for f in fields(value)] if is_dataclass(value) else value
    return _named(type(value).__name__, parts)


@lru_cache(maxsize=100_000)  # kernels share most of their steps
def _expression(value: sp.Basic) -> list[Any]:
    if value.is_Symbol:
        return ["Symbol", value.name]
    if value.is_Rational:
        return ["Rational", int(value.p), int(value.q)]
    return _named(type(value).__name__, value.args)


def _named(name: str, parts: Iterable[Any]) -> list[Any]:
    if name not in _MADE:
        raise KeyError(name)
    return [name, *map(written, parts)]


def read(text: Any) -> Any:
    """Return the value of a text of `written`."""
    if not isinstance(text, list):
        return text
    name, *parts = text
    return _MADE[name](*map(read, parts))

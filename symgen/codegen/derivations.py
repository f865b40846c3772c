"""A disk cache of derivations: a second run with the same robot derives nothing.

The key is the digest of the mechanism in the robot file, of the sources that derive and print, and
of SymPy's version. Cached objects are pickled, in the private folder of `symgen.cache`,
which also contains the compiled modules. If the cache fails, symgen derives again. SymPy is only
imported to derive, or to load expressions.
"""

from __future__ import annotations

import io
import os
import pickle
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from symgen.cache import digest, name_in_cache, private_folder, unchanged
from symgen.errors import BuildError
from symgen.files import templates

if TYPE_CHECKING:
    import sympy as sp

    from symgen.robot.types import Robot

Derived = TypeVar("Derived")
_SUFFIX = ".pickle"


@dataclass(frozen=True)
class Derivations:
    """The cached derivations of a robot.

    Attributes:
        folder: the folder of the robot in the cache; None without one.
    """

    folder: Path | None

    @classmethod
    def of(cls, robot: Robot) -> Derivations:
        """Return the derivations of a robot."""
        import sympy as sp

        from symgen.robot.toml_text import robot_toml

        return cls.by(sp.__version__, robot_toml(robot.mechanism()))

    @classmethod
    def by(cls, *texts: str) -> Derivations:
        """Return what some texts determine, in any version of SymPy."""
        key = digest(_code(), *texts)[:32]
        try:
            folder = private_folder() / key
            folder.mkdir(mode=0o700, exist_ok=True)
        except (BuildError, OSError):  # reported later, when a module is compiled
            return cls(None)
        return cls(folder)

    def have(self, name: str, derive: Callable[[], Derived]) -> Derived:
        """Return a cached derivation, or derive and cache it.

        Args:
            name: name of the derivation.
            derive: function that derives it.
        """
        if self.folder is None:
            return derive()
        if path := unchanged(self.folder, name, _SUFFIX):
            with suppress(Exception):  # of another version of NumPy, for example
                kept: Derived = pickle.loads(path.read_bytes())
                return kept
            path.unlink(missing_ok=True)
        derived = derive()
        with suppress(OSError):
            content = _pickled(derived)
            fresh = self.folder / f"part-{os.getpid()}"  # of two threads, one writes in vain
            fresh.write_bytes(content)
            fresh.replace(self.folder / name_in_cache(name, content, _SUFFIX))
        return derived


@cache
def _code() -> str:
    """Return the digest of all sources and templates that derive and print."""
    package = Path(__file__).resolve().parents[1]
    folders = [*(package / name for name in ("robot", "symbolic", "codegen")), templates()]
    files = [package / "names.py", package / "files.py"]
    files += [path for folder in folders for path in sorted(folder.rglob("*"))]
    code = [file for file in files if file.suffix and file.parent.name != "__pycache__"]
    return digest(*(f.name for f in code), *(f.read_bytes() for f in code))


def _pickled(value: Any) -> bytes:
    file = io.BytesIO()
    _Pickler(file).dump(value)
    return file.getvalue()


class _Pickler(pickle.Pickler):
    """Pickles expressions without changes; SymPy would evaluate them again."""

    def reducer_override(self, value: Any) -> Any:
        import sympy as sp

        if isinstance(value, (sp.Add, sp.Mul, sp.Pow, sp.Function)):
            return _unevaluated, (value.func, value.args)
        return NotImplemented


def _unevaluated(kind: Callable[..., sp.Expr], args: tuple[sp.Expr, ...]) -> sp.Expr:
    return kind(*args, evaluate=False)

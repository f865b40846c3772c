"""Report on this machine: compiler, libraries, caches, and optional packages."""

from __future__ import annotations

import os
import platform
from dataclasses import dataclass
from importlib import metadata, util

from symgen.cache import cache_folder
from symgen.errors import SymgenError
from symgen.runtime.build import build_module, find_compiler, missing_compiler
from symgen.runtime.flags import kernel_flags

_NEEDED = ("sympy", "numpy", "scipy", "casadi", "cffi", "jinja2", "pydantic", "pyarrow")
#: Module, its use, and how to install it.
_OPTIONAL = (
    ("rosbags", "MCAP files and ROS 2 bags", "symgen[ros]"),
    ("mujoco", "MJCF files", "symgen[mjcf]"),
)
_DECLARED = "int probe(void);"
_PROBE = {
    "probe.h": f"{_DECLARED}\n".encode(),
    "probe.c": b'#include "probe.h"\nint probe(void) { return 1; }\n',
}


@dataclass(frozen=True)
class Finding:
    """One item of the report: whether it works, what was found, and what to do."""

    name: str
    well: bool
    found: str
    advice: str = ""


def examine() -> tuple[Finding, ...]:
    """Examine everything that symgen uses; an item is an error only if symgen needs it."""
    return (
        Finding("Python", True, f"{platform.python_version()}, {platform.machine()}"),
        *map(_library, _NEEDED),
        _compiler(),
        _cache(),
        *(_library(*entry) for entry in _OPTIONAL),
    )


def _library(name: str, use: str = "", source: str = "") -> Finding:
    """Find a library; it is optional if it has a stated use."""
    if util.find_spec(name) is None:
        found = f"not installed: {use}" if use else "is not installed"
        return Finding(
            name, bool(use), found, f"pip install '{source}'" if use else f"pip install {name}"
        )
    return Finding(name, True, _version(name) + (f": {use}" if use else ""))


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "of unknown version"


def _compiler() -> Finding:
    compiler = find_compiler()
    if compiler is None:
        return Finding("C compiler", True, "none: CasADi evaluates the models", missing_compiler())
    try:
        build_module(_PROBE, _DECLARED, compiler)
    except SymgenError as error:  # CasADi replaces it, but is slower
        return Finding(
            "C compiler",
            True,
            f"{compiler.version} fails: {error}",
            "the headers of Python (python3-dev) may be missing",
        )
    flags = " ".join(kernel_flags(compiler)) or "no flags of the processor"
    return Finding("C compiler", True, f"{compiler.version}, {flags}")


def _cache() -> Finding:
    folder = cache_folder()
    place = next((p for p in (folder, *folder.parents) if p.exists()), folder)
    if os.access(place, os.W_OK):
        return Finding("cache", True, str(folder))
    return Finding("cache", True, f"{folder} cannot be written", "set SYMGEN_CACHE to a folder")

"""Rust: a crate around the C of the package, without other crates and without the standard library.

Its build script compiles the C. Its functions take arrays with the lengths of the C prototypes.
"""

from __future__ import annotations

from typing import Any

from symgen.codegen.backends import Package
from symgen.codegen.kernel import Argument, Kernel

BUILDS_ON: tuple[str, ...] = ("c",)
_REALS = {"double": "f64", "float": "f32"}
#: X of every function has all parameters, so that one array suits all: C reads the first of them.
_SIZES = {"X": "PARAMETERS"}


def files(package: Package) -> dict[str, str]:
    """Return Cargo.toml, build.rs and src/lib.rs."""
    values = None if package.values is None else list(map(repr, package.values.X))
    library = package.render(
        "rust/lib.rs",
        real=_REALS[package.dtype],
        fields=package.joint_fields,
        parameters=package.model.base.names,
        values=values,
        kernels=[_described(kernel) for kernel in package.kernels],
        fallible=any(kernel.fallible for kernel in package.kernels),
    )
    cargo = package.render("rust/Cargo.toml", maintainer=package.maintainer, license=package.spdx)
    return {
        "Cargo.toml": cargo,
        "build.rs": package.render("rust/build.rs"),
        "src/lib.rs": library,
    }


def _described(kernel: Kernel) -> dict[str, Any]:
    """Return a kernel for the template: parameters in C and in Rust, and what Rust passes to C."""
    arguments = kernel.arguments
    return {
        "name": kernel.name,
        "doc": kernel.doc,
        "fallible": kernel.fallible,
        "declared": ", ".join(f"{a.name}: {_in_c(a)}" for a in arguments),
        "taken": ", ".join(f"{a.name}: {_in_rust(a)}" for a in arguments),
        "passed": ", ".join(_passed(a) for a in arguments),
    }


def _in_c(a: Argument) -> str:
    """Return the type of an argument in the C declaration."""
    if a.plain:
        return _in_rust(a)
    return "*mut Real" if a.written else "*const Real"


def _in_rust(a: Argument) -> str:
    """Return the type of an argument of the safe function."""
    if a.plain:
        return "usize" if a.link else "Real"
    array = f"[Real; {_SIZES.get(a.name, a.size)}]"
    return f"&mut {array}" if a.written else f"&{array}"


def _passed(a: Argument) -> str:
    """Return what the safe function passes to C."""
    if a.plain:
        return a.name
    return f"{a.name}.as_mut_ptr()" if a.written else f"{a.name}.as_ptr()"

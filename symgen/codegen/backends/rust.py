"""Rust: a crate around the C of the package, without other crates and without the standard library.

Its build script compiles the C. Its functions take arrays with the lengths of the C prototypes. X
alone always has all parameters, so that one array suits all functions: C reads the first of them.
"""

from __future__ import annotations

from symgen.codegen.backends import Package


def files(package: Package) -> dict[str, str]:
    """Return Cargo.toml, build.rs and src/lib.rs."""
    library = package.render(
        "rust/lib.rs",
        fields=package.joint_fields,
        parameters=package.model.base.names,
        values=package.values,
        kernels=package.kernels,
    )
    cargo = package.render("rust/Cargo.toml", maintainer=package.maintainer, license=package.spdx)
    build = package.render("rust/build.rs")
    return {"Cargo.toml": cargo, "build.rs": build, "src/lib.rs": library}

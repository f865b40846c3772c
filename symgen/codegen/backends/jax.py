"""JAX: NAME_jax.py, a function of arrays for every kernel."""

from __future__ import annotations

from symgen.codegen.array_backend import array_files
from symgen.codegen.backends import Package

BUILDS_ON: tuple[str, ...] = ()


def files(package: Package) -> dict[str, str]:
    """Return NAME_jax.py."""
    return array_files(package, "jax", "jnp", kept="_kept(kept)")

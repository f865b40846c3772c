"""JAX: NAME_jax.py, a function of arrays for every kernel."""

from __future__ import annotations

from symgen.codegen.array_backend import Library, array_source
from symgen.codegen.backends import Package

BUILDS_ON: tuple[str, ...] = ()
_LIBRARY = Library(
    title="JAX",
    needs="jax, and nothing else",
    file="jax.py",
    name="jnp",
    convert="asarray",
    unpack="jnp.unstack({array}, axis=-1)",
    kept="_kept(kept)",
    transforms="jit, vmap and grad apply to the functions, also by X.",
)


def files(package: Package) -> dict[str, str]:
    """Return NAME_jax.py."""
    module = f"{package.name}_jax"
    return {f"{module}.py": array_source(package, _LIBRARY, module)}

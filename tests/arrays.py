"""Call the functions of NAME_jax.py or NAME_torch.py, in a process without other tests.

    python tests/arrays.py NAME_jax.py IN.npz OUT.npz

IN.npz has "KERNEL/INPUT" for each input. OUT.npz gets "KERNEL/values/K" for output K from inputs
with leading axes; for kernels in SLOPES also "KERNEL/mapped/K" by vmap (and jit), and
"KERNEL/slopes/INPUT" of the output.
"""

from __future__ import annotations

import inspect
import sys
import warnings
from collections.abc import Iterator
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

import numpy as np

warnings.simplefilter("error")
SLOPES = ("inverse_dynamics", "forward_dynamics")


def results(module: Any, inputs: dict[str, dict[str, Any]]) -> Iterator[tuple[str, Any]]:
    """Yield name and array of each result."""
    vmap, jit, jacobian, array = _library(module)
    for kernel, named in inputs.items():
        function = getattr(module, kernel)
        names = list(inspect.signature(function).parameters)
        arguments = [array(named[name]) for name in names]
        axes = tuple(0 if named[name].ndim == 2 else None for name in names)
        yield from _outputs(f"{kernel}/values", function(*arguments))
        if kernel in SLOPES:
            mapped = jit(vmap(function, axes))
            yield from _outputs(f"{kernel}/mapped", mapped(*arguments))
            if isinstance(mapped(*arguments), tuple):
                continue
            slope = jacobian(function, tuple(range(len(names))))
            slopes = jit(vmap(slope, axes))(*arguments)
            yield from ((f"{kernel}/slopes/{n}", s) for n, s in zip(names, slopes, strict=True))


def _outputs(name: str, found: Any) -> Iterator[tuple[str, Any]]:
    outputs = found if isinstance(found, tuple) else (found,)
    yield from ((f"{name}/{k}", output) for k, output in enumerate(outputs))


def _library(module: Any) -> tuple[Any, ...]:
    """Return vmap, jit, jacobian and array of the library of a module."""
    if "torch" in vars(module):
        from torch import as_tensor
        from torch.func import jacrev, vmap

        return vmap, lambda function: function, jacrev, as_tensor
    import jax

    jax.config.update("jax_enable_x64", True)
    return jax.vmap, jax.jit, jax.jacrev, jax.numpy.asarray


def main() -> None:
    """Read the inputs, call every function, and write the results."""
    source, read, write = map(Path, sys.argv[1:])
    spec = spec_from_file_location(source.stem, source)
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    inputs: dict[str, dict[str, Any]] = {}
    with np.load(read) as arrays:
        for key in arrays:
            kernel, name = key.split("/")
            inputs.setdefault(kernel, {})[name] = arrays[key]
    np.savez(write, **{name: np.asarray(found) for name, found in results(module, inputs)})


if __name__ == "__main__":
    main()

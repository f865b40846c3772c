"""The kernels as methods. The stub of this module declares them; `tests/forms.py` writes it."""

from __future__ import annotations

from symgen.codegen.kernels import KERNELS


class KernelMethods:
    """Every kernel as a method, `evaluator.mass_matrix(q, X)`."""


def _method(name: str, doc: str) -> property:
    return property(lambda evaluator: evaluator[name], doc=doc)


for _definition in KERNELS.values():
    setattr(KernelMethods, _definition.name, _method(_definition.name, _definition.documented))

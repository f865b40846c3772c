"""The stub of the methods of an evaluator, which follows from the list of kernels.

`python tests/forms.py` writes it; tests/unit/test_kernel_methods.py compares.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from pathlib import Path

from symgen.codegen.definition import GRAVITY
from symgen.codegen.kernels import DEFINITIONS

PROJECT = Path(__file__).parents[1]
STUB = PROJECT / "symgen/runtime/kernel_methods.pyi"
INDENT, WIDTH = 8 * " ", 88
HEAD = '''"""The kernels as methods of an evaluator; `python tests/forms.py` writes this file."""

from numpy.typing import ArrayLike

from symgen.data.raw import FloatArray

class KernelMethods:
    """Every kernel as a method, `evaluator.mass_matrix(q, X)`."""
'''


def stub() -> str:
    """Return the stub of the methods."""
    return HEAD + "".join(methods())


def methods() -> Iterator[str]:
    """Yield the declaration of each method."""
    for d in DEFINITIONS:
        plain = [a.name for a in d.inputs if a.name != GRAVITY]
        arguments = ["self", *(f"{name}: ArrayLike" for name in plain)]
        if len(plain) < max(len(d.inputs), len(d.floating.inputs)):
            arguments += ["*base: ArrayLike", "**named: ArrayLike"]
        result = "FloatArray" if len(d.outputs) == 1 else "tuple[FloatArray, ...]"
        line = f"    def {d.name}({', '.join(arguments)}) -> {result}:"
        if len(line) > 100:
            rows = "".join(f"        {a},\n" for a in arguments)
            line = f"    def {d.name}(\n{rows}    ) -> {result}:"
        wrapped = [textwrap.fill(part, WIDTH) for part in d.documented.splitlines()]
        text = textwrap.indent("\n".join(wrapped), INDENT).strip()
        yield f'\n{line}\n{INDENT}"""{text}\n{INDENT}"""\n'


if __name__ == "__main__":
    STUB.write_text(stub(), "utf-8")

"""How far every kernel of random robots is from Pinocchio, and its C from values of 50 digits.

    python tests/studies/kernel_study.py [ROBOTS]

prints the largest error of each kernel over its largest value: NumPy and CasADi against Pinocchio
(over 1 + the largest value), C and C in float by NAME_check.c, which holds values of 50 digits.
Robots are those of test_kernels.py: chains and trees of turning, sliding and fixed joints, joints
that follow others, gravity as an input, articulated bodies. Coriolis, drift and momentum are
compared with differences, which are right to 1e-7.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections import defaultdict
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
from identities.test_kernels import Case, called

import symgen

KINDS = ("chain", "tree", "follows", "input", "many")
COLUMNS = ("numpy", "casadi", "double", "float")


def against_pinocchio(c: Case, backend: str) -> Iterator[tuple[str, float]]:
    """Yield each kernel with its largest error over 1 + its largest value."""
    loaded = None if backend == "numpy" else symgen.load(c.model, backend=backend)
    for name, found, wanted in c.compared(partial(called, c.model, loaded)):
        largest = 0.0
        for a, b in zip(found, wanted, strict=True):
            error = np.abs(a.reshape(b.shape) - b).max(initial=0.0)
            largest = max(largest, float(error / (1 + np.abs(b).max(initial=0.0))))
        yield name, largest


def against_digits(c: Case, dtype: str) -> Iterator[tuple[str, float]]:
    """Compile a package and its check; yield what that prints."""
    with tempfile.TemporaryDirectory() as folder:
        symgen.write_package(symgen.generate(c.model, target="c", dtype=dtype), folder)
        sources = sorted(map(str, Path(folder).rglob("*.c")))
        program = str(Path(folder) / "checked")
        subprocess.run(["cc", "-O1", *sources, "-lm", "-o", program], check=True)
        printed = subprocess.run([program], check=False, capture_output=True, text=True).stdout
    for line in printed.splitlines():
        name, _, error = line.partition(" ")
        if name in {kernel.name for kernel in c.model.kernels}:
            yield name, float(error)


def main(robots: int) -> None:
    """Print the table."""
    worst: dict[str, dict[str, float]] = defaultdict(dict)
    for k in range(robots):
        c = Case(KINDS[k % len(KINDS)], 3000 + k)
        for column in COLUMNS:
            by_digits = column in ("double", "float")
            found = against_digits(c, column) if by_digits else against_pinocchio(c, column)
            for name, error in found:
                worst[name][column] = max(error, worst[name].get(column, 0.0))
    print("| kernel |", " | ".join(COLUMNS), "|")
    print("|---|" + "---|" * len(COLUMNS))
    for name, row in worst.items():
        print(f"| {name} |", " | ".join(f"{row.get(x, np.nan):.1e}" for x in COLUMNS), "|")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 60)

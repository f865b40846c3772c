"""Instructions and bytes of every kernel on a Cortex-M7; writes docs/worst_case.md.

python tests/benchmarks/bench_instructions.py
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from cortex_m7 import M7, instructions, missing, sizes
from packages import run, write
from support import PROJECT

ROBOTS = ("planar2r", "puma560", "panda")
HEAD = """# Worst case on a Cortex-M7

Instructions that a call executes, callees and libm included, and bytes of code and constants of
its source, batch form included. `python tests/benchmarks/bench_instructions.py` writes this table:
{compiler}, `-O2 -mcpu=cortex-m7 -mfpu=fpv5-d16`,
executed one by one by QEMU (board MPS2 AN500). Each number is the largest of four points, with
angles up to 100 rad. In double all four are equal, and tests hold that, but for kernels with the
tanh of smooth friction or functions in effects, which are libm's. In float the sine and cosine of
an angle are newlib's: together they take 38 instructions more beyond pi/4 than below, and many more
beyond 200 rad. Instructions are no cycles: caches, wait states and the two pipelines of the
processor stand between. The stack of every function is what `symgen check` prints.

| robot | kernel | double: instructions | bytes | float: instructions | bytes |
|---|---|---|---|---|---|
"""


def measured(name: str, dtype: str) -> dict[str, tuple[int, int]]:
    """Return instructions and bytes of every kernel of a robot."""
    with tempfile.TemporaryDirectory() as folder:
        package = write(name, dtype, Path(folder) / name, "all")
        work = Path(folder) / "work"
        work.mkdir()
        size = sizes(package, work)
        return {k: (max(v), size[k]) for k, v in instructions(package, work).items()}


def main() -> None:
    """Print the table and write it."""
    if missing():
        sys.exit(f"{missing()} is not on this machine")
    compiler = run([M7[0], "--version"], PROJECT).splitlines()[0]
    lines = [HEAD.format(compiler=compiler)]
    for name in ROBOTS:
        double, single = measured(name, "double"), measured(name, "float")
        for kernel in double:
            numbers = " | ".join(map(str, double[kernel] + single[kernel]))
            lines.append(f"| {name} | {kernel} | {numbers} |\n")
    (PROJECT / "docs").mkdir(exist_ok=True)
    (PROJECT / "docs" / "worst_case.md").write_text("".join(lines), encoding="utf-8")
    print("".join(lines))


if __name__ == "__main__":
    main()

"""Instructions and bytes of every kernel on a Cortex-M7, in double and float.

    python tests/benchmarks/bench_instructions.py [ROBOT...]

Counts robots of the library, by default those of generated/, and keeps the figures in
symgen/codegen/worst_case.toml. The READMEs of packages take their tables from that file, so
generate generated/ again. docs/worst_case.md shows three of the robots. Run it after every change
of emitted code; figures of robots that are not named stay as they are.
"""

from __future__ import annotations

import sys
import tempfile
import tomllib
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from cortex_m7 import M7, instructions, missing, sizes
from packages import run, write
from support import PROJECT

import symgen
from symgen.codegen.package import robot_key as key

ROBOTS = ("planar2r", "puma560", "panda", "rx90", "twin")
SHOWN = ("planar2r", "puma560", "panda")  # on the page: 2, 6 and 7 joints
FIGURES = PROJECT / "symgen" / "codegen" / "worst_case.toml"
HEAD = """# Worst case on a Cortex-M7

The largest number of instructions of one call of each kernel, and the bytes of its code. Use the
table to choose a processor and a sampling rate. Instructions are not cycles: caches, wait states
and the two pipelines of the processor change the time of a call. Measure the time on your board.

- **Instructions** include called functions and libm. A number is the largest of four points, with
  angles up to 100 rad.
- **Bytes** are code and constants of the source file. Batches are in other files.
- **Stack**: `symgen check` prints it for every function.
- **Double**: all four points give the same number, except for smooth friction (tanh) and for
  effects that call functions of libm. Tests check this.
- **Float**: the sine and cosine of an angle come from newlib. Together they take 38 more
  instructions beyond pi/4, and many more beyond 200 rad.

`python tests/benchmarks/bench_instructions.py` writes this page. The compiler is
{compiler}, with `-O2 -mcpu=cortex-m7 -mfpu=fpv5-d16`.
QEMU (board MPS2 AN500) executes and counts the instructions. The README of each generated package
has the table of its own robot, if the robot was counted.

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
    """Count, keep the figures and print the table."""
    if missing():
        sys.exit(f"{missing()} is not on this machine")
    compiler = run([M7[0], "--version"], PROJECT).splitlines()[0]
    known = tomllib.loads(FIGURES.read_text())["robots"]
    for name in sys.argv[1:] or ROBOTS:
        double, single = measured(name, "double"), measured(name, "float")
        counts = {k: [*double[k], *single[k]] for k in double}
        known[key(symgen.read_robot(name))] = counts
    figures = [f'compiler = "{compiler}"\n']
    for digest, counts in known.items():
        rows = [f"{kernel} = {row}\n" for kernel, row in counts.items()]
        figures += [f"\n[robots.{digest}]\n", *rows]
    FIGURES.write_text("".join(figures))
    lines = [HEAD.format(compiler=compiler)]
    for name in SHOWN:
        for kernel, row in known.get(key(symgen.read_robot(name)), {}).items():
            lines.append(f"| {name} | {kernel} | {' | '.join(map(str, row))} |\n")
    (PROJECT / "docs" / "worst_case.md").write_text("".join(lines), encoding="utf-8")
    print("".join(lines))


if __name__ == "__main__":
    main()

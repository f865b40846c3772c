"""What the tests of generated C packages share: robots, strict flags, commands."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import sympy as sp

import symgen
from symgen.codegen.kernel import Kernel, Output
from symgen.symbolic.tape import TapeBuilder

STRICT = [
    "-std=c99",
    "-Wall",
    "-Wextra",
    "-Wpedantic",
    "-Wconversion",
    "-Wshadow",
    "-Wdouble-promotion",
    "-Wstrict-prototypes",
    "-Werror",
]
STRICT_CXX = ["-x", "c++", "-std=c++11"]
STRICT_CXX += [flag for flag in STRICT if flag not in ("-std=c99", "-Wstrict-prototypes")]

# One of everything that the format has: tree, prismatic and fixed joints, smooth and sharp Coulomb
# friction, an offset, a coupled drive, a payload, named lengths.
RICH = """
[robot]
name = "rich"
gravity = [1.5, 0.0, -9.81]
[geometry]
L1 = 0.4
tilt = 0.3
[[joint]]
friction = ["coulomb", "viscous", "offset"]
[[joint]]
alpha = "pi/2 + tilt"
d = "L1"
coulomb_width = 0.05
[[joint]]
sigma = 1
alpha = "-pi/2"
r = "L1/3"
[[joint]]
sigma = 2
antecedent = 1
gamma = 0.7
d = "sqrt(2)*L1"
[[joint]]
theta = "pi/3"
[[coupling]]
joints = [1, 2]
ratio = "-L1"
[payload]
joint = 5
"""


#: The same, with gravity an input.
LEANING = RICH.replace('"rich"', '"leaning"').replace("[1.5, 0.0, -9.81]", '"input"')


@cache
def _tree(name: str, dtype: str, kernels: tuple[str, ...] | str | None) -> symgen.SourceTree:
    own = {"rich": RICH, "leaning": LEANING}.get(name)
    robot = symgen.read_robot(name) if own is None else symgen.parse_robot(own)
    model = symgen.derive(robot) if kernels is None else symgen.derive(robot, kernels)
    return symgen.generate(model, target="c", dtype=dtype, prefix=name)


def with_probe(model: symgen.Model) -> symgen.Model:
    """Add a kernel with a link, a plain number and an X that it changes: no robot's, but C's.

    out = [[q1 mass, q2 mass, link], [0, 1, link = 2]]; X becomes mass X.
    """
    n, p = model.robot.n, len(model.base.parameters)
    q, X = (sp.symbols(f"{name}1:{k + 1}", real=True) for name, k in (("a", n), ("b", p)))
    links = sp.symbols(f"l1:{len(model.robot.joints) + 1}", real=True)
    mass = sp.Symbol("m", real=True)
    tape = TapeBuilder({"a", "b", "m"})
    number = tape.name("number", sum(((i + 1) * s for i, s in enumerate(links)), sp.S.Zero))
    out = [tape.name("first", q[0] * mass), tape.name("second", q[1] * mass), number]
    out += [sp.S.Zero, sp.S.One, links[1]]
    out += [tape.name(f"x{i}", mass * x) for i, x in enumerate(X)]
    inputs = [("q", q), ("link", links), ("mass", (mass,)), ("X", X)]
    outputs = (Output("out", (2, 3)), Output("X", (p,)))
    probe = Kernel("probe", "for tests", tape.tape(inputs, out), outputs, batch=False)
    return replace(model, kernels=(*model.kernels, probe))


def write(
    name: str, dtype: str, folder: Path, kernels: tuple[str, ...] | str | None = None
) -> Path:
    """Generate a package of C into a folder: of the energy model unless kernels are named."""
    symgen.write_package(_tree(name, dtype, kernels), folder)
    return folder


def run(command: Sequence[str | Path], cwd: Path) -> str:
    """Run a command that must succeed; its output is the message where it does not."""
    done = subprocess.run([str(c) for c in command], cwd=cwd, capture_output=True, text=True)
    assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"
    return done.stdout


def c_files(package: Path, check: bool = False) -> list[Path]:
    """The package's .c files, without its check program unless asked for."""
    programs = sorted(package.glob("check/*.c")) if check else []
    return [*sorted(package.glob("*.c")), *programs]


@cache
def objects(package: Path) -> tuple[Path, ...]:
    """Compile a package that many programs are linked with, once; strictly, beside its folder."""
    folder = package.with_name(f"{package.name}-objects")
    if not folder.is_dir():
        own = Path(tempfile.mkdtemp(dir=package.parent))
        run(["cc", *STRICT, "-O2", "-c", *c_files(package)], own)
        with suppress(OSError):  # another worker was first
            own.rename(folder)
    return tuple(sorted(folder.glob("*.o")))


def casadi_functions(package: Path, name: str) -> dict[str, Any]:
    """The functions of NAME_casadi.py: kernel -> casadi.Function."""
    content: dict[str, Any] = {"__name__": name}
    exec((package / f"{name}_casadi.py").read_text(), content)
    return {kernel: build() for kernel, build in content["FUNCTIONS"].items()}

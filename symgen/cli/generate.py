"""The command `generate`: the model of a robot as a package.

A package is kept in the cache, so that a second run with the same robot only writes it.
"""

from __future__ import annotations

import shlex
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import click

from symgen.cli.options import ROBOT, options_of, split_list
from symgen.cli.progress import meter, say_progress
from symgen.report.terminal import say, table

_BUILD = "cmake -S {folder} -B {folder}-build && cmake --build {folder}-build"
#: The command that uses the files of a target, with the folder and the name of the package.
NEXT = {
    "c": _BUILD,
    "casadi": "python {folder}/{name}_casadi.py --save {folder}",
    "mex": 'octave --eval "cd {folder}/mex; {name}_build"',
    "all": _BUILD,
    "ros2": "colcon build --base-paths {folder}",
    "firmware": "pio pkg pack {folder}",
    "rust": "cargo build --manifest-path {folder}/Cargo.toml",
    "simulink": 'matlab -batch "cd {folder}; {name}_simulink"',
    "jax": 'PYTHONPATH={folder} python -c "import {name}_jax as model; help(model)"',
    "torch": 'PYTHONPATH={folder} python -c "import {name}_torch as model; help(model)"',
    "cuda": "nvcc -O3 -arch=native -c {folder}/{name}.cu -o {name}.o",
}
#: Approximate share of the time for derivation; proof and writing take the rest.
_DERIVING = 0.6


@click.command()
@ROBOT
@options_of("generate")
def generate(
    robot: str,
    into: Path | None,
    dtype: str,
    kernels: str | None,
    prefix: str | None,
    parameters: Path | None,
    standard: bool,
    exact: bool,
    check: Path | None,
    target: str,
    **options: Any,
) -> None:
    """Derive the model of ROBOT and write it as a package of C, CasADi and MEX; jax, torch and cuda
    are targets by name.

    Other targets are written only by name, with the C that they need. ROBOT is a robot.toml, a
    URDF, MJCF or .par file, a generated package, or the name of a built-in robot. With --check, the
    exit code is 0 where the package is equal, 1 where it is not.
    """
    import symgen
    from symgen.codegen.derivations import Derivations
    from symgen.files import RECORD, check_replaceable, write_folder
    from symgen.robot.identifiers import default_prefix
    from symgen.robot.imported import FORMATS, robot_text

    source = None
    content, path = robot_text(robot)
    if path.suffix.lower() in FORMATS:  # it can include other files
        source = symgen.read_robot(robot)
        content = symgen.robot_toml(source)
    options |= {"target": target}
    request = content, dtype, kernels, prefix, standard, exact, options
    kept = Derivations.by(repr(request)) if parameters is None else Derivations(None)

    @cache  # once: before the derivation, or for a package from the cache
    def begin(name: str) -> Path:
        folder = into or Path("generated") / (prefix or default_prefix(name, dtype))
        if check is None:
            check_replaceable(folder, "manifest.json")
        say_progress(f"deriving {name}")
        return folder

    def derived() -> tuple[Any, ...]:
        from symgen.codegen.kernels import KERNELS, expanded
        from symgen.codegen.package import summary

        robot = source or symgen.parse_robot(content, str(path))
        begin(robot.name)
        asked = split_list(kernels) or ("all",)
        about = [name for name, d in KERNELS.items() if standard and d.standard]
        chosen = expanded([*asked, *about])
        with meter("deriving") as advance:
            model = symgen.derive(
                replace(robot, exact=exact or robot.exact),
                chosen,
                meter=lambda part: advance(_DERIVING * part),
            )
            # A set means those of its kernels that the robot has, but a load needs its momentum.
            required = {*asked, "load_momentum"}
            named = tuple(k for k in chosen if k in required or model.kernel(k) is not None)
            values = None
            if parameters is not None:
                from symgen.identification.parameters import read_values

                values = read_values(parameters, model)
            tree = symgen.generate(
                model, dtype=dtype, kernels=named, prefix=prefix, values=values, **options
            )
        return robot.name, tree.files, model.base.table, summary(model)

    name, files, rows, lines = kept.have("package", derived)
    folder = begin(name)
    if check is not None:
        paths = [path for path in check.rglob("*") if path.is_file()]
        there = {path.relative_to(check).as_posix(): path.read_bytes() for path in paths}
        different = {name for name, _ in files.items() ^ there.items()} - {RECORD}
        for name in sorted(different):
            say(name)
        sys.exit(bool(different))
    write_folder(folder, files, "manifest.json")
    table(("base parameter", "formula", "unit"), rows)
    for line in lines:
        click.echo(line)
    say(f"written: {folder} ({len(files)} files)")
    package = prefix or default_prefix(name, dtype)
    say(f"next: {NEXT[target].format(folder=shlex.quote(str(folder)), name=package)}")

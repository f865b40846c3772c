"""Large trees beside Pinocchio's C++, in cache and out of it, with the same flags.

    python tests/benchmarks/bench_trees.py [--robots chain7,chain15,chain30,chain50,humanoid] [--kernels LIST]

`trees.c` says how both sides are timed.
"""
from __future__ import annotations

import argparse
import ctypes
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from bench_growth import chain
from packages import c_files
from peers import begin_cxx, pinocchio_model, pinocchio_objects, pointer

import symgen
from symgen.codegen.kernels import regrouped
from symgen.robot.toml_io import parse_robot

KERNELS = ("inverse_dynamics", "mass_matrix", "forward_dynamics", "inverse_dynamics_derivatives")
FLAGS = ("-O2", "-march=native", "-fPIC")
STATES = 32


def humanoid() -> str:
    lines = ["[robot]", 'name = "humanoid"', "gravity = [0.0, 0.0, -9.81]"]
    count = 0
    def limb(root, joints, first):
        nonlocal count
        at = root
        for j in range(joints):
            count += 1
            lines.extend(["[[joint]]", f"antecedent = {at}", f'alpha = "{("pi/2", "-pi/2")[j % 2]}"',
                          f"d = {0.05 * (j % 3)}", f"r = {0.1 * ((j + 1) % 3)}"])
            if j == 0:
                lines.extend([f'gamma = {first}', "b = 0.1"])
            at = count
        return at
    limb(0, 6, 0.3); limb(0, 6, -0.3)
    waist = limb(0, 3, 0.0)
    limb(waist, 7, 0.7); limb(waist, 7, -0.7); limb(waist, 1, 0.0)
    return "\n".join(lines) + "\n"


def robot_of(name):
    return parse_robot(humanoid() if name == "humanoid" else chain(int(name.removeprefix("chain"))), "x.toml")


def row(name, kernel, objects, options):
    robot = robot_of(name)
    model = symgen.derive(robot, (kernel,))
    found = model.kernel(kernel)
    pin, arm = pinocchio_model(robot)
    n = robot.n
    standard = dict.fromkeys((p.name for p in model.base.standard), 0.0)
    for j in range(1, arm.njoints):
        m, mx, my, mz, xx, xy, yy, xz, yz, zz = arm.inertias[j].toDynamicParameters()
        words = ("XX", "XY", "XZ", "YY", "YZ", "ZZ", "MX", "MY", "MZ", "M")
        standard |= {f"{w}{j}": float(v) for w, v in zip(words, (xx, xy, xz, yy, yz, zz, mx, my, mz, m))}
    X = np.array(regrouped(model.base, list(standard.values()), robot.values()))
    place = {"q": "q + i * n", "qd": "qd + i * n", "X": "X"}
    written = {}
    at = 0
    for o in found.outputs:
        written[o.name] = f"ours + i * size + {at}"
        at += o.size
    call = ", ".join(written.get(a.name) or place.get(a.name, "third + i * n") for a in found.arguments)
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        tree = symgen.generate(model, target="c", **options)
        symgen.write_package(tree, folder / "package")
        size = sum(len(c) for p, c in tree.files.items() if p.endswith(f"{kernel}.c"))
        text = (Path(__file__).parent / "trees.c").read_text()
        for mark, value in (("NAME", robot.name), ("KERNEL", kernel), ("OTHER", kernel), ("CALL", call),
                            ("JOINTS", str(n)), ("UPPER", str(int(kernel == "mass_matrix")))):
            text = text.replace(mark, value)
        (folder / "main.c").write_text(text)
        sources = [f for f in c_files(folder / "package") if f.name.endswith(f"{kernel}.c")]
        subprocess.run(["gcc", "-std=gnu11", *FLAGS, "-Ipackage", "-c", "main.c", *map(str, sources)], cwd=folder, check=True)
        objs = sorted(map(str, folder.glob("*.o")))
        subprocess.run(["g++", "-shared", *objs, *map(str, objects), "-lm", "-o", "all.so"], cwd=folder, check=True)
        lib = ctypes.CDLL(str(folder / "all.so"))
        begin_cxx(lib, arm)
        draw = np.random.default_rng(3)
        state = [draw.uniform(-1, 1, (STATES, n)) for _ in range(3)]
        ours, theirs, result = np.zeros(STATES * at), np.zeros(STATES * at), np.zeros(5)
        lib.measure(*map(pointer, (*state, X)), ctypes.c_size_t(at), *map(pointer, (ours, theirs, result)))
    h, H, c, C, d = result
    print(f"{name:9} {kernel:30} hot {h:8.0f} {H / h:5.2f}x cold {c:8.0f} {C / c:5.2f}x  diff {d:.1e}  {size/1e3:.0f} kB", flush=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--robots", default="chain7,chain15,chain30,chain50,humanoid")
    parser.add_argument("--kernels", default=",".join(KERNELS))
    asked = parser.parse_args()
    objects = pinocchio_objects(set(asked.kernels.split(",")), FLAGS)
    for kernel in asked.kernels.split(","):
        for name in asked.robots.split(","):
            row(name, kernel, objects, {})


main()

"""One call of a robot with a floating base beside Pinocchio's C++, and the time of generate.

    python tests/benchmarks/bench_floating.py [--robots go1,solo12,icub]

Robots are those of example-robot-data, without friction and rotors. trees.c says how a call is
timed: hot, out of the cache, and out of it after NAME_warm; both sides with -O2 -march=native. A
row of both holds q; qd and w; and qdd with f and wd, or tau with the wrench. M is compared as it
is, in the order of joints that each side has. `generate` writes all
kernels of the imported file with an empty cache, friction and rotors included; s of the processor.
"""

from __future__ import annotations

import argparse
import ctypes
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np
import pinocchio as pin
from bench_growth import processor
from bench_speed import STATES, TIMES, TREE_FLAGS
from oracles.urdf_arm import shipped, with_all_digits
from packages import run
from peers import pinocchio_headers, pointer

import symgen
from symgen.codegen.model import regrouping
from symgen.robot.formats.urdf import import_urdf

KERNELS = ("inverse_dynamics", "mass_matrix", "forward_dynamics")
SOURCE = Path(__file__).with_name("free_flyer.cpp")
HEADS = ("hot", "Pinocchio", "cold", "Pinocchio", "warm", "warm-up", "difference")


def begin(library: ctypes.CDLL, model: Any, places: list[int]) -> None:
    """Give the C++ the robot."""
    neutral, data = pin.neutral(model), model.createData()
    pin.computeJointJacobians(model, data, neutral)
    bodies = [np.ascontiguousarray(x.toDynamicParameters()) for x in model.inertias]
    library.begin(pointer(bodies[1]))
    for j in range(2, model.njoints):
        at, column = model.jointPlacements[j], model.joints[j].idx_v
        J = pin.getJointJacobian(model, data, j, pin.LOCAL)
        axis = np.ascontiguousarray(J[3:, column])
        rotation, translation = np.ascontiguousarray(at.rotation), np.array(at.translation)
        parent = ctypes.c_size_t(model.parents[j])
        parts = (axis, rotation, translation, bodies[j])
        library.joint(parent, *map(pointer, parts))
    library.end((ctypes.c_int * len(places))(*places))


def measured(name: str, text: str, flyer: Path, folder: Path) -> dict[str, list[float]]:
    """Return the times of each kernel, in the order of HEADS."""
    found = import_urdf(text, base="floating")
    joints = (replace(j, friction=(), rotor_inertia=False) for j in found.robot.joints)
    robot = replace(found.robot, name=name, joints=tuple(joints))
    model, n = symgen.derive(robot, KERNELS), robot.n
    symgen.write_package(symgen.generate(model, target="c"), folder / name)
    values = dict(found.parameters)
    X = regrouping(model) @ [values.get(p.name, 0.0) for p in model.base.standard]
    there = pin.buildModelFromXML(text, pin.JointModelFreeFlyer())
    places = [there.joints[there.getJointId(word)].idx_v for word in robot.joint_names]
    out = {}
    for kernel in KERNELS:
        (own,) = (k for k in model.kernels if k.name == kernel)
        at = {"q": "q", "qd": "qd", "w": "qd + n - 6", "f": "third + n - 6", "X": "X"}
        at |= {"wd": "third + n - 3", "wrench": "third + n - 6", "qdd": "third", "tau": "third"}
        words, written = [], 0
        for a in own.arguments:
            row = at.get(a.name, "")
            if a.written:
                row, written = f"ours + i * size + {written}", written + a.size
            words.append(row if a.written or a.name == "X" else f"{row} + i * n")
        program = TIMES.read_text()
        half = str(int(kernel == "mass_matrix"))
        marks = {"NAME": name, "KERNEL": kernel, "CALL": ", ".join(words), "JOINTS": str(n + 6)}
        for mark, content in (marks | {"HALF": half}).items():
            program = program.replace(mark, content)
        (folder / "main.c").write_text(program)
        sources = ("main.c", f"{name}/{name}_{kernel}.c", f"{name}/{name}_warm.c")
        run(["gcc", "-std=gnu11", *TREE_FLAGS, f"-I{name}", "-c", *sources], folder)
        objects = [folder / f"{Path(source).stem}.o" for source in sources]
        module = f"{name}_{kernel}.so"
        run(["g++", "-shared", *objects, flyer, "-lm", "-o", module], folder)
        library = ctypes.CDLL(str(folder / module))
        begin(library, there, places)
        state = np.random.default_rng(3).uniform(-1, 1, (3, STATES, n + 6))
        arrays = (*state, X, *np.zeros((2, STATES * written)), np.zeros(7))
        library.measure(ctypes.c_size_t(written), *map(pointer, arrays))
        out[kernel] = arrays[-1].tolist()
    return out


def main() -> None:
    """Compile Pinocchio, measure, print."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--robots", default="go1,solo12,icub")
    asked, headers = parser.parse_args().robots.split(","), pinocchio_headers()
    if isinstance(headers, str):
        sys.exit(headers)
    files = {path.stem: path for path in shipped()}
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        flyer = folder / "free_flyer.o"
        run(["g++", *headers, *TREE_FLAGS, "-c", SOURCE, "-o", flyer], folder)
        print(f"{'robot':8} {'kernel':20}" + "".join(f"{head:>12}" for head in HEADS))
        for name in asked:
            text = with_all_digits(files[name].read_text())
            for kernel, times in measured(name, text, flyer, folder).items():
                *ns, error = times
                ratios = [ns[1] / ns[0], ns[3] / ns[2], ns[3] / ns[4]]
                row = "".join(f"{x:12.0f}" for x in ns) + f"{error:12.1e}"
                shown = ", ".join(f"{ratio:.1f}" for ratio in ratios)
                print(f"{name:8} {kernel:20}{row}  hot, cold, warm {shown} times")
            toml, cache = folder / f"{name}.toml", str(folder / f"cache_{name}")
            toml.write_text(symgen.robot_toml(import_urdf(text, base="floating").robot))
            into = str(folder / f"all_{name}")
            spent = processor(["-m", "symgen", "generate", str(toml), "--into", into], cache)
            print(f"{name:8} generate, all kernels: {spent:.1f} s of the processor")


if __name__ == "__main__":
    main()

"""Peers of symgen, ready to be timed: Pinocchio and CasADi's C."""

from __future__ import annotations

import ctypes
import hashlib
import os
import re
import subprocess
import sys
import sysconfig
import warnings
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import casadi
import numpy as np

import symgen
from symgen import names
from symgen.cache import cache_folder
from symgen.codegen.backends.casadi import casadi_functions
from symgen.codegen.kernel import Kernel
from symgen.codegen.model import Model, regrouping
from symgen.robot.types import LENGTHS
from symgen.runtime.build import Compiler

#: How shared libraries of C are compiled, as symgen compiles its own.
BUILD = ("-O2", "-fPIC", "-shared", "-std=gnu11", "-fno-math-errno", "-ffp-contract=fast")
LOOPS = Path(__file__).with_name("pinocchio")
#: Kernels with a counterpart in Pinocchio, and what its Python binding calls it.
PINOCCHIO = {
    "energy_regressor": lambda pin, m, d, q, qd, _: (
        pin.computeKineticEnergyRegressor(m, d, q, qd),
        pin.computePotentialEnergyRegressor(m, d, q),
    ),
    "torque_regressor": lambda pin, m, d, q, qd, a: pin.computeJointTorqueRegressor(m, d, q, qd, a),
    "inverse_dynamics": lambda pin, m, d, q, qd, a: pin.rnea(m, d, q, qd, a),
    "mass_matrix": lambda pin, m, d, q, *_: pin.crba(m, d, q),
    "forward_dynamics": lambda pin, m, d, q, qd, tau: pin.aba(m, d, q, qd, tau),
}


def pointer(array: np.ndarray) -> ctypes.c_void_p:
    return array.ctypes.data_as(ctypes.c_void_p)


def pinocchio_model(robot: symgen.Robot) -> tuple[Any, Any] | None:
    """The arm with bodies of random inertia, in Pinocchio; None where it cannot be had."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            import pinocchio as pin
    except ImportError:
        return None
    if not hasattr(pin, "Model"):  # an unrelated package has the same name
        return None
    values = robot.values()
    model = pin.Model()
    pin.seed(1)
    for joint in robot.joints:
        gamma, b, alpha, d, theta, r = (float(getattr(joint, key).subs(values)) for key in LENGTHS)
        turn = pin.utils.rotate
        place = (
            pin.SE3(turn("z", gamma), np.array([0.0, 0.0, b]))
            * pin.SE3(turn("x", alpha), np.array([d, 0.0, 0.0]))
            * pin.SE3(turn("z", theta), np.array([0.0, 0.0, r]))
        )
        number = model.addJoint(joint.antecedent, pin.JointModelRZ(), place, f"joint{joint.number}")
        model.appendBodyToJoint(number, pin.Inertia.Random(), pin.SE3.Identity())
    model.gravity.linear = np.array([float(g.subs(values)) for g in robot.gravity])
    return pin, model


def pinocchio_objects(kernels: Iterable[str], flags: tuple[str, ...]) -> list[Path] | str:
    """Compile the loops over Pinocchio that these kernels are compared with, or say why not.

    Only the sources that hold them, two at a time, once: objects are kept in the cache folder.
    """
    headers = pinocchio_headers()
    if isinstance(headers, str):
        return headers
    command = ["g++", *headers, *flags, "-fPIC", "-c"]
    text = repr(command) + "".join(path.read_text() for path in sorted(LOOPS.iterdir()))
    kept = cache_folder() / f"pinocchio-{hashlib.sha256(text.encode()).hexdigest()[:16]}"
    kept.mkdir(parents=True, exist_ok=True)
    asked = sorted({LOOPS / "model.cpp", *(place for k, place in loops().items() if k in kernels)})

    def compiled(source: Path) -> Path | str:
        made, there = kept / f"{source.stem}-{os.getpid()}.o", kept / f"{source.stem}.o"
        if there.is_file():
            return there
        print(f"compiling Pinocchio: {source.name}", file=sys.stderr)
        done = subprocess.run([*command, source, "-o", made], capture_output=True, text=True)
        if done.returncode:
            return f"g++ failed on Pinocchio's headers: {done.stderr[:80]}"
        made.replace(there)
        return there

    with ThreadPoolExecutor(2) as pool:
        found = list(pool.map(compiled, asked))
    return next((f for f in found if isinstance(f, str)), [f for f in found if isinstance(f, Path)])


def loops() -> dict[str, Path]:
    """Return the kernels that have a loop over Pinocchio, and the source that holds each."""
    return {
        line[5 : line.index(",")]: source
        for source in sorted(LOOPS.glob("*.cpp"))
        for line in source.read_text().splitlines()
        if line.startswith("LOOP(")
    }


def pinocchio_headers() -> list[str] | str:
    """Options of g++ for Pinocchio's headers, or in words why there are none."""
    site = Path(sysconfig.get_path("purelib"))
    sites = [site, *(Path(p) for p in sys.path if p.endswith("site-packages"))]
    for place in sites:
        prefix, eigen = place / "cmeel.prefix", place / "casadi" / "include" / "eigen3"
        eigen = eigen if eigen.is_dir() else Path("/usr/include/eigen3")
        if (prefix / "include" / "pinocchio").is_dir() and eigen.is_dir():
            break
    else:
        return "the headers of Pinocchio (pin) or of Eigen (casadi) are not here"
    limits = ["-DBOOST_MPL_LIMIT_LIST_SIZE=30", "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS"]
    limits += ["-DBOOST_FUSION_INVOKE_MAX_ARITY=12", "-DFUSION_MAX_VECTOR_SIZE=12"]
    include = [f"-I{prefix / 'include'}", f"-I{eigen}"]
    return ["-std=c++17", "-O2", "-DNDEBUG", "-w", *limits, *include]


def begin_cxx(library: ctypes.CDLL, arm: Any) -> None:
    """Give the C++ loops the same arm."""
    library.begin()
    for joint in range(1, arm.njoints):
        place = arm.jointPlacements[joint]
        rotation = np.ascontiguousarray(place.rotation)
        body = np.ascontiguousarray(arm.inertias[joint].toDynamicParameters())
        parent = ctypes.c_size_t(arm.parents[joint])
        library.joint(
            parent, pointer(rotation), pointer(np.array(place.translation)), pointer(body)
        )
    library.end(pointer(np.array(arm.gravity.linear)))


def base_of(model: Model, arm: Any) -> np.ndarray:
    """Return the base parameters of the arm's bodies, without rotors and friction."""
    standard = dict.fromkeys((p.name for p in model.base.standard), 0.0)
    for j in range(1, arm.njoints):
        m, mx, my, mz, xx, xy, yy, xz, yz, zz = arm.inertias[j].toDynamicParameters()
        values = (xx, xy, xz, yy, yz, zz, mx, my, mz, m)
        standard |= {f"{w}{j}": float(v) for w, v in zip(names.LINK, values, strict=True)}
    return regrouping(model) @ list(standard.values())


CASADI_LOOP = """
#include <stddef.h>
void loop(size_t N, ARRAYS, double *out)
{
    const double *arg[64];
    double *res[64];
    casadi_int iw[IW];
    double w[W];
    for (size_t k = 0; k < N; ++k) {
        PLACES
        res[0] = out + k * SIZE;
        peer(arg, res, iw, w, 0);
    }
}
"""


def casadi_c(
    model: Model, kernel: Kernel, folder: Path, compiler: Compiler, flags: tuple[str, ...]
) -> ctypes.CDLL:
    """Compile the C that CasADi generates of a kernel, with symgen's compiler and flags."""
    function = casadi_functions("peer", model.robot, [kernel])[kernel.name]()
    peer = casadi.Function("peer", function.sx_in(), function.call(function.sx_in()))
    generator = casadi.CodeGenerator("peer.c")
    generator.add(peer)
    generator.generate(f"{folder}/")
    inputs = [(name, len(symbols)) for name, symbols in kernel.tape.inputs]
    loop = CASADI_LOOP.replace("ARRAYS", ", ".join(f"const double *{name}" for name, _ in inputs))
    places = " ".join(
        f"arg[{i}] = {name}{'' if name == 'X' else f' + k * {size}'};"
        for i, (name, size) in enumerate(inputs)
    )
    for mark, text in (("PLACES", places), ("SIZE", str(kernel.size))):
        loop = loop.replace(mark, text)
    loop = re.sub(r"\[IW\]", f"[{peer.sz_iw() + 1}]", loop)
    loop = re.sub(r"\[W\]", f"[{peer.sz_w() + 1}]", loop)
    source = folder / "peer.c"
    source.write_text(source.read_text() + loop)
    command = [*compiler.command, *BUILD, *flags, "peer.c", "-o", "peer.so", "-lm"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return ctypes.CDLL(str(folder / "peer.so"))


AD_LOOP = """
#include <stddef.h>
void NAME_loop(size_t N, ARRAYS, double *out)
{
    static double w[W];
    static casadi_int iw[IW];
    const double *arg[64];
    double *res[64];
    for (size_t k = 0; k < N; ++k) {
        PLACES
        NAME(arg, res, iw, w, 0);
    }
}
"""


def casadi_slopes(model: Model, kernel: str, name: str) -> str:
    """Return C with NAME_loop: the derivatives of a kernel by CasADi's AD of its own function.

    Args:
        model: with the kernel.
        kernel: inverse_dynamics or forward_dynamics; its first arrays are q, qd and tau or qdd.
        name: of the function.

    Returns:
        C of NAME_loop(N, q, qd, third, X, out); out holds dense matrices by columns.
    """
    found = model.kernel(kernel)
    assert found is not None
    function = casadi_functions("peer", model.robot, [found])[kernel]()
    inputs = function.sx_in()
    (value,) = function.call(inputs)
    count = 3 if kernel == "forward_dynamics" else 2
    slopes = [casadi.densify(casadi.jacobian(value, x)) for x in inputs[:count]]
    generator = casadi.CodeGenerator(f"{name}.c")
    peer = casadi.Function(name, inputs, slopes)
    generator.add(peer)
    n = model.robot.n
    words = ["q", "qd", "third", "X"]
    places = [f"arg[{i}] = {w}{'' if w == 'X' else f' + k * {n}'};" for i, w in enumerate(words)]
    places += [f"res[{i}] = out + (k * {count} + {i}) * {n * n};" for i in range(count)]
    text = AD_LOOP.replace("ARRAYS", ", ".join(f"const double *{word}" for word in words))
    marks = {"PLACES": " ".join(places), "[W]": f"[{peer.sz_w() + 1}]"}
    for mark, content in (marks | {"[IW]": f"[{peer.sz_iw() + 1}]", "NAME": name}).items():
        text = text.replace(mark, content)
    return str(generator.dump()) + text

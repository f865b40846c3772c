"""How long one energy_regressor takes, in every way of computing it, side by side in one run.

    python tests/benchmarks/bench_evaluator.py

Times are ns per sample, medians of repeats that take turns, so that a slow moment of the machine
meets all ways alike; ratios are against symgen's C called in a C loop (the batch form). Pinocchio
gives the 10 n standard columns (kinetic, then potential), symgen the base columns it needs.
"""

from __future__ import annotations

import ctypes
import shutil
import statistics
import subprocess
import sys
import sysconfig
import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import casadi
import numpy as np
import sympy as sp
from rich.console import Console
from rich.table import Table

import symgen
from symgen.codegen.casadi_model import casadi_function
from symgen.runtime.build import _FLAGS, find_compiler
from symgen.runtime.flags import chosen_flags
from symgen.symbolic.tape import Tape

ROBOTS = ("puma560", "tx40", "panda", "wam7")
SAMPLES = 1000
REPEATS = 41
AT_LEAST = 2e-3  # seconds of one timing

#: The C that CasADi generates, called once for each sample in a C loop.
CASADI_LOOP = """
#include <stddef.h>
void loop(size_t N, const double *q, const double *qd, double *out)
{
    const double *arg[64];
    double *res[64];
    casadi_int iw[1024];
    double w[65536];
    for (size_t k = 0; k < N; ++k) {
        arg[0] = q + k * N_JOINTS;
        arg[1] = qd + k * N_JOINTS;
        res[0] = out + k * N_OUT;
        energy(arg, res, iw, w, 0);
    }
}
"""

PINOCCHIO_LOOP = """
#include <pinocchio/multibody.hpp>
#include <pinocchio/algorithm/regressor.hpp>
#include <cstddef>
static pinocchio::Model model;
static pinocchio::Data *data;
extern "C" void begin() { delete data; data = nullptr; model = pinocchio::Model(); }
extern "C" void joint(const double *R, const double *p)
{
    using Matrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    const Eigen::Matrix3d rotation = Eigen::Map<const Matrix>(R);
    const Eigen::Vector3d translation = Eigen::Map<const Eigen::Vector3d>(p);
    const pinocchio::SE3 place(rotation, translation);
    const auto last = static_cast<pinocchio::JointIndex>(model.njoints - 1);
    const auto id = model.addJoint(last, pinocchio::JointModelRZ(), place, std::to_string(last));
    model.appendBodyToJoint(id, pinocchio::Inertia::Identity(), pinocchio::SE3::Identity());
}
extern "C" void end(const double *g)
{
    model.gravity.linear(Eigen::Map<const Eigen::Vector3d>(g));
    data = new pinocchio::Data(model);
}
extern "C" void loop(std::size_t N, const double *q, const double *qd, double *out)
{
    Eigen::VectorXd a(model.nq), b(model.nv);
    for (std::size_t k = 0; k < N; ++k) {
        a = Eigen::Map<const Eigen::VectorXd>(q + k * model.nq, model.nq);
        b = Eigen::Map<const Eigen::VectorXd>(qd + k * model.nv, model.nv);
        pinocchio::computeKineticEnergyRegressor(model, *data, a, b);
        pinocchio::computePotentialEnergyRegressor(model, *data, a);
        Eigen::Map<Eigen::VectorXd> sum(out + k * 10 * model.nv, 10 * model.nv);
        sum = data->kineticEnergyRegressor + data->potentialEnergyRegressor;
    }
}
"""

Way = tuple[Callable[[], Any], int]  # a call, and how many samples it computes


def calls_for(way: Way) -> int:
    """Choose how many calls one timing needs."""
    calls = 1
    while True:
        start = time.perf_counter()
        for _ in range(calls):
            way[0]()
        if time.perf_counter() - start > AT_LEAST:
            return calls
        calls *= 2


def measure(ways: dict[str, Way]) -> dict[str, float]:
    """Return the median time of each way, ns per sample; the ways take turns."""
    calls = {name: calls_for(way) for name, way in ways.items()}
    times: dict[str, list[float]] = {name: [] for name in ways}
    for _ in range(REPEATS):
        for name, (call, samples) in ways.items():
            count = calls[name]
            start = time.perf_counter_ns()
            for _ in range(count):
                call()
            times[name].append((time.perf_counter_ns() - start) / count / samples)
    return {name: statistics.median(t) for name, t in times.items()}


def pointer(array: np.ndarray) -> ctypes.c_void_p:
    return array.ctypes.data_as(ctypes.c_void_p)


def batch_call(function: Any, q: np.ndarray, qd: np.ndarray, out: np.ndarray) -> Way:
    """A C function of (N, q, qd, out), called once for all samples."""
    arguments = (ctypes.c_size_t(len(q)), *(pointer(a) for a in (q, qd, out)))
    return (lambda: function(*arguments)), len(q)


def casadi_c(function: casadi.Function, folder: Path, joints: int) -> ctypes.CDLL:
    """Compile the C that CasADi generates, with symgen's compiler and flags."""
    compiler = find_compiler()
    assert compiler is not None
    energy = casadi.Function("energy", function.sx_in(), function.call(function.sx_in()))
    generator = casadi.CodeGenerator("energy.c")
    generator.add(energy)
    generator.generate(f"{folder}/")
    source = folder / "energy.c"
    loop = CASADI_LOOP.replace("N_JOINTS", str(joints)).replace("N_OUT", str(energy.numel_out(0)))
    assert energy.sz_w() < 65536
    source.write_text(source.read_text() + loop)
    library = folder / "energy.so"
    command = [*compiler.command, *_FLAGS, *chosen_flags(compiler).flags.flags, str(source)]
    command += ["-o", str(library), "-lm"]
    subprocess.run(command, check=True, capture_output=True)
    return ctypes.CDLL(str(library))


def expressions(tape: Tape, values: dict[sp.Symbol, sp.Expr]) -> list[sp.Expr]:
    """The outputs as plain expressions of the inputs, what a user of SymPy would begin with."""
    known = {s: e.subs(values).evalf(20) for s, e in tape.constants}
    for symbol, expr in tape.steps:
        known[symbol] = expr.xreplace(known)
    return [sp.sympify(e).xreplace(known) for e in tape.outputs]


def pinocchio_model(robot: symgen.Robot) -> tuple[Any, Any] | None:
    """The arm in Pinocchio, with the placements of its joints; None where it cannot be had."""
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
    for joint in robot.joints:
        alpha, d, theta, r = (
            float(getattr(joint, key).subs(values)) for key in ("alpha", "d", "theta", "r")
        )
        turn = pin.utils.rotate
        place = pin.SE3(turn("x", alpha), np.array([d, 0.0, 0.0])) * pin.SE3(
            turn("z", theta), np.array([0.0, 0.0, r])
        )
        number = model.addJoint(joint.antecedent, pin.JointModelRZ(), place, f"joint{joint.number}")
        model.appendBodyToJoint(number, pin.Inertia.Identity(), pin.SE3.Identity())
    model.gravity.linear = np.array([float(g.subs(values)) for g in robot.gravity])
    return pin, model


def pinocchio_cxx(folder: Path) -> ctypes.CDLL | None:
    """Compile the loop over Pinocchio in C++; None where its headers or libraries are missing."""
    site = Path(sysconfig.get_path("purelib"))
    prefix = site / "cmeel.prefix"
    eigen = site / "casadi" / "include" / "eigen3"
    if not (prefix / "include" / "pinocchio" / "multibody.hpp").is_file() or not eigen.is_dir():
        return None
    if shutil.which("g++") is None:
        return None
    (folder / "pin.cpp").write_text(PINOCCHIO_LOOP)
    command = ["g++", "-std=c++17", "-O2", "-DNDEBUG", "-w", "-shared", "-fPIC", "pin.cpp"]
    command += ["-DBOOST_MPL_LIMIT_LIST_SIZE=30", "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS"]
    command += ["-DPINOCCHIO_ENABLE_TEMPLATE_INSTANTIATION"]  # the library's own compiled code
    command += [f"-I{prefix / 'include'}", f"-I{eigen}", "-o", "pin.so"]
    command += [f"-L{prefix / 'lib'}", "-lpinocchio_default", f"-Wl,-rpath,{prefix / 'lib'}"]
    try:
        subprocess.run(command, cwd=folder, check=True, capture_output=True, timeout=40)
        return ctypes.CDLL(str(folder / "pin.so"))
    except (subprocess.SubprocessError, OSError):
        return None


def ways_of(name: str, folder: Path, cxx: ctypes.CDLL | None) -> tuple[str, dict[str, Way]]:
    """Every way of computing a robot's kernel, checked to give the same numbers."""
    robot = symgen.read_robot(name)
    model = symgen.derive(robot)
    evaluator = symgen.load(model, backend="c")
    function = evaluator["energy_regressor"]
    kernel, n = function.kernel, robot.n
    draw = np.random.default_rng(1)
    q, qd = draw.uniform(-2, 2, (2, SAMPLES, n))
    expected = function(q, qd)
    out = np.empty_like(expected)

    def same(found: Any) -> None:
        np.testing.assert_allclose(found, expected[: len(found)], rtol=0, atol=1e-10)

    assert evaluator.library is not None
    ffi, lib = evaluator.library.ffi, evaluator.library.lib
    batch = getattr(lib, f"{name}_energy_regressor_batch")
    single = getattr(lib, f"{name}_energy_regressor")
    arrays = [ffi.from_buffer("double *", a) for a in (q, qd, out)]
    ways: dict[str, Way] = {"symgen C, C loop (batch)": (lambda: batch(SAMPLES, *arrays), SAMPLES)}
    bound = function.bind()
    bound.inputs[0][:], bound.inputs[1][:] = q[0], qd[0]
    ways["symgen C, bound buffers, Python"] = (bound.call, 1)
    bound()
    same(bound.out[None])
    one_q, one_qd, one_out = q[0].copy(), qd[0].copy(), out[0].copy()

    def from_buffer() -> None:
        single(
            ffi.from_buffer("double *", one_q),
            ffi.from_buffer("double *", one_qd),
            ffi.from_buffer("double *", one_out),
        )

    from_buffer()
    same(one_out[None])
    ways["symgen C, from_buffer, Python"] = (from_buffer, 1)
    ways["symgen C, evaluator call, Python"] = (lambda: function(one_q, one_qd), 1)

    vm = casadi_function(model, kernel)
    mapped = vm.map(SAMPLES)
    same(np.array(mapped(q.T, qd.T)).T)
    ways["CasADi VM, map"] = (lambda: mapped(q.T, qd.T), SAMPLES)
    library = casadi_c(vm, folder, n)
    out[:] = np.nan
    ways["CasADi generated C, C loop"] = batch_call(library.loop, q, qd, out)
    ways["CasADi generated C, C loop"][0]()
    same(out)

    symbols = [s for _, group in kernel.tape.inputs for s in group]
    plain = sp.lambdify(symbols, expressions(kernel.tape, robot.values()), "numpy", cse=True)
    arguments = [float(v) for v in (*q[0], *qd[0])]
    same(np.array([plain(*arguments)]))
    ways["SymPy lambdify(numpy, cse), Python"] = (lambda: plain(*arguments), 1)

    if (found := pinocchio_model(robot)) is not None:
        pin, arm = found
        data = arm.createData()

        def regressor() -> Any:
            kinetic = pin.computeKineticEnergyRegressor(arm, data, one_q, one_qd)
            return kinetic, pin.computePotentialEnergyRegressor(arm, data, one_q)

        ways["Pinocchio, Python"] = (regressor, 1)
        if cxx is not None:
            cxx.begin()
            for joint in range(1, n + 1):
                place = arm.jointPlacements[joint]
                rotation = np.ascontiguousarray(place.rotation)
                cxx.joint(pointer(rotation), pointer(np.array(place.translation)))
            cxx.end(pointer(np.array(arm.gravity.linear)))
            columns = np.empty((SAMPLES, 10 * n))
            ways["Pinocchio, C++, C++ loop"] = batch_call(cxx.loop, q, qd, columns)
            ways["Pinocchio, C++, C++ loop"][0]()
            kinetic, potential = regressor()
            np.testing.assert_allclose(
                columns[0], np.ravel(kinetic) + np.ravel(potential), rtol=0, atol=1e-10
            )
    o = kernel.tape.operations
    return f"{o.mul} mul {o.add} add {o.sincos} sincos, {model.inertial} columns", ways


def main() -> int:
    """Measure and print the tables."""
    compiler = find_compiler()
    if compiler is None:
        print("no C compiler: nothing to compare")
        return 2
    began = time.perf_counter()
    console = Console(highlight=False, width=140)
    table = Table("way", box=None, pad_edge=False, header_style="bold")
    table.title = f"energy_regressor: ns per sample (ratio to symgen's batch C); {compiler.version}"
    columns: list[dict[str, float]] = []
    counts = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        cxx = pinocchio_cxx(folder)
        for name in ROBOTS:
            (folder / name).mkdir()
            count, ways = ways_of(name, folder / name, cxx)
            columns.append(measure(ways))
            counts.append(f"{name}: {count}")
            table.add_column(name, justify="right")
    for way in columns[0]:
        base = [c["symgen C, C loop (batch)"] for c in columns]
        cells = [f"{c[way]:,.0f} ({c[way] / b:.3g}x)" for c, b in zip(columns, base, strict=True)]
        table.add_row(way, *cells)
    console.print("\n".join(counts))
    console.print(table)
    if cxx is None or "Pinocchio, Python" not in columns[0]:
        console.print("Pinocchio (or its C++ headers) is not on this machine: left out")
    seconds = time.perf_counter() - began
    console.print(f"medians of {REPEATS} repeats in turn; {seconds:.0f} s in all")
    return 0


if __name__ == "__main__":
    sys.exit(main())

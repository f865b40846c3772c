"""The on-line identifier at rest, with one joint alone, under drift, with NaN and with outliers.

    python tests/studies/identifier_study.py [--samples 10000000] [--cases rest alone ...]
    python tests/studies/identifier_study.py --robot panda --samples 120000 --cases load start wild

A planar arm with gravity and friction is excited for 60 s at 1 kHz, with noise of encoders, speeds
and torques. Then, for so many samples:

    rest       all joints stand, under static friction and torques that wander within it
    alone      joint 1 moves, joint 2 stands
    drift      the viscous friction of joint 2 doubles linearly over the whole case
    nan        one sample in a thousand is NaN (the identifier refuses it)
    outliers   one sample in ten thousand has a torque 1000 times too large, or a speed of 1e3
    load       a body of 2 kg is gripped when the case begins
    start      the same outliers in every second sample of the first second, before the 60 s
    wild       the same in one sample of twenty, from the first second on

These three are there for every robot of the library; with another robot than the pair, links are
invented. Readings begin 60 s after what happens.

by model and precision. The table has, over readings after each hundredth of the case: the largest
relative change of X and of std (rest), the largest error of X in std, the share of errors above 3
std, the error of the gravity torque at the end, and what is excited at the end.
"""

from __future__ import annotations

import argparse
import ctypes
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

import symgen
from symgen.runtime.build import find_compiler

ROBOT = """
[robot]
name = "pair"
convention = "modified-dh"
gravity = [0.0, -9.81, 0.0]
[[joint]]
rotor_inertia = false
[[joint]]
d = 0.5
rotor_inertia = false
"""
KERNELS = (
    "energy_regressor", "friction_power", "momentum_regressor", "friction_torque",
    "inverse_dynamics", "torque_regressor", "gravity_torque",
)  # fmt: skip
CASES = ("rest", "alone", "drift", "nan", "outliers", "load", "start", "wild")
ANY_ROBOT = CASES[-3:]
SPOILED = {"nan": 1e-3, "outliers": 1e-4, "wild": 0.05}
LOAD = {"XX": 0.03, "YY": 0.04, "ZZ": 0.02, "XZ": 0.01, "MX": 0.1, "MY": 0.06, "MZ": 0.2, "M": 2.0}
RATE, WARM, WINDOW, FORGETTING = 1000.0, 60_000, 200, 0.9999
NOISE = {"q": 1e-5, "qd": 1e-4, "tau": 2e-2}


@dataclass(frozen=True)
class Row:
    """What the study found of one case."""

    case: str
    model: str
    dtype: str
    samples: int
    change: float
    std_change: float
    worst: float
    above: float
    gravity: float
    excited: tuple[float, float]


@cache
def plant(robot: str = "pair") -> tuple[Any, np.ndarray]:
    """Return the compiled model and its parameters."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "pair.toml"
        path.write_text(ROBOT)
        source = str(path) if robot == "pair" else robot
        evaluator = symgen.load(symgen.derive(source, KERNELS), backend="c")
    return evaluator, regrouped(evaluator, links(evaluator))


def links(evaluator: Any) -> dict[str, float]:
    """Return standard parameters of a possible robot."""
    n = evaluator.model.robot.n
    if n == 2:
        return {"ZZ1": 0.5, "MX1": 1.2, "MY1": 0.1, "M1": 5.0,
                "ZZ2": 0.2, "MX2": 0.7, "MY2": -0.1, "M2": 3.0,
                "FS1": 1.5, "FV1": 0.8, "FS2": 0.9, "FV2": 0.4}  # fmt: skip
    values: dict[str, float] = {}
    for j in range(1, n + 1):
        m, (x, y, z) = 4.0 - 3.0 * j / n, (0.02 + 0.01 * j, -0.03, 0.05 - 0.01 * j)
        own = 0.02 * m
        values |= {f"M{j}": m, f"MX{j}": m * x, f"MY{j}": m * y, f"MZ{j}": m * z,
                   f"XX{j}": own + m * (y * y + z * z), f"YY{j}": own + m * (x * x + z * z),
                   f"ZZ{j}": own + m * (x * x + y * y), f"XY{j}": -m * x * y,
                   f"XZ{j}": -m * x * z, f"YZ{j}": -m * y * z,
                   f"IA{j}": 0.1, f"FS{j}": 1.0, f"FV{j}": 0.8}  # fmt: skip
    return values


def loaded(robot: str) -> np.ndarray:
    """Return the parameters with a body of 2 kg on the last link."""
    evaluator = plant(robot)[0]
    values = links(evaluator)
    for name, value in LOAD.items():
        on_last = f"{name}{evaluator.model.robot.n}"
        values[on_last] = values.get(on_last, 0.0) + value
    return regrouped(evaluator, values)


def regrouped(evaluator: Any, values: dict[str, float]) -> np.ndarray:
    """Return base parameters of standard ones: those whose torques are the same."""
    from symgen.codegen.model import regrouping

    standard = [values.get(p.name, 0.0) for p in evaluator.model.base.standard]
    return regrouping(evaluator.model) @ standard


class Online:
    """The identifier of a generated package in C, of a precision."""

    def __init__(self, model: str, dtype: str, robot: str = "pair") -> None:
        self.lib, name = _library(dtype, robot)
        self.real = np.dtype(np.float64 if dtype == "double" else np.float32)
        begin = f"{name}_identifier" + ("_momentum" if model == "momentum" else "")
        size = getattr(self.lib, f"{begin}_size")
        size.restype, size.argtypes = ctypes.c_size_t, [ctypes.c_size_t]
        self.memory = np.zeros(size(WINDOW) // 8 + 2)
        init = getattr(self.lib, f"{begin}_init")
        scalar = ctypes.c_double if dtype == "double" else ctypes.c_float
        init.argtypes = [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_size_t, ctypes.c_int, scalar]
        assert init(self.memory.ctypes.data, self.memory.nbytes, WINDOW, 1, FORGETTING) == 0
        self.functions = {}
        for function, count in (("step", 4), ("read", 3), ("excited", 2)):
            found = getattr(self.lib, f"{name}_identifier_{function}")
            found.argtypes = [ctypes.c_void_p] * count + ([scalar] if function == "step" else [])
            self.functions[function] = found
        feed = self.lib.feed
        feed.argtypes = [ctypes.c_void_p, ctypes.c_size_t, *[ctypes.c_void_p] * 3, scalar]
        self.p = len(plant(robot)[1])

    def feed(self, q: np.ndarray, qd: np.ndarray, tau: np.ndarray) -> None:
        arrays = [np.ascontiguousarray(x, dtype=self.real) for x in (q, qd, tau)]
        pointers = [a.ctypes.data for a in arrays]
        self.lib.feed(self.memory.ctypes.data, len(q), *pointers, 1 / RATE)

    def read(self) -> tuple[np.ndarray, np.ndarray]:
        X, std = np.zeros(self.p, self.real), np.zeros(self.p, self.real)
        state = self.memory.ctypes.data
        assert self.functions["read"](state, X.ctypes.data, std.ctypes.data) == 0
        return X.astype(float), std.astype(float)

    def excited(self) -> np.ndarray:
        out = np.zeros(self.p, self.real)
        assert self.functions["excited"](self.memory.ctypes.data, out.ctypes.data) == 0
        return out.astype(float)


FEED = """
#include "NAME_identifier.h"
void feed(void *s, size_t N, const NAME_real *q, const NAME_real *qd, const NAME_real *tau,
          NAME_real dt);
void feed(void *s, size_t N, const NAME_real *q, const NAME_real *qd, const NAME_real *tau,
          NAME_real dt)
{
    NAME_real passed = 0;
    for (size_t k = 0; k < N; k++) {
        passed += dt;
        if (NAME_identifier_step(s, q + k * NAME_JOINTS, qd + k * NAME_JOINTS,
                                 tau + k * NAME_JOINTS, passed) == 0) {
            passed = 0;
        }
    }
}
"""


@cache
def _library(dtype: str, robot: str) -> tuple[ctypes.CDLL, str]:
    folder = Path(tempfile.mkdtemp())
    tree = symgen.generate(plant(robot)[0].model, target="c", dtype=dtype)
    symgen.write_package(tree, folder / "pair")
    (folder / "feed.c").write_text(FEED.replace("NAME", tree.name))
    compiler = find_compiler()
    assert compiler is not None
    sources = list((folder / "pair").glob("*.c"))
    command = [*compiler.command, "-std=c99", "-O2", "-shared", "-fPIC", f"-I{folder / 'pair'}",
               folder / "feed.c", *sources, "-lm", "-o", folder / "pair.so"]  # fmt: skip
    subprocess.run(command, check=True)
    return ctypes.CDLL(str(folder / "pair.so")), tree.name


def moving(
    begin: int, count: int, X: np.ndarray, alone: bool = False, robot: str = "pair"
) -> list[np.ndarray]:
    """Return q, qd and tau of the arm from a sample on; alone: joint 2 stands."""
    t = (begin + np.arange(count))[:, None, None] / RATE
    evaluator = plant(robot)[0]
    if robot == "pair":
        w = np.array([[1.1, 1.7], [3.7, 2.9], [5.3, 6.1]])
        a = np.array([[0.9, 0.8], [0.3, 0.35], [0.15, 0.12]])
    else:
        rng, shape = np.random.default_rng(4), (6, evaluator.model.robot.n)
        w, a = 2 * np.pi * rng.uniform(0.05, 0.6, shape), rng.uniform(0.1, 0.5, shape)
    phase = a if robot == "pair" else 10 * a
    q, qd = (a * np.sin(w * t + phase)).sum(1), (a * w * np.cos(w * t + phase)).sum(1)
    qdd = (-a * w**2 * np.sin(w * t + phase)).sum(1)
    if alone:
        q[:, 1], qd[:, 1], qdd[:, 1] = 0.6, 0.0, 0.0
    if X.ndim == 1:
        return [q, qd, evaluator["inverse_dynamics"](q, qd, qdd, X)]
    return [q, qd, np.einsum("kij,kj->ki", evaluator["torque_regressor"](q, qd, qdd), X)]


def chunks(
    case: str, samples: int, chunk: int, robot: str = "pair"
) -> Iterator[tuple[list[np.ndarray], np.ndarray]]:
    """Yield the clean samples of a case, and the true X at the end of each chunk."""
    evaluator, X = plant(robot)
    X = loaded(robot) if case == "load" else X
    names = evaluator.model.base.names
    for begin in range(0, samples, chunk):
        count = min(chunk, samples - begin)
        if case == "rest":
            q = np.tile([0.4, 0.6], (count, 1))
            weight = evaluator["gravity_torque"](q, X)
            wander = np.sin(np.arange(begin, begin + count) / 7000.0)[:, None]
            friction = X[[names.index("FS1"), names.index("FS2")]]
            yield [q, np.zeros_like(q), weight + 0.8 * friction * wander], X
        elif case == "drift":
            true = np.tile(X, (count, 1))
            place = names.index("FV2")
            true[:, place] *= 1 + (begin + 1 + np.arange(count)) / samples
            yield moving(begin, count, true), true[-1]
        else:
            yield moving(begin, count, X, case == "alone", robot), X


def gravity_error(evaluator: Any, found: np.ndarray, true: np.ndarray) -> float:
    """Return the relative error of the gravity torque over random positions."""
    q = np.random.default_rng(1).uniform(-3, 3, (1000, evaluator.model.robot.n))
    weights = [evaluator["gravity_torque"](q, x) for x in (found, true)]
    return float(np.linalg.norm(weights[0] - weights[1]) / np.linalg.norm(weights[1]))


def studied(case: str, model: str, dtype: str, samples: int, robot: str = "pair") -> Row:
    """Run a case and return its row."""
    evaluator, X = plant(robot)
    online, rng = Online(model, dtype, robot), np.random.default_rng(88000 + CASES.index(case))

    def feed(parts: Sequence[np.ndarray], share: float) -> None:
        q, qd, tau = (
            x + s * rng.standard_normal(x.shape) for x, s in zip(parts, NOISE.values(), strict=True)
        )
        if share > 0:
            hit = rng.random(len(q)) < share
            which = rng.integers(2, size=len(q))
            for name, rows in (("qd", hit & (which == 0)), ("tau", hit & (which == 1))):
                spoiled = qd if name == "qd" else tau
                wrong = 1e3 if name == "qd" else 1e3 * tau[rows]
                spoiled[rows] = np.nan if case == "nan" else wrong
        online.feed(q, qd, tau)

    share = SPOILED.get(case, 0.0)
    before = share if case == "wild" else 0.0
    if case == "start":
        feed(moving(-WARM - 1000, 1000, X, robot=robot), 0.5)
    feed(moving(-WARM, WARM, X, robot=robot), before)
    if case == "rest":  # the stop itself, a window of it
        feed(next(chunks(case, 2 * WINDOW, 2 * WINDOW))[0], share)
    X0, std0 = online.read()
    change = std_change = worst = 0.0
    above = []
    seen, settled = 0, WARM if case == "load" else 0
    for parts, true in chunks(case, samples, max(samples // 100, 1), robot):
        feed(parts, share)
        seen += len(parts[0])
        if seen < settled:
            continue
        found, std = online.read()
        off = np.abs(found - true) / std
        worst, above = max(worst, float(off.max())), [*above, *(off > 3)]
        change = max(change, float(np.abs(found / X0 - 1).max()))
        std_change = max(std_change, float(np.abs(std / std0 - 1).max()))
    error = gravity_error(evaluator, found, true)
    excited = online.excited()
    return Row(case, model, dtype, samples, change, std_change, worst, float(np.mean(above)), error,
               (float(excited.min()), float(excited.max())))  # fmt: skip


def main() -> None:
    """Run the cases and print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--samples", type=int, default=10_000_000)
    parser.add_argument("--cases", nargs="+", default=None, choices=CASES)
    parser.add_argument("--robot", default="pair")
    asked = parser.parse_args()
    cases = asked.cases or (CASES if asked.robot == "pair" else ANY_ROBOT)
    table = Table(
        title=f"{asked.robot}, {asked.samples:,} samples, window {WINDOW}, forgetting {FORGETTING}",
        box=None,
    )
    for head in ("case", "model", "precision", "change of X", "of std", "worst error / std",
                 "above 3 std", "gravity torque off", "excited"):  # fmt: skip
        table.add_column(head)
    for case in cases:
        for model in ("energy", "momentum"):
            for dtype in ("double", "float"):
                row = studied(case, model, dtype, asked.samples, asked.robot)
                rest = case == "rest"
                table.add_row(
                    case, model, dtype, f"{row.change:.1e}" if rest else "",
                    f"{row.std_change:.1e}" if rest else "", f"{row.worst:.2f}",
                    f"{100 * row.above:.1f} %", f"{100 * row.gravity:.2f} %",
                    f"{row.excited[0]:.2g} to {row.excited[1]:.2g}",
                )  # fmt: skip
    Console(width=150).print(table)


if __name__ == "__main__":
    main()

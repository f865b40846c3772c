"""The identifiers and the follower of a load on line: microseconds, bytes of state, and errors.

    python tests/benchmarks/bench_identifier.py [--beside FOLDER] [--robot panda] [--into file.json]

FOLDER is another checkout of symgen, such as a worktree of an older commit: its packages are built
and run beside this one's, in turns. A step's time is the smallest of all repeats of the same step,
so that what interrupts a program is left out; the worst is the largest of these over the log. Then
each identifies logs that differ in the noise alone: the spread of every parameter, and how far the
means of the two are apart. NAME_payload.h is timed alone.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "docs"))

import numpy as np
from figures import keep
from rich.console import Console
from rich.table import Table

import symgen
from symgen.runtime.build import find_compiler
from symgen.runtime.flags import kernel_flags

RATE, WINDOW, SAMPLES, REPEATS = 1000.0, 100, 6000, 9
DRIVER = r"""
#define _POSIX_C_SOURCE 199309L
#ifdef LOAD
#include "NAME_payload.h"
#define SIZE NAME_payload_size()
#define BEGIN NAME_payload_init(state, bytes, 3, 0.3, 1)
#define STEP NAME_payload_step(state, x, x + N, x + 2 * N, DT, given)
#define READ (NAME_payload_read(state, X, std), 0)
#else
#include "NAME_identifierHEADER.h"
#define SIZE NAME_identifierMODEL_size(WINDOW)
#define BEGIN NAME_identifierMODEL_init(state, bytes, WINDOW, NAME_WINDOW_SLIDING, 1)
#define STEP NAME_identifier_step(state, x, x + N, x + 2 * N, DT)
#define READ NAME_identifier_read(state, X, std)
#endif
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#define N NAME_JOINTS
static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e6 * (double)t.tv_sec + 1e-3 * (double)t.tv_nsec;
}
/* samples, repeats, file of X and of [q qd tau] rows -> bytes, us of each step, us of reads, X */
int main(int argc, char **argv)
{
    const long count = atol(argv[1]), repeats = atol(argv[2]);
    const size_t bytes = SIZE;
    void *state = malloc(bytes);
    double *log = malloc((size_t)count * 3 * N * sizeof(double));
    double *least = malloc((size_t)count * sizeof(double));
    double given[NAME_PARAMETERS], X[NAME_PARAMETERS] = {0}, std[NAME_PARAMETERS];
    double whole = 1e9;
    FILE *file = fopen(argv[3], "rb");
    if (!file || fread(given, sizeof(double), NAME_PARAMETERS, file) != NAME_PARAMETERS ||
        fread(log, 24 * N, (size_t)count, file) != (size_t)count)
        return 1;
    for (long r = 0; r < repeats; r++) {
        if (BEGIN) return 2;
        for (long k = 0; k < count; k++) {
            const double *x = log + 3 * N * k;
            const double begun = now();
            if (STEP) return 3;
            const double took = now() - begun;
            least[k] = r == 0 || took < least[k] ? took : least[k];
        }
        const double begun = now();
        const int missing = READ;
        const double took = now() - begun;
        whole = took < whole ? took : whole;
        if (missing) return 4;
    }
    printf("%zu %.4f\n", bytes, whole);
#ifdef PIECES
    static NAME_least_squares_solution found;
    double first = 1e9, pieces[NAME_PARAMETERS + 1], worst = 0;
    for (long r = 0; r < repeats; r++) {
        int k = 0, left = 1;
        double begun = now();
        NAME_least_squares_begin(&found, NAME_identifier_state(state));
        double took = now() - begun;
        first = took < first ? took : first;
        while (left > 0) {
            begun = now();
            left = NAME_least_squares_proceed(&found, PIECES);
            took = now() - begun;
            pieces[k] = r == 0 || took < pieces[k] ? took : pieces[k];
            worst = r == repeats - 1 && pieces[k] > worst ? pieces[k] : worst;
            k++;
        }
    }
    printf("%.4f %.4f\n", first, worst);
#else
    printf("nan nan\n");
#endif
    for (long k = 0; k < count; k++) printf("%.4f ", least[k]);
    printf("\n");
    for (int i = 0; i < NAME_PARAMETERS; i++) printf("%.17g ", X[i]);
    return 0;
}
"""
KERNELS = ("energy_regressor", "friction_power", "momentum_regressor", "friction_torque")
WRITE = """import sys, symgen
model = symgen.derive(sys.argv[1], sys.argv[3].split(","))
symgen.write_package(symgen.generate(model, target="c"), sys.argv[2])
"""


def truth(model: Any) -> np.ndarray:
    """Return parameters whose mass matrix is positive definite for sure."""
    rng = np.random.default_rng(0)
    return np.array([0.3 + rng.random() + 5 * name.startswith("ZZ") for name in model.base.names])


def motion(model: Any, X: np.ndarray, seed: int | None) -> np.ndarray:
    """Return X, then rows [q qd tau]: noise of encoder and tachometer, 1 % of torque, or none."""
    n, t = model.robot.n, np.arange(SAMPLES)[:, None, None] / RATE
    rng = np.random.default_rng(1)
    w, a = 2 * np.pi * rng.uniform(0.2, 1.5, (6, n)), rng.uniform(0.1, 0.3, (6, n))
    angle = t * w + rng.uniform(0, 2 * np.pi, (6, n))
    q, qd = (a * np.sin(angle)).sum(1), (a * w * np.cos(angle)).sum(1)
    qdd = (-a * w**2 * np.sin(angle)).sum(1)
    tau = symgen.load(model)["inverse_dynamics"](q, qd, qdd, X)
    if seed is not None:
        rng = np.random.default_rng(seed)
        q = q + 2e-5 * rng.normal(size=q.shape)
        qd = qd + 2e-3 * rng.normal(size=qd.shape)
        tau = tau + 0.01 * np.sqrt(np.mean(tau**2, axis=0)) * rng.normal(size=tau.shape)
    return np.concatenate([X, np.hstack([q, qd, tau]).ravel()])


def built(checkout: Path, robot: str, model: str, folder: Path) -> Path:
    """Write the package that a checkout generates, and compile the driver with it."""
    environment = {**os.environ, "PYTHONPATH": str(checkout)}
    kernels = "payload" if model == "payload" else ",".join(KERNELS)
    command = [sys.executable, "-c", WRITE, robot, str(folder), kernels]
    subprocess.run(command, env=environment, cwd=checkout, check=True)
    of_model = "" if model == "energy" else f"_{model}"
    text = DRIVER.replace("HEADER", of_model).replace("MODEL", of_model).replace("NAME", robot)
    (folder / "driver.c").write_text(text)
    compiler = find_compiler()
    assert compiler is not None
    defined = [f"-DWINDOW={WINDOW}", f"-DDT={1 / RATE}"]
    if model == "payload":
        defined.append("-DLOAD")
    elif "_solution;" in (folder / f"{robot}_least_squares.h").read_text():
        defined.append("-DPIECES=4")
    sources = list(folder.glob("*.c"))
    flags = [*kernel_flags(compiler), *defined]
    subprocess.run(
        [*compiler.command, "-std=c99", "-O2", *flags, *sources, "-lm", "-o", "driver"],
        cwd=folder, check=True,
    )  # fmt: skip
    return folder / "driver"


def run(driver: Path, log: Path, repeats: int) -> dict[str, Any]:
    """Return what the driver measured."""
    command = [driver, str(SAMPLES), str(repeats), log]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    head, pieces, steps, X = done.stdout.splitlines()
    first, worst = map(float, pieces.split())
    us = np.array(steps.split(), float)
    return {
        "bytes": int(head.split()[0]), "read_us": float(head.split()[1]), "begin_us": first,
        "piece_us": worst, "median_us": float(np.median(us[SAMPLES // 10 :])),
        "worst_us": float(us[SAMPLES // 10 :].max()), "X": np.array(X.split(), float),
    }  # fmt: skip


def main() -> None:
    """Measure, print the tables and keep the figures."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--beside", type=Path)
    parser.add_argument("--robot", default="panda")
    parser.add_argument("--seeds", type=int, default=12)
    parser.add_argument("--into", type=Path, default=Path("identifier.json"))
    asked = parser.parse_args()
    derived = symgen.derive(asked.robot, (*KERNELS, "inverse_dynamics"))
    X = truth(derived)
    checkouts = {"this": Path(symgen.__file__).resolve().parents[1]}
    if asked.beside:
        checkouts["beside"] = asked.beside.resolve()
    figures: dict[str, Any] = {}
    table = Table(title=f"{asked.robot}, window {WINDOW} samples; us", box=None)
    for head in ("model", "checkout", "bytes", "median step", "worst step", "read X, std", "begin",
                 "4 pieces", "noise-free error of X", "median spread of X"):  # fmt: skip
        table.add_column(head, justify="right")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        clean = folder / "clean.bin"
        motion(derived, X, None).tofile(clean)
        for model in ("energy", "momentum"):
            drivers = {
                who: built(place, asked.robot, model, folder / f"{model}-{who}")
                for who, place in checkouts.items()
            }
            found = {who: run(driver, clean, REPEATS) for who, driver in drivers.items()}
            many: dict[str, list[np.ndarray]] = {who: [] for who in drivers}
            for seed in range(asked.seeds):
                motion(derived, X, seed).tofile(folder / "noisy.bin")
                for who, driver in drivers.items():
                    many[who].append(run(driver, folder / "noisy.bin", 1)["X"])
            spread = {who: np.std(xs, axis=0, ddof=1) for who, xs in many.items()}
            for who, row in found.items():
                error = float(np.abs(row.pop("X") / X - 1).max())
                wide = float(np.median(spread[who] / np.abs(X)))
                row |= {"noise_free_error": error, "relative_spread": wide}
                figures[f"{model}, {who}"] = row
                table.add_row(
                    model, who, f"{row['bytes']:,}", f"{row['median_us']:.2f}",
                    f"{row['worst_us']:.2f}", f"{row['read_us']:.1f}", f"{row['begin_us']:.2f}",
                    f"{row['piece_us']:.2f}", f"{error:.1e}", f"{wide:.2e}",
                )  # fmt: skip
            if len(many) == 2:
                means = {who: np.mean(xs, axis=0) for who, xs in many.items()}
                apart = np.abs(means["this"] - means["beside"]) / spread["beside"]
                ratio = spread["this"] / spread["beside"]
                figures[f"{model}, both"] = {
                    "spread_ratio": float(np.median(ratio)),
                    "means_apart_in_spreads": [float(np.median(apart)), float(apart.max())],
                }
        follower = built(checkouts["this"], asked.robot, "payload", folder / "payload")
        row = run(follower, clean, REPEATS)
        figures["payload, this"] = {
            key: row[key] for key in ("bytes", "read_us", "median_us", "worst_us")
        }
        table.add_row(
            "payload", "this", f"{row['bytes']:,}", f"{row['median_us']:.2f}",
            f"{row['worst_us']:.2f}", f"{row['read_us']:.1f}",
        )  # fmt: skip
    Console(width=170).print(table)
    print({k: v for k, v in figures.items() if k.endswith("both")})
    keep(asked.into, figures)


if __name__ == "__main__":
    main()

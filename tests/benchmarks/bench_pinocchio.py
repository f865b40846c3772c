"""ns of every kernel beside Pinocchio's C++, in one program, with the same flags.

    python tests/benchmarks/bench_pinocchio.py [FOLDER]

FOLDER keeps the objects for the next run: Pinocchio's templates take minutes of g++. Both sides are
loops over the same samples that store their outputs, -O2 -march=native, in turns; medians. Where
both compute one thing, `difference` is the largest of the first sample, relative. X has no rotors
and no friction, which Pinocchio's functions leave out, but our kernels compute them all the same.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from packages import c_files, run
from peers import LOOPS, pinocchio_headers, pinocchio_model

import symgen
from symgen.codegen.kernels import SCALARS, Kernel, regrouped
from symgen.codegen.prototypes import arguments

ROBOTS = ("panda", "puma560", "ur10e")
SAMPLES, REPEATS = 256, 41
GOALS = {"inverse_dynamics_derivatives": 4.0}
#: What all_terms computes at once.
TERMS = ("mass_matrix", "bias_torque", "gravity_torque", "jacobian", "frames")
#: Kernels whose counterpart has another name.
OTHER = {"link_jacobian": "jacobian"}
#: Outputs that are not one and the same thing: other columns, another C, U up to a constant, half
#: of M, and the Jacobian of another point.
APART = ("coriolis", "energy_regressor", "torque_regressor", "U_out", "M", "J")
FLAGS = ["-O2", "-march=native"]
MAIN = """
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
HEADERS
SIZES
void begin(void);
void joint(size_t parent, const double *R, const double *p, const double *body);
void end(const double *g);
DECLARED
static double ours[N * 2000], theirs[N * 2000];
static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e9 + (double)t.tv_nsec;
}
static int order(const void *a, const void *b)
{
    return (*(const double *)a > *(const double *)b) - (*(const double *)a < *(const double *)b);
}
static double difference(const double *a, const double *b, int size)
{
    double most = 0, norm = 1e-300;
    for (int i = 0; i < size; ++i) {
        most = fmax(most, fabs(a[i] - b[i]));
        norm = fmax(norm, fabs(b[i]));
    }
    return most / norm;
}
#define TIMED(name, our_call, their_call, compared)                       \\
    {                                                                     \\
        double a[REPEATS], b[REPEATS], worst = -1;                        \\
        for (int k = 0; k < REPEATS; ++k) {                               \\
            const double t0 = now();                                      \\
            our_call;                                                     \\
            const double t1 = now();                                      \\
            their_call;                                                   \\
            a[k] = t1 - t0;                                               \\
            b[k] = now() - t1;                                            \\
        }                                                                 \\
        qsort(a, REPEATS, sizeof *a, order);                              \\
        qsort(b, REPEATS, sizeof *b, order);                              \\
        compared;                                                         \\
        printf("%s %.1f %.1f %.1e\\n", name, a[REPEATS / 2] / N, b[REPEATS / 2] / N, worst); \\
    }
CASES
int main(void)
{
CALLS
    return 0;
}
"""


def listed(values: Any) -> str:
    """Write numbers as C does an array."""
    return "{ " + ", ".join(repr(float(v)) for v in np.ravel(values)) + " }"


def case(name: str, folder: Path, known: set[str]) -> str:
    """Write a robot's package, and the C that times it."""
    model = symgen.derive(symgen.read_robot(name), "all")
    symgen.write_package(symgen.generate(model, target="c"), folder / name)
    found = pinocchio_model(model.robot)
    assert found is not None
    _, arm = found
    standard = dict.fromkeys((p.name for p in model.base.standard), 0.0)
    lines = ["    begin();"]
    for j in range(1, arm.njoints):
        place, body = arm.jointPlacements[j], arm.inertias[j].toDynamicParameters()
        m, mx, my, mz, xx, xy, yy, xz, yz, zz = body
        values = (xx, xy, xz, yy, yz, zz, mx, my, mz, m)
        words = ("XX", "XY", "XZ", "YY", "YZ", "ZZ", "MX", "MY", "MZ", "M")
        standard |= {f"{w}{j}": float(v) for w, v in zip(words, values, strict=True)}
        parts = ", ".join(
            f"(const double[]){listed(v)}" for v in (place.rotation, place.translation, body)
        )
        lines.append(f"    joint({arm.parents[j]}, {parts});")
    lines.append(f"    end((const double[]){listed(arm.gravity.linear)});")
    X = regrouped(model.base, list(standard.values()), model.robot.values())
    draw = np.random.default_rng(3)
    state = {
        word: draw.uniform(-1, 1, (SAMPLES, model.robot.n)) for word in ("q", "qd", "third", "more")
    }
    lines += [f"    static const double {w}[] = {listed(v)};" for w, v in state.items()]
    lines.append(f"    static const double X[] = {listed(X)};")
    lines += [timed(name, k, model.robot.n, known) for k in model.kernels if k.batch]
    return f"static void case_{name}(void)\n{{\n" + "\n".join(lines) + "\n}\n"


def timed(name: str, kernel: Kernel, n: int, known: set[str]) -> str:
    """Write the calls of one kernel and of its counterpart."""
    place = {"q": "q", "qd": "qd", "qdr": "more", "X": "X", "link": str(n)}
    place |= dict.fromkeys(SCALARS, "1.0")
    outputs, at = {}, 0
    for output in kernel.outputs:
        outputs[output.name] = (at, output.size)
        at += output.size
    words = [
        f"ours + N * {outputs[a.name][0]}" if a.name in outputs else place.get(a.name, "third")
        for a in arguments(kernel, "double")
    ]
    call = f"{name}_{kernel.name}_batch(N, {', '.join(words)})"
    other = OTHER.get(kernel.name, kernel.name)
    if other not in known:
        return f'    TIMED("{name} {kernel.name}", {call}, (void)0, (void)0)'
    same = [
        f"worst = fmax(worst, difference(ours + N * {a}, theirs + {a}, {size}))"
        for word, (a, size) in outputs.items()
        if word not in APART and kernel.name not in APART
    ]
    theirs = f"{other}(N, q, qd, third, theirs)"
    return f'    TIMED("{name} {kernel.name}", {call}, {theirs}, {"; ".join(same) or "(void)0"})'


def main() -> None:
    """Build, run, print."""
    headers = pinocchio_headers()
    if isinstance(headers, str):
        sys.exit(headers)
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(sys.argv[1] if len(sys.argv) > 1 else temporary).resolve()
        folder.mkdir(exist_ok=True)
        loops = folder / "pinocchio_loops.o"
        if not loops.exists() or loops.stat().st_mtime < LOOPS.stat().st_mtime:
            run(["g++", *headers, *FLAGS, "-c", LOOPS, "-o", loops], folder)
        text = LOOPS.read_text()
        known = {line[5 : line.index(",")] for line in text.splitlines() if line[:5] == "LOOP("}
        cases = [case(name, folder, known) for name in ROBOTS]
        inputs = "size_t, const double *, const double *, const double *, double *"
        marks = {
            "HEADERS": "\n".join(f'#include "{name}/{name}.h"' for name in ROBOTS),
            "SIZES": f"enum {{ N = {SAMPLES}, REPEATS = {REPEATS} }};",
            "DECLARED": "\n".join(f"void {name}({inputs});" for name in sorted(known)),
            "CASES": "\n".join(cases),
            "CALLS": "\n".join(f"    case_{name}();" for name in ROBOTS),
        }
        program = MAIN
        for mark, content in marks.items():
            program = program.replace(mark, content, 1)
        (folder / "main.c").write_text(program)
        build = ["gcc", "-std=gnu11", *FLAGS, "-I.", "-c"]
        run([*build, "main.c", *(f for n in ROBOTS for f in c_files(folder / n))], folder)
        objects = [f"{f.stem}.o" for n in ROBOTS for f in c_files(folder / n)]
        run(["g++", "main.o", *objects, loops, "-lm", "-o", "program"], folder)
        printed = subprocess.run([folder / "program"], capture_output=True, text=True, check=True)
    taken: dict[tuple[str, str], float] = {}
    print(f"{'robot':8} {'kernel':30} {'ns':>8} {'Pinocchio':>9} {'ratio':>6} difference")
    for line in printed.stdout.splitlines():
        robot, kernel, ours, theirs, worst = line.split()
        ratio = float(theirs) / float(ours)
        taken[robot, kernel] = float(ours)
        there = OTHER.get(kernel, kernel) in known
        end = f"{theirs:>9} {ratio:6.1f}" if there else f"{'-':>9} {'-':>6}"
        goal = GOALS.get(kernel)
        said = "" if goal is None else f" goal {goal:g}: {'met' if ratio >= goal else 'missed'}"
        print(f"{robot:8} {kernel:30} {ours:>8} {end} {worst if worst[0] != '-' else '':9}{said}")
    for name in ROBOTS:
        apart = sum(taken[name, kernel] for kernel in TERMS)
        print(
            f"{name}: all_terms {apart / taken[name, 'all_terms']:.2f} times faster than its five"
        )


if __name__ == "__main__":
    main()

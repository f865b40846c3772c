"""ns of every kernel beside Pinocchio's C++, in one program, with the same flags.

    python tests/benchmarks/bench_pinocchio.py [--robots panda,puma560,ur10e] [--kernels LIST]

Pinocchio's templates take minutes of g++, once: objects are kept in the cache folder, and only
those of the kernels asked for are compiled. Both sides are loops over the same samples that store
their outputs, -O2 -march=native -fPIC, in turns; medians. Where both compute one thing,
`difference` is the largest of the first sample, relative. X has no rotors and no friction, which
Pinocchio's functions leave out, but our kernels compute them all the same. Derivatives stand beside
CasADi's AD of our own inverse or forward dynamics, too, as C with these flags.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from packages import c_files, run
from peers import base_of, casadi_slopes, loops, pinocchio_model, pinocchio_objects

import symgen
from symgen.codegen.kernel import SCALARS, Kernel

ROBOTS = ("panda", "puma560", "ur10e")
SAMPLES, REPEATS = 256, 41
GOALS = {"inverse_dynamics_derivatives": 4.0}
#: Kernels whose counterpart has another name.
OTHER = {"link_jacobian": "jacobian"}
#: Outputs that are not one and the same thing: other columns, another C, U up to a constant, half
#: of M, and the Jacobian of another point.
APART = ("coriolis", "energy_regressor", "torque_regressor", "U_out", "M", "J")
FLAGS = ("-O2", "-march=native", "-fPIC")
#: Kernels beside CasADi's AD of another one.
SLOPES = {f"{name}_derivatives": name for name in ("inverse_dynamics", "forward_dynamics")}
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
static double ours[N * 2000], theirs[N * 2000], slopes[N * 2000];
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
#define TIMED(name, our_call, their_call, ad_call, compared)              \\
    {                                                                     \\
        double a[REPEATS], b[REPEATS], c[REPEATS], worst = -1;            \\
        for (int k = 0; k < REPEATS; ++k) {                               \\
            const double t0 = now();                                      \\
            our_call;                                                     \\
            const double t1 = now();                                      \\
            their_call;                                                   \\
            a[k] = t1 - t0;                                               \\
            const double t2 = now();                                      \\
            b[k] = t2 - t1;                                               \\
            ad_call;                                                      \\
            c[k] = now() - t2;                                            \\
        }                                                                 \\
        qsort(a, REPEATS, sizeof *a, order);                              \\
        qsort(b, REPEATS, sizeof *b, order);                              \\
        qsort(c, REPEATS, sizeof *c, order);                              \\
        compared;                                                         \\
        printf("%s %.1f %.1f %.1f %.1e\\n", name, a[REPEATS / 2] / N, b[REPEATS / 2] / N, \\
            c[REPEATS / 2] / N, worst);                                   \\
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


def case(name: str, kernels: tuple[str, ...] | str, folder: Path, known: set[str]) -> str:
    """Write a robot's package, CasADi's C beside it, and the C that times them."""
    model = symgen.derive(symgen.read_robot(name), kernels)
    symgen.write_package(symgen.generate(model, target="c"), folder / name)
    timed_kernels = [k for k in model.kernels if k.batch]
    for kernel in {k.name for k in timed_kernels} & SLOPES.keys():
        plain = symgen.derive(model.robot, (SLOPES[kernel],))
        slopes = casadi_slopes(plain, SLOPES[kernel], f"ad_{name}_{kernel}")
        (folder / f"ad_{name}_{kernel}.c").write_text(slopes)
    found = pinocchio_model(model.robot)
    assert found is not None
    _, arm = found
    lines = ["    begin();"]
    for j in range(1, arm.njoints):
        place, body = arm.jointPlacements[j], arm.inertias[j].toDynamicParameters()
        parts = ", ".join(
            f"(const double[]){listed(v)}" for v in (place.rotation, place.translation, body)
        )
        lines.append(f"    joint({arm.parents[j]}, {parts});")
    lines.append(f"    end((const double[]){listed(arm.gravity.linear)});")
    X = base_of(model, arm)
    draw = np.random.default_rng(3)
    state = {
        word: draw.uniform(-1, 1, (SAMPLES, model.robot.n)) for word in ("q", "qd", "third", "more")
    }
    lines += [f"    static const double {w}[] = {listed(v)};" for w, v in state.items()]
    lines.append(f"    static const double X[] = {listed(X)};")
    lines += [timed(name, k, model.robot.n, known) for k in timed_kernels]
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
        for a in kernel.arguments
    ]
    call = f"{name}_{kernel.name}_batch(N, {', '.join(words)})"
    other = OTHER.get(kernel.name, kernel.name)
    slopes = "(void)0"
    if kernel.name in SLOPES:
        slopes = f"ad_{name}_{kernel.name}_loop(N, q, qd, third, X, slopes)"
    if other not in known:
        return f'    TIMED("{name} {kernel.name}", {call}, (void)0, {slopes}, (void)0)'
    same = [
        f"worst = fmax(worst, difference(ours + N * {a}, theirs + {a}, {size}))"
        for word, (a, size) in outputs.items()
        if word not in APART and kernel.name not in APART
    ]
    theirs = f"{other}(N, q, qd, third, theirs)"
    compared = "; ".join(same) or "(void)0"
    return f'    TIMED("{name} {kernel.name}", {call}, {theirs}, {slopes}, {compared})'


def main() -> None:
    """Build, run, print."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--robots", default=",".join(ROBOTS))
    parser.add_argument("--kernels", default="all")
    asked = parser.parse_args()
    robots, listed_kernels = asked.robots.split(","), asked.kernels
    kernels = "all" if listed_kernels == "all" else tuple(listed_kernels.split(","))
    wanted = {OTHER.get(k, k) for k in kernels} if isinstance(kernels, tuple) else loops().keys()
    known = loops().keys() & wanted
    objects = pinocchio_objects(known, FLAGS)
    if isinstance(objects, str):
        sys.exit(objects)
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        cases = [case(name, kernels, folder, known) for name in robots]
        slopes = sorted(folder.glob("ad_*.c"))
        inputs = "size_t, const double *, const double *, const double *, double *"
        more = inputs.replace(", double", ", const double *, double")
        declared = [f"void {name}({inputs});" for name in sorted(known)]
        declared += [f"void {file.stem}_loop({more});" for file in slopes]
        marks = {
            "HEADERS": "\n".join(f'#include "{name}/{name}.h"' for name in robots),
            "SIZES": f"enum {{ N = {SAMPLES}, REPEATS = {REPEATS} }};",
            "DECLARED": "\n".join(declared),
            "CASES": "\n".join(cases),
            "CALLS": "\n".join(f"    case_{name}();" for name in robots),
        }
        program = MAIN
        for mark, content in marks.items():
            program = program.replace(mark, content, 1)
        (folder / "main.c").write_text(program)
        sources = [f for n in robots for f in c_files(folder / n)]
        run(["gcc", "-std=gnu11", *FLAGS, "-I.", "-c", "main.c", *slopes, *sources], folder)
        run(["g++", *sorted(folder.glob("*.o")), *objects, "-lm", "-o", "program"], folder)
        printed = run([folder / "program"], folder)
    heads = ("ns", "Pinocchio", "ratio", "AD", "ratio")
    print(f"{'robot':8} {'kernel':30} " + " ".join(f"{head:>9}" for head in heads) + " difference")
    for line in printed.splitlines():
        robot, kernel, ours, theirs, slope, worst = line.split()
        cells = [ours, *beside(theirs, ours, OTHER.get(kernel, kernel) in known)]
        cells += beside(slope, ours, kernel in SLOPES)
        goal, ratio = GOALS.get(kernel), float(theirs) / float(ours)
        said = "" if goal is None else f" goal {goal:g}: {'met' if ratio >= goal else 'missed'}"
        end = worst if worst[0] != "-" else ""
        print(f"{robot:8} {kernel:30} " + " ".join(f"{c:>9}" for c in cells) + f" {end:9}{said}")


def beside(theirs: str, ours: str, there: bool) -> list[str]:
    """Return the cells of another way: ns, and its ratio to ours."""
    return [theirs, f"{float(theirs) / float(ours):.1f}"] if there else ["-", "-"]


if __name__ == "__main__":
    main()

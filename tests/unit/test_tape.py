"""The tape: whoever runs it gets the same numbers, and the counts are those of the printed C."""

from __future__ import annotations

import ctypes
import random
import re
import shutil
import subprocess
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

import symgen
from symgen.codegen.backends.casadi import casadi_functions
from symgen.codegen.c_printer import Printer
from symgen.codegen.kernel import Kernel, Output
from symgen.errors import SymgenError
from symgen.symbolic.energy import energy_tape
from symgen.symbolic.friction import friction_power_tape, friction_torque_tape
from symgen.symbolic.tape import Numbers, Tape, TapeBuilder, terms

CC = shutil.which("cc")
COUNT = 20
LENGTH = sp.Symbol("L1", real=True)
VALUES = {LENGTH: sp.Rational("0.35")}
NUMPY = Numbers(
    VALUES, {"sin": np.sin, "cos": np.cos, "abs": np.abs, "tanh": np.tanh, "sign": np.sign}
)
SYMBOLS = tuple(sp.Symbol(name, real=True) for name in ("q1", "q2", "q3", "qd1", "qd2", "qd3"))
INPUTS = [("q", SYMBOLS[:3]), ("qd", SYMBOLS[3:])]
CONSTANTS = (
    LENGTH,
    sp.sqrt(2) / 2,
    sp.Rational(1, 3),
    -sp.pi / 5,
    2 * LENGTH + 1,
    sp.cos(sp.pi / 5),
)
COUPLED = """
[robot]
name = "coupled"
[geometry]
L1 = 0.35
[[joint]]
coulomb_width = 0.01
friction = ["coulomb", "viscous", "offset"]
[[joint]]
d = "L1"
theta = 0.4
[[joint]]
sigma = 1
alpha = "pi/3"
[[coupling]]
joints = [1, 2]
ratio = "-L1/2"
[payload]
joint = 3
"""


@cache
def random_tape(seed: int) -> Tape:
    """Draw a tape: sums of products, squares, numbers, functions; dead steps and equal names."""
    rng = random.Random(f"tape {seed}")
    builder = TapeBuilder({"L1", *(s.name for s in SYMBOLS)})
    known: list[sp.Expr] = list(SYMBOLS)
    known += [builder.constant(f"c{i}", rng.choice(CONSTANTS)) for i in range(3)]

    def product() -> sp.Expr:
        factors = [rng.choice(known) for _ in range(rng.randint(1, 3))]
        number = rng.choice((1, 1, -1, -1, 2, sp.Rational(1, 2), sp.Rational(-3, 7)))
        if rng.random() < 0.2:
            factors.append(rng.choice(known) ** 2)
        if rng.random() < 0.2:
            factors.append(rng.choice(known) - rng.choice(known))
        return number * sp.Mul(*factors)

    for _ in range(rng.randint(5, 25)):
        draw = rng.random()
        if draw < 0.2:
            expr = rng.choice((sp.sin, sp.cos, sp.tanh, sp.Abs))(rng.choice(known))
        elif draw < 0.3:
            angle = sp.Add(*rng.sample(SYMBOLS, 2))
            expr = rng.choice((sp.sin, sp.cos))(angle)
        else:
            expr = sp.Add(*(product() for _ in range(rng.randint(1, 4))))
        known.append(builder.name(rng.choice("ABC"), expr))
    outputs = [rng.choice(known) for _ in range(6)] + [-known[-1], sp.S.Zero, sp.Rational(-1, 3)]
    return builder.tape(INPUTS, outputs)


def bodies(tape: Tape, own: str | None = None) -> tuple[str, ...]:
    """The lines of C of a tape."""
    kernel = Kernel("k", "", tape, (Output("out", (len(tape.outputs),)),))
    return Printer(kernel, {LENGTH: "LENGTH_1"}, VALUES, "double", own).function().body


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """All random tapes in one library, by ctypes."""
    if CC is None:
        pytest.skip("no C compiler (cc) on this machine")
    folder = tmp_path_factory.mktemp("tapes")
    header = Path(symgen.__file__).parents[1] / "templates" / "c" / "runtime" / "math.h"
    (folder / "own_math.h").write_text(header.read_text().replace("NAME", "own"))
    lines = ['#include "own_math.h"', f"#define LENGTH_1 {float(VALUES[LENGTH])!r}"]
    for seed in range(COUNT):
        for letter, own in (("f", None), ("g", "own")):
            lines.append(f"void {letter}{seed}(const double *q, const double *qd, double *out) {{")
            lines += [*bodies(random_tape(seed), own), "}"]
    (folder / "tapes.c").write_text("\n".join(lines))
    command = ["cc", "-O1", "-ffp-contract=off", "-Werror", "-shared", "-fPIC", "tapes.c"]
    done = subprocess.run(
        [*command, "-o", "tapes.so", "-lm"], cwd=folder, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return ctypes.CDLL(str(folder / "tapes.so"))


def run_numpy(tape: Tape, q: np.ndarray, qd: np.ndarray) -> np.ndarray:
    out = tape.run(NUMPY, {"q": list(q), "qd": list(qd)})
    return np.array([float(v) for v in out])


def by_substitution(tape: Tape, q: np.ndarray, qd: np.ndarray) -> np.ndarray:
    """Evaluate step by step with SymPy's own arithmetic: shares no code with `run`."""
    known = dict(zip(SYMBOLS, (sp.Float(v, 40) for v in (*q, *qd)), strict=True))
    for symbol, expr in tape.constants:
        known[symbol] = expr.subs(VALUES).evalf(40)
    for symbol, expr in tape.steps:
        known[symbol] = expr.xreplace(known).evalf(40)
    return np.array([float(sp.sympify(e).xreplace(known)) for e in tape.outputs])


def agree(found: np.ndarray, expected: np.ndarray, tape: Tape) -> None:
    # Products of tapes grow without bound: only their size sets what rounding can do.
    scale = max(1.0, np.abs(expected).max())
    assert found.shape == expected.shape == (len(tape.outputs),)
    np.testing.assert_allclose(found / scale, expected / scale, rtol=0, atol=1e-11)


def point(seed: int) -> tuple[np.ndarray, np.ndarray]:
    draw = np.random.default_rng(seed)
    return draw.uniform(-1.5, 1.5, 3), draw.uniform(-1.5, 1.5, 3)


# Values.


def test_numpy_run_agrees_with_sympy_substitution_with_40_digits():
    for seed in range(COUNT):
        tape, (q, qd) = random_tape(seed), point(seed)
        agree(run_numpy(tape, q, qd), by_substitution(tape, q, qd), tape)


def test_c_gives_what_numpy_gives(compiled):
    for seed in range(COUNT):
        tape, (q, qd) = random_tape(seed), point(seed)
        for letter in "fg":  # with the sine and cosine of libm, and the packages' own
            out = np.full(len(tape.outputs), np.nan)
            pointers = [a.ctypes.data_as(ctypes.c_void_p) for a in (q, qd, out)]
            getattr(compiled, f"{letter}{seed}")(*pointers)
            agree(out, run_numpy(tape, q, qd), tape)


def test_casadi_gives_what_numpy_gives():
    for seed in range(COUNT):
        tape, (q, qd) = random_tape(seed), point(seed)
        kernel = Kernel("k", "", tape, (Output("out", (len(tape.outputs),)),))
        function = casadi_functions("tape", symgen.parse_robot(COUPLED), [kernel])["k"]()
        agree(np.array(function(q, qd)).ravel(), run_numpy(tape, q, qd), tape)


def test_terms_multiply_and_add_up_to_the_expression():
    for seed in range(COUNT):
        tape = random_tape(seed)
        for _, expr in tape.steps:
            if expr.is_Function:
                continue
            total = sum((-1 if n else 1) * sp.Mul(*f) for n, f in terms(expr, tape.order))
            assert sp.expand(total - expr) == 0


def test_a_tape_refuses_powers_that_are_no_squares():
    x = SYMBOLS[0]
    for expr in (x**-2, sp.sqrt(sp.Abs(x) + 1), x ** sp.Rational(3, 2)):
        with pytest.raises(SymgenError):
            terms(expr, {x: 0})


# Pruning.


def test_keep_changes_no_value_and_leaves_no_dead_step():
    rng = random.Random(1)
    pruned = 0
    for seed in range(COUNT):
        tape, (q, qd) = random_tape(seed), point(seed)
        whole = run_numpy(tape, q, qd)
        indices = [rng.randrange(len(tape.outputs)) for _ in range(rng.randint(0, 3))]
        part = tape.keep(indices)
        np.testing.assert_array_equal(run_numpy(part, q, qd), whole[indices])
        pruned += len(tape.steps) - len(part.steps)
        for kept in (tape, part):
            used = {s for e in kept.outputs for s in e.free_symbols}
            used |= {s for _, e in kept.steps for s in e.free_symbols}
            assert {s for s, _ in (*kept.steps, *kept.constants)} <= used
        assert part.inputs == tape.inputs
        assert [s for s, _ in part.steps] == [s for s, _ in tape.steps if s in dict(part.steps)]
    assert pruned > COUNT


# Operation counts.


def counted(lines: tuple[str, ...]) -> dict[str, int]:
    """Count the operations in lines of C by their text alone."""
    text = "\n".join(line.split("=", 1)[1] for line in lines if "=" in line)
    text = re.sub(r"(\w+)\[(\d+)\]", r"\1_\2", text)  # an indexed array is one operand
    text = re.sub(r"(\d)e[+-](\d)", r"\1e\2", text)  # the sign of an exponent is no operation
    angles = re.findall(r"\b(?:sin|cos)\(([^()]*)\)", text)
    text = re.sub(r"\b(?:sin|cos)\([^()]*\)", "x", text)
    own = [int(n) for n in re.findall(r"_sincos(\d)\(", text)]
    text = re.sub(r"\b\w+_sincos\d\([^()]*\)", "x", text)  # q + 1 there is an address

    def sums(part: str) -> int:
        return len(re.findall(r"(?<=[\w)]) [+-] ", part))

    return {
        "mul": text.count("*"),
        "add": sums(text) + sum(sums(a) for a in set(angles)),
        "div": text.count("/"),
        "sincos": len(set(angles)) + sum(own),
        "other": len(re.findall(r"\b(?:fabs|tanh)\(", text)),
    }


def test_operation_counts_are_those_of_the_generated_files():
    tree = symgen.generate(symgen.derive(symgen.parse_robot(COUPLED)), target="c")
    assert tree.files["coupled_energy_regressor.c"].count(b"_sincos") > 0
    for name in ("energy_regressor", "friction_power"):
        text = tree.files[f"coupled_{name}.c"].decode()
        header = re.search(r"\* ([^*\n]+) for one sample", text)
        assert header is not None
        said = {key: int(n) for n, key in re.findall(r"(\d+) (\w+)", header[1])}
        body = re.search(r"\n\{\n(.*?)\n\}", text, re.DOTALL)
        assert body is not None
        found = counted(tuple(body[1].splitlines()))
        assert {k: v for k, v in found.items() if v} == said


# Names.


def tapes_of(robot: symgen.Robot) -> tuple[Tape, ...]:
    return energy_tape(robot), friction_power_tape(robot), friction_torque_tape(robot)


def test_names_never_clash_with_named_lengths():
    # Every name that the derivation gives to a step becomes the name of a length.
    plain = symgen.parse_robot(COUPLED)
    reserved = re.compile(r"(q|qd|u|ratio)\d+")
    taken = sorted(
        {s.name for t in tapes_of(plain) for s in t.order} - {s.name for s in plain.values()}
    )
    taken = [name for name in taken if not reserved.fullmatch(name)]
    geometry = "".join(f"{name} = 0.1\n" for name in taken)
    awkward = symgen.parse_robot(COUPLED.replace("[geometry]\n", f"[geometry]\n{geometry}"))
    lengths = {s.name for s in awkward.values()}
    assert {"C2", "W32", "V31d2", "t2"} & lengths
    for before, after in zip(tapes_of(plain), tapes_of(awkward), strict=True):
        assert len(after.order) == len({s.name for s in after.order}) == len(before.order)
        assert not lengths.intersection(s.name for s, _ in after.steps)
        assert after.operations == before.operations


def test_equal_and_opposite_expressions_share_one_step():
    builder = TapeBuilder()
    x, y = SYMBOLS[:2]
    first = builder.name("A", x - x * y)
    assert builder.name("B", x - x * y) == first
    assert builder.name("C", x * y - x) == -first
    assert builder.name("D", -x) == -x
    assert builder.name("E", sp.Rational(2)) == 2
    assert len(builder.tape(INPUTS, [first]).steps) == 1

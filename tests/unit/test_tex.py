"""The LaTeX document: its closed forms are the models, its names are valid, it compiles."""

from __future__ import annotations

import json
import os
import random
import re
import shutil
import subprocess
import sys
import warnings
from functools import cache

import numpy as np
import pytest
import sympy as sp
from oracles import planar2r
from oracles.special_arms import FAMILIES, special_arm
from support import PROJECT, sampled

import symgen
from symgen.codegen.closed_form import closed_form
from symgen.codegen.formula import Call, Formula, step
from symgen.codegen.tex import Words, tex_document
from symgen.codegen.verification import evaluate
from symgen.symbolic.trigonometric import Trigonometric

SPATIAL = """
[robot]
name = "spatial"
[geometry]
D3 = 0.4
[[joint]]
[[joint]]
alpha = "pi/2"
[[joint]]
d = "D3"
"""
PLANAR = """
[robot]
name = "planar_3"
gravity = [0.0, -9.81, 0.0]
[geometry]
L1 = 0.4
L2 = 0.3
[[joint]]
friction = ["coulomb", "viscous", "offset"]
[[joint]]
d = "L1"
coulomb_width = 0.05
[[joint]]
d = "L2"
"""
# Tree, prismatic and fixed joints, radicals, named and general angles, a coupling and a payload.
RICH = """
[robot]
name = "rich"
gravity = [1.5, 0.0, -9.81]
[geometry]
L1 = 0.4
tilt = 0.3
W_13 = 0.2
[[joint]]
friction = ["coulomb", "viscous", "offset"]
[[joint]]
alpha = "pi/2 + tilt"
d = "L1"
coulomb_width = 0.05
[[joint]]
sigma = 1
alpha = "-pi/2"
r = "L1/3 + W_13"
[[joint]]
sigma = 2
antecedent = 1
gamma = 0.7
d = "sqrt(2)*L1"
[[joint]]
theta = "pi/3"
[[coupling]]
joints = [1, 2]
ratio = "-L1"
[payload]
joint = 5
"""
TEXTS = {"spatial": SPATIAL, "planar_3": PLANAR, "rich": RICH}
KERNELS = ("energy_regressor", "friction_torque", "inverse_dynamics", "mass_matrix", "coriolis",
           "gravity_torque")  # fmt: skip
ENGINE = next(filter(shutil.which, ("pdflatex", "lualatex", "xelatex", "tectonic")), None)


@cache
def model(name: str) -> symgen.Model:
    text = TEXTS.get(name)
    robot = symgen.read_robot(name) if text is None else symgen.parse_robot(text)
    return symgen.derive(robot, "all")


@cache
def document(name: str) -> str:
    m = model(name)
    return tex_document(m.robot, m.base, m.kernels)


def expression(base: sp.Symbol | Call | Formula) -> sp.Expr:
    """A formula in SymPy."""
    if isinstance(base, Formula):
        return sp.Add(
            *(p.number * sp.Mul(*(expression(f.base) ** f.power for f in p.factors))
              for p in base.products)
        )  # fmt: skip
    if isinstance(base, Call):
        function = sp.Abs if base.name == "abs" else getattr(sp, base.name)
        return function(expression(base.argument))
    return base


def compare(m: symgen.Model, name: str, seed: int) -> int:
    """Compare a kernel's closed form, where it has one, with its tape in 50 digits."""
    kernel = m.kernel(name)
    forms = None if kernel is None else closed_form(kernel.tape)
    if kernel is None or forms is None:
        return 0
    draw = random.Random(seed)
    point = {a: [round(draw.uniform(-2, 2), 4) for _ in s] for a, s in kernel.tape.inputs}
    values = {s: sp.Rational(repr(v)) for a, group in kernel.tape.inputs
              for s, v in zip(group, point[a], strict=True)} | m.robot.values()  # fmt: skip
    expected = evaluate(kernel, m, point, 50)
    assert len(forms) == len(expected)
    for form, number in zip(forms, expected, strict=True):
        found = expression(form).subs(values).evalf(50)
        assert abs(found - sp.Float(str(number), 50)) < sp.Float("1e-40"), (m.robot.name, name)
    return 1


@pytest.mark.parametrize("name", sampled(["planar2r", "scara", "emps", "spatial", "planar_3"], 2))
def test_closed_forms_of_small_arms_equal_their_tapes_in_50_digits(name):
    found = [compare(model(name), kernel, seed) for kernel in KERNELS for seed in (1, 2)]
    without_friction = {"planar2r": 2}  # planar2r has none
    assert sum(found) == len(found) - without_friction.get(name, 0)


@pytest.mark.parametrize("name", sampled(["rich", "puma560", "stanford"], 1))
def test_what_is_printed_in_closed_form_of_larger_arms_equals_the_tape(name):
    assert sum(compare(model(name), kernel, 3) for kernel in KERNELS) >= 2


@pytest.mark.parametrize("family", sampled(FAMILIES, 2))
def test_closed_forms_of_special_geometry_equal_their_tapes(family):
    found = 0
    for seed in range(2):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", symgen.SymgenWarning)
            m = symgen.derive(symgen.parse_robot(special_arm(family, seed).text), KERNELS)
        found += sum(compare(m, kernel, seed) for kernel in KERNELS)
    assert found >= 2


def numbers(kernel: str, *arrays: np.ndarray) -> np.ndarray:
    """The closed form of a kernel of planar2r, in floats."""
    k = model("planar2r").kernel(kernel)
    forms = closed_form(k.tape)
    symbols = [s for _, group in k.tape.inputs for s in group] + list(
        model("planar2r").robot.values()
    )
    function = sp.lambdify(symbols, [expression(f) for f in forms], "numpy")
    return np.array(function(*np.concatenate(arrays), 0.5), dtype=float)


def test_planar2r_is_the_textbooks():
    draw = np.random.default_rng(1)
    for _ in range(5):
        q, qd, qdd = draw.uniform(-2, 2, (3, 2))
        X = draw.uniform(0.1, 1, 4)
        expected = {
            "energy_regressor": (planar2r.energy_regressor(q, qd, 0.5), (q, qd)),
            "inverse_dynamics": (planar2r.inverse_dynamics(q, qd, qdd, X, 0.5), (q, qd, qdd, X)),
            "mass_matrix": (planar2r.mass_matrix(q, X, 0.5), (q, X)),
            "coriolis": (planar2r.coriolis(q, qd, X, 0.5), (q, qd, X)),
        }
        for kernel, (value, arrays) in expected.items():
            np.testing.assert_allclose(numbers(kernel, *arrays), value.ravel(), atol=1e-12)


TEXTBOOK = r"""
ZZ_{1R} &= ZZ_1 + L_1^2 M_2
h_{ZZ_2} &= \tfrac{1}{2} (\dot q_1 + \dot q_2)^2 \\
h_{MX_2} &= L_1 \dot q_1 (\dot q_1 + \dot q_2) \cos(q_2) \\
\tau_2 &= ZZ_2 (\ddot q_1 + \ddot q_2) + L_1 \, MX_2 (\ddot q_1 \cos(q_2) + \dot q_1^2 \sin(q_2))
M_{11} &= ZZ_{1R} + ZZ_2 + 2 L_1 \, MX_2 \cos(q_2) - 2 L_1 \, MY_2 \sin(q_2) \\
M_{12} &= ZZ_2 + L_1 \, MX_2 \cos(q_2) - L_1 \, MY_2 \sin(q_2) \\
M_{22} &= ZZ_2
C_{21} &= L_1 \, MX_2 \dot q_1 \sin(q_2) + L_1 \, MY_2 \dot q_1 \cos(q_2) \\
C_{22} &= 0
Q_1 &= Q_2 = 0
2 & 0 & 1 & $0$ & $0$ & $0$ & $L_1$ & $q_2$ & $0$ \\
"""


@pytest.mark.parametrize("line", TEXTBOOK.strip().splitlines())
def test_planar2r_is_printed_as_in_a_textbook(line):
    assert line in document("planar2r")


def test_squares_and_products_of_cosines_are_those_of_a_textbook():
    text = document("spatial")
    assert r"XX_{2R} \sin^2(q_2)" in text
    assert r"2 D_3 \, MX_3 \cos(q_2) \cos(q_2 + q_3)" in text
    assert r"ZZ_{1R} &= ZZ_1 + Ia_1 + YY_2 + YY_3 + D_3^2 M_3" in text


def test_equal_functions_are_equal_sums():
    a = Trigonometric(10_000)
    p, q = (a.variable(sp.Symbol(n, real=True)) for n in "pq")
    one = a.constant(sp.S.One)
    s, c, t, d = (a.function(f, v) for v in (p, q) for f in ("sin", "cos"))
    assert a.add(a.mul(s, s), a.mul(c, c)) == one
    assert a.sub(a.mul(s, d), a.mul(c, t)) == a.function("sin", a.sub(p, q))
    assert a.add(a.mul(c, d), a.mul(s, t)) == a.function("cos", a.sub(q, p))
    whole, third = sp.Symbol("p", real=True), sp.Symbol("q", real=True) / 3
    for turned in (sp.sin(whole - third), sp.cos(whole + 2 * third)):
        assert a.expression(a.constant(turned)) == turned
    root = a.constant(sp.sqrt(2))
    assert a.reduced(a.mul(root, root)) == a.constant(sp.Integer(2))


def test_a_larger_arm_has_every_step_of_its_tapes_in_order():
    m, text = model("puma560"), document("puma560")
    at = 0
    for name in ("energy_regressor", "inverse_dynamics", "mass_matrix"):
        tape = m.kernel(name).tape
        words = Words(m.robot, m.base)
        for symbol, expr in tape.steps:
            line = "\n".join(words.rows(words[symbol.name], step(expr, tape.order))[:1])
            at = text.index(line, at) + 1
    assert r"\subsection{Coriolis" not in text


def test_two_symbols_never_look_the_same_and_underscores_are_escaped():
    names = ["W13", "W1_3", "W_13", "W13_", "W13__", "Ns1_2_3", "Ns12_3", "alpha", "_a", "a_",
             "IA1", "Ia1", "Ia_1", "FS1", "theta3", "x", "q5", "qd1",
             "X_ZZ1", "X_ZZ1R"]  # fmt: skip
    words = Words(model("rich").robot, model("rich").base)
    written = [words[name] for name in names]
    assert len(set(written)) == len(written)
    assert words["W13"] != words["W_13"] == "W_{13}"
    assert words["q5"] == "q_5"
    assert words["qd1"] == r"\dot q_1"
    assert words["X_ZZ1R"] == "ZZ_{1R}"
    assert words["Ns1_2_3"] == r"\mathit{Ns}_{1,2,3}"
    assert words["_a"] == r"\mathit{\_a}"
    for word in written:
        assert re.fullmatch(
            r"(\\[a-z]+(\{(\\_|[A-Za-z])+\})?\s?q?|[A-Za-z]+)'*(_\w|_\{[\w,]+\})?", word
        )


def width(tex: str) -> float:
    """Estimate how wide a formula is set, em; rather too wide than too narrow."""
    total, small = 0.0, [1.0]
    script = 1.0
    for token in re.findall(r"\\[A-Za-z]+|\\.|\S", tex):
        if token == "{":
            small.append(small[-1] * script)
        elif token == "}":
            small.pop()
        elif token in "^_":
            script = 0.72
            continue
        else:
            total += _WIDTHS.get(token, 0.8 if token.isupper() else 0.55) * small[-1] * script
        script = 1.0
    return total


LINE = 47.0  # em: what the template sets
_WIDTHS = {"+": 1.3, "-": 1.3, "=": 1.4, "(": 0.4, ")": 0.4, "[": 0.3, "]": 0.3, ",": 0.3,
           "'": 0.3, ".": 0.3, "m": 0.9, "w": 0.75, r"\,": 0.2, r"\dot": 0.0, r"\ddot": 0.0,
           r"\sin": 1.4, r"\cos": 1.5, r"\tan": 1.6, r"\tanh": 2.1, r"\exp": 1.7, r"\mathit": 0.0,
           r"\operatorname": 0.0, r"\frac": 0.3, r"\tfrac": 0.3, r"\sqrt": 0.9, r"\cdot": 0.8,
           r"\lvert": 0.3, r"\rvert": 0.3, r"\_": 0.5, r"\quad": 1.0, "&": 0.0}  # fmt: skip


@pytest.mark.parametrize(
    "name", sampled(["planar2r", "scara", "puma560", "panda", "rich"], 1, always=["rich"])
)
def test_no_line_is_wider_than_the_page(name):
    rows = re.findall(r"^(.*?&.*?)(?: \\\\)?$", document(name).split(r"\section{Models}")[1], re.M)
    assert rows
    assert max(map(width, rows)) <= LINE


@pytest.mark.skipif(ENGINE is None, reason="no TeX engine (pdflatex, ...) on this machine")
@pytest.mark.parametrize(
    "name", sampled(["planar2r", "scara", "spatial", "rich", "puma560"], 1, always=["rich"])
)
def test_the_document_compiles_and_nothing_runs_out_of_the_page(name, tmp_path):
    (tmp_path / "model.tex").write_text(document(name), "utf-8")
    options = (
        ["--keep-logs"] if ENGINE == "tectonic" else ["-interaction=nonstopmode", "-halt-on-error"]
    )
    done = subprocess.run([ENGINE, *options, "model.tex"], cwd=tmp_path, capture_output=True)
    assert done.returncode == 0, done.stdout[-2000:]
    log = (tmp_path / "model.log").read_text("utf-8", errors="replace")
    assert "Overfull" not in log
    assert "LaTeX Warning" not in log.replace("LaTeX Warning: Label(s) may have changed", "")


def test_the_bytes_do_not_depend_on_the_hash_seed():
    code = (
        "import sys, symgen; from symgen.codegen.tex import tex_document\n"
        "m = symgen.derive(symgen.parse_robot(sys.stdin.read()), 'all')\n"
        "sys.stdout.buffer.write(tex_document(m.robot, m.base, m.kernels).encode())"
    )
    out = {
        subprocess.run(
            [sys.executable, "-c", code], input=PLANAR.encode(), capture_output=True, check=True,
            cwd=PROJECT, env={**os.environ, "PYTHONHASHSEED": seed},
        ).stdout
        for seed in ("1", "2")
    }  # fmt: skip
    assert out == {document("planar_3").encode()}


def test_a_package_has_the_document_only_when_asked_and_check_compares_it(tmp_path, monkeypatch):
    monkeypatch.setenv("SYMGEN_CC", "none")
    plain = symgen.generate(model("planar2r"), target="c")
    tree = symgen.generate(model("planar2r"), target="c", tex=True)
    assert "planar2r.tex" not in plain.files
    assert "tex" not in json.loads(plain.files["manifest.json"])["options"]
    others = set(tree.files) - {"planar2r.tex", "manifest.json"}
    assert {f: tree.files[f] for f in others} == {f: plain.files[f] for f in others}
    symgen.write_package(tree, tmp_path / "p")
    (result,) = symgen.check(tmp_path / "p")
    assert result.differences == ()
    path = tmp_path / "p" / "planar2r.tex"
    path.write_text(path.read_text().replace("ZZ_2", "ZZ_3", 1))
    (result,) = symgen.check(tmp_path / "p")
    assert [d.split(":")[0] for d in result.differences] == ["planar2r.tex"]


def test_the_document_has_the_kernels_of_the_package_only():
    tree = symgen.generate(model("scara"), target="c", kernels=("mass_matrix",), tex=True)
    text = tree.files["scara.tex"].decode()
    assert re.findall(r"\\subsection\{(.*)\}", text) == ["Mass matrix"]

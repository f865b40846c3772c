r"""Write the model of a robot as a LaTeX document: tables, parameters and formulas.

A kernel with a short closed form is printed in closed form, any other as the steps of its tape.
Rows break at sums: the text of a formula has a line break before each term of the outermost sum,
where a row may end, and a tab before terms of inner sums, where a long term may break.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Any

import sympy as sp

from symgen import names
from symgen.codegen.closed_form import closed_form
from symgen.codegen.formula import Call, Factor, Formula, Product, geometric, step
from symgen.codegen.kernels import Kernel
from symgen.files import rendered
from symgen.robot.expressions import text
from symgen.robot.types import Joint, Robot, joint_variable, require_gravity
from symgen.symbolic.base_parameters import BaseParameter, BaseParameters, bound
from symgen.symbolic.friction import torque_tape
from symgen.symbolic.kinematics import variables
from symgen.symbolic.tape import Tape, real_symbol

#: Kernels in the document: title and text.
_SECTIONS = {
    "energy_regressor": ("Energy regressor", "Columns $h(q, \\dot q)$ of the energy:"),
    "inverse_dynamics": ("Torques", "Torques of a motion, friction included:"),
    "mass_matrix": ("Mass matrix", "Entries $M_{jk} = M_{kj}$:"),
    "coriolis": ("Coriolis matrix", "With $\\dot M - 2 C$ skew-symmetric:"),
    "gravity_torque": ("Gravity", "Torques that hold the arm at rest:"),
}
_CLOSED_ONLY = "coriolis"  # its steps are not printed
_LETTERS = 66  # most characters in a row of the template
_SILENT = re.compile(r"\\(d?dot|mathit|t?frac|operatorname|[lr]vert|qquad|quad|,)|[\\{}^_& ]")
_GREEK = frozenset(
    "alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi rho sigma tau phi "
    "chi psi omega".split()
)
_PREFIXES = (*names.LINK, names.ROTOR, names.COUPLING_INERTIA, *names.FRICTION.values(),
             *names.COUPLING_FRICTION)  # fmt: skip
_PARAMETER = re.compile(rf"({'|'.join(sorted(_PREFIXES, key=len, reverse=True))})(\d+|L)(R?)")
_VARIABLE = {"q": "q", "qd": r"\dot q", "qdd": r"\ddot q", "tau": r"\tau"}
_FUNCTIONS = {"log": "ln", "sign": "operatorname{sign}"}


def tex_document(robot: Robot, base: BaseParameters, kernels: Sequence[Kernel]) -> str:
    """Return a model as a LaTeX document (article, amsmath, booktabs).

    Args:
        robot: the mechanism.
        base: its base parameters.
        kernels: kernels whose formulas may be printed.

    Raises:
        RobotError: gravity is an input.
    """
    require_gravity(robot, "a LaTeX document")
    return rendered("tex/model.tex", **_Document(robot, base).data(kernels))


def regroupings(robot: Robot, base: BaseParameters) -> str:
    """Return the formulas of the base parameters as LaTeX in dollars, for notebooks."""
    document = _Document(robot, base)
    rows = [row for p in base.parameters for row in document.regrouping(p)]
    return "$$\\begin{aligned}\n" + " \\\\\n".join(rows) + "\n\\end{aligned}$$"


class Words:
    """LaTeX of the symbols of a document; each symbol is unique."""

    def __init__(self, robot: Robot, base: BaseParameters) -> None:
        self._words: dict[str, str] = {}
        variable = variables(robot)
        for symbol in (*variable.q, *variable.qd, *variable.qdd, *variable.tau):
            letter = symbol.name.rstrip("0123456789")
            self._put(symbol.name, _VARIABLE[letter], _subscript(symbol.name[len(letter) :]))
        for name in (*(p.name for p in base.standard), *base.names):
            if f"X_{name}" not in self._words:
                self._put(f"X_{name}", *_parameter(name))
        for name, _ in robot.geometry:
            self._put(name, *_identifier(name))

    def __getitem__(self, name: str) -> str:
        """Return the LaTeX of a symbol; the first use of a step defines it."""
        if name not in self._words:
            self._put(name, *_identifier(name))
        return self._words[name]

    def _put(self, name: str, letter: str, index: str) -> None:
        while letter + index in self._words.values():
            letter += "'"
        self._words[name] = letter + index

    def rows(self, left: str, formula: Formula) -> list[str]:
        """Return `left = formula` as rows of an align."""
        return _rows(left, self.sum(formula, alone=True))

    def line(self, formula: Formula) -> str:
        """Return a formula on one line."""
        return " ".join(self.sum(formula, alone=True).split())

    def sum(self, formula: Formula, alone: bool = False) -> str:
        """Return a sum with a possible break before each term but the first."""
        single, space = alone and len(formula.products) == 1, "\n" if alone else "\t"
        out = "".join(
            f"{space}{'-' if p.number < 0 else '+'} {self.product(p, single and not p.factors)}"
            for p in formula.products
        )
        return re.sub(r"^\s(\+ |(-) )", r"\2", out) or "0"

    def product(self, product: Product, decimal: bool = False) -> str:
        """Return the absolute value of a product."""
        number = abs(product.number)
        under = [f for f in product.factors if f.power < 0]
        if number.is_Rational and (
            under or (not number.is_Integer and any(f.base is sp.pi for f in product.factors))
        ):
            over = Product(sp.Integer(number.p), tuple(f for f in product.factors if f.power > 0))
            below = Product(sp.Integer(number.q), tuple(Factor(f.base, -f.power) for f in under))
            top, bottom = (self.product(p).replace("\t", " ") for p in (over, below))
            return rf"\frac{{{top}}}{{{bottom}}}"
        out = "" if number == 1 and product.factors else _number(number, decimal)
        for factor in product.factors:
            written = self.factor(factor)
            between = " " if out else ""
            if out and written[0].isdigit():
                between = r" \cdot "
            elif out and re.match(r"[A-Za-z]{2}|\\mathit", written):
                between = r" \, "  # between symbols of several letters
            out += between + written
        return out

    def factor(self, factor: Factor) -> str:
        """Return a factor with its power."""
        base, power = factor.base, ""
        if factor.power != 1:
            power = f"^{factor.power}" if 1 < factor.power < 10 else f"^{{{factor.power}}}"
        if isinstance(base, Formula):
            left, right = "()" if base.depth == 0 else "[]"
            return f"{left}{self.sum(base)}{right}{power}"
        if not isinstance(base, Call):
            word = r"\pi" if base is sp.pi else self[base.name]
            return f"{{{word}}}{power}" if power and "'" in word else f"{word}{power}"
        argument = self.line(base.argument)
        if base.name == "sqrt":
            root = rf"\sqrt{{{argument}}}"
            return f"({root}){power}" if power else root
        if base.name == "abs":
            return rf"\lvert {argument} \rvert{power}"
        return rf"\{_FUNCTIONS.get(base.name, base.name)}{power}({argument})"


def _rows(left: str, right: str) -> list[str]:
    r"""Return `left = right` as rows of an align, each about one line long."""
    rows, row, room = [], "", _LETTERS - _letters(left)
    for term in right.split("\n"):
        for part in term.split("\t") if _letters(term) > room else [term.replace("\t", " ")]:
            if row and _letters(row) + _letters(part) > room:
                rows.append(row)
                row = ""
            row += f" {part}"
    first, *others = [*rows, row]
    return [f"{left} &={first}", *(rf"&\quad{other}" for other in others)]


def _letters(tex: str) -> int:
    return len(_SILENT.sub("", tex))


def _parameter(name: str) -> tuple[str, str]:
    """Return letter and index of a parameter: ZZ1R gives ZZ_{1R}, IA3 gives Ia_3."""
    match = _PARAMETER.fullmatch(name)
    if match is None:
        return _identifier(name)
    prefix, number, regrouped = match.groups()
    if prefix not in names.LINK:  # the literature writes Ia, Fs, Fv
        prefix = prefix.capitalize()
    return prefix, _subscript(number + regrouped)


def _identifier(name: str) -> tuple[str, str]:
    r"""Return letter and index of a step or length: Ns1_2_ gives \mathit{Ns}'_{1,2}."""
    plain = name.rstrip("_")
    match = re.fullmatch(r"(_*[A-Za-z]+)_?(.*)", plain)
    head, tail = match.groups() if match else ("", plain)
    letters = _escaped(head)
    if head in _GREEK:
        letters = rf"\{head}"
    elif len(head) > 1:
        letters = rf"\mathit{{{letters}}}"
    marks = "'" * (len(name) - len(plain))
    return letters + marks, _subscript(tail.replace("_", ",")) if tail else ""


def _subscript(index: str) -> str:
    return f"_{index}" if len(index) == 1 else f"_{{{index}}}"


def _escaped(name: str) -> str:
    return name.replace("_", r"\_")


def _number(value: sp.Expr, decimal: bool) -> str:
    """Write a positive number: parts of eight as fractions, others as in a robot file."""
    written = text(value)
    if (
        value.is_Rational
        and not value.is_Integer
        and ("/" in written or (not decimal and 8 % value.q == 0))
    ):
        return rf"\tfrac{{{value.p}}}{{{value.q}}}"
    digits, _, exponent = written.partition("e")
    return rf"{digits} \cdot 10^{{{int(exponent)}}}" if exponent else digits


class _Document:
    def __init__(self, robot: Robot, base: BaseParameters) -> None:
        self.robot, self.base, self.words = robot, base, Words(robot, base)

    def data(self, kernels: Sequence[Kernel]) -> dict[str, Any]:
        robot, base = self.robot, self.base
        written = {kernel.name: kernel for kernel in kernels}
        sections = [s for name in _SECTIONS if name in written for s in self.section(written[name])]
        return {
            "name": robot.name,
            "title": _escaped(robot.name),
            "table": [self.row(joint) for joint in robot.joints],
            "gravity": ", ".join(map(self.geometric, robot.gravity)),
            "geometry": ", ".join(
                f"${self.words[name]} = {self.geometric(value)}$" for name, value in robot.geometry
            ),
            "drives": list(self.drives()),
            "p": len(base.parameters),
            "base": ", ".join(map(self.parameter, base.names)),
            "regrouped": [row for p in base.parameters if p.terms for row in self.regrouping(p)],
            "no_effect": ", ".join(map(self.parameter, base.no_effect)),
            "proof": {
                "rank": base.proof.rank,
                "primes": " and ".join(map(str, base.proof.primes)),
                "relations": base.proof.structural_relations + base.proof.lifted_relations,
                "bound": bound(robot),
            },
            "friction": self.friction(),
            "kernels": sections,
            "recursive": any(k["recursive"] for k in sections),
        }

    def geometric(self, expr: sp.Expr) -> str:
        return self.words.line(geometric(expr))

    def parameter(self, name: str) -> str:
        return f"${self.words[f'X_{name}']}$"

    def row(self, joint: Joint) -> str:
        """Return a row of the geometry table, with the joint variable."""
        cells: list[object] = [joint.number, joint.sigma, joint.antecedent]
        for key in ("gamma", "b", "alpha", "d", "theta", "r"):
            value = getattr(joint, key)
            moving = key == {names.REVOLUTE: "theta", names.PRISMATIC: "r"}.get(joint.sigma)
            products = geometric(value + (joint.offset if moving else 0)).products
            for k, share in joint.shares if moving else ():
                variable = Factor(joint_variable(k))
                products += tuple(
                    Product(p.number, (*p.factors, variable)) for p in geometric(share).products
                )
            cells.append(f"${self.words.line(Formula(products))}$")
        return " & ".join(map(str, cells))

    def drives(self) -> Iterator[str]:
        """Describe couplings and payload, in one sentence each."""
        for c in self.robot.couplings:
            j, k = (_subscript(str(i)) for i in (c.first, c.second))
            rotor, *friction = (
                self.parameter(f"{prefix}{c.second}")
                for prefix in (names.COUPLING_INERTIA, *names.COUPLING_FRICTION)
            )
            yield (
                rf"One drive moves joints {c.first} and {c.second}: its rotor {rotor} turns at "
                rf"$u = \dot q{j} + ({self.geometric(c.ratio)})\, \dot q{k}$ and has the energy "
                rf"column $u^2/2$; its friction is {' and '.join(friction)}."
            )
        if self.robot.payload is not None:
            yield f"A payload, of index L, is fixed to link {self.robot.payload}."

    def regrouping(self, p: BaseParameter) -> list[str]:
        products = []
        for coefficient, name in ((sp.S.One, p.head), *p.terms):
            symbol, formula = Factor(real_symbol(f"X_{name}")), geometric(coefficient)
            alone = Product(sp.S.One, (Factor(formula),))
            part = formula.products[0] if len(formula.products) == 1 else alone
            products.append(Product(part.number, (*part.factors, symbol)))
        return self.words.rows(self.words[f"X_{p.name}"], Formula(tuple(products)))

    def friction(self) -> list[str]:
        """Return the friction torque of each joint."""
        tape = torque_tape(self.robot)
        first = sum(s.inertial for s in self.base.standard)
        rubbing = [s for s in self.base.standard[first:] if not s.load]
        if not rubbing:
            return []
        forms = closed_form(tape)
        out = list(self.steps(tape)) if forms is None else []
        columns = iter(forms or _stepped(tape))
        for joint in self.robot.movable:
            products = [
                Product(p.number, (Factor(real_symbol(f"X_{s.name}")), *p.factors))
                for s in rubbing
                for p in next(columns).products
            ]
            out += self.words.rows(rf"\tau_{{f,{joint.number}}}", Formula(tuple(products)))
        return out

    def section(self, kernel: Kernel) -> Iterator[dict[str, Any]]:
        """Yield the text of a kernel, if it has any."""
        forms = closed_form(kernel.tape)
        if forms is None and kernel.name == _CLOSED_ONLY:
            return
        rows = list(self.steps(kernel.tape)) if forms is None else []
        title, said = _SECTIONS[kernel.name]
        yield {
            "title": title,
            "text": said,
            "rows": rows + self.outputs(kernel, forms or _stepped(kernel.tape)),
            "recursive": forms is None,
        }

    def steps(self, tape: Tape) -> Iterator[str]:
        for symbol, value in tape.constants:
            if symbol != value:
                yield from self.words.rows(self.words[symbol.name], geometric(value))
        for symbol, expr in tape.steps:
            yield from self.words.rows(self.words[symbol.name], step(expr, tape.order))

    def outputs(self, kernel: Kernel, forms: tuple[Formula, ...]) -> list[str]:
        (output,) = kernel.outputs
        numbers = self.robot.numbers
        if output.columns:
            lefts = [f"h_{{{self.words[f'X_{name}']}}}" for name in output.columns]
        elif len(output.shape) == 1:
            letter = r"\tau" if kernel.name == "inverse_dynamics" else "Q"
            lefts = [letter + _subscript(str(j)) for j in numbers]
        else:
            comma = "," if max(numbers) > 9 else ""
            lefts = [f"{output.name}_{{{j}{comma}{k}}}" for j in numbers for k in numbers]
        kept = list(zip(lefts, forms, strict=True))
        if kernel.name == "mass_matrix":  # symmetric
            n = len(numbers)
            kept = [pair for i, pair in enumerate(kept) if i // n <= i % n]
        rows = [row for left, form in kept if form.products for row in self.words.rows(left, form)]
        zeros = [left for left, form in kept if not form.products]
        if zeros:
            rows += _rows(zeros[0], "\n".join([*(f"{left} =" for left in zeros[1:]), "0"]))
        return rows


def _stepped(tape: Tape) -> tuple[Formula, ...]:
    return tuple(step(expr, tape.order) for expr in tape.outputs)

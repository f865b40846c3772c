"""Formulas and names as LaTeX: subscripts, escapes, and lines that fit the page."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable, Sequence

import sympy as sp

from symgen import names
from symgen.codegen.formula import Call, Factor, Formula, Product
from symgen.robot.expressions import text

#: Width of a line of formulas, em: what the template sets.
LINE = 47.0
_GREEK = frozenset(
    "alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi rho sigma tau phi "
    "chi psi omega".split()
)
_PREFIXES = (*names.LINK, names.ROTOR, names.COUPLING_INERTIA, *names.FRICTION.values(),
             *names.COUPLING_FRICTION)  # fmt: skip
_PARAMETER = re.compile(rf"({'|'.join(sorted(_PREFIXES, key=len, reverse=True))})(\d+|L)(R?)")
_VARIABLE = {"q": "q", "qd": r"\dot q", "qdd": r"\ddot q", "tau": r"\tau"}
_FUNCTIONS = {
    **{name: rf"\{name}" for name in ("sin", "cos", "tan", "tanh", "exp")},
    "log": r"\ln",
    "sign": r"\operatorname{sign}",
}
#: How deep in parentheses a part begins, and the part.
Part = tuple[int, str]
_FRACTION = 12  # denominators up to this are written as fractions, but for decimals


def _parameter(name: str) -> tuple[str, str]:
    """Return letter and index of a standard or base parameter: ZZ1R gives ZZ_{1R}, IA3 Ia_3."""
    match = _PARAMETER.fullmatch(name)
    if match is None:
        return _identifier(name)
    prefix, number, regrouped = match.groups()
    if prefix not in names.LINK:  # the field writes Ia, Fs, Fv
        prefix = prefix.capitalize()
    return prefix, subscript(number + regrouped)


def _identifier(name: str) -> tuple[str, str]:
    r"""Return letter and index of a step or length: Ns1_2_ gives \mathit{Ns}'_{1,2}."""
    plain = name.rstrip("_")
    match = re.fullmatch(r"(_*[A-Za-z]+)_?(.*)", plain)
    head, tail = match.groups() if match else ("", plain)
    letters = head.replace("_", r"\_")
    if head in _GREEK:
        letters = rf"\{head}"
    elif len(head) > 1:
        letters = rf"\mathit{{{letters}}}"
    marks = "'" * (len(name) - len(plain))
    return letters + marks, subscript(tail.replace("_", ",")) if tail else ""


def subscript(index: str) -> str:
    """Return an index as a subscript."""
    return f"_{index}" if len(index) == 1 else f"_{{{index}}}"


def escaped(name: str) -> str:
    r"""Return a name as text: underscores get a backslash."""
    return name.replace("_", r"\_")


class Words:
    """The LaTeX of every symbol of a document; two symbols never look the same."""

    def __init__(
        self, variables: Iterable[sp.Symbol], parameters: Iterable[str], lengths: Iterable[str]
    ) -> None:
        self._words: dict[str, str] = {}
        self._taken: set[str] = set()
        for symbol in variables:
            letter = symbol.name.rstrip("0123456789")
            self._put(symbol.name, _VARIABLE[letter], subscript(symbol.name[len(letter) :]))
        for name in parameters:
            self._put(f"X_{name}", *_parameter(name))
        for name in lengths:
            self._put(name, *_identifier(name))

    def __getitem__(self, name: str) -> str:
        """Return a symbol's LaTeX; steps are known from their first use."""
        if name not in self._words:
            self._put(name, *_identifier(name))
        return self._words[name]

    def _put(self, name: str, letter: str, index: str) -> None:
        while letter + index in self._taken:
            letter += "'"
        self._taken.add(letter + index)
        self._words[name] = letter + index


class TexPrinter:
    """Writes formulas in the words of a document."""

    def __init__(self, words: Words) -> None:
        self.words = words

    def line(self, formula: Formula) -> str:
        """Return a formula on one line."""
        return " ".join(part for _, part in self.parts(formula, alone=True))

    def rows(self, left: str, formula: Formula) -> list[str]:
        r"""Return `left = formula` as rows of an align, each of which fits the page."""
        return broken(left, self.parts(formula, alone=True))

    def parts(self, formula: Formula, depth: int = 0, alone: bool = False) -> list[Part]:
        """Return a sum as parts: a line may be broken before each, the outermost preferred."""
        if not formula.products:
            return [(depth, "0")]
        out: list[Part] = []
        decimal = alone and len(formula.products) == 1
        for i, product in enumerate(formula.products):
            (_, first), *rest = self.product(product, depth, decimal and not product.factors)
            if product.number < 0:
                first = f"- {first}" if i else f"-{first}"
            elif i:
                first = f"+ {first}"
            out += [(depth, first), *rest]
        return out

    def product(self, product: Product, depth: int = 0, decimal: bool = False) -> list[Part]:
        """Return the parts of a product, without its sign."""
        number = abs(product.number)
        under = [f for f in product.factors if f.power < 0]
        pi = any(f.base is sp.pi for f in product.factors)
        if number.is_Rational and (under or (pi and not number.is_Integer)):
            over = Product(sp.Integer(number.p), tuple(f for f in product.factors if f.power > 0))
            below = Product(sp.Integer(number.q), tuple(Factor(f.base, -f.power) for f in under))
            top, bottom = (" ".join(part for _, part in self.product(p)) for p in (over, below))
            return [(depth, rf"\frac{{{top}}}{{{bottom}}}")]
        written = _decimal(number) if decimal or not number.is_Rational else _number(number)
        parts: list[Part] = [(depth, "" if number == 1 and product.factors else written)]
        for factor in product.factors:
            (_, first), *rest = self.factor(factor, depth + 1)
            at, last = parts.pop()
            parts += [(at, _beside(last, first)), *rest]
        return parts

    def factor(self, factor: Factor, depth: int) -> list[Part]:
        """Return the parts of a factor with its power."""
        base, power = factor.base, ""
        if factor.power != 1:
            power = f"^{factor.power}" if 1 < factor.power < 10 else f"^{{{factor.power}}}"
        if isinstance(base, Formula):
            left, right = ("(", ")") if base.depth == 0 else ("[", "]")
            parts = self.parts(base, depth)
            parts[0] = (depth, f"{left}{parts[0][1]}")
            parts[-1] = (parts[-1][0], f"{parts[-1][1]}{right}{power}")
            return parts
        if isinstance(base, Call):
            return [(depth, self._call(base, power))]
        word = r"\pi" if base is sp.pi else self.words[base.name]
        return [(depth, f"{{{word}}}{power}" if power and "'" in word else f"{word}{power}")]

    def _call(self, call: Call, power: str) -> str:
        argument = self.line(call.argument)
        if call.name == "sqrt":
            root = rf"\sqrt{{{argument}}}"
            return f"({root}){power}" if power else root
        if call.name == "abs":
            return rf"\lvert {argument} \rvert{power}"
        return f"{_FUNCTIONS[call.name]}{power}({argument})"


def broken(left: str, parts: Sequence[Part]) -> list[str]:
    r"""Return `left = parts` as rows of an align that fit the page.

    A line ends before the last of its outermost parts, but not in its first third.
    """
    out, row, room = [], rf"{left} &=", LINE - width(left) - 2
    rest = [(depth, part, width(part)) for depth, part in parts]
    while rest:
        sums = list(itertools.accumulate(w for _, _, w in rest))
        end = sum(s <= room for s in sums) or 1
        if end < len(rest):
            late = [k for k in range(1, end + 1) if sums[k - 1] > room / 3] or [end]
            end = min(late, key=lambda k: (rest[k][0], -k))
        out.append(" ".join([row, *(part for _, part, _ in rest[:end])]))
        rest, room = rest[end:], LINE - width(left) - 4
        row = r"&\qquad" if rest and rest[0][0] else r"&\quad"
    return out


def _beside(left: str, right: str) -> str:
    r"""Put factors side by side, with a thin space between words of several letters."""
    if not left:
        return right
    if right[0].isdigit():
        return rf"{left} \cdot {right}"
    several = re.match(r"[A-Za-z]{2}|\\mathit", right) is not None
    return rf"{left} \, {right}" if several else f"{left} {right}"


def _number(value: sp.Rational) -> str:
    """Return a positive rational: small fractions as such, decimals where they end."""
    written = text(value)
    short = value.q <= _FRACTION and value.q % 5 != 0
    if value.is_Integer or not (short or "/" in written):
        return written
    return rf"\tfrac{{{value.p}}}{{{value.q}}}"


def _decimal(value: sp.Expr) -> str:
    """Return a number that stands alone: as a robot file writes it."""
    written = text(value)
    if "/" in written:
        return rf"\tfrac{{{value.p}}}{{{value.q}}}"
    digits, _, exponent = written.partition("e")
    return rf"{digits} \cdot 10^{{{int(exponent)}}}" if exponent else digits


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


_WIDTHS = {"+": 1.3, "-": 1.3, "=": 1.4, "(": 0.4, ")": 0.4, "[": 0.3, "]": 0.3, ",": 0.3,
           "'": 0.3, ".": 0.3, "m": 0.9, "w": 0.75, r"\,": 0.2, r"\dot": 0.0, r"\ddot": 0.0,
           r"\sin": 1.4, r"\cos": 1.5, r"\tan": 1.6, r"\tanh": 2.1, r"\exp": 1.7, r"\mathit": 0.0,
           r"\operatorname": 0.0, r"\frac": 0.3, r"\tfrac": 0.3, r"\sqrt": 0.9, r"\cdot": 0.8,
           r"\lvert": 0.3, r"\rvert": 0.3, r"\_": 0.5, r"\quad": 1.0, "&": 0.0}  # fmt: skip

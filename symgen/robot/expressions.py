"""The safe grammar of robot files: text to exact SymPy expressions, and back.

    sum     = ["+" | "-"] product {("+" | "-") product}
    product = power {("*" | "/") power}
    power   = ["+" | "-"] power  |  atom ["**" power]
    atom    = NUMBER | NAME | FUNCTION "(" sum {"," sum} ")" | "(" sum ")"

A recursive-descent parser accepts these four rules and nothing else. No text is evaluated as code.
Decimals become exact rationals (0.225 is 9/40).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Mapping
from decimal import Decimal
from fractions import Fraction

import sympy as sp

from symgen.errors import ExpressionError, located, shortened

_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|(?P<name>[A-Za-z_]\w*)"
    r"|(?P<op>\*\*|[-+*/(),]))",
    re.ASCII,
)
#: A number, or a fraction of two numbers that is not in a power or below another fraction.
_NUMBER = r"\d+(?:\.\d+)?(?:e[+-]?\d+)?"
_VALUE = re.compile(rf"(?<![\w./])(?<!\*\*){_NUMBER}/{_NUMBER}|(?<![\w.]){_NUMBER}")
_DIGITS = 6
_MAX_LENGTH = 1000
_MAX_DEPTH = 50
_MAX_EXPONENT = 16
_MAX_DECIMALS = 100
_MAX_EXPONENTIAL = 200  # largest argument of exp: exp(200) is 7e86
_MAX_SIZE = 1000  # nodes of an expression: min and max repeat their arguments
_MAX_TERMS = 100  # of a length or an angle, expanded

#: Number of arguments of a function, and its SymPy expression.
Function = tuple[int, Callable[..., sp.Expr]]
#: Constants and functions of geometry expressions.
CONSTANTS: Mapping[str, sp.Expr] = {"pi": sp.pi}
FUNCTIONS: Mapping[str, Function] = {"sqrt": (1, sp.sqrt)}


def _power(base: sp.Expr, exponent: sp.Expr) -> sp.Expr:
    numbers = [*exponent.atoms(sp.Rational), *([exponent] if exponent.is_number else [])]
    if not all(abs(number) <= _MAX_EXPONENT for number in numbers):
        raise ExpressionError(f"an exponent of pow is at most {_MAX_EXPONENT} in size")
    return sp.Pow(sp.Abs(base), exponent)


def _exponential(argument: sp.Expr) -> sp.Expr:
    if argument.is_number and not abs(argument) <= _MAX_EXPONENTIAL:
        raise ExpressionError(f"exp of a number is taken up to {_MAX_EXPONENTIAL} in size")
    return sp.exp(argument)


#: Functions in torques of effects; pow(x, p) is abs(x)**p.
EFFECT_FUNCTIONS: Mapping[str, Function] = {
    **FUNCTIONS,
    **{f.__name__: (1, f) for f in (sp.sin, sp.cos, sp.tanh, sp.sign)},
    "exp": (1, _exponential),
    "tan": (1, lambda x: sp.sin(x) / sp.cos(x)),
    "abs": (1, sp.Abs),
    "min": (2, lambda a, b: (a + b - sp.Abs(a - b)) / 2),
    "max": (2, lambda a, b: (a + b + sp.Abs(a - b)) / 2),
    "pow": (2, _power),
}


def parse(
    text: str,
    names: Collection[str] = (),
    functions: Mapping[str, Function] = FUNCTIONS,
    values: Mapping[str, sp.Expr] | None = None,
) -> sp.Expr:
    """Parse a text of the safe grammar to an exact expression.

    Args:
        text: for example "pi/2", "-L1" or "sqrt(2)*L1/2".
        names: allowed names; each becomes a real symbol.
        functions: allowed functions.
        values: name -> expression that replaces its symbol.

    Raises:
        ExpressionError: the text does not follow the grammar, uses an unknown name, divides by
            zero, or is too large.
    """
    if len(text) > _MAX_LENGTH:
        raise ExpressionError(
            f"expression of {len(text)} characters; accepted: at most {_MAX_LENGTH}"
        )
    with located(f"in {shortened(text)!r}"):
        parser = _Parser(text, names, functions, values or {})
        expr = parser.sum()
        if parser.kind is not None:
            raise parser.error("an operator")
        return check_finite(expr)


def check_finite(expr: sp.Expr) -> sp.Expr:
    """Return `expr`, or raise ExpressionError if it is not a finite real number or formula."""
    roots = (p for p in expr.atoms(sp.Pow) if not p.exp.is_integer)
    wrong = expr.has(sp.zoo, sp.nan, sp.oo, -sp.oo, sp.I) or any(p.base.is_negative for p in roots)
    if wrong or (expr.is_number and not abs(float(expr.evalf(20))) <= 10.0**_MAX_DECIMALS):
        raise ExpressionError("not a finite real value")
    return expr


def check_plain(expr: sp.Expr) -> None:
    """Raise ExpressionError for roots of roots, high powers, or too many terms."""
    for power in expr.atoms(sp.Pow):
        if power.exp.q > 2 or abs(power.exp) > _MAX_EXPONENT:
            raise ExpressionError(
                f"accepted: square roots (not roots of roots) and powers up to {_MAX_EXPONENT}"
            )
    if _terms(expr) > _MAX_TERMS:
        raise ExpressionError(f"over {_MAX_TERMS} terms, multiplied out")


def _terms(expr: sp.Expr) -> int:
    """Return the number of terms of the expanded expression."""
    if expr.is_Add:
        return sum(map(_terms, expr.args))
    if expr.is_Mul:
        return math.prod(map(_terms, expr.args))
    if expr.is_Pow and expr.exp.is_Integer:
        count, power = _terms(expr.base), abs(int(expr.exp))
        return math.comb(count + power - 1, power)
    return max((_terms(a) for a in expr.args), default=1)


def check_powers(expr: sp.Expr) -> None:
    """Raise ExpressionError if a power is too high."""
    for power in expr.atoms(sp.Pow):
        if power.exp.is_number and abs(power.exp) > _MAX_EXPONENT:
            raise ExpressionError(f"accepted: powers up to {_MAX_EXPONENT}")


def exact(number: int | float | Decimal) -> sp.Rational:
    """Return the exact rational of a written number: 0.225 gives 9/40.

    Raises:
        ExpressionError: the number is not finite, or its size is not accepted.
    """
    value = Decimal(repr(number)) if isinstance(number, float) else Decimal(number)
    if not value.is_finite() or (value and abs(value.adjusted()) > _MAX_DECIMALS):
        raise ExpressionError(
            f"{shortened(str(number))} is out of range; accepted: 0, or 1e-{_MAX_DECIMALS} to "
            f"1e{_MAX_DECIMALS} in size"
        )
    return sp.Rational(str(value))


class _Parser:
    """A parser for one text; `kind` and `token` describe the next token."""

    def __init__(
        self,
        text: str,
        names: Collection[str],
        functions: Mapping[str, Function],
        values: Mapping[str, sp.Expr],
    ) -> None:
        self.text, self.names, self.functions, self.values = text, names, functions, values
        self.at, self.end, self.depth = 0, 0, 0
        self.kind: str | None = None
        self.token = ""
        self.advance()

    def advance(self) -> None:
        self.at = self.end
        rest = self.text[self.end :]
        if not rest.strip():
            self.kind, self.token = None, ""
            return
        match = _TOKEN.match(rest)
        if match is None:
            self.at += len(rest) - len(rest.lstrip())
            self.kind, self.token = "?", self.text[self.at]
            raise self.error("numbers, names, + - * / ** and parentheses")
        self.kind = match.lastgroup
        self.token = match.group(self.kind or 0)
        self.end += match.end()

    def error(self, accepted: str) -> ExpressionError:
        found = f"{shortened(self.token)!r}" if self.kind else "the end"
        return ExpressionError(f"found {found} at character {self.at + 1}; accepted: {accepted}")

    def take(self, op: str) -> None:
        if self.kind != "op" or self.token != op:
            raise self.error(repr(op))
        self.advance()

    def deeper(self, what: str) -> None:
        self.depth += 1
        if self.depth > _MAX_DEPTH:
            raise ExpressionError(f"more than {_MAX_DEPTH} {what}")

    def sum(self) -> sp.Expr:
        self.deeper("nested parentheses")
        value: sp.Expr = sp.S.Zero
        while True:
            sign = -1 if self.kind == "op" and self.token == "-" else 1
            if self.kind == "op" and self.token in "+-":
                self.advance()
            value = value + sign * self.product()
            if self.kind != "op" or self.token not in "+-":
                break
        self.depth -= 1
        return value

    def product(self) -> sp.Expr:
        factors = [self.power()]
        while self.kind == "op" and self.token in ("*", "/"):
            divide = self.token == "/"
            self.advance()
            factor = self.power()
            if divide and factor.is_zero:
                raise ExpressionError("division by zero")
            factors.append(1 / factor if divide else factor)
        # A single call, because otherwise SymPy multiplies a number into the first sum only.
        return sp.Mul(*factors)

    def power(self) -> sp.Expr:
        if self.kind == "op" and self.token in ("+", "-"):
            sign = 1 if self.token == "+" else -1
            self.advance()
            self.deeper("signs in a row")
            value = sign * self.power()
            self.depth -= 1
            return value
        base = self.atom()
        if self.kind == "op" and self.token == "**":
            check_finite(base)  # a power could exhaust memory
            self.advance()
            exponent = self.power()
            if not (exponent.is_Integer or exponent in (sp.Rational(1, 2), -sp.Rational(1, 2))):
                raise ExpressionError("an exponent is an integer or 1/2")
            if abs(exponent) > _MAX_EXPONENT:
                raise ExpressionError(f"an exponent is at most {_MAX_EXPONENT} in size")
            if base.is_zero and exponent < 0:
                raise ExpressionError("division by zero")
            return base**exponent
        return base

    def applied(self, function: Callable[..., sp.Expr], arguments: list[sp.Expr]) -> sp.Expr:
        """Apply a function; refuse arguments that are not finite and results that are too large."""
        for argument in arguments:
            check_finite(argument)
        value = function(*arguments)
        if any(i > _MAX_SIZE for i, _ in enumerate(sp.preorder_traversal(value))):
            raise ExpressionError("too many functions in each other")
        return value

    def atom(self) -> sp.Expr:
        kind, token = self.kind, self.token
        if kind == "number":
            self.advance()
            return exact(Decimal(token))
        if kind == "op" and token == "(":
            self.advance()
            value = self.sum()
            self.take(")")
            return value
        if kind == "name" and token in self.functions:
            count, function = self.functions[token]
            self.advance()
            self.take("(")
            arguments = [self.sum()]
            for _ in range(count - 1):
                self.take(",")
                arguments.append(self.sum())
            self.take(")")
            return self.applied(function, arguments)
        if kind == "name" and token in CONSTANTS:
            self.advance()
            return CONSTANTS[token]
        if kind == "name" and token in self.names:
            self.advance()
            return self.values.get(token, sp.Symbol(token, real=True))
        declared = ", ".join([*CONSTANTS, *self.functions, *self.names])
        raise self.error(f"a number, '(' or one of {declared}; [geometry] declares lengths")


def text(expr: sp.Expr) -> str:
    """Write an expression in the grammar: `parse(text(e)) == e`.

    Terms and factors are sorted by their text. The result therefore does not depend on the SymPy
    version or on the hash seed.
    """
    return _text(sp.sympify(expr), 0)


def six_digits(formula: str) -> str:
    """Return a formula for people, with at most six digits in each number: 0.173273*M4."""
    return _VALUE.sub(_rounded, formula)


def _rounded(match: re.Match[str]) -> str:
    top, _, under = match[0].partition("/")
    if max(len(top), len(under)) <= _DIGITS:
        return match[0]
    return f"{float(Fraction(top) / Fraction(under or 1)):.{_DIGITS}g}"


def _text(expr: sp.Expr, level: int) -> str:
    """Write `expr` in a sum (level 0), a product (1) or a factor (2), with the parentheses it
    needs.
    """
    if expr.is_Rational:
        return _parenthesised(_rational(expr), expr < 0 or not expr.is_Integer, level, expr)
    if expr.is_Float:
        return _parenthesised(repr(float(expr)), expr < 0, level, expr)
    if expr.is_Symbol or expr in (sp.pi, sp.E):
        return {sp.pi: "pi", sp.E: "exp(1)"}.get(expr, str(expr))
    if expr.is_Add:
        terms = sorted((_text(a, 1) for a in expr.args), key=lambda s: (s.startswith("-"), s))
        out = "".join(f" - {s[1:]}" if s.startswith("-") else f" + {s}" for s in terms)
        out = f"-{out[3:]}" if out.startswith(" - ") else out[3:]
        return f"({out})" if level > 0 else out
    if expr.is_Mul:
        number, rest = expr.as_coeff_Mul()
        over = [f for f in rest.args if f.is_Pow and f.exp.is_negative] if rest.is_Mul else []
        if rest.is_Pow and rest.exp.is_negative:
            over = [rest]
        top = [f for f in (rest.args if rest.is_Mul else (rest,)) if f not in over]
        factors = sorted(_text(f, 2) for f in top)
        sign, number = ("-" if number < 0 else ""), abs(number)
        under = sorted(_text(1 / f, 2) for f in over)
        if sp.pi in top and not number.is_Integer:  # pi/2, not 0.5*pi
            number, under = sp.Integer(number.p), [str(number.q), *under]
        if number != 1 or not factors:
            factors.insert(0, _text(number, 2))
        out = sign + "*".join(factors) + "".join(f"/{f}" for f in under)
        return f"({out})" if level > 1 else out
    if expr.is_Pow:
        base, exponent = expr.args
        if exponent == sp.Rational(1, 2):
            return f"sqrt({_text(base, 0)})"
        if exponent.is_Rational and exponent.is_negative:
            out = f"1/{_text(1 / expr, 2)}"
            return f"({out})" if level > 1 else out
        if exponent.is_Integer:
            return f"{_text(base, 2)}**{exponent}"
        if (2 * exponent).is_Integer and base.func is not sp.Abs:
            whole = base ** (exponent - sp.S.Half)
            return _text(sp.Mul(whole, sp.sqrt(base), evaluate=False), level)
        inner = base.args[0] if base.func is sp.Abs else base  # pow takes abs() of its base
        return f"pow({_text(inner, 0)}, {_text(exponent, 0)})"
    if expr.func in (sp.sin, sp.cos, sp.tan, sp.Abs, sp.sign, sp.tanh, sp.exp):
        return f"{expr.func.__name__.lower()}({_text(expr.args[0], 0)})"
    raise ExpressionError(f"{expr} cannot be written in the grammar of robot files")


def _rational(value: sp.Rational) -> str:
    """Write a rational as a short decimal if possible, otherwise as a fraction."""
    if value.is_Integer:
        return str(value)
    digits = format(Decimal(int(value.p)) / Decimal(int(value.q)), "f")
    return digits if sp.Rational(digits) == value else f"{value.p}/{value.q}"


def _parenthesised(out: str, compound: bool, level: int, value: sp.Rational) -> str:
    needs = (level > 1 and ("/" in out or value < 0)) or (level > 0 and "/" in out and value < 0)
    return f"({out})" if needs and compound else out

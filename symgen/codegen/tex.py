"""The model of a robot as a LaTeX document: tables, parameters and formulas to paste from.

A kernel whose closed form is short is printed in closed form, any other as the steps of its tape.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import sympy as sp

from symgen import names
from symgen.codegen.closed_form import closed_form
from symgen.codegen.formula import Factor, Formula, Product, geometric, step
from symgen.codegen.kernels import Kernel
from symgen.codegen.model import Model
from symgen.codegen.tex_printer import TexPrinter, Words, broken, escaped, subscript
from symgen.files import rendered
from symgen.robot.types import Joint, joint_variable, require_gravity
from symgen.symbolic.base_parameters import BaseParameter, bound
from symgen.symbolic.friction import torque_tape
from symgen.symbolic.kinematics import variables
from symgen.symbolic.tape import Tape


@dataclass(frozen=True)
class _Section:
    """How a kernel is presented; `always` prints its steps where there is no closed form."""

    kernel: str
    title: str
    text: str
    always: bool = True


_SECTIONS = (
    _Section("energy_regressor", "Energy regressor", "Columns $h(q, \\dot q)$ of the energy:"),
    _Section("inverse_dynamics", "Torques", "Torques of a motion, friction included:"),
    _Section("mass_matrix", "Mass matrix", "Entries $M_{jk} = M_{kj}$:"),
    _Section(
        "coriolis",
        "Coriolis matrix",
        "With $\\dot M - 2 C$ skew-symmetric:",
        always=False,
    ),
    _Section("gravity_torque", "Gravity", "Torques that hold the arm at rest:"),
)


def tex_document(model: Model, kernels: Sequence[Kernel]) -> str:
    """Return a model as a LaTeX document (article, amsmath, booktabs).

    Args:
        model: from `derive`.
        kernels: those of its kernels whose formulas may be printed.

    Raises:
        RobotError: gravity is an input.
    """
    require_gravity(model.robot, "a LaTeX document")
    return rendered("tex/model.tex", **_Document(model, kernels).data())


def regroupings(model: Model) -> str:
    """Return the formulas of the base parameters, in dollars, as notebooks show LaTeX."""
    document = _Document(model, ())
    rows = [row for p in model.base.parameters for row in document.regrouping(p)]
    return "$$\\begin{aligned}\n" + " \\\\\n".join(rows) + "\n\\end{aligned}$$"


class _Document:
    def __init__(self, model: Model, kernels: Sequence[Kernel]) -> None:
        self.robot, self.base = model.robot, model.base
        self.chosen = {kernel.name: kernel for kernel in kernels}
        variable = variables(self.robot)
        self.words = Words(
            (*variable.q, *variable.qd, *variable.qdd, *variable.tau),
            dict.fromkeys((*(p.name for p in self.base.standard), *self.base.names)),
            (name for name, _ in self.robot.geometry),
        )
        self.printer = TexPrinter(self.words)

    def data(self) -> dict[str, Any]:
        base = self.base
        kernels = [k for section in _SECTIONS for k in self.kernel(section)]
        return {
            "name": self.robot.name,
            "title": escaped(self.robot.name),
            "table": [self.row(joint) for joint in self.robot.joints],
            "gravity": ", ".join(self.geometric(g) for g in self.robot.gravity),
            "geometry": ", ".join(
                f"${self.words[name]} = {self.geometric(value)}$"
                for name, value in self.robot.geometry
            ),
            "drives": list(self.drives()),
            "p": len(base.parameters),
            "base": ", ".join(f"${self.parameter(name)}$" for name in base.names),
            "regrouped": [row for p in base.parameters if p.terms for row in self.regrouping(p)],
            "no_effect": ", ".join(f"${self.parameter(name)}$" for name in base.no_effect),
            "proof": {
                "rank": base.proof.rank,
                "primes": " and ".join(map(str, base.proof.primes)),
                "relations": base.proof.structural + base.proof.lifted,
                "bound": bound(self.robot),
            },
            "friction": self.friction(),
            "kernels": kernels,
            "recursive": any(k["recursive"] for k in kernels),
        }

    def geometric(self, expr: sp.Expr) -> str:
        return self.printer.line(geometric(expr))

    def parameter(self, name: str) -> str:
        return self.words[f"X_{name}"]

    def row(self, joint: Joint) -> str:
        """Return a line of the table of geometry, the joint variable where it belongs."""
        values = {key: geometric(getattr(joint, key)) for key in ("gamma", "b", "alpha", "d")}
        for key, sigma in (("theta", names.REVOLUTE), ("r", names.PRISMATIC)):
            here = joint.sigma == sigma
            products = geometric(getattr(joint, key) + (joint.offset if here else 0)).products
            for k, share in joint.shares if here else ():
                variable = Factor(joint_variable(k))
                products += tuple(
                    Product(p.number, (*p.factors, variable)) for p in geometric(share).products
                )
            values[key] = Formula(products)
        cells = [str(n) for n in (joint.number, joint.sigma, joint.antecedent)]
        return " & ".join([*cells, *(f"${self.printer.line(v)}$" for v in values.values())])

    def drives(self) -> Iterator[str]:
        """Describe couplings and the payload, a sentence each."""
        for c in self.robot.couplings:
            j, k = (subscript(str(i)) for i in (c.first, c.second))
            rotor, *friction = (
                f"${self.parameter(f'{prefix}{c.second}')}$"
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
        def term(coefficient: sp.Expr, name: str) -> Product:
            symbol = Factor(sp.Symbol(f"X_{name}", real=True))
            parts = geometric(coefficient).products
            if len(parts) > 1:
                return Product(sp.S.One, (Factor(Formula(parts)), symbol))
            return Product(parts[0].number, (*parts[0].factors, symbol))

        products = [term(c, name) for c, name in ((sp.S.One, p.head), *p.terms)]
        return self.printer.rows(self.parameter(p.name), Formula(tuple(products)))

    def friction(self) -> list[str]:
        """Return the torque of friction on each joint."""
        tape = torque_tape(self.robot)
        forms = closed_form(tape)
        first = sum(s.inertial for s in self.base.standard)
        rubbing = [s for s in self.base.standard[first:] if not s.load]
        count = len(rubbing)
        out: list[str] = []
        if not count:
            return out
        if forms is None:
            out, forms = list(self.steps(tape)), _stepped(tape)
        for i, joint in enumerate(self.robot.movable):
            products = [
                Product(p.number, (Factor(sp.Symbol(f"X_{s.name}", real=True)), *p.factors))
                for k, s in enumerate(rubbing)
                for p in forms[i * count + k].products
            ]
            left = rf"\tau_{{f,{joint.number}}}"
            out += self.printer.rows(left, Formula(tuple(products)))
        return out

    def kernel(self, section: _Section) -> Iterator[dict[str, Any]]:
        kernel = self.chosen.get(section.kernel)
        if kernel is None:
            return
        forms = closed_form(kernel.tape)
        if forms is not None:
            rows = self.outputs(kernel, forms)
        elif section.always:
            rows = [*self.steps(kernel.tape), *self.outputs(kernel, _stepped(kernel.tape))]
        else:
            return
        yield {
            "title": section.title,
            "text": section.text,
            "rows": rows,
            "recursive": forms is None,
        }

    def steps(self, tape: Tape) -> Iterator[str]:
        for symbol, value in tape.constants:
            if symbol != value:
                yield from self.printer.rows(self.words[symbol.name], geometric(value))
        for symbol, expr in tape.steps:
            yield from self.printer.rows(self.words[symbol.name], step(expr, tape.order))

    def outputs(self, kernel: Kernel, forms: tuple[Formula, ...]) -> list[str]:
        (output,) = kernel.outputs
        numbers = [j.number for j in self.robot.movable]
        if output.columns:
            lefts = [f"h_{{{self.parameter(name)}}}" for name in output.columns]
        elif len(output.shape) == 1:
            letter = r"\tau" if kernel.name == "inverse_dynamics" else "Q"
            lefts = [letter + subscript(str(j)) for j in numbers]
        else:
            comma = "," if max(numbers) > 9 else ""
            lefts = [f"{output.name}_{{{j}{comma}{k}}}" for j in numbers for k in numbers]
        kept = list(range(len(lefts)))
        if kernel.name == "mass_matrix":  # symmetric
            kept = [i for i in kept if i // len(numbers) <= i % len(numbers)]
        rows = [r for i in kept if forms[i].products for r in self.printer.rows(lefts[i], forms[i])]
        zeros = [lefts[i] for i in kept if not forms[i].products]
        if zeros:
            rows += broken(zeros[0], [(0, part) for part in [*(f"{z} =" for z in zeros[1:]), "0"]])
        return rows


def _stepped(tape: Tape) -> tuple[Formula, ...]:
    return tuple(step(expr, tape.order) for expr in tape.outputs)

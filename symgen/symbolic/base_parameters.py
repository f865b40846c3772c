"""The minimal (base) parameters of a robot: regrouping formulas, and the proof of minimality.

A set of energy columns is minimal if no combination of them is constant. The number of base
parameters is the exact rank of the differences h(x) - h(x0), taken modulo two primes. Columns are
taken from the base to the tips, so that parameters regroup towards the base (Gautier and Khalil).
The regrouping formulas come from the structural relations if these cover the case, and otherwise
from exact linear algebra. Each formula is checked modulo both primes.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import sympy as sp

from symgen import names
from symgen.errors import SymgenError
from symgen.files import html_table
from symgen.robot.expressions import six_digits, text
from symgen.robot.types import Robot
from symgen.symbolic.elimination import (
    Coefficient,
    Elimination,
    ExactRow,
    NeedsValuesError,
)
from symgen.symbolic.energy import StateColumns, energy_tape
from symgen.symbolic.guard import require_floats_agree
from symgen.symbolic.lifting import lifted
from symgen.symbolic.modular import (
    BadDrawError,
    PrimeField,
    Residues,
    order_needed,
    primes,
    rational,
    reduce_rows,
)
from symgen.symbolic.parameters import Parameter
from symgen.symbolic.relations import structural_relations
from symgen.symbolic.tape import Tape

_SEEDS = (1, 2)
_MARGIN = 10  # more sample points than columns
_PRIMES, _ATTEMPTS = 400, 16


@dataclass(frozen=True)
class BaseParameter:
    """One base parameter: its leading standard parameter, and those that regroup into it.

    Attributes:
        name: the name of the leading parameter, with R if others regroup into it.
        index: position of the leading parameter among the standard ones.
        terms: (coefficient, standard parameter) for the others; coefficients in named lengths.
    """

    name: str
    index: int
    terms: tuple[tuple[sp.Expr, str], ...]
    unit: str
    inertial: bool

    @property
    def head(self) -> str:
        """Name of the leading standard parameter."""
        return self.name.removesuffix("R") if self.terms else self.name

    @property
    def expression(self) -> str:
        """The regrouping formula, for example ZZ1 + IA1 + L1**2*M2."""
        out = self.head
        for coefficient, name in self.terms:
            if coefficient in (1, -1):
                term = name if coefficient == 1 else f"-{name}"
            elif coefficient.is_Add:
                term = f"({text(coefficient)})*{name}"
            else:
                term = f"{text(coefficient)}*{name}"
            out += f" - {term[1:]}" if term.startswith("-") else f" + {term}"
        return out


@dataclass(frozen=True)
class Proof:
    """The proof of minimality: the exact rank, its geometry, and the relations."""

    rank: int
    primes: tuple[int, ...]
    seeds: tuple[int, ...]
    points: int
    structural_relations: int
    lifted_relations: int

    @property
    def method(self) -> str:
        """The proof as text."""
        return (
            "lower bound: rank of h(x) - h(x0) at random points of the circle, integers modulo "
            "the primes; upper bound: one relation for every parameter that is left out, checked "
            "modulo the primes"
        )


@dataclass(frozen=True)
class Nominal:
    """Comparison of the minimal sets of the nominal and of the exact geometry.

    Attributes:
        rank, exact_rank: the numbers of parameters in both sets.
        separated: parameters that only the exact geometry separates, each with the share of its
            torque that the nominal set cannot express.
        kept: those of them in X. The others regroup as in the nominal geometry.
        missing: (n,) share of the torque of every joint that X cannot express.
        states: number of states for these figures.
        limit: bound of `missing`.
    """

    rank: int
    exact_rank: int
    separated: tuple[tuple[str, float], ...]
    kept: tuple[str, ...]
    missing: tuple[float, ...]
    states: int
    limit: float

    @property
    def text(self) -> str:
        """The comparison in one sentence."""
        listed = ", ".join(f"{name} ({100 * share:.3g} %)" for name, share in self.separated)
        outcome = "X is the nominal set"
        if self.kept:
            outcome = f"X has {', '.join(self.kept)} of them"
        return (
            f"rank {self.rank} for the nominal geometry, {self.exact_rank} for the exact one, "
            f"which also separates {listed}; {outcome} and leaves out at most "
            f"{100 * max(self.missing):.2g} % of a joint's torque"
        )


@dataclass(frozen=True)
class BaseParameters:
    """The minimal set of a robot's parameters, in the order of X.

    Attributes:
        nominal: comparison of the sets of the nominal and of the exact geometry, if they differ.
    """

    parameters: tuple[BaseParameter, ...]
    standard: tuple[Parameter, ...]
    no_effect: tuple[str, ...]
    proof: Proof
    nominal: Nominal | None = None

    def __repr__(self) -> str:
        """Return the numbers of base parameters and of standard parameters."""
        return f"<BaseParameters: {len(self.parameters)} of {len(self.standard)} standard ones>"

    def _repr_html_(self) -> str:
        return html_table(repr(self), ("base parameter", "formula", "unit"), self.table)

    @property
    def table(self) -> list[tuple[str, str, str]]:
        """Name, formula and unit of each base parameter."""
        return [(p.name, six_digits(p.expression), p.unit) for p in self.parameters]

    @property
    def inertial(self) -> int:
        """Number of inertial base parameters: the first entries of X."""
        return sum(p.inertial for p in self.parameters)

    @property
    def linear(self) -> int:
        """Number of base parameters with a column: all but those of load effects, which are the
        last of X.
        """
        return sum(not self.standard[p.index].load for p in self.parameters)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the base parameters, in the order of X."""
        return tuple(p.name for p in self.parameters)


def bound(robot: Robot) -> int:
    """Return Gautier and Khalil's upper bound 8 n_r + 5 n_t - 4 - sigmabar_1.

    It holds for the inertial parameters of a serial arm with one joint on the base. For each
    further joint on the base, the four parameters that joint 1 lacks are subtracted once more. On a
    base with an IMU, no joint lacks any; a free base adds its ten.
    """
    revolute = sum(j.turns for j in robot.joints)
    prismatic = sum(j.slides for j in robot.joints)
    if robot.imu:
        return 8 * revolute + 5 * prismatic + (len(names.LINK) if robot.floating else 0)
    first = robot.movable[0]
    return 8 * revolute + 5 * prismatic - 4 - (1 if first.turns else 0)


def find_base(
    robot: Robot, standard: Sequence[Parameter], energy: Tape, *, at_values: bool = False
) -> BaseParameters | None:
    """Find the base parameters of a robot, with formulas and proof.

    Args:
        robot: the mechanism.
        standard: its standard parameters, in the order of X.
        energy: tape of the energy column of every inertial one.
        at_values: False keeps named lengths as symbols. The result is None if the values of the
            file then give another set than the symbols.

    Raises:
        SymgenError: a relation fails its check. This would be a bug of symgen.
    """
    problem = _Columns(robot, standard, energy)
    fields = problem.fields()
    first = problem.select(fields)
    if robot.geometry and not at_values:
        plain = robot.with_values()
        here = _Columns(plain, standard, energy_tape(plain))
        if here.select(here.fields()).pivots != first.pivots:
            return None
    rows = Elimination(problem.names, [s.field for s in fields])
    missing = [i for i in range(len(problem.names)) if i not in set(first.pivots)]
    try:
        for relation in structural_relations(robot):
            rows.add(rows.exact({k: v for k, v in relation.items() if k in rows.position}))
        structural = len(rows.rows)
        for i in missing:
            if problem.names[i] not in rows.rows:
                rows.add(problem.relation(i, first))
    except NeedsValuesError:
        return None
    if set(rows.rows) != {problem.names[i] for i in missing}:
        raise SymgenError("the regrouping relations do not match the exact rank")
    for k, sample in enumerate(fields):
        sample.check(problem.names, rows.rows, k)
    require_floats_agree(problem.columns, first.pivots, rows.rows)
    proof = Proof(
        rank=len(first.pivots) + problem.path_only,
        primes=tuple(s.field.p for s in fields),
        seeds=_SEEDS,
        points=fields[0].matrix.shape[0],
        structural_relations=structural,
        lifted_relations=len(rows.rows) - structural,
    )
    return _regrouped(standard, rows.rows, proof)


def _regrouped(
    standard: Sequence[Parameter], rows: Mapping[str, ExactRow], proof: Proof
) -> BaseParameters:
    """Convert relations X_d = ... to the formulas of the parameters that stay."""
    joined: dict[str, list[tuple[sp.Expr, str]]] = {}
    for p in standard:
        for head, coefficient in rows.get(p.name, {}).items():
            if head != p.name:
                joined.setdefault(head, []).append((-coefficient.value, p.name))
    kept = tuple(
        BaseParameter(
            name=p.name + ("R" if p.name in joined else ""),
            index=i,
            terms=tuple(joined.get(p.name, ())),
            unit=p.unit,
            inertial=p.inertial,
        )
        for i, p in enumerate(standard)
        if p.name not in rows
    )
    no_effect = tuple(p.name for p in standard if len(rows.get(p.name, {})) == 1)
    return BaseParameters(kept, tuple(standard), no_effect, proof)


def modulo_primes(robot: Robot, columns: Callable[[PrimeField], Residues]) -> list[Sample]:
    """Evaluate columns at random points modulo two primes, each with its own seed."""
    joints = robot.joints
    turned = [j.theta + j.offset for j in joints if j.turns]
    angles = [a for j in joints for a in (j.gamma, j.alpha, j.theta)] + turned
    order = order_needed(angles)
    lengths = [e for j in joints for e in (j.b, j.d, j.r)]
    geometry = [e for e in lengths if not e.is_Rational]
    out: list[Sample] = []
    # A square root in the geometry exists only modulo every other prime, or at every other
    # point.
    for prime in itertools.islice(primes(order), _PRIMES):
        for attempt in range(_ATTEMPTS):
            seed = _SEEDS[len(out)] + len(_SEEDS) * attempt
            try:
                field = PrimeField(prime, seed, angles, order)
                for length in geometry:  # relations need all lengths, the tape may not
                    field.constant(length)
                out.append(Sample(field, columns(field) % field.p))
                break
            except BadDrawError:
                continue
        if len(out) == len(_SEEDS):
            return out
    raise SymgenError("no prime was found that has all square roots of this geometry")


@dataclass(frozen=True, eq=False)
class Sample:
    """Columns at random points, modulo one prime."""

    field: PrimeField
    matrix: Residues

    def check(self, column: Sequence[str], rows: Mapping[str, ExactRow], k: int) -> None:
        """Raise SymgenError if a relation does not hold at these points (prime number k)."""
        index = {name: i for i, name in enumerate(column)}
        for relation in rows.values():
            coefficients = np.array([c.residues[k] for c in relation.values()], dtype=np.int64)
            terms = self.matrix[:, [index[name] for name in relation]] * coefficients % self.field.p
            if (terms.sum(axis=1) % self.field.p).any():
                raise SymgenError(f"the relation of {', '.join(relation)} does not hold")


@dataclass(frozen=True)
class _Selection:
    """Result of the elimination: the kept columns, and the reduced rows."""

    pivots: tuple[int, ...]
    reduced: tuple[tuple[PrimeField, Residues], ...]


class _Columns:
    """The columns that are functions of the state: energies, and q_j for an offset OF_j.

    FS and FV integrate along the path. No combination of them depends on the ends of the path
    alone, so they are base parameters without further proof.
    """

    def __init__(self, robot: Robot, standard: Sequence[Parameter], energy: Tape) -> None:
        state = [p for p in standard if p.inertial or p.prefix == "OF"]
        self.columns = StateColumns(robot, energy, state)
        self.names = [p.name for p in state]
        self.path_only = sum(not p.load for p in standard) - len(state)

    def fields(self) -> list[Sample]:
        """Evaluate all columns modulo two primes."""
        count = len(self.names) + _MARGIN
        return modulo_primes(
            self.columns.robot, lambda field: self.columns.differences(field, count)
        )

    def select(self, samples: Sequence[Sample]) -> _Selection:
        """Keep the first independent columns: links from the base to the tips, then offsets.

        If an offset OF_j depends on the energies (weight along a prismatic axis), it joins the
        link: M4R = M4 + OF4/g, IA4R = IA4 - OF4/g. A link on a fixed joint takes no part: its
        columns are combinations of those of its antecedent.
        """
        fixed = {joint.number for joint in self.columns.robot.joints if joint.fixed}
        part = np.array([p.joint not in fixed for p in self.columns.parameters])
        rows = part.sum() + _MARGIN
        results = [(s.field, *reduce_rows(s.matrix[:rows] * part, s.field.p)) for s in samples]
        pivots = max((tuple(pivots) for _, pivots, _ in results), key=len)
        if any(tuple(p) != pivots for _, p, _ in results):
            raise SymgenError("the exact rank differs between primes: an unlucky draw")
        return _Selection(pivots, tuple((f, rows) for f, _, rows in results))

    def relation(self, column: int, selection: _Selection) -> ExactRow:
        """Return the exact relation of a column that no structural relation covers."""
        fields = [field for field, _ in selection.reduced]
        moduli = [field.p for field in fields]
        residues = {
            pivot: tuple(int(rows[k, column]) for _, rows in selection.reduced)
            for k, pivot in enumerate(selection.pivots)
            if any(rows[k, column] for _, rows in selection.reduced)
        }
        guesses = [rational(r, moduli) for r in residues.values()]
        if all(guess is not None for guess in guesses):
            values = [-guess for guess in guesses if guess is not None]
        else:
            values = lifted(self.columns.only([column, *residues]))
            for value, r in zip(values, residues.values(), strict=True):
                if not value.has(sp.Float) and any(
                    (int(f.constant(value)) + x) % f.p for f, x in zip(fields, r, strict=True)
                ):
                    raise SymgenError(f"the formula {value} is not what elimination found")
        found = {self.names[column]: Coefficient(sp.S.One, (1,) * len(moduli))}
        for (pivot, r), value in zip(residues.items(), values, strict=True):
            opposite = tuple(-x % p for x, p in zip(r, moduli, strict=True))
            found[self.names[pivot]] = Coefficient(value, opposite)
        return found

"""Tapes for base parameters: from standard ones, and with a body or a load added to a link."""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp

from symgen import names
from symgen.robot.types import Robot
from symgen.symbolic.base_parameters import BaseParameters
from symgen.symbolic.bodies import Inertia
from symgen.symbolic.kinematics import builder
from symgen.symbolic.placement import coordinates, links
from symgen.symbolic.spatial import UPPER, symmetric
from symgen.symbolic.tape import Tape, TapeBuilder, real_symbol


def base_parameters_tape(robot: Robot, base: BaseParameters) -> Tape:
    """Derive X from all standard parameters: X_b = head + sum of c times the regrouped ones."""
    standard = {p.name: real_symbol(f"X_{p.name}") for p in base.standard}
    tape = builder(robot, standard.values())
    return tape.tape([("standard", tuple(standard.values()))], _joined(base, standard, tape, {}))


def add_body_tape(robot: Robot, base: BaseParameters) -> Tape:
    """Derive X of the robot with a body fixed on one of its links.

    In the frame of the link, with c the centre of mass and I the inertia about it,

        J = I + m (c.c - c c^T),  m c,  m

    are added to the standard parameters of the link. Negative mass and inertia remove a body.
    """
    X = _symbols(base)
    at, mass = links(robot), real_symbol("X_mass")
    c, own = coordinates("c"), coordinates("i", 6)
    tape = builder(robot, (*X.values(), *at, mass, *c, *own))
    moment = [tape.entry(mass * c[i], "m", "", i) for i in range(3)]
    squares = [tape.entry(moment[i] * c[i], "s", "", i) for i in range(3)]
    J = {}
    for (a, b), prefix, value in zip(UPPER, names.INERTIA, own, strict=True):
        steiner = sum(squares) - squares[a] if a == b else -moment[a] * c[b]
        J[a, b] = tape.name(f"J{prefix}", value + steiner)
    body = Inertia(symmetric(J), tuple(moment), mass).parameters
    standard = {
        f"{prefix}{joint.number}": tape.name(f"B{prefix}{joint.number}", symbol * value)
        for joint, symbol in zip(robot.bodies, at, strict=True)
        for prefix, value in body.items()
    }
    outputs = _joined(base, standard, tape, X)
    inputs = [
        ("X", tuple(X.values())),
        ("link", at),
        ("mass", (mass,)),
        ("com", c),
        ("inertia", own),
    ]
    return tape.tape(inputs, outputs)


def add_load_tape(robot: Robot, base: BaseParameters) -> Tape:
    """Derive X of the robot with a load on its link: X plus the regrouped ten parameters of it."""
    X, link = _symbols(base), robot.load_link
    load = coordinates("l", len(names.LINK))
    tape = builder(robot, (*X.values(), *load))
    standard = {f"{prefix}{link}": x for prefix, x in zip(names.LINK, load, strict=True)}
    outputs = _joined(base, standard, tape, X)
    return tape.tape([("X", tuple(X.values())), ("load", load)], outputs)


def _symbols(base: BaseParameters) -> dict[str, sp.Symbol]:
    """Return the symbol of each base parameter as an input."""
    return {name: real_symbol(f"X_{name}_") for name in base.names}


def _joined(
    base: BaseParameters,
    standard: Mapping[str, sp.Expr],
    tape: TapeBuilder,
    start: Mapping[str, sp.Expr],
) -> list[sp.Expr]:
    """Return start + head + sum of c times the regrouped parameters, for each base parameter."""
    out = []
    for p in base.parameters:
        terms = [start.get(p.name, sp.S.Zero), standard.get(p.head, sp.S.Zero)]
        for coefficient, name in p.terms:
            if name in standard:
                number = tape.constant(f"c{p.name}_{name}", coefficient)
                terms.append(number * standard[name])
        out.append(tape.name(f"N{p.name}", sp.Add(*terms)))
    return out

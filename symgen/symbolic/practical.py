"""Base parameters of a calibrated robot: those of its nominal geometry.

The exact geometry separates parameters that the nominal one regroups. If their torque is small, a
log cannot separate them: the exact set is correct, but its equations are nearly singular. The
practical set regroups them as the nominal geometry does, and all others as the exact geometry does.
Its columns are those of the exact geometry.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from symgen import names
from symgen.robot.body import Body
from symgen.robot.nominal import reach
from symgen.robot.types import Robot
from symgen.symbolic.base_parameters import BaseParameter, BaseParameters, Nominal
from symgen.symbolic.regressor import torque_tape
from symgen.symbolic.sampling import columns_at, random_inputs

FloatArray = NDArray[np.float64]
#: Share of a joint's torque that may be left out. On a UR10 with origins off by 0.7 mrad, leaving
#: out 0.16 % increases the held-out error of joint 1 by half, because filters reduce 1 % noise to
#: 0.13 %.
LIMIT = 3e-4
_DRAWS, _STATES = 10, 1000  # number of draws of links, and of states for each
_SLOW = 0.5  # speeds and accelerations of a moderate motion, relative to those of random states
_MASS = (1.0, 5.0)  # kg
_SIZE = 0.1  # of the centre of mass and of the radius of gyration, relative to the reach
_DIGITS = 2  # of figures in the manifest, so that they are the same on all computers


def practical_base(robot: Robot, exact: BaseParameters, nominal: BaseParameters) -> BaseParameters:
    """Return the base parameters to use: those of the nominal geometry if they express all torques.

    Some parameters are separated by the exact geometry only. Those with the smallest torque regroup
    as in the nominal geometry, as long as less than LIMIT of any joint's torque is left out.

    Args:
        robot: the mechanism, with its exact geometry.
        exact: the base parameters of this geometry.
        nominal: those of the nominal geometry.

    Returns:
        Base parameters with formulas of the exact geometry. `nominal` contains the figures if the
        sets of both geometries differ.
    """
    common = {p.head for p in nominal.parameters}
    separated = [p for p in exact.parameters if p.head not in common]
    if not separated or not common <= {p.head for p in exact.parameters}:
        return exact
    joins = {
        parameter.head: {
            p.head: c for p in nominal.parameters for c, name in p.terms if name == parameter.head
        }
        for parameter in separated
    }
    loss = _loss(robot, exact, separated, joins)
    order = np.argsort(loss.alone(), kind="stable")
    regrouped = order[:0]
    for count in range(1, len(separated) + 1):
        if max(loss.sum(order[:count])) < LIMIT:
            regrouped = order[:count]
    joined = [separated[k] for k in sorted(regrouped)]
    parameters = tuple(
        _joined(p, joined, joins, exact) for p in exact.parameters if p not in joined
    )
    present = {name for p in parameters for name in (p.head, *(n for _, n in p.terms))}
    return BaseParameters(
        parameters=parameters,
        standard=exact.standard,
        no_effect=tuple(p.name for p in exact.standard if p.name not in present),
        proof=nominal.proof if joined == separated else exact.proof,
        nominal=Nominal(
            rank=nominal.proof.rank,
            exact_rank=exact.proof.rank,
            separated=tuple(zip((p.head for p in separated), loss.columns, strict=True)),
            kept=tuple(p.head for p in separated if p not in joined),
            missing=loss.sum(regrouped),
            states=_DRAWS * _STATES,
            limit=LIMIT,
        ),
    )


_Joins = dict[str, dict[str, sp.Expr]]


def _joined(
    parameter: BaseParameter,
    separated: Sequence[BaseParameter],
    joins: _Joins,
    exact: BaseParameters,
) -> BaseParameter:
    """Return a parameter with the separated ones that regroup into it, and all that regroup into
    these.
    """
    head = parameter.head
    terms = _terms(parameter)
    for other in separated:
        factor = joins[other.head].get(head, sp.S.Zero)
        for c, name in ((sp.S.One, other.head), *other.terms):
            terms[name] = sp.expand(terms.get(name, sp.S.Zero) + factor * c)
    ordered = tuple((terms[p.name], p.name) for p in exact.standard if terms.get(p.name, 0) != 0)
    return replace(parameter, name=head + ("R" if ordered else ""), terms=ordered)


@dataclass(frozen=True)
class _Loss:
    """Torque that is left out if separated parameters regroup as in the nominal geometry.

    Attributes:
        gram: (n, s, s) products of these torques by joint, relative to the squared joint torque.
        columns: (s,) share of the column of every separated parameter.
    """

    gram: FloatArray
    columns: tuple[float, ...]

    def alone(self) -> FloatArray:
        """Return the largest share of a joint's torque for each parameter, (s,)."""
        squares: FloatArray = np.diagonal(self.gram, axis1=1, axis2=2).max(axis=0)
        return np.sqrt(squares)

    def sum(self, places: NDArray[np.intp]) -> tuple[float, ...]:
        """Return the share of every joint's torque, (n,), for the sum of some parameters."""
        squares = self.gram[:, places][:, :, places].sum(axis=(1, 2))
        return tuple(_short(share) for share in np.sqrt(np.maximum(squares, 0.0)))


def _loss(
    robot: Robot,
    exact: BaseParameters,
    separated: Sequence[BaseParameter],
    joins: _Joins,
) -> _Loss:
    """Compute the left-out torque for random links and states."""
    plain = replace(robot.with_values(), effects=())
    tape = torque_tape(plain)
    formulas = _matrix(exact, [{p.head: sp.S.One, **_terms(p)} for p in separated], robot)
    combined = [
        {p.head: sp.S.One, **{name: -c for name, c in joins[p.head].items()}} for p in separated
    ]
    differences = _matrix(exact, combined, robot)
    places = [p.index for p in separated]
    rows = len(robot.equations)
    torque = np.zeros(rows)
    gram = np.zeros((rows, len(separated), len(separated)))
    before, after = np.zeros((2, rows, len(separated)))
    for draw in range(_DRAWS):
        inputs = random_inputs(plain, _STATES, draw)
        for name in ("qd", "qdd"):
            inputs[name] = [_SLOW * x for x in inputs[name]]
        W = columns_at(tape, {}, inputs, _STATES).reshape(_STATES, rows, -1)
        columns = W.shape[2]
        links = _links(robot, exact, draw)
        rest = W @ differences[:, :columns].T
        missing = rest * (formulas @ links)
        torque += np.sum((W @ links[:columns]) ** 2, axis=0)
        gram += np.einsum("ija,ijb->jab", missing, missing)
        after += np.sum(rest**2, axis=0)
        before += np.sum(W[:, :, places] ** 2, axis=0)
    weight = np.divide(1.0, torque, out=np.zeros_like(torque), where=torque > 0)
    shares = np.sqrt((weight @ after) / (weight @ before))
    return _Loss(gram * weight[:, None, None], tuple(map(_short, shares)))


def _terms(parameter: BaseParameter) -> dict[str, sp.Expr]:
    return {name: c for c, name in parameter.terms}


def _matrix(base: BaseParameters, rows: Sequence[dict[str, sp.Expr]], robot: Robot) -> FloatArray:
    """Return sums of standard parameters as a matrix (rows, s), at the lengths of the robot."""
    place = {p.name: i for i, p in enumerate(base.standard)}
    values = robot.values()
    out = np.zeros((len(rows), len(place)))
    for k, row in enumerate(rows):
        for name, c in row.items():
            out[k, place[name]] = float(c.subs(values))
    return out


def _links(robot: Robot, base: BaseParameters, seed: int) -> FloatArray:
    """Draw standard parameters (s,) of links with the usual sizes and masses of arms."""
    draw, size = np.random.default_rng(seed), reach(robot)
    values: dict[str, float] = {}
    for joint in (*robot.bodies[: -len(robot.joints)], *robot.moving):
        mass = draw.uniform(*_MASS)
        centre = _SIZE * size * draw.uniform(-1, 1, 3)
        inertia = mass * (_SIZE * size) ** 2
        body = Body(joint.number, mass, centre, inertia * np.eye(3))
        keys = (f"{key}{joint.number}" for key in names.LINK)
        values |= dict(zip(keys, body.standard, strict=True))
        values[f"{names.ROTOR}{joint.number}"] = inertia if joint.turns else mass
    return np.array([values.get(p.name, 0.0) for p in base.standard])


def _short(number: float) -> float:
    return float(f"{number:.{_DIGITS}g}")

"""Link parameters that could exist, from base parameters: a semidefinite program.

Base parameters X = G s fix no more than combinations of the standard parameters s. They are
realisable when some s gives them with every link a body of positive mass density, and friction and
rotor inertia not negative:

    G s = X,   [[S_j, m_j], [m_j', M_j]] positive definite for each link j,   IA, FS, FV >= 0

(Sousa and Cortesao 2014; Traversaro, Brossette, Escande, Nori 2016; Wensing, Kim, Slotine 2018).
The programs are in feasibility.py.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symgen.codegen.model import Model
from symgen.errors import ParameterError
from symgen.identification.estimate import Consistency
from symgen.identification.physical.bodies import bodies
from symgen.identification.physical.feasibility import Feasibility
from symgen.robot.body import Body

FloatArray = NDArray[np.float64]
CAVEAT = (
    "base parameters do not determine link parameters: these are one of infinitely many sets that "
    "give the same torques, and a single mass or centre need not be the robot's"
)


@dataclass(frozen=True, eq=False)
class LinkParameters:
    """Standard parameters of all links that could exist and give certain base parameters.

    Attributes:
        values: every standard parameter by name, in the order of the model.
        X: the base parameters that they give, (p,).
        sigmas: distance d of X from what was asked for, sqrt(d' C^-1 d); 0 where it is met.
        bodies: mass, centre and inertia of the link behind each joint.
        caveat: what these numbers are not.
    """

    values: Mapping[str, float]
    X: FloatArray
    sigmas: float
    bodies: tuple[Body, ...]
    caveat: str = CAVEAT


def link_parameters(
    model: Model,
    X: Sequence[float] | FloatArray,
    *,
    prior: Mapping[str, float] | None = None,
    nearest: FloatArray | None = None,
) -> LinkParameters:
    """Find link parameters that could exist and give the base parameters X.

    Of all such sets it returns the closest to the prior, in units of a typical length and mass of
    the robot; without a prior, the smallest.

    Args:
        model: from `derive`.
        X: base parameters (p,), for example `estimate.X`.
        prior: standard parameters by name, from CAD for example. Those that it does not name are
            kept small, with a thousandth of the weight.
        nearest: covariance (p, p) of X, for example `estimate.covariance`. With it, an X that no
            robot can have gives way to the nearest one that a robot can have, and `sigmas` tells
            how far that is.

    Raises:
        ParameterError: no link parameters give X (the message says why), or X or the prior are not
            this robot's.
    """
    problem = Feasibility(model, X)
    prior = prior or {}
    problem.require(prior)
    fault = problem.fault()
    sigmas = 0.0
    if fault:
        if nearest is None:
            raise ParameterError(
                f"{model.robot.name}: no link parameters give these base parameters: {fault}; "
                "accepted: nearest=covariance of X, for the nearest that a robot can have"
            )
        near, sigmas = problem.nearest(np.asarray(nearest, dtype=float))
        problem = Feasibility(model, near)
    s = problem.closest(prior)
    values = dict(zip(problem.names, map(float, s), strict=True))
    return LinkParameters(values, problem.X, sigmas, bodies(model.robot, values))


def nearest_consistent(
    model: Model,
    X: FloatArray,
    covariance: FloatArray,
    divergence: float = 0.0,
    towards: Mapping[str, float] | None = None,
) -> tuple[FloatArray, float]:
    """Return the nearest base parameters that a robot can have, and how far they are.

        minimise 1/2 (X - X0)' C^-1 (X - X0) + divergence * sum over links of D(P_j, P0_j),
        D(P, P0) = tr(P0^-1 P) - log det P        (Lee, Wensing, Park 2020), up to a constant

    over parameters of links whose pseudo-inertias P_j are positive definite, with friction and
    rotor inertia not negative.

    Args:
        model: whose parameters they are.
        X: base parameters X0, (p,).
        covariance: C of X0, (p, p).
        divergence: weight of the log-det prior; 0 for none.
        towards: standard parameters by name, whose pseudo-inertias are P0; links that it does not
            give, or gives as impossible, have the unit matrix in the robot's units.

    Returns:
        The base parameters, and sqrt((X - X0)' C^-1 (X - X0)): 0 where X0 is possible and there is
        no log-det prior.

    Raises:
        ParameterError: the solver finds no solution, or what it finds is not
            possible after all.
    """
    problem = Feasibility(model, X)
    problem.require(towards or {})
    if divergence == 0 and not problem.fault():
        return problem.X, 0.0
    near, sigmas = problem.nearest(covariance, divergence, towards or {})
    fault = Feasibility(model, near).fault()
    if fault:
        raise ParameterError(f"{model.robot.name}: no consistent parameters are found: {fault}")
    return near, sigmas


def consistency(model: Model, X: FloatArray, covariance: FloatArray) -> Consistency:
    """Say whether a robot could have these base parameters, and how far the nearest are.

    Args:
        model: whose parameters they are.
        X: base parameters (p,).
        covariance: of X, (p, p).
    """
    try:
        problem = Feasibility(model, X)
        fault = problem.fault()
    except ParameterError as error:
        return Consistency(None, None, f"not checked: {error}")
    if not fault:
        return Consistency(True, 0.0, "bodies of positive mass can have these base parameters")
    try:
        near, sigmas = problem.nearest(covariance)
    except ParameterError as error:
        return Consistency(False, None, f"{fault}; the nearest that can is unknown: {error}")
    moves = np.abs(near - X) / np.sqrt(np.diag(covariance))
    worst = int(np.argmax(moves))
    return Consistency(
        False,
        sigmas,
        f"{fault}; the nearest that can is {sigmas:.3g} sigmas away, {model.base.names[worst]} by "
        f"{moves[worst]:.2g} of its own (noise alone: up to {_noise(len(X)):.2g})",
    )


def _noise(p: int) -> float:
    """Return the distance from p estimates to the truth that noise exceeds once in twenty.

    Fisher's approximation of the quantile of chi with p degrees of freedom.
    """
    return (math.sqrt(2 * p - 1) + 1.645) / math.sqrt(2)

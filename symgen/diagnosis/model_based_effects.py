"""Candidates that need the model itself: base_tilt, geometry_error, joint_elasticity, payload.

Their columns are derivatives of the links' torque by what is not as the file says, taken at the
link parameters of the current estimate. Base parameters do not determine those: what they leave
open has no torque in the file's own geometry and gravity, but may have one in another.

* Lengths: the open directions Z(d) satisfy Y(d) Z(d) = 0, hence (dY/dd) Z = -Y dZ/dd, which the
  model itself can say. Only lengths that are not zero are tried, since others change the set.
* Gravity: (dY/dg) Z is no torque of the model. Its columns, such as those of MX1 and MY1 of an
  upright first axis, stand beside those of the tilt, and get a coefficient each that means nothing.
* Elasticity and load leave geometry and gravity alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache, partial

import numpy as np
from numpy.typing import NDArray

from symgen import names
from symgen.data.signals import differentiate
from symgen.diagnosis.candidates import Candidate
from symgen.diagnosis.evidence import Columns, Evidence, Scene
from symgen.diagnosis.shapes import Torques
from symgen.diagnosis.stiffness import deflection, stiffnesses
from symgen.robot.effect import definitions, unit
from symgen.robot.types import Robot
from symgen.symbolic.independence import random_states
from symgen.symbolic.variation import Variation, variation

FloatArray = NDArray[np.float64]
_STEP = 1e-2  # m; torque is a polynomial in the lengths, of degree two
_SHIFT = 1e-4  # of the range of the motion, of the directional derivative of an elastic joint
_STATES = 200
_DEPENDENT = 1e-8
#: The load's parameters, those first that are told when several say the same.
_LOAD = (names.MASS, *names.MOMENT, "ZZ", "XX", "YY", "XY", "XZ", "YZ")


def special_candidates(
    robot: Robot, evidence: Evidence, chosen: Sequence[str] | None = None, *, given: bool = False
) -> Iterator[Candidate]:
    """Yield the candidates of a robot that need its model.

    Args:
        robot: the mechanism.
        evidence: what they are to explain.
        chosen: names of effects to try; None for all.
        given: whether the parameters are given: then a load shows, and a length that the robot
            always had does not.
    """
    kinds: dict[str, Callable[[Robot, Evidence], Iterator[Candidate]]] = {
        "base_tilt": _tilts,
        "joint_elasticity": _elastic,
        ("payload" if given else "geometry_error"): _loads if given else _lengths,
    }
    for name, make in kinds.items():
        if chosen is None or name in chosen:
            yield from make(robot, evidence)


def _everywhere(torque: FloatArray) -> Columns:
    """Return columns (N, n, m) by joint."""
    return {j: torque[:, j] for j in range(torque.shape[1])}


def _tilts(robot: Robot, _: Evidence) -> Iterator[Candidate]:
    """Gravity turned about the two axes of frame 0 that are most upright to it: dg = -beta x g.

    The base turns by beta, so that gravity turns by -beta in frame 0.
    """
    v = variation(robot)
    gravity = v.gravity
    if not gravity.any():
        return
    axes = [
        axis
        for axis in sorted(np.argsort(np.abs(gravity), kind="stable")[:2])
        if _felt(v, -np.cross(np.eye(3)[axis], gravity))
    ]
    if not axes:
        return
    turned = [-np.cross(np.eye(3)[axis], gravity) for axis in axes]
    hidden = _hidden(v, turned)

    def columns(s: Scene, torques: Torques) -> Columns:
        along = [_weight(v, s.q, torques.links, g) for g in turned]
        for blends in hidden:
            pairs = zip(turned, blends, strict=True)
            along.append(np.sum([_weight(v, s.q, x, g) for g, x in pairs], axis=0))
        return _everywhere(np.stack(along, axis=-1))

    yield Candidate(
        definitions()["base_tilt"],
        (),
        columns,
        len(axes) + len(hidden),
        uses_model=True,
        coefficients=tuple((f"T{'XYZ'[axis]}", "rad") for axis in axes),
    )


def _weight(v: Variation, q: FloatArray, links: FloatArray, gravity: FloatArray) -> FloatArray:
    """Return the torque of gravity alone."""
    rest = np.zeros_like(q)
    return v.torque((q, rest, rest), links, gravity)


def _felt(v: Variation, gravity: FloatArray) -> bool:
    """Whether any link parameter has a torque under this gravity."""
    q = random_states(v.robot, _STATES)[0][:, None, :]
    units = np.eye(10 * len(v.robot.joints)).reshape(-1, len(v.robot.joints), 10)
    return float(np.abs(_weight(v, q, units, gravity)).max()) > _DEPENDENT


def _hidden(v: Variation, turned: Sequence[FloatArray]) -> list[FloatArray]:
    """Return what gravity in the directions `turned` shows and the file's own gravity does not.

    Returns:
        A list of (directions, links, 10), one set of link parameters for each direction of gravity,
        whose summed torque no parameters have in the file's gravity.
    """
    count = len(v.robot.joints)
    units = np.eye(10 * count).reshape(-1, count, 10)
    state = [x[:, None, :] for x in random_states(v.robot, _STATES)]
    Y = v.torque(state, units)
    rows = [_weight(v, state[0], units, g) for g in turned]
    flat = [y.transpose(0, 2, 1).reshape(-1, len(units)) for y in (Y, *rows)]
    size, turn = np.linalg.eigh(flat[0].T @ flat[0])
    kept = size > _DEPENDENT * size[-1]
    seen, open_ = turn[:, kept], turn[:, ~kept]
    basis = np.linalg.qr(flat[0] @ seen)[0]
    beside = np.concatenate([f @ open_ for f in flat[1:]], axis=1)
    beside = beside - basis @ (basis.T @ beside)
    values, blend = np.linalg.eigh(beside.T @ beside)
    found = blend[:, values > _DEPENDENT * size[-1]].T.reshape(-1, len(turned), open_.shape[1])
    return [(x @ open_.T).reshape(len(turned), count, 10) for x in found]


def _lengths(robot: Robot, _: Evidence) -> Iterator[Candidate]:
    """Each length that is not zero, of a robot whose other joints do not depend on it."""
    v = variation(robot)
    if robot.loops or any(j.follows is not None for j in robot.joints):
        return
    at = {joint.number: i for i, joint in enumerate(robot.movable)}
    for number, key in v.lengths:
        if number in at:
            yield Candidate(
                definitions()["geometry_error"],
                (at[number],),
                partial(_lengthened, v, number, key),
                1,
                uses_model=True,
                coefficients=((f"delta_{key}{number}", "m"),),
            )


def _lengthened(v: Variation, number: int, key: str, s: Scene, torques: Torques) -> Columns:
    """Return d tau / d length, less what other link parameters would give as well.

    How much of the derivative these can say depends on which of many sets `links` is.
    """
    state, inverse = _own_torques(v)
    slope = _slope(v, (number, key), state, torques.links)
    same = (inverse @ slope.ravel()).reshape(torques.links.shape)
    here = (s.q, s.qd, s.qdd)
    along = _slope(v, (number, key), here, torques.links) - v.torque(here, same)
    return _everywhere(along[:, :, None])


@lru_cache(maxsize=4)
def _own_torques(v: Variation) -> tuple[list[FloatArray], FloatArray]:
    """Return random states, and what link parameters (10 links,) give a torque at them."""
    count = len(v.robot.joints)
    state = random_states(v.robot, _STATES)
    units = np.eye(10 * count).reshape(-1, count, 10)
    Y = v.torque([x[:, None, :] for x in state], units).transpose(0, 2, 1)
    inverse: FloatArray = np.asarray(np.linalg.pinv(Y.reshape(-1, 10 * count), rcond=_DEPENDENT))
    return state, inverse


def _slope(
    v: Variation, length: tuple[int, str], state: Sequence[FloatArray], links: FloatArray
) -> FloatArray:
    """Return a central difference, exact for polynomials of degree two."""
    high, low = (v.torque(state, links, changes={length: step}) for step in (_STEP, -_STEP))
    out: FloatArray = (high - low) / (2 * _STEP)
    return out


def _elastic(robot: Robot, evidence: Evidence) -> Iterator[Candidate]:
    """Each joint, with a compliance between its motor, whose motion is measured, and its link.

    Where its link has an encoder, what it bends is measured, and its stiffness known apart.
    """
    v, definition = variation(robot), definitions()["joint_elasticity"]
    known = {s.joint: s.stiffness[0] for s in stiffnesses(evidence) if not s.fault}
    for j in range(robot.n):
        if j not in known:
            yield Candidate(definition, (j,), partial(_bent, v, j), 1, uses_model=True)
            continue
        joint, sigma = robot.movable[j], robot.movable[j].sigma
        told = [(f"CE{joint.number}", unit(definition.linear["CE"], sigma))]
        if joint.rotor_inertia:
            told.append((f"IA{joint.number}", names.unit("IA", sigma)))
        yield Candidate(
            definition,
            (j,),
            partial(_behind, v, j, known[j], joint.rotor_inertia),
            len(told),
            uses_model=True,
            coefficients=tuple(told),
            measured=True,
        )


def _behind(
    v: Variation, j: int, stiffness: float, rotor: bool, s: Scene, torques: Torques
) -> Columns:
    """Return K times what the links' torque changes by where joint j is as its link is.

    Its coefficient is 1/K where the links move as their encoder says. A rotor that base parameters
    join with the link moves as the motor does: the column of IA gives back what was taken with it.
    """
    own = np.eye(s.q.shape[1])[j]
    bent = deflection(s, j)
    rate = differentiate(bent, s.step)
    along = (bent, rate, differentiate(rate, s.step))
    state = (s.q, s.qd, s.qdd)
    moved = [x - a[:, None] * own for x, a in zip(state, along, strict=True)]
    change = v.torque(moved, torques.links) - v.torque(state, torques.links)
    columns = np.zeros((*change.shape, 1 + rotor))
    columns[:, :, 0] = stiffness * change
    if rotor:
        columns[:, j, 1] = along[2]
    return _everywhere(columns)


def _bent(v: Variation, j: int, s: Scene, torques: Torques) -> Columns:
    """Return d tau / d(1/K): q behind joint j is q - R/K, R the torque that the links ask of it.

    Minus the derivative of the links' torque along (R, R', R'') of joint j; friction and rotor are
    on the motor's side. A rotor that the base parameters join with the link counts as link, which
    makes 1/K too small.
    """
    state = (s.q, s.qd, s.qdd)
    R = v.torque(state, torques.links)[:, j]
    rate = np.gradient(s.smooth(R), s.step)
    along = (R, rate, np.gradient(rate, s.step))
    span = max(float(np.ptp(s.q[:, j])), 1e-9)
    step = _SHIFT * span / max(float(np.abs(R).max()), 1e-300)
    unit = np.eye(s.q.shape[1])[j]

    def shifted(h: float) -> FloatArray:
        moved = [x + h * a[:, None] * unit for x, a in zip(state, along, strict=True)]
        return v.torque(moved, torques.links)

    return _everywhere(((shifted(-step) - shifted(step)) / (2 * step))[:, :, None])


def _loads(robot: Robot, _: Evidence) -> Iterator[Candidate]:
    """A load on the last link that moves; of its ten parameters those that show by themselves."""
    last = robot.movable[-1].number
    v = variation(robot)
    units = _unit_loads(v, last)
    state = [x[:, None, :] for x in random_states(robot, _STATES)]
    Y = v.torque(state, units).transpose(0, 2, 1).reshape(-1, len(units))
    kept = _independent(Y)
    joined = np.linalg.lstsq(Y[:, kept], Y, rcond=None)[0]

    def told(row: int, i: int) -> str:
        """Return the parameter's name, with R where others that show join it."""
        others = np.delete(joined[row], kept)
        return f"{_LOAD[i]}L" + ("R" if np.abs(others).max(initial=0.0) > 1e-6 else "")

    sigma = robot.joint(last).sigma

    def columns(s: Scene, _: Torques) -> Columns:
        state = [x[:, None, :] for x in (s.q, s.qd, s.qdd)]
        return _everywhere(v.torque(state, units[kept]).transpose(0, 2, 1))

    if kept:
        yield Candidate(
            definitions()["payload"],
            (robot.n - 1,),
            columns,
            len(kept),
            coefficients=tuple(
                (told(row, i), names.unit(_LOAD[i], sigma)) for row, i in enumerate(kept)
            ),
        )


def _unit_loads(v: Variation, number: int) -> FloatArray:
    """Return, for each name of _LOAD, link parameters (10, links, 10) with a 1 on the last link."""
    out = np.zeros((len(_LOAD), len(v.robot.joints), len(names.LINK)))
    for i, prefix in enumerate(_LOAD):
        out[i, number - 1, names.LINK.index(prefix)] = 1.0
    return out


def _independent(Y: FloatArray) -> list[int]:
    """Return the first columns of Y of which none is a combination of those before it."""
    kept: list[int] = []
    Q = np.zeros((len(Y), 0))
    largest = float(np.linalg.norm(Y, axis=0).max(initial=0.0))
    for i, column in enumerate(Y.T):
        left = column - Q @ (Q.T @ column)
        left = left - Q @ (Q.T @ left)
        if np.linalg.norm(left) > _DEPENDENT * max(largest, 1e-300):
            kept.append(i)
            Q = np.column_stack([Q, left / np.linalg.norm(left)])
    return kept

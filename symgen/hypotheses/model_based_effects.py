"""Candidates that need the model: geometry, gravity, elasticity, backlash, and a load.

Their columns are derivatives of the links' torque with respect to a quantity of the file, at the
current link parameters. Base parameters do not determine all link parameters. An undetermined
combination has no torque in the file's geometry and gravity, but may have one in another.

* Lengths: the undetermined directions Z(d) satisfy Y(d) Z(d) = 0. Hence (dY/dd) Z = -Y dZ/dd, which
  the model contains. Zero lengths are not tried, because they change the base parameters.
* Gravity: (dY/dg) Z is not a torque of the model, as for MX1 and MY1 of an upright first axis. A
  tilt therefore has these columns too. Their coefficients have no meaning.
* Zero offsets: Y(q) Z = 0 in every posture, hence also with another zero.
* Elasticity, load and gravity compensation leave geometry and gravity unchanged.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import lru_cache, partial

import numpy as np

from symgen import names
from symgen.data.signals import differentiate, lowpass
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.solve import SINGULAR, identifiable_columns
from symgen.estimation.values import FloatArray
from symgen.hypotheses.effects import (
    Candidate,
    Constants,
    Logs,
    Torque,
    Torques,
    begun,
    constant_grid,
)
from symgen.hypotheses.score import Columns, everywhere
from symgen.hypotheses.stiffness import Stiffness, deflection
from symgen.robot.effect import definitions
from symgen.robot.types import Robot
from symgen.symbolic.sampling import random_base, random_states
from symgen.symbolic.variation import Variation, variation

_STEP = 1e-2  # m or rad, of a difference: torque is a polynomial of degree two in the lengths
_SHIFT = 1e-4  # step of the derivative along an elastic deflection, as a part of the joint's range
_STATES = 200
#: Integration step while the play is crossed, s; smallest link inertia as a part of the largest.
_FINE, _LIGHT = 1e-3, 1e-3
#: Parameters of the load; of equivalent ones, the first is reported.
_POINT = (names.MASS, *names.MOMENT)
_LOAD = (*_POINT, "ZZ", "XX", "YY", "XY", "XZ", "YZ")


def special_candidates(
    robot: Robot, bent: Sequence[Stiffness], *, fixed: bool = False, logs: Logs = ()
) -> Iterator[Candidate]:
    """Yield the candidates of a robot that need its model.

    Args:
        robot: the mechanism.
        bent: results of second encoders.
        fixed: whether the parameters are fixed. Then a load is a candidate. A length is not,
            because it does not change after the parameters are identified.
        logs: logs in which a load may begin.
    """
    yield from _tilts(robot, fixed)
    yield from _elastic(robot, bent)
    yield from _loose(robot)
    yield from _on_joints(robot)
    if variation(robot).gravity.any() and not robot.imu:
        yield _of_links("commanded_torque", (), _dynamic)
    if not fixed:  # the link parameters include a load that is there in all logs
        yield from _lengths(robot)
    inner = {joint.antecedent for joint in robot.movable}
    for position, number in enumerate(robot.numbers):
        if number in inner:  # a load is on a last link
            continue
        if fixed:
            yield from _load(robot, position, _LOAD)
        for point in _load(robot, position, _POINT):
            yield from begun(point, logs)


def _random(v: Variation, links: FloatArray, gravity: FloatArray | None = None) -> FloatArray:
    """Return the torque of m sets of link parameters at random states, (states n, m).

    If `gravity` is not None, it is the torque of this gravity alone.
    """
    q, qd, qdd = random_states(v.robot, _STATES)
    if gravity is not None:
        qd, qdd = np.zeros((2, *q.shape))
    state = (q, qd, qdd, *random_base(v.robot, _STATES))
    return v.regressor(state, links, gravity).reshape(-1, len(links))


def _tilts(robot: Robot, fixed: bool) -> Iterator[Candidate]:
    """Yield a small tilt of the base about the two axes of frame 0 most normal to gravity.

    The base turns by beta, so gravity turns by -beta in frame 0: dg = -beta x g. With fixed
    parameters, torque is linear in gravity, so the three components of dg describe any tilt. A
    robot with an IMU has no such candidate, because the IMU measures its tilt.
    """
    if robot.imu:
        return
    v = variation(robot)
    units = v.units
    axes = np.eye(3)
    normal = sorted(np.argsort(np.abs(v.gravity), kind="stable")[:2])
    changes = {f"T{'XYZ'[k]}": -np.cross(axes[k], v.gravity) for k in normal}
    if fixed:
        changes = {f"dg{axis}": g for axis, g in zip("xyz", axes, strict=True)}
    turned = {  # those that act on some link
        name: g for name, g in changes.items() if np.abs(_random(v, units, g)).max() > SINGULAR
    }
    if not turned:
        return
    fields = [*turned.values()]
    hidden = _hidden(v, fields)

    def columns(s: FilteredLog, torques: Torques, _: Constants) -> Columns:
        rest = np.zeros((1, robot.n))
        state = (s.q, rest, rest)
        along = [v.torque(state, torques.links, g) for g in fields]
        for blend in hidden:
            parts = [v.torque(state, links, g) for links, g in zip(blend, fields, strict=True)]
            along.append(np.sum(parts, axis=0))
        return everywhere(np.stack(along, axis=-1))

    coefficients = tuple((name, "m/s2" if fixed else "rad") for name in turned)
    tilt = _of_links("base_tilt", (), columns, [1.0] * len(turned), coefficients)
    yield replace(tilt, size=len(turned) + len(hidden), first_order=not fixed)


def _hidden(v: Variation, fields: Sequence[FloatArray]) -> FloatArray:
    """Return link parameters with a torque in other gravities but none in that of the file.

    Returns:
        (directions, fields, links, 10): one set for each field. The model cannot produce the sum of
        their torques in the gravity of the file.
    """
    units = v.units
    model, size, turn = np.linalg.svd(_random(v, units), full_matrices=False)
    least = SINGULAR * size.max()
    model, without = model[:, size > least], turn[size <= least].T
    others = np.concatenate([_random(v, units, g) @ without for g in fields], axis=1)
    _, values, blend = np.linalg.svd(others - model @ (model.T @ others), full_matrices=False)
    sets = blend[values > least].reshape(-1, len(fields), without.shape[1]) @ without.T
    return np.asarray(sets.reshape(-1, len(fields), len(v.robot.moving), 10))


def _lengths(robot: Robot) -> Iterator[Candidate]:
    """Yield an error of each non-zero length, for robots without loops and following joints."""
    v, plain = variation(robot), robot.with_values()
    if robot.loops or any(j.follows is not None for j in robot.joints):
        return
    at = {joint.number: i for i, joint in enumerate(robot.movable)}
    for number, key in v.lengths:
        if number in at:
            length = abs(float(getattr(plain.joint(number), key)))
            coefficients = ((f"delta_{key}{number}", "m"),)
            torque = partial(_lengthened, v, (number, key))
            yield _of_links("geometry_error", (at[number],), torque, [length], coefficients)


def _lengthened(
    v: Variation, length: tuple[int, str], s: FilteredLog, torques: Torques, _: Constants
) -> Columns:
    """Return d tau / d length, for one of many equivalent sets of link parameters."""
    state = s.motion
    links, g = torques.links, torques.gravity
    return _column(_slope(lambda h: v.torque(state, links, g, {length: h})))


def _slope(torque: Callable[[float], FloatArray], step: float = _STEP) -> FloatArray:
    """Return a central difference at 0; it is exact for polynomials of degree two."""
    low, high = torque(-step), torque(step)
    return (high - low) / (2 * step)


def _on_joints(robot: Robot) -> Iterator[Candidate]:
    """Yield a zero offset, a wrong gear ratio and gravity compensation of each joint."""
    heavy = variation(robot).gravity.any() and not robot.imu
    for j, joint in enumerate(robot.movable):
        if joint.sigma == names.REVOLUTE and joint.follows is None:
            yield _of_links("zero_offset", (j,), partial(_offset, j))
        if robot.n > 1:
            column = _of_links("gear_ratio", (j,), partial(_geared, j))
            yield replace(column, analytic=False, first_order=True)
        if heavy:
            yield _of_links("gravity_compensation", (j,), partial(_compensated, j))


def _offset(j: int, s: FilteredLog, torques: Torques, _: Constants) -> Columns:
    """Return d tau / d zero offset: the link is at q + DZ."""
    unit = np.array([[1.0], [0.0], [0.0]])
    return _column(_slope(lambda h: torques.moved(s, j, h * unit)))


def _geared(j: int, s: FilteredLog, torques: Torques, _: Constants) -> Columns:
    """Return d tau / d gear ratio: the motion is multiplied and the torque divided by 1 + GR."""
    motion = np.array([x[:, j] for x in s.motion[:3]])
    columns = _slope(lambda h: torques.moved(s, j, h * motion))
    columns[:, j] += torques.model[:, j]
    return _column(columns)


def _compensated(j: int, s: FilteredLog, torques: Torques, _: Constants) -> Columns:
    """Return minus the gravity torque of a joint; compensation takes a share of it."""
    return {j: -torques.weight(s)[:, [j]]}


def _dynamic(s: FilteredLog, torques: Torques, _: Constants) -> Columns:
    """Return minus the torque of the motion; commanded torques lack a share of it."""
    return _column(torques.weight(s) - torques.rigid(s))


def _column(torque: FloatArray) -> Columns:
    """Return a torque (N, n) as one column on all joints."""
    return everywhere(torque[:, :, None])


def _of_links(
    name: str,
    joints: tuple[int, ...],
    torque: Torque,
    sizes: Sequence[float] = (1.0,),
    coefficients: tuple[tuple[str, str], ...] = (),
) -> Candidate:
    """Return a candidate whose columns come from the links' torque.

    Args:
        name: name of the effect.
        joints: positions; empty for all.
        torque: function that returns the columns.
        sizes: factor of each coefficient on its expected size.
        coefficients: name and unit of the coefficients; empty for those of the library.
    """
    definition = definitions()[name]
    return Candidate(
        definition,
        joints,
        torque,
        len(sizes),
        uses_model=True,
        analytic=True,
        coefficients=coefficients,
        scales=tuple(definition.expected * size for size in sizes),
    )


def _elastic(robot: Robot, bent: Sequence[Stiffness]) -> Iterator[Candidate]:
    """Yield a compliance of each joint, between its measured motor and its link.

    If the link has an encoder, it measures the deflection, and the stiffness is fitted separately.
    """
    definition = definitions()["joint_elasticity"]
    known = {s.joint: s.stiffness[0] for s in bent if not s.why}
    for j, joint in enumerate(robot.movable):
        if j not in known:
            yield Candidate(definition, (j,), partial(_bent, j), 1, uses_model=True)
            continue
        coefficients = [*definition.coefficients(joint.number, joint.sigma)]
        if joint.rotor_inertia:
            coefficients.append((f"IA{joint.number}", names.unit("IA", joint.sigma)))
        yield Candidate(
            definition,
            (j,),
            partial(_behind, j, known[j], joint.rotor_inertia),
            len(coefficients),
            uses_model=True,
            coefficients=tuple(coefficients),
            measured=True,
        )


def _behind(
    j: int, stiffness: float, rotor: bool, s: FilteredLog, torques: Torques, _: Constants
) -> Columns:
    """Return K times the change of the links' torque if joint j takes the position of its link.

    The coefficient is 1/K if the links move as their encoder measures. A rotor that base parameters
    regroup with the link moves with the motor, and the column of IA restores its torque.
    """
    bent = deflection(s, j)
    rate = differentiate(bent, s.step)
    along = np.stack([bent, rate, differentiate(rate, s.step)])
    change = torques.moved(s, j, -along) - torques.rigid(s)
    columns = np.zeros((*change.shape, 1 + rotor))
    columns[:, :, 0] = stiffness * change
    if rotor:
        columns[:, j, 1] = along[2]
    return everywhere(columns)


def _bent(j: int, s: FilteredLog, torques: Torques, _: Constants) -> Columns:
    """Return d tau / d(1/K): the link of joint j is at q - R/K, with its torque R.

    This is minus the derivative of the links' torque along (R, R', R'') of joint j. Friction and
    rotor are on the motor side. A rotor that base parameters regroup with the link counts as part
    of the link. This makes 1/K too small.
    """
    R, band = torques.rigid(s)[:, j], s.rows.cutoff
    rate = np.gradient(R if band is None else lowpass(R, s.step, band), s.step)
    along = np.stack([R, rate, np.gradient(rate, s.step)])
    span = max(float(np.ptp(s.q[:, j])), 1e-9)
    step = _SHIFT * span / max(float(np.abs(R).max()), 1e-300)
    return _column(-_slope(lambda h: torques.moved(s, j, h * along), step))


def _loose(robot: Robot) -> Iterator[Candidate]:
    """Yield backlash of each joint, between its measured motor and its link.

    The sign s of the transmitted torque decides which flank is in contact. This is the torque of
    the links, without rotor and friction. The link is at

        q - e,     e = s b/2.

    If the torque changes sign, the flanks separate. The gear then transmits no torque, and the link
    lags behind the motor because the torque R = torque at (q, qd, qdd) is missing:

        M e'' = R,     M inertia of the links about the joint,

    until it meets a flank and stays there (plastic impact). The torque of all joints changes by

        torque of the links at (q - e, qd - e', qdd - e'') - torque at (q, qd, qdd).

    This change has three parts:

    * a step d(torque)/dq b, with the sign of the transmitted torque and not of the speed;
    * a missing link torque while the play is crossed. If R changes at a constant rate, this takes
      (6 b M / |dR/dt|)^(1/3);
    * a shock that gives the link the speed of the motor.

    The width b is the coefficient. It also shapes the crossing, so the column is change(b)/b. A
    rotor that base parameters regroup with the link counts as part of the link.

    Nordin and Gutman 2002, Controlling mechanical systems with backlash - a survey, Automatica 38.
    """
    definition = definitions()["backlash"]
    for j in range(robot.n):
        plain = Candidate(definition, (j,), partial(_across, j), 1, uses_model=True)
        for constants in constant_grid(robot, definition.nonlinear, (), j):
            yield replace(plain, constants=constants, scales=(constants["width"],))


def _across(j: int, s: FilteredLog, torques: Torques, constants: Constants) -> Columns:
    """Return the change of all joint torques due to a play, divided by its width."""
    width = constants["width"]
    rigid, pull = _pull(j, s, torques)
    lead = _lead(pull, s.step, width)
    rate = np.gradient(lead, s.step)
    along = np.stack([lead, rate, np.gradient(rate, s.step)])
    return _column((torques.moved(s, j, -along) - rigid) / width)


@lru_cache(maxsize=8)
def _pull(j: int, s: FilteredLog, torques: Torques) -> tuple[FloatArray, FloatArray]:
    """Return the torque of the links, and the acceleration at which a free link lags behind."""
    unit = np.array([[0.0], [0.0], [1.0]])
    rigid = torques.rigid(s)
    inertia = (torques.moved(s, j, unit) - rigid)[:, j]
    least = _LIGHT * np.abs(inertia).max(initial=1e-300)
    return rigid, rigid[:, j] / np.maximum(inertia, least)


def _lead(pull: FloatArray, step: float, width: float) -> FloatArray:
    """Return the motor's lead over the link in a gear with play, (N,), within +-width/2.

    Args:
        pull: (N,) acceleration at which a link without torque lags behind, rad/s2 (m/s2). Its sign
            is that of the flank in contact.
        step: sampling step, s.
        width: width of the play, rad (m).
    """
    finer = max(1, int(np.ceil(step / _FINE)))
    count = (len(pull) - 1) * finer + 1
    fine = np.interp(np.arange(count) / finer, np.arange(len(pull)), pull)
    half, h = width / 2, step / finer
    out = np.where(fine < 0, -half, half)
    a, met = fine.data, 0  # items of a memoryview are floats
    for leaves in np.flatnonzero(np.diff(out)) + 1:
        if leaves < met:
            continue
        met, lead, speed = int(leaves), float(out[leaves - 1]), 0.0
        while met < count and (-half < lead < half or lead * a[met] < 0):
            speed += h * a[met]
            lead += h * speed
            if abs(lead) >= half:
                lead, speed = math.copysign(half, lead), 0.0
            out[met] = lead
            met += 1
    return out[::finer]


def _load(robot: Robot, position: int, prefixes: Sequence[str]) -> Iterator[Candidate]:
    """Yield a load on the link of a joint with its identifiable parameters, if there are any."""
    v, last = variation(robot), robot.movable[position]
    of_last = v.units[robot.moving.index(last) * len(names.LINK) :]
    units = np.array([of_last[names.LINK.index(prefix)] for prefix in prefixes])
    Y = _random(v, units)
    kept = identifiable_columns(Y).kept
    if not kept:
        return
    # R is appended to the name of a parameter with which others are regrouped.
    joined = np.abs(np.delete(np.linalg.lstsq(Y[:, kept], Y, rcond=None)[0], kept, axis=1))
    coefficients = []
    for row, index in zip(joined, kept, strict=True):
        prefix = prefixes[index]
        regrouped = "R" if row.max(initial=0.0) > SINGULAR else ""
        coefficients.append((f"{prefix}L{regrouped}", names.unit(prefix, last.sigma)))

    @lru_cache(maxsize=4)
    def along(s: FilteredLog) -> Columns:
        return everywhere(v.regressor(s.motion, units[kept]))

    load, joints = definitions()["payload"], (position,)
    yield Candidate(
        load, joints, lambda s, *_: along(s), len(kept), coefficients=tuple(coefficients)
    )

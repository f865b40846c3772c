"""Causes of a model error other than wrong parameters: they compete by one score.

All compete by the prediction of motion that they were not fitted on, in training and validation
logs together (`symgen.estimation.predictive_score`). The causes are the columns of
`symgen.faults.shapes`, gravity in another direction or missing, sets of wrong torque signs, and
channel faults that other finders would correct. Physics that the model may lack competes as well,
without a name. Other motion cannot predict an event such as a collision
(`symgen.estimation.events`).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from symgen import names
from symgen.data.mask import moving_joints
from symgen.estimation.decimation import BLOCK
from symgen.estimation.events import likeliest_event
from symgen.estimation.filtered_log import FilteredLog, kept_spans
from symgen.estimation.floor import noise_fit, unexplained_from
from symgen.estimation.misfit_evidence import MisfitEvidence
from symgen.estimation.predictive_score import (
    TEMPERATURE,
    Columns,
    dense,
    everywhere,
    price_of_size,
)
from symgen.estimation.summary import solve_gram
from symgen.estimation.values import FloatArray
from symgen.faults.fault import EVERYWHERE, MASKED, Fault
from symgen.faults.recorder import contact_fault, cut_torques, late_torques
from symgen.faults.scene import Rows, Scene, mean_inertia
from symgen.faults.shapes import FACTOR, KINDS, Shape, Sized
from symgen.faults.undo import completed, multiplied
from symgen.parallel import in_order, own_threads
from symgen.policy import LEAST, MISFIT, SURE
from symgen.runtime.evaluator import Evaluator

#: Largest remaining error, as a part of the error without it, for a cause that is named.
_CLEARER = 0.85
#: Log prior odds of missing physics, which most robots have, against one fault.
_RARE = math.log(1000.0)
TILT = math.radians(1.0)  # tilt that sound bases have
_TIMES = tuple(k / 6 for k in range(1, 6))  # parts of a log at which something may begin
_FADES = (0.1, 0.2, 0.4)  # time constants with which something may fade, as parts of a log
_NEAR = 8  # number of most probable causes that are tried again beside each set of physics
_MOST = 3  # sets of columns of physics without a name, for each joint
_TURNED = 12  # largest number of joints whose signs are tried in sets
_ROUNDS, _FAR = 4, 0.5  # of the Gauss-Newton method; largest change of gravity by one, relative
_DEPENDENT = 1e-10  # eigenvalue over the largest: a combination without torque
_HEAVY = (*names.MOMENT, names.MASS)  # parameters of a link that weigh
_WILD = 0.1  # of a joint's torque: error above which other gravity axes are tried
_AWAY = 1.0  # s, distance from masked samples
ANOTHER = 10.0  # factor above which a torque is in another unit
_CLOSE = 20.0  # nats to the most probable cause, up to which the exact size is computed
_SIZE = 0.3  # expected size of physics or a fault, as a part of the joint's torque
_ALIKE = ("clock", "command")  # causes with the same log: no physics is searched for behind either
_FEW = 2  # other causes that are named with the most probable one
_STEPS = 2  # of the Gauss-Newton method, for the size of a geometry error
_EXACT, _TRIES = 0.005, 5  # relative accuracy of a factor, and largest number of iterations
_STEPPED = 1e-4  # smallest factor; its inverse is the largest
_SHARE = 4.0  # largest share of the torque of the motion: a clock at half the rate
_SIGMAS = 3.0  # standard deviations above which a value is significant
_AT_END = 0.99  # part of a range above which the best fit lies outside


@dataclass(frozen=True, eq=False)
class Cause:
    """A possible cause of the model error.

    Attributes:
        kind: kind of its shape, or of a finder of its own; "" for no cause.
        joints: indices of the joints; empty for all.
        says: what is wrong and what to do; "" if it is no larger than in every robot.
        score: log-odds, from prediction and prior.
        left: (n,) held-out variance of the joints with the cause.
        shape: the shape with its columns; None if it has none.
        columns: those of the shape, or of the part of the logs in which it acts.
        value: the first coefficient.
        fault: the channel fault, if it can be undone; None if nothing in the logs can be corrected.
        regressor: (K, n, p) of the model with the cause, if it differs from that of the model.
        shares: shares of the torque of motion and of gravity that the logs contain.
    """

    kind: str
    joints: tuple[int, ...]
    says: str
    score: float
    left: FloatArray
    shape: Shape | None = None
    columns: Columns | None = None
    value: float = math.nan
    fault: Fault | None = None
    regressor: FloatArray | None = None
    shares: tuple[float, float] = (1.0, 1.0)

    @property
    def physics(self) -> bool:
        """Whether it is physics without a name."""
        return self.shape is not None and self.shape.physics


#: Finds causes that have fits of their own.
Finder = Callable[[Scene], Iterator[Cause]]


def _begun(scene: Scene) -> Iterator[tuple[str, FloatArray]]:
    """Yield possible courses of a change: a text, and the weight (K,) of the rows.

    It is in another log than the first, begins at some time, or grows along a log.
    """
    several = len(scene.rows.logs) > 1
    for k, (log, span) in enumerate(zip(scene.rows.logs, kept_spans(scene.rows.logs), strict=True)):
        own = np.zeros(len(scene.rows.y))
        own[span] = 1.0
        if several and k:
            yield f" in {log.name}", own
        length = log.compared_t[-1] - log.compared_t[0]
        for part in _TIMES:
            at = log.compared_t[0] + part * length
            yield f" in {log.name} from about {at:.3g} s on", own * (scene.rows.t > part)
        yield f" along {log.name}", own * scene.rows.t


def _fading(scene: Scene) -> Iterator[tuple[str, FloatArray]]:
    """Yield courses of what falls as a joint warms up, exp(-t/T): text, and weight (K,)."""
    for log, span in zip(scene.rows.logs, kept_spans(scene.rows.logs), strict=True):
        for part in _FADES:
            weight = np.zeros(len(scene.rows.y))
            weight[span] = np.exp(-scene.rows.t[span] / part)
            yield f" in {log.name}, most at its beginning", weight


def causes(
    scene: Scene, faults: Sequence[Fault] = (), repairs: Sequence[Fault] = ()
) -> tuple[Scene, list[Cause]]:
    """Return the possible causes beside more probable physics, the most probable first.

    Args:
        scene: the fitted model.
        faults: channel faults that compete as well, each with its undo.
        repairs: repairs of the logs.
    """
    # Measured speeds that needed no repair confirm the clock.
    derived = any(log.samples.velocity_derived for log in scene.rows.logs)
    clock = derived or any(r.kind == "speed" for r in repairs)
    special: Mapping[str, Finder] = {**SPECIAL, "command": partial(_scaled, clock=clock)}
    every = in_order(lambda make: [*make(scene)], KINDS.values(), own_threads())
    shapes = [*itertools.chain.from_iterable(every)]
    found = _all(scene, shapes, faults, special)
    sized = {c.shape: _sized(scene, c) for c in found[:_NEAR] if c.shape and c.shape.at}
    shapes = [sized.get(s, s) for s in shapes]
    again = _ordered(_linear(scene, [*sized.values()]), ())
    found = first = _ranked([*(c for c in found if c.shape not in sized), *again])
    # The free misfit names nothing and would hide missing physics, so it competes at the end.
    while (best := _lawful(found)) and len(scene.physics) < _MOST * scene.n:
        scene = replace(scene, physics=(*scene.physics, best.columns))
        # Other causes change little beside physics: the first of them show whether one is more
        # probable.
        near = [s for s in shapes if s.physics or s in [c.shape for c in found[:_NEAR]]]
        found = _ordered(_linear(scene, near), near) or found[1:]
    if not scene.physics:
        return scene, found
    # Physics makes no other cause more probable, except one that few rows show.
    likely = {c.kind for c in first if c.score > 0} | {"delay", "saturated"}
    likely |= {"command"} if "clock" in likely else set()  # one fit gives both
    return scene, _all(
        scene,
        shapes,
        [f for f in faults if f.kind in likely],
        {kind: find for kind, find in special.items() if kind in likely},
    )


def _lawful(found: Sequence[Cause]) -> Shape | None:
    """Return the most probable physics, if no cause but the free misfit is certain beside it.

    It may act on other joints than the most probable cause: then both are true, and the cause is
    as probable beside it.
    """
    named = [c for c in found if c.shape is None or not c.shape.free]
    best = next((c for c in named if c.physics and c.score > 0), None)
    return best.shape if best and named[0].score - best.score < SURE else None


def _all(
    scene: Scene,
    shapes: Sequence[Shape],
    faults: Sequence[Fault],
    special: Mapping[str, Finder],
) -> list[Cause]:
    """Return the possible causes beside a scene, and no cause, the most probable first."""
    alone = scene.score.alone
    nothing = Cause("", (), "", 0.0, alone.left)
    found = [nothing, *_linear(scene, shapes)]
    for own in in_order(lambda find: [*find(scene)], special.values(), own_threads()):
        found += own
    for fault in faults:
        if fault.kind != "delay":  # delays are tried for all joints together and for each joint
            found += _undone(scene, fault)
    return _ordered(found, shapes)


def _ordered(found: Iterable[Cause], shapes: Iterable[Shape]) -> list[Cause]:
    """Return causes with their prior odds, the most probable first; one of the physics is true."""
    odds = {True: math.log(max(1, sum(s.physics for s in shapes))), False: _RARE}
    whole = [replace(c, score=c.score - odds[c.physics]) if c.kind else c for c in found]
    return _ranked(whole)


def _ranked(found: Iterable[Cause]) -> list[Cause]:
    """Return causes, the most probable first."""
    return sorted(found, key=lambda c: -c.score)


def _sized(scene: Scene, cause: Cause) -> Shape:
    """Return the shape of a geometry error with its exact model, by the Gauss-Newton method.

    To first order, an error of several percent may look less like itself than like another cause.
    """
    shape, x = cause.shape, cause.value
    assert shape is not None
    assert shape.at is not None
    for _ in range(_STEPS):
        W = shape.at(x)
        X = scene.fitted(scene.blocks(W, scene.rows.weight))[0]
        shape = replace(
            shape, sized=Sized(x, W, everywhere(((W - scene.rows.W) @ X / x)[:, :, None]))
        )
        found = _tried(scene, shape, shape.columns, "", 0.0)
        if found is None or abs(found.value - x) < _EXACT * abs(x):
            break
        x = found.value
    return shape


def _linear(scene: Scene, shapes: Sequence[Shape]) -> list[Cause]:
    """Return the shapes that predict other motion, each with its most probable start time."""
    begun, fading = list(_begun(scene)), list(_fading(scene))
    found: dict[tuple[str, tuple[int, ...], Shape | None], list[Cause]] = {}
    for shape in shapes:
        tried = [_tried(scene, shape, shape.columns, "", 0.0)] if shape.always else []
        courses = [*begun, *(fading if shape.fades else ())] if shape.changes else []
        for when, weight in courses:
            columns = {j: c * weight[:, None] for j, c in shape.columns.items()}
            # The course is one of many, which has a prior cost.
            tried.append(_tried(scene, shape, columns, when, math.log(len(courses))))
        for cause in tried:
            if cause is not None and cause.score > 0:
                own = shape if shape.physics else None
                found.setdefault((cause.kind, cause.joints, own), []).append(cause)
    return [max(same, key=lambda c: c.score) for same in found.values()]


def _tried(scene: Scene, shape: Shape, columns: Columns, when: str, price: float) -> Cause | None:
    """Return a shape as a cause; None if its columns have no finite score or no effect."""
    whole = np.concatenate([c.ravel() for c in columns.values()])
    if not np.isfinite(whole).all() or not whole.any():
        return None
    score, start, W = scene.score, 0.0, None
    if shape.sized and not when:
        start, W, columns = shape.sized
        score = scene.scored(W)
    fit = score.beside(columns, shape.size)
    x = start + float(fit.coefficients[0])
    if not shape.within[0] < x < shape.within[1]:
        return None
    if shape.physics:  # as for effects
        part = float(np.max(fit.torque / scene.rows.size)) / _SIZE
        price += price_of_size(part)
    return Cause(
        f"{shape.kind} changes" if when else shape.kind,
        shape.joints,
        shape.says(x, when),
        fit.score - scene.score.alone.score - price,
        fit.left,
        shape,
        columns,
        x,
        None if when else _mendable(shape, x),
        W,
    )


def _mendable(shape: Shape, x: float) -> Fault | None:
    """Return the fault that a shape describes in the logs, with its undo."""
    if shape.undo is None:
        return None
    return Fault(
        EVERYWHERE, shape.channel, shape.says(x),
        kind=shape.kind, joints=shape.joints, value=1 + x, undo=shape.undo(x),
    )  # fmt: skip


def _undone(scene: Scene, fault: Fault, columns: Columns | None = None) -> Iterator[Cause]:
    """Yield a channel fault as a cause, scored in the units of the recorded torque.

    Args:
        scene: the fitted model.
        fault: the fault.
        columns: change of the corrected torque with the size of the fault, which each fold then
            fits to the others; None for a size that is known.
    """
    rows = scene.rows
    if fault.undo is None:
        return
    logs = tuple(map(fault.undo, rows.logs))
    if [len(a.kept) for a in logs] != [len(b.kept) for b in rows.logs]:
        return
    undone = rows.with_torques(logs)
    score = replace(scene, rows=undone).score
    gain = rows.size / undone.size if fault.kind in ("gain", "ratio") else np.ones(scene.n)
    more = float(score.counts.sum(axis=1) @ np.log(gain)) / TEMPERATURE
    now = score.beside(columns) if columns else score.alone
    was = scene.score.alone
    left = now.left * gain**2
    if (undone.weight < rows.weight).any():  # compare both on the same rows
        was = scene.scored(rows.W, undone.weight).alone
        left = left * scene.score.alone.left / np.maximum(was.left, 1e-300)
    told = now.score - more - was.score
    yield Cause(fault.kind, fault.joints, fault.fault, told, left, fault=fault)


def _exactly(scene: Scene, found: Sequence[Cause]) -> list[Cause]:
    """Return the causes, with exact scores for the first ones that can be undone.

    To first order, two faults of one joint may look alike.
    """

    def exact(c: Cause) -> list[Cause]:
        if not (c.shape and c.fault and found[0].score - c.score < _CLOSE):
            return [c]
        own = _undone(scene, *_exact_fault(scene.rows.evaluator, scene.rows.logs, c))
        return [replace(e, score=e.score - _RARE, columns=c.columns) for e in own]

    return _ranked(itertools.chain.from_iterable(in_order(exact, found, own_threads())))


def _upside_down(scene: Scene) -> Iterator[Cause]:
    """Yield gravity in the opposite direction."""
    yield from _weighing(
        scene, -1.0, "gravity points in the opposite direction: change the sign of gravity in the "
        "robot file"
    )  # fmt: skip


def _weightless(scene: Scene) -> Iterator[Cause]:
    """Yield torques that do not contain the weight of the links."""
    yield from _weighing(
        scene, 0.0, "the torques do not contain the weight of the links: they lack the gravity "
        "compensation of the controller; log the total torque of the motors"
    )  # fmt: skip


def _weighing(scene: Scene, share: float, says: str) -> Iterator[Cause]:
    """Yield a model whose links have a share of their weight."""
    rest = scene.rows.at_rest
    if np.any(rest):
        fit = scene.scored(scene.rows.W + (share - 1.0) * rest).alone
        kind = "weightless" if share == 0 else "upside down"
        better = fit.score - scene.score.alone.score
        yield Cause(kind, (), says, better, fit.left, shares=(1.0, share))


def _scaled(scene: Scene, clock: bool) -> Iterator[Cause]:
    """Yield a dynamic torque that is a share s of the model's, apart from gravity.

        tau = W0 X + s (W - W0) X,    W0 the regressor at rest

    A controller that compensates gravity, and feeds forward a share of the rest, commands this
    torque. A clock that is c times too fast gives it from any torque, s = 1/c^2. So do springs and
    counterweights that carry a share 1 - 1/s of the weight of the links. No log distinguishes the
    three, except by measured speeds that confirm the clock. Friction is free, hence the same for
    all.

    Args:
        scene: the fitted model.
        clock: true if no measured speed confirms the clock.
    """
    from scipy.optimize import minimize_scalar

    rest, p = scene.rows.at_rest, scene.rows.W.shape[2]
    if not np.any(rest):
        return
    moving = scene.rows.W - rest
    blocks = scene.blocks(np.concatenate([rest, moving], axis=2), scene.rows.weight)
    T = np.zeros((2 * p + 1, p + 1))
    T[:p, :p], T[-1, -1] = np.eye(p), 1.0

    def left(share: float) -> float:
        T[p:-1, :p] = share * np.eye(p)
        return float(np.sum(np.log(scene.fitted(replace(blocks, grams=T.T @ blocks.grams @ T))[1])))

    share = float(minimize_scalar(left, bounds=(0.0, _SHARE), method="bounded").x)
    if share > _AT_END * _SHARE:
        return  # a larger share would fit better: no size is found
    W = rest + share * moving
    X = scene.fitted(scene.blocks(W, scene.rows.weight))[0]
    # No fold knows the share of the others, like the size of other causes.
    fit = scene.scored(W).beside(everywhere(moving @ X[:, None]))
    slow = math.sqrt(share)
    fast = (
        f"t: the time stamps run about {1 / slow:.3g} times too fast: check the unit and the clock "
        "of t (--time-unit)"
    )
    asked = (
        "tau looks like a controller's command, with the weight of the links and about "
        f"{100 * share:.2g} % of the torque of the motion: log the measured torque or the motor "
        "current"
    )
    carried = (
        f"the motors carry about {100 / share:.2g} % of the weight of the links: springs or "
        "counterweights carry the rest, or gravity in the robot file is too large"
    )
    better = fit.score - scene.score.alone.score
    if share > 1:
        says = carried if 1 - 1 / share > FACTOR else ""
        yield Cause("carried", (), says, better, fit.left, regressor=W, shares=(share, 1.0))
    if clock:
        says = fast if abs(slow - 1) > FACTOR else ""
        yield Cause("clock", (), says, better, fit.left, regressor=W, shares=(share, 1.0))
    if share < 1:
        says = asked if 1 - share > FACTOR else ""
        yield Cause("command", (), says, better, fit.left, regressor=W, shares=(share, 1.0))


def _late(scene: Scene) -> Iterator[Cause]:
    """Yield torques that are late, of all joints or of one."""
    for fault in late_torques(scene):
        yield from _undone(scene, fault)


def _cut(scene: Scene) -> Iterator[Cause]:
    """Yield torques that are clipped at a limit: tau_j = min(max(W_j X, -L), L).

    X is fitted without the rows near the limit. These rows then count with the clipped model.
    """
    for fault, limit, weight in cut_torques(scene):
        (j,) = fault.joints
        score = scene.scored(scene.rows.W, weight)
        left = score.residual.copy()
        model = scene.rows.y[:, j] - left[:, j]
        cut = (weight[:, j] == 0) & (scene.rows.weight[:, j] > 0)
        whole = left[cut, j]
        clipped = whole + model[cut] - np.clip(model[cut], -limit[cut], limit[cut])
        if clipped @ clipped > _CLEARER**2 * (whole @ whole):
            continue  # the motion needs no more torque than was recorded
        left[:, j] += model - np.clip(model, -limit, limit)
        again = replace(score, residual=left, weight=scene.rows.weight)
        fit = again.fitted_without(weight == 0)
        better = fit.score - scene.score.alone.score
        yield Cause("saturated", fault.joints, fault.fault, better, fit.left, fault=fault)


def _lacks_friction(scene: Scene) -> Cause | None:
    """Return the cause that the torques are a command without Coulomb friction.

    Every drive has Coulomb friction, which steps at reversals. The test runs only if something is
    wrong that nothing else explains. Let c be the friction over the torque of a joint, averaged
    over joints with weights 1/variance. The cause applies if the mean is below what matters by 3
    std and no c is significantly larger than that, with either sign. The std come from fits without
    each fold.
    """
    rows = scene.rows
    base, movable = rows.evaluator.model.base, rows.evaluator.model.robot.movable
    joints = moving_joints([log.qd for log in rows.logs], rows.evaluator.model.robot.sigma)
    names_of = {p.name: k for k, p in enumerate(base.parameters)}
    found = {j: names_of.get(f"FS{movable[j].number}") for j in joints}
    if not found or None in found.values():
        return None
    columns = [k for k in found.values() if k is not None]
    size = rows.size[list(found)]
    apart = scene.score.apart[:, columns] / size
    std = np.sqrt((len(apart) - 1) * np.mean((apart - apart.mean(axis=0)) ** 2, axis=0))
    share, precision = scene.X[columns] / size, 1 / np.maximum(std, 1e-300) ** 2
    mean = float(share @ precision / precision.sum())
    most = mean + _SIGMAS / math.sqrt(precision.sum())
    if most > LEAST or (np.abs(share) > np.maximum(_SIGMAS * std, FACTOR)).any():
        return None
    return _command(
        rows,
        "no joint has Coulomb friction, and the residual is larger than noise",
        "if the drives have none, leave coulomb out of friction in the robot file",
    )


def _command(rows: Rows, sign: str, otherwise: str) -> Cause:
    says = (
        f"tau looks like a controller's command: {sign}; log the measured torque or the motor "
        f"current ({otherwise})"
    )
    return Cause("command", (), says, math.inf, rows.size)


def _directions(scene: Scene) -> Iterator[Cause]:
    """Yield the gravity direction that fits best, if it is not that of the file.

    The weights of the links are free parameters, separate from their inertias, for both directions.
    """
    v = scene.rows.variation
    own = v.gravity
    size = float(np.linalg.norm(own))
    if not size or scene.n < 2:
        return
    loud = bool((np.sqrt(scene.score.alone.left) / scene.rows.size > _WILD).any())
    every, moving = _fields(scene), scene.rows.W - scene.rows.at_rest
    fields = every[..., np.any(every, axis=(0, 1, 2))]
    field = _Field(scene, moving, fields)
    starts = [own]
    if loud:
        axes = [sign * size * e for e in np.eye(3) for sign in (1.0, -1.0)]
        starts = [own, min(axes, key=field.left)]
    best = min(map(field.turned, starts), key=field.left)
    if math.acos(float(np.clip(abs(best @ own) / size**2, 0.0, 1.0))) > TILT or best @ own < 0:
        best = min(best, -best, key=_tied(scene, every))  # the free weights fit both equally

    def model(g: FloatArray) -> FloatArray:
        return np.concatenate([moving, np.tensordot(g, fields, axes=1)], axis=2)

    angle = math.acos(float(np.clip(best @ own / size**2, -1.0, 1.0)))
    before, after = (scene.scored(model(g)).alone for g in (own, best))
    written = ", ".join(f"{x:.3g}" for x in best)
    says = (
        ""
        if angle <= TILT
        else (
            f"gravity is {math.degrees(angle):.2g} degrees off its direction in the robot file: "
            f"write gravity = [{written}], or check the base and the zeros of the joints"
        )
    )
    share = after.left / np.maximum(before.left, 1e-300)
    told = after.score - before.score
    yield Cause("gravity", (), says, told, scene.score.alone.left * share)


def _signs(scene: Scene) -> Iterator[Cause]:
    """Yield the set of torques with the wrong sign, if a non-empty set fits best.

    With y_j = s_j W_j X and joints weighted by their torque, the residual of the best X is a
    constant minus s' B s, with B_jk = b_j' A^-1 b_k. A set and its complement fit equally; the one
    with positive inertia is taken.
    """
    rows, n = scene.rows, scene.n
    if not 1 < n <= _TURNED:
        return
    weighed = rows.W * (rows.weight / rows.size)[:, :, None]
    scale = np.maximum(np.sqrt(np.sum(weighed**2, axis=(0, 1))), 1e-300)
    weighed = weighed / scale
    y = rows.y * rows.weight / rows.size
    A = np.einsum("kjp,kjq->pq", weighed, weighed, optimize=True)
    b = np.einsum("kjp,kj->jp", weighed, y)
    x = b @ np.linalg.pinv(A, hermitian=True)
    sets = np.array(list(itertools.product((1.0, -1.0), repeat=n - 1)))
    sets = np.column_stack([np.ones(len(sets)), sets])
    best = sets[np.argmax(np.einsum("sj,jk,sk->s", sets, b @ x.T, sets))]
    inertias = [mean_inertia(rows.evaluator, rows.logs, j) for j in range(n)]
    inertia = np.sum([own / size for own, size in zip(inertias, rows.size, strict=True)], axis=0)
    best = best if inertia @ (best @ x / scale) > 0 else -best
    joints = [j for j in scene.driven if best[j] < 0]
    if not joints:
        return
    told = ", ".join(f"tau{j + 1}" for j in joints)
    fit = replace(scene, rows=rows.turned(best)).score.alone
    says = f"{told} {'has' if len(joints) == 1 else 'have'} the wrong sign, or q and qd there have"
    undo = partial(multiplied, joints=tuple(joints), factor=-1.0, keys=("tau",))
    fault = Fault(EVERYWHERE, told, says, kind="sign", joints=tuple(joints), value=-1.0, undo=undo)
    better = fit.score - scene.score.alone.score
    yield Cause("sign", tuple(joints), says, better, fit.left, fault=fault)


def _units(scene: Scene) -> Iterator[Cause]:
    """Yield a torque in another unit, with a factor too large for a first-order column.

    Weighted least squares solves y_j / g = W_j X for X and 1/g together. The measured torque of
    joint j is a column, and the other joints determine X.
    """
    blocks = scene.blocks(scene.rows.W, scene.rows.weight)
    grams, p = blocks.grams[0], blocks.grams.shape[-1] - 1
    for j in scene.compared:
        whole = np.zeros((p + 2, p + 2))  # X, 1/g, and the torque of the other joints
        for i, (gram, size) in enumerate(zip(grams, blocks.size, strict=True)):
            own = np.arange(p + 2) != (p + 1 if i == j else p)
            signs = np.ones(p + 1)
            signs[-1] = -1.0 if i == j else 1.0
            whole[np.ix_(own, own)] += gram * np.outer(signs, signs) / size**2
        inverse = float(solve_gram(whole)[-1])
        if 1 / ANOTHER <= inverse <= ANOTHER or inverse <= 0:
            continue
        channel, factor = f"tau{j + 1}", 1 / inverse
        says = f"{channel} is {factor:.3g} times as large as the other joints require (unit)"
        undo = partial(multiplied, joints=(j,), factor=inverse, keys=("tau",))
        fault = Fault(EVERYWHERE, channel, says, kind="gain", joints=(j,), value=factor, undo=undo)
        yield from _undone(scene, fault)


def _fields(scene: Scene) -> FloatArray:
    """Return the weight columns of the links for gravity along each axis, (3, K, n, m)."""
    count = len(scene.rows.evaluator.model.robot.moving)
    every = np.eye(count * len(names.LINK)).reshape(count, len(names.LINK), count, -1)
    units = every[:, np.isin(names.LINK, _HEAVY)].reshape(-1, count, len(names.LINK))

    def weights(axis: FloatArray, q: FloatArray) -> FloatArray:
        rest = np.zeros((1, q.shape[1]))  # one for all states
        return scene.rows.variation.regressor((q, rest, rest), units, axis)

    return np.stack([scene.rows.held(partial(weights, axis)) for axis in np.eye(3)])


def _tied(scene: Scene, fields: FloatArray) -> Callable[[FloatArray], float]:
    """Return the misfit of links whose weight is their own, as a function of gravity (3,).

    It is the sum of the log residuals of the joints. The columns are those of the inertial
    parameters of the links, of rotor inertias and of friction. Their rank is that of the motion, so
    a basis of them is fitted.

    Args:
        scene: the fitted model.
        fields: the result of `_fields`.
    """
    rows, n, size = scene.rows, scene.n, len(names.LINK)
    links = len(rows.evaluator.model.robot.moving)
    units = np.eye(links * size).reshape(links * size, links, size)

    def columns(q: FloatArray, qd: FloatArray, qdd: FloatArray) -> FloatArray:
        weightless = rows.variation.regressor((q, qd, qdd), units, np.zeros(3))
        return np.concatenate([weightless, np.eye(n) * qdd[:, :, None]], axis=2)

    inertial = rows.evaluator.model.inertial
    own = np.concatenate([rows.along(columns, BLOCK, smooth=True), rows.W[:, :, inertial:]], axis=2)
    heavy = np.flatnonzero(np.tile(np.isin(names.LINK, _HEAVY), links))

    def misfit(g: FloatArray) -> float:
        W = own.copy()
        W[:, :, heavy] += np.tensordot(g, fields, axes=1)
        W = W / np.maximum(np.sqrt(np.mean(W**2, axis=(0, 1))), 1e-300)
        found, basis = np.linalg.eigh(np.einsum("knp,knq->pq", W, W, optimize=True))
        W = W @ basis[:, found > _DEPENDENT * found[-1]]
        return float(np.sum(np.log(scene.fitted(scene.blocks(W, rows.weight))[1])))

    return misfit


class _Field:
    """Fits of a model with free weights, for gravity in any direction.

    Args:
        scene: the fitted model.
        moving: (K, n, p) regressor without weight.
        fields: the columns of `_fields` that are not zero.
    """

    def __init__(self, scene: Scene, moving: FloatArray, fields: FloatArray) -> None:
        whole = np.concatenate([moving, *fields], axis=2)
        self.scene, self.blocks = scene, scene.blocks(whole, scene.rows.weight)
        self.moving, self.weights = moving.shape[2], fields.shape[3]

    def fitted(
        self, g: FloatArray, more: Sequence[FloatArray] = ()
    ) -> tuple[FloatArray, FloatArray]:
        """Return parameters and standard deviations for gravity g, with more weight columns."""
        p, m = self.moving, self.weights
        T = np.zeros((p + 3 * m + 1, p + m + len(more) + 1))
        T[:p, :p], T[-1, -1] = np.eye(p), 1.0
        T[p:-1, p : p + m] = np.kron(g[:, None], np.eye(m))
        for i, column in enumerate(more):
            T[p:-1, p + m + i] = column
        return self.scene.fitted(replace(self.blocks, grams=T.T @ self.blocks.grams @ T))

    def left(self, g: FloatArray) -> float:
        """Return the sum of the log residuals of the joints for gravity g."""
        return float(np.sum(np.log(self.fitted(g)[1])))

    def turned(self, g: FloatArray) -> FloatArray:
        """Return the best gravity direction near g, by the Gauss-Newton method."""
        size = float(np.linalg.norm(g))
        for _ in range(_ROUNDS):
            across = np.linalg.svd(g[None])[2][1:]
            weights = self.fitted(g)[0][self.moving :]
            step = self.fitted(g, [np.kron(a, weights) for a in across])[0][-2:]
            step *= min(1.0, _FAR * size / max(float(np.linalg.norm(step)), 1e-300))
            g = g + step @ across
            g = g * size / np.linalg.norm(g)
        return g


def _moments(scene: Scene) -> Iterator[Cause]:
    """Yield the most probable event of the training logs, without which the fit is better."""
    logs = scene.rows.logs[: scene.rows.train]
    event = likeliest_event(scene.score, logs)
    if event is None:
        return
    log = logs[event.log]
    near = (log.t >= event.start - _AWAY) & (log.t <= event.end + _AWAY)
    if log.mask is not None and log.mask.joint[near].any():
        return  # a channel is wrong there
    gained, fit = event.fit(scene.score)
    yield Cause("moment", (), contact_fault(event, log).fault, gained, fit.left)


#: Causes with fits of their own.
SPECIAL: Mapping[str, Finder] = {
    "upside down": _upside_down,
    "weightless": _weightless,
    "gravity": _directions,
    "sign": _signs,
    "gain": _units,
    "delay": _late,
    "saturated": _cut,
    "moment": _moments,
}


def find_cause(
    scene: Scene,
    faults: Sequence[Fault] = (),
    repairs: Sequence[Fault] = (),
    least: float = LEAST,
    undone: bool = False,
) -> Cause | None:
    """Return the cause that the data name; None if there is none, or none is certain.

    A cause is named if it lowers the error of a joint's torque, on motion that it was not fitted
    on, by what matters and by 15 %. This holds for every joint with an unexplained error
    (`symgen.estimation.floor`). It must also be larger than in every robot, and nine times as
    probable as physics without a name, and as no cause beside a misfit of any shape
    (`symgen.estimation.misfit_evidence`). Up to three causes that the data do not distinguish are
    named together.

    Args:
        scene: the model on the logs, in the band of the run.
        faults: channel faults that were found before.
        repairs: repairs of the logs.
        least: smallest torque that matters, as a part of the joint's torque.
        undone: whether the named cause will be undone. Then the 15 % are not required, because the
            search continues behind it.
    """
    rows = scene.rows
    if not (np.sqrt(scene.score.alone.left) / rows.size > least).any():
        return None
    beside, found = causes(scene, faults, repairs)
    found = _exactly(beside, found)
    if cause := _sure(beside, found, least, undone):
        return cause
    return _lacks_friction(scene) if beside.physics or found[0].kind else None


def _sure(scene: Scene, found: Sequence[Cause], least: float, undone: bool) -> Cause | None:
    """Return the first of the causes, most probable first, if it is certain; see `find_cause`."""
    rows, best, alone = scene.rows, _undoable(found), scene.score.alone.left
    fell, rose = np.sqrt(np.maximum([alone - best.left, best.left - alone], 0.0)) / rows.size
    part = 1.0 if undone and best.fault is not None and best.fault.undo is not None else _CLEARER
    clear = (fell >= least) & (best.left <= part**2 * alone)
    if best.physics or not clear.any() or not best.says:
        return None
    # A torque is in the equation of its joint alone, which no mended torque explains worse.
    torque = best.fault is not None and best.fault.channel.startswith("tau")
    if torque and (rose[list(best.joints)] >= least).any():
        return None
    noise = noise_fit(rows.evaluator, rows.logs, scene.whole).residual
    lost = np.sqrt(alone) / rows.size > unexplained_from(noise)[1]
    if part < 1.0 and not clear[lost].all():
        return None
    if best.score - _more_than_shown(scene, best) < SURE:
        return None
    if len(rows.logs) > rows.train and not _confirmed(rows, best, part):
        return None
    near = [c for c in found if c is not best and found[0].score - c.score < SURE]
    if best.kind == "delay":
        near = [c for c in near if (c.kind, c.joints) != ("filter", best.joints)]
    if len(near) > _FEW or any(c.physics or not c.says for c in near):
        return None
    # Many causes that are each less probable are together as probable as one.
    others = [c for c in found if c is not best and found[0].score - c.score >= SURE]
    if others and _total([best, *near]) - _total(others) < SURE:
        return None
    # Causes that the data do not distinguish are all named; then no kind is certain.
    told = "".join(f"; or {c.says.rpartition(': ')[0] or c.says}" for c in near)
    joints = tuple(sorted({j for c in (best, *near) for j in c.joints}))
    kind = best.kind if all(c.kind in (best.kind, *_ALIKE) for c in near) else ""
    return replace(best, kind=kind, joints=joints, says=f"{best.says}{told}")


def _more_than_shown(scene: Scene, cause: Cause) -> float:
    """Return how much less a cause explains beside a misfit of any shape, in nats; 0.0 or more.

    A model that misses a function of the state misses it in many rows alike, so that a column
    which resembles it predicts all of them. The misfit is that of a diagnosis.
    """
    if cause.columns is None:
        return 0.0
    rows, score, weight = scene.rows, scene.score, scene.rows.weight
    size = rows.misfit * rows.size
    evidence = MisfitEvidence(score.W, score.residual, weight, score.sigma, rows.waves, size)
    units = evidence.units(cause.columns, _SIZE * rows.size)
    alone = score.beside(cause.columns).score - score.alone.score
    return max(alone - evidence.of(cause.columns, units), 0.0)


def _undoable(found: Sequence[Cause]) -> Cause:
    """Return the most probable cause, or the delay that its filter may be as well."""
    first = found[0]
    late = (c for c in found if c.kind == "delay" and c.joints == first.joints)
    delay = next(late, first) if first.kind == "filter" else first
    return delay if first.score - delay.score < SURE else first


def _total(found: Sequence[Cause]) -> float:
    """Return the log-odds of one of some causes."""
    return float(np.logaddexp.reduce([c.score for c in found]))


def _confirmed(rows: Rows, cause: Cause, part: float) -> bool:
    """Whether a permanent cause, fitted to the training logs, lowers the validation error.

    The error has to fall to `part` for one joint, and in total as `identify` would measure it with
    the cause undone. A cause without columns and undo, with a mask, or with a start time is not
    tested.
    """
    shape, fault = cause.shape, cause.fault
    if fault is not None and fault.kind in MASKED:
        return True  # its undo removes the rows that show it
    if fault is not None and fault.undo is not None:
        mended = rows.with_torques(tuple(map(fault.undo, rows.logs)))
        other = mended.W, mended.y, mended.weight
    elif shape is not None and cause.columns is not None and cause.kind == shape.kind:
        own = rows.W if cause.regressor is None else cause.regressor
        both = [own, dense(cause.columns, rows.y.shape)]
        other = np.concatenate(both, axis=2), rows.y, rows.weight
    elif cause.regressor is not None:
        other = cause.regressor, rows.y, rows.weight
    else:
        return True
    train = np.zeros(len(rows.y), dtype=bool)
    for span in kept_spans(rows.logs)[: rows.train]:
        train[span] = True
    left = []
    for W, y, weight in ((rows.W, rows.y, rows.weight), other):
        weighed = replace(rows)
        weighed.__dict__.update(W=W, y=y, weight=weight * train[:, None])
        scene = Scene(weighed)
        X, _ = scene.fitted(scene.blocks(W, weighed.weight))
        judged = other[2][~train]  # the rows that both have
        error = (y - W @ X)[~train] * judged
        size = np.sum((y[~train] * judged) ** 2, axis=0)
        left.append(np.sum(error**2, axis=0) / np.maximum(size, 1e-300))
    ratio = left[1] / np.maximum(left[0], 1e-300)
    return bool(ratio.min() <= part**2 and np.log(np.maximum(ratio, 1e-300)).sum() < 0)


def unmendable(scene: Scene, cause: Cause) -> Fault:
    """Return the fault of a cause that needs a new record, with a correction for the search.

    The model computes the missing part of the torques, with the parameters that fit the recorded
    part.
    """
    model = scene.rows.evaluator
    X = _expected_parameters(scene, cause.shares)
    X = np.pad(X, (0, len(model.model.base.parameters) - len(X)))
    undo = partial(completed, torque=model["inverse_dynamics"], shares=cause.shares, X=X)
    return Fault(
        EVERYWHERE, "all", cause.says, kind=cause.kind, joints=cause.joints, undo=undo
    )  # fmt: skip


def _expected_parameters(scene: Scene, shares: tuple[float, float]) -> FloatArray:
    """Return X (p,) for torques with only a share of those of motion and of gravity.

    The torque of each parameter has a normal prior with the size of a joint's torque. It decides
    the parameters that the recorded part does not show.
    """
    rows, (moving, weight) = scene.rows, shares
    more = [dense(c, rows.y.shape) for c in scene.physics]
    whole = np.concatenate([rows.W, *more], axis=2)
    own = moving * rows.W + (weight - moving) * rows.at_rest
    held = np.concatenate([own, *more], axis=2)
    sigma = scene.fitted(scene.blocks(held, rows.weight))[1]
    each = rows.weight / sigma / math.sqrt(TEMPERATURE)
    A = (held * each[:, :, None]).reshape(rows.y.size, -1)
    size = np.mean(np.sum((whole / rows.size[:, None]) ** 2, axis=1), axis=0)
    found = np.linalg.solve(A.T @ A + np.diag(size + 1e-300), A.T @ (rows.y * each).ravel())
    return np.asarray(found[: rows.W.shape[2]])


def _exact_fault(
    evaluator: Evaluator, logs: Sequence[FilteredLog], cause: Cause
) -> tuple[Fault, Columns]:
    """Return the fault of a cause, with its size computed to half a percent by undoing it.

    The columns are those of its size in the corrected logs.

    Args:
        evaluator: the compiled model.
        logs: the logs with the fault.
        cause: a cause whose shape is a fault.
    """
    fault, x = cause.fault, cause.value
    assert fault is not None
    assert cause.shape is not None
    for _ in range(_TRIES):
        undone = [fault.undo(log) for log in logs]  # type: ignore[misc]
        scene = Scene(Rows(evaluator, tuple(undone), len(undone), MISFIT))
        left = next(s for s in KINDS[cause.kind](scene) if s.joints == cause.joints)
        more = float(scene.score.beside(left.columns).coefficients[0])
        x = (1 + x) * (1 + more) - 1
        if not cause.shape.within[0] < x < 1 / _STEPPED:  # no valid size
            break
        found = _mendable(cause.shape, x)
        assert found is not None
        fault = found
        if abs(more) < _EXACT:
            break
    return fault, left.columns

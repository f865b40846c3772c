"""Kernels of large trees as loops: templates of one body, applied joint by joint.

A straight tape of a large tree is more text than a cache holds. Its recursions repeat the same
steps for each joint, with other constants. Here, a `Sweep` holds these steps once for each kind of
joint, as the Tape of one body, and a `Program` applies sweeps along the tree. The constants stand
in a table with one row for each joint.

The templates come from the same functions as the straight tapes, applied to one joint whose
geometry, antecedent and parameters are symbols.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import sympy as sp

from symgen import names
from symgen.robot.types import Joint, Robot
from symgen.symbolic.articulated import (
    Articulated,
    Driven,
    accelerated,
    released,
    rigid,
)
from symgen.symbolic.base_parameters import BaseParameters
from symgen.symbolic.bodies import Inertia
from symgen.symbolic.derivatives import Screws, felt
from symgen.symbolic.kinematics import ARGUMENTS, Frame, Step, cosine_sine, next_frame
from symgen.symbolic.motion import REAL, REFERENCE, Motion, handed_back, passed
from symgen.symbolic.placement import Place, moved_place
from symgen.symbolic.spatial import (
    UPPER,
    ZERO,
    Screw,
    Shift,
    Turn,
    Vector,
    acting,
    axis,
    cross,
    matrix,
    moved,
    named,
    plus,
    scaled,
    symmetric,
    unit,
)
from symgen.symbolic.tape import Operations, Symbols, Tape, TapeBuilder, real_symbol

#: Orders of a sweep.
OUTWARD, INWARD, APART = "outward", "inward", "apart"
#: Suffix of an array whose row is that of the antecedent; other rows are the joint's own.
UP = "_up"
#: Columns that a solution takes at once. Their number is a constant, so that compilers use vectors.
COLUMNS = 8
#: Constants of a joint's transform.
GEOMETRY = ("cgamma", "sgamma", "b", "calpha", "salpha", "d", "r", "sharp")
#: Names of arrays and tables in the sources, which no step may have.
RESERVED = ARGUMENTS | set(
    "c s up i geometry body antecedent way order kind theta turns row column inverse".split()
)


@dataclass(frozen=True)
class Kind:
    """Joints that share templates.

    Attributes:
        sigma: their type.
        smooth: whether their Coulomb friction is smooth.
        aside: whether their axis is not on the x axis of the antecedent (gamma or b).
    """

    sigma: int
    smooth: bool
    aside: bool

    @property
    def name(self) -> str:
        """Name in the sources."""
        more = (", smooth friction" if self.smooth else "", ", aside" if self.aside else "")
        return ("revolute", "prismatic", "fixed")[self.sigma] + "".join(more)


@dataclass(frozen=True)
class Sweep:
    """Steps that every joint applies, from the base to the tips or back.

    Attributes:
        doc: what it computes.
        order: from the tips to the base (INWARD), from the base to the tips (OUTWARD), or in any
            order (APART): then, bodies use arrays of the state alone, and only their own rows.
        bodies: the template of each kind of joint. Its inputs are rows of tables and arrays, named
            as these. Its outputs are the entries of `written`. Bodies apart have one template, as
            have kinds that do not differ.
        written: rows that it writes, and their numbers of entries; to those of the antecedent, it
            adds.
    """

    doc: str
    order: str
    bodies: tuple[tuple[Kind, Tape], ...]
    written: tuple[tuple[str, int], ...]


@dataclass(frozen=True)
class Pairs:
    """Steps for each body j and each body `up` on its way to the base, itself included.

    Attributes:
        doc: what they compute.
        body: the template of two bodies.
        entries: where each of its outputs goes: names of the matrices whose entry in row j and
            column `up` it is, then of those whose entry in row `up` and column j it is.
        diagonal: a matrix, and the array of the state that is added to its diagonal.
    """

    doc: str
    body: Tape
    entries: tuple[tuple[tuple[str, ...], tuple[str, ...]], ...]
    diagonal: tuple[str, str] | None = None

    @property
    def matrices(self) -> tuple[str, ...]:
        """Names of the matrices."""
        return tuple(dict.fromkeys(name for both in self.entries for part in both for name in part))


@dataclass(frozen=True)
class Elimination:
    """Factors a symmetric matrix of pairs, from the tips: M = L' D L (Featherstone 2005).

    Attributes:
        doc: what it computes.
        matrix: the matrix, whose rows below the diagonal become those of L.
        into: outputs that become L' and D, if any.
    """

    doc: str
    matrix: str
    into: tuple[str, ...] = ()


@dataclass(frozen=True)
class Solution:
    """Solves M x = b with the factors of M.

    Attributes:
        doc: what it computes.
        matrix: the factored matrix M.
        right: b: a vector, or the negative of a matrix; the identity if empty.
        into: x: a vector, or a matrix.
        single: whether these are vectors: arrays of the state, an input or an output.
    """

    doc: str
    matrix: str
    right: str
    into: str
    single: bool = False


#: A step of a program.
Part = Sweep | Pairs | Elimination | Solution


@dataclass(frozen=True)
class Program:
    """A kernel as steps over the joints.

    Tables and arrays have the joints with a variable first, in its order, then the fixed ones.

    Attributes:
        kinds: the kind of each joint.
        order: place of each joint in these tables, antecedents first.
        antecedents: place of the joint before each joint, counted from 1; 0 is the base.
        way: the same among the joints with a variable, past the fixed ones.
        angles: angle of each joint about z, to which q of a revolute joint is added.
        columns: names of the columns of `geometry`.
        geometry: constants of each joint.
        parameters: names of the columns of the parameters of a body.
        places: for every entry of X, its row and column among the parameters of bodies.
        state: arrays with a row for the base, then for each joint, and the row of the base.
        steps: in their order.
        matrices: names of matrices over joints that are not outputs.
    """

    kinds: tuple[Kind, ...]
    order: tuple[int, ...]
    antecedents: tuple[int, ...]
    way: tuple[int, ...]
    angles: tuple[sp.Expr, ...]
    columns: tuple[str, ...]
    geometry: tuple[tuple[sp.Expr, ...], ...]
    parameters: tuple[str, ...]
    places: tuple[tuple[int, int], ...]
    state: tuple[tuple[str, tuple[sp.Expr, ...]], ...]
    steps: tuple[Part, ...]
    matrices: tuple[str, ...] = ()

    @property
    def paired(self) -> bool:
        """Whether it has pairs of joints."""
        return any(isinstance(step, Pairs) for step in self.steps)

    @property
    def width(self) -> int:
        """Columns that a solution takes at once."""
        many = any(isinstance(step, Solution) and not step.single for step in self.steps)
        return min(COLUMNS, len(self.way)) if many else 1

    @property
    def operations(self) -> Operations:
        """The operations of one evaluation, the angles included."""
        n = len(self.way)
        ways = [0]  # number of joints on the way to each joint, itself included
        for joint in self.way:
            ways.append(ways[joint] + 1)
        pairs = sum(ways)
        total = Operations(0, n, 0, len(self.kinds))
        for step in self.steps:
            if isinstance(step, Sweep):
                bodies = dict(step.bodies)
                for kind in self.kinds:
                    total = total.plus(bodies.get(kind, step.bodies[0][1]).operations)
                added = sum(size for name, size in step.written if name.endswith(UP))
                total = total.plus(Operations(0, added, 0, 0), len(self.kinds))
            elif isinstance(step, Pairs):
                total = total.plus(step.body.operations, pairs)
                total = total.plus(Operations(0, n if step.diagonal else 0, 0, 0))
            elif isinstance(step, Elimination):
                earlier = sum(way * (way - 1) // 2 for way in ways)
                total = total.plus(Operations(earlier + pairs - n, earlier, n, 0))
            else:
                width = self.width
                for end in (n,) if step.single else range(n, 0, -width):  # blocks of columns
                    rows = n if step.right else max(end, width)
                    used = 2 * sum(ways[1 : rows + 1]) - rows
                    total = total.plus(Operations(used, used, 0, 0), width)
        return total


def rollable(robot: Robot) -> bool:
    """Whether loops can compute a robot: each moving joint has a variable and a drive of its own.

    Effects are single terms of single joints, so a robot with any keeps its straight tapes.
    """
    plain = len(robot.moving) == robot.n
    return plain and not robot.couplings and not robot.effects


def inverse_dynamics(
    robot: Robot,
    base: BaseParameters,
    *,
    accelerating: bool = True,
    moving: bool = True,
    out: str = "tau",
) -> Program:
    """Return inverse dynamics as two sweeps: motions and wrenches outward, torques inward.

    Args:
        robot: it is `rollable`.
        base: its base parameters.
        accelerating: whether joints have accelerations; without them, C qd + g + friction.
        moving: whether joints have speeds; without them, the torque of gravity.
        out: name of the output.
    """
    table = _Table.of(robot, base)
    size = 9 if moving else 3

    def outward(at: _Template) -> Sequence[sp.Expr]:
        return _wrenched(at, size, accelerating)

    def inward(at: _Template) -> Sequence[sp.Expr]:
        back, torque = _torque(at, moving, "qdd" if accelerating else "")
        return (*back, *torque)

    sweeps = (
        table.sweep("Motion and wrench of each body.", outward, ("motion", size), ("wrench", 6)),
        table.sweep(_BACK, inward, (f"wrench{UP}", 6), (out, 1), order=INWARD),
    )
    return table.program((_base_motion(robot, size), ("wrench", _zeros(6))), sweeps)


def slotine_li_torque(robot: Robot, base: BaseParameters) -> Program:
    """Return the torque of a reference motion, as two sweeps like those of inverse dynamics.

    `symgen.symbolic.passive` has the equations and their source.

    Args:
        robot: it is `rollable`.
        base: its base parameters.
    """
    table = _Table.of(robot, base)

    def outward(at: _Template) -> Sequence[sp.Expr]:
        now = Motion(*at.vectors(f"motion{UP}", 4))
        speed = at.rate("qdr", True)
        rates = speed, speed, at.rate("qddr", True)
        now = passed(now, at.step(at.rate("qd", True)), rates, REFERENCE, at.tape)
        f, n = at.inertia.virtual_wrench(now, "0", at.tape, lambda v, x: named(v, x, at.tape))
        return (*now.w, *now.dw, *now.a, *now.turning, *f, *n)

    def inward(at: _Template) -> Sequence[sp.Expr]:
        back, torque = _torque(at, moving=True, faster="qddr")
        return (*back, *torque)

    sweeps = (
        table.sweep("Motion and wrench of each body.", outward, ("motion", 12), ("wrench", 6)),
        table.sweep(_BACK, inward, (f"wrench{UP}", 6), ("tau", 1), order=INWARD),
    )
    motion = (*_zeros(6), *(-g for g in robot.gravity), *_zeros(3))
    return table.program((("motion", motion), ("wrench", _zeros(6))), sweeps)


def generalized_momentum(robot: Robot, base: BaseParameters) -> Program:
    """Return p = M qd and C' qd - g as two sweeps.

    `symgen.symbolic.passive` has the equations. Weights go inward beside the momenta.

    Args:
        robot: it is `rollable`.
        base: its base parameters.
    """
    table = _Table.of(robot, base)

    def outward(at: _Template) -> Sequence[sp.Expr]:
        w, v, g = at.vectors(f"motion{UP}", 3)
        before, step = Frame(w, v, g, sp.S.Zero), at.step(at.rate("qd", True))
        now, body = next_frame(before, step, at.tape), at.inertia
        momentum, weight = body.momentum(now.twist), body.momentum((ZERO, now.g))
        return [x for v in (*now.twist, now.g, *momentum, *weight) for x in v]

    def inward(at: _Template) -> Sequence[sp.Expr]:
        momentum, weight, step = at.screw("momentum"), at.screw("weight"), at.step(sp.S.Zero)
        back = [handed_back(x, step, x_, at.tape) for x, x_ in ((momentum, "m"), (weight, "w"))]
        up = [x for screw in back for v in screw for x in v]
        if not at.moves:
            return up
        w, v, _ = at.vectors("motion", 3)
        screw = axis(at.kind.sigma)
        p = acting(momentum, screw) + at.value(names.ROTOR) * at.rate("qd", True)
        return (*up, p, acting(momentum, moved(screw, (w, v))) + acting(weight, screw))

    sweeps = (
        table.sweep(
            "Motion and gravity in the frame of each body, its momentum and weight.",
            outward,
            ("motion", 9),
            ("momentum", 6),
            ("weight", 6),
        ),
        table.sweep(
            "Momentum of each joint and its rate, and what the body before it carries.",
            inward,
            (f"momentum{UP}", 6),
            (f"weight{UP}", 6),
            ("p_out", 1),
            ("rate_out", 1),
            order=INWARD,
        ),
    )
    motion = "motion", (*_zeros(6), *robot.gravity)
    return table.program((motion, *_at_rest({"momentum": 6, "weight": 6})), sweeps)


def forward_dynamics(robot: Robot, base: BaseParameters) -> Program:
    """Return forward dynamics by articulated bodies as three sweeps.

    Motions and wrenches without accelerations go outward, articulated bodies inward, and
    accelerations outward.

    Args:
        robot: it is `rollable`.
        base: its base parameters.
    """
    table = _Table.of(robot, base)

    def outward(at: _Template) -> Sequence[sp.Expr]:
        return (*_wrenched(at, 9, accelerating=False), *_entries(rigid(at.inertia)))

    def inward(at: _Template) -> Sequence[sp.Expr]:
        step, own = at.step(sp.S.Zero), _articulated(at.rows("articulated", 27))
        back, torque = _torque(at, moving=True)
        pivot: list[sp.Expr] = []
        driven: list[sp.Expr] = []
        if at.moves:
            right = at.tape.name("b", at.rows("tau", 1)[0] - torque[0])
            guard, joint, own = released(at.tape, step, own, at.value(names.ROTOR), right)
            pivot, driven = [guard], [*joint.n, *joint.f, joint.driven]
        for motion in reversed(step.way):
            own = own.before(motion, at.tape)
        return (*back, *_entries(own), *driven, *pivot)

    def accelerations(at: _Template) -> Sequence[sp.Expr]:
        before, driven = at.rows(f"acceleration{UP}", 6), at.rows("driven", 7)
        own = Driven(driven[:3], driven[3:6], sp.S.One, driven[6]) if at.moves else None
        twist = before[:3], before[3:]
        (w, v), found = accelerated(at.tape, at.step(sp.S.Zero), own, twist)
        return (*w, *v, *([] if found is None else [found]))

    sweeps = (
        table.sweep(
            "Motion and wrench of each body without accelerations, and the body alone.",
            outward,
            ("motion", 9),
            ("wrench", 6),
            ("articulated", 27),
        ),
        table.sweep(
            "What drives each joint, and the articulated body that the body before it carries.",
            inward,
            (f"wrench{UP}", 6),
            (f"articulated{UP}", 27),
            ("driven", 7),
            ("guard", 1),
            order=INWARD,
        ),
        table.sweep(
            "Acceleration of each body and joint.", accelerations, ("acceleration", 6), ("qdd", 1)
        ),
    )
    sizes = {"wrench": 6, "articulated": 27, "driven": 7, "acceleration": 6}
    return table.program((_base_motion(robot, 9), *_at_rest(sizes)), sweeps)


def mass_matrix(robot: Robot, base: BaseParameters) -> Program:
    """Return the mass matrix: composite bodies, then the power of their forces on earlier joints.

    Screws and forces are about the origin of frame 0 and in its axes, so that each entry is one
    product.

    Args:
        robot: it is `rollable`.
        base: its base parameters.
    """
    return _massive(robot, base, "M")


def mass_matrix_factor(robot: Robot, base: BaseParameters) -> Program:
    """Return the factors of the mass matrix; arguments as for `mass_matrix`."""
    return _massive(robot, base, _MASS, Elimination(_FACTORS, _MASS, ("L_out", "D_out")))


def solve_mass_matrix(robot: Robot, base: BaseParameters) -> Program:
    """Return the solution of M x = b; arguments as for `mass_matrix`."""
    solution = Solution("Its solution.", _MASS, "b", "x", single=True)
    return _massive(robot, base, _MASS, Elimination(_FACTORS, _MASS), solution)


def _massive(robot: Robot, base: BaseParameters, into: str, *more: Part) -> Program:
    """Return the mass matrix, its lower half if it is no output, and steps that use it."""
    table = _Table.of(robot, base)

    def outward(at: _Template) -> Sequence[sp.Expr]:
        place, screw = at.placed()
        body = at.inertia.parameters.values()
        return (*(x for v in (*place, *screw) for x in v), *body, at.value(names.ROTOR))

    def inward(at: _Template) -> Sequence[sp.Expr]:
        body = at.body("composite")
        *axes, origin = at.vectors("place", 4)
        lin, ang = (
            named(plus(*map(scaled, part, axes)), letter, at.tape)
            for part, letter in zip(body.momentum(axis(at.kind.sigma)), "fn", strict=True)
        )
        for motion in reversed(at.step(sp.S.Zero).way):
            body = body.before(motion, 0, at.tape)
        return (*body.parameters.values(), *lin, *plus(ang, cross(origin, lin)))

    sweeps = (
        table.sweep(
            "Place and screw of each joint in frame 0, and the body alone.",
            outward,
            ("place", 12),
            ("screw", 6),
            ("composite", 10),
            ("rotor", 1),
        ),
        table.sweep(
            "Force of each joint at unit acceleration, and the composite body before it.",
            inward,
            (f"composite{UP}", 10),
            ("force", 6),
            order=INWARD,
        ),
    )
    sizes = {"screw": 6, "composite": 10, "rotor": 1, "force": 6}
    steps = (*sweeps, _mass_pairs(table, "force", into), *more)
    matrices = (_MASS,) if into == _MASS else ()
    return table.program((_BASE_PLACE, *_at_rest(sizes)), steps, matrices)


def _mass_pairs(table: _Table, force: str, into: str) -> Pairs:
    """Return the pairs of the mass matrix, or of its lower half if it is no output.

    Args:
        table: of the robot.
        force: name of the array of what unit acceleration of each joint needs.
        into: name of the matrix.
    """
    at = _Template(table, table.kinds[0])
    entry = acting(at.screw(force), at.screw(f"screw{UP}"))
    return Pairs(
        "Entry of two joints: the power of the force on one, of unit acceleration, on the other.",
        at.close((entry,)),
        (((into,), () if into == _MASS else (into,)),),
        (into, "rotor"),
    )


def coriolis(robot: Robot, base: BaseParameters) -> Program:
    """Return C of Christoffel's symbols: half of the derivative of C qd by qd.

    It is that of `inverse_dynamics_derivatives` without friction and accelerations.

    Args:
        robot: it is `rollable`.
        base: its base parameters.
    """
    table, half = _Table.of(robot, base), sp.Rational(1, 2)

    def outward(at: _Template) -> Sequence[sp.Expr]:
        found = _moved_screw(at, accelerating=False)
        return (*found[:24], *found[30:])

    at = _Template(table, table.kinds[0])
    screw, inertia = at.screw(f"screw{UP}"), at.screw("inertia")
    entries = (
        half * acting(at.screw("by_qd"), screw),
        half * acting((ZERO, at.rows("couple", 3)), screw) + acting(inertia, at.screw(f"rate{UP}")),
    )
    screws, bodies, wrenches = (*_SCREW[:3], *_SCREW[4:]), _CARRIED[:3], _FELT[1:]
    steps = (
        table.sweep(_OUTWARD, outward, *screws),
        table.sweep(
            "Inertia of each body, its rate and momentum.",
            lambda at: _carried(at)[:22],
            *bodies,
            order=APART,
        ),
        _summed(table, *bodies),
        table.sweep(
            "What joints before it feel of each joint.",
            lambda at: _felt(at, at.screw("force"))[6:],
            *wrenches,
            order=APART,
        ),
        Pairs("Entries of two joints.", at.close(entries), (((), ("C",)), (("C",), ()))),
    )
    sizes = dict((*screws[1:], *bodies, *wrenches))
    return table.program((_BASE_PLACE, *_at_rest(sizes)), steps)


def inverse_dynamics_derivatives(robot: Robot, base: BaseParameters) -> Program:
    """Return dtau/dq and dtau/dqd: sweeps about the origin of frame 0 in its axes, then pairs.

    `symgen.symbolic.derivatives` has the equations and their source. In one frame, what the bodies
    after a joint carry is a sum, and each entry is a sum of products of two bodies.

    Args:
        robot: it is `rollable`.
        base: its base parameters.
    """
    table = _Table.of(robot, base)

    def outward(at: _Template) -> Sequence[sp.Expr]:
        return (*_moved_screw(at, accelerating=True), at.friction_slope())

    def alone(at: _Template) -> Sequence[sp.Expr]:
        return (*_second(at, at.screw("acceleration")), *_carried(at))

    steps = (
        table.sweep(_OUTWARD, outward, *_SCREW, ("slope", 1)),
        table.sweep(
            "Second rate of each screw; inertia, its rate, momentum and wrench of each body.",
            alone,
            ("second", 6),
            *_CARRIED,
            order=APART,
        ),
        _summed(table, *_CARRIED),
        table.sweep(
            "What joints before it feel of each joint.",
            lambda at: _felt(at, at.screw("force")),
            *_FELT,
            order=APART,
        ),
        _slopes(table),
    )
    sizes = dict((*_SCREW[1:], ("slope", 1), ("second", 6), *_CARRIED, *_FELT))
    return table.program((_BASE_PLACE, *_accelerated(robot, sizes)), steps)


def forward_dynamics_derivatives(robot: Robot, base: BaseParameters) -> Program:
    """Return dqdd/dq, dqdd/dqd and dqdd/dtau = M^-1.

    The mass matrix and the torques without accelerations give the accelerations. With these, the
    derivatives of inverse dynamics give the others: dqdd/dq = -M^-1 dtau/dq.

    Args:
        robot: it is `rollable`.
        base: its base parameters.
    """
    table = _Table.of(robot, base)

    def outward(at: _Template) -> Sequence[sp.Expr]:
        driving = at.rate("tau", True) - at.friction()
        rotor = at.value(names.ROTOR)
        return (*_moved_screw(at, accelerating=False), at.friction_slope(), rotor, driving)

    def alone(at: _Template) -> Sequence[sp.Expr]:
        carried = _carried(at)
        return (*carried, *carried[:10])

    def resisted(at: _Template) -> Sequence[sp.Expr]:
        screw = at.screw("screw")
        lin, ang = at.body("composite").momentum(screw)
        return (*lin, *ang, at.rows("driving", 1)[0] - acting(at.screw("force"), screw))

    def faster(at: _Template) -> Sequence[sp.Expr]:
        return [
            x for v in _sum(at.screw(f"more{UP}"), at.screw("screw"), at.rate("found", True))
            for x in v
        ]  # fmt: skip

    def pushed(at: _Template) -> Sequence[sp.Expr]:
        more = at.screw("more")
        lin, ang = at.body("alone").momentum(more)
        return (*_second(at, _sum(at.screw("acceleration"), more, sp.S.One)), *lin, *ang)

    def columns(at: _Template) -> Sequence[sp.Expr]:
        return _felt(at, at.named(_sum(at.screw("force"), at.screw("push"), sp.S.One), "FN"))

    steps = (
        table.sweep(_OUTWARD, outward, *_SCREW, ("slope", 1), ("rotor", 1), ("driving", 1)),
        table.sweep(
            "Inertia of each body, its rate, momentum and wrench without accelerations.",
            alone,
            *_CARRIED,
            ("alone", 10),
            order=APART,
        ),
        _summed(table, *_CARRIED),
        table.sweep(
            "Force of each joint at unit acceleration, and the torque that accelerates it.",
            resisted,
            ("inertia", 6),
            ("right", 1),
            order=APART,
        ),
        _mass_pairs(table, "inertia", _MASS),
        Elimination(_FACTORS, _MASS),
        Solution("Accelerations of joints.", _MASS, "right", "found", single=True),
        table.sweep("What they add to the motion of each body.", faster, ("more", 6)),
        table.sweep(
            "Second rate of each screw, and the wrench of these accelerations.",
            pushed,
            ("second", 6),
            ("push", 6),
            order=APART,
        ),
        _summed(table, ("push", 6)),
        table.sweep("What joints before it feel of each joint.", columns, *_FELT, order=APART),
        _slopes(table),
        Solution("Inverse of the mass matrix.", _MASS, "", "dtau_out"),
        Solution("Derivatives by q.", _MASS, "dq_out", "dq_out"),
        Solution("Derivatives by qd.", _MASS, "dqd_out", "dqd_out"),
    )
    sizes = dict((*_SCREW[1:], ("slope", 1), ("second", 6), *_CARRIED, *_FELT))
    sizes |= dict.fromkeys(("rotor", "driving", "right", "found"), 1)
    sizes |= {"alone": 10, "more": 6, "push": 6}
    return table.program((_BASE_PLACE, *_accelerated(robot, sizes)), steps, (_MASS,))


_BACK = "Torque of each joint, and the wrench on the body before it."
#: Name of the mass matrix where it is no output.
_MASS = "mass"
_FACTORS = "Factors of the mass matrix."
_OUTWARD = "Place, screw and motion of each joint in frame 0, and the body alone."
#: Arrays about the origin of frame 0 in its axes: of joints, of what bodies carry, and of what
#: joints before a joint feel of it.
_SCREW = (
    ("place", 12),
    ("screw", 6),
    ("twist", 6),
    ("acceleration", 6),
    ("rate", 6),
    ("own", 10),
)
_CARRIED = (("composite", 10), ("growing", 6), ("momentum", 6), ("force", 6))
_FELT = (("by_q", 6), ("by_qd", 6), ("inertia", 6), ("couple", 3))


def _moved_screw(at: _Template, accelerating: bool) -> Sequence[sp.Expr]:
    """Return place, screw and motion of a joint, the rate of the screw, and the body."""
    place, screw = at.placed()
    speed, faster = at.rate("qd", True), at.rate("qdd", accelerating)
    twist = at.named(_sum(at.screw(f"twist{UP}"), screw, speed), "wV")
    rate = at.named(moved(screw, twist), "st")
    acceleration = _sum(_sum(at.screw(f"acceleration{UP}"), screw, faster), rate, speed)
    found = (*place, *screw, *twist, *acceleration, *rate)
    return (*(x for v in found for x in v), *at.inertia.parameters.values())


def _second(at: _Template, acceleration: Screw) -> Sequence[sp.Expr]:
    """Return the second rate of a screw."""
    parts = (moved(at.screw("screw"), acceleration), moved(at.screw("rate"), at.screw("twist")))
    return [x for pair in zip(*parts, strict=True) for x in plus(*pair)]


def _carried(at: _Template) -> Sequence[sp.Expr]:
    """Return inertia of a body, its rate, momentum and wrench."""
    *axes, origin = at.vectors("place", 4)
    twist, acceleration = at.screw("twist"), at.screw("acceleration")
    body = at.body("own").placed(axes, origin, at.tape)
    lin, ang = at.named(body.momentum(twist), "lk")
    growing = body.rate(Frame(*twist, ZERO, sp.S.Zero), lin, 0, at.tape).J
    needed, moment = body.momentum(acceleration)
    f = plus(needed, cross(twist[0], lin))
    n = plus(moment, cross(twist[0], ang), cross(twist[1], lin))
    inertia = body.parameters.values()
    return (*inertia, *(growing[i][k] for i, k in UPPER), *lin, *ang, *f, *n)


def _summed(table: _Table, *arrays: tuple[str, int]) -> Sweep:
    """Return the sweep that adds rows to those of the body before, from the tips."""
    return table.sweep(
        "The same of each body with all that it carries.",
        lambda at: [x for name, size in arrays for x in at.rows(name, size)],
        *((f"{name}{UP}", size) for name, size in arrays),
        order=INWARD,
    )


def _felt(at: _Template, force: Screw) -> Sequence[sp.Expr]:
    """Return what joints before a joint feel of it, in the order of `_FELT`."""
    rate, twice = at.screw("rate"), sp.Integer(2)
    double = at.named((scaled(twice, rate[0]), scaled(twice, rate[1])), "de")
    growing = symmetric(dict(zip(UPPER, at.rows("growing", 6), strict=True)))
    *wrenches, (_, couple) = felt(
        Screws(at.screw("screw"), double, at.screw("second")),
        at.body("composite"),
        Inertia(growing, ZERO, sp.S.Zero),
        at.screw("momentum"),
        force,
        0,
        at.tape,
    )
    return [*(x for wrench in wrenches for part in wrench for x in part), *couple]


def _slopes(table: _Table) -> Pairs:
    """Return the pairs of dtau/dq and dtau/dqd."""
    at = _Template(table, table.kinds[0])
    screw, rate = at.screw(f"screw{UP}"), at.screw(f"rate{UP}")
    inertia, couple = at.screw("inertia"), (ZERO, at.rows("couple", 3))
    entries = (
        acting(at.screw("by_q"), screw),
        acting(at.screw("by_qd"), screw),
        acting(couple, rate) + acting(inertia, at.screw(f"second{UP}")),
        acting(couple, screw) + 2 * acting(inertia, rate),
    )
    by_q, by_qd = ("dq_out",), ("dqd_out",)
    places = (((), by_q), ((), by_qd), (by_q, ()), (by_qd, ()))
    return Pairs("Derivatives of two joints.", at.close(entries), places, ("dqd_out", "slope"))


def _accelerated(
    robot: Robot, sizes: Mapping[str, int]
) -> Iterator[tuple[str, tuple[sp.Expr, ...]]]:
    """Yield arrays whose row of the base is zero, but that the base accelerates against gravity."""
    for name, row in _at_rest(sizes):
        yield name, (*ZERO, *(-g for g in robot.gravity)) if name == "acceleration" else row


_BASE_PLACE = "place", (*unit(0), *unit(1), *unit(2), *ZERO)


def _sum(twist: Screw, screw: Screw, factor: sp.Expr) -> Screw:
    """Return twist + factor screw."""
    first, second = (plus(a, scaled(factor, b)) for a, b in zip(twist, screw, strict=True))
    return first, second


def _at_rest(sizes: Mapping[str, int]) -> Iterator[tuple[str, tuple[sp.Expr, ...]]]:
    """Yield arrays of the state whose row of the base is zero, by their numbers of entries."""
    return ((name, _zeros(size)) for name, size in sizes.items())


def _zeros(count: int) -> tuple[sp.Expr, ...]:
    return (sp.S.Zero,) * count


def _base_motion(robot: Robot, size: int) -> tuple[str, tuple[sp.Expr, ...]]:
    """Return the motion of the base: it accelerates against gravity."""
    return "motion", (*_zeros(size - 3), *(-g for g in robot.gravity))


def _wrenched(at: _Template, size: int, accelerating: bool) -> Sequence[sp.Expr]:
    """Return the motion of a body, of 9 entries or at rest of 3, and the wrench that it needs."""
    before, moving = at.rows(f"motion{UP}", size), size == 9
    w, dw = (before[:3], before[3:6]) if moving else (ZERO, ZERO)
    speed, faster = at.rate("qd", moving), at.rate("qdd", accelerating)
    rates = speed, speed, faster
    now = passed(Motion(w, dw, before[-3:]), at.step(speed), rates, REAL, at.tape)
    f, n = at.inertia.wrench(now, 0, at.tape)
    return (*now.w, *now.dw, *now.a, *f, *n) if moving else (*now.a, *f, *n)


def _torque(
    at: _Template, moving: bool, faster: str = ""
) -> tuple[Sequence[sp.Expr], Sequence[sp.Expr]]:
    """Return the wrench on the body before, and the torque of the joint unless it is fixed.

    Args:
        at: the template.
        moving: whether it has a speed, and friction.
        faster: name of its acceleration, if any.
    """
    wrench = at.rows("wrench", 6)
    screw = wrench[:3], wrench[3:]
    f, n = handed_back(screw, at.step(sp.S.Zero), "b", at.tape)
    if not at.moves:
        return (*f, *n), ()
    torque = acting(screw, axis(at.kind.sigma))
    torque += at.value(names.ROTOR) * at.rate(faster, bool(faster))
    return (*f, *n), (torque + at.friction() if moving else torque,)


def _entries(body: Articulated) -> Sequence[sp.Expr]:
    """Return the 27 numbers of an articulated body without what drives its joints."""
    J, M = ([a[i][k] for i, k in UPPER] for a in (body.J, body.M))
    return (*J, *(x for row in body.H for x in row), *M, *body.n, *body.f)


def _articulated(entries: Symbols) -> Articulated:
    """Return the articulated body of these numbers."""
    J, M = (
        symmetric(dict(zip(UPPER, part, strict=True))) for part in (entries[:6], entries[15:21])
    )
    H = matrix(lambda i, k: entries[6 + 3 * i + k])
    return Articulated(J, H, M, entries[21:24], entries[24:])


@dataclass(frozen=True)
class _Table:
    """What templates know of a robot: kinds of joints, and the columns that any of them needs."""

    robot: Robot
    joints: tuple[Joint, ...]
    kinds: tuple[Kind, ...]
    geometry: Mapping[str, tuple[sp.Expr, ...]]
    heads: tuple[tuple[str, int], ...]

    @staticmethod
    def of(robot: Robot, base: BaseParameters) -> _Table:
        joints = (*robot.movable, *(j for j in robot.joints if j.fixed))
        kinds = tuple(Kind(j.sigma, j.coulomb_width > 0, j.gamma != 0 or j.b != 0) for j in joints)
        columns = zip(GEOMETRY, zip(*map(_constants, joints), strict=True), strict=True)
        place = {joint.number: i for i, joint in enumerate(joints)}
        standard = (base.standard[p.index] for p in base.parameters)
        heads = tuple((p.prefix, place[p.joint]) for p in standard)
        return _Table(robot, joints, kinds, dict(columns), heads)

    def varies(self, column: str, kind: Kind, value: sp.Expr) -> bool:
        """Whether any joint of a kind has another constant than this."""
        entries = zip(self.kinds, self.geometry[column], strict=True)
        return any(k == kind and entry != value for k, entry in entries)

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the constants that are not the same without effect in every joint."""
        plain = {"cgamma": sp.S.One, "calpha": sp.S.One}
        return tuple(
            c for c in GEOMETRY
            if any(self.varies(c, kind, plain.get(c, sp.S.Zero)) for kind in self.kinds)
        )  # fmt: skip

    @property
    def parameters(self) -> tuple[str, ...]:
        """Prefixes of the parameters of a body that any joint has."""
        order = (*names.LINK, names.ROTOR, *names.FRICTION.values())
        return tuple(p for p in order if any(p == prefix for prefix, _ in self.heads))

    def sweep(
        self,
        doc: str,
        derive: Callable[[_Template], Sequence[sp.Expr]],
        *written: tuple[str, int],
        order: str = OUTWARD,
    ) -> Sweep:
        """Return a sweep whose templates are derived by a function."""
        bodies = []
        for kind in self.kinds[:1] if order == APART else dict.fromkeys(self.kinds):
            at = _Template(self, kind)
            bodies.append((kind, at.close(derive(at))))
        if all(tape == bodies[0][1] for _, tape in bodies):
            bodies = bodies[:1]
        return Sweep(doc, order, tuple(bodies), written)

    def program(
        self,
        state: tuple[tuple[str, tuple[sp.Expr, ...]], ...],
        steps: tuple[Part, ...],
        matrices: tuple[str, ...] = (),
    ) -> Program:
        columns, parameters = self.columns, self.parameters
        places = ((i, parameters.index(p)) for p, i in self.heads)
        rows = zip(*(self.geometry[c] for c in columns), strict=True)
        row = {joint.number: i for i, joint in enumerate(self.joints, 1)} | {0: 0}
        way = {0: 0}  # row of the last joint with a variable, up to each joint
        for joint in self.robot.joints:
            way[joint.number] = row[joint.number] if joint.movable else way[joint.antecedent]
        return Program(
            self.kinds,
            tuple(row[joint.number] - 1 for joint in self.robot.joints),
            tuple(row[joint.antecedent] for joint in self.joints),
            tuple(way[joint.antecedent] for joint in self.robot.movable),
            tuple(joint.theta for joint in self.joints),
            columns,
            tuple(rows),
            parameters,
            tuple(places),
            state,
            steps,
            matrices,
        )


def _constants(joint: Joint) -> tuple[sp.Expr, ...]:
    """Return the constants of a joint, in the order of GEOMETRY."""
    (cg, sg), (ca, sa) = cosine_sine(joint.gamma), cosine_sine(joint.alpha)
    width = joint.coulomb_width
    sharp = 1 / sp.Rational(repr(width)) if width else sp.S.Zero
    return cg, sg, joint.b, ca, sa, joint.d, joint.r, sharp


class _Template:
    """Collects the steps of one body. It is mutable, and lives only during a derivation."""

    def __init__(self, table: _Table, kind: Kind) -> None:
        self.table, self.kind = table, kind
        self.groups: dict[str, Symbols] = {}
        self.tape = TapeBuilder(RESERVED)

    @property
    def moves(self) -> bool:
        """Whether the joint moves."""
        return self.kind.sigma != names.FIXED

    def rows(self, name: str, count: int) -> Symbols:
        """Return the symbols of a row of an array."""
        return self.groups.setdefault(
            name, tuple(real_symbol(f"X_{name}{i}") for i in range(count))
        )

    def vectors(self, name: str, count: int) -> tuple[Vector, ...]:
        """Return the symbols of a row of an array as vectors."""
        row = self.rows(name, 3 * count)
        return tuple(row[3 * k : 3 * k + 3] for k in range(count))

    def screw(self, name: str) -> Screw:
        """Return the symbols of a row of an array as a screw or wrench."""
        first, second = self.vectors(name, 2)
        return first, second

    def named(self, screw: Screw, letters: str) -> Screw:
        """Name the entries of a screw."""
        first, second = (named(part, x, self.tape) for part, x in zip(screw, letters, strict=True))
        return first, second

    def body(self, name: str) -> Inertia:
        """Return the symbols of a row of an array as a body."""
        body = Inertia.of(dict(zip(names.LINK, self.rows(name, 10), strict=True)))
        return body if names.MASS in self.table.parameters else replace(body, M=sp.S.Zero)

    def placed(self) -> tuple[Place, Screw]:
        """Return the place of the link and the screw of its joint, in frame 0."""
        place = self.vectors(f"place{UP}", 4)
        for motion in self.step(sp.S.Zero).way:
            place = moved_place(place, motion, self.tape)
        z, origin = place[2:]
        if not self.moves:
            return place, (ZERO, ZERO)
        if self.kind.sigma != names.REVOLUTE:
            return place, (ZERO, z)
        return place, (z, named(cross(origin, z), "v", self.tape))

    def rate(self, name: str, there: bool) -> sp.Expr:
        """Return a variable of the joint, or zero."""
        return self.rows(name, 1)[0] if there and self.moves else sp.S.Zero

    def constant(self, column: str, value: int = 0) -> sp.Expr:
        """Return a constant of the joint, or its value if it is this one in all of them."""
        if not self.table.varies(column, self.kind, sp.Integer(value)):
            return sp.Integer(value)
        columns = self.table.columns
        return self.rows("geometry", len(columns))[columns.index(column)]

    def value(self, prefix: str) -> sp.Expr:
        """Return a parameter of the body; zero if no joint of its kind has it."""
        rows = (i for p, i in self.table.heads if p == prefix)
        if not any(self.table.kinds[i] == self.kind for i in rows):
            return sp.S.Zero
        columns = self.table.parameters
        return self.rows("body", len(columns))[columns.index(prefix)]

    @property
    def inertia(self) -> Inertia:
        """The link."""
        return Inertia.of({prefix: self.value(prefix) for prefix in names.LINK})

    def step(self, speed: sp.Expr) -> Step:
        """Return the way from the antecedent."""
        c, s = self.rows("c", 1)[0], self.rows("s", 1)[0]
        before: list[Turn | Shift] = []
        for k, angle, length in ((2, "gamma", "b"), (0, "alpha", "d")):
            if (cosine := self.constant(f"c{angle}", 1)) != 1:
                before.append(Turn(k, cosine, self.constant(f"s{angle}"), angle))
            if (shift := self.constant(length)) != 0:
                before.append(Shift(k, shift, length))
        before.append(Turn(2, c, s, "q"))
        r = self.constant("r")
        if self.kind.sigma == names.PRISMATIC:
            r = self.tape.name("R", self.rate("q", True) + r)
        after = () if r == 0 else (Shift(2, r, "r"),)
        return Step(Joint(0, self.kind.sigma, 0), tuple(before), after, speed, speed)

    def friction(self) -> sp.Expr:
        """Return the torque of friction."""
        speed = self.rate("qd", True)
        turned = self.turned if self.kind.smooth else sp.sign(speed)
        columns = {"FS": self.tape.name("sign", turned), "FV": speed, "OF": sp.S.One}
        return sum((self.value(p) * column for p, column in columns.items()), sp.S.Zero)

    @property
    def turned(self) -> sp.Expr:
        """The smooth sign of the speed."""
        return sp.tanh(self.tape.name("x", self.rate("qd", True) * self.constant("sharp")))

    def friction_slope(self) -> sp.Expr:
        """Return the derivative of the torque of friction by the speed."""
        slope = self.value("FV")
        if self.kind.smooth:
            turned = self.tape.name("sign", self.turned)
            falling = self.tape.name("falls", self.constant("sharp") * (1 - turned * turned))
            slope += self.value("FS") * falling
        return slope

    def close(self, outputs: Sequence[sp.Expr]) -> Tape:
        """Return the template, with the groups of inputs that it reads."""
        named = [self.tape.name("out", expr) for expr in outputs]
        tape = self.tape.tape(self.groups.items(), named)
        read = {s for _, expr in tape.steps for s in expr.free_symbols}
        read |= {s for out in tape.outputs for s in out.free_symbols}
        return replace(tape, inputs=tuple(g for g in tape.inputs if read.intersection(g[1])))

"""The steps from the base to every link: elementary motions, and the rates of the joints.

The modified Denavit-Hartenberg transform is a product of elementary motions along and about z and
x. Recursions apply them one by one. Zeros and signs of the geometry vanish as the steps are
written. Every step has a name.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import sympy as sp

from symgen import names
from symgen.robot.types import Joint, Robot
from symgen.symbolic.constraints import followed
from symgen.symbolic.spatial import ZERO, Screw, Shift, Turn, Vector, axis, unit_vector
from symgen.symbolic.tape import Symbols, TapeBuilder, real_symbol

#: Names of arrays in generated code; steps must not have them.
ARGUMENTS = frozenset(
    "q qd qdd tau X out M C h p_out dl_out T_out U_out J_out N k i angle guard status qdr qddr b x "
    "rate_out dq_out dqd_out dtau_out link point J a kinetic_out potential_out standard mass com "
    "inertia g load offset w".split()
)

#: The steps to every joint, in file order.
Way = tuple["Step", ...]


@dataclass(frozen=True)
class Step:
    """The step from the frame of an antecedent to that of joint j.

    `before` leads to the axis of j, and includes theta if j is revolute. The velocity of the joint
    is added there. `after` is the translation along z. `rate` is the speed qd; if the joint follows
    others, it is a sum of their speeds.
    """

    joint: Joint
    before: tuple[Turn | Shift, ...]
    after: tuple[Shift, ...]
    qd: sp.Expr
    rate: sp.Expr

    @property
    def way(self) -> tuple[Turn | Shift, ...]:
        """All elementary motions, in order."""
        return (*self.before, *self.after)

    @property
    def back(self) -> tuple[Turn | Shift, ...]:
        """The opposite motions, from the frame of j to that of its antecedent."""
        return tuple(motion.back for motion in reversed(self.way))

    def still(self) -> Step:
        """Return the same step at rest."""
        return replace(self, qd=sp.S.Zero, rate=sp.S.Zero)


#: The joint variables, and the prefix of their symbols: no length in a robot file can begin with
#: X_. `qdr` and `qddr` are reference speeds and accelerations, `b` is any right-hand side.
_PREFIX = {"q": "", "qd": "", "qdd": "", "tau": "", "qdr": "X_", "qddr": "X_", "b": "X_"}


def variables(robot: Robot, name: str) -> dict[int, sp.Symbol]:
    """Return the symbols of a variable by number, in file order: one for every movable joint, and
    for b one for every equation.
    """
    numbers = robot.equations if name == "b" else robot.numbers
    return {j: real_symbol(f"{_PREFIX[name]}{name}{j}") for j in numbers}


def axes(robot: Robot) -> dict[int, tuple[int, Screw]]:
    """Return link and screw of every equation by number: the axis along or about which its force or
    moment acts, in the frame of the link. A free base comes first, then all moving joints.
    """
    units = [unit_vector(k) for k in range(3)]
    screws = [*((ZERO, unit) for unit in units), *((unit, ZERO) for unit in units)]
    base = {number: (0, screw) for number, screw in zip(robot.free, screws, strict=False)}
    return base | {j.number: (j.number, axis(j.sigma)) for j in robot.moving}


def arrays(robot: Robot, *names: str) -> list[tuple[str, Symbols]]:
    """Return variables as the inputs of a tape."""
    return [(name, tuple(variables(robot, name).values())) for name in names]


def builder(robot: Robot, symbols: Iterable[sp.Symbol] = ()) -> TapeBuilder:
    """Return an empty tape with the names of the file, variables and other symbols reserved."""
    own = (s for _, group in arrays(robot, *_PREFIX) for s in group)
    taken = {s.name for s in (*own, *symbols)} | {name for name, _ in robot.geometry}
    base = base_inputs(robot)
    groups = [[x] for x in base] if robot.floating else [base]
    return TapeBuilder(taken | ARGUMENTS | {name for name, _ in base}, groups)


def base_inputs(robot: Robot) -> list[tuple[str, Symbols]]:
    """Return the inputs that describe the base: gravity, or the motion that its IMU measures.

    For a free base, these are all inputs of `names.FREE_BASE`; a tape has those that it reads.
    """
    if robot.imu:
        sizes = names.FREE_BASE if robot.floating else dict.fromkeys(names.BASE, 3)
        return [
            (x, tuple(real_symbol(f"X_{x}{i + 1}") for i in range(size)))
            for x, size in sizes.items()
        ]
    return [("g", robot.gravity)] if robot.gravity_input else []


def path(robot: Robot, number: int) -> list[int]:
    """Return the numbers of the joints from one down to the base."""
    out = []
    while number:
        out.append(number)
        number = robot.joint(number).antecedent
    return out


def carriers(robot: Robot) -> set[int]:
    """Return the numbers of the moving joints, and of the fixed ones that carry them."""
    return {number for joint in robot.moving for number in path(robot, joint.number)}


def way_of(robot: Robot, tape: TapeBuilder) -> Way:
    """Return the steps to every joint, in file order; sines and cosines become tape steps."""
    q, qd = variables(robot, "q"), variables(robot, "qd")
    out = []
    for joint in robot.joints:
        j = joint.number
        at = tape.name(f"Q{j}", followed(joint, q, tape))
        rate = followed(joint, qd, tape)
        out.append(_step(joint, at, tape.name(f"qd{j}", rate), rate, tape))
    return tuple(out)


def _step(joint: Joint, q: sp.Expr, qd: sp.Expr, rate: sp.Expr, tape: TapeBuilder) -> Step:
    j = joint.number
    turn, slide = joint.theta, joint.r
    if joint.turns:
        turn += joint.offset
        c, s = _joint_angle(q, turn, j, tape)
    else:
        slide += joint.offset
        c, s = _angle(turn, f"theta{j}", tape)
    r = tape.constant(f"r{j}", slide)
    if joint.slides:
        r = tape.name(f"R{j}", q + r)
    return Step(joint, *elementary(joint, c, s, r, tape), qd, rate)


def elementary(
    joint: Joint, c: sp.Expr, s: sp.Expr, r: sp.Expr, tape: TapeBuilder
) -> tuple[tuple[Turn | Shift, ...], tuple[Shift, ...]]:
    """Return the motions to the axis of a joint, turned about it by (c, s), and those along it."""
    j = joint.number
    before: tuple[Turn | Shift, ...] = (
        Turn(2, *_angle(joint.gamma, f"gamma{j}", tape), f"a{j}"),
        Shift(2, tape.constant(f"b{j}", joint.b), f"b{j}"),
        Turn(0, *_angle(joint.alpha, f"alpha{j}", tape), f"c{j}"),
        Shift(0, tape.constant(f"d{j}", joint.d), f"d{j}"),
        Turn(2, c, s, f"e{j}"),
    )
    kept = tuple(m for m in before if not (m.c == 1 if isinstance(m, Turn) else m.length == 0))
    return kept, () if r == 0 else (Shift(2, r, f"r{j}"),)


def gravity(robot: Robot, tape: TapeBuilder) -> Vector:
    """Return the acceleration of gravity in frame 0, as constants or input of the tape."""
    if robot.gravity_input:
        return robot.gravity
    return tuple(tape.constant(f"g{a}", g) for a, g in zip("xyz", robot.gravity, strict=True))


def _angle(angle: sp.Expr, name: str, tape: TapeBuilder) -> tuple[sp.Expr, sp.Expr]:
    """Return cosine and sine of a constant angle, as constants of the tape."""
    c, s = cosine_sine(angle)
    return tape.constant(f"C{name}", c), tape.constant(f"S{name}", s)


def cosine_sine(angle: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    """Return cosine and sine of a constant angle, in radicals only if these are not nested.

    cos(pi/8) stays unchanged. As sqrt(2 + sqrt(2))/2, its sign modulo a prime would no longer match
    that of sin(pi/8).
    """
    both = sp.cos(angle), sp.sin(angle)
    if any(not p.base.is_Rational for e in both for p in e.atoms(sp.Pow) if not p.exp.is_Integer):
        return sp.cos(angle, evaluate=False), sp.sin(angle, evaluate=False)
    return both


def _joint_angle(q: sp.Expr, offset: sp.Expr, j: int, tape: TapeBuilder) -> tuple[sp.Expr, sp.Expr]:
    """Return cosine and sine of q + offset; quarter turns vanish into signs and swaps."""
    quarter = offset * 2 / sp.pi
    if quarter.is_Integer:
        c, s = tape.name(f"C{j}", sp.cos(q)), tape.name(f"S{j}", sp.sin(q))
        return ((c, s), (-s, c), (-c, -s), (s, -c))[int(quarter) % 4]
    angle = tape.name(f"t{j}", q + tape.constant(f"theta{j}", offset))
    return tape.name(f"C{j}", sp.cos(angle)), tape.name(f"S{j}", sp.sin(angle))

"""Conversion of a tree of links and joints (URDF) to modified Denavit-Hartenberg frames.

All frames are computed with 50 digits at q = 0 in the frame of the root link. The table rows, the
limits and the inertias in the new frames follow from them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import sympy as sp

from symgen import names
from symgen.errors import RobotError, first_of, located, shortened
from symgen.robot import dh, exact_numbers
from symgen.robot.body import Array, Body, inverse, pose, screw, turn
from symgen.robot.dh import Line
from symgen.robot.exact_numbers import context
from symgen.robot.identifiers import robot_name
from symgen.robot.imported import Imported
from symgen.robot.tables import Drive, Frame, Limits
from symgen.robot.types import EARTH, MAX_RATIO, Joint, Robot, Typed, joint_variable

_FAR = 10  # m
_WRITTEN = 1e-14  # rad: an angle with all digits is not rounded
_UNITS = 2  # of the last digit: the error of rounded or truncated angles in files
#: Limits of a robot, and their words in the file. The smallest counts.
_LIMITS = {
    "velocity": ("velocity",),
    "acceleration": ("acceleration", "deceleration"),
    "jerk": ("jerk",),
    "torque": ("effort",),
}
_COMPUTED = 12  # decimals of a table from rotations; parallel axes of two branches have the same
_DUST = 1e-9  # rad: angles from computations, not from measurements
Triple = tuple[sp.Rational, sp.Rational, sp.Rational]
#: The joints that a joint follows with their factors, and its position with these at 0.
Mimic = tuple[tuple[tuple[str, sp.Rational], ...], sp.Rational]
ORIGIN: Triple = (sp.S.Zero, sp.S.Zero, sp.S.Zero)


@dataclass(frozen=True)
class Inertial:
    """Mass [kg], centre of mass (frame xyz, rpy in the link) and inertia about it [kg m2]."""

    xyz: Triple
    rpy: Triple
    mass: sp.Rational
    inertia: tuple[sp.Rational, ...]


@dataclass(frozen=True)
class UrdfJoint(Typed):
    """A joint between two links: its frame in the parent frame, and its axis in its frame.

    Attributes:
        sigma: 0 revolute or continuous, 1 prismatic, 2 fixed.
        limit: lower, upper, velocity, effort, acceleration, deceleration and jerk, if the file
            contains them.
        damping, friction: viscous and Coulomb friction.
        armature: inertia of the rotor on the joint side.
        mimic: the joints that it follows, or None.
        floats: whether it is free in the file. symgen fixes such a joint, and accepts it only below
            the root.
    """

    name: str
    sigma: int
    parent: str
    child: str
    xyz: Triple
    rpy: Triple
    axis: Triple = (sp.S.One, sp.S.Zero, sp.S.Zero)
    limit: dict[str, float] = field(default_factory=dict)
    damping: float = 0.0
    friction: float = 0.0
    armature: float = 0.0
    mimic: Mimic | None = None
    floats: bool = False


@dataclass(frozen=True)
class Urdf:
    """A tree of links with inertias, and joints in document order.

    Attributes:
        computed: whether angles come from rotations with an unknown number of digits. Otherwise
            each angle has the rounding error of its last digit.
        gears: motor turns per turn of each joint with a variable; {} if unknown.
        notes: differences from the file, one line each.
        base: base of the robot, see `Robot`.
    """

    name: str
    root: str
    links: dict[str, Inertial | None]
    joints: dict[str, UrdfJoint]
    computed: bool = False
    gears: dict[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    base: str = names.BASES[0]


def on_base(urdf: Urdf, base: str | None) -> Urdf:
    """Return a tree on a base. One that moves is the link of the free joint, if there is one.

    Raises:
        RobotError: there are several free joints, or joints that move and are not behind it.
    """
    joints = urdf.joints
    free = next((joint for joint in joints.values() if joint.floats), None)
    if base in (None, names.BASES[0]) or free is None:
        return replace(urdf, base=base or names.BASES[0])
    parents = {joint.child: joint.parent for joint in joints.values() if joint is not free}

    def behind(link: str) -> bool:
        return behind(parents[link]) if link in parents else link == free.child

    for name, joint in joints.items():
        if joint is not free and (joint.floats or not joint.fixed) and not behind(joint.child):
            raise RobotError(
                f"joint {shortened(name)!r} does not hang on the free link "
                f"{shortened(free.child)!r}; accepted: one robot with one free joint"
            )
    links = {name: body for name, body in urdf.links.items() if behind(name)}
    kept = {name: joint for name, joint in joints.items() if joint.parent in links}
    return replace(urdf, root=free.child, links=links, joints=kept, base=base)


class Chain:
    """The joints of a URDF in symgen's order, with their axes and frames at q = 0."""

    def __init__(self, urdf: Urdf) -> None:
        self.urdf = urdf
        self.named = [link for link in urdf.links if link != urdf.root]
        self.notes = [*urdf.notes]
        self.far: list[str] = []
        self.snapped: dict[str, None] = {}
        self.above = {joint.child: joint for joint in urdf.joints.values()}
        self.link = self._link_frames()
        self.carrier = {name: self._carrier(name) for name in urdf.links}
        joints = self._order()
        self.line = {name: self._line(urdf.joints[name]) for name in joints}
        self.crossing: dict[str, str] = {}
        for name in joints:
            self._cross(urdf.joints[name])
        self.order = [at for name in joints for at in (self.crossing.get(name), name) if at]
        self.number = {name: i for i, name in enumerate(self.order, 1)}
        self.frame: dict[str, Array] = {"": np.eye(4, dtype=object)}
        self.table: dict[str, dict[str, sp.Expr]] = {}
        for name in joints:
            if name in self.crossing:
                self._place_crossing(urdf.joints[name])
            self._place(urdf.joints[name])
        if self.crossing:
            self.notes.append(
                f"fixed frames between nearly parallel axes keep all frames near: before joint "
                f"{first_of(list(map(shortened, self.crossing)), 6)}"
            )
        for joint in urdf.joints.values():
            if joint.floats:
                self.notes.append(
                    f"joint {shortened(joint.name)!r} is free in the file: the base "
                    f"{shortened(joint.child)!r} is fixed; symgen import --base floating frees it"
                )
            if min(joint.damping, joint.friction) < 0:
                self.notes.append(
                    f"joint {shortened(joint.name)!r}: its friction is negative in the file and "
                    "would drive it; symgen keeps the value"
                )
        if self.snapped:
            shown = first_of(list(self.snapped), 4)
            self.notes.insert(0, f"rounded angles read as multiples of pi/24: {shown}")

    # --- the tree -------------------------------------------------------------------------------

    def _link_frames(self) -> dict[str, Array]:
        out = {self.urdf.root: np.eye(4, dtype=object)}
        waiting = list(self.urdf.joints.values())
        while waiting:
            for joint in waiting:
                if joint.parent in out:
                    out[joint.child] = out[joint.parent] @ self._pose(joint.xyz, joint.rpy)
            waiting = [joint for joint in waiting if joint.child not in out]
        return out

    def _carrier(self, link: str) -> str:
        """Return the joint that moves a link, or "" for links fixed to the root."""
        while link in self.above and self.above[link].fixed:
            link = self.above[link].parent
        return self.above[link].name if link in self.above else ""

    def _order(self) -> list[str]:
        """Return the joints: first those with a variable, then followers, then fixed joints.

        Each group keeps the document order, but a joint comes after the joint that carries it.
        """

        def kind(joint: UrdfJoint) -> int:
            return 2 if joint.fixed else int(joint.mimic is not None)

        waiting, order = sorted(self.urdf.joints.values(), key=kind), [""]
        while waiting:
            ready = next(joint for joint in waiting if self.carrier[joint.parent] in order)
            waiting.remove(ready)
            order.append(ready.name)
        return order[1:]

    def _cross(self, joint: UrdfJoint) -> None:
        """Add a fixed joint before one whose axis is nearly parallel to that of its carrier."""
        carrier = self.carrier[joint.parent]
        z = self.line[carrier][1] if carrier else np.array([0, 0, 1], dtype=object)
        if not dh.nearly_parallel(z, self.line[joint.name][1]):
            return
        name = f"{joint.name}_crossing"
        while name in self.urdf.joints or name in self.urdf.links:
            name += "_"
        fixed = UrdfJoint(name, names.FIXED, joint.parent, name, ORIGIN, ORIGIN)
        self.urdf = replace(
            self.urdf,
            links=self.urdf.links | {name: None},
            joints=self.urdf.joints | {name: fixed},
        )
        self.crossing[joint.name] = name
        self.above[name] = fixed
        self.carrier[name] = carrier

    def _antecedent(self, joint: UrdfJoint) -> str:
        """Return the joint whose frame is the reference of a joint's row, or "" for the root."""
        return self.crossing.get(joint.name, self.carrier[joint.parent])

    # --- frames ---------------------------------------------------------------------------------

    def _pose(self, xyz: Triple, rpy: Triple) -> Array:
        """Return Trans(xyz) Rot(z, yaw) Rot(y, pitch) Rot(x, roll), with exact angles."""
        errors = list(map(self._rounding, rpy))
        angles = map(self._meant, many(rpy), errors)
        within = min(sum(errors), exact_numbers.TOLERANCE)
        return pose(self._recognised(turn(*angles), within), many(xyz))

    def _rounding(self, angle: sp.Rational) -> float:
        """Return the largest rounding error of an angle of the file."""
        if self.urdf.computed:
            return exact_numbers.TOLERANCE
        if angle == 0:  # 0 has no rounding error
            return _DUST
        units = max(_UNITS * exact_numbers.last_digit(angle), _DUST)
        return min(units, exact_numbers.TOLERANCE)

    def _meant(self, angle: Any, within: float) -> Any:
        """Return the multiple of pi/24 if an angle is its rounded value, otherwise the angle."""
        meant = exact_numbers.snapped(angle, within)
        if abs(meant - angle) > _WRITTEN:
            self.snapped[f"{float(angle):.12g}"] = None
        return meant

    def _recognised(self, rotation: Array, within: float) -> Array:
        """Make a rotation exact if all its angles are multiples of pi/24 within `within`."""
        angles = dh.turned_by(rotation, within)
        if any(exact_numbers.fraction_of_pi(angle, within) is None for angle in angles):
            return rotation
        return turn(*(self._meant(angle, within) for angle in angles))

    def _line(self, joint: UrdfJoint) -> Line:
        frame = self.link[joint.child]
        if joint.fixed:
            return frame[:3, 3], frame[:3, 2]
        axis = many(joint.axis)
        axis = axis / dh.norm(axis)
        axis = np.where(abs(axis) > exact_numbers.TOLERANCE, axis, context().mpf(0))
        rotation = np.eye(3, dtype=object)
        rotation[:, 0] = axis / dh.norm(axis)
        rotation = self._recognised(rotation, exact_numbers.TOLERANCE)
        return frame[:3, 3], frame[:3, :3] @ rotation[:, 0]

    def _place_crossing(self, joint: UrdfJoint) -> None:
        """Compute the table row and the frame of the fixed joint before a joint."""
        name = self.crossing[joint.name]
        base = self.frame[self.carrier[joint.parent]]
        self.link[name] = dh.crossing(base, self.line[joint.name])
        self.line[name] = self._line(self.urdf.joints[name])
        self._place(self.urdf.joints[name])

    def _place(self, joint: UrdfJoint) -> None:
        """Compute the table row and the frame of a joint."""
        base = self.frame[self._antecedent(joint)]
        line = self.line[joint.name]
        gamma, b, alpha, d = dh.row_to_line(base, line)
        before = base @ screw(2, gamma, b) @ screw(0, alpha, d)
        theta, r = self._rest(joint, before)
        self.frame[joint.name] = before @ screw(2, theta, r)
        angles = {"gamma": gamma, "alpha": alpha, "theta": theta}
        lengths = {"b": b, "d": d, "r": r}
        decimals = _COMPUTED if self.urdf.computed else exact_numbers.LONG
        self.table[joint.name] = {
            **{key: exact_numbers.angle(value, decimals) for key, value in angles.items()},
            **{key: exact_numbers.length(value, decimals) for key, value in lengths.items()},
        }
        if not joint.fixed and max(map(abs, lengths.values())) > _FAR:
            self.far.append(repr(shortened(joint.name)))

    def _rest(self, joint: UrdfJoint, before: Array) -> tuple[Any, Any]:
        """Return theta and r, which determine x and the origin of the frame on its z axis."""
        z, at = before[:3, 2:].T
        if joint.fixed:
            frame = self.link[joint.child]
            return dh.turn_of(frame[:3, 0], before), (frame[:3, 3] - at) @ z
        behind = (  # moving joints on the link of this joint
            name
            for name, on in ((name, self.urdf.joints[name]) for name in self.order)
            if not on.fixed and self.carrier[on.parent] == joint.name
        )
        found = next(behind, None)
        if found is None:
            return context().mpf(0), context().mpf(0)
        common = dh.normal((at, z), self.line[found], dh.NEARLY_PARALLEL)
        if common is None:
            return context().mpf(0), context().mpf(0)
        foot, x = common
        return dh.half_turn(dh.turn_of(x, before)), (foot - at) @ z

    def host(self, joint: str) -> str:
        """Return the link of a joint; for a fixed link without mass, the link that carries it.

        The joint "" stands for the base.
        """
        link = self.urdf.joints[joint].child if joint else self.urdf.root
        while link != self.urdf.root and self.urdf.links[link] is None:
            if not self.above[link].fixed:
                break
            link = self.above[link].parent
        return link

    def pose(self, joint: str) -> Array:
        """Return the frame (4, 4) of a joint in the frame of the link that hosts it."""
        return inverse(self.link[self.host(joint)]) @ self.frame[joint]

    # --- the robot ------------------------------------------------------------------------------

    def imported(self) -> Imported:
        """Return the robot, its parameters, and notes on differences from the file."""
        joints = tuple(self._joint(self.urdf.joints[name]) for name in self.order)
        base = self.urdf.base
        if not any(joint.movable for joint in joints) and base != names.BASES[-1]:
            raise RobotError(
                "no joint is movable; accepted: at least one that is revolute, continuous or "
                "prismatic"
            )
        gears = [self.urdf.gears[j.name] for j in joints if j.movable and self.urdf.gears]
        rows = tuple(map(tuple, np.diag(gears).tolist()))
        drive = Drive(rows, position_side="joint", torque_side="joint")
        name = robot_name(self.urdf.name)
        if name != self.urdf.name:
            self.notes.append(f"the robot {shortened(self.urdf.name)!r} is called {name}")
        robot = Robot(
            name=name, gravity=(*ORIGIN[:2], EARTH), joints=joints, limits=self._limits(joints),
            base=base,
            frames=tuple(map(self._frame, self.named)), drive=drive if gears else None,
        )  # fmt: skip
        assumed = (
            f"lengths of more than {_FAR} m at joint {first_of(self.far, 3)}: is the file in mm? "
            "accepted: m"
        )
        notes, questions = tuple(self.notes), (assumed,) if self.far else ()
        return Imported(robot, tuple(self._parameters()), notes, questions)

    def _frame(self, link: str) -> Frame:
        """Return the frame of a link, constant in the frame of the joint that moves it."""
        carrier = self.carrier[link]
        placed = inverse(self.frame[carrier]) @ self.link[link]
        x, y, z = map(exact_numbers.to_double, placed[:3, 3])
        roll, pitch, yaw = map(exact_numbers.to_double, dh.turned_by(placed[:3, :3], _DUST))
        return Frame(link, self.number.get(carrier, 0), (x, y, z), (roll, pitch, yaw))

    def _joint(self, joint: UrdfJoint) -> Joint:
        moving = not joint.fixed
        with located(f"joint {shortened(joint.name)!r}"):
            follows = self._follows(joint) if moving and joint.mimic else None
        own = moving and follows is None
        return Joint(
            number=self.number[joint.name],
            sigma=joint.sigma,
            antecedent=self.number.get(self._antecedent(joint), 0),
            friction=("coulomb", "viscous") if own else (),
            rotor_inertia=own,
            follows=follows,
            name=joint.name,
            **self.table[joint.name],
        )

    def _follows(self, joint: UrdfJoint, before: Sequence[str] = ()) -> sp.Expr:
        """Return q of a joint as an expression in the variables of the joints that it follows."""
        if joint.mimic is None:
            return joint_variable(self.number[joint.name])
        if joint.name in before:
            raise RobotError("it mimics itself; accepted: a joint with a variable")
        terms, constant = joint.mimic
        within = _DUST if self.urdf.computed else exact_numbers.TOLERANCE
        k = exact_numbers.fraction_of_pi(constant, within) if not joint.slides else None
        q = constant if k is None else k * sp.pi
        for name, factor in terms:
            if name not in self.urdf.joints:
                raise RobotError(f"there is no joint {shortened(name)!r} to mimic")
            leader = self.urdf.joints[name]
            if leader.fixed:
                raise RobotError(f"it mimics {shortened(name)!r}, which is fixed")
            if factor == 0:
                raise RobotError("its multiplier is 0; accepted: a fixed joint in its place")
            if joint.turns and leader.slides:
                raise RobotError(
                    f"it turns as prismatic joint {shortened(name)!r} slides; accepted: revolute "
                    "joints that mimic revolute ones",
                )
            q += sp.expand(factor * self._follows(leader, (*before, joint.name)))
        if joint.turns and any(abs(q.coeff(variable)) > MAX_RATIO for variable in q.free_symbols):
            raise RobotError(f"its multiplier is above {MAX_RATIO} in size")
        return q

    def _limits(self, joints: Sequence[Joint]) -> Limits | None:
        """Return the kinds of limits that all movable joints have."""
        movable = [self.urdf.joints[joint.name] for joint in joints if joint.movable]
        limits: dict[str, list[Any]] = {
            "position": [(j.limit.get("lower", 0.0), j.limit.get("upper", 0.0)) for j in movable]
        }
        for key, words in _LIMITS.items():
            limits[key] = [
                min((j.limit[w] for w in words if w in j.limit), default=0) for j in movable
            ]
        read: dict[str, Any] = {}
        for key, values in limits.items():
            sizes = [x[1] - x[0] for x in values] if key == "position" else values
            free = [shortened(j.name) for j, size in zip(movable, sizes, strict=True) if size <= 0]
            if not free:
                read[key] = tuple(values)
            elif np.any(values):
                self.notes.append(f"no {key} limits are read: {first_of(free, 3)} has none")
        return Limits(**read) if read and movable else None

    def _parameters(self) -> list[tuple[str, float]]:
        """Return the standard parameters of the file in the order of X; [] if it has none."""
        if not any(self.urdf.links.values()):
            return []
        out: list[tuple[str, float]] = []
        losses: list[tuple[str, float]] = []
        if self.urdf.base == names.BASES[-1]:
            values = self.standard(self.urdf.links[self.urdf.root], self.urdf.root, "")
            out += [(f"{k}0", v) for k, v in zip(names.LINK, values, strict=True)]
        for name in self.order:
            joint, number = self.urdf.joints[name], self.number[name]
            values = self.standard(self.urdf.links[joint.child], joint.child, name)
            out += [(f"{k}{number}", v) for k, v in zip(names.LINK, values, strict=True)]
            if not joint.fixed and joint.mimic is None:
                out.append((f"{names.ROTOR}{number}", joint.armature))
                losses += [(f"FS{number}", joint.friction), (f"FV{number}", joint.damping)]
        return out + losses

    def standard(self, inertial: Inertial | None, link: str, joint: str) -> list[float]:
        """Return XX XY XZ YY YZ ZZ MX MY MZ M of a body on a link, in the frame of a joint.

        The joint "" stands for frame 0.
        """
        if inertial is None:
            return [0.0] * len(names.LINK)
        own = self.link[link] @ self._pose(inertial.xyz, inertial.rpy)
        xx, xy, xz, yy, yz, zz = many(inertial.inertia)
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], dtype=object)
        (mass,) = many((inertial.mass,))
        body = Body(self.number.get(joint, 0), mass, many(ORIGIN), tensor)
        moved = body.moved(inverse(self.frame[joint]) @ own)
        return [exact_numbers.to_double(v) for v in moved.standard]


def many(values: Sequence[sp.Rational]) -> Array:
    """Return exact rationals as numbers with 50 digits."""
    return np.array([context().mpf(int(v.p)) / int(v.q) for v in values], dtype=object)

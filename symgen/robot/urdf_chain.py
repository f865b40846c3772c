"""The joints of a URDF on the frames of modified Denavit-Hartenberg notation.

Everything is placed with 50 digits where all q are zero, in the frame of the root link, and read
off there: the rows of the table, the limits, and the inertias in the new frames.
"""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from typing import Any

import sympy as sp

from symgen import names
from symgen.errors import RobotError
from symgen.robot import denavit_hartenberg as dh
from symgen.robot import recognition
from symgen.robot.denavit_hartenberg import Line, Matrix, Pose, Vector
from symgen.robot.expressions import shortened
from symgen.robot.identifiers import robot_name
from symgen.robot.recognition import context
from symgen.robot.types import MAX_RATIO, Joint, Limits, Robot, joint_variable
from symgen.robot.urdf_text import Triple, Urdf, UrdfJoint

_FAR = 10  # m
_WRITTEN = 1e-14  # rad: an angle with all digits is not rounded
_Y, _Z = (0, 1, 0), (0, 0, 1)
_GRAVITY = (sp.S.Zero, sp.S.Zero, sp.Rational(-981, 100))


class Chain:
    """The joints of a URDF in symgen's order, with their axes and frames where all q are zero."""

    def __init__(self, urdf: Urdf, where: str, exact: bool) -> None:
        self.urdf, self.where, self.exact = urdf, where, exact
        self.notes: list[str] = []
        self.snapped: dict[str, None] = {}
        self.above = {joint.child: joint for joint in urdf.joints.values()}
        self.link = self._link_frames()
        self.carrier = {name: self._carrier(name) for name in urdf.links}
        self.order = self._order()
        self.number = {name: i for i, name in enumerate(self.order, 1)}
        self.line = {name: self._line(urdf.joints[name]) for name in self.order}
        self.frame: dict[str, Pose] = {"": dh.identity()}
        self.table: dict[str, dict[str, sp.Expr]] = {}
        for name in self.order:
            self._place(urdf.joints[name])
        if self.snapped:
            shown = ", ".join(list(self.snapped)[:4])
            more = ", ..." if len(self.snapped) > 4 else ""
            self.notes.insert(0, f"rounded angles read as multiples of pi/24: {shown}{more}")

    def fail(self, joint: UrdfJoint, message: str) -> RobotError:
        return RobotError(f"{self.where}: joint {shortened(joint.name)!r}: {message}")

    # --- the tree -------------------------------------------------------------------------------

    def _below(self) -> dict[str, list[UrdfJoint]]:
        out: dict[str, list[UrdfJoint]] = {name: [] for name in self.urdf.links}
        for joint in self.urdf.joints.values():
            out[joint.parent].append(joint)
        return out

    def _link_frames(self) -> dict[str, Pose]:
        below, out = self._below(), {self.urdf.root: dh.identity()}
        waiting = [self.urdf.root]
        while waiting:
            parent = waiting.pop()
            for joint in below[parent]:
                out[joint.child] = out[parent].times(self._pose(joint.xyz, joint.rpy))
                waiting.append(joint.child)
        return out

    def _carrier(self, link: str) -> str:
        """Return the moving joint that moves a link, or "" for what stands on the root."""
        while link in self.above and self.above[link].sigma == names.FIXED:
            link = self.above[link].parent
        return self.above[link].name if link in self.above else ""

    def _order(self) -> list[str]:
        """Return the joints: those with a variable in document order, what follows, what is fixed.

        A joint that stands on one that follows comes later than that.
        """
        place = {name: i for i, name in enumerate(self.urdf.joints)}
        on: dict[str, list[UrdfJoint]] = {}
        for joint in self.urdf.joints.values():
            on.setdefault(self.carrier[joint.parent], []).append(joint)

        def key(joint: UrdfJoint) -> tuple[int, int, str]:
            fixed = joint.sigma == names.FIXED
            return 2 if fixed else int(joint.mimic is not None), place[joint.name], joint.name

        ready = [key(joint) for joint in on.get("", [])]
        heapq.heapify(ready)
        order: list[str] = []
        while ready:
            name = heapq.heappop(ready)[2]
            order.append(name)
            if self.urdf.joints[name].sigma != names.FIXED:
                for joint in on.get(name, []):
                    heapq.heappush(ready, key(joint))
        return order

    # --- frames ---------------------------------------------------------------------------------

    def _pose(self, xyz: Triple, rpy: Triple) -> Pose:
        """Return Trans(xyz) Rot(z, yaw) Rot(y, pitch) Rot(x, roll), rounded angles as meant."""
        angles = _many(rpy)
        if self.exact:
            angles = self._meant(angles)
        turn = dh.turn(*angles)
        if self.exact:
            turn = self._recognised(turn)
        return Pose(turn.x, turn.y, turn.z, _many(xyz))

    def _meant(self, angles: Vector) -> Vector:
        """Return angles, those near multiples of pi/24 as these."""
        roll, pitch, yaw = (recognition.snapped(angle) for angle in angles)
        for angle, meant in zip(angles, (roll, pitch, yaw), strict=True):
            if abs(meant - angle) > _WRITTEN:
                self.snapped[f"{float(angle):.12g}"] = None
        return roll, pitch, yaw

    def _recognised(self, turn: Pose) -> Pose:
        """Return a rotation whose angles are all near multiples of pi/24 as these."""
        angles = dh.turned_by(turn.x, turn.y, turn.z)
        if any(recognition.fraction_of_pi(angle) is None for angle in angles):
            return turn
        return dh.turn(*self._meant(angles))

    def _line(self, joint: UrdfJoint) -> Line:
        frame = self.link[joint.child]
        if joint.sigma == names.FIXED:
            return Line(frame.origin, frame.z)
        axis = _many(joint.axis)
        axis = dh.scaled(axis, 1 / dh.norm(axis))
        if self.exact:
            flat = tuple(a if abs(a) > recognition.TOLERANCE else context().mpf(0) for a in axis)
            axis = dh.scaled(flat, 1 / dh.norm(flat))
            axis = self._recognised(Pose(axis, _Y, _Z, axis)).x
        return Line(frame.origin, frame.turned(axis))

    def _place(self, joint: UrdfJoint) -> None:
        """Give a joint its row of the table, and its frame."""
        base = self.frame[self.carrier[joint.parent]]
        line = self.line[joint.name]
        gamma, b, alpha, d = dh.reach(base, line)
        before = base.times(dh.screw(2, gamma, b)).times(dh.screw(0, alpha, d))
        theta, r = self._rest(joint, Line(before.origin, before.z), before)
        self.frame[joint.name] = before.times(dh.screw(2, theta, r))
        angles = {"gamma": gamma, "alpha": alpha, "theta": theta}
        lengths = {"b": b, "d": d, "r": r}
        self.table[joint.name] = {
            **{key: recognition.angle(value) for key, value in angles.items()},
            **{key: recognition.length(value) for key, value in lengths.items()},
        }
        if abs(b) > _FAR or abs(r) > _FAR:
            across = dh.norm(dh.cross(base.z, line.direction))  # may be a digit more than 1
            tilt = context().atan2(across, abs(dh.dot(base.z, line.direction)))
            self.notes.append(
                f"joint {joint.name!r}: its axis is {float(tilt):.3g} rad from parallel to the one "
                f"before, which puts b and r at {float(b):.3g} and {float(r):.3g} m"
            )

    def _rest(self, joint: UrdfJoint, line: Line, before: Pose) -> tuple[Any, Any]:
        """Return theta and r, which choose x and the origin of the frame on its z axis."""
        zero = context().mpf(0)
        if joint.sigma == names.FIXED:
            frame = self.link[joint.child]
            x, origin = frame.x, frame.origin
        else:
            found = self._next(joint)
            common = None if found is None else dh.normal(line, self.line[found])
            if common is None:
                return zero, zero
            x, origin = common
        theta = dh.turn_of(x, before)
        if joint.sigma != names.FIXED:
            theta = dh.half_turn(theta)
        return theta, dh.dot(dh.plus(origin, before.origin, -1), before.z)

    def _next(self, joint: UrdfJoint) -> str | None:
        """Return the first moving joint on a joint's link."""
        for name in self.order:
            after = self.urdf.joints[name]
            if after.sigma != names.FIXED and self.carrier[after.parent] == joint.name:
                return name
        return None

    # --- the robot ------------------------------------------------------------------------------

    def robot(self) -> Robot:
        """Return the robot."""
        joints = tuple(self._joint(self.urdf.joints[name]) for name in self.order)
        if not any(joint.movable for joint in joints):
            raise RobotError(
                f"{self.where}: no joint is movable; accepted: at least one that is revolute, "
                "continuous or prismatic"
            )
        name = robot_name(self.urdf.name)
        if name != self.urdf.name:
            self.notes.append(f"the robot {shortened(self.urdf.name)!r} is called {name}")
        return Robot(name=name, gravity=_GRAVITY, joints=joints, limits=self._limits(joints))

    def _joint(self, joint: UrdfJoint) -> Joint:
        carrier = self.carrier[joint.parent]
        moving = joint.sigma != names.FIXED
        follows = self._follows(joint) if moving and joint.mimic else None
        own = moving and follows is None
        return Joint(
            number=self.number[joint.name],
            sigma=joint.sigma,
            antecedent=self.number.get(carrier, 0),
            friction=("coulomb", "viscous") if own else (),
            rotor_inertia=own,
            follows=follows,
            name=joint.name,
            **self.table[joint.name],
        )

    def _follows(self, joint: UrdfJoint) -> sp.Expr:
        """Return q of a joint that mimics, in the variable at the end of its chain."""
        factor, offset, at, seen = sp.S.One, sp.S.Zero, joint, {joint.name}
        while at.mimic is not None:
            name, c, constant = at.mimic
            factor, offset = factor * c, offset + factor * self._offset(constant, joint)
            if name not in self.urdf.joints:
                raise self.fail(joint, f"there is no joint {shortened(name)!r} to mimic")
            if name in seen:
                raise self.fail(joint, "it mimics itself; accepted: a joint with a variable")
            seen.add(name)
            at = self.urdf.joints[name]
            if at.sigma == names.FIXED:
                raise self.fail(joint, f"it mimics {shortened(name)!r}, which is fixed")
        if factor == 0:
            raise self.fail(joint, "its multiplier is 0; accepted: a fixed joint in its place")
        if joint.sigma == names.REVOLUTE and abs(factor) > MAX_RATIO:
            raise self.fail(joint, f"its multiplier is above {MAX_RATIO} in size")
        if joint.sigma == names.REVOLUTE and at.sigma == names.PRISMATIC:
            raise self.fail(
                joint,
                f"it turns as prismatic joint {shortened(at.name)!r} slides; accepted: revolute "
                "joints that mimic revolute ones",
            )
        return factor * joint_variable(self.number[at.name]) + offset

    def _offset(self, written: sp.Rational, joint: UrdfJoint) -> sp.Expr:
        k = recognition.fraction_of_pi(written) if self.exact else None
        return written if k is None or joint.sigma == names.PRISMATIC else k * sp.pi

    def _limits(self, joints: Sequence[Joint]) -> Limits | None:
        """Return the limits that all movable joints have."""
        given = [self.urdf.joints[j.name].limit for j in joints if j.movable]
        columns: dict[str, Any] = {}
        pairs = [(limit.get("lower", 0.0), limit.get("upper", 0.0)) for limit in given]
        if all(low < high for low, high in pairs):
            columns["position"] = tuple(pairs)
        for key, word in (("velocity", "velocity"), ("torque", "effort")):
            values = tuple(limit.get(word, 0.0) for limit in given)
            if min(values) > 0:
                columns[key] = values
        return Limits(**columns) if columns else None

    def parameters(self) -> list[tuple[str, float]]:
        """Return standard parameters from the file, in the order of X; [] where it has none."""
        if all(link.inertial is None for link in self.urdf.links.values()):
            return []
        out: list[tuple[str, float]] = []
        losses: list[tuple[str, float]] = []
        for name in self.order:
            joint, number = self.urdf.joints[name], self.number[name]
            values = _standard(self._body(joint.child))
            out += [(f"{k}{number}", v) for k, v in zip(names.LINK, values, strict=True)]
            if joint.sigma != names.FIXED and joint.mimic is None:
                out.append((f"{names.ROTOR}{number}", 0.0))
                losses += [(f"FS{number}", joint.friction), (f"FV{number}", joint.damping)]
        return out + losses

    def inside(self, name: str) -> Pose:
        """Return the frame of a joint's child link in the joint's own frame."""
        return self.frame[name].inverse().times(self.link[self.urdf.joints[name].child])

    def _body(self, link: str) -> tuple[Any, Vector, Matrix]:
        """Return mass, centre of mass and inertia about it of a link, in its joint's frame."""
        inertial = self.urdf.links[link].inertial
        zero = context().mpf(0)
        if inertial is None:
            return zero, (zero,) * 3, ((zero,) * 3,) * 3
        pose = self.inside(self.above[link].name).times(self._pose(inertial.xyz, inertial.rpy))
        xx, xy, xz, yy, yz, zz = _many(inertial.inertia)
        tensor = ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
        return _many((inertial.mass,))[0], pose.origin, pose.tensor(tensor)


def _standard(body: tuple[Any, Vector, Matrix]) -> list[float]:
    """Return XX XY XZ YY YZ ZZ MX MY MZ M about the frame's origin."""
    mass, c, inertia = body
    square = dh.dot(c, c)
    about = [
        inertia[i][k] + mass * ((square if i == k else 0) - c[i] * c[k])
        for i in range(3)
        for k in range(i, 3)
    ]
    return [recognition.number(v) for v in (*about, *dh.scaled(c, mass), mass)]


def _many(values: Sequence[sp.Rational]) -> Any:
    """Return exact rationals with 50 digits."""
    return tuple(context().mpf(int(v.p)) / int(v.q) for v in values)

"""Read MJCF, the format of MuJoCo.

MuJoCo's compiler reads the file, so defaults, classes, included files, degrees and inertias from
geometry have their usual meaning. Install it with `pip install 'symgen[mjcf]'`.
https://mujoco.readthedocs.io/en/stable/XMLreference.html

A link frame has its origin at the anchor of the body's last joint, and the axes of the body frame.
A body with several joints gets a link without mass for each joint but the last.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from decimal import Decimal
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import sympy as sp

from symgen import names
from symgen.errors import ParameterError, RobotError, located, message_of, plain
from symgen.robot import expressions
from symgen.robot.body import FloatArray
from symgen.robot.declared_effects import of_library
from symgen.robot.dh import turned_by
from symgen.robot.effect import definitions
from symgen.robot.exact_numbers import angle, context
from symgen.robot.expressions import shortened
from symgen.robot.formats.chain import ORIGIN, Chain, Inertial, Triple, Urdf, UrdfJoint
from symgen.robot.formats.xml import parse_xml
from symgen.robot.imported import Imported
from symgen.robot.tables import Coupling
from symgen.robot.types import WITHOUT_MOTOR, Robot

ACCEPTED = "an MJCF of an arm on a fixed base"
_DIGITS = 14
_ON_JOINTS = 1  # transmission types of MuJoCo up to this number act on joints
SPRING = "gravity_spring"
_SIGMA = {"slide": names.PRISMATIC, "hinge": names.REVOLUTE}


def import_mjcf(text: str, where: str = "robot.xml") -> Imported:
    """Read an MJCF as a robot, with the inertias of its bodies as standard parameters.

    armature becomes IA, damping becomes FV, and frictionloss becomes FS. A spring of a joint
    becomes the effect gravity_spring, with an offset if it is not at rest at 0. A fixed tendon
    between two joints becomes a coupling. Of actuators, only the limits of their forces are read.

    Args:
        text: the file's text.
        where: path of the file; MuJoCo reads it and the files that it includes.

    Raises:
        RobotError: MuJoCo is not installed or refuses the file, or symgen cannot represent the
            robot.
    """
    with located(where):
        tree = MjcfTree(Path(where), text)
        chain = Chain(tree.urdf)
        found = chain.imported()
        with located("gravity"):
            gravity = tuple(map(_exact, tree.model.opt.gravity))
        if not any(gravity):
            raise RobotError("gravity is zero; accepted: the gravity that the robot works in")
    robot = replace(found.robot, gravity=gravity, couplings=tree.couplings(chain))
    values = [*found.parameters, *tree.coupled(chain)]
    offsets = {}
    for name, (stiffness, rest) in tree.springs.items():
        joint = robot.joint(chain.number[name])
        spring = of_library(definitions()[SPRING], joint.number, joint.sigma, {}, {})
        robot = replace(robot, effects=(*robot.effects, spring))
        values.append((spring.linear[0][0], stiffness))
        if rest:
            offsets[joint.number] = -stiffness * rest
    joints = []
    for joint in robot.joints:
        if joint.number in offsets:
            joint = replace(joint, friction=(*joint.friction, "offset"))
        key = "r" if joint.slides else "theta"
        zero = angle(context().mpf(tree.zeros.get(joint.name, 0.0)))
        joints.append(replace(joint, **{key: getattr(joint, key) - zero}))
    values += [(f"OF{number}", torque) for number, torque in offsets.items()]
    robot = replace(robot, joints=tuple(joints))
    notes, assumed = (
        (*found.notes, *tree.notes),
        (*found.assumed, *_without_motor(robot, tree.model)),
    )
    return replace(found, robot=robot, parameters=tuple(values), notes=notes, assumed=assumed)


def _without_motor(robot: Robot, model: Any) -> Iterator[str]:
    """Yield a note on the joints without an actuator, if every actuator moves a joint."""
    if (model.actuator_trntype > _ON_JOINTS).any():
        return
    moved = {model.joint(int(j)).name for j in model.actuator_trnid[:, 0]}
    still = [k for k, joint in enumerate(robot.movable) if joint.name not in moved]
    if moved and still:
        yield (
            f"no actuator moves {robot.listed(still)}; a motor is assumed: if there is none, "
            f"{WITHOUT_MOTOR}"
        )


class _Tendon(NamedTuple):
    """A fixed tendon of length q_first + ratio q_second."""

    name: str
    ratio: float
    armature: float
    damping: float
    frictionloss: float


class MjcfTree:
    """A compiled MJCF as links and joints.

    Attributes:
        model: model of MuJoCo.
        root: root element of the text.
        urdf: the tree.
        shift: origin of each link frame in its body frame, (3,) m.
        springs: stiffness, and position without torque, of the joints with a spring.
        tendons: fixed tendon between two joints, by their names.
        mimics: joints that follow others: the leader, factor and offset, as in a URDF.
        zeros: positions of joints in the pose of the file (ref), rad or m.
        notes: ignored content of the file.
    """

    def __init__(self, path: Path, text: str) -> None:
        self.notes: list[str] = []
        self._path, self.model = path, _compiled(path, self.notes)
        self.mimics = self._mimics()
        self.zeros: dict[str, float] = {}
        self.shift: dict[str, FloatArray] = {}
        self.springs: dict[str, tuple[float, float]] = {}
        self._links: dict[str, Inertial | None] = {}
        self._joints: dict[str, UrdfJoint] = {}
        m = self.model
        self._body_names = [m.body(b).name or f"body{b}" for b in range(m.nbody)]
        for b, body in enumerate(self._body_names):
            with located(f"body {shortened(body)!r}"):
                self._add(b)
        self.tendons = self._tendons()
        if m.neq > len(self.mimics):
            count = m.neq - len(self.mimics)
            self.notes.append(f"{count} equality constraints of the file are not read")
        if m.body_gravcomp.any():
            self.notes.append("the gravity compensation of bodies (gravcomp) is not read")
        if m.ntendon > len(self.tendons):
            self.notes.append(
                f"{m.ntendon - len(self.tendons)} tendons of the file are not read: they are no "
                "drives of two joints"
            )
        self.root = parse_xml(text)
        title = self.root.attributes.get("model", "") or path.stem
        self.urdf = Urdf(title, self._body_names[0], self._links, self._joints, computed=True)

    def _add(self, b: int) -> None:
        """Add a body, and a link without mass for each joint but the last."""
        m, name = self.model, self._body_names[b]
        if b == 0:
            self.shift[name] = np.zeros(3)
            self._links[name] = None
            return
        parent = self._body_names[m.body_parentid[b]]
        R = _matrix(m.body_quat[b])
        at = np.array(m.body_pos[b]) - self.shift[parent]
        first, count = int(m.body_jntadr[b]), int(m.body_jntnum[b])
        # MuJoCo allows free joints on bodies of the world only.
        floats = bool(count) and int(m.jnt_type[first]) == 0
        count = 0 if floats else count
        before, xyz, rpy = parent, at, _triple(turned_by(R))
        previous = np.zeros(3)
        for k in range(first, first + count):
            anchor = np.array(m.jnt_pos[k])
            xyz = at + R @ anchor if k == first else anchor - previous
            last = k == first + count - 1
            link = name if last else f"{name}:{k}"
            joint = self._joint(k, before, link, xyz, rpy)
            self._joints[joint.name] = joint
            if not last:
                self._links[link] = None
            before, rpy, previous = link, ORIGIN, anchor
        if count == 0:
            joint = UrdfJoint(
                f"{name}_fixed", names.FIXED, parent, name, _triple(xyz), rpy, floats=floats
            )
            self._joints[joint.name] = joint
        self.shift[name] = previous
        body = self._inertial(b)
        self._links[name] = body if body.mass else None

    def _mimics(self) -> dict[str, tuple[str, sp.Rational, sp.Rational]]:
        """Return the joints that an equality couples linearly to another joint of their type.

        With the positions y0 and x0 in the pose of the file, y - y0 = a0 + a1 (x - x0).
        """
        import mujoco

        m, out = self.model, {}
        for k in np.flatnonzero(m.eq_type == mujoco.mjtEq.mjEQ_JOINT):
            joints = [int(m.eq_obj1id[k]), int(m.eq_obj2id[k])]
            y0, x0 = m.qpos0[m.jnt_qposadr[joints]]
            a0, a1, *higher = m.eq_data[k][:5]
            if joints[1] >= 0 and a1 and not any(higher) and len({*m.jnt_type[joints]}) == 1:
                follower, leader = (m.joint(joint).name for joint in joints)
                out[follower] = leader, _exact(a1), _exact(y0 + a0 - a1 * x0)
        return out

    def _joint(self, k: int, parent: str, child: str, xyz: FloatArray, rpy: Triple) -> UrdfJoint:
        m = self.model
        name = m.joint(k).name or f"joint{k + 1}"
        kind = ("free", "ball", "slide", "hinge")[int(m.jnt_type[k])]
        self.zeros[name] = float(m.qpos0[m.jnt_qposadr[k]])
        with located(f"joint {shortened(name)!r}"):
            if kind not in _SIGMA:
                raise RobotError(f"it is {kind}; accepted: hinge, slide")
            if not abs(np.linalg.norm(m.jnt_axis[k]) - 1) < 1e-6:  # numbers beyond 1e154 overflow
                raise RobotError(
                    "its axis has no direction; accepted: three finite numbers, not all 0"
                )
        limit = {}
        if m.jnt_limited[k]:
            limit["lower"], limit["upper"] = map(float, m.jnt_range[k])
        forces = np.abs(m.actuator_forcerange).max(axis=1) * m.actuator_forcelimited
        on = (m.actuator_trntype <= _ON_JOINTS) & (m.actuator_trnid[:, 0] == k)
        of_actuators = np.abs(m.actuator_gear[on, 0]) @ forces[on] * forces[on].all()
        of_joint = np.abs(m.jnt_actfrcrange[k]).max() * m.jnt_actfrclimited[k]
        if efforts := [float(effort) for effort in (of_actuators, of_joint) if effort]:
            limit["effort"] = min(efforts)
        dof = int(m.jnt_dofadr[k])
        stiffness = float(m.jnt_stiffness[k].flat[0])
        if stiffness and name not in self.mimics:
            self.springs[name] = stiffness, float(m.qpos_spring[m.jnt_qposadr[k]])
        damping = float(m.dof_damping[dof].flat[0])
        friction, armature = float(m.dof_frictionloss[dof]), float(m.dof_armature[dof])
        for key, loss in (("damping", damping), ("frictionloss", friction), ("armature", armature)):
            with located(f"joint {shortened(name)!r}, {key}"):
                _exact(loss)
        return UrdfJoint(
            name, _SIGMA[kind], parent, child, _triple(xyz), rpy, _triple(m.jnt_axis[k]), limit,
            damping, friction, armature, self.mimics.get(name),
        )  # fmt: skip

    def _tendons(self) -> dict[tuple[str, str], _Tendon]:
        """Return the fixed tendons between two joints; the first has the coefficient 1."""
        import mujoco

        m, out = self.model, dict[tuple[str, str], _Tendon]()
        for k in range(m.ntendon):
            first, count = int(m.tendon_adr[k]), int(m.tendon_num[k])
            fixed = all(m.wrap_type[first + i] == mujoco.mjtWrap.mjWRAP_JOINT for i in range(count))
            if not fixed or count != 2 or m.wrap_prm[first] != 1 or m.tendon_stiffness[k].any():
                continue
            one, two = (m.joint(int(m.wrap_objid[first + i])).name for i in range(2))
            losses = (
                float(np.ravel(getattr(m, f"tendon_{key}")[k])[0])
                for key in ("armature", "damping", "frictionloss")
            )
            if one and two and not self.mimics.keys() & {one, two}:
                ratio = float(m.wrap_prm[first + 1])
                out[one, two] = _Tendon(m.tendon(k).name, ratio, *losses)
        return out

    def couplings(self, chain: Chain) -> tuple[Coupling, ...]:
        """Return the tendons as couplings, with joint numbers."""
        return tuple(
            Coupling((chain.number[one], chain.number[two]), _exact(tendon.ratio))
            for (one, two), tendon in self.tendons.items()
        )

    def coupled(self, chain: Chain) -> Iterator[tuple[str, float]]:
        """Yield the parameters of the couplings."""
        for (_, two), tendon in self.tendons.items():
            number = chain.number[two]
            yield f"IAM{number}", tendon.armature
            yield f"FVM{number}", tendon.damping
            yield f"FSM{number}", tendon.frictionloss

    def require_weight_on_motors(self) -> None:
        """Refuse bodies whose weight MuJoCo compensates without the actuators.

        Raises:
            ParameterError: there is such a body.
        """
        m = self.model
        if m.body_gravcomp.any() and not m.jnt_actgravcomp.all():
            name = self._body_names[int(np.flatnonzero(m.body_gravcomp)[0])]
            raise ParameterError(
                f"gravcomp of the body {plain(name)!r} carries weight that the motors carry in the "
                "logs; accepted: a file without it, or with actuatorgravcomp on all joints"
            )

    @property
    def degrees(self) -> float:
        """The number that the file contains for a radian."""
        import mujoco

        compiler = mujoco.MjSpec.from_file(str(self._path)).compiler
        return float(np.degrees(1.0)) if compiler.degree else 1.0

    def _inertial(self, b: int) -> Inertial:
        """Return the inertia of a body in its link frame."""
        m = self.model
        R = _matrix(m.body_iquat[b])
        tensor = R @ np.diag(m.body_inertia[b]) @ R.T
        values = tuple(_exact(tensor[i, k]) for i in range(3) for k in range(i, 3))
        centre = np.array(m.body_ipos[b]) - self.shift[self._body_names[b]]
        return Inertial(_triple(centre), ORIGIN, _exact(m.body_mass[b]), values)


def _compiled(path: Path, notes: list[str]) -> Any:
    """Return the MuJoCo model of a file; without meshes if one is missing.

    Args:
        path: path of the file.
        notes: receives a line if meshes are ignored.

    Raises:
        RobotError: MuJoCo is not installed, or refuses the file.
    """
    try:
        import mujoco
    except ImportError as error:
        raise RobotError(
            "MuJoCo is not installed; accepted: after pip install 'symgen[mjcf]'"
        ) from error
    mujoco.set_mju_user_warning(lambda _: None)  # MuJoCo would print, and write MUJOCO_LOG.TXT
    try:
        return mujoco.MjModel.from_xml_path(str(path))
    except (ValueError, OSError) as error:
        notes.append(f"meshes are left out: {message_of(error)}")
        try:
            return _without_meshes(mujoco.MjSpec.from_file(str(path)))
        except (ValueError, OSError):
            what = f"MuJoCo refuses it: {message_of(error)}; accepted: {ACCEPTED}"
            raise RobotError(what) from error
    finally:
        mujoco.set_mju_user_warning(None)


def _without_meshes(spec: Any) -> Any:
    """Return the model of a file without meshes, except those that determine an inertia.

    Raises:
        ValueError: MuJoCo refuses it.
    """
    import mujoco

    forced = spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
    for geom in spec.geoms:
        body = geom.parent
        shown = body == spec.worldbody or (body.explicitinertial and not forced)
        if shown and geom.type == mujoco.mjtGeom.mjGEOM_MESH:
            spec.delete(geom)
    used = {geom.meshname for geom in spec.geoms}
    for shape in spec.meshes:
        if shape.name not in used:
            spec.delete(shape)
    return spec.compile()


def _exact(value: float) -> sp.Rational:
    """Round a double to a decimal of fourteen digits."""
    return expressions.exact(Decimal(repr(round(float(value), _DIGITS))))


def _triple(values: Iterable[float]) -> Triple:
    x, y, z = map(_exact, values)
    return x, y, z


def _matrix(quaternion: FloatArray) -> FloatArray:
    """Return the rotation of a quaternion (w, x, y, z)."""
    import mujoco

    R = np.zeros(9)
    mujoco.mju_quat2Mat(R, quaternion)
    return R.reshape(3, 3)

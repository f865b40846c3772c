"""Read MJCF, the format of MuJoCo.

MuJoCo's compiler reads the file, so defaults, classes, included files, degrees and inertias from
geometry have their usual meaning. Install it with `pip install 'symgen[mjcf]'`.
https://mujoco.readthedocs.io/en/stable/XMLreference.html

A link frame has its origin at the anchor of the body's last joint, and the axes of the body frame.
A body with several joints gets a link without mass for each joint but the last.

Torques prove the import: those of the robot agree with those of MuJoCo, or the file is refused.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from decimal import Decimal
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from symgen import names
from symgen.errors import (
    ParameterError,
    RobotError,
    first_of,
    located,
    message_of,
    plain,
    shortened,
)
from symgen.robot import expressions
from symgen.robot.body import COUPLING, FloatArray
from symgen.robot.declared_effects import of_library
from symgen.robot.dh import turned_by
from symgen.robot.effect import definitions
from symgen.robot.exact_numbers import TOLERANCE, angle, context
from symgen.robot.formats.chain import (
    ORIGIN,
    Chain,
    Inertial,
    Mimic,
    Triple,
    Urdf,
    UrdfJoint,
    on_base,
)
from symgen.robot.formats.mjcf_torques import LINEAR, disabling, equality, quiet, unread
from symgen.robot.formats.xml import parse_xml
from symgen.robot.imported import Imported
from symgen.robot.tables import Coupling
from symgen.robot.types import WITHOUT_MOTOR, Robot

ACCEPTED = "an MJCF of an arm on a fixed base"
_DIGITS = 14
_ON_JOINTS, _TENDON = (0, 1), 3  # transmission types of MuJoCo
_CONNECT, _GEAR = 0, 2  # types of equalities of MuJoCo
SPRING = "gravity_spring"
#: Effects of springs and dampers with higher orders.
CABLE, DRAG = "cable_torque", "nonlinear_viscous_friction"
#: Types of joints of MuJoCo from this number on slide or turn about an axis.
SLIDE = 2
_SIGMA = {"slide": names.PRISMATIC, "hinge": names.REVOLUTE}


def import_mjcf(text: str, where: str = "robot.xml", base: str | None = None) -> Imported:
    """Read an MJCF as a robot, with the inertias of its bodies as standard parameters.

    armature becomes IA, damping becomes FV, and frictionloss becomes FS, with the shares of the
    actuators of the joint and of the joints that follow it. Damping of higher order becomes the
    effect nonlinear_viscous_friction. A spring becomes gravity_spring, or cable_torque if it has
    higher orders, with an offset if it is not at rest at 0. A fixed tendon between two joints
    becomes a coupling. The limits of forces are those of the joint and of its actuators.

    Args:
        text: the file's text.
        where: path of the file; MuJoCo reads it and the files that it includes.
        base: base of the robot. A body with a free joint is link 0, unless the base is fixed.

    Raises:
        RobotError: MuJoCo is not installed or refuses the file, symgen cannot represent the robot,
            or its torques are not those of MuJoCo. Or the file has a free joint, and `base` is
            None.
    """
    with located(where):
        tree = MjcfTree(Path(where), text)
        free = [joint.child for joint in tree.urdf.joints.values() if joint.floats]
        if free and base is None:
            line = f"symgen import {Path(where).name} --into robot.toml --base"
            raise RobotError(
                f"body {shortened(free[0])!r} has a free joint; accepted: {line} floating, for a "
                "robot with legs, wings or wheels; or with --base imu, for its joints only, or "
                "--base fixed, for a robot that is held"
            )
        chain = Chain(on_base(tree.urdf, base))
        found = chain.imported()
        with located("gravity"):
            field = tree.model.opt.gravity
            if chain.urdf.root != tree.urdf.root:
                field = _matrix(tree.model.body(chain.urdf.root).quat).T @ field
            gravity = tuple(map(_exact, field))
        if not any(gravity) or tree.is_off("GRAVITY"):
            raise RobotError("gravity is zero; accepted: the gravity that the robot works in")
    robot, values = replace(found.robot, gravity=gravity), [*found.parameters]
    for pair, tendon in tree.tendons.items():
        first, second = (chain.number[name] for name in pair)
        coupling = Coupling((first, second), _exact(tendon.ratio))
        robot = replace(robot, couplings=(*robot.couplings, coupling))
        losses = ((f"{key}{second}", getattr(tendon.losses, x)) for key, x in COUPLING.items())
        values += losses
    for name, effect, coefficients, constants in tree.effects():
        joint = robot.joint(chain.number[name])
        added = of_library(definitions()[effect], joint.number, joint.sigma, constants)
        robot = replace(robot, effects=(*robot.effects, added))
        named = (coefficient for coefficient, _ in robot.effects[-1].linear)
        values += zip(named, coefficients, strict=True)
    joints = []
    for joint in robot.joints:
        torque, *_ = tree.springs.get(joint.name, [0.0])
        if torque:
            values.append((f"OF{joint.number}", float(torque)))
            joint = replace(joint, friction=(*joint.friction, "offset"))
        key = "r" if joint.slides else "theta"
        zero = angle(context().mpf(tree.zeros.get(joint.name, 0.0)))
        joints.append(replace(joint, **{key: getattr(joint, key) - zero}))
    robot = replace(robot, joints=tuple(joints))
    assumed = (*found.assumed, *_without_motor(robot, tree.model))
    read = replace(found, robot=robot, parameters=tuple(values), assumed=assumed)
    with located(where):
        missing = unread(read, tree.model, len(tree.tendons), rounded=bool(chain.snapped))
        notes = (*found.notes, *tree.notes, *missing)
    return replace(read, notes=notes)


def _without_motor(robot: Robot, model: Any) -> Iterator[str]:
    """Yield a note on the joints without an actuator, if every actuator moves a joint."""
    if not np.isin(model.actuator_trntype, _ON_JOINTS).all():
        return
    moved = {model.joint(int(j)).name for j in model.actuator_trnid[:, 0]}
    still = [k for k, joint in enumerate(robot.movable) if joint.name not in moved]
    if moved and still:
        yield (
            f"no actuator moves {robot.listed(still)}; a motor is assumed: if there is none, "
            f"{WITHOUT_MOTOR}"
        )


class Losses(NamedTuple):
    """Armature, damping v + damping_2 v|v| + damping_3 v^3, and Coulomb friction of a joint."""

    armature: float
    damping: float
    damping_2: float
    damping_3: float
    frictionloss: float


#: Orders in which the losses grow with the ratio of a follower.
_ORDERS = np.array([2, 2, 3, 4, 1])
#: Arrays of MuJoCo with the losses, in their order, and numbers in a row.
_SIZES = {"armature": 1, "damping": 1, "dampingpoly": 2, "frictionloss": 1}


def _row(model: Any, name: str, k: Any, size: int = 2) -> list[float]:
    """Return row k of an array of the model; zeros where MuJoCo is older than the array."""
    array = getattr(model, name, None)
    return [0.0] * size if array is None else np.ravel(array[k]).tolist()


def _own_losses(model: Any, of: str, k: Any) -> FloatArray:
    """Return the `Losses` of a degree of freedom ("dof"), tendon or actuator alone, (5,)."""
    rows = [_row(model, f"{of}_{key}", k, size) for key, size in _SIZES.items()]
    return np.concatenate(rows)


class _Tendon(NamedTuple):
    """A fixed tendon of length q_first + ratio q_second, with the losses of its actuators."""

    name: str
    ratio: float
    losses: Losses
    added: Losses


class MjcfTree:
    """A compiled MJCF as links and joints.

    Attributes:
        model: model of MuJoCo.
        root: root element of the text.
        urdf: the tree.
        shift: origin of each link frame in its body frame, (3,) m.
        losses: of each joint with those of its actuators and followers, and `added`, these alone.
        springs: torque of the springs of a joint, c0 + c1 q + c2 q^2 + c3 q^3, (4,).
        tendons: fixed tendon between two joints, by their names.
        mimics: joints that follow others, as in a URDF.
        zeros: positions of joints in the pose of the file (ref), rad or m.
        notes: ignored content of the file.
    """

    def __init__(self, path: Path, text: str) -> None:
        self.notes: list[str] = []
        self._path, self.model = path, compiled(path, self.notes)
        m = self.model
        self._joint_names = [m.joint(k).name or f"joint{k + 1}" for k in range(m.njnt)]
        self.mimics = self._mimics()
        self.zeros: dict[str, float] = {}
        self.shift: dict[str, FloatArray] = {}
        self.added, self.losses = self._losses()
        self.springs = self._springs()
        self._links: dict[str, Inertial | None] = {}
        self._joints: dict[str, UrdfJoint] = {}
        self._body_names = [m.body(b).name or f"body{b}" for b in range(m.nbody)]
        for b, body in enumerate(self._body_names):
            with located(f"body {shortened(body)!r}"):
                self._add(b)
        self.tendons = self._tendons()
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
            link = name if k == first + count - 1 else f"{name}:{k}"
            joint = self._joint(k, before, link, xyz, rpy)
            self._joints[joint.name] = joint
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

    def _mimics(self) -> dict[str, Mimic]:
        """Return the joints that equalities bind to others.

        The first joint of a gear follows the second. In a loop, joints without an actuator follow
        the others. The factors are those of the constraints in the pose of the file. Gears and
        parallelograms have them in every pose; the comparison with MuJoCo refuses other loops.

        Raises:
            RobotError: an equality is not read, or a loop has too few actuators.
        """
        import mujoco

        self._require_read()
        m, data, out = self.model, mujoco.MjData(self.model), dict[str, Mimic]()
        m.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        with quiet():
            mujoco.mj_fwdPosition(m, data)
        J = data.efc_J.reshape(data.nefc, m.nv)[: data.ne][:, m.jnt_dofadr]
        places = data.efc_id[: data.ne]
        gears = m.eq_type[places] == _GEAR
        first = m.eq_obj1id[places[gears]]
        moved = m.actuator_trnid[np.isin(m.actuator_trntype, _ON_JOINTS), 0]
        in_loops = np.flatnonzero(abs(J[~gears]).max(axis=0, initial=0) > TOLERANCE)
        passive = np.union1d(first, np.setdiff1d(in_loops, moved))
        if np.linalg.matrix_rank(J[:, passive], TOLERANCE) < len(passive):
            named = first_of([equality(m, k) for k in sorted({*places})])
            raise RobotError(f"joints without an actuator are free in {named}; {LINEAR}")
        back, q0 = -np.linalg.pinv(J[:, passive]), m.qpos0[m.jnt_qposadr]
        ends = q0[passive] + back @ data.efc_pos[: data.ne]
        J[:, passive] = 0
        rates = back @ J
        factors = np.where(abs(rates - np.rint(rates)) < TOLERANCE, np.rint(rates), rates)
        for j, line, at in zip(passive, factors, ends, strict=True):
            terms = [(self._joint_names[k], _exact(line[k])) for k in np.flatnonzero(line)]
            if terms:
                out[self._joint_names[j]] = tuple(terms), _exact(at - line @ q0)
        return out

    def _joint(self, k: int, parent: str, child: str, xyz: FloatArray, rpy: Triple) -> UrdfJoint:
        m = self.model
        name = self._joint_names[k]
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
        on = np.isin(m.actuator_trntype, _ON_JOINTS) & (m.actuator_trnid[:, 0] == k)
        of_actuators = np.abs(m.actuator_gear[on, 0]) @ forces[on] * forces[on].all()
        of_joint = np.abs(m.jnt_actfrcrange[k]).max() * m.jnt_actfrclimited[k]
        if efforts := [float(effort) for effort in (of_actuators, of_joint) if effort]:
            limit["effort"] = min(efforts)
        losses = self.losses[name]
        for key, loss in zip(Losses._fields, losses, strict=True):
            with located(f"joint {shortened(name)!r}, {key}"):
                _exact(loss)
        return UrdfJoint(
            name, _SIGMA[kind], parent, child, _triple(xyz), rpy, _triple(m.jnt_axis[k]), limit,
            losses.damping, losses.frictionloss, losses.armature, self.mimics.get(name),
        )  # fmt: skip

    def is_off(self, flag: str) -> bool:
        """Return whether <flag> of the file disables a part of the physics: GRAVITY, SPRING, ..."""
        return bool(self.model.opt.disableflags & disabling(flag))

    def _losses(self) -> tuple[dict[str, Losses], dict[str, Losses]]:
        """Return the losses that actuators and followers add to each joint, and all of the joint.

        An actuator of gear g adds g^2 times its armature and damping. A follower q = c q_leader + d
        adds its losses times |c|^2, |c| for Coulomb friction, and one order of |c| more for each
        order of damping.
        """
        m = self.model
        own = np.zeros((m.njnt, len(Losses._fields)))
        for k in np.flatnonzero(m.jnt_type >= SLIDE):
            own[k] = _own_losses(m, "dof", m.jnt_dofadr[k])
        added = self._actuators(np.arange(m.njnt), _ON_JOINTS)
        place = {name: k for k, name in enumerate(self._joint_names)}
        total = own + added
        for follower in self.mimics:
            if total[place[follower]].any():
                leader, factor, _ = self._followed(follower)
                added[place[leader]] += abs(factor) ** _ORDERS * total[place[follower]]
        used = ((self._used * x).tolist() for x in (added, own + added))
        rows = (zip(self._joint_names, (Losses(*row) for row in x), strict=True) for x in used)
        more, every = map(dict, rows)
        return more, every

    @property
    def _used(self) -> FloatArray:
        """1 for the losses that the flags of the file leave on, 0 for the others."""
        damps = not self.is_off("DAMPER")
        rubs = not (self.is_off("FRICTIONLOSS") or self.is_off("CONSTRAINT"))
        return np.array([1, damps, damps, damps, rubs], dtype=float)

    def _actuators(self, places: NDArray[np.intp], kinds: Sequence[int]) -> FloatArray:
        """Return the losses that actuators add to some joints or tendons: g^2 times their own.

        Args:
            places: indices of the joints or tendons.
            kinds: types of transmissions that act on them.
        """
        m = self.model
        out = np.zeros((len(places), len(Losses._fields)))
        for k in np.flatnonzero(np.isin(m.actuator_trntype, kinds)):
            own = _own_losses(m, "actuator", k)
            out[places == m.actuator_trnid[k, 0]] += m.actuator_gear[k, 0] ** 2 * own
        return out

    def _followed(self, joint: str) -> tuple[str, float, float]:
        """Return the joint that a follower follows, with q = factor q_leader + offset.

        Raises:
            RobotError: it follows two joints.
        """
        terms, offset = self.mimics.get(joint, (((joint, sp.S.One),), sp.S.Zero))
        if len(terms) > 1:
            raise RobotError(
                f"joint {shortened(joint)!r} follows two joints; accepted: such a joint without "
                "springs, armature, damping and friction"
            )
        ((leader, factor),) = terms
        return leader, float(factor), float(offset)

    def _springs(self) -> dict[str, FloatArray]:
        """Return the torque of the springs of each joint with some: c0 + c1 q + c2 q^2 + c3 q^3.

        A joint has its own spring k1 x + k2 x^2 + k3 x^3, x = q - springref, and, with the torque
        times the factor, those of its followers.
        """
        m, out = self.model, dict[str, FloatArray]()
        for k in () if self.is_off("SPRING") else np.flatnonzero(m.jnt_type >= SLIDE):
            own = [0.0, float(m.jnt_stiffness[k]), *_row(m, "jnt_stiffnesspoly", k)]
            rest = float(m.qpos_spring[m.jnt_qposadr[k]])
            if any(own):
                leader, factor, offset = self._followed(self._joint_names[k])
                stretch = np.polynomial.Polynomial([offset - rest, factor])
                torque = (factor * np.polynomial.Polynomial(own)(stretch)).coef
                spring = out.setdefault(leader, np.zeros(len(own)))
                spring[: len(torque)] += torque.astype(float)
        return out

    def effects(self) -> Iterator[tuple[str, str, list[float], dict[str, sp.Expr]]]:
        """Yield joint, name, coefficients and constants of the effects of the library."""
        for name, spring in self.springs.items():
            effect = CABLE if any(spring[2:]) else SPRING
            yield name, effect, spring[1 : 4 if effect == CABLE else 2].tolist(), {}
        for name, losses in self.losses.items():
            for order, value in ((2, losses.damping_2), (3, losses.damping_3)):
                if value and name not in self.mimics:
                    yield name, DRAG, [value], {"p": sp.Integer(order)}

    def _require_read(self) -> None:
        """Refuse constraints between links or joints that symgen does not read.

        Raises:
            RobotError: there is such a constraint.
        """
        import mujoco

        m = self.model
        for k in np.flatnonzero(m.eq_active0):
            kind, first, second = m.eq_type[k], m.eq_obj1id[k], m.eq_obj2id[k]
            on_bodies = m.eq_objtype[k] == mujoco.mjtObj.mjOBJ_BODY
            if on_bodies and max(m.body_mocapid[[first, second]]) >= 0:
                m.eq_active0[k] = 0  # it follows the scene
            elif kind != _CONNECT and (kind != _GEAR or any(m.eq_data[k][2:5])):
                raise RobotError(f"{equality(m, k)} is not read; {LINEAR}")

    def _tendons(self) -> dict[tuple[str, str], _Tendon]:
        """Return the fixed tendons between two joints; the first has the coefficient 1."""
        import mujoco

        m, out = self.model, dict[tuple[str, str], _Tendon]()
        for k in range(m.ntendon):
            path = m.tendon_adr[k] + np.arange(m.tendon_num[k])
            fixed = (m.wrap_type[path] == mujoco.mjtWrap.mjWRAP_JOINT).all()
            springs = m.tendon_stiffness[k].any() or any(_row(m, "tendon_stiffnesspoly", k))
            if not fixed or len(path) != 2 or m.wrap_prm[path[0]] != 1 or springs:
                continue
            one, two = (m.joint(int(joint)).name for joint in m.wrap_objid[path])
            added = self._used * self._actuators(np.array([k]), (_TENDON,))[0]
            losses = added + self._used * _own_losses(m, "tendon", k)
            if one and two and not self.mimics.keys() & {one, two} and not losses[2:4].any():
                about = m.tendon(k).name, float(m.wrap_prm[path[1]])
                out[one, two] = _Tendon(*about, *(Losses(*x.tolist()) for x in (losses, added)))
        return out

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


def compiled(path: Path, notes: list[str], accepted: str = ACCEPTED) -> Any:
    """Return the MuJoCo model of an MJCF or URDF; without meshes if one is missing.

    Args:
        path: path of the file.
        notes: receives a line if meshes are ignored.
        accepted: the accepted files, for error messages.

    Raises:
        RobotError: MuJoCo is not installed, or refuses the file.
    """
    try:
        import mujoco
    except ImportError as error:
        raise RobotError(
            "MuJoCo is not installed; accepted: after pip install 'symgen[mjcf]'"
        ) from error
    with quiet():
        try:
            return mujoco.MjModel.from_xml_path(str(path))
        except (ValueError, OSError) as error:
            notes.append(f"meshes are left out: {message_of(error)}")
            try:
                return _without_meshes(path)
            except (ValueError, OSError):
                what = f"MuJoCo refuses it: {message_of(error)}; accepted: {accepted}"
                raise RobotError(what) from error


def _without_meshes(path: Path) -> Any:
    """Return the model of a file without meshes, except those that determine an inertia of an MJCF.

    Raises:
        ValueError: MuJoCo refuses it.
    """
    import mujoco

    spec = mujoco.MjSpec.from_file(str(path))
    is_urdf = path.suffix.lower() == ".urdf"
    forced = spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
    for geom in spec.geoms:
        body = geom.parent
        shown = is_urdf or body == spec.worldbody or (body.explicitinertial and not forced)
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

"""Read MJCF, the format of MuJoCo, and write link parameters into it.

MuJoCo's compiler reads the file, so defaults, classes, included files, degrees and inertias from
geometry have their usual meaning. Install it with `pip install 'symgen[mjcf]'`.
https://mujoco.readthedocs.io/en/stable/XMLreference.html

A link frame has its origin at the anchor of the body's last joint, and the axes of the body frame.
A body with several joints gets a link without mass for each joint but the last.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import sympy as sp

from symgen import names
from symgen.errors import ParameterError, RobotError, located, plain, told_by
from symgen.robot import expressions
from symgen.robot.body import Body, FloatArray
from symgen.robot.dh import turned_by
from symgen.robot.expressions import shortened
from symgen.robot.formats.chain import ORIGIN, Chain, Inertial, Triple, Urdf, UrdfJoint
from symgen.robot.formats.urdf import CAVEAT, replaced_inertials, written_bodies
from symgen.robot.formats.xml import Element, parse_xml
from symgen.robot.imported import Imported, read_text

_ACCEPTED = "an MJCF of an arm on a fixed base"
_DIGITS = 14
_SIGMA = {"slide": names.PRISMATIC, "hinge": names.REVOLUTE}
_FULL = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))  # fullinertia


def import_mjcf(text: str, where: str = "robot.xml") -> Imported:
    """Read an MJCF as a robot, with the inertias of its bodies as standard parameters.

    armature becomes IA, damping becomes FV, and frictionloss becomes FS.

    Args:
        text: the file's text.
        where: path of the file; MuJoCo reads it and the files that it includes.

    Raises:
        RobotError: MuJoCo is not installed or refuses the file, or symgen cannot represent the
            robot.
    """
    with located(where):
        tree = _Tree(Path(where), text)
        chain = Chain(tree.urdf)
        found = chain.imported()
        gravity = tuple(map(_exact, tree.model.opt.gravity))
        if not any(gravity):
            raise RobotError("gravity is zero; accepted: the gravity that the robot works in")
    rotors = {f"{names.ROTOR}{chain.number[name]}": value for name, value in tree.armature.items()}
    return replace(
        found,
        robot=replace(found.robot, gravity=gravity),
        parameters=tuple((name, rotors.get(name, value)) for name, value in found.parameters),
        notes=(*found.notes, *tree.notes),
    )


def updated_mjcf(path: Path, bodies: Iterable[Body]) -> str:
    """Return the text of an MJCF with link parameters in its <inertial> elements.

    Args:
        path: path of the MJCF. All other bytes of it stay the same.
        bodies: links of the imported robot in the frames of their joints.

    Raises:
        RobotError: the file cannot be read.
        ParameterError: a body has no name, has several joints, or is in an included file.
    """
    text, _ = read_text(path, _ACCEPTED)
    edits: list[tuple[Element, list[str]]] = []
    with located(path):
        tree = _Tree(path, text)
        places = {e.attributes.get("name"): e for e in tree.root.walk("body")}
        found = written_bodies(Chain(tree.urdf), bodies)
    for link, body in found.items():
        if link not in places:
            raise ParameterError(
                f"{path}: there is no body of the name {plain(link)!r} in the file itself; "
                "accepted: an MJCF whose bodies have names, one joint at most, and are not included"
            )
        com = np.asarray(body.com) + tree.shift[link]
        values = " ".join(repr(float(body.inertia[pair])) for pair in _FULL)
        centre = " ".join(repr(float(v)) for v in com)
        line = f'<inertial pos="{centre}" mass="{body.mass!r}" fullinertia="{values}"/>'
        edits.append((places[link], [CAVEAT, line]))
    return replaced_inertials(text, edits)


class _Tree:
    """A compiled MJCF as links and joints.

    Attributes:
        model: model of MuJoCo.
        root: root element of the text.
        urdf: the tree.
        shift: origin of each link frame in its body frame, (3,) m.
        armature: IA of the joints.
        notes: what symgen ignores.
    """

    def __init__(self, path: Path, text: str) -> None:
        self.model = _compiled(path)
        self.shift: dict[str, FloatArray] = {}
        self.armature: dict[str, float] = {}
        self.notes: list[str] = []
        self._links: dict[str, Inertial | None] = {}
        self._joints: dict[str, UrdfJoint] = {}
        m = self.model
        self._body_names = [m.body(b).name or f"body{b}" for b in range(m.nbody)]
        for b in range(m.nbody):
            self._add(b)
        if m.neq:
            self.notes.append(f"{m.neq} equality constraints of the file are not read")
        self.root = parse_xml(text)
        title = self.root.attributes.get("model", "") or path.stem
        self.urdf = Urdf(title, self._body_names[0], self._links, self._joints)

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
            joint = UrdfJoint(f"{name}_fixed", names.FIXED, parent, name, _triple(xyz), rpy)
            self._joints[joint.name] = joint
        self.shift[name] = previous
        self._links[name] = self._inertial(b, previous)

    def _joint(self, k: int, parent: str, child: str, xyz: FloatArray, rpy: Triple) -> UrdfJoint:
        m = self.model
        name = m.joint(k).name or f"joint{k + 1}"
        kind = ("free", "ball", "slide", "hinge")[int(m.jnt_type[k])]
        zero = float(m.qpos0[m.jnt_qposadr[k]])
        with located(f"joint {shortened(name)!r}"):
            if kind not in _SIGMA:
                raise RobotError(f"it is {kind}; accepted: hinge, slide")
            if zero != 0:
                raise RobotError(f"its ref is {zero:g}; accepted: 0")
            if not abs(np.linalg.norm(m.jnt_axis[k]) - 1) < 1e-6:  # numbers beyond 1e154 overflow
                raise RobotError(
                    "its axis has no direction; accepted: three finite numbers, not all 0"
                )
        limit = {}
        if m.jnt_limited[k]:
            limit["lower"], limit["upper"] = map(float, m.jnt_range[k])
        if m.jnt_actfrclimited[k]:
            limit["effort"] = float(m.jnt_actfrcrange[k][1])
        dof = int(m.jnt_dofadr[k])
        self.armature[name] = float(m.dof_armature[dof])
        damping, friction = float(m.dof_damping[dof].flat[0]), float(m.dof_frictionloss[dof])
        return UrdfJoint(
            name, _SIGMA[kind], parent, child, _triple(xyz), rpy, _triple(m.jnt_axis[k]), limit,
            damping, friction,
        )  # fmt: skip

    def _inertial(self, b: int, shift: FloatArray) -> Inertial | None:
        """Return the inertia of a body in its link frame; None if it has no mass."""
        m = self.model
        if m.body_mass[b] == 0:
            return None
        R = _matrix(m.body_iquat[b])
        tensor = R @ np.diag(m.body_inertia[b]) @ R.T
        values = tuple(_exact(tensor[i, k]) for i in range(3) for k in range(i, 3))
        centre = np.array(m.body_ipos[b]) - shift
        return Inertial(_triple(centre), ORIGIN, _exact(m.body_mass[b]), values)


def _compiled(path: Path) -> Any:
    """Return the MuJoCo model of a file.

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
        raise RobotError(f"MuJoCo refuses it: {told_by(error)}; accepted: {_ACCEPTED}") from error
    finally:
        mujoco.set_mju_user_warning(None)


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

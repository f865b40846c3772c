"""Move the robot of a URDF or MJCF in MuJoCo by prescribed torques, or by its actuators."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from symgen.data.raw import FloatArray
from symgen.errors import RobotError, first_of, located
from symgen.names import ROTOR
from symgen.robot.formats.mjcf import SLIDE, compiled
from symgen.robot.formats.mjcf_torques import difference, disabling, quiet
from symgen.robot.toml_io import read_imported
from symgen.runtime.simulate import Law

_HOLDING = 1e9  # kg m2 or kg: armature of a locked joint
_FINEST = 1e-3  # s: longest step
_SAME = 1e-3  # relative difference of torques; rounded angles cause less
_RIGHT = 4  # the first MuJoCo that was seen to read all inertias of a URDF
_ACCEPTED = (
    "MuJoCo 4.0 or later, which reads <origin rpy> of <inertial> and fixed links right: "
    "pip install 'mujoco>=4.0'"
)


class MujocoRobot:
    """A robot from a file, in MuJoCo.

    Contacts and joint limits are switched off, and actuators until `follow`. Joints without a name
    in `joints` stand still at 0.

    Args:
        path: path of the file.
        joints: names of the moving joints, in the order of q.

    Attributes:
        notes: differences from the file, one line each.

    Raises:
        RobotError: MuJoCo is not installed, refuses the file or reads other inertias, or there is
            no such joint.
    """

    def __init__(self, path: Path, joints: Sequence[str]) -> None:
        with located(path):
            m = self.model = compiled(path, [], "URDF or MJCF")
            known = {m.joint(k).name: k for k in range(m.njnt)}
            missing = [name for name in joints if name not in known]
            if missing:
                raise RobotError(
                    f"there is no joint {first_of(missing, 3)}; accepted: a file with the joints "
                    f"{first_of(list(joints))}"
                )
            places = [known[name] for name in joints]
            if (m.jnt_type[places] < SLIDE).any():
                raise RobotError("a joint of the log is neither hinge nor slide; accepted: these")
            is_urdf = path.suffix.lower() == ".urdf"
            self.notes = _other_inertias(m, path) if is_urdf else []
        self._q, self._v = m.jnt_qposadr[places], m.jnt_dofadr[places]
        self._moved = "qfrc_applied", self._v
        self._path, self._joints = path, places
        locked = np.setdiff1d(np.arange(m.nv), self._v)
        m.dof_armature[locked] = _HOLDING
        for part in ("CONTACT", "LIMIT", "ACTUATION"):
            m.opt.disableflags |= disabling(part)
        m.opt.timestep = min(float(m.opt.timestep), _FINEST)

    def follow(self) -> None:
        """Let laws return references of the actuators in the file, in place of torques.

        Raises:
            RobotError: not one actuator of each joint follows a reference of its position.
        """
        m = self.model
        gear, gain = m.actuator_gear[:, 0], m.actuator_gainprm[:, 0]
        back = m.actuator_biasprm[:, 1]
        other = m.actuator_trntype + m.actuator_dyntype  # than on a joint, and at once
        follows = (other == 0) & (gain == -back) & (gear == 1)
        moved = np.where(follows, m.actuator_trnid[:, 0], -1)
        servos = [np.flatnonzero(moved == joint) for joint in self._joints]
        if any(len(k) != 1 for k in servos):
            raise RobotError(
                f"{self._path.name}: no reference moves its joints, and logs of duty have no "
                "torques; accepted: one <position> of each joint: symgen export --actuator position"
            )
        self._moved = "ctrl", np.concatenate(servos)
        m.opt.disableflags &= ~disabling("ACTUATION")

    @quiet()
    def __call__(
        self, q: FloatArray, qd: FloatArray, law: Law, t: FloatArray, bounds: FloatArray
    ) -> FloatArray:
        """Return the positions (K, n) at times t; see `symgen.estimation.playback.Mover`.

        A torque is constant over a step.
        """
        import mujoco

        m = self.model
        d = mujoco.MjData(m)
        d.qpos[self._q], d.qvel[self._v] = q, qd
        key, places = self._moved
        moved = getattr(d, key)
        out = np.full((len(t), len(self._q)), np.nan)
        steps = np.round((t - t[0]) / m.opt.timestep).astype(int)
        step, row = 0, 0
        while row < len(t):
            if step == steps[row]:
                out[row] = d.qpos[self._q]
                row += 1
                continue
            at = float(t[0] + (step + 0.5) * m.opt.timestep)
            moved[places] = law(at, d.qpos[self._q], d.qvel[self._v])
            mujoco.mj_step(m, d)
            step += 1
            if not np.isfinite(d.qpos).all() or d.time < 0.5 * step * m.opt.timestep:
                break  # MuJoCo resets the state if it is not finite
            if (np.abs(d.qpos[self._q] - q) > bounds).any():
                break
        return out


def _other_inertias(model: Any, path: Path) -> list[str]:
    """Return a note if MuJoCo has other inertias than a URDF.

    Raises:
        RobotError: they differ, and this MuJoCo is older than the one that reads them right.
    """
    import mujoco

    found, version = read_imported(path), mujoco.__version__
    bodies = tuple(p for p in found.parameters if not p[0].startswith((ROTOR, "FV")))
    bare = copy.copy(model)
    bare.dof_damping[:] = 0
    error = difference(replace(found, parameters=bodies), bare).max() if bodies else 0
    if error <= _SAME:
        return []
    what = f"MuJoCo {version} has other inertias than {path.name}: torques differ by {error:.1%}"
    if int(version.split(".")[0]) < _RIGHT:
        raise RobotError(f"{what}; accepted: {_ACCEPTED}")
    return [f"{what}. Links without <inertial> have the mass of their geometry in MuJoCo"]

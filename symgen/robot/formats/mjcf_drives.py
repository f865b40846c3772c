"""Write the drives of joints into an MJCF, as actuators of MuJoCo."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import quoteattr

from symgen.errors import ParameterError, plain
from symgen.robot.formats.mjcf import compiled
from symgen.robot.formats.mjcf_torques import disabling
from symgen.robot.formats.xml import Edit, Element

#: Attributes of an actuator that stay; and those that stay where it followed a reference before.
_KEPT, _KEPT_OF_SERVO = ("name", "group", "user"), ("class", "ctrlrange", "inheritrange")
_COMMENTS = {"dcmotor": "<!-- motorconst holds the viscous friction of the joint, too -->"}
#: A small control and speed, at which no servo is at its limit; largest relative difference.
_SMALL, _SAME = 1e-3, 1e-9


@dataclass(frozen=True)
class JointDrive:
    """The drive of a joint, as an actuator of MuJoCo.

        tau = gain (ctrl - q) - damping qd  for "position",  tau = gain ctrl - damping qd  otherwise

    Attributes:
        kind: tag of the actuator: "position", "motor" or "dcmotor".
        gain: N m (N) per unit of the control.
        damping: N m s/rad (N s/m) of the actuator.
        attributes: attributes of the actuator.
        reach: largest control; of a "position" a small one.
    """

    kind: str
    gain: float
    damping: float
    attributes: Mapping[str, str]
    reach: float = _SMALL


def drive_edits(root: Element, drives: Mapping[str, JointDrive]) -> Iterator[Edit]:
    """Yield the edits of an MJCF that give joints their drives, in place of their actuators.

    Args:
        root: root of the file.
        drives: drives by names of joints.
    """
    written = [element for section in root.all("actuator") for element in section.children]
    keys = "joint", "jointinparent"
    places = {e.attributes[key]: e for e in written for key in keys if key in e.attributes}
    added = []
    for joint, drive in drives.items():
        at = places.get(joint)
        words = {"joint": joint, **drive.attributes}
        followed = at is not None and at.tag == drive.kind == "position"
        if drive.kind == "position" and not followed:
            words["ctrllimited"] = "false"
        if at is not None:
            kept = _KEPT + _KEPT_OF_SERVO * followed
            old = at.attributes
            words = {key: old[key] for key in kept if key in old} | words
        pairs = words.items()
        line = "".join(f" {key}={quoteattr(value)}" for key, value in pairs)
        line = f"{_COMMENTS.get(drive.kind, '')}<{drive.kind}{line}/>"
        if at is None:
            added.append(f"    {line}\n")
        else:
            yield at.start, at.end, line.encode()
    if added:  # MuJoCo joins several sections
        lines = "".join(added)
        yield root.close, root.close, f"  <actuator>\n{lines}  </actuator>\n".encode()


def require_drives(path: Path, drives: Mapping[str, JointDrive]) -> None:
    """Refuse an MJCF in which MuJoCo computes other torques of the drives than symgen wrote.

    Args:
        path: path of the file.
        drives: drives by names of joints.

    Raises:
        ParameterError: other actuators move a joint, too, or a default of the file changes one.
    """
    import mujoco

    model = compiled(path, [])
    if any(drive.kind == "position" for drive in drives.values()):
        model.opt.disableflags |= disabling("CLAMPCTRL")
    data = mujoco.MjData(model)
    data.qvel[:] = _SMALL
    largest = [drive.reach for drive in drives.values()]
    data.ctrl[:] = max(largest, default=0.0)
    for name in drives:
        data.joint(name).qpos = 0.0
    mujoco.mj_forward(model, data)
    for name, drive in drives.items():
        theirs = data.joint(name).qfrc_actuator.item()
        ours = drive.gain * drive.reach - drive.damping * _SMALL
        if abs(theirs - ours) > _SAME * drive.gain:
            raise ParameterError(
                f"{path.name}: MuJoCo computes another torque of the actuators of {plain(name)!r} "
                "than written; accepted: one actuator at most of the joint, in the file itself, "
                "that no <default> or <option> of the file changes"
            )

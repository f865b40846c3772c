"""Write the drives of joints into an MJCF, as actuators of MuJoCo."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import quoteattr

from symgen.errors import ParameterError, plain
from symgen.robot.formats.mjcf import compiled
from symgen.robot.formats.xml import Edit, Element

#: Attributes of an actuator that stay, and those that no default of the file may change.
_KEPT = ("name", "group", "user")
_OWN = {"gear": "1", "ctrllimited": "false"}
_COMMENTS = {"dcmotor": "<!-- motorconst holds the viscous friction of the joint, too -->"}
#: Control and speed at which no force is at its limit; largest relative difference of torques.
_SMALL, _SAME = 1e-5, 1e-9


@dataclass(frozen=True)
class JointDrive:
    """The drive of a joint, as an actuator of MuJoCo.

        tau = gain (ctrl - q) - damping qd  for "position",  tau = gain ctrl - damping qd  otherwise

    Attributes:
        kind: tag of the actuator: "position", "motor" or "dcmotor".
        gain: N m (N) per unit of the control.
        damping: N m s/rad (N s/m) of the actuator.
        attributes: numbers of the actuator.
        clipped: what a limit clips, "ctrl" or "force".
        limit: this limit.
    """

    kind: str
    gain: float
    damping: float
    attributes: Mapping[str, float]
    clipped: str
    limit: float

    @property
    def reach(self) -> float:
        """Largest control below which no force is at its limit."""
        return self.limit if self.clipped == "ctrl" else _SMALL

    def element(self, kept: Mapping[str, str]) -> str:
        """Return the element of the actuator, with some attributes that it keeps."""
        numbers = {key: repr(value) for key, value in self.attributes.items()}
        reach = f"{-self.limit!r} {self.limit!r}"
        limits = {f"{self.clipped}limited": "true", f"{self.clipped}range": reach}
        pairs = {**kept, **_OWN, **numbers, **limits}.items()
        line = "".join(f" {key}={quoteattr(value)}" for key, value in pairs)
        return f"{_COMMENTS.get(self.kind, '')}<{self.kind}{line}/>"


def drive_edits(root: Element, drives: Mapping[str, JointDrive]) -> Iterator[Edit]:
    """Yield the edits of an MJCF that give joints their drives, in place of their actuators.

    Args:
        root: root of the file.
        drives: drives by names of joints.
    """
    written = [element for section in root.all("actuator") for element in section.children]
    places = {element.attributes.get("joint"): element for element in written}
    added = ""
    for joint, drive in drives.items():
        at = places.get(joint)
        if at is None:
            added += f"    {drive.element({'joint': joint})}\n"
        else:
            kept = {key: at.attributes[key] for key in _KEPT if key in at.attributes}
            yield at.start, at.end, drive.element({**kept, "joint": joint}).encode()
    if added:  # MuJoCo joins several sections
        yield root.close, root.close, f"  <actuator>\n{added}  </actuator>\n".encode()


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
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = 0.0, -_SMALL
    data.ctrl[:] = max((drive.reach for drive in drives.values()), default=0.0)
    mujoco.mj_forward(model, data)
    for name, drive in drives.items():
        theirs = data.joint(name).qfrc_actuator.item()
        ours = drive.gain * drive.reach + drive.damping * _SMALL
        if abs(theirs - ours) > _SAME * ours:
            raise ParameterError(
                f"{path.name}: MuJoCo computes another torque of the actuators of {plain(name)!r} "
                "than written; accepted: one actuator at most of the joint, in the file itself, "
                "that no <default> or <option> of the file changes"
            )

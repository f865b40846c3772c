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
_FIXED = {
    "position": {"gear": "1", "ctrllimited": "false", "forcelimited": "true"},
    "motor": {"ctrllimited": "true"},
    "dcmotor": {"gear": "1", "ctrllimited": "true"},
}
#: A control above all limits; largest relative difference of torques.
_LARGE, _SAME = 1e6, 1e-9


@dataclass(frozen=True)
class JointDrive:
    """The drive of a joint, as an actuator of MuJoCo.

    Attributes:
        kind: tag of the actuator: "position", "motor" or "dcmotor".
        numbers: attributes of the actuator; of a range the upper limit, its lower limit is minus
            that.
        torque: largest torque without speed, N m (N).
        viscous: viscous friction of the joint that the actuator holds, N m s/rad (N s/m).
        comment: comment in the file, or "".
    """

    kind: str
    numbers: Mapping[str, float]
    torque: float
    viscous: float = 0.0
    comment: str = ""

    def element(self, kept: Mapping[str, str]) -> str:
        """Return the element of the actuator, with some attributes that it keeps."""
        pairs = {**kept, **_FIXED[self.kind]}
        for key, x in self.numbers.items():
            pairs[key] = f"{-x!r} {x!r}" if key.endswith("range") else repr(x)
        words = [f"{key}={quoteattr(value)}" for key, value in pairs.items()]
        line = " ".join([self.kind, *words])
        return f"{self.comment}<{line}/>"


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
    """Refuse an MJCF in which MuJoCo computes other largest torques than those of the drives.

    Args:
        path: path of the file.
        drives: drives by names of joints.

    Raises:
        ParameterError: other actuators move a joint, too, or a default of the file changes one.
    """
    import mujoco

    model = compiled(path, [])
    data = mujoco.MjData(model)
    data.qpos[:], data.ctrl[:] = 0.0, _LARGE
    mujoco.mj_forward(model, data)
    for name, drive in drives.items():
        theirs = data.joint(name).qfrc_actuator.item()
        if abs(theirs - drive.torque) > _SAME * drive.torque:
            raise ParameterError(
                f"{path.name}: MuJoCo computes another torque of the actuators of {plain(name)!r} "
                "than written; accepted: one actuator at most of the joint, in the file itself, "
                "that no <default> or <option> of the file changes"
            )

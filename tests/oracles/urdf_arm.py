"""URDFs for tests: the ones that example-robot-data ships, cut to arms and legs, in Pinocchio.

Nothing here is shared with the package under test: the texts go through ElementTree, the torques
through Pinocchio's own reader of URDF.
"""

import copy
import importlib.metadata
import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from oracles.pinocchio_arm import load_pinocchio

MOVING = ("revolute", "continuous", "prismatic")


def shipped() -> tuple[Path, ...]:
    """Return the URDFs of the package example-robot-data, or none where it is not installed."""
    try:
        files = importlib.metadata.files("example-robot-data") or []
    except importlib.metadata.PackageNotFoundError:
        return ()
    paths = sorted(Path(str(f.locate())) for f in files if f.name.endswith(".urdf"))
    return tuple(p.resolve() for p in paths if p.is_file())


def limbs(text: str, most: int = 12) -> Iterator[tuple[str, str]]:
    """Cut a robot into trees with a fixed base and at most so many moving joints.

    The whole robot where it is small enough; else the branches of the link where it first
    branches into moving subtrees, each with that link as its base, and so on along each branch.

    Yields:
        The name of the base link and the joint that starts the limb (or "", ""), and the text.
    """
    robot = ET.fromstring(text.encode())
    joints = [j for j in robot.findall("joint") if j.find("child") is not None]
    below: dict[str, list[ET.Element]] = {}
    for joint in joints:
        below.setdefault(joint.find("parent").get("link"), []).append(joint)
    children = {j.find("child").get("link") for j in joints}
    links = [link.get("name") for link in robot.findall("link")]
    root = next((name for name in links if name not in children), "")

    def tree(joint: ET.Element) -> list[ET.Element]:
        out = [joint]
        for after in below.get(joint.find("child").get("link"), []):
            out += tree(after)
        return out

    def count(tree: list[ET.Element]) -> int:
        return sum(j.get("type") in MOVING for j in tree)

    def cut(base: str, kept: list[ET.Element]) -> str:
        names = {base} | {j.find("child").get("link") for j in kept}
        out = ET.Element("robot", {"name": robot.get("name", "robot")})
        for element in robot:
            inside = element.tag == "link" and element.get("name") in names
            if inside or any(element is j for j in kept):
                out.append(copy.deepcopy(element))
        joints = {j.get("name") for j in out.findall("joint")}
        for joint in out.findall("joint"):
            mimic = joint.find("mimic")
            if mimic is not None and mimic.get("joint") not in joints:
                joint.remove(mimic)  # its master is in another limb
        return ET.tostring(out, encoding="unicode")

    whole = [j for j in below.get(root, []) for j in tree(j)]
    if count(whole) <= most:
        if count(whole):
            yield "", text
        return

    def branches(base: str) -> Iterator[tuple[str, str]]:
        for joint in below.get(base, []):
            limb = tree(joint)
            if 0 < count(limb) <= most:
                yield joint.get("name"), cut(base, limb)
            elif count(limb):
                yield from branches(joint.find("child").get("link"))

    yield from branches(root)


def with_all_digits(text: str) -> str:
    """Return the URDF with the digits of k pi/24 that rounded angles lack, and without dust."""

    def word(written: str) -> str:
        try:
            value = float(written)
        except ValueError:  # a macro in a comment
            return written
        k = round(value * 24 / math.pi)
        gap = abs(value - k * math.pi / 24)
        if gap < 1e-4:
            return repr(k * math.pi / 24)
        return written

    def angles(match: re.Match[str]) -> str:
        return f'rpy="{" ".join(map(word, match.group(1).split()))}"'

    def axis(match: re.Match[str]) -> str:
        v = np.array([float(w) for w in match.group(1).split()])
        unit = v / (np.linalg.norm(v) or 1.0)
        return f'axis xyz="{" ".join(repr(float(x)) for x in np.where(abs(unit) < 1e-4, 0, v))}"'

    text = re.sub(r'rpy\s*=\s*"([^"]*)"', angles, text)
    return re.sub(r'axis\s+xyz\s*=\s*"([^"]*)"', axis, text)


class PinocchioUrdf:
    """Torques and placements of a URDF in Pinocchio; joints by name, each with one number q."""

    def __init__(self, text: str) -> None:
        self.pin = load_pinocchio()
        self.model = self.pin.buildModelFromXML(text)
        self.model.armature[:] = 0
        self.model.friction[:] = 0
        self.data = self.model.createData()
        self.joints = tuple(self.model.names)[1:]

    def state(self, q: dict[str, float]) -> np.ndarray:
        out = np.zeros(self.model.nq)
        for i, name in enumerate(self.joints, 1):
            joint = self.model.joints[i]
            values = [math.cos(q[name]), math.sin(q[name])] if joint.nq == 2 else [q[name]]
            out[joint.idx_q : joint.idx_q + joint.nq] = values
        return out

    def vector(self, values: dict[str, float]) -> np.ndarray:
        out = np.zeros(self.model.nv)
        for i, name in enumerate(self.joints, 1):
            out[self.model.joints[i].idx_v] = values[name]
        return out

    def torques(self, q: dict[str, float], qd: dict[str, float], qdd: dict[str, float]):
        tau = self.pin.rnea(self.model, self.data, self.state(q), self.vector(qd), self.vector(qdd))
        return {n: tau[self.model.joints[i].idx_v] for i, n in enumerate(self.joints, 1)}

    def places(self, q: dict[str, float]) -> dict[str, np.ndarray]:
        """Placements (4, 4) of the frames of all joints, fixed ones included, by name."""
        self.pin.framesForwardKinematics(self.model, self.data, self.state(q))
        kinds = (self.pin.FrameType.JOINT, self.pin.FrameType.FIXED_JOINT)
        return {
            frame.name: self.data.oMf[i].homogeneous
            for i, frame in enumerate(self.model.frames)
            if frame.type in kinds
        }

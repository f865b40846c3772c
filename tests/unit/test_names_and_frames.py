"""Names and frames of an imported robot: in its robot file, in C, and in the manifest."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
from support_urdf import Ours

import symgen
from symgen.codegen.model import derive
from symgen.codegen.package import generate
from symgen.errors import RobotError
from symgen.robot.dh import frames
from symgen.robot.imported import Imported, with_name
from symgen.robot.toml_io import parse_imported, parse_robot
from symgen.robot.toml_text import robot_toml

EVIL = (
    "*/ #define main evil", "*/", "/*", "<script>alert(1)</script>", "a\"b'c", "\\", "??/", "été",
    "shoulder pan", "shoulder-pan", "shoulder_pan_2", "関節", "]]> --", "x" * 200, "{{ 7 * 7 }}",
)  # fmt: skip
BODY = '<inertial><origin xyz="0.1 0 0.02"/><mass value="2"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.3"/></inertial>'  # noqa: E501
POSES = {  # xyz, rpy and axis of each joint of the arm, and of the flange and the tool
    "pan": ((0.0, 0.0, 0.3), (0.0, 0.0, 0.4), (0, 0, 1)),
    "lift": ((0.2, 0.1, 0.0), (0.3, -0.2, 0.0), (0, 1, 0)),
    "flange": ((0.0, 0.3, 0.0), (0.0, 0.5, 0.1), None),
    "tool0": ((0.05, 0.0, 0.1), (1.2, 0.0, -0.7), None),
}


def escaped(name: str) -> str:
    for character, entity in (("&", "&amp;"), ("<", "&lt;"), ('"', "&quot;")):
        name = name.replace(character, entity)
    return name


def urdf(joints: dict[str, str] | None = None, links: dict[str, str] | None = None) -> Imported:
    """Return an arm of two joints with a flange and a tool, with other names."""
    out, parent = ['<robot name="arm"><link name="base"/>'], "base"
    for key, (xyz, rpy, axis) in POSES.items():
        joint, link = (escaped((names or {}).get(key, key)) for names in (joints, links))
        kind = "fixed" if axis is None else "continuous"
        at = '" rpy="'.join(" ".join(map(str, x)) for x in (xyz, rpy))
        turn = "" if axis is None else f'<axis xyz="{" ".join(map(str, axis))}"/>'
        out.append(
            f'<link name="{link}">{BODY}</link><joint name="{joint}" type="{kind}"><origin '
            f'xyz="{at}"/><parent link="{parent}"/><child link="{link}"/>{turn}</joint>'
        )
        parent = link
    return parse_imported("".join([*out, "</robot>"]), Path("arm.urdf"))


def turned(axis: int, angle: float) -> np.ndarray:
    T, (i, k) = np.eye(4), [i for i in range(3) if i != axis]
    sign = -1 if axis == 1 else 1
    T[i, i] = T[k, k] = np.cos(angle)
    T[k, i], T[i, k] = sign * np.sin(angle), -sign * np.sin(angle)
    return T


def places(q: np.ndarray) -> dict[str, np.ndarray]:
    """Return where the links of the URDF are, by its own definition."""
    T, out, values = np.eye(4), {}, iter(q)
    for key, (xyz, rpy, axis) in POSES.items():
        shift = np.eye(4)
        shift[:3, 3] = xyz
        T = T @ shift @ turned(2, rpy[2]) @ turned(1, rpy[1]) @ turned(0, rpy[0])
        if axis is not None:
            T = T @ turned(axis.index(1), next(values))
        out[key] = T
    return out


def test_frames_are_those_of_the_links() -> None:
    ours = Ours(urdf())
    assert [(f.name, f.joint) for f in ours.robot.frames] == [
        ("pan", 1), ("lift", 2), ("flange", 2), ("tool0", 2),
    ]  # fmt: skip
    q = ours.states(5)["q"]
    for angles, found in zip(q, ours.frames(q), strict=True):
        for name, want in places(angles).items():
            frame = ours.robot.frame(name)
            np.testing.assert_allclose(found[frame.joint - 1] @ frame.transform, want, atol=1e-14)


def test_a_joint_that_slides_moves_its_frame_along_its_axis() -> None:
    robot = parse_robot('[robot]\nname = "r"\n[[joint]]\nsigma = 1\nalpha = 0.5\nr = 0.2\n')
    before, after = (frames(robot, {1: q})[1] for q in (0.0, 0.3))
    np.testing.assert_allclose(after[:3, 3] - before[:3, 3], 0.3 * before[:3, 2], atol=1e-15)


def test_frames_and_names_stay_in_the_robot_file() -> None:
    names = dict(zip(POSES, EVIL, strict=False))
    for robot in (urdf().robot, urdf(names, names).robot):
        assert parse_robot(robot_toml(robot)) == robot


@pytest.mark.parametrize(
    ("frame", "says"),
    [
        ('name = "a"\njoint = 3', "there is no joint 3; accepted: 0 to 2"),
        ('name = ""\njoint = 1', "frame 1, key 'name'"),
        ('name = "a"\njoint = 1\n[[frame]]\nname = "a"\njoint = 1', "the name stands twice"),
        ('name = "a"\njoint = 1\nrpy = [1, 2]', "key 'rpy'"),
    ],
)
def test_a_frame_that_is_none_is_refused(frame, says) -> None:
    text = f'[robot]\nname = "r"\n[[joint]]\n[[joint]]\nd = 1\n[[frame]]\n{frame}\n'
    with pytest.raises(RobotError, match=re.escape(says)):
        parse_robot(text)


def package(robot: symgen.Robot) -> dict[str, bytes]:
    return dict(generate(derive(robot, ("gravity_torque",)), target="c").files)


def compiled(files: dict[str, bytes], folder: Path, program: str) -> str:
    """Compile a program with the headers of a package, with warnings as errors, and run it."""
    for path, content in files.items():
        if "/" not in path:
            (folder / path).write_bytes(content)
    (folder / "main.c").write_text(program)
    strict = ["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", "-Wno-unused-const-variable"]
    subprocess.run(["gcc", *strict, "main.c", "-o", "main"], cwd=folder, check=True)
    return subprocess.run([folder / "main"], capture_output=True, text=True, check=True).stdout


def test_no_name_ends_a_comment_or_adds_code(tmp_path) -> None:
    for k in range(0, len(EVIL) - 3, 3):
        names = dict(zip(POSES, EVIL[k : k + 4], strict=True))
        robot = urdf(names, names).robot
        files = package(robot)
        # The same tokens as with plain names, but for the endings of the macros.
        plain = package(urdf().robot)
        for path in ("arm.h", "arm_links.h"):
            texts = (f[path].decode("ascii") for f in (files, plain))
            found, want = (re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL) for text in texts)
            ending = r"arm_(JOINT|FRAME|LINK)_\w+|0x[0-9a-f]+ULL"
            assert re.sub(ending, "", found) == re.sub(ending, "", want)
        program = '#include "arm_links.h"\nint main(void) { return 0; }\n'
        assert compiled(files, tmp_path, program) == ""
        manifest = json.loads(files["manifest.json"])
        assert manifest["joint_names"] == [names["pan"], names["lift"]]
        assert [f["name"] for f in manifest["frames"]] == [names[key] for key in POSES]


def test_c_has_places_of_joints_and_frames(tmp_path) -> None:
    robot = urdf({"pan": "shoulder pan", "lift": "shoulder-pan"}).robot
    files = package(robot)
    program = """#include <stdio.h>
#include "arm_links.h"
int main(void) {
    printf("%d %d %d", arm_JOINT_shoulder_pan, arm_JOINT_shoulder_pan_2, arm_LINK_tool0);
    for (int k = 0; k < 16; ++k) { printf(" %.17g", arm_FRAME_tool0[k]); }
    return 0;
}
"""
    numbers = [float(word) for word in compiled(files, tmp_path, program).split()]
    assert numbers[:3] == [0, 1, 2]
    assert numbers[3:] == list(np.ravel(robot.frame("tool0").transform))


def test_a_robot_without_names_has_none_in_c() -> None:
    robot = parse_robot('[robot]\nname = "arm"\n[[joint]]\n[[joint]]\nd = 1\n')
    files = package(robot)
    assert "arm_links.h" not in files
    assert b"arm_JOINT_" not in files["arm.h"]
    assert not {"joint_names", "frames"} & json.loads(files["manifest.json"]).keys()


def test_import_takes_another_name() -> None:
    found = urdf()
    assert with_name(found, "left_arm").robot.name == "left_arm"
    with pytest.raises(RobotError, match=r"--name left-arm: accepted: .* such as left_arm"):
        with_name(found, "left-arm")


def test_a_base_that_floats_is_fixed_and_said() -> None:
    text = (
        '<robot name="r"><link name="world"/><link name="base"/><link name="a"/>'
        '<joint name="root" type="floating"><parent link="world"/><child link="base"/></joint>'
        '<joint name="j" type="continuous"><parent link="base"/><child link="a"/></joint></robot>'
    )
    found = parse_imported(text, Path("r.urdf"))
    assert found.robot.n == 1
    assert any("'root' is free in the file: the base 'base' is fixed" in n for n in found.notes)

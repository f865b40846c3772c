"""Bad URDFs, and the import command: one line that names file, joint or link, and exit code 2."""

import subprocess
import sys

import pytest

import symgen
from symgen.robot.formats.urdf import import_urdf

GOOD = """<?xml version="1.0"?>
<robot name="good">
  <link name="base"/>
  <link name="arm"><inertial><origin xyz="0 0 0.1"/><mass value="2"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <link name="tip"/>
  <joint name="turn" type="revolute"><parent link="base"/><child link="arm"/>
    <origin xyz="0 0 0.3" rpy="0 0 1.5708"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="5" velocity="2"/></joint>
  <joint name="slide" type="prismatic"><parent link="arm"/><child link="tip"/>
    <origin xyz="0.1 0 0"/><axis xyz="0 0 1"/></joint>
</robot>
"""
PAR = """(* Robotname = 'two' *)
NJ = 2
NL = 2
Type = 0
ant = {0,1}
sigma = {0,0}
d = {0,L1}
theta = {th1,th2}
"""
END = "</joint>\n</robot>"
CHANGES = {
    "empty": (GOOD, "", ["not well-formed"]),
    "cut": ("</robot>", "", ["not well-formed"]),
    "doctype": ("<robot name", '<!DOCTYPE robot [<!ENTITY a "b">]><robot name', ["DOCTYPE"]),
    "other root": ("robot", "sdf", ["<sdf>", "<robot>"]),
    "macro": ("</robot>", "<xacro:arm/></robot>", ["xacro:arm", "macro"]),
    "planar": ('type="prismatic"', 'type="planar"', ["joint 'slide'", "planar", "fixed"]),
    "floating": ('type="prismatic"', 'type="floating"', ["joint 'slide'", "'floating'"]),
    "no type": (' type="prismatic"', "", ["joint 'slide'", "no type"]),
    "forest": ('<parent link="arm"/>', '<parent link="tip"/>', ["ring"]),
    "two roots": ('<link name="base"/>', '<link name="base"/><link name="x"/>', ["'base', 'x'"]),
    "no such link": ('<parent link="arm"/>', '<parent link="leg"/>', ["joint 'slide'", "'leg'"]),
    "no parent": ('<parent link="arm"/>', "", ["joint 'slide'", "<parent link=...>"]),
    "two parents": ('<child link="tip"/>', '<child link="arm"/>', ["'arm'", "'turn'"]),
    "link twice": ('<link name="tip"/>', '<link name="arm"/>', ["link 'arm'", "twice"]),
    "joint twice": ('"slide"', '"turn"', ["joint 'turn'", "twice"]),
    "no name": ('<link name="tip"/>', "<link/>", ["line 6", "no usable name"]),
    "line break": ('"slide"', '"sl&#10;ide"', ["no usable name"]),
    "not a number": ('"0 0 0.3"', '"0 0 x"', ["joint 'turn'", "xyz is '0 0 x'", "3 finite"]),
    "nan": ('"0 0 0.3"', '"0 0 nan"', ["joint 'turn'", "nan"]),
    "infinity": ('"0 0 0.3"', '"0 0 inf"', ["joint 'turn'", "inf"]),
    "huge": ('"0 0 0.3"', '"0 0 1e999"', ["joint 'turn'", "1e999"]),
    "two numbers": ('"0 0 0.3"', '"0 0.3"', ["joint 'turn'", "3 finite"]),
    "zero axis": ('<axis xyz="0 0 1"/>', '<axis xyz="0 0 0"/>', ["joint 'slide'", "axis is zero"]),
    "negative mass": ('value="2"', 'value="-2"', ["link 'arm'", "-2 kg"]),
    "no mass": ('<mass value="2"/>', "", ["link 'arm'", "<mass>"]),
    "no inertia": (' ixx="1"', "", ["link 'arm'", "ixx is missing"]),
    "bad limit": ('effort="5"', 'effort="much"', ["joint 'turn'", "effort is 'much'"]),
    "quaternion": ('rpy="0 0 1.5708"', 'quat_xyzw="0 0 0 1"', ["joint 'turn'", "quat_xyzw", "1.1"]),
    "two orientations": (
        'name="good">', 'name="good" version="1.1"><joint name="x" type="fixed">'
        '<parent link="base"/><child link="arm"/><origin rpy="0 0 0" quat_xyzw="0 0 0 1"/></joint>',
        ["'x'", "no rpy"],
    ),
    "no unit quaternion": (
        'name="good">', 'name="good" version="1.1"><joint name="x" type="fixed">'
        '<parent link="base"/><child link="arm"/><origin quat_xyzw="0 0 0 0"/></joint>',
        ["'x'", "of length 1"],
    ),
    "gear": (
        "</robot>",
        "<transmission><mechanicalReduction>much</mechanicalReduction></transmission></robot>",
        ["mechanicalReduction is 'much'", "a finite number"],
    ),
    "bad jerk": ('effort="5"', 'effort="5" jerk="much"', ["joint 'turn'", "jerk is 'much'"]),
    "nothing moves": ('type="prismatic"', 'type="fixed"', ["no joint is movable"]),
    "mimic of none": (END, f'<mimic joint="x"/>{END}', ["'slide'", "'x'"]),
    "mimic of itself": (END, f'<mimic joint="slide"/>{END}', ["'slide'", "mimics itself"]),
}  # fmt: skip


def _bad(old, new, name):
    text = GOOD.replace('type="revolute"', 'type="fixed"') if name == "nothing moves" else GOOD
    assert old in text
    return text.replace(old, new)


@pytest.mark.parametrize("name", CHANGES)
def test_a_bad_urdf_is_refused_in_one_line(name):
    old, new, words = CHANGES[name]
    with pytest.raises(symgen.RobotError) as caught:
        import_urdf(_bad(old, new, name), "bad.urdf")
    message = str(caught.value)
    assert message.startswith("bad.urdf: ")
    assert "\n" not in message
    for word in words:
        assert word in message


def test_a_revolute_joint_that_multiplies_rounding_too_much_is_refused():
    text = GOOD.replace('"prismatic"', '"continuous"')
    text = text.replace(END, f'<mimic joint="turn" multiplier="1e9"/>{END}')
    with pytest.raises(symgen.RobotError, match="joint 'slide': its multiplier is above 200"):
        import_urdf(text)


def test_a_revolute_joint_cannot_mimic_a_prismatic_one():
    text = GOOD.replace("</joint>", '<mimic joint="slide"/></joint>', 1)
    with pytest.raises(symgen.RobotError, match=r"joint 'turn'.*slides"):
        import_urdf(text)


@pytest.fixture
def good(tmp_path):
    path = tmp_path / "good.urdf"
    path.write_text(GOOD)
    return path


def test_import_writes_a_robot_and_its_parameters(run, good, tmp_path):
    into = tmp_path / "new" / "robot.toml"
    code, out, err = run("import", good, "--into", into)
    assert (code, err) == (0, [])
    assert "turn" in out
    assert "pi/2" in out
    assert "note: rounded angles" in out
    robot = symgen.read_robot(into)
    assert robot == symgen.read_robot(good)
    from symgen.identification.parameters import read_parameters

    model = symgen.derive(robot)
    values = into.with_name("good_parameters.toml")
    assert list(read_parameters(values, model)) == list(read_parameters(good, model))


LIMIT = '<limit lower="-1" upper="1" effort="5" velocity="2"/>'


@pytest.mark.parametrize(
    ("turn", "note"),
    [
        (LIMIT, ""),
        ('<limit lower="1" upper="-1" effort="5" velocity="2"/>', "position"),
        ("", "position velocity torque"),
    ],
)
def test_limits_that_a_joint_lacks_are_noted(turn, note):
    axis = '<axis xyz="0 0 1"/>'
    found = import_urdf(GOOD.replace(LIMIT, turn).replace(axis, axis + LIMIT))
    lost = [line for line in found.notes if "limits" in line]
    assert lost == [f"no {key} limits are read: turn has none" for key in note.split()]


def test_import_again_replaces_what_nobody_changed_and_nothing_else(run, good, tmp_path):
    into = tmp_path / "robot.toml"
    assert run("import", good, "--into", into)[0] == 0
    assert run("import", good, "--into", into)[0] == 0
    edited = into.read_text().replace("-9.81", "-9.8")
    into.write_text(edited)
    code, _, lines = run("import", good, "--into", into)
    assert (code, len(lines)) == (2, 1)
    assert "nobody changed" in lines[0]
    assert into.read_text() == edited


def test_lengths_in_mm_are_asked_for(run, tmp_path):
    path = tmp_path / "mm.urdf"
    path.write_text(GOOD.replace('"0 0 0.3"', '"0 0 300"').replace('"0.1 0 0"', '"100 0 0"'))
    code, out, err = run("import", path, "--into", tmp_path / "robot.toml")
    assert code == 0
    assert "parallel" not in out
    assert len(err) == 1
    for word in (str(path), "'turn'", "in mm?"):
        assert word in err[0]


@pytest.mark.parametrize("into", ["robot.urdf", "folder.toml", "file/robot.toml"])
def test_import_writes_only_where_a_file_can_be(run, good, tmp_path, into):
    (tmp_path / "folder.toml").mkdir()
    (tmp_path / "file").write_text("")
    before = sorted(p.name for p in tmp_path.iterdir())
    code, _, lines = run("import", good, "--into", tmp_path / into)
    assert (code, len(lines)) == (2, 1)
    assert sorted(p.name for p in tmp_path.iterdir()) == before


def test_import_of_a_par_warns_of_values_that_are_not_in_it(run, tmp_path):
    path = tmp_path / "two.par"
    path.write_text(PAR)
    code, out, lines = run("import", path, "--into", tmp_path / "robot.toml")
    assert code == 0
    assert len(lines) == 1
    assert "L1 = 0.29" in lines[0]
    assert not (tmp_path / "two_parameters.toml").exists()
    assert dict(symgen.read_robot(tmp_path / "robot.toml").geometry)
    with pytest.warns(symgen.SymgenWarning, match="not in the file|no value"):
        symgen.read_robot(path)
    assert "follows" in out


def test_the_billion_laughs_are_not_laughed(good):
    bomb = '<!DOCTYPE l [<!ENTITY a "ha">' + "".join(
        f'<!ENTITY {chr(98 + i)} "{f"&{chr(97 + i)};" * 10}">' for i in range(9)
    )
    good.write_text(f"{bomb}]><robot>&j;</robot>")
    done = subprocess.run(
        [sys.executable, "-m", "symgen", "import", good, "--into", good.with_suffix(".toml")],
        capture_output=True, text=True, check=False, timeout=60,
    )  # fmt: skip
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert "DOCTYPE" in done.stderr

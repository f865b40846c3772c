"""Boxes of links from the geometry of their file, against Coal (Pinocchio) and MuJoCo."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

import symgen

URDF = """<robot name="shapes">
  <link name="base"><visual><geometry><mesh filename="nowhere.stl"/></geometry></visual></link>
  <link name="upper">{inertial}
    <visual><origin rpy="0.3 -0.2 1"/><geometry><mesh filename="package://arms/meshes/rock.stl"
      scale="1 -2 0.5"/></geometry></visual>
    <visual><origin xyz="0.1 0 0.3" rpy="1 0.4 0"/><geometry><cylinder radius="0.05" length="0.3"/>
      </geometry></visual>
    <collision><geometry><mesh filename="package://arms/meshes/rock.dae"/></geometry></collision>
  </link>
  <link name="cover"><collision><origin xyz="0 0 0.1" rpy="0 0.7 0"/><geometry>
    <box size="0.4 0.1 0.02"/></geometry></collision></link>
  <link name="lower">{inertial}
    <collision><origin xyz="0.02 0 0" rpy="0 0 2"/><geometry><mesh filename="../meshes/words.STL"/>
      </geometry></collision>
    <visual><geometry><mesh filename="../meshes/rock.obj" scale="0.001 0.001 0.001"/></geometry>
      </visual></link>
  <link name="tool">{inertial}
    <visual><origin xyz="0 0.3 0" rpy="0 1 0"/><geometry><sphere radius="0.07"/></geometry></visual>
  </link>
  <link name="bare">{inertial}</link>
  <link name="unread">{inertial}{unread}</link>
  {joints}
</robot>
"""
INERTIAL = """<inertial><mass value="1"/>
  <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>"""
WHERE = [("base", "upper"), ("upper", "lower"), ("lower", "tool"), ("tool", "bare"),
         ("bare", "unread")]  # fmt: skip
JOINTS = "".join(
    f'<joint name="{b}" type="revolute"><parent link="{a}"/><child link="{b}"/>'
    f'<origin xyz="0 0.1 {0.1 * k}" rpy="{k} 0 0"/><axis xyz="0 1 0"/>'
    '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
    for k, (a, b) in enumerate(WHERE)
)  # fmt: skip
FIXED = ('<joint name="cover_joint" type="fixed"><parent link="upper"/><child link="cover"/>'
         '<origin xyz="0.2 0 0.3" rpy="0.2 0.5 0"/></joint>')  # fmt: skip


def write_meshes(folder: Path) -> None:
    """Write the same triangles, of a rock, as binary STL, as OBJ in mm, and as an STL of words."""
    folder.mkdir(parents=True)
    points = np.random.default_rng(0).normal(size=(20, 3, 3)).astype("<f4") / 10
    triangles = b"".join(struct.pack("<3f", 0, 0, 0) + p.tobytes() + b"\0\0" for p in points)
    (folder / "rock.stl").write_bytes(b"solid rock".ljust(80) + struct.pack("<I", 20) + triangles)
    lines = [f"v {x:.9g} {y:.9g} {z:.9g} 1 0 0" for x, y, z in 1000 * points.reshape(-1, 3)]
    lines += ["vn 9999 9999 9999", *(f"f {3 * k + 1} {3 * k + 2} {3 * k + 3}" for k in range(20))]
    (folder / "rock.obj").write_text("\n".join(lines))
    corner = "vertex {:.9g} {:.9g} {:.9g}\n".format
    facets = [f"facet normal 0 0 1\nouter loop\n{''.join(corner(*p) for p in three)}endloop\n"
              "endfacet\n" for three in points[:3]]  # fmt: skip
    (folder / "words.STL").write_text(f"solid words\n{''.join(facets)}endsolid words\n")


def urdf(tmp_path: Path, unread: str = "") -> Path:
    """Write the robot into package arms/, where its urdf/ and meshes/ are."""
    write_meshes(tmp_path / "arms" / "meshes")
    path = tmp_path / "arms" / "urdf" / "arm.urdf"
    path.parent.mkdir()
    path.write_text(URDF.format(inertial=INERTIAL, joints=JOINTS + FIXED, unread=unread))
    return path


def by_coal(path: Path) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Lowest and highest coordinates of the links by the meshes of Coal, and of round shapes by
    points on them; a cover is part of the upper link."""
    from oracles.pinocchio_arm import load_pinocchio

    pin = load_pinocchio()
    import coal

    text = path.read_text().replace("nowhere.stl", "../meshes/rock.stl")
    text = text.replace("rock.dae", "rock.stl")  # of a kind that has no part in it
    readable = path.with_name("readable.urdf")
    readable.write_text(text.replace("../meshes", "package://arms/meshes"))
    model, points = pin.buildModelFromXML(text), dict[str, list[np.ndarray]]()
    around = np.random.default_rng(1).normal(size=(200_000, 3))
    around /= np.linalg.norm(around, axis=1)[:, None]
    turn = np.linspace(0, 2 * np.pi, 100_000)
    for kind in (pin.GeometryType.COLLISION, pin.GeometryType.VISUAL):
        geometry = pin.buildGeomFromUrdf(model, str(readable), kind, None, str(path.parents[2]))
        for item in geometry.geometryObjects:
            frame, shape = model.frames[item.parentFrame], item.geometry
            if kind == pin.GeometryType.COLLISION and frame.name == "upper":
                continue
            if isinstance(shape, coal.BVHModelBase):
                own = shape.vertices()
            elif isinstance(shape, coal.Box):
                signs = np.stack(np.meshgrid(*[[-1, 1]] * 3), axis=-1).reshape(-1, 3)
                own = signs * shape.halfSide
            elif isinstance(shape, coal.Cylinder):
                ring = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1) * shape.radius
                own = np.concatenate([ring + [0, 0, s * shape.halfLength] for s in (-1, 1)])
            else:
                own = around * shape.radius
            link = "upper" if frame.name == "cover" else frame.name
            host = model.frames[model.getFrameId(link, pin.FrameType.BODY)].placement
            pose = host.inverse() * item.placement
            points.setdefault(link, []).append(own @ pose.rotation.T + pose.translation)
    stacked = {link: np.concatenate(own) for link, own in points.items()}
    return {link: (own.min(axis=0), own.max(axis=0)) for link, own in stacked.items()}


def test_boxes_of_a_urdf_are_those_of_coal(tmp_path) -> None:
    pytest.importorskip("pinocchio", reason="Pinocchio (pin) is not installed")
    path = urdf(tmp_path)
    found = symgen.geometry_boxes(path)
    theirs = by_coal(path)
    assert sorted(found.boxes) == ["lower", "tool", "upper"]
    for link, box in found.boxes.items():
        np.testing.assert_allclose(box, theirs[link], rtol=0, atol=5e-5, err_msg=link)
    assert set(found.unread) == {"bare", "unread"}


@pytest.mark.parametrize(
    ("geometry", "says"),
    [
        ('<mesh filename="package://arms/meshes/gone.stl"/>', "gone.stl': there is no such file"),
        ('<mesh filename="../meshes/rock.dae"/>', "rock.dae': accepted: STL and OBJ"),
        ('<mesh filename="../meshes/nan.obj"/>', "nan.obj': accepted: a file with points"),
        ('<mesh filename="../meshes/text.obj"/>', "text.obj': could not convert"),
        ('<mesh filename="../meshes/empty.stl"/>', "empty.stl': accepted: a file with points"),
        ('<mesh filename="file:///dev/zero.stl"/>', "there is no such file"),
        ("<mesh/>", "accepted: STL and OBJ"),
        ('<cylinder radius="1"/>', "length is missing"),
        ('<cone radius="1"/>', "<cone>; accepted: box, cylinder, sphere, mesh"),
        ('<box size="1 1 0"/>', "its geometry is flat"),
        ("", "has no geometry"),
    ],
)
def test_a_link_that_cannot_be_read_is_named_with_the_reason(tmp_path, geometry, says) -> None:
    path = urdf(tmp_path, f"<visual><geometry>{geometry}</geometry></visual>")
    meshes = path.parents[1] / "meshes"
    (meshes / "nan.obj").write_text("v 0 0 nan\n")
    (meshes / "text.obj").write_text("v 0 0 x\n")
    (meshes / "empty.stl").write_bytes(bytes(84))
    found = symgen.geometry_boxes(path)
    assert says in found.unread["unread"]
    assert sorted(found.boxes) == ["lower", "tool", "upper"]


MJCF = """<mujoco model="shapes">
  <compiler angle="radian" meshdir="arms/meshes"/>
  <default><default class="round"><geom type="capsule" size="0.05 0.2"/></default></default>
  <asset><mesh name="rock" file="rock.stl" scale="1 -2 0.5"/></asset>
  <worldbody>
    <body name="upper" pos="0 0 0.3">
      <joint name="one" axis="0 1 0" pos="0.02 0 0.01"/>
      <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
      <geom type="mesh" mesh="rock" pos="0.1 0 0" euler="0.3 1 0"/>
      <geom class="round" euler="1 0.5 0" pos="0 0.3 0"/>
      <body name="cover" pos="0.2 0 0.3" euler="0.5 0.2 0.1">
        <geom type="box" size="0.3 0.1 0.02" euler="0 0.7 0" mass="0"/>
      </body>
      <body name="lower" pos="0 0.05 0.4" euler="0.1 0.2 0">
        <joint name="two" axis="1 0 0"/>
        <geom type="ellipsoid" size="0.1 0.2 0.05" euler="0.3 0.2 1" pos="0 0 0.1"/>
        <geom type="cylinder" size="0.05 0.2" euler="0.8 0.4 1"/>
        <geom type="sphere" size="0.05" pos="0 -0.2 0"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


def test_boxes_of_an_mjcf_are_those_of_its_distances(tmp_path) -> None:
    """MuJoCo measures the distance of every geom to six walls that stand about each body."""
    mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    write_meshes(tmp_path / "arms" / "meshes")
    path = tmp_path / "arm.xml"
    path.write_text(MJCF)
    found = symgen.geometry_boxes(path)
    assert (sorted(found.boxes), found.unread) == (["lower", "upper"], {})
    spec = mujoco.MjSpec.from_file(str(path))
    for name in found.boxes:
        for axis in range(3):
            for side in (-1, 1):
                size, pos = np.full(3, 9.0), np.zeros(3)
                size[axis], pos[axis] = 1.0, side * 2.0  # its face is 1 m away
                spec.body(name).add_geom(name=f"{name} {axis} {side}", size=size, pos=pos,
                                         type=mujoco.mjtGeom.mjGEOM_BOX, mass=0)  # fmt: skip
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    for name, box in found.boxes.items():
        bodies = [model.body(n).id for n in ((name, "cover") if name == "upper" else (name,))]
        geoms = [g for g in range(model.ngeom)
                 if model.geom_bodyid[g] in bodies and not model.geom(g).name]  # fmt: skip
        for axis in range(3):
            for side, own in zip((-1, 1), box, strict=True):
                wall = model.geom(f"{name} {axis} {side}").id
                gap = min(mujoco.mj_geomDistance(model, data, g, wall, 9, None) for g in geoms)
                assert side * own[axis] == pytest.approx(1 - gap, abs=1e-5), (name, axis, side)

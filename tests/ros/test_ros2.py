"""The ROS 2 package: manifests, plugins loaded by their names, numbers against Pinocchio."""

from __future__ import annotations

import ast
import shutil
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from oracles.pinocchio_arm import load_pinocchio
from oracles.random_urdf import random_urdf
from oracles.urdf_arm import shipped, with_all_digits
from packages import LEANING, run
from support_ros2 import DISTRIBUTIONS, HERE, Built, build, compiler, needs_ros, process

import symgen
from symgen.errors import PackageError
from symgen.identification.parameters import read_values

#: Roundings of torques that are sums of hundreds of products, relative to the largest.
EXACT = 1e-11


@dataclass(frozen=True)
class Arm:
    """A robot of a URDF: its ROS package on disk, its evaluator, and its parameters."""

    package: Path
    urdf: str
    evaluator: symgen.Evaluator
    X: np.ndarray

    @property
    def name(self) -> str:
        return self.package.name

    @property
    def joints(self) -> list[str]:
        return [j.name for j in self.evaluator.model.robot.movable]

    def state(self, seed: int, count: int = 3) -> list[np.ndarray]:
        rng = np.random.default_rng(seed)
        return list(rng.uniform(-1.5, 1.5, (count, len(self.joints))))


def write_arm(text: str, into: Path, dtype: str = "double") -> Arm:
    """Write the ROS package of a URDF, with friction in addition."""
    into.mkdir(parents=True)
    path = into / "robot.urdf"
    path.write_text(text)
    model = symgen.derive(symgen.read_robot(path), "all")
    values = read_values(path, model)
    rng = np.random.default_rng(5)
    inertial = model.base.inertial
    rubbing = rng.uniform(0.2, 2.0, len(values.X) - inertial)
    X = np.array([*values.X[:inertial], *rubbing])
    tree = symgen.generate(
        model, target="ros2", dtype=dtype, values=replace(values, X=tuple(X.tolist()))
    )
    symgen.write_package(tree, into / "package")
    (package,) = into.glob("package/*_model")
    return Arm(package, text, symgen.load(model), X)


def ur10() -> str:
    found = [path for path in shipped() if path.name == "ur10_robot.urdf"]
    if not found:
        pytest.skip("example-robot-data (PyPI) is not installed")
    return with_all_digits(found[0].read_text())


@pytest.fixture(scope="module")
def arm(tmp_path_factory) -> Arm:
    return write_arm(ur10(), tmp_path_factory.mktemp("ros2") / "ur10")


@pytest.fixture(scope="module", params=DISTRIBUTIONS)
def built(request, arm, tmp_path_factory) -> Iterator[Built]:
    needs_ros()
    folder = build(arm.package, request.param, tmp_path_factory.mktemp("built") / request.param)
    with process() as hosts:
        yield Built(folder, arm.name, hosts)


@pytest.fixture(scope="module")
def tree(tmp_path_factory) -> Iterator[tuple[Arm, Built]]:
    """A tree with fixed and prismatic joints, in a float package."""
    needs_ros()
    folder = tmp_path_factory.mktemp("tree")
    made = write_arm(with_all_digits(random_urdf(3)), folder / "tree", "float")
    with process() as hosts:
        yield made, Built(build(made.package, "jazzy", folder / "jazzy"), made.name, hosts)


# ---- what the files say


def test_package_xml_is_a_manifest_of_format_3(arm):
    package = pytest.importorskip("catkin_pkg.package", reason="catkin_pkg is not installed")
    warnings: list[str] = []
    found = package.parse_package(str(arm.package), warnings=warnings)
    assert (found.name, found.package_format, warnings) == ("ur10_model", 3, [])
    assert found.get_build_type() == "ament_cmake"
    assert {"controller_interface", "pluginlib", "urdf"} <= {d.name for d in found.exec_depends}


def test_license_and_maintainer_are_those_of_the_user(arm):
    tree = symgen.generate(
        arm.evaluator.model,
        target="ros2",
        license="BSD-3-Clause",
        maintainer="A. Builder <a@b.org>",
    )
    root = ET.fromstring(tree.files["ur10_model/package.xml"])
    assert root.findtext("license") == "BSD-3-Clause"
    assert root.find("maintainer").attrib == {"email": "a@b.org"}


def test_controllers_yaml_names_the_joints_and_the_model(arm):
    settings = yaml.safe_load((arm.package / "config" / "controllers.yaml").read_text())
    parameters = settings["ur10_model_controller"]["ros__parameters"]
    assert parameters["joints"] == arm.joints
    assert parameters["torque_limits"] == [330, 330, 150, 54, 54, 54]
    header = (arm.package / "model" / "ur10.h").read_text()
    assert f"DIGEST 0x{parameters['model']['digest'].removeprefix('sha256:')}ULL" in header
    manager = settings["controller_manager"]["ros__parameters"]
    assert manager["ur10_model_controller"]["type"] == parameters["type"]


def test_launch_file_spawns_the_controller_of_the_yaml(arm):
    (path,) = arm.package.glob("launch/*.launch.py")
    module = ast.parse(path.read_text())
    assert [f.name for f in module.body if isinstance(f, ast.FunctionDef)] == [
        "generate_launch_description"
    ]
    texts = {n.value for n in ast.walk(module) if isinstance(n, ast.Constant)}
    assert {"ur10_model_controller", "spawner", "controllers.yaml", "ur10_model"} <= texts


def test_each_plugin_file_names_its_library_and_class(arm):
    build_file = (arm.package / "CMakeLists.txt").read_text()
    for stem in ("controller", "solver", "kinematics"):
        library = ET.parse(arm.package / f"{stem}.xml").getroot()
        named = library.find("class").attrib
        source = (arm.package / "src" / f"{stem}.cpp").read_text()
        assert library.get("path") == f"ur10_model_{stem}"
        assert f"PLUGINLIB_EXPORT_CLASS({named['type']}" in "".join(source.split())
        assert f"add_plugin({stem} {named['base_class_type'].split(':')[0]}" in build_file


def test_all_does_not_write_it():
    model = symgen.derive(symgen.read_robot("planar2r"))
    assert not [path for path in symgen.generate(model).files if path.startswith("planar2r_model")]


PASSIVE = '[robot]\nname = "p"\n[[joint]]\n[[joint]]\nalpha = "pi/2"\nactuated = false\n'
MOVING = '[robot]\nname = "m"\nbase = "imu"\n[[joint]]\n[[joint]]\nalpha = "pi/2"\n'


@pytest.mark.parametrize(
    ("text", "kernels", "expected"),
    [
        (PASSIVE, None, "joint 2 of p has no drive"),
        (MOVING, None, "the base of m moves"),
        (LEANING, ("inverse_dynamics",), "without the kernels mass_matrix, gravity_torque"),
    ],
)
def test_what_it_cannot_serve_is_refused(text, kernels, expected):
    model = symgen.derive(symgen.parse_robot(text), "all")
    with pytest.raises(PackageError, match=expected):
        symgen.generate(model, target="ros2", kernels=kernels)


# ---- the solver


def model_in_pinocchio(urdf: str):
    pin = load_pinocchio()
    model = pin.buildModelFromXML(urdf)
    model.armature[:] = 0
    return pin, model, model.createData()


def in_pinocchio(model, joints: list[str], values: np.ndarray) -> np.ndarray:
    """Return a vector of joint values in the order of Pinocchio's velocities."""
    out = np.zeros(model.nv)
    for name, value in zip(joints, values, strict=True):
        out[model.joints[model.getJointId(name)].idx_v] = value
    return out


def configuration(pin, model, joints: list[str], q: np.ndarray) -> np.ndarray:
    return pin.integrate(model, pin.neutral(model), in_pinocchio(model, joints, q))


def order(model, joints: list[str]) -> list[int]:
    return [model.joints[model.getJointId(name)].idx_v for name in joints]


def check_solver(arm: Arm, built: Built, exact: float) -> None:
    host = built.host("solver")
    assert host.start("solver", arm.urdf) == 0, host.log()
    pin, model, data = model_in_pinocchio(arm.urdf)
    places = order(model, arm.joints)
    q, qd, qdd = arm.state(1)
    at = configuration(pin, model, arm.joints, q)
    v, a = (in_pinocchio(model, arm.joints, x) for x in (qd, qdd))
    still = np.zeros(model.nv)
    M = pin.crba(model, data, at).copy()
    M = np.triu(M) + np.triu(M, 1).T
    gravity = pin.rnea(model, data, at, still, still)[places]
    bias = pin.rnea(model, data, at, v, still)[places]
    tau = pin.rnea(model, data, at, v, a)[places]
    found = host.solve(q, qd, qdd)
    size = np.abs(tau).max()
    np.testing.assert_allclose(found["inertia"], M[np.ix_(places, places)], atol=exact * M.max())
    np.testing.assert_allclose(found["gravity"], gravity, atol=exact * size)
    np.testing.assert_allclose(found["coriolis"], bias - gravity, atol=exact * size)
    np.testing.assert_allclose(found["torques"], tau, atol=exact * size)
    friction = arm.X[arm.evaluator.model.base.inertial :]
    coulomb, viscous = friction[::2], friction[1::2]
    np.testing.assert_allclose(
        found["friction"], coulomb * np.sign(qd) + viscous * qd, atol=exact * friction.max()
    )
    rubbing = built.host("solver", friction=True)
    assert rubbing.start("solver", arm.urdf) == 0
    total = rubbing.solve(q, qd, qdd)["torques"]
    np.testing.assert_allclose(total, tau + found["friction"], atol=exact * size)


@pytest.mark.slow
def test_solver_gives_pinocchios_numbers(arm, built):
    check_solver(arm, built, EXACT)


@pytest.mark.slow
def test_solver_of_a_float_package_gives_pinocchios_numbers(tree):
    check_solver(*tree, 2e-5)


@pytest.mark.slow
def test_solver_refuses_other_parameters_and_other_robots(arm, built):
    digest = yaml.safe_load((arm.package / "config" / "controllers.yaml").read_text())
    digest = digest["ur10_model_controller"]["ros__parameters"]["model"]["digest"]
    good = {"X": arm.X.tolist(), "digest": digest}
    assert built.host("solver", **good).start("solver", "") == 0
    for changed, expected in (
        ({"X": arm.X[1:].tolist()}, f"model.X has {len(arm.X) - 1} numbers"),
        ({"digest": "0x0123"}, "model.digest is 0x0123; the model of this package has sha256:"),
    ):
        host = built.host("solver", **{**good, **changed})
        assert host.start("solver", "") == 2
        assert expected in host.log()
    host = built.host("solver")
    assert host.start("solver", arm.urdf.replace("elbow_joint", "elbow")) == 2
    assert "joints of the model: shoulder_pan_joint, " in host.log()
    assert "joints of robot_description: elbow, " in host.log()


# ---- frames and Jacobians


def check_kinematics(arm: Arm, built: Built, exact: float, inverse: bool) -> None:
    host = built.host("kinematics")
    assert host.start("kinematics", arm.urdf) == 0, host.log()
    pin, model, data = model_in_pinocchio(arm.urdf)
    places = order(model, arm.joints)
    (q,) = arm.state(2, 1)
    at = configuration(pin, model, arm.joints, q)
    links = [link.get("name") for link in ET.fromstring(arm.urdf).findall("link")]
    pin.computeJointJacobians(model, data, at)
    pin.updateFramePlacements(model, data)
    for link in links:
        frame = model.getFrameId(link)
        T, J, damped = host.locate(q, link)
        np.testing.assert_allclose(T, data.oMf[frame].homogeneous, atol=exact)
        full = pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED)
        np.testing.assert_allclose(J, full[:, places], atol=exact)
        if inverse:
            expected = J.T @ np.linalg.inv(J @ J.T + 5e-6 * np.eye(6))
            np.testing.assert_allclose(damped, expected, atol=1e-5 * max(1, abs(expected).max()))
    assert host.locate(q, "nowhere") is None
    assert "no link nowhere; links: " in host.log()
    assert host.locate(q[1:], links[0]) is None


@pytest.mark.slow
def test_every_link_is_where_pinocchio_has_it(arm, built):
    check_kinematics(arm, built, EXACT, built.distribution != "humble")


@pytest.mark.slow
def test_links_of_a_float_tree_are_where_pinocchio_has_them(tree):
    check_kinematics(*tree, 1e-5, True)


@pytest.mark.slow
def test_names_with_a_prefix(arm, built):
    urdf = arm.urdf
    for word in [*arm.joints, "tool0", "base_link"]:
        urdf = urdf.replace(f'"{word}"', f'"left_{word}"')
    joints = [f"left_{j}" for j in arm.joints]
    for kind in ("controller", "solver", "kinematics"):
        plain = built.host(kind, robot_description=urdf)
        assert plain.start(kind, urdf) != 0
        assert "joint shoulder_pan_joint is not in robot_description" in plain.log()
        host = built.host(kind, joints=joints, prefix="left_", robot_description=urdf)
        assert host.start(kind, urdf) == 0, host.log()
        if kind == "controller":
            assert host.load("left_tool0", 1.0) == ""
        if kind == "kinematics":
            assert host.locate(arm.state(2, 1)[0], "left_tool0") is not None


@pytest.mark.slow
def test_kinematics_in_another_base(arm, built):
    host = built.host("kinematics", base="base")
    root = built.host("kinematics")
    assert host.start("kinematics", arm.urdf) == root.start("kinematics", arm.urdf) == 0
    (q,) = arm.state(2, 1)
    turned = root.locate(q, "base")[0]
    T, J, _ = host.locate(q, "tool0")
    expected, J_root, _ = root.locate(q, "tool0")
    np.testing.assert_allclose(turned @ T, expected, atol=EXACT)
    np.testing.assert_allclose(turned[:3, :3] @ J[:3], J_root[:3], atol=EXACT)
    moving = built.host("kinematics", base="tool0")
    assert moving.start("kinematics", arm.urdf) == 1
    assert moving.log() == "base is 'tool0'; accepted: a link that does not move"


# ---- the controller


@pytest.mark.slow
def test_gravity_compensation_adds_efforts_and_limits(arm, built):
    host = built.host("controller")
    host.set("robot_description", arm.urdf)
    assert host.start("controller", arm.urdf) == 0, host.log()
    assert host.names(0) == [f"{j}/effort" for j in arm.joints]
    assert host.names(1)[:2] == ["shoulder_pan_joint/position", "shoulder_pan_joint/velocity"]
    assert host.names(2) == [f"arm/{j}/effort" for j in arm.joints]
    q, qd = arm.state(3, 2)
    gravity = arm.evaluator.gravity_torque(q, arm.X[: arm.evaluator.model.base.inertial])
    np.testing.assert_allclose(host.cycle(q, qd), gravity, atol=EXACT * 100)
    host.chain(True)
    efforts = np.array([1.0, np.nan, 3.0, 4.0, 100.0, -100.0])
    host.refer(efforts)
    expected = np.clip(gravity + np.nan_to_num(efforts), -LIMITS, LIMITS)
    np.testing.assert_allclose(host.cycle(q, qd), expected, atol=EXACT * 100)
    host.chain(False)  # no reference is left over
    np.testing.assert_allclose(host.cycle(q, qd), gravity, atol=EXACT * 100)
    assert host.cycle(np.full(6, np.nan)) is None
    np.testing.assert_array_equal(host.commands(6), 0.0)
    assert host.cycle(q, qd) is not None
    host.deactivate()
    np.testing.assert_array_equal(host.commands(6), 0.0)


LIMITS = np.array([330, 330, 150, 54, 54, 54])


@pytest.mark.slow
def test_full_feedforward_follows_and_holds(arm, built):
    p, d = np.full(6, 50.0), np.full(6, 5.0)
    host = built.host("controller", feedforward="full")
    host.set("gains.p", p)
    host.set("gains.d", d)
    host.set("torque_limits", np.full(6, 1e6))
    assert host.start("controller", arm.urdf) == 0, host.log()
    kinds = ("position", "velocity", "acceleration", "effort")
    assert host.names(2) == [f"arm/{j}/{kind}" for j in arm.joints for kind in kinds]
    q, qd, target, speed, acceleration = arm.state(4, 5)
    host.chain(True)
    still = np.zeros(6)
    holding = arm.evaluator.inverse_dynamics(q, still, still, arm.X)
    np.testing.assert_allclose(host.cycle(q, qd), holding - d * qd, atol=1e-9)
    host.refer(np.stack([target, speed, acceleration, np.full(6, np.nan)], axis=1).ravel())
    expected = arm.evaluator.inverse_dynamics(q, speed, acceleration, arm.X)
    expected = expected + p * (target - q) + d * (speed - qd)
    np.testing.assert_allclose(host.cycle(q, qd), expected, atol=1e-9)
    host.refer(np.full(24, np.nan))
    expected = holding + p * (target - q) - d * qd
    np.testing.assert_allclose(host.cycle(q, qd), expected, atol=1e-9)
    host.chain(False)
    np.testing.assert_allclose(host.cycle(q, qd), holding - d * qd, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("settings", "expected"),
    [
        ({"feedforward": "none"}, "feedforward is 'none'; accepted: gravity, full"),
        ({"feedforward": "full"}, "feedforward full needs gains.p above 0"),
        ({"gains__p": [100] * 6}, "wrong index for variant"),
        ({"gains__p": [1.0]}, "gains.p has 1 numbers; the model has 6 joints"),
        ({"gains__d": [-1.0] * 6}, "gains.d must have numbers of at least 0"),
        ({"torque_limits": [np.nan] * 6}, "torque_limits must have numbers of at least 0"),
        ({"joints": ["a", "b"]}, "joints has 2 names; the model has 6: shoulder_pan_joint, "),
        ({"joints": list("abcdef")}, "joint a is not in robot_description; joints of the model"),
        ({"model__X": [1.0, 2.0]}, "model.X has 2 numbers; the model has "),
        ({"model__digest": "0x1"}, "model.digest is 0x1; the model of this package has sha256:"),
    ],
)
def test_wrong_settings_are_refused(arm, built, settings, expected):
    host = built.host("controller", robot_description=arm.urdf, **settings)
    assert host.start("controller", arm.urdf) == 1
    assert expected in host.log()


@pytest.mark.slow
def test_without_a_description_names_are_not_checked(arm, built):
    host = built.host("controller", joints=[f"left_{j}" for j in arm.joints])
    assert host.start("controller", "") == 0
    assert "the names of the joints are not checked" in host.log()
    assert host.names(0)[0] == "left_shoulder_pan_joint/effort"


@pytest.mark.slow
def test_a_load_is_that_of_pinocchio(arm, built):
    host = built.host("controller", robot_description=arm.urdf)
    assert host.start("controller", arm.urdf) == 0, host.log()
    pin, model, data = model_in_pinocchio(arm.urdf)
    frame = model.frames[model.getFrameId("tool0")]
    mass, com = 2.5, np.array([0.1, -0.05, 0.2])
    inertia = np.array([0.03, 0.001, -0.002, 0.04, 0.003, 0.02])
    tensor = inertia[[0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(3, 3)
    body = frame.placement.act(pin.Inertia(mass, com, tensor))
    model.inertias[frame.parentJoint] = model.inertias[frame.parentJoint] + body
    data = model.createData()
    (q,) = arm.state(6, 1)
    gravity = pin.computeGeneralizedGravity(model, data, configuration(pin, model, arm.joints, q))
    unloaded = host.cycle(q)
    assert host.load("tool0", mass, com, inertia) == ""
    np.testing.assert_allclose(host.cycle(q), gravity[order(model, arm.joints)], atol=1e-9)
    for refused, expected in (
        (("tool0", -1.0), "payload refused: mass, centre of mass and inertia must be finite"),
        (("tool0", np.nan), "payload refused: mass, centre of mass and inertia must be finite"),
        (("gripper", 1.0), "payload refused: frame_id 'gripper' is not a link of the model; links"),
        (("tool0", 0.0, (0, 0, 0), (1, 0, 0, -1, 0, 1)), "a negative principal moment"),
        (("base_link", 1.0), "payload refused: link base_link does not move"),
    ):
        assert expected in host.load(*refused)
        np.testing.assert_allclose(host.cycle(q), gravity[order(model, arm.joints)], atol=1e-9)
    assert host.load("tool0", 0.0, (1, 1, 1), (1, 0, 0, 1, 0, 1)) == ""
    np.testing.assert_array_equal(host.cycle(q), unloaded)


@pytest.mark.slow
def test_a_moving_load_has_its_inertia(arm, built):
    host = built.host("controller", feedforward="full", robot_description=arm.urdf)
    host.set("torque_limits", np.full(6, 1e6))
    host.set("gains.p", np.ones(6))
    assert host.start("controller", arm.urdf) == 0, host.log()
    pin, model, data = model_in_pinocchio(arm.urdf)
    q, qd, qdd = arm.state(7)
    at = configuration(pin, model, arm.joints, q)
    v, a = (in_pinocchio(model, arm.joints, x) for x in (qd, qdd))
    before = pin.rnea(model, data, at, v, a)
    frame = model.frames[model.getFrameId("ee_link")]
    inertia = np.array([0.03, 0.001, -0.002, 0.04, 0.003, 0.02])
    tensor = inertia[[0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(3, 3)
    body = frame.placement.act(pin.Inertia(3.0, np.array([0.1, 0.2, 0.3]), tensor))
    model.inertias[frame.parentJoint] = model.inertias[frame.parentJoint] + body
    added = (pin.rnea(model, model.createData(), at, v, a) - before)[order(model, arm.joints)]
    host.chain(True)
    host.refer(np.stack([q, qd, qdd, np.zeros(6)], axis=1).ravel())
    unloaded = host.cycle(q, qd)
    assert host.load("ee_link", 3.0, (0.1, 0.2, 0.3), inertia) == ""
    np.testing.assert_allclose(host.cycle(q, qd) - unloaded, added, atol=1e-9)


ODD = """
[robot]
name = "Odd__One"
gravity = "input"
[[joint]]
name = 'a "b" é'
[[joint]]
sigma = 1
alpha = "pi/2"
[[joint]]
alpha = "pi/2"
d = 0.3
[[effect]]
name = "gravity_spring"
joints = [3]
[[effect]]
name = "load_dependent_friction"
joints = [1]
"""


@pytest.mark.slow
@pytest.mark.parametrize("distribution", DISTRIBUTIONS)
def test_an_odd_robot_is_held(distribution, tmp_path):
    needs_ros()
    robot = symgen.parse_robot(ODD)
    model = symgen.derive(robot, "all")
    symgen.write_package(symgen.generate(model, target="ros2"), tmp_path / "odd")
    built = build(tmp_path / "odd" / "odd_one_model", distribution, tmp_path / distribution)
    X = np.random.default_rng(3).uniform(0.1, 1.0, len(model.base.parameters))
    q, g = np.array([0.3, -0.2, 0.5]), [1.0, 2.0, -9.0]
    still = np.zeros(3)
    expected = symgen.load(model).inverse_dynamics(q, still, still, X, g)
    with process() as hosts:
        named = Built(built, "odd_one_model", hosts)
        host = named.host("controller", gravity=g, model__X=X)
        assert host.start("controller", "") == 0, host.log()
        assert host.names(0) == ['a "b" é/effort', "q2/effort", "q3/effort"]
        np.testing.assert_allclose(host.cycle(q), expected, atol=1e-12)
        solver = named.host("solver", gravity=g, X=X)
        assert solver.start("solver", "") == 0, solver.log()
        gravity = symgen.load(model).gravity_torque(q, X[: model.base.inertial], g)
        np.testing.assert_allclose(solver.solve(q, still, still)["gravity"], gravity, atol=1e-12)


@pytest.mark.slow
def test_two_robots_in_one_process(arm, tree, tmp_path):
    other, float_built = tree
    folder = build(arm.package, "jazzy", tmp_path / "jazzy")
    same = Built(folder, arm.name, float_built.hosts)
    hosts = [same.host("controller"), float_built.host("controller")]
    for host, robot in zip(hosts, (arm, other), strict=True):
        host.set("torque_limits", np.full(len(robot.joints), 1e6))
        assert host.start("controller", robot.urdf) == 0, host.log()
    for host, robot in zip(hosts, (arm, other), strict=True):
        (q,) = robot.state(8, 1)
        inertial = robot.evaluator.model.base.inertial
        gravity = robot.evaluator.gravity_torque(q, robot.X[:inertial])
        np.testing.assert_allclose(host.cycle(q), gravity, atol=1e-4 * np.abs(gravity).max())


@pytest.mark.slow
def test_a_cycle_allocates_nothing_and_takes_no_lock(arm, built, tmp_path):
    program = tmp_path / "counted"
    source = HERE / "counted.cpp"
    libraries = ["-lclass_loader", "-lconsole_bridge", "-ldl", "-pthread"]
    run([*compiler(built.distribution), "-rdynamic", source, *libraries, "-o", program], tmp_path)
    printed = run(
        [program, built.folder / "controller.so", f"{arm.name}::ModelController"], tmp_path
    )
    assert printed.split() == ["allocations", "0", "locks", "0", "control", "1", "1"]


# ---- the build


@pytest.mark.slow
def test_ament_builds_and_installs_the_plugins(arm, built, tmp_path):
    if shutil.which("cmake") is None or not Path("/usr/share/ament_cmake").is_dir():
        pytest.skip("cmake and ament_cmake are not installed")
    for name, target in STUBBED.items():
        folder = tmp_path / "prefix" / "share" / name / "cmake"
        folder.mkdir(parents=True)
        flags = f"-DDISTRIBUTION={DISTRIBUTIONS[built.distribution]}"
        (folder / f"{name}Config.cmake").write_text(
            "include_guard(GLOBAL)\n"
            f"add_library({target} INTERFACE IMPORTED GLOBAL)\n"
            f'target_include_directories({target} INTERFACE "{HERE / "stubs"}")\n'
            f'target_compile_options({target} INTERFACE "{flags}")\n'
        )
    configure = [
        f"-DCMAKE_PREFIX_PATH={tmp_path / 'prefix'}",
        "-DPython3_EXECUTABLE=/usr/bin/python3",
    ]
    install = tmp_path / "install"
    build_folder = tmp_path / "build"
    where = ["-S", arm.package, "-B", build_folder, f"-DCMAKE_INSTALL_PREFIX={install}"]
    run(["cmake", *where, *configure], tmp_path)
    run(["cmake", "--build", build_folder, "-j2", "--target", "install"], tmp_path)
    index = install / "share" / "ament_index" / "resource_index"
    for stem, base in PLUGINS.items():
        named = (index / f"{base}__pluginlib__plugin" / "ur10_model").read_text().split()
        assert named == [f"share/ur10_model/{stem}.xml"]
        library = ET.parse(install / named[0]).getroot().get("path")
        host = built.host(str(install / "lib" / f"lib{library}"))
        assert host.start(stem, arm.urdf) == 0, host.log()
    assert (install / "share" / "ur10_model" / "config" / "controllers.yaml").is_file()


#: The package of the base class of each plugin.
PLUGINS = {
    "controller": "controller_interface",
    "solver": "inverse_dynamics_solver",
    "kinematics": "kinematics_interface",
}
STUBBED = {
    "rclcpp": "rclcpp::rclcpp",
    "rclcpp_lifecycle": "rclcpp_lifecycle::rclcpp_lifecycle",
    "geometry_msgs": "geometry_msgs::geometry_msgs",
    "controller_interface": "controller_interface::controller_interface",
    "hardware_interface": "hardware_interface::hardware_interface",
    "kinematics_interface": "kinematics_interface::kinematics_interface",
    "inverse_dynamics_solver": "inverse_dynamics_solver::inverse_dynamics_solver",
}


@pytest.mark.slow
def test_without_ros_cmake_builds_the_library(arm, tmp_path):
    if shutil.which("cmake") is None:
        pytest.skip("cmake is not installed")
    hidden = "-DCMAKE_DISABLE_FIND_PACKAGE_ament_cmake=ON"
    run(["cmake", "-S", arm.package, "-B", tmp_path, hidden], tmp_path)
    run(["cmake", "--build", tmp_path, "-j2"], tmp_path)
    assert list(tmp_path.glob("model/libur10_model.a"))

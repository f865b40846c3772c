"""ROS 2: the package NAME_model, with the C sources and three plugins around them.

A chainable effort controller for ros2_control, a solver for inverse_dynamics_solver, and frames and
Jacobians for kinematics_interface. The sources compile with Humble, Jazzy and Lyrical.
"""

from __future__ import annotations

import json
import re
import tomllib
from html import escape

from symgen.codegen.backends import Package, c
from symgen.codegen.values import robot_digest
from symgen.errors import PackageError
from symgen.files import templates
from symgen.robot.identifiers import c_identifiers
from symgen.robot.types import Robot

#: Kernels that the plugins call.
_KERNELS = (
    "inverse_dynamics",
    "mass_matrix",
    "gravity_torque",
    "friction",
    "frames",
    "link_jacobian",
    "add_body",
)


def files(package: Package) -> dict[str, str]:
    """Return the files of the folder NAME_model: C library, plugins, manifest and launch file."""
    robot = package.model.robot
    _require(package)
    plain = re.sub("_+", "_", package.name.lower().strip("_"))
    folder = f"{plain}_model"
    library = c.files(package)
    names = [_quoted(j.name or f"q{j.number}") for j in robot.movable]
    limits = robot.limits.torque if robot.limits is not None else None
    listed = (templates() / "ros2/plugins.toml").read_text("utf-8")
    plugins = tomllib.loads(listed)["plugin"]
    packages = {"pluginlib", "rclcpp", "urdf", "eigen"}
    for plugin in plugins:
        packages.update([plugin["package"], *plugin["extras"]])
    data = {
        "package": folder,
        "title": escape(robot.name),
        "plugins": plugins,
        "dependencies": sorted(packages),
        "license": package.license,
        "contact": package.contact,
        "joints": names,
        "links": _links(package),
        "links_header": bool(robot.frames),
        "link_count": len(robot.joints),
        "limits_header": f"{package.name}_limits.h" in library,
        "torque_limits": limits,
        "known": package.values is not None,
        "digest": f"sha256:{robot_digest(robot)[2:18]}",
    }
    written = {
        "package.xml": "package.xml",
        "CMakeLists.txt": "CMakeLists.txt",
        "src/model.hpp": "model.hpp",
        "config/controllers.yaml": "controllers.yaml",
        f"launch/{folder}.launch.py": "launch.py",
    }
    for plugin in plugins:
        source = f"{plugin['stem']}.cpp"
        written[f"src/{source}"] = source
    out = {path: package.render(f"ros2/{name}", **data) for path, name in written.items()}
    for plugin in plugins:
        description = package.render("ros2/plugin.xml", package=folder, plugin=plugin)
        out[f"{plugin['stem']}.xml"] = description
    out |= {f"model/{path}": text for path, text in library.items()}
    return {f"{folder}/{path}": text for path, text in out.items()}


def _quoted(text: str) -> str:
    """Return a text as a literal of C++ and of YAML."""
    return json.dumps(text, ensure_ascii=False)


def _require(package: Package) -> None:
    """Refuse a robot or a choice of kernels that the plugins cannot serve.

    Raises:
        PackageError: kernels are missing, the base moves, or a joint is passive.
    """
    robot = package.model.robot
    missing = [name for name in _KERNELS if not package.has(name)]
    if missing:
        raise PackageError(
            f"target ros2 without the kernels {', '.join(missing)}; accepted: --kernels all"
        )
    if robot.imu:
        raise PackageError(f"target ros2: the base of {robot.name} moves; accepted: a fixed base")
    passive = [j.name or f"{j.number}" for j in robot.movable if not j.actuated]
    if passive:
        raise PackageError(
            f"target ros2: joint {passive[0]} of {robot.name} has no drive, and an effort "
            "controller commands every joint; accepted: target c"
        )


def _links(package: Package) -> list[dict[str, str]]:
    """Return the links by name: those of the robot's file, or link0, link1 .. by joint number."""
    robot: Robot = package.model.robot
    if not robot.frames:
        numbers = [0, *(j.number for j in robot.joints)]
        return [{"text": f'"link{n}"', "joint": f"{n}u", "frame": "SAME"} for n in numbers]
    endings = c_identifiers((f.name for f in robot.frames), "frame")
    return [
        {
            "text": _quoted(frame.name),
            "joint": f"{package.name}_LINK_{ending}",
            "frame": f"{package.name}_FRAME_{ending}",
        }
        for frame, ending in zip(robot.frames, endings, strict=True)
    ]

"""An estimate written back into the robot's own URDF or MJCF."""

from __future__ import annotations

import hashlib
from pathlib import Path

from symgen.codegen.model import derive
from symgen.errors import ParameterError
from symgen.identification.estimate import ROBOT_DIGEST, Estimate, read_estimate
from symgen.identification.parameters import cad_parameters, same_frames
from symgen.identification.physical.links import link_parameters
from symgen.robot.imported import read_text
from symgen.robot.mjcf_io import updated_mjcf
from symgen.robot.toml_io import read_imported, read_robot
from symgen.robot.toml_text import robot_toml
from symgen.robot.types import Robot
from symgen.robot.urdf_io import updated_urdf


def identified_file(
    path: str | Path, estimate: Estimate, robot: Robot | None = None
) -> tuple[str, str]:
    """Return the file with link parameters that give the identified ones, and what to say of it.

    Base parameters do not determine link parameters: of all that a robot could have and that give
    X, those closest to the file's own are taken. Where no robot can have X, the nearest X is taken
    that one can have.

    Args:
        path: of the file that the robot was read from.
        estimate: identified on that robot.
        robot: that robot, where joints of the file are held still in it.

    Raises:
        RobotError: the file cannot be read.
        ParameterError: it is another robot's.
    """
    path = Path(path)
    found = read_imported(path)
    model = derive(found.robot if robot is None else robot)
    if model.base.names != tuple(p.name for p in estimate.parameters):
        raise ParameterError(f"{path}: the estimate is of another robot")
    if not same_frames(found.robot, model.robot):
        raise ParameterError(
            f"{path}: its frames are not those of {model.robot.name}; accepted: the file that the "
            "robot was imported from"
        )
    links = link_parameters(
        model,
        estimate.X,
        prior=cad_parameters(path, model) if found.parameters else None,
        nearest=estimate.covariance,
    )
    if path.suffix.lower() == ".xml":
        text = updated_mjcf(path, links.bodies)
    else:
        text, _ = read_text(path, "accepted: a .urdf")
        text = updated_urdf(text, links.bodies, str(path))
    said = f"link parameters in {path.name}: {links.caveat}"
    if links.sigmas > 0:
        said += f"; the identified X is {links.sigmas:.2g} standard deviations away from them"
    return text, said


def export(
    estimate: str | Path, source: str | Path, robot: str | Path | Robot | None = None
) -> tuple[str, str]:
    """Write the identified link parameters of a robot into the text of its URDF or MJCF.

    Args:
        estimate: an estimate.json, or the folder that `identify` wrote.
        source: path of the URDF or MJCF; everything in it but <inertial> elements stays as it is.
        robot: the robot that was identified, its path or a library name; by default the robot.toml
            beside the estimate, or else the robot of the file.

    Returns:
        The text, and what to say of the numbers in it.

    Raises:
        RobotError: a robot cannot be read.
        ParameterError: the estimate cannot be read or is another robot's.
    """
    known = read_estimate(estimate)
    path = Path(estimate)
    beside = (path if path.is_dir() else path.parent) / "robot.toml"
    if robot is None and beside.is_file():
        robot = beside
    if isinstance(robot, (str, Path)):
        robot = read_robot(robot)
    if robot is not None:
        digest = hashlib.sha256(robot_toml(robot).encode()).hexdigest()
        if dict(known.provenance).get(ROBOT_DIGEST, digest) != digest:
            raise ParameterError(
                f"{path}: the estimate is of another robot than {robot.name}; accepted: --robot "
                "with the robot.toml that was identified"
            )
    return identified_file(source, known, robot)

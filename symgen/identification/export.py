"""Export of identified values: a C header, and a copy of the robot's URDF or MJCF."""

from __future__ import annotations

import hashlib
import math
import re
from pathlib import Path

from symgen.codegen.model import derive
from symgen.codegen.package import model_digest
from symgen.errors import ParameterError
from symgen.files import rendered
from symgen.identification.estimate import ROBOT_DIGEST, Estimate, read_estimate
from symgen.identification.parameters import cad_parameters, same_frames
from symgen.identification.physical import link_parameters
from symgen.robot.formats.mjcf import updated_mjcf
from symgen.robot.formats.urdf import updated_urdf
from symgen.robot.imported import read_text
from symgen.robot.toml_io import read_imported, read_robot
from symgen.robot.toml_text import robot_toml
from symgen.robot.types import Robot


def values_header(estimate: Estimate, prefix: str | None = None) -> str:
    """Return NAME_values.h: the identified X as `static const NAME_real NAME_values[]`.

    It includes NAME.h of the generated package. It compares digests, and compiles only with a
    package of the same robot.toml. Its first lines have the verdict and the reasons.

    Args:
        estimate: the estimate.
        prefix: prefix of the package; the name of the robot by default, NAMEf for a float package.

    Raises:
        ParameterError: a value is not finite, or the result of method consistent is not possible.
    """
    if estimate.method.startswith("consistent") and estimate.physical.feasible is not True:
        raise ParameterError(
            f"{estimate.robot}: not exported, no robot can have these parameters: "
            f"{estimate.physical.reason}"
        )
    bad = [p.name for p in estimate.parameters if not math.isfinite(p.value)]
    if bad:
        raise ParameterError(f"{', '.join(bad[:5])}: not finite, and cannot be written in C")
    facts = [
        f"Identified by symgen with the {estimate.model} model, method {estimate.method}.",
        f"Verdict: {estimate.verdict}.",
        *(f"- {reason}" for reason in estimate.reasons),
        *(
            f"For {use.name}: {'yes' if use.ok else 'no: ' + '; '.join(use.reasons)}."
            for use in estimate.uses
        ),
        f"Physical consistency: {estimate.physical.reason}.",
        *(f"{key}: {value}" for key, value in estimate.provenance),
    ]
    robot = dict(estimate.provenance).get(ROBOT_DIGEST, "")
    return rendered(
        "c/values.h",
        name=prefix or estimate.robot,
        robot=estimate.robot,
        digest=model_digest(robot) if re.fullmatch("[0-9a-f]{64}", robot) else None,
        facts=[_comment(fact) for fact in facts],
        parameters=[
            {
                "name": p.name,
                "value": repr(p.value),
                "formula": _comment(
                    p.name if p.expression == p.name else f"{p.name} = {p.expression}"
                ),
                "unit": p.unit,
                "std": f"{p.std:.3g}" if math.isfinite(p.std) else "unknown",
            }
            for p in estimate.parameters
        ],
    )


def _comment(text: str) -> str:
    """Return a text as one line that is safe inside a C comment."""
    line = "".join(c if c.isprintable() else " " for c in text)
    # no end or begin of a comment, and no trigraph
    return re.sub(r"(\*(?=/)|/(?=\*)|\?(?=\?))", r"\1 ", line).rstrip("\\")


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
    if robot is not None:
        robot = read_robot(robot)
        digest = hashlib.sha256(robot_toml(robot).encode()).hexdigest()
        if dict(known.provenance).get(ROBOT_DIGEST, digest) != digest:
            raise ParameterError(
                f"{path}: the estimate is of another robot than {robot.name}; accepted: --robot "
                "with the robot.toml that was identified"
            )
    return identified_file(source, known, robot)

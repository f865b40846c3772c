"""An estimate written back into the robot's own URDF."""

from __future__ import annotations

from pathlib import Path

from symgen.codegen.model import derive
from symgen.errors import ParameterError
from symgen.identification.estimate import Estimate
from symgen.identification.parameters import cad_parameters
from symgen.identification.physical import link_parameters
from symgen.robot.toml_io import read_robot
from symgen.robot.urdf_io import Body, updated_urdf


def identified_urdf(path: str | Path, estimate: Estimate) -> tuple[str, str]:
    """Return the URDF with link parameters that give the identified ones, and what to say of them.

    Base parameters do not determine link parameters: of all that a robot could have and that give
    X, those closest to the file's own are taken. Where no robot can have X, the nearest X is taken
    that one can have.

    Args:
        path: of the URDF that the robot was read from.
        estimate: identified on that robot.

    Raises:
        ParameterError: the file has no inertias, or the solver is not installed.
    """
    path = Path(path)
    model = derive(read_robot(path))
    if model.base.names != tuple(p.name for p in estimate.parameters):
        raise ParameterError(f"{path}: the estimate is of another robot")
    links = link_parameters(
        model,
        estimate.X,
        prior=cad_parameters(path, model),
        nearest=estimate.covariance,
    )
    text = updated_urdf(
        path, {b.joint: Body(b.mass, b.com.tolist(), b.inertia.tolist()) for b in links.bodies}
    )
    said = f"link parameters in a URDF: {links.caveat}"
    if links.sigmas > 0:
        said += f"; the identified X is {links.sigmas:.2g} standard deviations away from them"
    return text, said

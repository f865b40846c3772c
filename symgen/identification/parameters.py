"""Parameter values from files: `[parameters]` in TOML, or an estimate.json."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from symgen import names
from symgen.codegen.model import Model, derive, regrouping
from symgen.codegen.values import Values, named_values
from symgen.errors import ParameterError, SymgenError, message_of
from symgen.estimation.band import Band
from symgen.estimation.estimators import Prior
from symgen.estimation.system import torque_at
from symgen.estimation.values import FloatArray
from symgen.faults.fault import Fault
from symgen.files import load_json, load_toml
from symgen.identification.estimate import MARKER, READ, Estimate, read_estimate
from symgen.robot.imported import FORMATS
from symgen.robot.toml_io import read_imported
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator
from symgen.schemas import from_json, result_file

#: Name of the parameters in the folder of a diagnosis.
PARAMETERS = "parameters.toml"
_SAME = 1e-6  # m or rad: the frames of two files of one robot agree so closely


@dataclass(frozen=True, eq=False)
class Given:
    """Parameters that are an input of a command.

    Attributes:
        file: file of the parameters.
        X: (p,) base parameters.
        named: value and standard deviation (or None) of each parameter in that file, by name.
        estimate: estimate in that file; None for TOML and URDF files.
        band: filters of the run that gave the parameters; None if the file does not state them.
    """

    file: Path
    X: FloatArray
    named: Mapping[str, tuple[Any, Any]]
    estimate: Estimate | None
    band: Band | None

    @property
    def shifts(self) -> tuple[Fault, ...]:
        """Shifts of the torques of all logs that the estimate stands on."""
        return () if self.estimate is None else self.estimate.shifts


def read_given(path: str | Path, model: Model) -> Given:
    """Read the base parameters of a model, and their estimate if there is one.

    Args:
        path: a path as for `read_parameters`.
        model: model of the robot.

    Raises:
        ParameterError: as `read_parameters`, or the estimate is damaged.
    """
    named = read_named(Path(path), model)
    X, file = _base(named, model, path), parameters_file(path)
    if file.suffix == ".json":
        estimate = read_estimate(file)
        return Given(file, X, named, estimate, estimate.band)
    return Given(file, X, named, None, _band(file) if file.suffix == ".toml" else None)


def parameters_file(path: str | Path) -> Path:
    """Return the file of parameters: the path, or estimate.json or parameters.toml of a folder."""
    file = result_file(path, MARKER)
    diagnosed = file.with_name(PARAMETERS)
    return diagnosed if Path(path).is_dir() and not file.exists() and diagnosed.exists() else file


def _band(file: Path) -> Band | None:
    """Return the table [band] of a TOML file that `diagnose` wrote; None without one.

    Raises:
        ParameterError: the table is damaged.
    """
    content = load_toml(file.read_text(encoding="utf-8-sig")).get("band")
    return from_json(Band, content, file) if isinstance(content, dict) else None


def read_parameters(path: str | Path, model: Model) -> FloatArray:
    """Read the base parameters X (p,) of a model.

    Args:
        path: the folder that `identify` or `diagnose` wrote, the estimate.json in it, or a TOML
            file with a table [parameters]: base parameters by name (`ZZ1R = 1.7`), or standard
            ones (`ZZ1 = 1.2`), which are regrouped; or the .urdf that the robot was imported from,
            whose inertias are standard parameters.
        model: model of the robot.

    Raises:
        ParameterError: the file cannot be read, or a name is unknown, missing or not a number.
    """
    return _base(read_named(Path(path), model), model, path)


def _base(named: Mapping[str, tuple[Any, Any]], model: Model, path: str | Path) -> FloatArray:
    return base_values({name: value for name, (value, _) in named.items()}, model, str(path))


def read_values(path: str | Path, model: Model) -> Values:
    """Read the parameters of a model for a package: X, and standard parameters if the file has all.

    Args:
        path: a path as for `read_parameters`.
        model: model of the robot.

    Raises:
        ParameterError: as `read_given` and `estimate_facts`.
    """
    given = read_given(path, model)
    own = (f"From {Path(path).name}.",)
    facts = own if given.estimate is None else estimate_facts(given.estimate)
    return named_values(given.X.tolist(), given.named, model.base, facts)


def estimate_facts(estimate: Estimate) -> tuple[str, ...]:
    """Return what the header of values says of an estimate: verdict, headline and provenance.

    Raises:
        ParameterError: a value is not finite, or the result of method consistent is not possible.
    """
    if estimate.method.startswith("consistent") and not estimate.possible:
        raise ParameterError(
            f"{estimate.robot}: not exported, the parameters are not physically possible: "
            f"{estimate.physical.text}"
        )
    bad = [p.name for p in estimate.parameters if not math.isfinite(p.value)]
    if bad:
        raise ParameterError(f"{', '.join(bad[:5])}: not finite, and cannot be written in C")
    return (
        f"Identified by symgen with the {estimate.model} model, method {estimate.method}.",
        f"Verdict: {estimate.verdict}.",
        *estimate.sentences,
        f"Physical consistency: {estimate.physical.text}.",
        *(f"{key}: {value}" for key, value in estimate.provenance),
    )


def read_named(path: Path, model: Model) -> dict[str, tuple[Any, Any]]:
    """Return value and standard deviation (or None) of each parameter in a file.

    Raises:
        ParameterError: the file cannot be read, or belongs to another robot.
    """
    if path.suffix.lower() in FORMATS:
        return {name: (value, None) for name, value in cad_parameters(path, model).items()}
    path = parameters_file(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
        content = load_json(text) if path.suffix == ".json" else load_toml(text)
    except (OSError, ValueError, RecursionError) as error:
        raise ParameterError(
            f"{path}: cannot be read ({message_of(error)}); accepted: estimate.json, or TOML with "
            "[parameters]"
        ) from error
    table = content.get("parameters") if isinstance(content, dict) else None
    if path.suffix != ".json":
        if not isinstance(table, dict):
            raise ParameterError(f"{path}: the table [parameters] is missing")
        return {name: (value, None) for name, value in table.items()}
    if not isinstance(table, list) or content.get("schema") not in READ:
        raise ParameterError(f"{path}: not an estimate; accepted: schema {READ[0]}")
    if not all(isinstance(p, dict) and {"name", "value"} <= set(p) for p in table):
        raise ParameterError(f"{path}: every parameter needs a name and a value")
    if content.get("robot", model.robot.name) != model.robot.name:
        raise ParameterError(
            f"{path}: the estimate is of the robot {content['robot']!r}; accepted: one of "
            f"{model.robot.name!r}"
        )
    return {str(p["name"]): (p["value"], p.get("std")) for p in table}


def cad_parameters(path: Path, model: Model) -> dict[str, float]:
    """Return the parameter values of another program's file, if it has the frames of the model.

    A missing rotor inertia or friction is 0.

    Raises:
        ParameterError: the file has no parameters, or belongs to another robot.
    """
    found = read_imported(path)
    if not found.parameters:
        raise ParameterError(f"{path}: it holds no values of parameters")
    robot = with_fixed_links(model.robot, found.robot, path)
    values = dict(found.parameters)
    if robot == model.robot:
        return _with_drives(values, model)
    there = derive(robot)
    X = base_values(_with_drives(values, there), there, str(path))
    return dict(zip(model.base.names, X, strict=True))


def _with_drives(values: dict[str, Any], model: Model) -> dict[str, Any]:
    """Return the parameters that a model has; drives and a payload without values are 0."""
    load = [f"{prefix}L" for prefix in names.LINK]
    for p in model.base.standard:
        if p.name in load or not (p.inertial and p.prefix in names.LINK):
            values.setdefault(p.name, 0.0)
    known = {*model.base.names, *(p.name for p in model.base.standard)}
    return {name: value for name, value in values.items() if name in known}


def values_of_file(robot: Any, model: Model) -> FloatArray | None:
    """Return the base parameters (p,) that a robot's own file has; None where it has none.

    They are in a URDF, MJCF or .par itself, and in NAME_parameters.toml beside the robot.toml of
    `symgen import`. A rotor inertia or friction that the file lacks is 0.

    Args:
        robot: path of the robot's file; of anything else there are no values.
        model: model of the robot.
    """
    if not isinstance(robot, (str, Path)) or not Path(robot).is_file():
        return None  # a name of the library has no file
    path = Path(robot)
    beside = path.with_name(f"{model.robot.name}_parameters.toml")
    try:
        if path.suffix.lower() in FORMATS:
            values = cad_parameters(path, model)
        elif beside.is_file():
            found = {name: value for name, (value, _) in read_named(beside, model).items()}
            values = _with_drives(found, model)
        else:
            return None
        return base_values(values, model, str(path))
    except SymgenError:
        return None


def _undeclared(name: str, value: float, robot: Robot) -> bool:
    """Whether a parameter is a 0 of a rotor or a friction that the robot does not have.

    Files of `import` contain them, even if robot.toml no longer declares them.
    """
    prefix = name.rstrip("0123456789")
    number = name[len(prefix) :]
    drive = prefix in (names.ROTOR, *names.FRICTION.values())
    return drive and value == 0 and number in {str(joint.number) for joint in robot.joints}


def with_fixed_links(robot: Robot, imported: Robot, where: str | Path) -> Robot:
    """Return a robot with the fixed links of a file in which the same joints move.

    Joints of the file may be fixed in the robot. Fixed links behind all joints that move may
    differ: their bodies are part of the links that carry them.

    Raises:
        ParameterError: the frame of a joint is another one.
    """
    count = imported.moving[-1].number
    theirs, ours = imported.with_values().joints[:count], robot.with_values().joints
    behind = [joint for joint in ours[count:] if not joint.fixed]
    for a, b in zip(theirs, ours, strict=False):
        keys = ["antecedent", "gamma", "b", "alpha", "d"]
        if a.sigma == b.sigma or not b.fixed:
            keys += ["sigma", "theta", "r"]
        else:  # it stands somewhere along its axis
            keys.append("r" if a.turns else "theta")
        if any(abs(float(getattr(a, key) - getattr(b, key))) > _SAME for key in keys):
            behind.append(b)
    if behind or len(ours) < count:
        what = "its joints are not those"
        if behind:
            what = f"the frame of {robot.label(behind[0].number)} is not that"
        raise ParameterError(
            f"{where}: {what} of {robot.name}; accepted: the file that the robot was "
            "imported from, or one in which the same joints move in the same frames"
        )
    return replace(robot, joints=(*robot.joints[:count], *imported.joints[count:]))


def mass_matrices(evaluator: Evaluator, q: FloatArray, X: FloatArray) -> FloatArray:
    """Return M at some positions, (N, n, n): columns of inverse dynamics from rest.

    Args:
        evaluator: the compiled model, with inverse_dynamics.
        q: (N, n) positions.
        X: (p,) base parameters.
    """
    n = q.shape[1]
    M = np.empty((len(q), n, n))
    zero = np.zeros_like(q)
    base = np.zeros((len(names.BASE) if evaluator.model.robot.imu else 0, len(q), 3))
    still = torque_at(evaluator, X, q, zero, zero, *base)
    for j in range(n):
        unit = zero.copy()
        unit[:, j] = 1.0
        M[:, :, j] = torque_at(evaluator, X, q, zero, unit, *base) - still
    return M


def link_columns(model: Model, link: int) -> list[int]:
    """Return the indices of the ten parameters of a link among the standard ones."""
    place = {p.name: k for k, p in enumerate(model.base.standard)}
    return [place[f"{prefix}{link}"] for prefix in names.LINK]


def is_finite(value: Any) -> bool:
    """Whether a value is a number that is finite in double precision."""
    number = isinstance(value, (int, float, np.number)) and not isinstance(value, bool)
    return number and bool(abs(value) <= sys.float_info.max)


def base_values(
    given: Mapping[str, Any], model: Model, where: str, partial: bool = False
) -> FloatArray:
    """Return X (p,) from base or standard parameters by name; standard ones are regrouped.

    Args:
        given: names and values.
        model: model of the robot.
        where: name of the source in error messages.
        partial: whether missing parameters become NaN instead of an error.

    Raises:
        ParameterError: a name is unknown or missing, or a value is not a finite number.
    """
    for name, value in given.items():
        if not is_finite(value):
            raise ParameterError(f"{where}: {name} is {value!r}; accepted: a finite number")
    base, standard = model.base, [p.name for p in model.base.standard]
    known = {*standard, *base.names}
    given = {k: v for k, v in given.items() if k in known or not _undeclared(k, v, model.robot)}
    unknown = sorted(set(given) - known)
    if unknown:
        raise ParameterError(
            f"{where}: {', '.join(unknown[:5])} is no parameter of {model.robot.name}; accepted: "
            f"{', '.join(base.names[:8])}, ... or standard parameters"
        )
    X, s = (np.array([float(given.get(n, np.nan)) for n in own]) for own in (base.names, standard))
    G = regrouping(model) if np.isnan(X).any() else np.zeros((len(X), len(s)))
    X = np.where(np.isnan(X), np.sum(np.where(G == 0, 0.0, G * s), axis=1), X)
    for name in () if partial else np.array(base.names)[np.isnan(X)]:
        row = G[base.names.index(name)]
        missing = [n for n, g in zip(standard, row, strict=True) if g and n not in given]
        raise ParameterError(
            f"{where}: {name} is missing, and {', '.join(missing[:5])} to regroup it from"
        )
    return X


#: Standard deviation of a prior value that has none, as a share of the value ...
SHARE = 0.3
#: ... which counts as at least this share of the largest of its unit.
_LEAST = 0.1


def read_prior(path: str | Path, model: Model) -> Prior:
    """Read a prior for the base parameters.

    A base parameter has a prior if the file has it, or all standard parameters that it contains.
    The others are free. Standard deviations come from an estimate.json. Otherwise they are 30 % of
    the value, or 3 % of the largest value of the same unit if that is more. Parameters that a .urdf
    does not define (rotor inertia, friction of 0) have no prior, nor do base parameters with them.

    Args:
        path: an estimate.json, TOML with [parameters] (base or standard ones), or the .urdf that
            the robot was imported from.
        model: model of the robot.

    Raises:
        ParameterError: the file cannot be read, or has no parameter of this robot.
    """
    path = Path(path)
    pairs = read_named(path, model)
    if path.suffix.lower() in FORMATS:
        links = {p.name for p in model.base.standard if p.inertial and p.prefix in names.LINK}
        pairs = {name: own for name, own in pairs.items() if own[0] or name in links}
    given = {name: value for name, (value, _) in pairs.items()}
    values = base_values(given, model, str(path), partial=True)
    known = np.isfinite(values)
    if not known.any():
        raise ParameterError(f"{path}: it gives no base parameter of {model.robot.name}")
    units = np.array([p.unit for p in model.base.parameters])
    size = np.where(known, np.abs(values), 0.0)
    largest = np.array([size[units == unit].max() for unit in units])
    share = SHARE * np.maximum(size, _LEAST * largest)
    std = np.where(known & (share > 0), share, np.inf)
    for k in np.flatnonzero(known):
        own = pairs.get(model.base.names[k], (None, None))[1]
        if is_finite(own) and own > 0:
            std[k] = own
    return Prior(np.where(known, values, 0.0), std)

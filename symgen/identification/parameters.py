"""Read parameter values from files: TOML with [parameters], an estimate.json, or a robot file."""

from __future__ import annotations

import math
import re
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
from symgen.faults.fault import IMU, Fault, shifted_imu, shifted_torques
from symgen.files import load_json, load_toml
from symgen.identification.estimate import MARKER, READ, Estimate, read_estimate
from symgen.robot.imported import FORMATS
from symgen.robot.toml_io import read_imported
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator
from symgen.schemas import from_json, result_file

#: Name of the file of parameters in the folder of a diagnosis.
PARAMETERS = "parameters.toml"
#: Units of torques and forces.
TORQUES = ("N m", "N")
_TORQUES = re.compile(r"tau|tau\d+(, tau\d+)*")
_SAME = 1e-6  # m or rad, tolerance between the frames of two files of one robot


@dataclass(frozen=True, eq=False)
class KnownParameters:
    """Parameters that are an input of a command.

    Attributes:
        file: file of the parameters.
        X: (p,) base parameters.
        estimate: estimate in that file; None for TOML and robot files.
        band: filters of the run that estimated the parameters; None if the file has none.
        shifts: shifts of the torques and of the IMU of all logs in that run.
        drives: (n,) torque of each drive per unit of its input in that run; None for logs of
            torques.
    """

    file: Path
    X: FloatArray
    estimate: Estimate | None = None
    band: Band | None = None
    shifts: tuple[Fault, ...] = ()
    drives: FloatArray | None = None


def read_known(path: str | Path, model: Model) -> KnownParameters:
    """Read the base parameters of a model, and their estimate if there is one.

    Args:
        path: a path as for `read_parameters`.
        model: model of the robot.

    Raises:
        ParameterError: as `read_parameters`, or the estimate is damaged.
    """
    X, file = read_parameters(path, model), parameters_file(path)
    if file.suffix == ".json":
        estimate = read_estimate(file)
        drives = known_torques(estimate)
        return KnownParameters(file, X, estimate, estimate.band, estimate.shifts, drives)
    if file.suffix != ".toml":
        return KnownParameters(file, X)
    content = load_toml(file.read_text(encoding="utf-8-sig"))
    band = content.get("band")
    filters = from_json(Band, band, file) if isinstance(band, dict) else None
    return KnownParameters(file, X, None, filters, _shifts(content, file))


def parameters_file(path: str | Path) -> Path:
    """Return the path of a file, or estimate.json or else parameters.toml of a folder."""
    file = result_file(path, MARKER)
    diagnosed = file.with_name(PARAMETERS)
    return diagnosed if Path(path).is_dir() and not file.exists() and diagnosed.exists() else file


def _shifts(content: Mapping[str, Any], file: Path) -> tuple[Fault, ...]:
    """Return the table [delays] of a TOML file that `diagnose` wrote, as repairs.

    Raises:
        ParameterError: the table is damaged.
    """
    delays = content.get("delays", {})
    known = isinstance(delays, dict) and all(
        (channel == IMU or _TORQUES.fullmatch(channel)) and isinstance(seconds, float)
        for channel, seconds in delays.items()
    )
    if not known:
        what = (
            "accepted: torque channels, or imu, with seconds, such as tau = 0.01 or "
            '"tau1, tau3" = 0.02'
        )
        raise ParameterError(f"{file}: damaged at [delays]; {what}")
    return tuple(
        shifted_imu(delay) if channel == IMU else shifted_torques(channel, delay)
        for channel, delay in delays.items()
    )


def read_parameters(path: str | Path, model: Model) -> FloatArray:
    """Read the base parameters X (p,) of a model.

    Args:
        path: one of

            - the folder that `identify` or `diagnose` wrote, or the estimate.json in it;
            - a TOML file with a table [parameters] of base parameters (`ZZ1R = 1.7`), or of
              standard parameters (`ZZ1 = 1.2`), which symgen regroups;
            - the robot file from which the robot was imported, for example a .urdf, whose inertias
              are standard parameters.
        model: model of the robot.

    Raises:
        ParameterError: symgen cannot read the file, or a parameter is unknown, missing or not a
            number.
    """
    values, _ = read_named(Path(path), model)
    if model.robot.payload is not None:  # the file may be of the robot without [payload]
        values = {f"{prefix}L": 0.0 for prefix in names.LINK} | values
    return base_values(values, model, str(path))


def read_values(path: str | Path, model: Model) -> Values:
    """Read the parameters of a package: X, and standard parameters if the file has all of them.

    Args:
        path: a path as for `read_parameters`.
        model: model of the robot.

    Raises:
        ParameterError: as `read_known` and `estimate_values`.
    """
    known = read_known(path, model)
    if known.estimate is not None:
        return replace(estimate_values(known.estimate), X=tuple(known.X.tolist()))
    named = read_named(Path(path), model)
    source = f"From {Path(path).name}."
    return named_values(known.X.tolist(), *named, model.base, [source])


def known_torques(estimate: Estimate) -> FloatArray | None:
    """Return the torque of each drive per unit of its input, (n,); None for logs of torques."""
    torque = np.array([drive.torque for drive in estimate.drives])
    return torque if len(torque) else None


def estimate_values(estimate: Estimate) -> Values:
    """Return the values of an estimate for a package, with verdict, headline and provenance.

    Raises:
        ParameterError: the values are not finite, or are not possible though the method is
            constrained.
    """
    if estimate.method.startswith("consistent") and estimate.possible is False:
        raise ParameterError(
            f"{estimate.robot}: not exported, the parameters are not physically possible: "
            f"{estimate.physical.text}"
        )
    bad = [p.name for p in estimate.parameters if not math.isfinite(p.value)]
    if bad:
        raise ParameterError(f"{', '.join(bad[:5])}: not finite, and cannot be written in C")
    facts = (
        f"Identified by symgen with the {estimate.model} model, method {estimate.method}.",
        f"Verdict: {estimate.verdict}.",
        *estimate.sentences,
        f"Physical consistency: {estimate.physical.text}.",
        *_torque_units(estimate),
        *(f"{key}: {value}" for key, value in estimate.provenance),
    )
    return Values(
        tuple(p.value for p in estimate.parameters),
        tuple(p.std if math.isfinite(p.std) else None for p in estimate.parameters),
        facts=facts,
        units=tuple(p.unit for p in estimate.parameters),
        drives=tuple((drive.torque, drive.unit) for drive in estimate.drives),
    )


def _torque_units(estimate: Estimate) -> list[str]:
    """Return a line on the joints whose torques are counted in the input of a drive."""
    others = [f"{j.label}: {j.unit}" for j in estimate.joints if j.unit not in TORQUES]
    return [f"All functions count torques in these units: {', '.join(others)}."] if others else []


def read_named(path: Path, model: Model) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the values of the parameters in a file by name, and their standard deviations.

    Raises:
        ParameterError: symgen cannot read the file, or it is of another robot.
    """
    if path.suffix.lower() in FORMATS:
        return cad_parameters(path, model), {}
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
        return table, {}
    if not isinstance(table, list) or content.get("schema") not in READ:
        raise ParameterError(f"{path}: not an estimate; accepted: schema {READ[0]}")
    if not all(isinstance(p, dict) and {"name", "value"} <= set(p) for p in table):
        raise ParameterError(f"{path}: every parameter needs a name and a value")
    if content.get("robot", model.robot.name) != model.robot.name:
        raise ParameterError(
            f"{path}: the estimate is of the robot {content['robot']!r}; accepted: one of "
            f"{model.robot.name!r}"
        )
    values, std = ({str(p["name"]): p.get(key) for p in table} for key in ("value", "std"))
    return values, std


def cad_parameters(path: Path, model: Model) -> dict[str, float]:
    """Return the parameter values of a robot file of another program.

    A missing rotor inertia or friction is 0.

    Raises:
        ParameterError: the file has no parameters, or its frames are not those of the model.
    """
    imported = read_imported(path, model.robot.base)
    if not imported.parameters:
        raise ParameterError(f"{path}: it holds no values of parameters")
    robot = with_fixed_links(model.robot, imported.robot, path)
    values = dict(imported.parameters)
    if robot == model.robot:
        return _with_drives(values, model)
    there = derive(robot)
    X = base_values(_with_drives(values, there), there, str(path))
    return dict(zip(model.base.names, X, strict=True))


def _with_drives(values: dict[str, Any], model: Model) -> dict[str, Any]:
    """Return the values of the parameters of a model; missing ones of drives and payload are 0."""
    load = [f"{prefix}L" for prefix in names.LINK]
    for p in model.base.standard:
        if p.name in load or not (p.inertial and p.prefix in names.LINK):
            values.setdefault(p.name, 0.0)
    known = {*model.base.names, *(p.name for p in model.base.standard)}
    return {name: value for name, value in values.items() if name in known}


def values_of_file(robot: Any, model: Model) -> FloatArray | None:
    """Return the base parameters (p,) in a robot file; None if it has none.

    A URDF, MJCF or .par contains the values. `symgen import` writes them to NAME_parameters.toml in
    the folder of robot.toml. A missing rotor inertia or friction is 0.

    Args:
        robot: path of the robot file; anything else has no values.
        model: model of the robot.
    """
    if not isinstance(robot, (str, Path)) or not Path(robot).is_file():
        return None  # a name of the library has no file
    path = Path(robot)
    imported = path.with_name(f"{model.robot.name}_parameters.toml")
    try:
        if path.suffix.lower() in FORMATS:
            values = cad_parameters(path, model)
        elif imported.is_file():
            values = _with_drives(read_named(imported, model)[0], model)
        else:
            return None
        return base_values(values, model, str(path))
    except SymgenError:
        return None


def _undeclared(name: str, value: float, robot: Robot) -> bool:
    """Whether a parameter is 0 and belongs to a rotor or friction that the robot does not declare.

    The file that `symgen import` wrote may have such values, because the user can edit robot.toml.
    """
    prefix = name.rstrip("0123456789")
    number = name[len(prefix) :]
    drive = prefix in (names.ROTOR, *names.FRICTION.values())
    return drive and value == 0 and number in {str(joint.number) for joint in robot.joints}


def with_fixed_links(robot: Robot, imported: Robot, where: str | Path) -> Robot:
    """Return a robot with the fixed links of an imported robot.

    The robot may fix joints that move in the file. Fixed links after the last moving joint may
    differ, because their bodies are part of the links that carry them.

    Args:
        robot: the robot.
        imported: the robot of the file.
        where: path of the file, for messages.

    Raises:
        ParameterError: the frames of a joint differ.
    """
    count = max((joint.number for joint in imported.moving), default=0)
    theirs, ours = imported.with_values().joints[:count], robot.with_values().joints
    behind = [joint for joint in ours[count:] if not joint.fixed]
    for a, b in zip(theirs, ours, strict=False):
        keys = ["antecedent", "gamma", "b", "alpha", "d"]
        if a.sigma == b.sigma or not b.fixed:
            keys += ["sigma", "theta", "r"]
        else:  # the robot may fix the joint at any position
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
    """Return the mass matrix M at some positions, (N, m, m), from inverse dynamics at rest.

    Args:
        evaluator: the compiled model, with inverse_dynamics.
        q: (N, n) positions.
        X: (p,) base parameters.
    """
    robot = evaluator.model.robot
    m, free = len(robot.kinds), len(robot.free)
    M = np.empty((len(q), m, m))
    zero = np.zeros_like(q)
    base = np.zeros((len(names.BASE) if robot.imu else 0, len(q), 3))
    still = torque_at(evaluator, X, q, zero, zero, *base)
    for j in range(m):
        unit, moved = zero.copy(), base.copy()
        if j < free:
            linear = j < free // 2
            moved[names.BASE.index("f" if linear else "wd"), :, j % 3] = 1.0
        else:
            unit[:, j - free] = 1.0
        M[:, :, j] = torque_at(evaluator, X, q, zero, unit, *moved) - still
    return M


def link_columns(model: Model, link: int) -> list[int]:
    """Return the indices of the ten parameters of a link among the standard parameters."""
    place = {p.name: k for k, p in enumerate(model.base.standard)}
    return [place[f"{prefix}{link}"] for prefix in names.LINK]


def is_finite(value: Any) -> bool:
    """Whether a value is a number that is finite in double precision."""
    number = isinstance(value, (int, float, np.number)) and not isinstance(value, bool)
    return number and bool(abs(value) <= sys.float_info.max)


def base_values(
    named: Mapping[str, Any], model: Model, where: str, partial: bool = False
) -> FloatArray:
    """Return X (p,) from base or standard parameters by name, and regroup standard ones.

    Args:
        named: values by name.
        model: model of the robot.
        where: name of the source in error messages.
        partial: whether missing parameters become NaN instead of an error.

    Raises:
        ParameterError: a name is unknown or missing, or a value is not a finite number.
    """
    for name, value in named.items():
        if not is_finite(value):
            raise ParameterError(f"{where}: {name} is {value!r}; accepted: a finite number")
    base, standard = model.base, [p.name for p in model.base.standard]
    known = {*standard, *base.names}
    robot = model.robot
    named = {k: v for k, v in named.items() if k in known or not _undeclared(k, v, robot)}
    unknown = sorted(set(named) - known)
    if unknown:
        of_result = Path(where) / "robot.toml"  # of a result folder
        how = f"; or {of_result} as the robot" if of_result.is_file() else ""
        raise ParameterError(
            f"{where}: {', '.join(unknown[:5])} is no parameter of {model.robot.name}; accepted: "
            f"{', '.join(base.names[:8])}, ... or standard parameters{how}"
        )
    X = np.array([float(named.get(n, np.nan)) for n in base.names])
    s = np.array([float(named.get(n, np.nan)) for n in standard])
    G = regrouping(model) if np.isnan(X).any() else np.zeros((len(X), len(s)))
    sums = np.sum(np.where(G == 0, 0.0, G * s), axis=1)
    X = np.where(np.isnan(X), sums, X)
    absent = np.isnan(X)
    if absent.any() and not partial:
        needed = (G[absent] != 0).any(axis=0)
        parts = [n for n, used in zip(standard, needed, strict=True) if used and n not in named]
        bases = [n for n, lost in zip(base.names, absent, strict=True) if lost]
        regrouped = "" if parts == bases else f", or {', '.join(parts)} to regroup them from"
        raise ParameterError(
            f"{where}: missing: {', '.join(bases)}{regrouped}; accepted: all parameters of "
            f"{model.robot.name}, as symgen identify finds them with this robot file"
        )
    return X


#: Default standard deviation of a prior value, as a share of the value.
SHARE = 0.3
#: Smallest value for this rule, as a share of the largest value with the same unit.
_LEAST = 0.1


def read_prior(path: str | Path, model: Model) -> Prior:
    """Read a prior for the base parameters.

    A base parameter has a prior if the file has its value, or all standard parameters that it
    contains. The others are free. An estimate.json has standard deviations. For other files, they
    are 30 % of the value, or 3 % of the largest value with the same unit if that is more. A .urdf
    does not define rotor inertia and friction of 0. Base parameters that contain them have no
    prior.

    Args:
        path: an estimate.json, TOML with [parameters] (base or standard ones), or the .urdf from
            which the robot was imported.
        model: model of the robot.

    Raises:
        ParameterError: symgen cannot read the file, or it has no parameter of this robot.
    """
    path = Path(path)
    named, stated = read_named(path, model)
    if path.suffix.lower() in FORMATS:
        links = {p.name for p in model.base.standard if p.inertial and p.prefix in names.LINK}
        named = {name: value for name, value in named.items() if value or name in links}
    values = base_values(named, model, str(path), partial=True)
    known = np.isfinite(values)
    if not known.any():
        raise ParameterError(f"{path}: it gives no base parameter of {model.robot.name}")
    units = np.array([p.unit for p in model.base.parameters])
    size = np.where(known, np.abs(values), 0.0)
    largest = np.array([size[units == unit].max() for unit in units])
    share = SHARE * np.maximum(size, _LEAST * largest)
    std = np.where(known & (share > 0), share, np.inf)
    for k in np.flatnonzero(known):
        of_file = stated.get(model.base.names[k], math.nan)
        if is_finite(of_file) and of_file > 0:
            std[k] = of_file
    return Prior(np.where(known, values, 0.0), std)

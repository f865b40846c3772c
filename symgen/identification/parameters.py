"""Parameter values from files: `[parameters]` in TOML, or an estimate.json."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen import names
from symgen.codegen.model import Model
from symgen.errors import ParameterError
from symgen.estimation.band import Band
from symgen.files import load_json, load_toml
from symgen.identification.estimate import MARKER, READ, Estimate, read_estimate
from symgen.robot.imported import FORMATS
from symgen.robot.toml_io import read_imported
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator
from symgen.schemas import result_file

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Given:
    """Parameters that a command is given.

    Attributes:
        file: where they stand.
        X: (p,) base parameters.
        estimate: the estimate that they come from; None for TOML and URDF files.
    """

    file: Path
    X: FloatArray
    estimate: Estimate | None

    @property
    def band(self) -> Band | None:
        """The band of the estimate; None where there is none."""
        return None if self.estimate is None else self.estimate.band


def read_given(path: str | Path, model: Model) -> Given:
    """Read the base parameters of a model, and the estimate that they come from.

    Args:
        path: what `read_parameters` reads.
        model: whose parameters they are.

    Raises:
        ParameterError: as `read_parameters`, or the estimate is damaged.
    """
    X = read_parameters(path, model)
    file = result_file(path, MARKER)
    return Given(file, X, read_estimate(file) if file.suffix == ".json" else None)


def read_parameters(path: str | Path, model: Model) -> FloatArray:
    """Read the base parameters X (p,) of a model.

    Args:
        path: the folder that `identify` wrote, the estimate.json in it, or a TOML file with a table
            [parameters]: base parameters by name (`ZZ1R = 1.7`), or standard ones (`ZZ1 = 1.2`),
            which are regrouped; or the .urdf that the robot was imported from, whose inertias are
            standard parameters.
        model: whose parameters they are.

    Raises:
        ParameterError: the file cannot be read, or a name is unknown, missing or not a number.
    """
    return base_values(named_values(path, model), model, str(path))


def named_values(path: str | Path, model: Model) -> dict[str, Any]:
    """Return name and value of the parameters in a file that `read_parameters` reads.

    Raises:
        ParameterError: the file cannot be read.
    """
    path = Path(path)
    if path.suffix.lower() in FORMATS:
        return dict(cad_parameters(path, model))
    return {name: value for name, (value, _) in read_named(path, model.robot.name).items()}


def read_named(path: Path, robot: str) -> dict[str, tuple[Any, Any]]:
    """Return value and standard deviation (None where there is none) of what a file names.

    Raises:
        ParameterError: the file cannot be read, or is an estimate of another robot than `robot`.
    """
    path = result_file(path, MARKER)
    try:
        text = path.read_text(encoding="utf-8-sig")
        content = load_json(text) if path.suffix == ".json" else load_toml(text)
    except (OSError, ValueError, RecursionError) as error:
        reason = getattr(error, "strerror", None) or " ".join(str(error).split())[:200]
        raise ParameterError(
            f"{path}: cannot be read ({reason}); accepted: estimate.json, or TOML with [parameters]"
        ) from error
    return _named(content, path, robot)


def cad_parameters(path: Path, model: Model) -> dict[str, float]:
    """Return the parameter values of another program's file, if it has the model's frames.

    A rotor inertia that the file does not give is 0, and so is friction.

    Raises:
        ParameterError: it holds none, or is another robot's.
    """
    found = read_imported(path)
    if not found.parameters:
        raise ParameterError(f"{path}: it holds no values of parameters")
    if not same_frames(found.robot, model.robot):
        raise ParameterError(
            f"{path}: its frames are not those of {model.robot.name}; accepted: the file that the "
            "robot was imported from, and geometry as imported"
        )
    values = dict(found.parameters)
    standard = {p.name: p for p in model.base.standard}
    for name, p in standard.items():
        if not (p.inertial and p.prefix in names.LINK):
            values.setdefault(name, 0.0)
    return {name: value for name, value in values.items() if name in standard}


def _undeclared(name: str, value: float, robot: Robot) -> bool:
    """Whether a parameter is the 0 of a rotor or a friction that the robot has not.

    Files that `import` wrote hold them, also where they were switched off in robot.toml since.
    """
    prefix = name.rstrip("0123456789")
    number = name[len(prefix) :]
    drive = prefix in (names.ROTOR, *names.FRICTION.values())
    return drive and value == 0 and number in {str(joint.number) for joint in robot.joints}


def same_frames(imported: Robot, robot: Robot) -> bool:
    """Whether a robot has the frames of its file; joints of the file may be held still in it."""
    theirs, ours = imported.with_values().joints, robot.with_values().joints
    if len(theirs) != len(ours):
        return False
    for a, b in zip(theirs, ours, strict=True):
        keys = ["antecedent", "gamma", "b", "alpha", "d"]
        if a.sigma == b.sigma:
            keys += ["sigma", "theta", "r"]
        elif b.sigma == names.FIXED:  # it stands somewhere along its axis
            keys.append("r" if a.sigma == names.REVOLUTE else "theta")
        else:
            return False
        if any(getattr(a, key) != getattr(b, key) for key in keys):
            return False
    return True


def _named(content: Any, path: Path, robot: str) -> dict[str, tuple[Any, Any]]:
    """Return name, value and standard deviation of every parameter in a parsed file."""
    if path.suffix == ".json":
        listed = content.get("parameters") if isinstance(content, dict) else None
        if not isinstance(listed, list) or content.get("schema") not in READ:
            raise ParameterError(f"{path}: not an estimate; accepted: schema {READ[0]}")
        if not all(isinstance(p, dict) and {"name", "value"} <= set(p) for p in listed):
            raise ParameterError(f"{path}: every parameter needs a name and a value")
        if content.get("robot", robot) != robot:
            raise ParameterError(
                f"{path}: the estimate is of the robot {content['robot']!r}; accepted: one of "
                f"{robot!r}"
            )
        return {str(p["name"]): (p["value"], p.get("std")) for p in listed}
    table = content.get("parameters")
    if not isinstance(table, dict):
        raise ParameterError(f"{path}: the table [parameters] is missing")
    return {name: (value, None) for name, value in table.items()}


def mass_matrices(evaluator: Evaluator, q: FloatArray, X: FloatArray) -> FloatArray:
    """Return M at some positions, (N, n, n): columns of inverse dynamics from rest.

    Args:
        evaluator: the compiled model, with inverse_dynamics.
        q: (N, n) positions.
        X: (p,) base parameters.
    """
    n = q.shape[1]
    M = np.empty((len(q), n, n))
    inverse, zero = evaluator["inverse_dynamics"], np.zeros_like(q)
    still = inverse(q, zero, zero, X)
    for j in range(n):
        unit = zero.copy()
        unit[:, j] = 1.0
        M[:, :, j] = inverse(q, zero, unit, X) - still
    return M


def link_columns(model: Model, link: int) -> list[int]:
    """Return the places of the ten parameters of a link among the standard ones."""
    place = {p.name: k for k, p in enumerate(model.base.standard)}
    return [place[f"{prefix}{link}"] for prefix in names.LINK]


def regrouping(model: Model) -> FloatArray:
    """Return G (p, s) of X = G s: from standard to base parameters, at the robot's lengths."""
    base, numbers = model.base, model.robot.values()
    place = {p.name: k for k, p in enumerate(base.standard)}
    G = np.zeros((len(base.parameters), len(base.standard)))
    for row, p in enumerate(base.parameters):
        G[row, p.index] = 1.0
        for c, name in p.terms:
            G[row, place[name]] = float(c.subs(numbers).evalf(30))
    return G


def base_values(
    given: Mapping[str, Any], model: Model, where: str, partial: bool = False
) -> FloatArray:
    """Return X (p,) from base or standard parameters by name; standard ones are regrouped.

    Args:
        given: name and value.
        model: whose parameters they are.
        where: what error messages call the source.
        partial: whether a parameter that is missing is NaN.

    Raises:
        ParameterError: a name is unknown or missing, or a value is not a finite number.
    """
    for name, value in given.items():
        number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if not number or not abs(value) <= sys.float_info.max:
            raise ParameterError(f"{where}: {name} is {value!r}; accepted: a finite number")
    base, numbers = model.base, model.robot.values()
    known = {p.name for p in base.standard} | set(base.names)
    given = {k: v for k, v in given.items() if k in known or not _undeclared(k, v, model.robot)}
    unknown = sorted(set(given) - known)
    if unknown:
        raise ParameterError(
            f"{where}: {', '.join(unknown[:5])} is no parameter of {model.robot.name}; accepted: "
            f"{', '.join(base.names[:8])}, ... or standard parameters"
        )
    X = []
    for p in base.parameters:
        if p.name in given:
            X.append(float(given[p.name]))
            continue
        missing = [name for name in (p.head, *(n for _, n in p.terms)) if name not in given]
        if missing and partial:
            X.append(math.nan)
            continue
        if missing:
            raise ParameterError(
                f"{where}: {p.name} is missing, and {', '.join(missing[:5])} to regroup it from"
            )
        terms = (float(c.subs(numbers).evalf(30)) * float(given[n]) for c, n in p.terms)
        X.append(float(given[p.head]) + sum(terms))
    return np.array(X)

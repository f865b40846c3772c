"""A diagnosis from the folder that diagnose wrote."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from symgen.diagnosis.diagnosis import (
    SCHEMA,
    VERDICTS,
    Diagnosis,
    FoundEffect,
    FoundParameter,
    Gap,
    Place,
    Rejected,
)
from symgen.errors import ParameterError
from symgen.estimation.repairs import Repair
from symgen.robot.toml_io import read_robot
from symgen.schemas import from_json, number, or_nan, read_json

MARKER = "diagnosis.json"


def read_diagnosis(path: str | Path) -> Diagnosis:
    """Read a diagnosis again: diagnosis.json, and the extended robot.toml beside it.

    Curves over time are not kept there: `curves` is empty.

    Args:
        path: the folder that `diagnose` wrote, or the diagnosis.json in it.

    Raises:
        ParameterError: there is none, or it is damaged.
        RobotError: robot.toml beside it cannot be read.
    """
    path = Path(path)
    file = path / MARKER if path.is_dir() else path
    content = read_json(file, SCHEMA)
    extended = read_robot(file.with_name("robot.toml"))
    try:
        gap = content["gap"]
        band = content["cutoff_hz"]
        joints = tuple(j.number for j in extended.movable)
        before, after, floor = (_gap(gap[key]) for key in ("before", "after", "noise_floor"))
        lengths = {len(g.per_joint) for g in (before, after, floor)}
        if content["verdict"] not in VERDICTS or lengths != {len(joints)}:
            raise ValueError("verdict or joints")
        return Diagnosis(
            robot=str(content["robot"]),
            verdict=content["verdict"],
            cutoff_hz=None if band is None else number(band),
            before=before,
            after=after,
            floor=floor,
            where=tuple(
                Place(
                    int(p["joint"]),
                    number(p["share"]),
                    str(p["pattern"]),
                    None if p["time_window"] is None else _pair(p["time_window"]),
                )
                for p in content["where"]
            ),
            effects=tuple(map(_effect, content["effects"])),
            rejected=tuple(
                Rejected(str(r["name"]), _joints(r), str(r["reason"])) for r in content["rejected"]
            ),
            advice=tuple(map(str, content["advice"])),
            notes=tuple(map(str, content["notes"])),
            extended=extended,
            joints=joints,
            tried=int(content["candidates_tried"]),
            parameters=tuple(map(_parameter, content["parameters"])),
            repairs=tuple(from_json(Repair, r, file) for r in content.get("repairs", ())),
        )
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise ParameterError(
            f"{file}: damaged ({type(error).__name__}: {' '.join(str(error).split())[:100]}); "
            f"accepted: schema {SCHEMA} as diagnose writes it"
        ) from error


def _effect(content: dict[str, Any]) -> FoundEffect:
    return FoundEffect(
        str(content["name"]),
        _joints(content),
        tuple(map(_parameter, content["parameters"])),
        str(content["expression"]),
        or_nan(content["p_value"]),
        or_nan(content["gap_reduction"]),
        tuple((str(o["name"]), _joints(o)) for o in content["indistinguishable_from"]),
        str(content["separate"]),
        bool(content["in_robot_toml"]),
    )


def _parameter(content: dict[str, Any]) -> FoundParameter:
    return FoundParameter(
        str(content["name"]),
        or_nan(content["value"]),
        or_nan(content["std"]),
        str(content["unit"]),
    )


def _gap(content: dict[str, Any]) -> Gap:
    return Gap(tuple(map(or_nan, content["per_joint"])))


def _joints(content: dict[str, Any]) -> tuple[int, ...]:
    return tuple(map(int, content["joints"]))


def _pair(values: list[Any]) -> tuple[float, float]:
    first, last = map(number, values)
    return first, last

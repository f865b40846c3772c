"""A diagnosis as JSON, and from the folder that diagnose wrote."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from symgen.diagnosis.diagnosis import (
    VERDICTS,
    Diagnosis,
    FoundEffect,
    FoundParameter,
    Gap,
    Place,
    Rejected,
    Work,
    work,
)
from symgen.errors import ParameterError
from symgen.faults.fault import Fault
from symgen.robot.toml_io import read_robot
from symgen.schemas import OrNan, from_json, read_json, result_file, to_json

MARKER = "diagnosis.json"
SCHEMA = "symgen.diagnosis/1"


@dataclass(frozen=True)
class _Gap:
    total: OrNan
    per_joint: tuple[OrNan, ...]


@dataclass(frozen=True)
class _Gaps:
    metric: str
    before: _Gap
    after: _Gap
    noise_floor: _Gap


@dataclass(frozen=True)
class _Alike:
    name: str
    joints: tuple[int, ...]


@dataclass(frozen=True)
class _Effect:
    name: str
    joints: tuple[int, ...]
    parameters: tuple[FoundParameter, ...]
    expression: str
    p_value: OrNan
    gap_reduction: OrNan
    indistinguishable_from: tuple[_Alike, ...]
    separate: str
    in_robot_toml: bool


@dataclass(frozen=True)
class _File:
    robot: str
    verdict: str
    cutoff_hz: float | None
    gap: _Gaps
    energy: Work | None
    where: tuple[Place, ...]
    effects: tuple[_Effect, ...]
    rejected: tuple[Rejected, ...]
    candidates_tried: int
    advice: tuple[str, ...]
    notes: tuple[str, ...]
    parameters: tuple[FoundParameter, ...]
    repairs: tuple[Fault, ...] = ()
    # what stands beside it: the motion under the measured torques, and the files of the folder
    replay: dict[str, Any] | None = field(default=None, metadata={"absent": True})
    digests: dict[str, str] | None = field(default=None, metadata={"absent": True})


def diagnosis_json(d: Diagnosis) -> dict[str, Any]:
    """Return the content of diagnosis.json."""
    gaps = (_Gap(gap.total, gap.per_joint) for gap in (d.before, d.after, d.floor))
    file = _File(
        robot=d.robot,
        verdict=d.verdict,
        cutoff_hz=d.cutoff_hz,
        gap=_Gaps("torque", *gaps),
        energy=work(d.curves),
        where=d.where,
        effects=tuple(
            _Effect(
                e.name,
                e.joints,
                e.parameters,
                e.expression,
                e.p_value,
                e.gap_reduction,
                tuple(_Alike(*other) for other in e.indistinguishable_from),
                e.separate,
                e.declared,
            )
            for e in d.effects
        ),
        rejected=d.rejected,
        candidates_tried=d.tried,
        advice=d.advice,
        notes=d.notes,
        parameters=d.parameters,
        repairs=d.repairs,
    )
    return to_json(file, SCHEMA)


def read_diagnosis(path: str | Path) -> Diagnosis:
    """Read a diagnosis again: diagnosis.json, and the extended robot.toml beside it.

    Curves over time are not kept there: `curves` is empty.

    Args:
        path: the folder that `diagnose` wrote, or the diagnosis.json in it.

    Raises:
        ParameterError: there is none, or it is damaged.
        RobotError: robot.toml beside it cannot be read.
    """
    file = result_file(path, MARKER)
    f = from_json(_File, read_json(file, SCHEMA), file)
    extended = read_robot(file.with_name("robot.toml"))
    joints = tuple(j.number for j in extended.movable)
    before, after, floor = (
        Gap(gap.per_joint) for gap in (f.gap.before, f.gap.after, f.gap.noise_floor)
    )
    sizes = {len(gap.per_joint) for gap in (before, after, floor)}
    if f.verdict not in VERDICTS or sizes != {len(joints)}:
        what = f"verdict {f.verdict!r}" if f.verdict not in VERDICTS else "gap.per_joint"
        raise ParameterError(
            f"{file}: damaged at {what}; accepted: schema {SCHEMA} as diagnose writes it"
        )
    return Diagnosis(
        robot=f.robot,
        verdict=f.verdict,
        cutoff_hz=f.cutoff_hz,
        before=before,
        after=after,
        floor=floor,
        where=f.where,
        effects=tuple(map(_effect, f.effects)),
        rejected=f.rejected,
        advice=f.advice,
        notes=f.notes,
        extended=extended,
        joints=joints,
        tried=f.candidates_tried,
        parameters=f.parameters,
        repairs=f.repairs,
    )


def _effect(e: _Effect) -> FoundEffect:
    return FoundEffect(
        e.name,
        e.joints,
        e.parameters,
        e.expression,
        e.p_value,
        e.gap_reduction,
        tuple((other.name, other.joints) for other in e.indistinguishable_from),
        e.separate,
        e.in_robot_toml,
    )

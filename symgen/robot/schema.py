"""The shape of robot.toml, validated by pydantic: keys and types, before any meaning."""

from __future__ import annotations

from decimal import Decimal
from typing import Annotated, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

_MAX_JOINTS = 200


def _number_or_text(value: object) -> object:
    if isinstance(value, bool) or not isinstance(value, (int, Decimal, float, str)):
        raise ValueError("a number or an expression in quotes")
    return value


def _number(value: object) -> object:
    if isinstance(value, bool) or not isinstance(value, (int, Decimal, float)):
        raise ValueError("a number")
    return value


def _integer(value: object) -> object:
    if isinstance(value, bool) or not isinstance(value, int):
        raise ValueError("an integer")
    return value


Scalar = Annotated[int | Decimal | str, BeforeValidator(_number_or_text)]
Finite = Annotated[float, BeforeValidator(_number), Field(allow_inf_nan=False)]
Integer = Annotated[int, BeforeValidator(_integer)]
Positive = Annotated[Finite, Field(gt=0)]


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=False, arbitrary_types_allowed=True)


class RobotTable(_Table):
    name: str
    convention: Literal["modified-dh"] = "modified-dh"
    gravity: tuple[Scalar, Scalar, Scalar] = (0, 0, Decimal("-9.81"))


class JointTable(_Table):
    sigma: Annotated[Integer, Field(ge=0, le=2)] = 0
    antecedent: Annotated[Integer, Field(ge=0)] | None = None
    gamma: Scalar = 0
    b: Scalar = 0
    alpha: Scalar = 0
    d: Scalar = 0
    theta: Scalar = 0
    r: Scalar = 0
    friction: list[Literal["coulomb", "viscous", "offset"]] | None = None
    coulomb_width: Annotated[Finite, Field(ge=0)] = 0.0
    rotor_inertia: bool | None = None


class CouplingTable(_Table):
    joints: tuple[Integer, Integer]
    ratio: Scalar = 1


class PayloadTable(_Table):
    joint: Annotated[Integer, Field(ge=1)]


class LimitsTable(_Table):
    position: list[tuple[Finite, Finite]] | None = None
    velocity: list[Positive] | None = None
    acceleration: list[Positive] | None = None
    torque: list[Positive] | None = None


class RobotFile(_Table):
    robot: RobotTable
    geometry: dict[str, Scalar] = Field(default_factory=dict)
    joint: Annotated[list[JointTable], Field(min_length=1, max_length=_MAX_JOINTS)]
    coupling: list[CouplingTable] = Field(default_factory=list)
    payload: PayloadTable | None = None
    limits: LimitsTable | None = None
    drive: object = None
    effect: object = None
    loop: object = None

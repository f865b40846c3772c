"""The load of an arm as a result: mass, centre of mass and inertia with their precision."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np

from symgen import names
from symgen.errors import IdentificationError
from symgen.estimation.band import Band
from symgen.estimation.values import Residual, Trace
from symgen.faults.fault import Fault
from symgen.identification.curves import FILE, read_traces
from symgen.identification.estimate import JointLabel, equation_titles
from symgen.identification.load import COM, LABELS, Load, read_off
from symgen.names import joint_label
from symgen.policy import BEYOND
from symgen.schemas import BESIDE, OPTIONAL, Size, SizeOrNan, read_result, result_file, to_json
from symgen.views import Viewable

SCHEMA = "symgen.payload/1"
MARKER = "payload.json"
#: Quantities of the traces: torque of a model without the load, and of one with it.
WITHOUT, WITH = "torque without the load", "torque with the load"


@dataclass(frozen=True)
class Quantity:
    """A value with its standard deviation; both are None if the logs do not determine it."""

    value: float | None = None
    std: Size | None = None


@dataclass(frozen=True)
class Sensor:
    """What a sensor at the wrist shows besides the load; channels wfx wfy wfz wnx wny wnz.

    Attributes:
        offset: offset of each channel at the end of the last log, N and N m.
        drift: its change over this log; without a value where the logs show none.
        turned: whether the sensor reports the opposite wrench, so that symgen turned it.
        load: XX XY XZ YY YZ ZZ MX MY MZ M about the origin of the frame, an argument of the kernel
            tool_wrench; directions that the logs leave open are those of a small body.
        torques: mass, centre of mass and inertia from the joint torques of the same logs, in the
            order of `Payload.rows`; None if the robot without the load is not known.
    """

    offset: tuple[Quantity, ...]
    drift: tuple[Quantity, ...]
    turned: bool
    load: tuple[float, ...]
    torques: tuple[Quantity, ...] | None = None


@dataclass(frozen=True)
class LoadErrors:
    """Torque error of joints in motion, ||tau - model|| / ||tau||, on the logs with the load.

    Attributes:
        before, after: error of the model without the load, and with it.
        noise_floor: error that noise alone causes; NaN if unknown.
        joints_before, joints_after: `before` and `after` of each joint.
        floating: both errors with those of force and moment on a floating base; None for others.
    """

    before: Size
    after: Size
    noise_floor: SizeOrNan
    joints_before: tuple[Size, ...]
    joints_after: tuple[Size, ...]
    floating: Annotated[tuple[Residual, Residual] | None, OPTIONAL] = None


@dataclass(frozen=True, kw_only=True)
class Payload(Viewable):
    """The load of a robot, in the frame of a link.

    Attributes:
        robot: name of the robot.
        frame: name of the frame of com and inertia, or the number of `joint` for that of its link.
        mass: mass, kg.
        com: centre of mass (3), m.
        inertia: XX XY XZ YY YZ ZZ about the centre of mass, kg m2; XY is the matrix entry.
        identifiable: names of the quantities that the logs determine: mass, cx cy cz, XX .. ZZ.
        gain_uncertainty_percent: standard deviation of the gains of the drives, which is part of
            std; None if unknown.
        residual: torque errors without and with the load in the model.
        method: a text on the method.
        band: the filters of the run.
        repairs: repairs of the logs.
        notes: texts about the run.
        joints: number, unit and name of each movable joint.
        joint: number of the joint whose link carries the load; 0 for the base.
        sensor: for a load from the wrench of a sensor, what else it shows. `residual` is then that
            of its force, without the offset, and `joints` is empty.
        traces: measured and modelled torque of each log with the load, for the quantities WITHOUT
            and WITH the load; none for a load by a sensor.
    """

    GONE: ClassVar = ("gains",)

    robot: str
    frame: int | str
    mass: Quantity
    com: tuple[Quantity, Quantity, Quantity]
    inertia: tuple[Quantity, Quantity, Quantity, Quantity, Quantity, Quantity]
    identifiable: tuple[str, ...]
    gain_uncertainty_percent: Size | None
    residual: LoadErrors
    method: str
    band: Band
    repairs: tuple[Fault, ...]
    notes: tuple[str, ...]
    joints: tuple[JointLabel, ...]
    joint: int
    sensor: Annotated[Sensor | None, OPTIONAL] = None
    traces: Annotated[tuple[Trace, ...], BESIDE] = ()

    def __repr__(self) -> str:
        """Return robot and mass."""
        mass = "not determined" if self.mass.value is None else f"{self.mass.value:.4g} kg"
        return f"<Payload of {self.robot} on {self.link}: mass {mass}>"

    @property
    def link(self) -> str:
        """Name in results of the joint whose link carries the load."""
        labels = {joint.number: joint.label for joint in self.joints} | {0: joint_label(0, "base")}
        return labels.get(self.joint, str(self.joint))

    @property
    def titles(self) -> list[str]:
        """Titles of the columns of the traces."""
        return equation_titles(self.joints, (self.residual.floating or (Residual(0.0),))[-1])

    @property
    def frame_label(self) -> str:
        """Name in results of the frame of the load."""
        return self.frame if isinstance(self.frame, str) else self.link

    def to_json(self) -> dict[str, Any]:
        """Return the content of payload.json."""
        return to_json(self, SCHEMA)

    def rows(self) -> list[tuple[str, Quantity, str]]:
        """Return name, quantity and unit of every number."""
        out = [("mass", self.mass, "kg")]
        out += [(name, q, "m") for name, q in zip(COM, self.com, strict=True)]
        out += [(name, q, "kg m2") for name, q in zip(names.INERTIA, self.inertia, strict=True)]
        return out


def read_payload(path: str | Path) -> Payload:
    """Read a payload from payload.json.

    Args:
        path: the folder that `payload` wrote, or the payload.json in it.

    Raises:
        ParameterError: there is no payload.json, or it is damaged.
    """
    file = result_file(path, MARKER)
    found = read_result(Payload, file, SCHEMA, traces=())
    return replace(found, traces=read_traces(file.with_name(FILE), len(found.titles)))


def payload_of(
    body: Load, mass: float | None, gain: float | None, notes: tuple[str, ...], **more: Any
) -> Payload:
    """Return the payload of a load.

    Args:
        body: the load of the equations.
        mass: known mass, kg; None if unknown.
        gain: standard deviation of the gains of the drives, in percent; None if unknown.
        notes: texts about the run.
        more: the other attributes of the payload.
    """
    values, doubts = _quantities(body, mass, (gain or 0.0) / 100)
    body_mass, x, y, z, xx, xy, xz, yy, yz, zz = values
    return Payload(
        mass=body_mass,
        com=(x, y, z),
        inertia=(xx, xy, xz, yy, yz, zz),
        identifiable=tuple(n for n, q in zip(LABELS, values, strict=True) if q.std is not None),
        gain_uncertainty_percent=gain,
        notes=notes + doubts,
        **more,
    )


def require_mass(
    body: Load, link: str, how: str = "logs in which it is turned against gravity, or --mass"
) -> None:
    """Refuse a load whose mass the logs do not show.

    Args:
        body: the load of the equations.
        link: name of the link.
        how: logs that determine the mass.

    Raises:
        IdentificationError: the mass is not determined, or below 3 standard deviations.
    """
    if "mass" not in body.determined():
        raise IdentificationError(
            f"the logs do not determine the mass of a load on the link of {link}; accepted: {how}"
        )
    mass, std = read_off(body.s)[0], body.std()[0]
    if mass < BEYOND * std:
        raise IdentificationError(
            f"the logs show no load on the link of {link}: its mass is {mass:.3g} kg with a "
            f"standard deviation of {std:.3g} kg; accepted: logs recorded with the load"
        )


def _quantities(
    estimated: Load, mass: float | None, gain: float
) -> tuple[list[Quantity], tuple[str, ...]]:
    """Return mass, centre of mass and inertia of the nearest possible load, and notes.

    A moment or product of inertia is determined if its noise is below the largest moment that is
    beyond its own noise.

    Args:
        estimated: the load of the equations.
        mass: known mass, kg; None if unknown.
        gain: relative standard deviation of the gains of the drives, which scale masses and
            inertias.
    """
    body, notes = estimated.nearest(mass), list[str]()
    if body is not estimated:
        notes.append("the load is the most probable one that is physically possible")
    values, std, known = read_off(body.s), estimated.std(), estimated.determined()
    scaled = np.array([1.0, 0, 0, 0, *[1.0] * 6])
    if mass is not None:
        std[0] = scaled[0] = 0.0
    std = np.hypot(std, gain * scaled * np.abs(values))
    sure = np.where(values > BEYOND * std, values, 0.0)
    inertia = sure[-len(names.INERTIA) :].max()  # products are smaller than moments
    out = []
    for name, value, deviation in zip(LABELS, values.tolist(), std.tolist(), strict=True):
        shown = name in known and (name not in names.INERTIA or BEYOND * deviation < inertia)
        out.append(Quantity(value, deviation) if shown else Quantity())
    return out, tuple(notes)

"""What `payload` finds: a load with the precision of every number, and the drives' gains."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from symgen import names
from symgen.estimation.band import Band
from symgen.estimation.repairs import Repair
from symgen.identification.load import COM
from symgen.schemas import from_json, read_json, result_file, to_json

SCHEMA = "symgen.payload/1"
MARKER = "payload.json"


@dataclass(frozen=True)
class Quantity:
    """A value with its standard deviation; both None where the logs do not determine it."""

    value: float | None
    std: float | None


@dataclass(frozen=True)
class Left:
    """What is left of the torque, ||tau - model|| / ||tau||, of the logs with the load.

    Attributes:
        before: without the load in the model.
        after: with it.
    """

    before: float
    after: float


@dataclass(frozen=True)
class Payload:
    """What the arm carries, in the frame of a link.

    Attributes:
        robot: its name.
        frame: number of the joint whose link carries the load, and in whose frame it is given.
        mass: kg.
        com: centre of mass (3), m.
        inertia: XX XY XZ YY YZ ZZ about the centre of mass, kg m2; XY is the matrix entry.
        identifiable: names of what the logs determine, of mass, cx cy cz, XX .. ZZ.
        gain_uncertainty_percent: of the drives' gains, which is part of std; None: not given.
        residual: what is left of the torque without and with the load.
        method: in words.
        band: the filters of the run; None for still poses, which pass none.
        repairs: what was mended in the logs.
        notes: what was done, in words.
        gains: of the drives, joint by joint, where the load calibrated them: torque over what the
            log makes of it.
    """

    robot: str
    frame: int
    mass: Quantity
    com: tuple[Quantity, Quantity, Quantity]
    inertia: tuple[Quantity, Quantity, Quantity, Quantity, Quantity, Quantity]
    identifiable: tuple[str, ...]
    gain_uncertainty_percent: float | None
    residual: Left
    method: str
    band: Band | None
    repairs: tuple[Repair, ...]
    notes: tuple[str, ...]
    gains: tuple[Quantity, ...] = ()

    def __repr__(self) -> str:
        """Return robot and mass."""
        mass = "not determined" if self.mass.value is None else f"{self.mass.value:.4g} kg"
        return f"<Payload of {self.robot} on joint {self.frame}: mass {mass}>"

    def to_json(self) -> dict[str, Any]:
        """Return the content of payload.json."""
        return to_json(self, SCHEMA)

    def rows(self) -> list[tuple[str, Quantity, str]]:
        """Return name, quantity and unit of every number."""
        inertia = zip(names.INERTIA, self.inertia, strict=True)
        gains = enumerate(self.gains, 1)
        return [
            ("mass", self.mass, "kg"),
            *((name, q, "m") for name, q in zip(COM, self.com, strict=True)),
            *((name, q, "kg m2") for name, q in inertia),
            *((f"gain of movable joint {j}", q, "") for j, q in gains),
        ]


def read_payload(path: str | Path) -> Payload:
    """Read a payload again.

    Args:
        path: the folder that `payload` wrote, or the payload.json in it.

    Raises:
        ParameterError: there is none, or it is damaged.
    """
    file = result_file(path, MARKER)
    return from_json(Payload, read_json(file, SCHEMA), file)

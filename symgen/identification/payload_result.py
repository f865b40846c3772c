"""What `payload` finds: a load with the precision of every number, and the drives' gains."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from symgen import names
from symgen.estimation.band import Band
from symgen.estimation.repairs import Repair
from symgen.identification.load import COM

SCHEMA = "symgen.payload/1"
MARKER = "payload.json"


@dataclass(frozen=True)
class Quantity:
    """A value with its standard deviation; both None where the logs do not determine it."""

    value: float | None
    std: float | None

    def to_json(self) -> dict[str, float | None]:
        """Return value and std."""
        return {"value": self.value, "std": self.std}


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
        gains: of the drives, joint by joint, where the load calibrated them: torque over what the
            log makes of it.
        before, after: ||tau - model|| / ||tau|| of the logs with the load, without and with it in
            the model.
        method: in words.
        band: the filters of the run; None for still poses, which pass none.
        notes: what was done, in words.
        repairs: what was mended in the logs.
    """

    robot: str
    frame: int
    mass: Quantity
    com: tuple[Quantity, ...]
    inertia: tuple[Quantity, ...]
    identifiable: tuple[str, ...]
    gain_uncertainty_percent: float | None
    before: float
    after: float
    method: str
    band: Band | None
    notes: tuple[str, ...]
    repairs: tuple[Repair, ...]
    gains: tuple[Quantity, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """Return the content of payload.json."""
        return {
            "schema": SCHEMA,
            "robot": self.robot,
            "mass": self.mass.to_json(),
            "com": [q.to_json() for q in self.com],
            "inertia": [q.to_json() for q in self.inertia],
            "frame": self.frame,
            "identifiable": list(self.identifiable),
            "gain_uncertainty_percent": self.gain_uncertainty_percent,
            "residual": {"before": self.before, "after": self.after},
            "method": self.method,
            "gains": [q.to_json() for q in self.gains],
            "band": self.band and self.band.to_json(),
            "repairs": [r.to_json() for r in self.repairs],
            "notes": list(self.notes),
        }

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

"""A payload from the folder that `symgen payload` wrote."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from symgen.errors import ParameterError
from symgen.identification.payload_result import MARKER, SCHEMA, Payload, Quantity
from symgen.identification.reading import number, read_band, read_json, read_repair


def read_payload(path: str | Path) -> Payload:
    """Read a payload again.

    Args:
        path: the folder that `payload` wrote, or the payload.json in it.

    Raises:
        ParameterError: there is none, or it is damaged.
    """
    path = Path(path)
    file = path / MARKER if path.is_dir() else path
    content = read_json(file, SCHEMA)
    try:
        com, inertia = (tuple(map(_quantity, content[key])) for key in ("com", "inertia"))
        if (len(com), len(inertia)) != (3, 6):
            raise ValueError("another number of entries")
        return Payload(
            robot=str(content["robot"]),
            frame=int(content["frame"]),
            mass=_quantity(content["mass"]),
            com=com,
            inertia=inertia,
            identifiable=tuple(map(str, content["identifiable"])),
            gain_uncertainty_percent=_or_none(content["gain_uncertainty_percent"]),
            before=number(content["residual"]["before"]),
            after=number(content["residual"]["after"]),
            method=str(content["method"]),
            band=None if content["band"] is None else read_band(content["band"]),
            gains=tuple(map(_quantity, content.get("gains", ()))),
            notes=tuple(map(str, content["notes"])),
            repairs=tuple(map(read_repair, content["repairs"])),
        )
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise ParameterError(
            f"{file}: damaged ({type(error).__name__}); accepted: schema {SCHEMA} as payload "
            "writes it"
        ) from error


def _quantity(content: dict[str, Any]) -> Quantity:
    return Quantity(_or_none(content["value"]), _or_none(content["std"]))


def _or_none(value: Any) -> float | None:
    return None if value is None else number(value)

"""Results as JSON and back, by the types of their fields: the one place that knows how.

A result is a frozen dataclass of numbers, texts, tuples and other such dataclasses; its JSON has a
key for every field, and "schema". Reading is strict: another type, a missing key or one too many is
an error that names the key.
"""

from __future__ import annotations

import json
import math
from dataclasses import fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Any, TypeVar

import numpy as np
from pydantic import BeforeValidator, TypeAdapter, ValidationError

from symgen.errors import ParameterError
from symgen.files import load_json

Result = TypeVar("Result")
#: A number that JSON has as null where it is NaN.
OrNan = Annotated[float, BeforeValidator(lambda value: math.nan if value is None else value)]


def to_json(result: Any, schema: str) -> dict[str, Any]:
    """Return the content of the JSON file of a result."""
    return {"schema": schema, **as_json(result)}


def from_json(kind: type[Result], content: dict[str, Any], file: Path) -> Result:
    """Return the result that a JSON file holds.

    Args:
        kind: the dataclass.
        content: of the file, its schema known.
        file: for messages.

    Raises:
        ParameterError: the content is another.
    """
    given = {key: value for key, value in content.items() if key != "schema"}
    known = _adapter(kind)  # type: ignore[arg-type]  # a class is hashable
    try:
        read: Result = known.validate_json(json.dumps(given), strict=True)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise ParameterError(
            f"{file}: damaged at {where or 'its top'}: {first['msg']}; accepted: schema "
            f"{content.get('schema')} as symgen writes it"
        ) from error
    return read


@cache
def _adapter(kind: type[Any]) -> TypeAdapter[Any]:
    """Return what reads a dataclass; to make it takes longer than to read a file."""
    return TypeAdapter(kind)


def result_file(path: str | Path, name: str) -> Path:
    """Return the JSON file of a result: the path itself, or of this name in that folder."""
    path = Path(path)
    return path / name if path.is_dir() else path


def read_json(file: Path, *schemas: str) -> dict[str, Any]:
    """Return the content of a JSON file of one of some schemas.

    Raises:
        ParameterError: it cannot be read, or is of another kind.
    """
    try:
        content = load_json(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        reason = getattr(error, "strerror", None) or " ".join(str(error).split())[:100]
        raise ParameterError(
            f"{file}: cannot be read ({reason}); accepted: schema {schemas[0]}"
        ) from error
    found = content.get("schema") if isinstance(content, dict) else None
    if found not in schemas:
        accepted = " or ".join(schemas)
        raise ParameterError(f"{file}: its schema is {found!r}; accepted: {accepted}")
    return dict(content)


def as_json(value: Any) -> Any:
    """Return a value as JSON has it: dataclasses and named tuples by their fields.

    A number that JSON has no word for is null. A field of the metadata {"absent": True} has no key
    where it is None: older files do not have it. One of {"file": False} never has a key.
    """
    if is_dataclass(value):
        kept = (f for f in fields(value) if f.metadata.get("file", True))
        held = {f: getattr(value, f.name) for f in kept}
        return {
            f.name: as_json(v)
            for f, v in held.items()
            if v is not None or not f.metadata.get("absent")
        }
    if hasattr(value, "_asdict"):
        value = value._asdict()
    if isinstance(value, dict):
        return {key: as_json(v) for key, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [as_json(v) for v in value]
    if isinstance(value, (np.ndarray, np.generic)):
        return as_json(value.tolist())
    return None if isinstance(value, float) and not math.isfinite(value) else value

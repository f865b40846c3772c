"""Results as JSON and back, by the types of their fields: the one place that knows how.

A result is a frozen dataclass of numbers, texts, tuples and other such dataclasses; its JSON has a
key for every field, and "schema". Reading is strict: another type, a missing key or one too many is
an error that names the key.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError

from symgen.errors import ParameterError

Result = TypeVar("Result")


def to_json(result: Any, schema: str) -> dict[str, Any]:
    """Return the content of the JSON file of a result."""
    return {"schema": schema, **TypeAdapter(type(result)).dump_python(result, mode="json")}


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
    try:
        read: Result = TypeAdapter(kind).validate_json(json.dumps(given), strict=True)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise ParameterError(
            f"{file}: damaged at {where or 'its top'}: {first['msg']}; accepted: schema "
            f"{content.get('schema')} as symgen writes it"
        ) from error
    return read

"""Results as JSON and back: a frozen dataclass is the schema of its file.

The file has "schema" and a key for every field, in their order. NaN and infinity become null. `at`,
`Form`, OPTIONAL and BESIDE mark fields with another form in the file. Reading is strict: a wrong
type, a missing key or an unknown key is an error that names the key.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import cache
from pathlib import Path
from typing import Annotated, Any, TypeVar, get_type_hints

import numpy as np
from pydantic import (
    AfterValidator,
    AliasChoices,
    AliasPath,
    BeforeValidator,
    Field,
    GetCoreSchemaHandler,
    GetPydanticSchema,
    TypeAdapter,
    ValidationError,
)
from pydantic_core import core_schema

from symgen.errors import ParameterError, message_of
from symgen.files import load_json

Result = TypeVar("Result")
#: Numbers that are null in a file if they are NaN or infinite.
OrNan = Annotated[float, BeforeValidator(lambda value: math.nan if value is None else value)]
OrInf = Annotated[float, BeforeValidator(lambda value: math.inf if value is None else value)]


def _not_negative(value: float) -> float:
    if value < 0:
        raise ValueError("a number of at least 0 is expected")
    return value


#: Numbers that are not negative: errors, standard deviations, shares.
Size = Annotated[float, AfterValidator(_not_negative)]
SizeOrNan = Annotated[OrNan, AfterValidator(_not_negative)]
SizeOrInf = Annotated[OrInf, AfterValidator(_not_negative)]
#: Keys of lists that have one entry for each joint of the result.
_PER_JOINT = ("per_joint", "joints_before", "joints_after", "slow", "weight")
_adapter = cache(TypeAdapter)  # cached, because making an adapter takes longer than reading a file
#: Mark of a field that is not in the file.
BESIDE = GetPydanticSchema(lambda *_: core_schema.any_schema())
#: Mark of a field without a key if it is None.
OPTIONAL = "optional"


@dataclass(frozen=True)
class Form:
    """Marks a field that has another type in the file: how to write it, and how to read it."""

    kind: Any
    write: Callable[[Any], Any]
    read: Callable[[Any], Any]

    def __get_pydantic_core_schema__(
        self, _: Any, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        """Read as the other type, then back."""
        other = handler.generate_schema(self.kind)
        return core_schema.no_info_after_validator_function(self.read, other)


#: Pairs of texts as an object; a matrix of numbers.
PAIRS = Form(dict[str, str], dict, lambda found: tuple(found.items()))
MATRIX = Form(tuple[tuple[OrNan, ...], ...], np.ndarray.tolist, lambda rows: np.array(rows, float))


def at(key: str, *, missing: bool = False) -> Any:
    """Return the mark of a field with another key.

    Args:
        key: "residual.train" is the key train of the object residual, which is null if all of its
            fields are None.
        missing: whether the key may be missing in an object that is there; see OPTIONAL.
    """
    group, *inner = key.split(".")
    choices = [AliasPath(group, *inner)]
    if inner and not missing:
        choices.append(AliasPath(group))  # the object may be null
    return Field(validation_alias=AliasChoices(*choices))


@cache
def fields_in_file(kind: Any) -> list[tuple[str, list[Any], Form | None, bool]]:
    """Return the fields in a file: name, path, form, and whether the key may be missing."""
    out, hints = [], get_type_hints(kind, include_extras=True)
    for f in fields(kind):
        marks = getattr(hints[f.name], "__metadata__", ())
        paths = (
            m.validation_alias.choices[0].path for m in marks if hasattr(m, "validation_alias")
        )
        form = next((m for m in marks if isinstance(m, Form)), None)
        if BESIDE not in marks:
            out.append((f.name, next(paths, [f.name]), form, OPTIONAL in marks))
    return out


def to_json(result: Any, schema: str) -> dict[str, Any]:
    """Return the content of the JSON file of a result."""
    return {"schema": schema, **as_json(result)}


def as_json(value: Any) -> Any:
    """Return a value as JSON: dataclasses and named tuples become objects."""
    if is_dataclass(value):
        return _as_object(value)
    if hasattr(value, "_asdict"):
        value = value._asdict()
    if isinstance(value, dict):
        return {key: as_json(v) for key, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [as_json(v) for v in value]
    if isinstance(value, (np.ndarray, np.generic)):
        return as_json(value.tolist())
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _as_object(value: Any) -> dict[str, Any]:
    out: dict[str, Any] = {}
    for name, (*groups, key), form, optional in fields_in_file(value.__class__):
        own = getattr(value, name)
        if own is not None or not optional:
            into = out.setdefault(groups[0], {}) if groups else out
            into[key] = as_json(form.write(own) if form else own)
    for name in {path[0] for _, path, *_ in fields_in_file(value.__class__) if len(path) > 1}:
        if all(v is None for v in out[name].values()):
            out[name] = None
    return out


def from_json(kind: type[Result], content: dict[str, Any], file: Path, **more: Any) -> Result:
    """Return the result in a JSON file.

    Args:
        kind: the dataclass. Keys of its `GONE`, which earlier versions wrote, are ignored.
        content: content of the file, with a known schema.
        file: path for messages.
        more: values of the fields that are not in the file.

    Raises:
        ParameterError: the content does not match the dataclass.
    """
    gone = {"schema", *getattr(kind, "GONE", ())}
    given = {key: value for key, value in content.items() if key not in gone}
    known = _adapter(kind)  # type: ignore[arg-type]  # a class is hashable
    try:
        text = json.dumps({**given, **dict.fromkeys(more)})
        read = known.validate_json(text, strict=True)
        joints = more.get("joints", given.get("joints"))
        count = len(joints) if isinstance(joints, list | tuple) else None
        where = _unknown(given, as_json(read), count)
        what = "an unknown key, or a list of another number of joints"
    except ValidationError as error:
        first = error.errors()[0]
        where, what = ".".join(map(str, first["loc"])) or "its top", first["msg"]
    if where:
        schema = f"schema {content['schema']} as" if "schema" in content else "what"
        raise ParameterError(
            f"{file}: damaged at {where[:100]}: {what[:200]}; accepted: {schema} symgen writes"
        )
    found: Result = replace(read, **more) if more else read
    return found


def _unknown(content: Any, written: Any, joints: int | None) -> str:
    """Return the first key in a file that symgen would not write for the result; "" if there is
    none.

    Args:
        content: content of the file.
        written: what symgen would write.
        joints: number of joints; None if it is unknown.
    """
    pairs: list[tuple[str, Any, Any]] = []
    if isinstance(content, dict) and isinstance(written, dict):
        for key, value in content.items():
            other = key in _PER_JOINT and isinstance(value, list) and len(value) != joints
            if key not in written or (joints is not None and other):
                return str(key)
            pairs.append((key, value, written[key]))
    elif isinstance(content, list) and isinstance(written, list):
        pairs += [(str(k), *both) for k, both in enumerate(zip(content, written, strict=False))]
    inner = ((key, _unknown(value, other, joints)) for key, value, other in pairs)
    return next((f"{key}.{where}" for key, where in inner if where), "")


def result_file(path: str | Path, name: str) -> Path:
    """Return the JSON file of a result: the path itself, or the file `name` in that folder."""
    path = Path(path)
    return path / name if path.is_dir() else path


def read_result(kind: type[Result], file: Path, *schemas: str, **more: Any) -> Result:
    """Return the result in a JSON file with one of some schemas; see `from_json`."""
    return from_json(kind, read_json(file, *schemas), file, **more)


def read_json(file: Path, *schemas: str) -> dict[str, Any]:
    """Return the content of a JSON file with one of some schemas.

    Raises:
        ParameterError: the file cannot be read, or is of another kind.
    """
    try:
        content = load_json(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise ParameterError(
            f"{file}: cannot be read ({message_of(error)}); accepted: schema {schemas[0]}"
        ) from error
    found = content.get("schema") if isinstance(content, dict) else None
    if found not in schemas:
        accepted = " or ".join(schemas)
        raise ParameterError(f"{file}: its schema is {found!r}; accepted: {accepted}")
    return dict(content)

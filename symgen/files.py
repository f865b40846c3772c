"""Folders written whole or not at all, and the place of the templates.

A folder is made beside its place, in a temporary folder (see `places`), and then exchanged with the
one that is there in one step of the system. A kill leaves either the old folder or the new one in
place, whole; the other is in the temporary folder, which the next run removes.

What symgen wrote into a folder stands in a record there (see `record`); a folder without one is
refused. All else goes over into the new folder.

A system that cannot exchange folders takes two steps: the old one is moved aside, then the new one
is moved in. A kill between the two leaves the old folder aside, as `.NAME-old-*`. It may be the
only copy: no run puts it back, replaces it or removes it. Every later run says where it is.
"""

from __future__ import annotations

import glob
import hashlib
import json
import math
import os
import re
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack, suppress
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from symgen.errors import PackageError, SymgenWarning, located, plain
from symgen.places import alone, exchanged, place, sweep, written
from symgen.record import RECORD, Carried, read_record, with_record

if TYPE_CHECKING:
    import jinja2

_ASIDE = "-old-"

#: 200 parts of a key of TOML with dots behind them; a part is bare or in quotes, and short, so that
#: the search takes a time in proportion to the text.
_LONG_KEY = re.compile(
    r"""(?:(?:"(?:[^"\\\n]|\\.){0,200}+"|'[^'\n]{0,200}+'|(?<![\w-])[\w-]{1,200}+)"""
    r"""[ \t]{0,9}+\.[ \t]{0,9}+){200}"""
)
_MARK = "# written by symgen, digest "


def write_folder(folder: Path, files: Mapping[str, bytes], marker: str) -> None:
    """Write a folder of files in one step; an older one of the same kind is replaced.

    Args:
        folder: where; its parents are made.
        files: relative path and content of each file.
        marker: the file that tells what kind of folder it is.

    Raises:
        PackageError: the folder holds something else, or cannot be written.
    """
    _check_kind(folder, marker)
    folder = folder.absolute()
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        sweep(folder.parent)
        with place(folder.parent) as own:
            fresh, carried = own / "new", Carried(marker)
            for name, content in with_record(files, marker).items():
                path = fresh / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(content)
            with alone(folder.parent):
                if folder.exists():
                    carried.over(folder, fresh)
                old = _moved_in(fresh, folder)
                if old is not None:  # what came in the meantime
                    try:
                        carried.over(old, folder)
                    except OSError:
                        old.rename(_aside(folder, own.name[-8:]))
                        raise
    except OSError as error:
        raise PackageError(f"{folder}: cannot be written: {error.strerror or error}") from error
    for name, kept in carried.renamed.items():
        what = "changed since symgen wrote it, or not written by symgen"
        warnings.warn(SymgenWarning(f"{folder / name}: {what}; it is now {kept}"), stacklevel=2)


def _moved_in(fresh: Path, folder: Path) -> Path | None:
    """Move a new folder to its place; return where the old one is, None where there was none."""
    try:
        fresh.rename(folder)
        return None
    except OSError:  # there is one, and it is not empty
        if not os.path.lexists(folder):
            raise
    if exchanged(fresh, folder):
        return fresh
    own = fresh.parent
    aside = _aside(folder, own.name[-8:])
    folder.rename(aside)
    try:
        fresh.rename(folder)
    except BaseException:
        if not os.path.lexists(folder):
            aside.rename(folder)
        raise
    return aside.rename(own / "old")


def _aside(folder: Path, number: str) -> Path:
    return folder.absolute().with_name(f".{folder.absolute().name}{_ASIDE}{number}")


def check_replaceable(folder: Path, marker: str) -> None:
    """Check that a folder is absent, empty or one that symgen wrote, before its content is made.

    What killed runs left beside it is removed; an old result that one had moved aside is named.

    Raises:
        PackageError: it is not a folder, holds something that symgen did not write, or is the
            current folder.
    """
    _check_kind(folder, marker)
    whole = folder.absolute()
    sweep(whole.parent)
    for aside in sorted(whole.parent.glob(f".{glob.escape(whole.name)}{_ASIDE}*")):
        warnings.warn(
            SymgenWarning(
                f"{aside}: the result of an earlier run, which a killed run had moved aside; "
                "move it back, or remove it"
            ),
            stacklevel=2,
        )


def _check_kind(folder: Path, marker: str) -> None:
    accepted = "accepted: a new or empty folder, or one that symgen wrote"
    with located(str(folder) if len(str(folder)) < 200 else f"{str(folder)[:200]}..."):
        try:
            if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
                raise PackageError(f"exists and is not a folder; {accepted}")
            if folder.exists() and Path.cwd().is_relative_to(folder.resolve()):
                raise PackageError(f"the current folder cannot be replaced; {accepted}")
            with suppress(FileNotFoundError):
                _aside(folder, "12345678").lstat()  # the name fits into the file system
            if not folder.is_dir() or not any(folder.iterdir()):
                return
            record = read_record(folder, marker)
        except OSError as error:
            raise PackageError(f"not ours ({error.strerror}); {accepted}") from error
        if record is None or marker not in record:
            missing = marker if not (folder / marker).is_file() else RECORD
            reason = f"no {missing} in it" if record is None else f"no {marker} in its {RECORD}"
            raise PackageError(f"not ours ({reason}); {accepted}")


def load_json(text: str) -> Any:
    """Return the content of a JSON text of unknown origin: finite numbers, texts of one line.

    Raises:
        ValueError: it is no JSON, or has a number that is none in double precision.
        RecursionError: it is nested too deeply.
    """

    def finite(digits: str) -> float:
        number = float(digits)
        if not math.isfinite(number):
            raise ValueError(f"{digits[:40]} is not a finite number")
        return number

    def integer(digits: str) -> int:
        finite(digits)
        return int(digits)

    return _plain(json.loads(text, parse_float=finite, parse_int=integer, parse_constant=finite))


def load_toml(text: str, parse_float: Callable[[str], Any] = float) -> dict[str, Any]:
    """Return the content of a TOML text of unknown origin.

    Raises:
        ValueError: it is no TOML, or has a key of 200 parts or more: the time that one takes grows
            with the square of its parts, to hours for a file of some 100 kB.
        RecursionError: it is nested too deeply.
    """
    import tomllib

    if _LONG_KEY.search(text):
        raise ValueError("a key of 200 parts or more")
    return tomllib.loads(text, parse_float=parse_float)


def _plain(content: Any) -> Any:
    if isinstance(content, str):
        return plain(content)
    if isinstance(content, list):
        return [_plain(value) for value in content]
    if isinstance(content, dict):
        return {plain(key): _plain(value) for key, value in content.items()}
    return content


def write_text(path: Path, text: str) -> None:
    """Write a text file in one step, with a first line by which symgen knows it again.

    Raises:
        PackageError: the path holds something else, or a file that was changed since, or cannot
            be written.
    """
    check_text_replaceable(path)
    replace_file(path, f"{_MARK}{_digest(text)}\n{text}".encode())


def replace_file(path: Path, content: bytes) -> None:
    """Write a file in one step, in place of what was there.

    Raises:
        PackageError: it cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        sweep(path.parent)
        written(path, content)
    except OSError as error:
        raise PackageError(f"{path}: cannot be written: {error.strerror or error}") from error


def write_files(files: Iterable[tuple[Path, bytes]]) -> None:
    """Write new files, all of them or none.

    Args:
        files: path and content of each; a content is asked for when the one before is on the disk.

    Raises:
        PackageError: a path is taken, or cannot be written.
    """
    made: list[tuple[Path, Path]] = []
    done: list[Path] = []
    path = Path()
    with ExitStack() as places:
        try:
            for path, content in files:
                check_new(path)
                path.parent.mkdir(parents=True, exist_ok=True)
                sweep(path.parent)
                fresh = places.enter_context(place(path.parent)) / path.name
                fresh.write_bytes(content)
                made.append((fresh, path))
            for fresh, path in made:
                os.replace(fresh, path)
                done.append(path)
        except OSError as error:
            for finished in done:
                finished.unlink(missing_ok=True)
            raise PackageError(f"{path}: cannot be written: {error.strerror or error}") from error


def check_new(path: Path) -> None:
    """Check that nothing is at a path.

    Raises:
        PackageError: something is.
    """
    if os.path.lexists(path):
        raise PackageError(f"{path}: exists; accepted: a new file")


def check_text_replaceable(path: Path) -> None:
    """Check that a path is free, or holds a text that symgen wrote and nobody changed.

    Raises:
        PackageError: it holds something else.
    """
    accepted = "accepted: a new file, or one that symgen wrote and nobody changed"
    with located(path):
        try:
            if path.is_symlink() or (path.exists() and not path.is_file()):
                raise PackageError(f"exists and is not a file; {accepted}")
            if not path.exists():
                return
            mark, _, text = path.read_text("utf-8").partition("\n")
        except (OSError, ValueError) as error:
            raise PackageError(f"not ours; {accepted}") from error
        if mark != f"{_MARK}{_digest(text)}":
            raise PackageError(f"exists; {accepted}")


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode("utf-8")).hexdigest()[:16]


def json_text(value: Any, indent: str = "") -> str:
    """Return JSON text in which a list of numbers or texts takes one line.

    Raises:
        ValueError: a number is not finite.
    """
    inner = indent + " "
    if isinstance(value, dict) and value:
        items = [f"{json.dumps(key)}: {json_text(v, inner)}" for key, v in value.items()]
        start, end = "{", "}"
    elif isinstance(value, list) and any(isinstance(v, (dict, list)) for v in value):
        items = [json_text(v, inner) for v in value]
        start, end = "[", "]"
    else:
        return json.dumps(value, allow_nan=False)
    return f"{start}\n{inner}" + f",\n{inner}".join(items) + f"\n{indent}{end}"


#: What templates of a folder need: TeX has braces and percent signs of its own.
_SYNTAX: dict[str, dict[str, Any]] = {
    "tex": {
        "block_start_string": "<%",
        "block_end_string": "%>",
        "variable_start_string": "<<",
        "variable_end_string": ">>",
        "comment_start_string": "<#",
        "comment_end_string": "#>",
    },
    "report": {"autoescape": True},
}


def rendered(template: str, **data: Any) -> str:
    """Return a template with its data put in.

    Args:
        template: its folder and name, such as "c/values.h".
        data: every name that it uses; one that is missing is an error.
    """
    folder, name = template.split("/", 1)
    return str(_environment(folder).get_template(name).render(**data))


@cache
def _environment(folder: str) -> jinja2.Environment:
    """Return what reads the templates of a folder, and keeps them."""
    import jinja2

    return jinja2.Environment(
        loader=jinja2.FileSystemLoader(templates() / folder),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        **_SYNTAX.get(folder, {}),
    )


def html_table(caption: str, header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table as HTML, as notebooks show it."""
    return rendered("report/table.html", caption=caption, header=header, rows=rows)


def templates() -> Path:
    """Return the folder of the templates: inside an installed package, beside it in a checkout."""
    here = Path(__file__).resolve().parent
    for folder in (here / "templates", here.parent / "templates"):
        if folder.is_dir():
            return folder
    raise PackageError("symgen's templates are missing: install it again")

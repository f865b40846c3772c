"""Folders written whole or not at all, and the place of the templates."""

from __future__ import annotations

import glob
import hashlib
import json
import math
import os
import re
import shutil
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from symgen.errors import PackageError, plain

#: 200 parts of a key of TOML with dots behind them; a part is bare or in quotes, and short, so that
#: the search takes a time in proportion to the text.
_LONG_KEY = re.compile(
    r"""(?:(?:"(?:[^"\\\n]|\\.){0,200}+"|'[^'\n]{0,200}+'|(?<![\w-])[\w-]{1,200}+)"""
    r"""[ \t]{0,9}+\.[ \t]{0,9}+){200}"""
)
_MARK = "# written by symgen, digest "


def write_folder(folder: Path, files: Mapping[str, bytes], marker: str) -> None:
    """Write a folder of files in one step; an older one of the same kind is replaced.

    What somebody else put into the older folder is carried over into the new one.

    Args:
        folder: where; its parents are made.
        files: relative path and content of each file.
        marker: the JSON file whose schema tells that an existing folder is one of ours.

    Raises:
        PackageError: the folder holds something else, or cannot be written.
    """
    ours = check_replaceable(folder, marker) | set(files)
    folder = folder.absolute()
    fresh = old = None
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        fresh = Path(tempfile.mkdtemp(prefix=f".{folder.name}-", dir=folder.parent))
        for name, content in files.items():
            path = fresh / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        fresh.chmod(0o777 & ~_umask())
        if folder.exists():
            _carry_over(folder, fresh, ours)
            old = Path(tempfile.mkdtemp(prefix=f".{folder.name}-old-", dir=folder.parent))
            folder.rename(old / folder.name)
        try:
            fresh.rename(folder)
        except OSError:
            if old is not None:
                (old / folder.name).rename(folder)
            raise
    except OSError as error:
        raise PackageError(f"{folder}: cannot be written: {error.strerror or error}") from error
    finally:
        for leftover in (fresh, old):
            if leftover is not None:
                shutil.rmtree(leftover, ignore_errors=True)


def _carry_over(old: Path, new: Path, ours: set[str], inside: str = "") -> None:
    """Copy what is not among our paths; a folder that holds one of them is looked into.

    A link stays one: what it leads to is not copied into the folder, which may be passed on.
    """
    for path in old.iterdir():
        name = f"{inside}{path.name}"
        link, holds = path.is_symlink(), any(own.startswith(f"{name}/") for own in ours)
        if path.is_dir() and holds and not link:
            _carry_over(path, new, ours, f"{name}/")
        elif name not in ours and not holds:
            (new / name).parent.mkdir(parents=True, exist_ok=True)
            if path.is_dir() and not link:
                shutil.copytree(path, new / name, symlinks=True)
            else:
                shutil.copy2(path, new / name, follow_symlinks=False)


def _restore(folder: Path) -> None:
    """Put back what a run had moved aside when it was killed before its own was in place."""
    if not folder.name or os.path.lexists(folder):
        return
    for aside in sorted(folder.parent.glob(f".{glob.escape(folder.name)}-old-*")):
        if (aside / folder.name).is_dir():
            (aside / folder.name).rename(folder)
            aside.rmdir()
            return


def check_replaceable(folder: Path, marker: str) -> set[str]:
    """Return the names of our own files in `folder`, which may be absent or empty.

    Raises:
        PackageError: it is not a folder, holds something that symgen did not write, or is the
            current folder.
    """
    accepted = "accepted: a new or empty folder, or one that symgen wrote"
    try:
        _restore(folder.absolute())
        if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
            raise PackageError(f"{folder}: exists and is not a folder; {accepted}")
        if folder.exists() and Path.cwd().is_relative_to(folder.resolve()):
            raise PackageError(f"{folder}: the current folder cannot be replaced; {accepted}")
        if not folder.is_dir() or not any(folder.iterdir()):
            return set()
        manifest = load_json((folder / marker).read_text("utf-8"))
    except OSError as error:
        reason = f"no {marker} in it" if isinstance(error, FileNotFoundError) else error.strerror
        shown = str(folder) if len(str(folder)) < 200 else f"{str(folder)[:200]}..."
        raise PackageError(f"{shown}: not ours ({reason}); {accepted}") from error
    except (ValueError, RecursionError) as error:
        raise PackageError(f"{folder}: {marker} is not ours; {accepted}") from error
    if not isinstance(manifest, dict) or not str(manifest.get("schema")).startswith("symgen."):
        raise PackageError(f"{folder}: {marker} is not ours; {accepted}")
    digests = manifest.get("digests")
    ours = {marker, *(digests if isinstance(digests, dict) else ())}
    return ours | {path.name for path in folder.glob("*.casadi")}


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
    fresh = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, fresh = tempfile.mkstemp(prefix=f".{path.name}-", dir=path.parent)
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        os.chmod(fresh, 0o666 & ~_umask())
        os.replace(fresh, path)
    except OSError as error:
        if fresh is not None:
            Path(fresh).unlink(missing_ok=True)
        raise PackageError(f"{path}: cannot be written: {error.strerror or error}") from error


def write_files(files: Iterable[tuple[Path, bytes]]) -> None:
    """Write new files, all of them or none.

    Args:
        files: path and content of each; a content is asked for when the one before is on the disk.

    Raises:
        PackageError: a path is taken, or cannot be written.
    """
    made: list[tuple[str, Path]] = []
    done: list[Path] = []
    path = Path()
    try:
        for path, content in files:
            check_new(path)
            path.parent.mkdir(parents=True, exist_ok=True)
            handle, fresh = tempfile.mkstemp(prefix=f".{path.name}-", dir=path.parent)
            made.append((fresh, path))
            with os.fdopen(handle, "wb") as file:
                file.write(content)
            os.chmod(fresh, 0o666 & ~_umask())
        for fresh, path in made:
            os.replace(fresh, path)
            done.append(path)
    except OSError as error:
        for written in done:
            written.unlink(missing_ok=True)
        raise PackageError(f"{path}: cannot be written: {error.strerror or error}") from error
    finally:
        for fresh, _ in made:
            Path(fresh).unlink(missing_ok=True)


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
    try:
        if path.is_symlink() or (path.exists() and not path.is_file()):
            raise PackageError(f"{path}: exists and is not a file; {accepted}")
        if not path.exists():
            return
        mark, _, text = path.read_text("utf-8").partition("\n")
    except (OSError, ValueError) as error:
        raise PackageError(f"{path}: not ours; {accepted}") from error
    if mark != f"{_MARK}{_digest(text)}":
        raise PackageError(f"{path}: exists; {accepted}")


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode("utf-8")).hexdigest()[:16]


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


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
    import jinja2

    folder, name = template.split("/", 1)
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(templates() / folder),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        **_SYNTAX.get(folder, {}),
    )
    return environment.get_template(name).render(**data)


def html_table(caption: str, header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table as HTML, as notebooks show it."""
    return rendered("report/table.html", caption=caption, header=header, rows=rows)


def templates() -> Path:
    """Return the folder of the templates: inside an installed package, beside it in a checkout."""
    here = Path(__file__).resolve().parent
    for place in (here / "templates", here.parent / "templates"):
        if place.is_dir():
            return place
    raise PackageError("symgen's templates are missing: install it again")

"""Write folders and files completely or not at all; JSON and TOML texts, and templates.

symgen writes a folder under a temporary name in the same parent folder. One system call then
exchanges it with the old folder. A killed process leaves the complete old folder or the complete
new one. A system without this call needs two steps. A process that is killed between them leaves
the old folder as `.NAME-old`, which symgen never removes.

The record of a folder, `.symgen.sha256`, contains the names and the SHA-256 of its files. The last
line of a single text file is a comment with the digest of the text. symgen replaces neither a
folder with other or changed files, nor a file that it did not write or that was changed.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from symgen.errors import PackageError, located, plain

if TYPE_CHECKING:
    import jinja2

RECORD = ".symgen.sha256"
_PART = ".symgen-part-"
#: Age in s from which no running process uses a temporary folder.
_STALE = 86_400.0
#: Maximum number of foreign files in a message.
_NAMED = 5
#: Largest number in a result: its square and its percentage are finite.
_LARGEST = 1e100
_HERE, _EXCHANGE, _SWAP = -100, 2, 2  # AT_FDCWD, RENAME_EXCHANGE (Linux), RENAME_SWAP (macOS)
#: 200 parts of a TOML key, each followed by a dot. A part is bare or in quotes, and short, so that
#: the search takes a time in proportion to the text.
_LONG_KEY = re.compile(
    r"""(?:(?:"(?:[^"\\\n]|\\.){0,200}+"|'[^'\n]{0,200}+'|(?<![\w-])[\w-]{1,200}+)"""
    r"""[ \t]{0,9}+\.[ \t]{0,9}+){200}"""
)
#: Last line of a text file, as a comment in TOML or XML.
_MARK = re.compile(rb"(?:#|<!--) written by symgen, digest [0-9a-f]{16}(?: -->)?\n\Z")


def write_folder(folder: Path, files: Mapping[str, bytes], marker: str) -> None:
    """Write a folder of files in one step; it replaces an older one of the same kind.

    Args:
        folder: path of the folder; missing parents are created.
        files: relative path and content of each file.
        marker: the file that identifies the kind of folder.

    Raises:
        PackageError: the folder contains other files, or cannot be written.
    """
    check_replaceable(folder, marker)
    folder = folder.absolute()
    digests = {name: hashlib.sha256(content).hexdigest() for name, content in files.items()}
    record = "".join(f"{digest}  {name}\n" for name, digest in sorted(digests.items()))
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        with _temporary_folder(folder.parent) as part:
            fresh = part / "new"
            for name, content in {**files, RECORD: record.encode()}.items():
                path = fresh / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(content)
            _move_in(fresh, folder)
    except OSError as error:
        raise PackageError(f"{folder}: cannot be written: {error.strerror or error}") from error


def _move_in(fresh: Path, folder: Path) -> None:
    """Move a new folder to its place; the old folder gets the temporary name."""
    if not folder.exists() or not any(folder.iterdir()):
        fresh.rename(folder)
    elif not _exchanged(fresh, folder):
        aside = folder.with_name(f".{folder.name}-old")
        folder.rename(aside)
        fresh.rename(folder)
        shutil.rmtree(aside, ignore_errors=True)


def _exchanged(one: Path, other: Path) -> bool:
    """Exchange two folders in one step; return whether that was possible.

    Linux and macOS can, on most disks.
    """
    import ctypes

    a, b = os.fsencode(one), os.fsencode(other)
    # the library of this system has no such call
    with suppress(AttributeError, OSError, TypeError):
        library = ctypes.CDLL(None)
        if sys.platform == "darwin":
            return bool(library.renamex_np(a, b, _SWAP) == 0)
        return bool(library.renameat2(_HERE, a, _HERE, b, _EXCHANGE) == 0)
    return False


@contextmanager
def _temporary_folder(parent: Path) -> Iterator[Path]:
    """Yield a temporary folder in `parent` and remove it afterwards, as well as old ones of killed
    runs.
    """
    for leftover in parent.glob(f"{_PART}*"):
        with suppress(OSError):
            if time.time() - leftover.lstat().st_mtime > _STALE:
                shutil.rmtree(leftover, ignore_errors=True)
    part = Path(tempfile.mkdtemp(prefix=_PART, dir=parent))
    try:
        yield part
    finally:
        shutil.rmtree(part, ignore_errors=True)


def check_replaceable(folder: Path, marker: str) -> None:
    """Check that a folder is absent, empty or as symgen wrote it.

    Raises:
        PackageError: the path is not a folder, or is the current folder. Or the folder contains
            another kind of result, files that are not in its record, or changed files.
    """
    accepted = "accepted: a new or empty folder, or one that symgen wrote"
    with located(str(folder) if len(str(folder)) < 200 else f"{str(folder)[:200]}..."):
        try:
            if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
                raise PackageError(f"exists and is not a folder; {accepted}")
            if folder.exists() and Path.cwd().is_relative_to(folder.resolve()):
                raise PackageError(f"the current folder cannot be replaced; {accepted}")
            if not folder.is_dir() or not any(folder.iterdir()):
                return
            record = _read_record(folder)
            foreign = _foreign_files(folder, record)
        except OSError as error:
            raise PackageError(f"cannot be read ({error.strerror}); {accepted}") from error
        if foreign:
            named = ", ".join(foreign[:_NAMED])
            more = f" and {len(foreign) - _NAMED} more" if len(foreign) > _NAMED else ""
            raise PackageError(
                f"holds files that symgen did not write, or that changed since: {named}{more}; "
                "accepted: another folder, or remove these files first"
            )
        if marker not in record:
            raise PackageError(f"holds another kind of result (no {marker}); {accepted}")


def _read_record(folder: Path) -> dict[str, str]:
    """Return the SHA-256 of the files that symgen wrote into a folder; {} without a record."""
    record: dict[str, str] = {}
    path = folder / RECORD
    if path.is_file() and not path.is_symlink():
        for line in path.read_text("utf-8", errors="replace").split("\n"):
            digest, _, name = line.partition("  ")
            record[name] = digest
    return record


def _foreign_files(folder: Path, record: Mapping[str, str]) -> list[str]:
    """Return the paths in a folder that are not in its record, or that were changed."""
    foreign = []
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder).as_posix()
        if path.is_dir() and not path.is_symlink():
            continue
        if name == RECORD and record:
            continue
        if path.is_symlink() or name not in record or record[name] != _sha256(path):
            foreign.append(name)
    return foreign


def _sha256(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def load_json(text: str) -> Any:
    """Return the content of a JSON text of unknown origin: numbers, and texts of one line.

    Raises:
        ValueError: it is not JSON, or has a number that is not finite or is above 1e100.
        RecursionError: it is nested too deeply.
    """

    def finite(digits: str) -> float:
        number = float(digits)
        if not abs(number) <= _LARGEST:
            raise ValueError(f"{digits[:40]} is not a number of at most {_LARGEST:g}")
        return number

    def integer(digits: str) -> int:
        finite(digits)
        return int(digits)

    return _plain(json.loads(text, parse_float=finite, parse_int=integer, parse_constant=finite))


def load_toml(text: str, parse_float: Callable[[str], Any] = float) -> dict[str, Any]:
    """Return the content of a TOML text of unknown origin.

    Raises:
        ValueError: it is not TOML, or has a key with 200 parts or more. The time to read such a key
            grows with the square of its parts, to hours for a file of some 100 kB.
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


def write_text(path: Path, text: str | bytes) -> None:
    """Write a text file in one step. Its last line is a comment with a digest of the rest.

    Args:
        path: path of a file in TOML, or else in XML or HTML.
        text: the text, or its bytes. The comment replaces that of an earlier `write_text`.

    Raises:
        PackageError: the path contains another file, or a text that was changed since, or is not
            writable.
    """
    check_text_replaceable(path)
    content = text.encode() if isinstance(text, str) else text
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        replace_in_one_step(path, _marked(content, path.suffix))
    except OSError as error:
        raise PackageError(f"{path}: cannot be written: {error.strerror or error}") from error


def _marked(content: bytes, suffix: str) -> bytes:
    """Return a text with its mark as the last line."""
    rest = _MARK.sub(b"", content)
    if not rest.endswith(b"\n"):
        rest += b"\n"
    words = f"written by symgen, digest {hashlib.sha256(rest).hexdigest()[:16]}"
    mark = f"# {words}\n" if suffix == ".toml" else f"<!-- {words} -->\n"
    return rest + mark.encode()


def replace_in_one_step(path: Path, content: bytes) -> None:
    """Write a file under a temporary name in the same folder, and rename it.

    Args:
        path: path of the file.
        content: content of the file.

    Raises:
        OSError: the file cannot be written.
    """
    with _temporary_folder(path.parent) as part:
        fresh = part / path.name
        fresh.write_bytes(content)
        os.replace(fresh, path)


def write_files(files: Iterable[tuple[Path, bytes]]) -> None:
    """Write new files, either all or none.

    Args:
        files: path and content of each file. The iterator makes a content after the previous file
            is on the disk.

    Raises:
        PackageError: a path exists, or cannot be written.
    """
    done: list[Path] = []
    path = Path()
    try:
        for path, content in files:
            check_new(path)
            path.parent.mkdir(parents=True, exist_ok=True)
            replace_in_one_step(path, content)
            done.append(path)
    except BaseException as error:
        for finished in done:
            finished.unlink(missing_ok=True)
        if isinstance(error, OSError):
            reason = error.strerror or error
            raise PackageError(f"{path}: cannot be written: {reason}") from error
        raise


def check_new(path: Path) -> None:
    """Raise PackageError if a path exists."""
    if os.path.lexists(path):
        raise PackageError(f"{path}: exists; accepted: a new file")


def check_text_replaceable(path: Path) -> None:
    """Check that a path is free, or contains an unchanged text of symgen.

    Raises:
        PackageError: it contains something else.
    """
    accepted = "accepted: a new file, or one that symgen wrote and nobody changed"
    with located(path):
        try:
            if path.is_symlink() or (path.exists() and not path.is_file()):
                raise PackageError(f"exists and is not a file; {accepted}")
            if not path.exists():
                return
            content = path.read_bytes()
        except OSError as error:
            raise PackageError(f"cannot be read ({error.strerror}); {accepted}") from error
        if content != _marked(content, path.suffix):
            raise PackageError(f"exists; {accepted}")


def json_text(value: Any, indent: str = "") -> str:
    """Return JSON text with each list of numbers or texts in one line.

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


#: Syntax of the templates of a folder: TeX itself uses braces and percent signs.
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
    """Return a template with its data inserted.

    Args:
        template: folder and name of the template, such as "c/values.h".
        data: all names of the template; a missing one is an error.
    """
    folder, name = template.split("/", 1)
    return str(_environment(folder).get_template(name).render(**data))


@cache
def _environment(folder: str) -> jinja2.Environment:
    """Return the cached Jinja environment of a folder of templates."""
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
    """Return a table as HTML for notebooks."""
    return rendered("report/table.html", caption=caption, header=header, rows=rows)


def templates() -> Path:
    """Return the folder of the templates: in an installed package, or next to it in a checkout."""
    here = Path(__file__).resolve().parent
    for folder in (here / "templates", here.parent / "templates"):
        if folder.is_dir():
            return folder
    raise PackageError("symgen's templates are missing: install it again")

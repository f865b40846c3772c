"""Mutations of real files, read one after the other in a process with bounds of time and memory.

    python fuzzing.py READER FOLDER FIRST COUNT

The seed files of a reader are in FOLDER/seeds. Input k is a function of READER and k alone, so that
a fault is seen again with FIRST = k and COUNT = 1. Prints one JSON object: "faults" as [k, what],
how many inputs were "refused" in a line, the "slowest" in s, and the "memory" of the process in MB.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import random
import re
import signal
import sys
import time
import traceback
import warnings
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

SECONDS = 20.0  # for one input
MEMORY = 6 << 30  # bytes of address space of the process
LONGEST = 2000  # characters of a message

#: What breaks readers: ends of numbers, of texts, of structures.
WORDS = [
    *(b"nan", b"inf", b"-inf", b"1e999", b"-0", b"0", b"1e-320", b"9" * 400, b"1e308", b"0x1p3"),
    *(b"null", b"true", b'""', b"[]", b"{}", b"[[", b"]", b"}", b'"', b"'", b'"""', b"\\u0000"),
    *(b"\\ud800", b"\x1b[31m", b"\xff\xfe", b"\xef\xbb\xbf", b"\x00", b"\r", b"\n", b"\t", b","),
    *(b"<!ENTITY a 'b'>", b"&amp;", b"<x/>", b"<!--", b"-->", b"\xc2\xb2", b"\xd9\xa3", b"#"),
    *(b"q1", b"tau2", b"t", b"sqrt(2)", b"**16", b"/0", b"pi/", b"L1", b"(" * 60, b"-" * 60),
    *(b"sigma = 2", b"antecedent = 9", b"[[joint]]", b"=", b"th1", b"{0, 1}", b"\x7f" * 8),
]
NUMBERS = [
    *(b"0", b"1", b"2", b"3", b"-1", b"0.5", b"1.5707963267948966", b"-0.785398", b"1e-9", b"1e9"),
    *(b"1e100", b"1e-100", b"1e300", b"1e-300", b"100", b"3.14159", b"0.3", b"7", b"12", b"255"),
    *(b"nan", b"inf", b"9" * 30, b"1e308", b"1e309", b"-0.0", b"4294967296", b"1e5"),
]
_NUMBER = re.compile(rb"-?[0-9]+(?:\.[0-9]+)?(?:[eE][-+]?[0-9]+)?")


def mutated(seeds: list[bytes], draw: random.Random) -> bytes:
    """Return one of the seeds with one to six places spoiled; of a ZIP, inside, half the times."""
    seed = draw.choice(seeds)
    if seed.startswith(b"PK") and draw.random() < 0.5:  # behind the checksums of the archive
        return _repacked(seed, draw)
    return _spoiled(seed, seeds, draw)


def _repacked(seed: bytes, draw: random.Random) -> bytes:
    """Return an archive with one of its files spoiled, and now and then gone or named anew."""
    file = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(seed)) as old, zipfile.ZipFile(file, "w") as new:
        names = old.namelist()
        chosen = draw.choice(names)
        for name in names:
            content, called = old.read(name), name
            if name == chosen:
                content = _spoiled(content, [old.read(n) for n in names], draw)
                called = draw.choice((name, name, name, name, draw.choice(names), "x"))
            if draw.random() > 0.02 and called not in new.namelist():
                new.writestr(called, content)
    return file.getvalue()


def _spoiled(seed: bytes, seeds: list[bytes], draw: random.Random) -> bytes:
    data = bytearray(seed)
    if draw.random() < 0.5:  # other numbers alone: what is behind the grammar
        for _ in range(draw.choice((1, 1, 2, 4))):
            found = list(_NUMBER.finditer(data))
            if found:
                match = draw.choice(found)
                data[match.start() : match.end()] = draw.choice(NUMBERS)
        return bytes(data)
    for _ in range(draw.choice((1, 1, 1, 2, 3, 6))):
        at = draw.randrange(len(data) + 1)
        size = draw.choice((1, 1, 2, 4, 16, 200))
        kind = draw.randrange(8)
        if kind == 0 and at < len(data):
            data[at] ^= 1 << draw.randrange(8)
        elif kind == 1 and at < len(data):
            data[at] = draw.randrange(256)
        elif kind == 2:
            del data[at : at + size]
        elif kind == 3:
            data[at:at] = data[at : at + size] * draw.choice((1, 2, 50))
        elif kind == 4:
            data[at : at + draw.choice((0, size))] = draw.choice(WORDS)
        elif kind == 5:
            other = draw.choice(seeds)
            start = draw.randrange(len(other) + 1)
            data[at : at + size] = other[start : start + size]
        elif kind == 6:
            del data[at:]
        else:  # a whole line, value or tag goes, or comes twice
            separator = draw.choice((b"\n", b",", b"=", b" ", b">", b'"'))
            parts = bytes(data).split(separator)
            k = draw.randrange(len(parts))
            parts[k : k + 1] = draw.choice(([], [parts[k]] * 2, [draw.choice(WORDS)]))
            data = bytearray(separator.join(parts))
    return bytes(data)


def _finite(*arrays: Any) -> None:
    for array in arrays:
        if array is not None and not np.isfinite(array).all():
            raise AssertionError("a result that is not finite")


def read_robot(path: Path) -> None:
    """Read a robot, and what is written of it: the same robot."""
    import symgen

    robot = symgen.read_robot(path)
    again = symgen.parse_robot(symgen.robot_toml(robot))
    if again.n != robot.n:
        raise AssertionError("another robot when read again")
    _finite([float(v) for v in robot.values().values()])


def read_log(path: Path) -> None:
    """Read a log: finite arrays of one length, increasing in time, plain names."""
    from symgen.data.log import read_log
    from symgen.errors import plain

    log = read_log(path, names=("a", "b"))
    _finite(log.t, log.q, log.qd, log.tau)
    if not len(log.t) == len(log.q) or not (np.diff(log.t) > 0).all():
        raise AssertionError("a log of unequal lengths, or out of order")
    for text in (*log.ignored, *log.notes):
        if plain(text) != text:
            raise AssertionError("a name that a terminal obeys")


def read_map(path: Path) -> None:
    """Read names of columns, and the log beside it by them."""
    from symgen.data.log import read_log
    from symgen.data.raw import Reading

    names = Reading(columns=path.read_text("utf-8", "replace"))
    log = read_log(path.with_name("log.csv"), reading=names)
    _finite(log.t, log.q, log.qd, log.tau)


def read_motion(path: Path) -> None:
    """Read a motion that simulate follows."""
    from symgen.data.tables import read_columns

    t, found = read_columns(path, ("q",), ("qd", "qdd"), "a motion")
    _finite(t, *found.values())
    if {len(array) for array in found.values()} != {len(t)}:
        raise AssertionError("a motion of unequal lengths")


def read_result(path: Path) -> None:
    """Read a result and print it; of one in 200, make the page."""
    from symgen.report.store import load_result, result_page
    from symgen.report.terminal import print_result

    result: Any = load_result(path)
    _finite(getattr(result, "X", None), getattr(result, "condition_number", None))
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        print_result(result)
    out.getvalue().encode()
    if "\x1b" in out.getvalue():
        raise AssertionError("an escape in the output")
    if zlib.crc32(path.read_bytes()) % 200 == 0:
        page = result_page(result)
        page.encode()
        if "<x/>" in page:
            raise AssertionError("a name is HTML of the page")


def read_beside(path: Path) -> None:
    """Read the result that a table of curves belongs to."""
    from symgen.identification.estimate import read_estimate
    from symgen.identification.prediction import read_prediction

    if path.suffix == ".npz":
        found = read_estimate(path.parent)
        _finite(*(array for x in found.traces for array in (x.t, x.measured, x.predicted)))
    else:
        prediction = read_prediction(path.parent)
        _finite(prediction.torque.t, prediction.torque.measured, prediction.kinetic)


def read_parameters(path: Path, model: list[Any] = []) -> None:  # noqa: B006  (derived once)
    """Read parameters of planar2r."""
    import symgen
    from symgen.identification.parameters import read_parameters

    if not model:
        model.append(symgen.derive(symgen.read_robot("planar2r"), ()))
    _finite(read_parameters(path, model[0]))


#: Reader: name of the file that it gets, and what reads it.
READERS: dict[str, tuple[str, Callable[[Path], None]]] = {
    "toml": ("robot.toml", read_robot),
    "urdf": ("robot.urdf", read_robot),
    "par": ("robot.par", read_robot),
    "mjcf": ("robot.xml", read_robot),
    "csv": ("log.csv", read_log),
    "npz": ("log.npz", read_log),
    "parquet": ("log.parquet", read_log),
    "mcap": ("log.mcap", read_log),
    "db3": ("bag/bag.db3", read_log),
    "columns": ("map/columns.toml", read_map),
    "motion": ("motion.csv", read_motion),
    "estimate": ("estimate.json", read_result),
    "curves": ("estimate/curves.npz", read_beside),
    "diagnosis": ("diagnosis/diagnosis.json", read_result),
    "prediction": ("prediction/prediction.json", read_result),
    "predicted": ("predicted/prediction.csv", read_beside),
    "payload": ("payload.json", read_result),
    "parameters": ("parameters.toml", read_parameters),
    "values": ("values.json", read_parameters),
}


class Late(BaseException):
    """An input took too long; nothing that reads catches it."""


def fault_of(read: Callable[[Path], None], path: Path) -> str | None:
    """Return what is wrong with how a file is read; "" where it is refused, None where not."""
    from symgen.errors import SymgenError, plain

    def late(*_: object) -> None:
        raise Late(f"more than {SECONDS:g} s")

    signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, SECONDS)
    try:
        read(path)
    except SymgenError as error:
        text = str(error)
        if plain(text) != text or not text or len(text) > LONGEST:
            return f"a message that is not one plain line: {text[:200]!r}"
        return ""
    except (Exception, Late) as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        text = f"{type(error).__name__}: {str(error)[:100]}"
        return f"{text} at {last.filename.rsplit('/', 1)[-1]}:{last.lineno}"
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
    return None


def main() -> None:
    """Read the inputs that the command line asks for."""
    import resource

    reader, folder, first, count = sys.argv[1], Path(sys.argv[2]), *map(int, sys.argv[3:])
    name, read = READERS[reader]
    files = sorted((folder / "seeds").iterdir())
    seeds = [p.read_bytes() for p in files]
    place = folder / "in" / name
    place.parent.mkdir(parents=True, exist_ok=True)
    os.chdir(folder / "empty")
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    warnings.simplefilter("ignore")
    for seed in files:  # what is spoiled must be good, or refused in a line
        place.write_bytes(seed.read_bytes())
        if (fault := fault_of(read, place)) != ("" if seed.name.startswith("refused") else None):
            raise AssertionError(f"seed {seed.name}: {fault or 'refused, or not'}")
    faults: list[list[object]] = []
    refused, slowest = 0, 0.0
    last = os.open(folder / "last", os.O_WRONLY | os.O_CREAT)
    for k in range(first, first + count):
        os.pwrite(last, b"%12d" % k, 0)
        place.unlink()  # to write over it would wait for the disk
        place.write_bytes(mutated(seeds, random.Random(f"{reader} {k}")))
        begun = time.monotonic()
        fault = fault_of(read, place)
        slowest = max(slowest, time.monotonic() - begun)
        if fault:
            faults.append([k, fault])
        refused += fault == ""
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    done = {"faults": faults, "refused": refused, "slowest": slowest, "memory": memory}
    print(json.dumps(done))


if __name__ == "__main__":
    main()

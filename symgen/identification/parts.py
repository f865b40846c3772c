"""Which logs a run on a data set has: stretches that train, that are held out, that are sampled."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from symgen.data.dataset import DataSet, is_data_set, listed_files
from symgen.data.log import Log
from symgen.data.stretch import Stretch
from symgen.data.tables import COUNTED
from symgen.errors import LogError
from symgen.estimation.logs import HELD_OUT, Source
from symgen.estimation.partition import Part
from symgen.estimation.recipe import Recipe

Progress = Callable[[str], None]
#: Samples, of all training and of all validation logs, that are looked at in memory; stretches.
SAMPLE, HELD_SAMPLE, PIECES = 80_000, 20_000, 4
#: Samples from which logs are read chunk by chunk, and bytes under which no file has so many.
LONG, _LIGHT = 250_000, 4 << 20
#: A log has so many windows and samples, at least.
_WINDOWS, _FEWEST = 2.0, 20


def is_long(sources: Sequence[Source], plain: bool) -> bool:
    """Whether logs are read chunk by chunk: a data set, or Parquet and NPZ files of many samples.

    Args:
        sources: the logs.
        plain: whether least squares is asked for and nothing that needs all logs in memory.
    """
    if any(map(is_data_set, sources)):
        return True
    paths = [Path(s) for s in sources if isinstance(s, (str, Path))]
    known = [p for p in paths if p.suffix.lower() in COUNTED and p.is_file()]
    if not plain or not known or len(known) < len(sources):
        return False
    if sum(p.stat().st_size for p in known) < _LIGHT:
        return False
    return sum(COUNTED[p.suffix.lower()](p) for p in known) > LONG


def paths_of(sources: Sequence[Source]) -> list[str | Path]:
    """Return logs as paths.

    Raises:
        LogError: one is in memory.
    """
    for source in sources:
        if isinstance(source, Log):
            raise LogError(f"{source.name}: is in memory; accepted: files for chunks and workers")
    return [source for source in sources if not isinstance(source, Log)]


def parts_of(
    data: DataSet,
    logs: Sequence[str | Path],
    validation: Sequence[str | Path],
    recipes: Sequence[Recipe],
    progress: Progress,
) -> tuple[list[Part], tuple[str, ...]]:
    """Find the stretches of all files and hold some of them out; say which are too short."""
    files, held_files = listed_files(logs), listed_files(validation)
    both = sorted(set(files) & set(held_files))
    if both:
        raise LogError(f"{both[0]}: trains and validates; accepted: another log to validate")
    progress(f"finding the stretches of {len(files) + len(held_files)} files")
    window = max(recipe.gap for recipe in recipes)
    out: list[Part] = []
    short: list[str] = []
    for name in (*files, *held_files):
        for s in data.stretches(name):
            kinds = _split(s) if not held_files else [(s, "train")]
            if name in held_files:
                kinds = [(s, "validation")]
            if all(_long(own, window) for own, _ in kinds):
                out += [Part(own, kind) for own, kind in kinds]
            else:
                short.append(s.name)
    for kind in ("train", "validation"):
        if not any(p.kind == kind for p in out):
            listed = ", ".join(short[:3])
            raise LogError(f"{listed}: too short a {kind} log; accepted: longer ones, without gaps")
    if not short:
        return out, ()
    listed = ", ".join(short[:3]) + (", ..." if len(short) > 3 else "")
    return out, (f"{len(short)} stretches are too short and left out: {listed}",)


def _long(s: Stretch, window: float) -> bool:
    return s.count >= _FEWEST and s.times[1] - s.times[0] > _WINDOWS * window


def _split(s: Stretch) -> list[tuple[Stretch, str]]:
    """Hold out the last fifth of a stretch."""
    count = int(s.count * (1 - HELD_OUT))
    edge = s.rows[0] + count
    at = s.times[0] + s.step * count
    early = replace(s, rows=(s.rows[0], edge), times=(s.times[0], at - s.step))
    late = replace(s, name=f"{s.name} (last fifth)", rows=(edge, s.rows[1]), times=(at, s.times[1]))
    return [(early, "train"), (late, "validation")]


def sampled_spans(parts: Sequence[Part], kind: str, budget: int) -> list[tuple[Part, int, int]]:
    """Return rows of the parts of a kind that are looked at: all, or pieces evenly over them."""
    own = [p for p in parts if p.kind == kind]
    counts = np.array([p.stretch.count for p in own])
    total = int(counts.sum())
    if total <= budget:
        return [(p, *p.stretch.rows) for p in own]
    before, length = np.concatenate([[0], np.cumsum(counts)]), budget // PIECES
    out: dict[tuple[int, int], tuple[Part, int, int]] = {}
    for k in range(PIECES):
        place = (k * total) // PIECES
        number = int(np.searchsorted(before, place, side="right")) - 1
        first, last = own[number].stretch.rows
        begin = max(min(first + place - int(before[number]), last - length), first)
        out[number, begin] = (own[number], begin, min(begin + length, last))
    return list(out.values())

"""Who does the work: this process, workers on this machine, or a Dask cluster; and what is kept.

    items --executor--> result of each, as bytes --written whole--> work folder --> whoever merges

Tasks are values that travel: source and settings, no compiled handle, no open file. Each result is
a file named by the digest of all that it depends on: what an interrupted run has finished is found
again, a task that ran twice, since its worker was killed, writes the same file twice, and nothing
is counted twice. The only module that imports Dask.
"""

from __future__ import annotations

import hashlib
import importlib
import os
import re
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any, TypeVar

from symgen.errors import SymgenError
from symgen.files import replace_whole

Item = TypeVar("Item")
Result = TypeVar("Result")
_MOST = 4  # threads of this process: one reads for them all, and each holds a chunk
_AHEAD = 3  # items a worker that are handed out at once
_RETRIES = 3  # of an item whose workers die
_PREPARED = 20  # s in which a worker has loaded a model
_SHA = 32  # bytes of a SHA-256
_PIECE = re.compile(r"[0-9a-f]{64}(\.npz|-\d+-\d+\.rows)")


#: Who is told what is being done, and which part is done, from 0 to 1.
Say = Callable[[str], None]
Meter = Callable[[float], None]


def silent(_: object) -> None:
    """Tell nobody."""


@dataclass(frozen=True)
class Workers:
    """Who does the work of `identify` and `study`, and where it is kept.

    Attributes:
        processes: on this machine; None for this process, and as many threads as it has cores, at
            most four, where items are worked on in parts; 1 for one thread of it; more need Dask.
        scheduler: address of a Dask scheduler, which is used and left running.
        work: folder in which a run that is interrupted keeps what is finished; a study keeps
            nothing.

    Raises:
        SymgenError: no such number of processes, or both are given.
    """

    processes: int | None = None
    scheduler: str | None = None
    work: str | Path | None = None

    def __post_init__(self) -> None:
        if self.processes is not None and self.scheduler is not None:
            raise SymgenError("--workers and --scheduler; accepted: one of them")
        if self.processes is not None and self.processes < 1:
            raise SymgenError(f"--workers {self.processes}; accepted: 1 or more")


class Executor:
    """Who works: this process, one item after the other.

    Attributes:
        workers: how many items are worked on at once.
        threads: that each of them may use.
    """

    workers = 1

    def __init__(self, threads: int = 1) -> None:
        """Take the threads that an item may use."""
        self.threads = threads

    def prepare(self, call: Callable[[], object]) -> None:
        """Have every other process that works load what items need, while there are none yet."""

    def results(
        self, task: Callable[[Item], bytes], items: Sequence[Item]
    ) -> Iterator[tuple[int, bytes]]:
        """Yield the number of an item and its result, as they are done."""
        for k, item in enumerate(items):
            yield k, task(item)


class OnDask(Executor):
    """Workers of a Dask cluster; a killed one's items go to another."""

    def __init__(self, client: Any) -> None:
        """Take a client of the cluster."""
        super().__init__()
        self._client = client
        self._known = list(client.scheduler_info(n_workers=-1)["workers"])
        self._prepared: list[Any] = []
        self.workers = max(1, len(self._known))

    def prepare(self, call: Callable[[], object]) -> None:
        """Have every worker load what items need: what goes wrong there, items will tell."""
        self._prepared = [  # a future that nobody holds is not worked on
            self._client.submit(_prepared, call, workers=[worker], pure=False)
            for worker in self._known
        ]

    def settled(self) -> None:
        """Wait until workers have loaded what they were to prepare, well or not."""
        with suppress(TimeoutError):
            for future in self._prepared:
                future.exception(timeout=_PREPARED)

    def results(
        self, task: Callable[[Item], bytes], items: Sequence[Item]
    ) -> Iterator[tuple[int, bytes]]:
        """Yield the number of an item and its result, as they are done."""
        library: Any = importlib.import_module("distributed")
        waiting, number = iter(enumerate(items)), dict[str, int]()

        def submit(k: int, item: Item) -> Any:
            # The task goes with each item: what one worker alone held would die with it.
            future = self._client.submit(_call, task, item, pure=False, retries=_RETRIES)
            number[future.key] = k
            return future

        first = [submit(*pair) for pair in islice(waiting, _AHEAD * self.workers)]
        pending = library.as_completed(first, loop=self._client.loop)
        for future in pending:
            content = future.result()
            k = number.pop(future.key)
            future.release()
            more = next(waiting, None)
            if more is not None:
                pending.add(submit(*more))
            yield k, content


def _call(task: Callable[[Item], bytes], item: Item) -> bytes:
    return task(item)


def _prepared(call: Callable[[], object]) -> None:
    call()  # what it returns stays there


def own_threads() -> int:
    """Return how many threads of this process work at once: one a core, at most four."""
    try:
        cores = len(os.sched_getaffinity(0))
    except AttributeError:  # not on this system
        cores = os.cpu_count() or 1
    return min(cores, _MOST)


def in_turn(
    function: Callable[[Item], Result], items: Iterable[Item], threads: int
) -> Iterator[Result]:
    """Yield the results of some items in their order; while one is awaited, others are worked on.

    What fails is raised in its turn, whether an item or its result cannot be had: the same error
    whatever the number of threads.

    Args:
        function: from an item to its result, at home in any thread.
        items: taken one by one as there is room, in the thread that asks.
        threads: items that are worked on at once.
    """
    if threads == 1:
        yield from map(function, items)
        return
    lost: list[Exception] = []

    def taken() -> Iterator[Item]:
        try:
            yield from items
        except Exception as error:
            lost.append(error)

    with ThreadPoolExecutor(threads) as pool:
        begun: deque[Future[Result]] = deque()
        try:
            for item in taken():
                begun.append(pool.submit(function, item))
                if len(begun) == threads:
                    yield begun.popleft().result()
            while begun:
                yield begun.popleft().result()
            if lost:
                raise lost.pop()
        finally:
            for future in begun:  # of no use where one has failed
                future.cancel()


@contextmanager
def executor(asked: Workers | None = None) -> Iterator[Executor]:
    """Give an executor, and end what was started for it.

    Raises:
        SymgenError: Dask is not installed, or no scheduler answers there.
    """
    workers, scheduler = (None, None) if asked is None else (asked.processes, asked.scheduler)
    if scheduler is None and workers in (None, 1):
        yield Executor(1 if workers == 1 else own_threads())
        return
    try:
        library: Any = importlib.import_module("distributed")
    except ImportError as error:
        what = "--workers and --scheduler need Dask"
        raise SymgenError(f"{what}; accepted: pip install symgen[dask]") from error
    if scheduler is not None:
        try:
            client = library.Client(scheduler, timeout=10, set_as_default=False)
        except (OSError, ValueError) as error:
            what = " ".join(str(error).split())
            raise SymgenError(
                f"--scheduler {scheduler}: {what}; accepted: the address of a Dask scheduler, "
                "tcp://HOST:8786"
            ) from error
        with client:
            yield OnDask(client)
        return
    # Workers hold what one chunk needs, and are not restarted for it by a guess of their limit.
    # Dask has them give every array back to the system at once, and take it again page by page: a
    # chunk takes twice as long, which two workers just make up for.
    kept = {"distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_": None}
    with (
        importlib.import_module("dask").config.set(kept),
        library.LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            processes=True,
            memory_limit=0,
            dashboard_address=None,
        ) as cluster,
        library.Client(cluster, set_as_default=False) as client,
    ):
        by = OnDask(client)
        try:
            yield by
        except Exception:
            by.settled()  # workers that are ended at work have Dask say so before the error does
            raise


def digest(*parts: str | bytes) -> str:
    """Return the SHA-256 of some texts, each with its length, in hexadecimal."""
    sha = hashlib.sha256()
    for part in parts:
        content = os.fsencode(part)
        sha.update(f"{len(content)}:".encode())
        sha.update(content)
    return sha.hexdigest()


def keep(path: Path, content: bytes) -> None:
    """Write a piece of work, with its SHA-256 behind it, whole or not at all."""
    replace_whole(path, content + hashlib.sha256(content).digest())


def kept(path: Path) -> bytes | None:
    """Return a piece of work, None where there is none or its SHA-256 does not fit."""
    try:
        whole = path.read_bytes()
    except OSError:
        return None
    content, sha = whole[:-_SHA], whole[-_SHA:]
    return content if content and hashlib.sha256(content).digest() == sha else None


class WorkFolder:
    """Results by key, each written whole or not at all, and read only as it was written."""

    def __init__(self, folder: Path) -> None:
        """Make the folder, where it is absent, and remove what killed runs left unfinished."""
        self.folder = folder
        folder.mkdir(parents=True, exist_ok=True)

    def _file(self, key: str) -> Path:
        return self.folder / f"{key}.npz"

    def __contains__(self, key: str) -> bool:
        return kept(self._file(key)) is not None

    def damaged(self, key: str) -> bool:
        """Whether there is a result that is not as it was written."""
        return os.path.lexists(self._file(key)) and key not in self

    def write(self, key: str, content: bytes) -> None:
        """Keep a result."""
        keep(self._file(key), content)

    def read(self, key: str) -> bytes:
        """Return a result.

        Raises:
            SymgenError: it was changed or removed while this run needed it.
        """
        content = kept(self._file(key))
        if content is None:
            raise SymgenError(
                f"{self._file(key)}: was changed or removed during the run; run the same command "
                "again, and no other one with this folder"
            )
        return content

    def remove(self) -> None:
        """Remove what runs kept here, and the folder where nothing else is in it."""
        with suppress(OSError):  # somebody put something into it
            for path in self.folder.iterdir():
                if _PIECE.fullmatch(path.name):
                    path.unlink(missing_ok=True)
            self.folder.rmdir()


def finished(
    by: Executor,
    task: Callable[[Item], bytes],
    items: Sequence[Item],
    keys: Sequence[str],
    folder: WorkFolder,
    sizes: Sequence[int],
    progress: Say = silent,
    what: str = "",
    unit: str = "samples",
) -> None:
    """Work on all items whose results are not there.

    Args:
        by: who works.
        task: from an item to its result.
        items: what is worked on.
        keys: of their results: digests of all that a result depends on.
        folder: where results are kept.
        sizes: samples of each item, for progress.
        progress: is told how many samples a second are done, and the time left.
        what: is done, in words.
        unit: of the sizes.
    """
    left = [k for k, key in enumerate(keys) if key not in folder]
    damaged = sum(folder.damaged(keys[k]) for k in left)
    if damaged:
        progress(damaged_pieces(what, damaged))
    total, before = sum(sizes), sum(sizes) - sum(sizes[k] for k in left)
    if before:
        progress(f"{what}: {before:,} of {total:,} {unit} were finished before")
    done, begin, told = 0, time.monotonic(), time.monotonic()
    for k, content in by.results(task, [items[k] for k in left]):
        folder.write(keys[left[k]], content)
        done += sizes[left[k]]
        now = time.monotonic()
        if now - told > 1.0 or before + done == total:
            rate, told = done / max(now - begin, 1e-9), now
            remaining = (total - before - done) / max(rate, 1e-9)
            progress(
                f"{what}: {before + done:,} of {total:,} {unit}, {_rate(rate)} a second, "
                f"{remaining:.0f} s left"
            )


def damaged_pieces(what: str, count: int) -> str:
    """Say that kept pieces of work are computed again."""
    return f"{what}: damaged pieces of an earlier run, computed again: {count}"


def _rate(rate: float) -> str:
    return f"{rate:,.0f}" if rate >= 10 else f"{rate:.2g}"

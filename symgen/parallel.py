"""Work on items side by side, in threads or by any executor, and whom to tell of progress."""

from __future__ import annotations

import importlib
import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager, nullcontext
from typing import Any, TypeVar

from symgen.errors import SymgenError

Item = TypeVar("Item")
Result = TypeVar("Result")
#: Who is told what is being done, and which part is done, from 0 to 1.
Say = Callable[[str], None]
Meter = Callable[[float], None]
_MOST = 4  # threads of this process: each holds what it works on


def silent(_: object) -> None:
    """Tell nobody."""


def own_threads() -> int:
    """Return how many threads of this process work at once: one a core, at most four."""
    try:
        cores = len(os.sched_getaffinity(0))
    except AttributeError:  # not on this system
        cores = os.cpu_count() or 1
    return min(cores, _MOST)


def in_order(
    function: Callable[[Item], Result],
    items: Iterable[Item],
    threads: int,
    executor: Executor | None = None,
) -> Iterator[Result]:
    """Yield the results of some items in their order; while one is awaited, others are worked on.

    What fails is raised in its turn, and what is not begun by then is left.

    Args:
        function: from an item to its result, at home in any thread.
        items: what is worked on.
        threads: items that are worked on at once; each is taken when there is room.
        executor: that works instead of threads; it is given all items, and stays open.
    """
    if executor is None and threads == 1:
        yield from map(function, items)
        return
    begun: deque[Future[Result]] = deque()
    pool = ThreadPoolExecutor(threads) if executor is None else nullcontext(executor)
    with pool as by:
        try:
            for item in items:
                begun.append(by.submit(function, item))
                if executor is None and len(begun) == threads:
                    yield begun.popleft().result()
            while begun:
                yield begun.popleft().result()
        finally:
            for future in begun:
                future.cancel()


@contextmanager
def executor_of(workers: int | None, scheduler: str | None) -> Iterator[Executor | None]:
    """Give the executor of --workers or --scheduler, and end what was started for it.

    Args:
        workers: number of processes; 1 for one thread of this process.
        scheduler: address of a Dask scheduler, which is used and left running.

    Raises:
        SymgenError: both are given, Dask is not installed, or no scheduler answers there.
    """
    if workers is not None and scheduler is not None:
        raise SymgenError("--workers and --scheduler; accepted: one of them")
    if scheduler is not None:
        with _client(scheduler) as client:
            yield client.get_executor()
    elif workers is None:
        yield None
    elif workers == 1:
        with ThreadPoolExecutor(1) as thread:
            yield thread
    else:
        from multiprocessing import get_context

        # a fork would copy the locks of other threads
        with ProcessPoolExecutor(workers, get_context("spawn")) as processes:
            yield processes


def _client(scheduler: str) -> Any:
    try:
        library: Any = importlib.import_module("distributed")
    except ImportError as error:
        raise SymgenError("--scheduler needs Dask; accepted: pip install symgen[dask]") from error
    try:
        return library.Client(scheduler, timeout=10, set_as_default=False)
    except (OSError, ValueError) as error:
        what = " ".join(str(error).split())
        raise SymgenError(
            f"--scheduler {scheduler}: {what}; accepted: the address of a Dask scheduler, "
            "tcp://HOST:8786"
        ) from error

"""Parallel work in threads or in any executor, and callbacks for progress."""

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
#: Callbacks for the current step as text, and for the finished share, from 0 to 1.
Say = Callable[[str], None]
Meter = Callable[[float], None]
_MOST = 4  # maximum number of threads in this process; each one needs memory for its work


def silent(_: object) -> None:
    """Report no progress."""


def thread_count() -> int:
    """Return the number of threads of this process to use: one a core, at most four."""
    try:
        cores = len(os.sched_getaffinity(0))
    except AttributeError:  # missing on this system
        cores = os.cpu_count() or 1
    return min(cores, _MOST)


def in_order(
    function: Callable[[Item], Result],
    items: Iterable[Item],
    threads: int,
    executor: Executor | None = None,
) -> Iterator[Result]:
    """Yield the results of items in their order; later items are already in progress.

    An error is raised when the result of its item is due. Items that have not started are
    cancelled.

    Args:
        function: computes the result of an item; it must be thread-safe.
        items: the items; the iterator is read as threads become free.
        threads: number of items at once.
        executor: replaces the threads. It gets all items at once, and stays open.
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
    """Yield the executor of --workers or --scheduler, and stop the processes that it started.

    Args:
        workers: number of processes; 1 for one thread of this process.
        scheduler: address of a Dask scheduler, which keeps running.

    Raises:
        SymgenError: both options are set, Dask is not installed, or no scheduler answers at the
            address.
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

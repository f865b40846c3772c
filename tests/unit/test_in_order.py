"""Items worked on by threads: their order, how many at once, and what fails."""

from __future__ import annotations

import os
import threading
import time

import pytest

from symgen.errors import SymgenError
from symgen.parallel import executor_of, in_order, thread_count


@pytest.mark.parametrize("threads", [1, 2, 3, 20])
def test_results_come_in_the_order_of_their_items_whichever_is_done_first(threads: int) -> None:
    def slow(k: int) -> int:
        time.sleep(0.002 * (7 * k % 5))
        return k * k

    assert list(in_order(slow, range(12), threads)) == [k * k for k in range(12)]
    assert list(in_order(slow, [], threads)) == []


@pytest.mark.parametrize("threads", [1, 2, 4])
def test_no_more_items_are_taken_than_are_worked_on(threads: int) -> None:
    lock, now, most, taken, given = threading.Lock(), 0, 0, 0, 0

    def items():
        nonlocal taken
        for k in range(20):
            taken += 1
            assert taken - given <= threads  # each of them holds its part of the memory
            yield k

    def work(k: int) -> int:
        nonlocal now, most
        with lock:
            now += 1
            most = max(most, now)
        time.sleep(0.01)
        with lock:
            now -= 1
        return k

    for _ in in_order(work, items(), threads):
        given += 1
    assert given == taken == 20
    assert most == threads


@pytest.mark.parametrize("threads", [1, 3])
def test_what_fails_is_raised_in_its_turn_and_ends_the_work(threads: int) -> None:
    begun: list[int] = []

    def fails(k: int) -> int:
        begun.append(k)
        if k == 2:
            raise ValueError("of item 2")
        return k

    found = in_order(fails, range(100), threads)
    assert [next(found), next(found)] == [0, 1]
    with pytest.raises(ValueError, match="of item 2"):
        next(found)
    assert len(begun) <= 2 + threads


def test_threads_are_the_cores_and_an_option_says_another_number(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for cores, threads in ((1, 1), (2, 2), (64, 4)):
        monkeypatch.setattr(os, "sched_getaffinity", lambda _, n=cores: range(n), raising=False)
        assert thread_count() == threads
    with executor_of(None, None) as nobody:
        assert nobody is None
    with executor_of(1, None) as one:
        names = {*in_order(lambda _: threading.current_thread().name, range(5), 4, one)}
        assert len(names) == 1
    with pytest.raises(SymgenError, match="--scheduler"), executor_of(2, "tcp://127.0.0.1:1"):
        pass


@pytest.mark.filterwarnings("default")  # of Dask's own
@pytest.mark.slow
def test_a_scheduler_that_does_not_answer_is_named() -> None:
    pytest.importorskip("distributed")
    address = "tcp://127.0.0.1:9"
    with pytest.raises(SymgenError, match=address), executor_of(None, address):
        pass

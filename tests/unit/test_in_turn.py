"""Items worked on by threads: their order, how many at once, and what fails."""

from __future__ import annotations

import os
import threading
import time

import pytest

from symgen.distributed import Workers, executor, in_turn


@pytest.mark.parametrize("threads", [1, 2, 3, 20])
def test_results_come_in_the_order_of_their_items_whichever_is_done_first(threads: int) -> None:
    def slow(k: int) -> int:
        time.sleep(0.002 * (7 * k % 5))
        return k * k

    assert list(in_turn(slow, range(12), threads)) == [k * k for k in range(12)]
    assert list(in_turn(slow, [], threads)) == []


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

    for _ in in_turn(work, items(), threads):
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

    found = in_turn(fails, range(100), threads)
    assert [next(found), next(found)] == [0, 1]
    with pytest.raises(ValueError, match="of item 2"):
        next(found)
    assert len(begun) <= 2 + threads


@pytest.mark.parametrize("threads", [1, 2, 4])
def test_an_item_that_cannot_be_had_is_told_behind_those_before_it(threads: int) -> None:
    def items(last: int):
        yield from range(last)
        raise OSError(f"no item {last}")

    def works(k: int) -> int:
        time.sleep(0.01)
        if k == 7:
            raise ValueError("of item 7")
        return k

    given = in_turn(works, items(3), threads)
    assert [next(given), next(given), next(given)] == [0, 1, 2]
    with pytest.raises(OSError, match="no item 3"):
        next(given)
    with pytest.raises(ValueError, match="of item 7"):  # whatever could be read behind it
        list(in_turn(works, items(8), threads))


def test_one_worker_is_one_thread_and_the_cores_are_used_where_nothing_is_asked(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for cores, threads in ((1, 1), (2, 2), (64, 4)):
        monkeypatch.setattr(os, "sched_getaffinity", lambda _, n=cores: range(n), raising=False)
        with executor() as by:
            assert (by.workers, by.threads) == (1, threads)
        with executor(Workers(1)) as by:
            assert (by.workers, by.threads) == (1, 1)

"""Order the steps of a tape so that few values are live at any time.

Compilers keep the order of long straight-line code and spill values that do not fit into registers.
A step that does not increase the number of live values comes as early as possible. Other steps keep
the order of the derivation (Goodman and Hsu 1988, with one threshold).
"""

from __future__ import annotations

from heapq import heappop, heappush

from symgen.symbolic.tape import Steps


def scheduled(steps: Steps) -> Steps:
    """Return the steps in a new order that respects their dependencies."""
    place = {symbol: i for i, (symbol, _) in enumerate(steps)}
    needs = [{place[s] for s in expr.free_symbols if s in place} for _, expr in steps]
    users: list[set[int]] = [set() for _ in steps]
    for i, needed in enumerate(needs):
        for k in needed:
            users[k].add(i)
    lasting = [bool(u) for u in users]  # other values are stored and not live
    missing = [len(needed) for needed in needs]
    ready = [i for i, count in enumerate(missing) if count == 0]
    cheap: list[int] = []  # ready steps that do not increase the number of live values
    done: set[int] = set()

    def weigh(i: int) -> None:
        used_up = sum(len(users[k]) == 1 for k in needs[i])
        if missing[i] == 0 and used_up >= lasting[i]:
            heappush(cheap, i)

    for i in ready:
        weigh(i)
    order = []
    while ready or cheap:
        i = heappop(cheap or ready)
        if i in done:
            continue
        done.add(i)
        order.append(steps[i])
        for k in sorted(needs[i]):
            users[k].discard(i)
            if len(users[k]) == 1:
                weigh(next(iter(users[k])))
        for k in sorted(users[i]):
            missing[k] -= 1
            if missing[k] == 0:
                heappush(ready, k)
                weigh(k)
    return tuple(order)

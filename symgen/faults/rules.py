"""Rules: what finds a fault in the channels of a log, how it is undone, and what is said of it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from symgen.faults.fault import LEFT, Fault

_ALIKE = 0.2  # largest difference of values that joints share, relative to their mean


@dataclass(frozen=True, eq=False)
class Symptom:
    """What a rule finds in one channel of a log.

    Attributes:
        channel: "q", "qd" or "tau"; "t" or "all" without a joint.
        joint: index of the joint; None for all of them.
        samples: number of affected samples.
        numbers: numbers of the message, by name.
        values: measured quantities with their standard deviations, by name.
        data: what the undo of the rule needs: a mask (N,), or corrected values (N,).
    """

    channel: str
    joint: int | None
    samples: int
    data: Any = None
    numbers: Mapping[str, float] = field(default_factory=dict)
    values: Mapping[str, tuple[float, float]] = field(default_factory=dict)


def _keep(log: Any, _: Symptom) -> Any:
    return log


@dataclass(frozen=True)
class Rule:
    """A kind of fault.

    Attributes:
        kind: as in `Fault`.
        find: yields what is found in a log.
        message: the fault, with numbers of the findings, {channels} and {log} in braces.
        done: the repair.
        undo: returns a log without what was found; by default the log as it is.
    """

    kind: str
    find: Callable[..., Iterator[Symptom]]
    message: str
    done: str = LEFT
    undo: Callable[[Any, Symptom], Any] = _keep

    def undone(self, log: Any, found: Sequence[Symptom]) -> Any:
        """Return a log without what was found."""
        for finding in found:
            log = self.undo(log, finding)
        return log

    def fault(self, log: str, found: Sequence[Symptom], n: int) -> Fault:
        """Return one fault for everything that was found in a log of this name, with n joints."""
        joints = [f.joint for f in found if f.joint is not None]
        names = [f.channel if f.joint is None else f"{f.channel}{f.joint + 1}" for f in found]
        numbers = {name: _between([f.numbers[name] for f in found]) for name in found[0].numbers}
        every = len({f.channel for f in found}) == 1 and len(joints) == n > 1
        channels = found[0].channel if every else ", ".join(names)
        return Fault(
            log,
            channels,
            self.message.format(channels=channels, log=log, **numbers),
            sum(f.samples for f in found),
            self.done,
            tuple(_values(found, every)),
            kind=self.kind,
            joints=() if every else tuple(dict.fromkeys(joints)),
        )


def _values(found: Sequence[Symptom], every: bool) -> Iterator[tuple[str, float, float]]:
    """Yield the measured quantities of some joints, or of every joint.

    The name of a quantity ends with the number of its joint, if there are several joints. A value
    that all joints share is one of the recorder.
    """
    for name in found[0].values:
        pairs = np.array([f.values[name] for f in found])
        value, std = map(float, pairs.mean(axis=0))
        if len(found) == 1 or (every and np.ptp(pairs[:, 0]) <= _ALIKE * abs(value)):
            yield name, value, std
            continue
        for f, (x, error) in zip(found, pairs.tolist(), strict=True):
            yield f"{name}{(f.joint or 0) + 1}", x, error


def _between(numbers: Iterable[float]) -> str:
    """Return the range of some numbers as text."""
    low, high = (f"{x:.3g}" for x in (min(numbers), max(numbers)))
    return low if low == high else f"{low} to {high}"


def apply(rules: Iterable[Rule], log: Any, *about: Any) -> tuple[Any, tuple[Fault, ...]]:
    """Repair a log by one rule after the other; each sees the earlier repairs.

    Args:
        rules: the rules.
        log: a log, or samples.
        about: further arguments of the finders.
    """
    faults: list[Fault] = []
    for rule in rules:
        found = list(rule.find(log, *about))
        if found:
            log = rule.undone(log, found)
            faults.append(rule.fault(log.name, found, log.q.shape[1]))
    return log, tuple(faults)

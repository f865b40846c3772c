"""Rules: a rule finds a fault in a channel of a log, undoes it, and describes it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from symgen.data.raw import FloatArray
from symgen.faults.channels import moves
from symgen.faults.fault import LEFT, Fault
from symgen.faults.undo import with_column

_ALIKE = 0.2  # largest difference of a value that all joints share, relative to its mean


@dataclass(frozen=True, eq=False)
class Channel:
    """One channel of a log.

    Attributes:
        log: a log as recorded, or its samples.
        key: "q", "qd" or "tau" of a joint; "t", or "all" for all channels.
        joint: index of the joint; None for "t" and "all".
        x: (N,) the values; those of t for "all".
        about: further data for the rule.
    """

    log: Any
    key: str
    joint: int | None
    x: FloatArray
    about: Any

    @property
    def name(self) -> str:
        """Name of the channel, such as "tau2"."""
        return channel_name(self.key, self.joint)

    @property
    def q(self) -> FloatArray:
        """(N,) position of the joint."""
        return np.ascontiguousarray(self.log.q[:, self.joint])

    @property
    def moves(self) -> bool:
        """Whether the joint moves beyond a few last digits of its position."""
        return moves(self.q)


def channel_name(key: str, joint: int | None) -> str:
    """Return the name of a channel, such as "tau2"."""
    return key if joint is None else f"{key}{joint + 1}"


@dataclass(frozen=True, eq=False)
class Symptom:
    """The evidence of a fault in a channel.

    Attributes:
        samples: number of affected samples.
        data: the data to undo it: a mask (N,), or corrected values (N,).
        numbers: numbers for the message, by name.
        values: measured quantities and their standard deviations, by name.
    """

    samples: int
    data: Any = None
    numbers: Mapping[str, float] = field(default_factory=dict)
    values: Mapping[str, tuple[float, float]] = field(default_factory=dict)


Findings = Sequence[tuple[Channel, Symptom]]


def _keep(log: Any, *_: object) -> Any:
    return log


@dataclass(frozen=True)
class Rule:
    """A kind of fault.

    Attributes:
        kind: as in `Fault`.
        keys: keys of the channels that can have it.
        find: returns the symptom of a channel, or None.
        message: description of the fault, with numbers of the symptoms, {channels} and {log} in
            braces.
        done: description of the repair.
        undo: returns a log without the fault, from the log, the channel and the data of the
            symptom; by default the unchanged log.
    """

    kind: str
    keys: tuple[str, ...]
    find: Callable[[Channel], Symptom | None]
    message: str
    done: str = LEFT
    undo: Callable[[Any, Channel, Any], Any] = _keep

    def search(self, log: Any, about: Any = None) -> Findings:
        """Return the channels of a log with the fault, and their symptoms."""
        findings = []
        for channel in _channels(log, self.keys, about):
            if symptom := self.find(channel):
                findings.append((channel, symptom))
        return findings

    def fault(self, findings: Findings) -> Fault:
        """Return one fault for all symptoms in a log."""
        first, symptom = findings[0]
        names = [c.name for c, _ in findings]
        of_joints = [c.joint for c, _ in findings if c.joint is not None]
        joints = tuple(dict.fromkeys(of_joints))
        width = first.log.q.shape[1]
        channels_of_key = {channel_name(first.key, j) for j in range(width)}
        every = len(joints) > 1 and {*names} == channels_of_key
        channels = first.key if every else ", ".join(names)
        numbers = {}
        for name in symptom.numbers:
            numbers[name] = _between([s.numbers[name] for _, s in findings])
        return Fault(
            first.log.name,
            channels,
            self.message.format(channels=channels, log=first.log.name, **numbers),
            sum(f.samples for _, f in findings),
            self.done,
            tuple(_values(findings, every)),
            kind=self.kind,
            joints=() if every else joints,
        )


def _channels(log: Any, keys: Iterable[str], about: Any) -> Iterator[Channel]:
    """Yield the channels of a log with these keys."""
    for key in keys:
        x = log.t if key in ("t", "all") else getattr(log, key)
        if x is not None and x.ndim == 1:
            yield Channel(log, key, None, x, about)
        elif x is not None:
            for j, column in enumerate(x.T):
                yield Channel(log, key, j, np.ascontiguousarray(column), about)


def _values(findings: Findings, every: bool) -> Iterator[tuple[str, float, float]]:
    """Yield the measured quantities of some joints, or of every joint.

    The name of a quantity ends with its joint number if there are several joints. A value that all
    joints share belongs to the recorder.
    """
    for name in findings[0][1].values:
        pairs = np.array([symptom.values[name] for _, symptom in findings])
        value, std = pairs.mean(axis=0).tolist()
        spread = np.ptp(pairs[:, 0])
        shared = every and spread <= _ALIKE * abs(value)
        if len(findings) == 1 or shared:
            yield name, value, std
            continue
        for (channel, _), (x, error) in zip(findings, pairs.tolist(), strict=True):
            number = channel.name.removeprefix(channel.key)
            yield f"{name}{number}", x, error


def _between(numbers: Sequence[float]) -> str:
    """Return the range of some numbers as text."""
    low = f"{min(numbers):.3g}"
    high = f"{max(numbers):.3g}"
    return low if low == high else f"{low} to {high}"


def with_values(log: Any, c: Channel, x: FloatArray) -> Any:
    """Return a log, or samples, with other values (N,) of a channel: the undo of many rules."""
    return with_column(log, c.key, c.joint or 0, x)


def apply(rules: Iterable[Rule], log: Any, about: Any = None) -> tuple[Any, tuple[Fault, ...]]:
    """Repair a log by one rule after the other; each rule gets the log with the earlier repairs.

    Args:
        rules: the rules.
        log: a log, or samples.
        about: further data for the rules.
    """
    faults: list[Fault] = []
    for rule in rules:
        if findings := rule.search(log, about):
            for channel, symptom in findings:
                log = rule.undo(log, channel, symptom.data)
            faults.append(rule.fault(findings))
    return log, tuple(faults)

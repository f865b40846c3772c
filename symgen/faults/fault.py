"""A fault of a recorder: what it is, where, how large, and how it is undone."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from typing import Annotated, Any

from symgen.schemas import BESIDE, OrNan

#: Done about a fault that nothing takes away.
LEFT = "left as it is"
#: Kinds that take samples out of the equations.
MASKED = ("saturated", "stuck")

#: Name of the log of a fault that all logs have together.
EVERYWHERE = "all logs"


@dataclass(frozen=True)
class Fault:
    """What is wrong with channels of a log, and what was done.

    JSON holds the first five and `values`; programs decide by `kind`.

    Attributes:
        log: name of the log, or EVERYWHERE.
        channel: "t", "q2", "tau2, tau4", "tau" for all joints, or "all".
        fault: in words, with the value.
        samples: how many it touches; 0 for whole columns.
        done: in words.
        values: of what was measured: name, value and standard deviation; GV of speeds that are
            (1 + GV) dq/dt, LV s late, and off by OV; DT s by which torques of all joints were late
            and are shifted; limit of a torque that is cut off.
        kind: one of the keys of `symgen.faults.samples.FINDERS` and `symgen.faults.model.FINDERS`.
        joints: positions of the joints; empty for all.
        value: factor, or delay in s.
        share: error on folds left out with the fault undone, over that as it is.
        undo: gives the log that it was found in without it; None where no way is known, and where
            it was undone.
    """

    log: str
    channel: str
    fault: str
    samples: int = 0
    done: str = LEFT
    values: tuple[tuple[str, float, OrNan], ...] = ()
    kind: Annotated[str, BESIDE] = field(default="", compare=False)
    joints: Annotated[tuple[int, ...], BESIDE] = field(default=(), compare=False)
    value: Annotated[float, BESIDE] = field(default=0.0, compare=False)
    share: Annotated[float, BESIDE] = field(default=1.0, compare=False)
    undo: Annotated[Callable[[Any], Any] | None, BESIDE] = field(
        default=None, compare=False, repr=False
    )

    @property
    def in_words(self) -> str:
        """The fault in one line."""
        samples = f", {self.samples} samples" if self.samples else ""
        return f"{self.log}: {self.channel}: {self.fault}{samples}: {self.done}"


def fault_of(
    log: str,
    kind: str,
    key: str,
    j: int,
    says: str,
    samples: int,
    done: str = LEFT,
    undo: Callable[[Any], Any] | None = None,
) -> Fault:
    """Return the fault of the channel `key` (q, qd or tau) of a joint."""
    channel = f"{key}{j + 1}"
    return Fault(log, channel, says, samples, done, kind=kind, joints=(j,), undo=undo)


def delay_of(fault: Fault) -> float:
    """Return by how much the torques of all joints are shifted, DT in s; 0 where they are not."""
    return sum(value for name, value, _ in fault.values if name == "DT")


def undo_faults(log: Any, faults: Iterable[Fault]) -> tuple[Any, tuple[Fault, ...]]:
    """Return a log without faults, one after the other, and the faults, which need no undo now."""
    told = []
    for fault in faults:
        log = fault.undo(log) if fault.undo else log
        told.append(replace(fault, undo=None))
    return log, tuple(told)


def merged(faults: Iterable[Fault]) -> list[Fault]:
    """Return one fault for each log, channel and kind: what chunks say of one fault.

    Figures, which differ a little from chunk to chunk, are the first's.
    """
    out: dict[tuple[str, str, str], Fault] = {}
    for f in faults:
        known = out.get((f.log, f.channel, f.kind))
        samples = f.samples + (known.samples if known else 0)
        out[f.log, f.channel, f.kind] = replace(known or f, samples=samples)
    return list(out.values())

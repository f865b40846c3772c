"""What logs of a floating base can show: the exact ranks of the equations that they contain."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from symgen.codegen.derivations import Derivations
from symgen.codegen.model import Model
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.floating import touching
from symgen.identification.estimate import EquationRank, Identifiable, Lift
from symgen.robot.tables import Contact
from symgen.robot.toml_text import robot_toml
from symgen.robot.types import Robot
from symgen.symbolic.ranks import EquationPart, Rank, exact_ranks

_Parts = Sequence[EquationPart]


def identifiable(model: Model, logs: Sequence[FilteredLog]) -> Identifiable:
    """Return which inertial parameters the logs can determine, by their forces and contacts.

    Args:
        model: the model of a robot with a floating base.
        logs: the training logs.
    """
    shares = _shares(model.robot, logs)
    parts = [*shares]
    lifted = _lifted(model.robot, logs, usual=parts[0])
    systems: list[_Parts] = [*([part] for part in parts), parts]
    every = [*parts, *lifted.values()]
    others = [[part for part in every if part is not other] for other in lifted.values()]
    ranks = _ranks(model, [*systems, every, *others])
    equations = [
        _equation_rank(part, shares[part], rank) for part, rank in zip(parts, ranks, strict=False)
    ]
    in_all, *without = ranks[len(systems) :]
    together = ranks[len(parts)]
    last = EquationRank("all", (), False, 1.0, together.rank, together.unknown)
    needed: dict[tuple[str, ...], list[str]] = {}
    for name in together.unknown:
        pairs = zip(lifted, without, strict=True)
        needs = [frames for frames, rank in pairs if name in rank.unknown]
        contacts = () if name in in_all.unknown else tuple(f for frames in needs for f in frames)
        needed.setdefault(contacts, []).append(name)
    lifts = tuple(Lift(contacts, tuple(names)) for contacts, names in needed.items())
    return Identifiable(model.inertial, (*equations, last), lifts)


def _ranks(model: Model, systems: Sequence[_Parts]) -> list[Rank]:
    """Return the exact ranks of systems of equations, from the cache if they are known."""
    kept = Derivations.by(robot_toml(model.robot), repr(systems))
    return kept.have("ranks", lambda: exact_ranks(model.robot, model.base, systems))


def _equation_rank(part: EquationPart, share: float, rank: Rank) -> EquationRank:
    kind = "contacts" if part.contacts else part.rows
    contacts = tuple(contact.frame for contact in part.contacts)
    return EquationRank(kind, contacts, part.flight, share, rank.rank, rank.unknown)


def never_lifted(robot: Robot, logs: Sequence[FilteredLog]) -> list[Contact]:
    """Return the contacts with an unknown force in every sample of all logs."""
    always = set.intersection(*({*part.contacts} for log in logs for part in _samples(robot, log)))
    return [contact for contact in robot.contacts if contact in always]


def _lifted(
    robot: Robot, logs: Sequence[FilteredLog], usual: EquationPart
) -> dict[tuple[str, ...], EquationPart]:
    """Return motions that lift a link whose contacts never lift, by the frames of these.

    Args:
        robot: the robot.
        logs: its logs.
        usual: the equations with the other contacts.
    """
    links: dict[int, list[Contact]] = {}
    for contact in never_lifted(robot, logs):
        links.setdefault(robot.frame(contact.frame).joint, []).append(contact)
    out = {}
    for contacts in links.values():
        rest = tuple(contact for contact in usual.contacts if contact not in contacts)
        flight = not rest and logs[0].samples.forces is None
        out[tuple(c.frame for c in contacts)] = EquationPart(contacts=rest, flight=flight)
    return out


def _shares(robot: Robot, logs: Sequence[FilteredLog]) -> Mapping[EquationPart, float]:
    """Return the kinds of equations in logs, with their shares of the samples, most first.

    Without unknown forces, the equations of the base and those of the joints are two kinds.
    """
    samples = sum((_samples(robot, log) for log in logs), Counter[EquationPart]())
    alone = ("base", "joints") if robot.n else ("base",)
    out: dict[EquationPart, float] = {}
    for part in sorted(samples, key=lambda part: (-samples[part], str(part))):
        rows = ("all",) if part.contacts else alone
        out |= {replace(part, rows=row): samples[part] / samples.total() for row in rows}
    return out


def _samples(robot: Robot, log: FilteredLog) -> Counter[EquationPart]:
    """Return the number of samples of a log with each set of contacts."""
    samples, flies = log.samples, log.samples.forces is None
    flags = touching(samples)
    if flags is None:
        return Counter({EquationPart(flight=flies): len(samples.t)})
    used = flags if samples.mask is None else flags[~samples.mask.robot]
    out = Counter[EquationPart]()
    for row, count in zip(*np.unique(used, axis=0, return_counts=True), strict=True):
        contacts = tuple(c for c, touches in zip(robot.contacts, row, strict=True) if touches)
        out[EquationPart(contacts=contacts, flight=flies and not contacts)] = int(count)
    return out

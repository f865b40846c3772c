"""What logs of a floating base can show: the exact ranks of the equations that they contain."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import compress

from symgen.codegen.derivations import Derivations
from symgen.codegen.model import Model
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.floating import touching
from symgen.identification.estimate import EquationRank, Identifiable
from symgen.robot.tables import Contact
from symgen.robot.toml_text import robot_toml
from symgen.robot.types import Robot
from symgen.symbolic.base_parameters import BaseParameter
from symgen.symbolic.ranks import EquationPart, exact_rank, exact_ranks

_KINDS = {"base": "forces on the base", "joints": "torques of the joints"}


def identifiable(model: Model, logs: Sequence[FilteredLog]) -> Identifiable:
    """Return which inertial parameters the logs can determine, by their forces and contacts.

    Args:
        model: the model of a robot with a floating base.
        logs: the training logs.
    """
    robot, samples = model.robot, _samples(model.robot, logs)
    together, total = [*samples], sum(samples[p] for p in samples if p.rows != "joints")
    systems = [(_in_words(part), samples[part] / total, [part]) for part in together]
    systems.append(("all together", 1.0, together))
    usual, lifted = together[0].contacts, list[EquationPart]()
    links: dict[int, list[Contact]] = {}
    for contact in never_lifted(robot, logs):
        links.setdefault(robot.frame(contact.frame).joint, []).append(contact)
    for contacts in links.values():
        rest = tuple(contact for contact in usual if contact not in contacts)
        lifted.append(EquationPart(contacts=rest, flight=not rest))
        systems.append((f"if {_listed(contacts)} lifts too", 0.0, [*together, lifted[-1]]))
    if len(links) > 1:
        systems.append(("if each of them lifts once", 0.0, [*together, *lifted]))
    parts = [system for _, _, system in systems]
    kept = Derivations.by(robot_toml(robot), repr(parts))
    ranks = kept.have("ranks", lambda: exact_ranks(robot, model.base, parts))
    rows = tuple(
        EquationRank(words, share, rank.rank, rank.unknown)
        for (words, share, _), rank in zip(systems, ranks, strict=True)
    )
    logged = len(together) + 1
    return Identifiable(model.inertial, rows[:logged], rows[logged:])


def hides_load(model: Model, columns: Sequence[int], logs: Sequence[FilteredLog]) -> bool:
    """Return whether unknown forces at contacts hide some of a load on a link.

    Args:
        model: the model of a robot with a floating base.
        columns: indices of the sought parameters of the link among the standard ones.
        logs: the logs.
    """
    parts = [*_samples(model.robot, logs)]
    sought = tuple(BaseParameter(str(k), k, (), "", inertial=True) for k in columns)
    link = replace(model.base, parameters=sought)
    if any(part.flight for part in parts):
        return False  # the torques of the joints show all of it
    return exact_rank(model.robot, link, parts).rank < len(sought)


def never_lifted(robot: Robot, logs: Sequence[FilteredLog]) -> list[Contact]:
    """Return the contacts with an unknown force in every sample of all logs."""
    parts = _samples(robot, logs)
    return [c for c in robot.contacts if all(c in part.contacts for part in parts)]


def _in_words(part: EquationPart) -> str:
    if part.contacts:
        return f"contact: {_listed(part.contacts)}"
    return f"{_KINDS[part.rows]}{' in flight' * part.flight}"


def _listed(contacts: Iterable[Contact]) -> str:
    return ", ".join(contact.frame for contact in contacts)


def _samples(robot: Robot, logs: Sequence[FilteredLog]) -> dict[EquationPart, int]:
    """Return the kinds of equations in logs with their numbers of samples, most first.

    Without unknown forces, the equations of the base and those of the joints are two kinds.
    """
    out = Counter[EquationPart]()
    alone = [*_KINDS][: 1 + (robot.n > 0)]
    for log in logs:
        samples, flags = log.samples, touching(log.samples)
        sets = Counter({(): len(samples.t)})
        if flags is not None:
            used = flags if samples.mask is None else flags[~samples.mask.robot]
            sets = Counter(map(tuple, used.tolist()))
        for touches, count in sets.items():
            contacts, flight = tuple(compress(robot.contacts, touches)), samples.forces is None
            for rows in ["all"] if contacts else alone:
                out[EquationPart(rows, contacts, flight and not contacts)] += count
    return dict(out.most_common())

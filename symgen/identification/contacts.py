"""What logs of a floating base can show: the exact ranks of the equations that they contain."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from itertools import compress

from symgen.codegen.derivations import Derivations
from symgen.codegen.model import Model
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.floating import touching
from symgen.identification.estimate import EquationRank, Identifiable
from symgen.identification.parameters import link_columns
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
    parts, total = [*samples], sum(samples[p] for p in samples if p.rows != "joints")
    shares = {_in_words(part): count / total for part, count in samples.items()}
    systems = {_in_words(part): [part] for part in parts} | {"all together": parts}
    links = {c: robot.frame(c.frame).joint for c in never_lifted(robot, logs)}
    lifted = []
    for link in dict.fromkeys(links.values()):
        frames = ", ".join(c.frame for c in links if links[c] == link)
        rest = tuple(c for c in parts[0].contacts if links.get(c) != link)
        lifted.append(EquationPart(contacts=rest, flight=not rest))
        systems[f"if {frames} lifts too"] = [*parts, lifted[-1]]
    if len(lifted) > 1:
        systems["if each of them lifts once"] = [*parts, *lifted]
    kept = Derivations.by(robot_toml(robot), repr(systems))
    found = kept.have("ranks", lambda: exact_ranks(robot, model.base, [*systems.values()]))
    rows = tuple(
        EquationRank(words, shares.get(words, 1.0), rank.rank, rank.unknown)
        for words, rank in zip(systems, found, strict=True)
    )
    return Identifiable(model.inertial, rows[: len(parts) + 1], rows[len(parts) + 1 :])


def hidden_in_power(model: Model, logs: Sequence[FilteredLog]) -> tuple[str, ...]:
    """Return the inertial parameters that the energy model of logs without unknown forces hides."""
    parts = [EquationPart("power", flight=log.samples.forces is None) for log in logs]
    return exact_rank(model.robot, model.base, [*dict.fromkeys(parts)]).unknown


def hides_load(model: Model, link: int, logs: Sequence[FilteredLog]) -> bool:
    """Return whether unknown forces at contacts hide some of a load on a link."""
    parts = [*_samples(model.robot, logs)]
    if not all(part.contacts for part in parts):
        return False  # at times, all forces are known
    load = [BaseParameter("", k, (), "", inertial=True) for k in link_columns(model, link)]
    base = replace(model.base, parameters=tuple(load))
    return exact_rank(model.robot, base, parts).rank < len(load)


def never_lifted(robot: Robot, logs: Sequence[FilteredLog]) -> list[Contact]:
    """Return the contacts with an unknown force in every sample of all logs."""
    parts = _samples(robot, logs)
    return [c for c in robot.contacts if all(c in part.contacts for part in parts)]


def _in_words(part: EquationPart) -> str:
    if part.contacts:
        return f"contact: {', '.join(contact.frame for contact in part.contacts)}"
    return f"{_KINDS[part.rows]}{' in flight' * part.flight}"


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

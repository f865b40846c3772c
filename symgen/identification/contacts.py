"""What logs of a floating base can show: the exact rank of the equations that they contain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symgen.codegen.model import Model
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.floating import touching
from symgen.symbolic.ranks import EquationPart, exact_rank


def determined(model: Model, logs: Sequence[FilteredLog], rows: str = "all") -> list[int] | None:
    """Return the parameters that the logs can show, by their contacts; None for all.

    Args:
        model: the model of a robot with a floating base.
        logs: the training logs.
        rows: rows of their equations, see `EquationPart`.
    """
    kinds = {replace(part, rows=rows) for log in logs for part in _parts(log)}
    parts = sorted(kinds, key=str)
    unknown = {*exact_rank(model.robot, model.base, parts).unknown}
    names = model.base.names
    known = [k for k, name in enumerate(names) if name not in unknown]
    return None if len(known) == len(names) else known


def never_lifted(logs: Sequence[FilteredLog]) -> list[str]:
    """Return the frames of contacts with an unknown force in every sample of all logs."""
    parts = [part for log in logs for part in _parts(log)]
    sets = [{contact.frame for contact in part.contacts} for part in parts]
    always = set.intersection(*sets) if sets else set[str]()
    robot = logs[0].samples.robot
    contacts = () if robot is None else robot.contacts
    return [contact.frame for contact in contacts if contact.frame in always]


def _parts(log: FilteredLog) -> set[EquationPart]:
    """Return the kinds of equations in a log: one for each set of contacts."""
    samples, robot = log.samples, log.samples.robot
    if robot is None:
        return set()
    flies = samples.forces is None
    flags = touching(samples)
    if flags is None:
        return {EquationPart(flight=flies)}
    used = flags if samples.mask is None else flags[~samples.mask.robot]
    out = set()
    for row in np.unique(used, axis=0):
        contacts = tuple(c for c, touches in zip(robot.contacts, row, strict=True) if touches)
        out.add(EquationPart(contacts=contacts, flight=flies and not contacts))
    return out

"""Contacts: times in a log in which something pushes on the robot, with a torque of any course."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symgen.estimation.events import Event, likeliest_event
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.predictive_score import PredictiveScore
from symgen.estimation.values import FloatArray
from symgen.faults.fault import Fault
from symgen.faults.recorder import contact_fault
from symgen.robot.effect import definitions

NAME = "external_contact"


@dataclass(frozen=True, eq=False)
class Contact:
    """A contact that the score of a model shows.

    Attributes:
        event: its rows.
        fault: its samples; the undo leaves them out.
        odds: log-odds that it is present.
        worth: reduction of the error as a part of the joint's torque, from squares.
        gain: share of the sum of squares of its joints that it contains.
        torque: RMS of its torque on its joints, over all rows, N m or N.
    """

    event: Event
    fault: Fault
    odds: float
    worth: float
    gain: float
    torque: float

    @property
    def probability(self) -> float:
        """Probability that the contact is present."""
        from scipy.special import expit

        return float(expit(self.odds))


def weighed(score: PredictiveScore, event: Event, fault: Fault, size: FloatArray) -> Contact:
    """Return an event as a contact beside a model.

    Args:
        score: the model on the rows of the event.
        event: the event.
        fault: its samples.
        size: (n,) RMS of the measured torque.
    """
    evidence, fit = event.fit(score)
    was, joints = score.alone.left, list(event.joints)
    fell = np.maximum(was - fit.left, 0.0)[joints]
    part = fell / size[joints] ** 2
    gain = float(np.sum(part) / max(float(np.sum((was / size**2)[joints])), 1e-300))
    odds = evidence + math.log(definitions()[NAME].odds)
    torque, worth = (float(np.sqrt(x.max())) for x in (fell, part))
    return Contact(event, fault, odds, worth, gain, torque)


def probable_contact(
    score: PredictiveScore, logs: Sequence[FilteredLog], size: FloatArray, least: float
) -> Contact | None:
    """Return the most probable contact in some logs; None if none is probable and matters.

    Args:
        score: the model on the rows of the logs.
        logs: the logs.
        size: (n,) RMS of the measured torque.
        least: smallest torque that matters, as a part of the joint's torque.
    """
    event = likeliest_event(score, logs)
    if event is None:
        return None
    found = weighed(score, event, contact_fault(event, logs[event.log]), size)
    return found if found.odds > 0 and found.worth >= least else None


def contacts_in(
    score: PredictiveScore, logs: Sequence[FilteredLog], size: FloatArray, least: float
) -> Iterator[Contact]:
    """Yield the contacts in some logs one after the other; arguments as for `probable_contact`."""
    while (found := probable_contact(score, logs, size, least)) is not None:
        yield found
        weight = np.where(found.event.rows, 0.0, score.weight)
        score = replace(score, weight=weight)

"""Contacts at declared places of a floating base whose flags do not show them.

The projected equations hold with any force at a contact whose flag is 1. A span in which an unknown
force acts is therefore tried with the flag of each declared contact set to 1. If a separate
variance of the span is then improbable, the contact touched. Else the force acts at another place.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from symgen.data.raw import Bools
from symgen.estimation.floating import HALF
from symgen.hypotheses.event import Contact, Span
from symgen.hypotheses.problem import Stage
from symgen.hypotheses.registry import columns_in


def with_frame(stage: Stage, contact: Contact) -> Contact:
    """Return a contact with the frame that touches in its span; the contact itself without one."""
    problem, best, least = stage.problem, contact, 0.0
    (log,) = (log for log in problem.logs if log.name == contact.cause.log)
    touches = log.samples.touches
    if touches is None:
        return contact
    for declared, flags in zip(problem.robot.contacts, touches.T, strict=True):
        span = _between(contact.cause, flags > HALF)
        start, end = log.t[[span.first, span.last]].tolist()
        cause = replace(span, frame=declared.frame, start=start, end=end)
        touching = replace(contact, cause=cause)
        other = problem.without([touching])
        score = other.stage(columns_in(other, stage.effects)).score
        evidence, _ = contact.cause.fit(score)
        if evidence < least:
            best, least = touching, evidence
    return best


def _between(span: Span, flags: Bools) -> Span:
    """Return a span up to the samples (N,) in which a flag is 1, if they are near its ends."""
    on = np.flatnonzero(flags)
    length = span.last + 1 - span.first
    before = on[on < span.first].max(initial=-1) + 1
    after = on[on > span.last].min(initial=len(flags)) - 1
    first = int(before) if span.first - before <= length else span.first
    last = int(after) if after - span.last <= length else span.last
    return replace(span, first=first, last=last)

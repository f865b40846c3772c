"""Search the logs of a run for faults and missing effects, and undo those of the recorder."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symgen.estimation.decimation import PER_PERIOD
from symgen.estimation.values import Reason
from symgen.faults.fault import Fault, shifted_torques
from symgen.faults.samples import unmended_faults
from symgen.hypotheses.ask import Answer, ask
from symgen.hypotheses.changes import Changed
from symgen.hypotheses.event import Contact
from symgen.identification.campaign import Campaign
from symgen.identification.imu import has_imu, imu_errors, offsets_with_known, undone
from symgen.identification.proportional import proportional_joints

#: Kind of the reason that a channel must be recorded again.
BROKEN = "broken_channel"
_ROUNDS = 3  # most searches; each may find a fault that the ones before hid


def searched(campaign: Campaign, least: float) -> Campaign:
    """Search for missing effects and faults of the logs, and undo delays, contacts and errors of an
    IMU.

    Logs of a flight, and those of a robot without joints, are not searched. A delay of more than
    one kept row spoils the choice of the band, which is then repeated.

    Args:
        campaign: the logs.
        least: smallest torque that matters, as a part of a joint's torque.
    """
    passive = campaign.robot.passive
    every = [f for log in campaign.logs for f in unmended_faults(log.samples, passive)]
    broken = tuple(Reason(BROKEN, text=f.why) for f in every)
    if broken:
        return replace(campaign, answer=Answer(shown=broken))
    recorded, campaign = campaign, without_imu_errors(campaign)
    if campaign.unsearched:
        return campaign
    delays = tuple[Changed, ...]()
    contacts = tuple[Contact, ...]()
    for _ in range(_ROUNDS):
        answer = ask(campaign.evaluator, campaign.train, campaign.held, least, campaign.progress)
        if not (answer.delays or answer.contacts):
            break
        delays += answer.delays
        contacts += answer.contacts
        recorded = _without(_shifted(recorded, answer.delays), answer.contacts)
        longest = max((abs(item.cause.delay) for item in answer.delays), default=0.0)
        if longest * recorded.band.comparison_hz * PER_PERIOD > 1:
            recorded = recorded.in_new_band()
        campaign = without_imu_errors(recorded)
    answer = replace(answer, delays=delays, contacts=contacts)
    if delays or contacts:
        answer = replace(answer, found=None)
    # The filter spreads masked samples slightly into the rows around them.
    if any(log.mask is not None for log in campaign.logs):
        answer = replace(answer, largest_fold_error=0.0)
    # With parameters that the logs cannot separate, the search could name any of several causes.
    if proportional_joints(campaign.train):
        answer = replace(answer, shown=(), suspected=())
    return replace(campaign, answer=answer)


def without_imu_errors(campaign: Campaign) -> Campaign:
    """Estimate the errors of the IMU in all logs in memory, and remove them.

    Those of the training logs are estimated together with the parameters. Validation logs have the
    delay of the training logs and separate offsets, for these parameters. The ends of training logs
    have the offsets of these.
    """
    if campaign.long is not None or not any(map(has_imu, campaign.logs)):
        return campaign
    campaign.progress("estimating the offsets and the delay of the IMU")
    found = imu_errors(campaign.evaluator, campaign.train)
    repairs = [*campaign.repairs, *found.repairs]
    if campaign.has_validation:
        X, delay = found.X, found.certain_delay
        of_held = offsets_with_known(campaign.evaluator, campaign.held, X, delay)
        held, more = of_held.logs, of_held.repairs
        repairs += more
    else:
        ends = zip(campaign.held, found.offsets, strict=True)
        held = tuple(undone(log, found.delay, offsets) for log, offsets in ends)
    return replace(campaign, train=found.logs, held=held, repairs=tuple(repairs), imu=found)


def _without(campaign: Campaign, contacts: Sequence[Contact]) -> Campaign:
    """Return the logs with contacts undone: their samples masked, or their flags set."""
    for contact in contacts:
        span, robot = contact.cause, campaign.robot
        where = robot.listed(contact.joints) if contact.joints else "the robot"
        what = f"contact of {where}, {span.start:.3g} to {span.end:.3g} s"
        fault = Fault(
            span.log,
            f"{span.frame}.contact" if span.frame else "tau",
            span.in_words(robot) if span.frame else what,
            samples=span.last - span.first + 1,
            done="set to 1" if span.frame else "left out",
            kind=contact.definition.name,
            joints=contact.joints,
        )
        repairs = (*campaign.repairs, fault)
        campaign = replace(campaign.changed(span.undo), repairs=repairs)
    return campaign


def _shifted(campaign: Campaign, delays: Sequence[Changed]) -> Campaign:
    """Return the logs with the torques of some joints, or of all, shifted."""
    for item in delays:
        repairs = (*campaign.repairs, _shift(item, campaign))
        campaign = replace(campaign.changed(item.cause.undo), repairs=repairs)
    return campaign


def _shift(item: Changed, campaign: Campaign) -> Fault:
    """Return the repair of a delay of torques."""
    change = item.cause
    channel = ", ".join(f"tau{j + 1}" for j in change.joints) or "tau"
    joints = campaign.robot.listed(change.joints) if change.joints else "all joints"
    fault = shifted_torques(channel, change.delay, change.sizes[0].std, joints)
    samples = sum(len(log.t) for log in campaign.logs)
    return replace(fault, samples=samples, joints=change.joints, gap_reduction=item.gain)

"""Judge whether an identified model can be simulated over the range of the motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symgen.errors import ParameterError
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.playback import (
    HORIZONS,
    Horizon,
    Window,
    model_mover,
    play,
    position_errors,
    windows_of,
)
from symgen.estimation.torque_error import percent
from symgen.estimation.values import SEED, FloatArray, Reason
from symgen.identification.campaign import Campaign
from symgen.identification.estimate import ParameterEstimate
from symgen.identification.parameters import mass_matrices
from symgen.identification.settle import joint_of_friction
from symgen.identification.uses import SimulationUse
from symgen.policy import NEARER, SIMULATES
from symgen.runtime.evaluator import Evaluator

#: Largest number of simulated windows of held-out motion, whose RMS is then known to a fifth.
WINDOWS_PLAYED = 24
#: Number of states at which the properties of a model are evaluated.
STATES = 500


def simulation_use(
    campaign: Campaign,
    X: FloatArray,
    parameters: Sequence[ParameterEstimate],
    restrictions: Sequence[Reason],
) -> SimulationUse:
    """Judge whether the model can be simulated over the range of the motion.

    The mass matrix has to be positive definite at positions of the logs, and at positions whose
    joints are drawn from the logs independently. Coefficients of friction must not be negative. On
    held-out motion, the position error has to stay below the limits of `symgen.policy`.

    Args:
        campaign: the logs.
        X: (p,) parameters.
        parameters: the same with their standard deviations.
        restrictions: reasons that restrict the model to some motion, which a simulation would
            leave.
    """
    if restrictions:
        return SimulationUse(tuple(restrictions))
    evaluator = campaign.evaluator
    reasons = [*_mass_matrix_reasons(evaluator, campaign.train, X), *_friction_reasons(parameters)]
    if campaign.robot.imu:
        moves = Reason("not_simulated", text="the base moves, and simulations have a base at rest")
        return SimulationUse((*reasons, moves))
    windows = _windows(campaign.held)
    horizons, diverged = _play(evaluator, windows, X)
    before, _ = _play(evaluator, windows, campaign.file_values)
    if horizons:
        reasons += _position_reasons(horizons)
    else:
        before = ()
    if not (horizons or reasons):
        reasons.append(Reason("not_simulated", text="no held-out motion was simulated"))
    return SimulationUse(
        tuple(reasons),
        horizons=horizons,
        before=before,
        windows=len(windows) if horizons else 0,
        diverged=diverged,
    )


def motion_states(logs: Sequence[FilteredLog]) -> list[FloatArray]:
    """Return the motion of logs at their kept samples: the arrays of `FilteredLog.motion`."""
    kept = [[x[log.kept] for x in log.motion] for log in logs]
    return [np.concatenate(parts) for parts in zip(*kept, strict=True)]


def some_states(*motion: FloatArray) -> list[FloatArray]:
    """Return about STATES evenly spaced states of a motion, arrays (N, n) each."""
    every = slice(None, None, max(1, len(motion[0]) // STATES))
    return [np.ascontiguousarray(x[every]) for x in motion]


def mixed_states(*motion: FloatArray) -> list[FloatArray]:
    """Return STATES states whose joints are drawn from a motion independently."""
    count, n = motion[0].shape
    rows = np.random.default_rng(SEED).integers(count, size=(STATES, max(n, 1)))
    joints = [np.ascontiguousarray(x[rows[:, :n], np.arange(n)]) for x in motion[:3]]
    return [*joints, *(x[rows[:, 0]] for x in motion[3:])]


def _mass_matrix_reasons(
    evaluator: Evaluator, train: Sequence[FilteredLog], X: FloatArray
) -> list[Reason]:
    """Return a reason if the mass matrix is not positive definite at some position."""
    q = motion_states(train)[0]
    positions = np.concatenate([*some_states(q), *mixed_states(q)])
    M = mass_matrices(evaluator, positions, X)
    least = np.linalg.eigvalsh((M + M.transpose(0, 2, 1)) / 2)[:, 0]
    share = float(np.mean(least <= 0))
    if not share:
        return []
    text = (
        f"the mass matrix is not positive definite at {percent(share)} of the positions in the "
        "range of the motion"
    )
    return [Reason("mass_matrix", value=share, limit=0.0, text=text)]


def _friction_reasons(parameters: Sequence[ParameterEstimate]) -> list[Reason]:
    """Return a reason for each negative coefficient of friction."""
    reasons = []
    for p in parameters:
        joint = joint_of_friction(p.name)
        if joint is not None and p.value < 0:
            text = f"{p.name} is negative: friction would drive the joint"
            reasons.append(Reason("negative_friction", (joint,), p.value, 0.0, text))
    return reasons


def _position_reasons(horizons: Sequence[Horizon]) -> list[Reason]:
    """Return a reason if the first or the last position error is above its limit."""
    for horizon, limit in ((horizons[0], NEARER), (horizons[-1], SIMULATES)):
        error = horizon.position_error
        if not error < limit:
            text = (
                f"position error after {horizon.seconds:g} s {percent(error)} of the distance "
                f"moved (accepted: {100 * limit:g} %)"
            )
            return [Reason("position_error", value=error, limit=limit, text=text)]
    return []


def _windows(held: Sequence[FilteredLog]) -> list[Window]:
    """Return the windows of held-out motion to simulate."""
    windows = windows_of(held, max(1, WINDOWS_PLAYED // max(1, len(held))))
    if len(windows) <= WINDOWS_PLAYED:
        return windows
    evenly = np.linspace(0, len(windows) - 1, WINDOWS_PLAYED).astype(int)  # more logs than windows
    return [windows[k] for k in evenly]


def _play(
    evaluator: Evaluator,
    windows: Sequence[Window],
    X: FloatArray | None,
) -> tuple[tuple[Horizon, ...], int]:
    """Return the position errors over windows, and the number of windows that diverge.

    There are no errors if X is None, if there are no windows, or if friction is negative.
    """
    if X is None or not windows:
        return (), 0
    t = np.array([0.0, *(h for h in HORIZONS if h <= windows[0].seconds)])
    try:
        mover = model_mover(evaluator.model, X)
    except ParameterError:  # negative friction: the reasons name it
        return (), 0
    return position_errors(windows, t, play(mover, windows, t))

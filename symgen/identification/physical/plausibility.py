"""Whether a robot can weigh what its parameters say: what no residual shows.

Torques in N mm or in kN m all fit as well, with parameters a thousand times too large or small. A
joint's own inertia M_jj over the square of what the robot reaches from there is the mass that it
moves like; a note says so where all joints move like tonnes, or none like more than a few coins.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from symgen.estimation.filtered import FilteredLog
from symgen.identification.parameters import mass_matrices
from symgen.names import REVOLUTE
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator

FloatArray = NDArray[np.float64]
#: kg: no robot moves like less than a few coins at every joint, nor like more than a lorry.
LIGHTEST, HEAVIEST = 0.02, 5000.0
_BODY = 0.1  # m of a last link beyond its frame
_STATES = 200


def implausible(evaluator: Evaluator, logs: Sequence[FilteredLog], X: FloatArray) -> str:
    """Say that a robot would be absurdly heavy or light; "" where it can be.

    Args:
        evaluator: the compiled model, with inverse_dynamics.
        logs: the training logs.
        X: (p,) base parameters.
    """
    reach = _reach(evaluator.model.robot.with_values())
    q = np.concatenate([log.q[log.kept] for log in logs])
    q = np.ascontiguousarray(q[:: max(1, len(q) // _STATES)])
    inertia = np.mean(np.einsum("kjj->kj", mass_matrices(evaluator, q, X)), axis=0)
    masses = np.abs(inertia) / reach**2
    least, most = float(masses.min()), float(masses.max())
    if least <= HEAVIEST and most >= LIGHTEST:
        return ""
    seen = f"{least:.3g} kg at least" if least > HEAVIEST else f"{most:.3g} kg at most"
    return (
        f"every joint moves like {seen} at the end of the arm: look at the units of the log "
        "(N m, not N mm; N; rad; m; s)"
    )


def _reach(robot: Robot) -> FloatArray:
    """Return what the robot reaches from each joint, m (1 for a slide), (n,)."""
    lengths = {j.number: sum(abs(float(x)) for x in (j.b, j.d, j.r)) for j in robot.joints}
    out = [
        _BODY + sum(x for number, x in lengths.items() if number > joint.number)
        if joint.sigma == REVOLUTE
        else 1.0
        for joint in robot.movable
    ]
    return np.array(out)

"""What matters, how sure is sure, and how large is large: the limits by which symgen decides.

Every limit that changes a verdict, an adoption or a choice stands here, with the reason for it and
the measurement that chose it. Numbers of an algorithm (orders, tolerances, grids) stay beside it.
"""

from __future__ import annotations

import math

#: Smallest torque that matters, part of a joint's torque: what engineers leave alone (`--least`).
LEAST = 0.008
#: Smallest error of a model to expect, part of a joint's torque (`--misfit`).
MISFIT = 0.004
#: Torque error on other motion up to which a model is good, and usable (`--accept`): a feed-forward
#: at 5 % leaves the feedback a twentieth of the work; above 10 % it needs another look.
GOOD, ACCEPT = 0.05, 0.10
#: A part of the motion with this many times the error of all is named.
VARIES = 2.5
#: Standard deviation up to which a parameter is known, part of its value.
KNOWN = 0.3
#: Standard deviations beyond which a difference is not chance: one of 370 by a normal law.
BEYOND = 3.0
#: Error of a single joint from which it is listed with its N m.
JOINT = 0.30
#: A model can be simulated if its position error on held-out motion is below these parts of the
#: distance moved: after the first horizon (0.2 s) it has to be nearer than a robot that stands
#: still; after the last (1 s) it leaves 30 %. Of ten simulated arms whose torques have a misfit of
#: 1 %, all leave less than 12 % after 1 s; of thirteen with 5 %, eleven less than 30 %.
NEARER, SIMULATES = 1.0, 0.3
#: The nearest possible robot is the estimate unless its held-out error exceeds that of least
#: squares by `LEAST` and by this part.
POSSIBLE = 0.10
#: An effect is shown as the cause if it leaves at most this part of its joint's error above the
#: noise floor on other motion. Of 59 simulated logs, right names left 1 to 32 %, false 59 to 97.
SHOWN = 0.5
#: Gap after, of the torque, up to which a diagnosis is "explained".
EXPLAINED = 0.15
#: Log-odds above which one of two explanations is certain: nine to one.
SURE = math.log(9.0)
#: Error of a joint's torque above which the motion itself is doubted: signs, exchanged joints,
#: other gears and another gravity leave more.
LOUD = 0.3

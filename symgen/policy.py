"""Limits by which symgen decides: what matters, how certain is certain, and how large is large.

This file contains every limit that changes a verdict, an adoption or a choice, with its reason and
the measurement that chose it. Numbers of an algorithm (orders, tolerances, grids) are in the file
of the algorithm.
"""

from __future__ import annotations

import math

#: Smallest torque that matters, relative to the torque of the joint: engineers ignore less
#: (`--least`).
LEAST = 0.008
#: Smallest error to expect of a model, relative to the torque of the joint (`--misfit`).
MISFIT = 0.004
#: Torque errors below this part of the torque are equal, and the first of several equals is chosen.
#: On logs without noise, errors are roundings of about 1e-8, which differ between processors.
ROUNDING = 1e-6
#: Torque error on other motion up to which a model is good, and usable (`--accept`). At 5 %, a
#: feed-forward leaves the feedback a twentieth of the work; above 10 %, check the model.
GOOD, ACCEPT = 0.05, 0.10
#: Torque error of one joint above which the model does not describe that joint, however small the
#: total is. Joints of real robots have up to 0.37 (a KR300's wrist), joints of simulated arms with
#: exchanged or coupled wrist joints 0.4 to 2.6.
JOINT = 0.40
#: A part of the motion with this many times the total error is reported.
VARIES = 2.5
#: Relative standard deviation up to which a parameter counts as known.
KNOWN = 0.3
#: Number of standard deviations above which a difference is not chance: 1 of 370 for a normal
#: distribution.
BEYOND = 3.0
#: Limits of the position error on held-out motion, relative to the distance moved, for a model to
#: be good for simulation. After the first horizon (0.2 s), the model must be nearer than a robot at
#: rest. After the last one (1 s), the error must be below 30 %. Of ten simulated arms with a torque
#: misfit of 1 %, all have errors below 12 % after 1 s; of thirteen with 5 %, eleven have errors
#: below 30 %.
NEARER, SIMULATES = 1.0, 0.3
#: The nearest possible robot is the estimate unless its held-out error exceeds that of least
#: squares by `LEAST` and by this share.
POSSIBLE = 0.10
#: Models with up to this many times the smallest error on held-out folds are as good. With 1.1, the
#: choice was more than 15 % worse than the best in 14 of 20 cuts of a real leg, with this in 5; on
#: simulated arms, it was so in 7 and in 10 of 100.
AS_GOOD = 1.03
#: An effect is shown as the cause if at most this share of its joint's error above the noise floor
#: remains on other motion. In 59 simulated logs, right effects left 1 to 32 %, false ones 59 to 97
#: %.
SHOWN = 0.5
#: An adopted effect raises the error of no joint by more than this part of its largest reduction,
#: or of what matters.
RISE = 0.25
#: Factor on the position error of a simulation above which adopted effects make it worse.
WORSE = 1.1
#: Faults of the recorder are the cause if they close this part of what is closed, and of the error.
CHIEFLY, WORTH = 0.5, 0.1
#: RMS torque of a log, relative to that of the file's masses at rest and to the torque limits,
#: above which the unit is in doubt. Robots stay below a few times the one, or below the other; mA
#: and mN m are wrong by 1000.
SCALE = 20.0
#: Smallest torque at rest, N m or N, that counts for this: 10 g at 1 m. Smaller ones come from
#: masses that nobody filled in, and from rounded angles.
HEAVY = 0.1
#: Log-odds above which one of two explanations is certain: nine to one.
SURE = math.log(9.0)
#: Median step of the positions between rows, relative to their spread, above which the rows are
#: poses and no motion. A motion that is sampled six times a period has 1.0. Of 300 sets of 24
#: random poses, 95 % were above 0.87 for two joints, 1.07 for three and 1.2 for seven.
POSES = 1.0
#: Torque error of a joint above which the motion itself is in doubt. Wrong signs, exchanged joints,
#: wrong gears and another gravity cause larger errors.
LOUD = 0.3
#: Ratio of a joint's error to that of the quietest quarter of the joints above which it counts as
#: large as well: faults of a wrist stay below `LOUD`. On two real arms it is at most 2 before the
#: search, if the file declares their coupling, and up to 3.4 after several effects.
APART = 3.0
#: Number of correlated rows that count as one in the score of a search, at four rows a period.
TEMPERATURE = 4.0
#: Correlation of the explained torques above which two effects are one class, and above which one
#: is an alternative to the other; probability above which an alternative is listed.
SAME, ALIKE, LISTED = 0.98, 0.8, 0.05
#: Largest number of hypotheses that the search of `identify` adds; `diagnose` has no limit.
STEPS = 3
#: Share of the states of validation logs above which they repeat the training motion, which
#: confirms nothing. States are equal within `NEAR` standard deviations.
REPEATED, NEAR = 0.9, 0.05
#: Smallest share of the torque, without rotor and friction, that the deflection between two
#: encoders has to explain. Noise of q - qs lowers this share as much as it lowers the stiffness.
DEFLECTS = 0.95
#: A torque error is visible above these multiples of the noise floor and of what matters.
NOISES, VISIBLE = 3.0, 2.0
#: A validation log is a copy of a training log if nine tenths of their torques differ by less than
#: this number of standard deviations of the noise, or, where it was filtered, by less than this
#: part of their RMS. Two recordings differ by 1.5 times as much, those of a real axis by 50.
COPIED = 1.55
EQUAL = 1e-3
#: The torques of a log lack the weight, or the friction, that the robot file states if they have
#: less than this part of it. A file with a density of the links that is wrong has 8 times as much.
WEIGHT_LEFT = 0.1
FRICTION_LEFT = 0.25
#: Usual offsets of an IMU, m/s2 and rad/s, and its usual delay, s: the deviations of a prior. Data
#: sheets of MEMS sensors state 0.2 to 0.6 m/s2 and 0.01 to 0.02 rad/s before calibration.
IMU_OFFSETS, IMU_DELAY = (0.2, 0.02), 0.01

"""Counts of base parameters by the rank of sampled regressors, by code of others."""

import json
from pathlib import Path

TRUTH = json.loads(
    (Path(__file__).parents[1] / "reference" / "ground_truth.json").read_text("utf-8")
)["robots"]
#: Rotor inertia, and friction.
VARIANTS = {
    "no_ia_no_fric": (False, ()),
    "ia_no_fric": (True, ()),
    "no_ia_fric": (False, ("coulomb", "viscous")),
    "ia_fric": (True, ("coulomb", "viscous")),
}

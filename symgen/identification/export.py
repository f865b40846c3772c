"""Identified values for other programs: a C header that goes with the generated package."""

from __future__ import annotations

import math
import re

from symgen.codegen.package import model_digest
from symgen.errors import ParameterError
from symgen.files import rendered
from symgen.identification.estimate import ROBOT_DIGEST, Estimate


def values_header(estimate: Estimate, prefix: str | None = None) -> str:
    """Return NAME_values.h: the identified X as `static const NAME_real NAME_values[]`.

    It includes NAME.h of the generated package and compiles with one of the same robot.toml alone,
    whose digest it compares. The verdict and its reasons stand at its head.

    Args:
        estimate: what was identified.
        prefix: of the package; the robot's name by default. NAMEf is that of a float package.

    Raises:
        ParameterError: a value is not finite, or method consistent gave what no robot can have.
    """
    if estimate.method.startswith("consistent") and estimate.physical.feasible is not True:
        raise ParameterError(
            f"{estimate.robot}: not exported, no robot can have these parameters: "
            f"{estimate.physical.reason}"
        )
    bad = [p.name for p in estimate.parameters if not math.isfinite(p.value)]
    if bad:
        raise ParameterError(f"{', '.join(bad[:5])}: not finite, and cannot be written in C")
    facts = [
        f"Identified by symgen with the {estimate.model} model, method {estimate.method}.",
        f"Verdict: {estimate.verdict}.",
        *(f"- {reason}" for reason in estimate.reasons),
        *(
            f"For {use.name}: {'yes' if use.ok else 'no: ' + '; '.join(use.reasons)}."
            for use in estimate.uses
        ),
        f"Physical consistency: {estimate.physical.reason}.",
        *(f"{key}: {value}" for key, value in estimate.provenance),
    ]
    robot = dict(estimate.provenance).get(ROBOT_DIGEST, "")
    return rendered(
        "c/values.h",
        name=prefix or estimate.robot,
        robot=estimate.robot,
        digest=model_digest(robot) if re.fullmatch("[0-9a-f]{64}", robot) else None,
        facts=[_comment(fact) for fact in facts],
        parameters=[
            {
                "name": p.name,
                "value": repr(p.value),
                "formula": _comment(
                    p.name if p.expression == p.name else f"{p.name} = {p.expression}"
                ),
                "unit": p.unit,
                "std": f"{p.std:.3g}" if math.isfinite(p.std) else "unknown",
            }
            for p in estimate.parameters
        ],
    )


def _comment(text: str) -> str:
    """Return a text as one line that is safe inside a C comment: names of logs are anything."""
    line = "".join(c if c.isprintable() else " " for c in text)
    # no end or begin of a comment, and no trigraph
    return re.sub(r"(\*(?=/)|/(?=\*)|\?(?=\?))", r"\1 ", line).rstrip("\\")

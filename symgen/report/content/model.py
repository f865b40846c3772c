"""Content of a compiled model: its kernels, parameters and frames."""

from __future__ import annotations

from symgen.report.content.parts import Content, Section, Table, frames_section
from symgen.report.folded import folded
from symgen.runtime.evaluator import Evaluator

_OPERATIONS = ("mul", "add", "div", "sincos")
_COUNTS = "Scalar operations of one call. Each angle is turned once: sincos counts sine and cosine."


def model_content(evaluator: Evaluator) -> Content:
    """Return the cost of the kernels, the base parameters, and the frames of the robot."""
    model, backend = evaluator.model, "C" if evaluator.backend == "c" else "CasADi"
    base = model.base
    lead = (
        f"Model of {model.robot.name}: {model.robot.n} joints, {len(base.parameters)} base "
        f"parameters of {len(base.standard)} standard ones. Evaluated by {backend}.",
    )
    rows = [
        (k.name, *(str(getattr(k.tape.operations, key)) for key in _OPERATIONS))
        for k in model.kernels
    ]
    parameters = [(p.name, p.unit, folded(p.expression)) for p in base.parameters]
    counts = Table(("kernel", *_OPERATIONS), rows)
    sections = (
        Section("Operations", (_COUNTS,), counts),
        Section("Base parameters", (), Table(("name", "unit", "formula"), parameters)),
        frames_section(model.robot),
    )
    return Content(f"Model of {model.robot.name}", lead, sections)

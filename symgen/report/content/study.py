"""Content of a study."""

from __future__ import annotations

from symgen.experiment.study import StudiedMethod, Study
from symgen.report.content.parts import Banner, Content, Section, Table, percent

_HEADER = ("model and method", "torque error", "coverage", "runs without a solution")
_COLUMNS = ("name", "true value", "bias", "std", "stated std", "coverage", "unit")
_WAYS = (
    "The torque error is that on a motion without noise that no run has. Coverage is how often the "
    "95 % interval contains the true value, mean over the parameters."
)
_PARAMETERS = (
    "Bias and standard deviation (std) are relative to the true value. Stated std is what the "
    "estimates state."
)


def study_content(study: Study) -> Content:
    """Return the models and methods, the parameters of the best one, and the settings."""
    best, title = study.best, f"Study of {study.robot}"
    lead = (
        f"Accuracy of the parameters of {study.robot} from {study.runs} simulated runs. Each run "
        f"is identified with {len(study.results)} combinations of model and method, and compared "
        "with the true parameters.",
    )
    if best is None or best.torque_error is None:
        text = "No run determines the parameters."
        return Content(title, lead, (_settings(study),), Banner("bad", "not determined", text))
    facts = (
        ("torque error of held-out motion", percent(best.torque_error)),
        ("coverage of 95 % intervals", percent(best.coverage)),
    )
    banner = Banner("plain", best.name, "The smallest torque error.", facts=facts)
    rows = [
        (
            r.name,
            "-" if r.torque_error is None else percent(r.torque_error),
            "-" if r.torque_error is None else percent(r.coverage),
            str(r.failed),
        )
        for r in study.results
    ]
    sections = (
        Section("Models and methods", (_WAYS,), Table(_HEADER, rows), printed=()),
        Section(f"Parameters: {best.name}", (_PARAMETERS,), _precision(best), printed=()),
        *(
            Section(f"Parameters: {r.name}", (), _precision(r), folded=True)
            for r in study.results
            if r is not best and r.parameters
        ),
        _settings(study),
    )
    return Content(title, lead, sections, banner)


def _precision(way: StudiedMethod) -> Table:
    rows = []
    for p in way.parameters:
        shares = [percent(x / abs(p.value)) if p.value else "-" for x in
                  (p.bias, p.std, p.stated_std)]  # fmt: skip
        rows.append((p.name, f"{p.value:.4g}", *shares, percent(p.coverage), p.unit))
    return Table(_COLUMNS, rows)


def _settings(study: Study) -> Section:
    """Return the settings of the study."""
    r = study.recording
    instruments = {k.replace("_", " "): v for k, v in vars(r.instruments).items()}
    rows = [
        ("motions", ", ".join(study.trajectories)),
        ("held-out motion", study.held_out),
        ("windows", f"{study.window_s:g} s"),
        *((name, f"{float(value):g}") for name, value in instruments.items()),
        ("controller", f"{r.controller.kind}, {r.controller.bandwidth:g} rad/s"),
        ("disturbance", str(r.disturbance)),
        *((f"band of {m.name}", m.band.in_words()) for m in study.results),
        ("seed", str(study.seed)),
    ]
    return Section("Settings", (), Table(("", ""), rows))

"""FMU: forward dynamics as a Functional Mock-up Unit (FMI 2.0).

Model exchange and co-simulation (FMI 2.0.4, sections 3 and 4): inputs tau, states q and qd, outputs
q, qd and qdd, and the base parameters X as tunable parameters. It calls NAME_forward_dynamics of
the package. CMake builds NAME.fmu (`-DNAME_FMU=ON`).
"""

from __future__ import annotations

import hashlib
import random
import re
from collections.abc import Iterator
from typing import Any

from symgen.codegen.backends import Package
from symgen.codegen.model import Model
from symgen.codegen.verification import SEED, physical_parameters
from symgen.files import rendered, templates
from symgen.robot.effect import unit

NEEDS = frozenset({"forward_dynamics"})
#: Largest integration step in co-simulation, s.
STEP = 1e-4
#: Speed at which dry friction is smoothed, rad/s or m/s.
WIDTH = 0.01

_BASE = {"kg": (1, 0, 0, 0), "m": (0, 1, 0, 0), "s": (0, 0, 1, 0), "rad": (0, 0, 0, 1)}
_BASE["N"] = (1, 1, -2, 0)


def files(package: Package) -> dict[str, str]:
    """Return the files of the folder fmu/: description, C sources and CMake."""
    name, model = package.name, package.model
    starts = (
        [round(x, 6) for x in physical_parameters(model, random.Random(SEED))]
        if package.values is None
        else list(package.values.X)
    )
    dry = list(_dry(model))
    variables = _variables(model, starts, bool(dry))
    sources = [f"{name}_forward_dynamics.c", f"{name}.h"]
    sources += [path for path in (f"{name}_math.h",) if path in package.files]
    states = 2 * model.robot.n
    data: dict[str, Any] = {
        "name": name,
        "known": package.values is not None,
        "dry": dry,
        "starts": [*map(repr, starts), repr(STEP), *([repr(WIDTH)] if dry else [])],
        "variables": variables,
        "units": [
            {"name": unit, "base": _base_unit(unit)}
            for unit in sorted({v["unit"] for v in variables if v["unit"]})
        ],
        "outputs": [i for i, v in enumerate(variables, 1) if v["causality"] == "output"],
        "derivatives": [i + 1 for i in range(3 * states // 2, 5 * states // 2)],
        "sources": sources,
    }
    # A master compares this text in the description with that in the library.
    digest = hashlib.sha256()
    for text in (repr(data), *(package.files[path] for path in sources)):
        digest.update(text.encode() + b"\0")
    data["guid"] = f"{{{digest.hexdigest()[:32]}}}"
    return {
        "fmu/modelDescription.xml": rendered("fmu/modelDescription.xml", **data),
        f"fmu/{name}_fmu.c": rendered("fmu/model.c", **data),
        "fmu/CMakeLists.txt": rendered("fmu/CMakeLists.txt", **data),
        "fmu/fmi2.h": (templates() / "fmu" / "fmi2.h").read_text("utf-8"),
    }


def _dry(model: Model) -> Iterator[dict[str, Any]]:
    """Yield the position in X of each dry friction parameter FS, and the speed it acts on."""
    robot, values = model.robot, model.robot.values()
    place = {joint.number: i for i, joint in enumerate(robot.movable)}
    for i, parameter in enumerate(model.base.parameters):
        standard = model.base.standard[parameter.index]
        joint = standard.joint
        if standard.prefix == "FS" and not robot.joint(joint).coulomb_width:
            yield {"place": i, "first": place[joint], "second": place[joint], "ratio": "0.0"}
        elif standard.prefix == "FSM":
            coupling = next(c for c in robot.couplings if c.second == joint)
            ratio = repr(float(coupling.ratio.xreplace(values)))
            first = place[coupling.first]
            yield {"place": i, "first": first, "second": place[joint], "ratio": ratio}


def _variables(model: Model, starts: list[float], dry: bool) -> list[dict[str, Any]]:
    """Return the variables in the order of their value references."""
    out: list[dict[str, Any]] = []
    joints = model.robot.movable

    def add(name: str, causality: str, text: str, unit_of: str, **more: Any) -> None:
        known = {"variability": "continuous", "initial": None, "start": None, "derivative": None}
        known |= {"least": None, **more}
        kind = {"name": name, "causality": causality, "description": text, "unit": unit_of}
        out.append(kind | known)

    n = len(joints)
    state, derived = {"initial": "exact", "start": 0.0}, {"initial": "calculated"}
    groups: tuple[tuple[str, str, str, str, dict[str, Any]], ...] = (
        ("tau{}", "input", "torque of the motor of joint {}", "torque", {"start": 0.0}),
        ("q{}", "output", "position of joint {}", "position", state),
        ("qd{}", "output", "speed of joint {}", "speed", state),
        ("der(q{})", "local", "derivative of q{}", "speed", derived),
        ("qdd{}", "output", "acceleration of joint {}", "acceleration", derived),
    )
    for name, causality, text, kind, more in groups:
        for j in joints:
            # der(q) and qdd are derivatives of q and qd, 2 n variables before them.
            of = {"derivative": len(out) + 1 - 2 * n} if more is derived else {}
            says = text.format(j.number)
            add(name.format(j.number), causality, says, unit(kind, j.sigma), **more, **of)
    tunable = {"variability": "tunable", "initial": "exact"}
    for parameter, start in zip(model.base.parameters, starts, strict=True):
        text = f"X[{len(out) - 5 * n}] = {parameter.expression}"
        add(parameter.name, "parameter", text, parameter.unit, start=start, **tunable)
    text = "longest step of the integrator in co-simulation"
    add("integration_step", "parameter", text, "s", start=STEP, least=0.0, **tunable)
    if dry:
        text = "speed v0 in FS tanh(v/v0), which stands for FS sign(v) of dry friction"
        add("coulomb_width", "parameter", text, "rad/s", start=WIDTH, least=0.0, **tunable)
    return out


def _base_unit(unit: str) -> str:
    """Return the BaseUnit element of a unit such as "N m s/rad"; "" for unknown units."""
    powers = [0, 0, 0, 0]
    above, _, below = unit.partition("/")
    for part, sign in ((above, 1), (below, -1)):
        for factor in part.split():
            found = re.fullmatch(r"([A-Za-z]+)(\d*)", factor)
            if found is None or found[1] not in _BASE:
                return ""
            for i, power in enumerate(_BASE[found[1]]):
                powers[i] += sign * power * int(found[2] or 1)
    named = zip(("kg", "m", "s", "rad"), powers, strict=True)
    return "<BaseUnit" + "".join(f' {key}="{p}"' for key, p in named if p) + "/>"

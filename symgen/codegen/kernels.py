"""The kernels: one definition each, from which all their forms are made.

kernels.toml has a table for each kernel: a description, the inputs and outputs with their shapes,
and the derivation. C declarations, batches, panels, CasADi functions, the manifest, the methods of
an evaluator with their stub, and the table of docs/c.md follow from it.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from importlib import resources
from typing import Any

from symgen.codegen.definition import (
    GRAVITY,
    Array,
    Columns,
    KernelDefinition,
    Size,
    Subject,
    of_base,
    of_plant,
    of_robot,
)
from symgen.names import BASES, FREE_BASE, LINK
from symgen.symbolic import (
    derivatives,
    dynamics,
    energy,
    forward,
    friction,
    passive,
    placement,
    regressor,
    regrouping,
)

#: The modules with derivations, by what these take.
_DERIVING = (
    (of_robot, (energy, friction, regressor, placement)),
    (of_plant, (dynamics, forward, passive, derivatives)),
    (of_base, (regrouping,)),
)


def _linear(s: Subject) -> list[tuple[str, int]]:
    """Return the base parameters with a column."""
    return [(b.name, b.index) for b in s.base.parameters[: s.base.linear]]


def _inertial(s: Subject) -> list[tuple[str, int]]:
    return [(b.name, b.index) for b in s.base.parameters if b.inertial]


def _rubbing(s: Subject) -> list[tuple[str, int]]:
    """Return the base parameters of friction and effects, which follow the inertial ones."""
    first = sum(p.inertial for p in s.base.standard)
    return [(name, place - first) for name, place in _linear(s) if place >= first]


def _load(s: Subject) -> list[tuple[str, int]]:
    """Return the parameters of the link that carries a load."""
    names = [p.name for p in s.base.standard]
    first = names.index(f"{LINK[0]}{s.robot.load_link}")
    return [(f"{prefix}L", first + k) for k, prefix in enumerate(LINK)]


def _standard(s: Subject, *, inertial: bool) -> list[tuple[str, int]]:
    """Return the standard parameters with a column, or the inertial ones."""
    kept = [p.name for p in s.base.standard if (p.inertial if inertial else not p.load)]
    return [(name, place) for place, name in enumerate(kept)]


_SIZES: dict[Any, Size | Columns] = {
    "n": Size("n", lambda s: s.robot.n),
    "m": Size("m", lambda s: len(s.robot.equations)),
    "links": Size("links", lambda s: len(s.robot.joints)),
    "p": Size("p", lambda s: len(s.base.parameters)),
    "p_inertial": Size("p_inertial", lambda s: s.base.inertial),
    "s": Size("s", lambda s: len(s.base.standard)),
    "linear": Columns("p", _linear),
    "inertial": Columns("p_inertial", _inertial),
    "friction": Columns("p - p_inertial", _rubbing),
    "load": Columns("10", _load),
    "standard": Columns("s", partial(_standard, inertial=False)),
    "inertial_standard": Columns("s_inertial", partial(_standard, inertial=True)),
}
#: What a robot needs to have a kernel: a test, and what a robot without it lacks.
_NEEDS = {
    "joints": (lambda s: s.robot.n > 0, "no movable joints"),
    "friction": (lambda s: bool(_rubbing(s)), "no friction and no effects"),
    "effects": (lambda s: bool(s.robot.effects), "no effects"),
    "columns": (lambda s: not s.robot.loaded, "friction that depends on the load of its joint"),
    "sensor": (
        lambda s: s.robot.sensor is not None and not s.robot.imu,
        "no [sensor], or a base that moves",
    ),
}


def _array(name: str, shape: Sequence[Any]) -> Array:
    return Array(name.removesuffix("_inertial"), tuple(_SIZES.get(size, size) for size in shape))


def _definitions() -> tuple[KernelDefinition, ...]:
    """Return the kernels of kernels.toml."""
    tables = tomllib.loads((resources.files(__package__) / "kernels.toml").read_text("utf-8"))
    shapes, out = tables.pop("inputs"), []
    for name, row in tables.items():
        inputs = [_array(x, shapes.get(x, ["n"])) for x in row.pop("inputs").split()]
        outputs = _outputs(row.pop("outputs"))
        bases = tuple(row.pop("bases", " ".join(BASES)).split())
        free = row.pop("floating", {})
        module, _, function = row.pop("derived").partition(".")
        exists, lacks = _NEEDS.get(row.pop("needs", ""), (None, ""))
        (tape,) = (
            of(getattr(found, function))
            for of, modules in _DERIVING
            for found in modules
            if found.__name__.endswith(f".{module}")
        )
        definition = KernelDefinition(
            name=name, inputs=tuple(inputs), outputs=outputs, tape=tape,
            exists=exists, lacks=lacks, bases=bases, **row,
        )  # fmt: skip
        out.append(replace(definition, floating=_for_free_base(definition, **free)))
    return tuple(out)


def _outputs(shapes: Mapping[str, Sequence[Any]]) -> tuple[Array, ...]:
    return tuple(_array(name, shape) for name, shape in shapes.items())


def _for_free_base(
    definition: KernelDefinition,
    base: str = "",
    doc: str = "",
    outputs: Mapping[str, Sequence[Any]] | None = None,
) -> KernelDefinition:
    """Return the definition for a floating base."""
    inputs = [Array(name, (FREE_BASE[name],)) for name in base.split()]
    return replace(
        definition,
        inputs=(*(a for a in definition.inputs if a.name != GRAVITY), *inputs),
        outputs=definition.outputs if outputs is None else _outputs(outputs),
        doc=doc or definition.doc,
    )


DEFINITIONS = _definitions()
KERNELS = {d.name: d for d in DEFINITIONS}
#: Kernels that are not only for requests by name, and do not concern standard parameters.
ALL = tuple(d.name for d in DEFINITIONS if not (d.standard or d.named))
#: Kernels that identification with the energy model needs.
ENERGY = ("energy_regressor", "friction_power")
#: Kernels that follow a load on line.
PAYLOAD = ("load_momentum", "add_load", "generalized_momentum", "friction_torque")
#: Names of sets of kernels.
SETS = {"all": ALL, "payload": PAYLOAD}


def expanded(kernels: Iterable[str]) -> tuple[str, ...]:
    """Return the names of kernels with those of `SETS` in place of the name of a set."""
    out: list[str] = []
    for name in kernels:
        out += SETS.get(name, (name,))
    return tuple(dict.fromkeys(out))

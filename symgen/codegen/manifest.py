"""manifest.json: what a package is, the proof of its parameters, and values to check it by."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from symgen.codegen.c_printer import operation_counts
from symgen.codegen.kernels import Kernel
from symgen.codegen.model import Model
from symgen.codegen.verification import DIGITS, SEED, TOLERANCE
from symgen.symbolic.base_parameters import bound

SCHEMA = "symgen.manifest/1"


def base_table(model: Model) -> list[dict[str, str]]:
    """Return name, formula and unit of every base parameter, in the order of X."""
    return [
        {"name": p.name, "expression": p.expression, "unit": p.unit} for p in model.base.parameters
    ]


def described(
    model: Model,
    kernels: Sequence[Kernel],
    options: Mapping[str, Any],
    verified: Mapping[str, Any],
    digests: Mapping[str, str],
) -> dict[str, Any]:
    """Return the content of manifest.json.

    Args:
        model: the robot and its base parameters.
        kernels: those of the package.
        options: what the package was asked to hold: target, dtype, kernels.
        verified: points and expected values by kernel, from `verification`.
        digests: sha256 by file.
    """
    robot, base = model.robot, model.base
    return {
        "schema": SCHEMA,
        "robot": robot.name,
        "options": options,
        "joints": robot.n,
        "joint_numbers": [j.number for j in robot.movable],
        "standard_parameters": len(base.standard),
        "base_parameters": base_table(model),
        "inertial_parameters": model.inertial,
        "no_effect": list(base.no_effect),
        "effects": [{"name": e.name, "kind": e.kind} for e in robot.effects],
        "kernels": [
            {
                "name": k.name,
                "inputs": [
                    {"name": name, "shape": [len(symbols)]} for name, symbols in k.tape.inputs
                ],
                "outputs": [
                    {"name": o.name, "shape": list(o.shape), "columns": list(o.columns)}
                    for o in k.outputs
                ],
                "operations": operation_counts([k.tape]),
            }
            for k in kernels
        ],
        "proof": {
            "rank": base.proof.rank,
            "primes": list(base.proof.primes),
            "seeds": list(base.proof.seeds),
            "points": base.proof.points,
            "structural_relations": base.proof.structural,
            "lifted_relations": base.proof.lifted,
            "bound": bound(robot),
            "method": base.proof.method,
        },
        "verification": {
            "digits": DIGITS,
            "seed": SEED,
            "tolerance": TOLERANCE[options["dtype"]],
            "points": {name: entry["points"] for name, entry in verified.items()},
            "expected": {name: entry["expected"] for name, entry in verified.items()},
        },
        "digests": digests,
    }

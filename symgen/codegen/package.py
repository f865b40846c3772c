"""Generate a package from a model: data, files of each target, documents, manifest.

The same model gives the same bytes: without dates, paths and set order, and independent of the
SymPy version.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from symgen.codegen.backends import (
    Package,
    arrays,
    c,
    casadi,
    cuda,
    firmware,
    mex,
    ros2,
    rust,
    simulink,
)
from symgen.codegen.c_printer import DTYPES
from symgen.codegen.definition import Subject
from symgen.codegen.kernel import Kernel
from symgen.codegen.kernels import ALL, KERNELS
from symgen.codegen.latex import latex_document
from symgen.codegen.model import Model, uncollected
from symgen.codegen.readme import readme
from symgen.codegen.values import Values
from symgen.codegen.verification import DIGITS, SEED, TOLERANCE
from symgen.errors import PackageError
from symgen.files import json_text, write_folder
from symgen.names import LICENSE, MAINTAINER
from symgen.robot.identifiers import default_prefix, is_robot_name
from symgen.robot.tables import Frame
from symgen.robot.toml_text import robot_toml
from symgen.symbolic.base_parameters import bound

SCHEMA = "symgen.manifest/1"


class Target(NamedTuple):
    """A target: returns path -> text of its files; the other targets whose files it needs."""

    files: Callable[[Package], dict[str, str]]
    builds_on: tuple[str, ...] = ()


TARGETS = {
    "c": Target(c.files),
    "casadi": Target(casadi.files),
    "mex": Target(mex.files, ("c",)),
    "ros2": Target(ros2.files),
    "firmware": Target(firmware.files, ("c",)),
    "rust": Target(rust.files, ("c",)),
    "simulink": Target(simulink.files, ("c",)),
    "jax": Target(partial(arrays.files, library="jax", name="jnp", kept="_kept(kept)")),
    "torch": Target(partial(arrays.files, library="torch", name="torch")),
    "cuda": Target(cuda.files, ("c",)),
}
#: The targets of "all". Other targets are written only by name.
ALL_TARGETS = ("c", "casadi", "mex")
#: License and maintainer that stand in every manifest: no character that a format would escape.
_LICENSE = re.compile(r"[A-Za-z0-9.+() -]+")
_MAINTAINER = re.compile(r"[^<>&\"\\]+ <[^<>&\"\\\s@]+@[^<>&\"\\\s@]+>")


@dataclass(frozen=True)
class SourceTree:
    """The files of a package: relative path and content."""

    name: str
    files: Mapping[str, bytes]


@uncollected()
def generate(
    model: Model,
    *,
    target: str = "all",
    dtype: str = "double",
    kernels: tuple[str, ...] | None = None,
    tex: bool = False,
    prefix: str | None = None,
    values: Values | None = None,
    license: str = LICENSE,
    maintainer: str = MAINTAINER,
) -> SourceTree:
    """Generate a package of C, CasADi and MEX, or of another target, from a model.

    Args:
        model: a model of `derive`.
        target: a name of `TARGETS`, with the files that it needs; "all" is c, casadi and mex.
        dtype: "double" or "float", for the C sources.
        kernels: names of the kernels to write; all by default. The identifier in C comes with
            energy_regressor (and with friction_power if the robot has friction), NAME_payload.h
            with those of the set "payload".
        tex: whether to add the model as a LaTeX document, with the formulas of the kernels.
        prefix: prefix of file and function names; by default the name of the robot. In float, it
            ends in f, so that one program can link both packages.
        values: values of the parameters, for NAME_values.h and the start values of MEX.
        license: license of the package in manifests of other tools, as an SPDX expression.
        maintainer: its maintainer there, as NAME <EMAIL>.

    Raises:
        PackageError: an option is unknown, or there is no kernel to write.
    """
    if dtype not in DTYPES:
        raise PackageError(f"dtype {dtype!r}; accepted: {', '.join(DTYPES)}")
    chosen = _chosen(model, kernels)
    targets = _targets(target)
    name = default_prefix(model.robot.name, dtype) if prefix is None else prefix
    if not is_robot_name(name):
        raise PackageError(f"prefix {name!r}; accepted: a C identifier that hides no header of C")
    if not _LICENSE.fullmatch(license):
        raise PackageError(
            f"license {license!r}; accepted: an SPDX expression, such as BSD-3-Clause"
        )
    if not (maintainer.isprintable() and _MAINTAINER.fullmatch(maintainer)):
        raise PackageError(f"maintainer {maintainer!r}; accepted: NAME <EMAIL>")
    package = Package(name, model, dtype, chosen, targets, values, license, maintainer)
    texts = {"robot.toml": robot_toml(model.robot)}
    for part in targets:
        texts |= TARGETS[part].files(package)
    if tex:
        texts[f"{name}.tex"] = latex_document(model.robot, model.base, chosen)
    texts["README.md"] = readme(package)
    files = {path: content.encode() for path, content in sorted(texts.items())}
    options = _options(package, target, tex)
    manifest = json_text(_manifest(package, options, files)) + "\n"
    files["manifest.json"] = manifest.encode()
    return SourceTree(name, dict(sorted(files.items())))


def summary(model: Model) -> list[str]:
    """Return lines on the proof of the base parameters, and on the kernels."""
    base = model.base
    lines = [
        f"no effect: {', '.join(base.no_effect) or 'none'}",
        f"{len(base.parameters)} base parameters of {len(base.standard)} standard ones "
        f"({base.inertial} inertial, bound {bound(model.robot)}); exact rank {base.proof.rank} "
        f"modulo {' and '.join(map(str, base.proof.primes))}",
    ]
    if base.nominal is not None:
        lines.append(base.nominal.text)
    for kernel in model.kernels:
        o = kernel.tape.operations
        lines.append(f"{kernel.name}: {o.mul} mul, {o.add} add, {o.div} div, {o.sincos} sincos")
    return lines


def _chosen(model: Model, names: Sequence[str] | None) -> tuple[Kernel, ...]:
    """Return the kernels to write."""
    known = [k.name for k in model.kernels]
    subject = Subject(model.robot, model.base)
    for name in () if names is None else names:
        if name not in known:
            reason = KERNELS[name].absent(subject) if name in KERNELS else ""
            place = f"kernel {name!r}: {reason}" if reason else f"kernel {name!r}"
            others = [k for k in ALL if not KERNELS[k].absent(subject)] if reason else known
            raise PackageError(f"{place}; accepted: all, or some of {', '.join(others)}")
    chosen = tuple(k for k in model.kernels if names is None or k.name in names)
    if not chosen:
        accepted = ", ".join(known) or "a model with at least one kernel"
        raise PackageError(f"a package without kernels; accepted: {accepted}")
    return chosen


def _targets(target: str) -> tuple[str, ...]:
    """Return the targets to write: those that the target builds on, then the target itself."""
    if target == "all":
        return ALL_TARGETS
    if target not in TARGETS:
        raise PackageError(f"target {target!r}; accepted: {', '.join(TARGETS)}, all")
    return (*TARGETS[target].builds_on, target)


def write_package(tree: SourceTree, folder: str | Path) -> None:
    """Write a package to a folder, completely or not at all; it replaces an older package."""
    write_folder(Path(folder), tree.files, "manifest.json")


def _options(package: Package, target: str, tex: bool) -> dict[str, Any]:
    """Return the options that reproduce the package."""
    options: dict[str, Any] = {
        "target": target,
        "dtype": package.dtype,
        "kernels": [k.name for k in package.kernels],
        "prefix": package.name,
    }
    if tex:
        options["tex"] = True
    if package.values is not None:
        options["values"] = vars(package.values)
    if package.license != LICENSE:
        options["license"] = package.license
    if package.maintainer != MAINTAINER:
        options["maintainer"] = package.maintainer
    return options


def _manifest(
    package: Package, options: Mapping[str, Any], files: Mapping[str, bytes]
) -> dict[str, Any]:
    """Return the manifest: description, proof of the parameters, check values, and digests."""
    robot, base = package.model.robot, package.model.base
    names: dict[str, Any] = {}
    if any(robot.joint_names):
        names["joint_names"] = robot.joint_names
    if robot.frames:
        names["frames"] = [_frame(f) for f in robot.frames]
    parameters = [
        {"name": b.name, "expression": b.expression, "unit": b.unit} for b in base.parameters
    ]
    if base.nominal is not None:
        names["nominal"] = vars(base.nominal)
    verification = {
        "digits": DIGITS,
        "seed": SEED,
        "tolerance": TOLERANCE[package.dtype],
        **package.verified,
    }
    return {
        "schema": SCHEMA,
        "robot": robot.name,
        "options": options,
        "joints": robot.n,
        "joint_numbers": robot.numbers,
        **names,
        "standard_parameters": len(base.standard),
        "standard_names": [p.name for p in base.standard],
        "base_parameters": parameters,
        "inertial_parameters": base.inertial,
        "no_effect": base.no_effect,
        "effects": [{"name": e.name, "kind": e.kind} for e in robot.effects],
        "kernels": [_kernel(k) for k in package.kernels],
        "proof": {**vars(base.proof), "bound": bound(robot), "method": base.proof.method},
        "verification": verification,
        "digests": {path: hashlib.sha256(content).hexdigest() for path, content in files.items()},
    }


def _kernel(kernel: Kernel) -> dict[str, Any]:
    return {
        "name": kernel.name,
        "inputs": [{"name": a.name, "shape": [a.size]} for a in kernel.inputs],
        "outputs": [vars(o) for o in kernel.outputs],
        "operations": vars(kernel.tape.operations),
    }


def _frame(frame: Frame) -> dict[str, Any]:
    return {"name": frame.name, "joint": frame.joint, "transform": frame.transform}

"""Generate a package from a model: C sources, build files, documents and the manifest.

The same model gives the same bytes: no dates, no paths, no order of sets, no SymPy version.
"""

from __future__ import annotations

import hashlib
import html
import re
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any

from symgen.codegen import example
from symgen.codegen.backends import Backend, Package, mex
from symgen.codegen.c_printer import DTYPES, Printer, literal
from symgen.codegen.casadi_source import casadi_source
from symgen.codegen.kernels import ENERGY, LINK, SCALARS, Kernel
from symgen.codegen.latex import latex_document
from symgen.codegen.model import Model, uncollected
from symgen.codegen.panels import panel, panelled
from symgen.codegen.recipes import FRICTION, RECIPES
from symgen.codegen.values import Values, values_header
from symgen.codegen.verification import (
    DIGITS,
    SEED,
    TOLERANCE,
    checked_kernel,
    verification,
)
from symgen.errors import PackageError
from symgen.files import json_text, rendered, write_folder
from symgen.robot.expressions import six_digits, text
from symgen.robot.identifiers import c_comment, c_identifiers, is_robot_name
from symgen.robot.tables import Frame
from symgen.robot.toml_text import robot_toml
from symgen.robot.types import Robot, joint_variable
from symgen.symbolic.base_parameters import bound
from symgen.symbolic.tape import real_symbol

SCHEMA = "symgen.manifest/1"
#: Version of the interface in C, CMake and pkg-config; the first number is that of the layout.
_VERSION = "1.2.0"
_LINE = 100  # line length of a header
_SINCOS, _LANES = "math.h", "lanes.h"  # no public headers
#: The C runtime: least squares, and the online identifier.
_RUNTIME = ("least_squares", "identifier", "identifier_momentum")
#: Limits of [limits] that C has as constants.
_LIMITS = ("position", "velocity", "acceleration", "jerk", "torque")
#: Targets that build on the C sources.
BACKENDS: dict[str, Backend] = {"mex": mex}
TARGETS = ("c", "casadi", *BACKENDS, "all")

_wrapped = partial(textwrap.wrap, break_long_words=False, break_on_hyphens=False)


@dataclass(frozen=True)
class SourceTree:
    """The files of a package: relative path and content."""

    name: str
    files: Mapping[str, bytes]

    @property
    def library(self) -> dict[str, bytes]:
        """Sources and headers of the functions, without check and examples."""
        return {
            path: content
            for path, content in self.files.items()
            if path.endswith((".c", ".h")) and "/" not in path and path != f"{self.name}_check.c"
        }


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
) -> SourceTree:
    """Generate a package of C, CasADi and MEX from a model.

    Args:
        model: from `derive`.
        target: "c", "casadi", "mex" (with its C), or "all" that the kernels allow.
        dtype: "double" or "float", for the C sources.
        kernels: names of the kernels to write; all by default. The identifier in C comes with
            energy_regressor (and with friction_power if the robot has friction).
        tex: whether to add the model as a LaTeX document, with the formulas of the kernels.
        prefix: prefix of file and function names; by default the name of the robot. In float, it
            ends in f, so that one program can link both packages.
        values: values of the parameters, for NAME_values.h and the start values of MEX.

    Raises:
        PackageError: an option is unknown, or there is no kernel to write.
    """
    if dtype not in DTYPES:
        raise PackageError(f"dtype {dtype!r}; accepted: {', '.join(DTYPES)}")
    chosen = _chosen(model, kernels)
    added = _backends(target, chosen)
    name = default_prefix(model.robot.name, dtype) if prefix is None else prefix
    if not is_robot_name(name):
        raise PackageError(f"prefix {name!r}; accepted: a C identifier that hides no header of C")
    if values is not None:
        values.require(model.base)
    writer = _Writer(model, target, dtype, chosen, tex, name, added, values)
    return writer.tree()


def _chosen(model: Model, names: Sequence[str] | None) -> tuple[Kernel, ...]:
    known = [k.name for k in model.kernels]
    for name in known if names is None else names:
        if name in FRICTION and name not in known and model.base.linear == model.base.inertial:
            others = ", ".join(other for other in RECIPES if other not in FRICTION)
            raise PackageError(
                f"kernel {name!r}: {model.robot.name} has no friction and no effects; "
                f"accepted: all, or some of {others}"
            )
        if name not in known:
            raise PackageError(f"kernel {name!r}; accepted: {', '.join(known)}")
    chosen = tuple(k for k in model.kernels if names is None or k.name in names)
    if not chosen:
        accepted = ", ".join(known) or "a model with at least one kernel"
        raise PackageError(f"a package without kernels; accepted: {accepted}")
    return chosen


def _backends(target: str, kernels: Sequence[Kernel]) -> tuple[str, ...]:
    """Return the backends of a target; for "all", those whose kernels are written."""
    if target not in TARGETS:
        raise PackageError(f"target {target!r}; accepted: {', '.join(TARGETS)}")
    written = {k.name for k in kernels}
    if target == "all":
        return tuple(name for name in BACKENDS if written >= BACKENDS[name].NEEDS)
    if target not in BACKENDS:
        return ()
    missing = sorted(BACKENDS[target].NEEDS - written)
    if missing:
        raise PackageError(f"target {target}: needs the kernels {', '.join(missing)}")
    return (target,)


def library(
    model: Model, kernels: Sequence[str] | None = None, *, panels: bool = False
) -> dict[str, bytes]:
    """Return the C sources and headers of a model in double, for an evaluator.

    They are the functions of `generate` for target "c", without the other files.
    Without panels, batches are loops of single calls, which compile faster.
    """
    chosen = tuple(k for k in model.kernels if kernels is None or k.name in kernels)
    writer = _Writer(model, "c", "double", chosen, False, model.robot.name, (), panels=panels)
    return {path: content.encode() for path, content in writer.library().items()}


def default_prefix(robot: str, dtype: str) -> str:
    """Return the default prefix of a package."""
    return f"{robot}f" if dtype == "float" else robot


def model_digest(robot_file: str) -> str:
    """Return the digest of a model for C: 64 bits of a SHA-256.

    Args:
        robot_file: the SHA-256 of the canonical robot.toml, in hexadecimal digits.
    """
    return f"0x{robot_file[:16]}ULL"


def write_package(tree: SourceTree, folder: str | Path) -> None:
    """Write a package to a folder, completely or not at all; an older package is replaced."""
    write_folder(Path(folder), tree.files, "manifest.json")


def robot_key(robot: Robot) -> str:
    """Return the key of a robot: the first 64 bits of the SHA-256 of its robot.toml."""
    return hashlib.sha256(robot_toml(robot).encode()).hexdigest()[:16]


def runtime_source(path: str, gravity_input: bool, dtype: str = "double") -> str:
    """Return a file of the C runtime, with NAME in place of the prefix.

    Args:
        path: path in templates/c/runtime.
        gravity_input: whether its functions take g as the last input.
        dtype: double or float.
    """
    declared, given = (", const NAME_real *g", ", g") if gravity_input else ("", "")
    names = ("bytes", "bits", "ps", "f", "sqrt")
    values = (4, 32, "ps", "f", "sqrtf") if dtype == "float" else (8, 64, "pd", "", "sqrt")
    kind = dict(zip(names, values, strict=True))
    return rendered(
        f"c/runtime/{path}",
        gravity_input=gravity_input, dtype=dtype, G=declared, g=given, **kind,
    )  # fmt: skip


@dataclass(frozen=True)
class _Writer:
    model: Model
    target: str
    dtype: str
    kernels: tuple[Kernel, ...]
    tex: bool
    name: str
    backends: tuple[str, ...]
    values: Values | None = None
    panels: bool = True

    def tree(self) -> SourceTree:
        verified = verification(self.model, self.kernels)
        robot = self.model.robot
        files = {"robot.toml": robot_toml(robot).encode()}
        if self.target != "casadi":
            files |= {path: content.encode() for path, content in self.c_files(verified).items()}
        if self.target in ("casadi", "all"):
            source = casadi_source(self.name, self.model, self.kernels)
            files[f"{self.name}_casadi.py"] = source.encode()
            if self.controlled:
                program = example.optimal_control(self.name, self.model)
                files[f"example/{self.name}_optimal_control.py"] = program.encode()
        if self.tex:
            files[f"{self.name}.tex"] = latex_document(
                robot, self.model.base, self.kernels
            ).encode()
        files["README.md"] = self.readme().encode()
        digests = {
            path: hashlib.sha256(content).hexdigest() for path, content in sorted(files.items())
        }
        manifest = self.manifest(verified) | {"digests": digests}
        files["manifest.json"] = (json_text(manifest) + "\n").encode()
        return SourceTree(self.name, dict(sorted(files.items())))

    def render(self, template: str, **data: Any) -> str:
        """Render a template with the model and further values."""
        robot, base = self.model.robot, self.model.base
        return rendered(
            f"c/{template}",
            name=self.name,
            robot=robot.name,
            n=robot.n,
            p=len(base.parameters),
            inertial=self.model.inertial,
            gravity_input=robot.gravity_input,
            version=_VERSION,
            dtype=self.dtype,
            proof=base.proof,
            backends=self.backends,
            percent=example.PERCENT,
            example=self.example,
            **data,
        )

    @cached_property
    def runtime(self) -> tuple[str, ...]:
        """Parts of the runtime whose kernels are written."""
        written = {k.name for k in self.kernels}
        model = self.model
        rubs = len(model.base.parameters) > model.inertial
        if model.robot.loaded:
            return ()  # not linear in X

        def complete(kernel: str, friction: str) -> bool:
            return {kernel, *([friction] if rubs else [])} <= written

        if not complete(*ENERGY):
            return ()
        return _RUNTIME if complete("momentum_regressor", "friction_torque") else _RUNTIME[:-1]

    @property
    def example(self) -> bool:
        """Whether the controller's example is written: it calls the identifier."""
        needed = self.target != "casadi" and bool(self.runtime)
        return needed and example.called_by(example.CONTROLLER, self.kernels)

    @property
    def controlled(self) -> bool:
        smooth = not self.model.robot.effects
        return smooth and example.called_by(example.OPTIMAL_CONTROL, self.kernels)

    def library(self) -> dict[str, str]:
        """Return the sources and headers of the functions."""
        robot = self.model.robot
        kernels = [self.describe(k) for k in self.kernels]
        header = self.render(
            "model.h",
            joints=", ".join(f"q{j.number}" for j in robot.movable),
            named=[(f"q{j.number}", c_comment(j.name)) for j in robot.movable if j.name],
            places=_named_places(robot),
            geometry=[(name, literal(value, self.dtype)) for name, value in robot.geometry],
            base=[
                (b.name, _wrapped(f"{six_digits(b.expression)} [{b.unit}]", _LINE - 4))
                for b in self.model.base.parameters
            ],
            kernels=kernels,
            numbers=_VERSION.split("."),
            digest=model_digest(robot_key(robot)),
        )
        out = {f"{self.name}.h": header}
        for k in kernels:
            out[f"{self.name}_{k['name']}.c"] = self.render("kernel.c", k=k)
        plain = [f"{stem}{suffix}" for stem in self.runtime for suffix in (".h", ".c")]
        if any(k["needs_sincos"] for k in kernels):
            plain.append(_SINCOS)
        if on_panels := [k for k in kernels if k["panel"]]:
            plain.append(_LANES)
            out[f"{self.name}_panels.h"] = self.render("panels.h", kernels=on_panels)
            for k in on_panels:
                out[f"{self.name}_{k['name']}_panels.c"] = self.render("panels.c", k=k)
        for path in plain:
            source = runtime_source(path, robot.gravity_input, self.dtype)
            out[f"{self.name}_{path}"] = source.replace("NAME", self.name)
        return out

    def c_files(self, verified: Mapping[str, Any]) -> dict[str, str]:
        out = self.library()
        private = [f"{self.name}_{header}" for header in (_SINCOS, _LANES)]
        sources = [path for path in out if path.endswith(".c")]
        if frames := self.frames():
            out[f"{self.name}_links.h"] = self.render("links.h", frames=frames)
        limits = {key: getattr(self.model.robot.limits, key, None) for key in _LIMITS}
        if any(value is not None for value in limits.values()):
            out[f"{self.name}_limits.h"] = self.render("limits.h", limits=limits)
        if self.values is not None:
            base, robot = self.model.base, self.model.robot
            out[f"{self.name}_values.h"] = values_header(
                self.name,
                robot.name,
                self.values,
                [(b.name, b.expression, b.unit) for b in base.parameters],
                digest=model_digest(robot_key(robot)),
                standard=[p.name for p in base.standard],
            )
        headers = [p for p in out if p.endswith(".h") and p not in private]
        out[f"{self.name}_check.c"] = self.render(
            "check.c",
            kernels=[
                checked_kernel(self.name, k, verified[k.name], self.dtype) for k in self.kernels
            ],
            digits=DIGITS,
            tolerance=repr(TOLERANCE[self.dtype]),
        )
        if self.example:
            facts = example.facts(self.model, self.dtype)
            for file in ("simulated.h", "controller.c"):
                out[f"example/{self.name}_{file}"] = self.render(f"example/{file}", **facts)
        out["CMakeLists.txt"] = self.render(
            "CMakeLists.txt", sources=sources, headers=" ".join(headers)
        )
        out[f"{self.name}.pc.in"] = self.render("package.pc.in")
        package = Package(self.name, self.model, self.dtype, self.kernels, dict(out), self.values)
        for target in self.backends:
            out |= BACKENDS[target].files(package)
        return out

    def frames(self) -> list[dict[str, Any]]:
        """Return the frames of links: ending of the C names, text, joint, and rows of numbers."""
        frames = self.model.robot.frames
        endings = c_identifiers((f.name for f in frames), "frame")
        return [
            {
                "ending": ending,
                "text": c_comment(frame.name),
                "joint": frame.joint,
                "rows": [
                    ", ".join(f"({self.name}_real){x!r}" for x in row) for row in frame.transform
                ],
            }
            for ending, frame in zip(endings, frames, strict=True)
        ]

    def describe(self, kernel: Kernel) -> dict[str, Any]:
        """Return the data of a kernel for the templates."""
        robot, listed = self.model.robot, kernel.arguments
        macros = {real_symbol(g): f"{self.name}_geometry_{g}" for g, _ in robot.geometry}
        function = Printer(kernel, macros, robot.values(), self.dtype, self.name).function()
        on_panels = self.panels and panelled(kernel)
        counts = vars(kernel.tape.operations)
        shapes = [f"{a.name}: {self.shape(a.name, a.size)}" for a in kernel.inputs]
        for o in kernel.outputs:
            of = f": {', '.join(o.columns)}" if o.columns else ""
            comma = "," if len(o.shape) == 1 else ""
            shapes.append(f"{o.name}: ({', '.join(map(str, o.shape))}{comma}){of}")
        return {
            "name": kernel.name,
            "doc": _wrapped(kernel.doc, _LINE - 4),
            "shapes": [
                line for s in shapes for line in _wrapped(s, _LINE - 4, subsequent_indent="  ")
            ],
            "returns": "int" if kernel.fallible else "void",
            "fallible": kernel.fallible,
            "guarded": bool(kernel.guards),
            "links": kernel.links,
            "loop": kernel.batch and not on_panels,
            "panel": on_panels and panel(kernel, macros, robot.values(), self.dtype, self.name),
            "parameters": kernel.listed(self.dtype),
            "batch_parameters": kernel.listed(self.dtype, batch=True),
            "batch_lines": _wrapped(kernel.listed(self.dtype, batch=True), _LINE - 4),
            "strides": ", ".join(
                a.name if a.shared else f"&{a.name}[k * {a.size}u]" for a in listed
            ),
            "declarations": [
                line
                for prototype in kernel.prototypes(self.name, self.dtype)
                for line in _wrapped(prototype, _LINE, subsequent_indent="    ")
            ],
            "operations": ", ".join(f"{v} {key}" for key, v in counts.items() if v)
            or "0 operations",
            "body": function.body,
            "dtype": self.dtype,
            "names": ", ".join(a.name for a in listed),
            "needs_math": function.needs_math,
            "needs_sincos": function.needs_sincos,
        }

    def shape(self, name: str, size: int) -> str:
        """Describe an input."""
        if name == LINK:
            return (
                f"number of a joint in robot.toml, 1 to {size}; with any other the function "
                f"returns {self.name}_NO_SUCH_LINK and writes nothing"
            )
        return "a number" if name in SCALARS else f"({size},)"

    def readme(self) -> str:
        robot, base = self.model.robot, self.model.base
        panels = (f"{k.name}_panels" for k in self.kernels if panelled(k))
        stems = (*(k.name for k in self.kernels), *panels, *self.runtime)
        return self.render(
            "README.md",
            casadi=self.kernels[-1].name if self.target in ("casadi", "all") else "",
            sources=" ".join(f"{self.name}_{stem}.c" for stem in stems),
            table=[
                " | ".join(
                    [
                        *map(str, (j.number, j.sigma, j.antecedent)),
                        *map(text, (j.gamma, j.b, j.alpha, j.d, j.theta, j.r)),
                        text(sum((c * joint_variable(k) for k, c in j.shares), j.offset)),
                        _markdown(j.name) or "-",
                    ]
                )
                for j in robot.joints
            ],
            effects=[
                (_markdown(e.name), e.joint, text(e.torque), e.nonlinear) for e in robot.effects
            ],
            gravity="[" + ", ".join(text(g) for g in robot.gravity) + "]",
            identifier=bool(self.runtime),
            geometry=[(name, text(value)) for name, value in robot.geometry],
            base=base.parameters,
            no_effect=", ".join(base.no_effect) or "none",
            kernels=[(k.name, *vars(k.tape.operations).values()) for k in self.kernels],
            control=self.controlled,
        )

    def manifest(self, verified: Mapping[str, Any]) -> dict[str, Any]:
        """Return the manifest: description, proof of the parameters, and check values."""
        robot, base = self.model.robot, self.model.base
        return {
            "schema": SCHEMA,
            "robot": robot.name,
            "options": {
                "target": self.target,
                "dtype": self.dtype,
                "kernels": [k.name for k in self.kernels],
                "prefix": self.name,
                **({"tex": True} if self.tex else {}),
                **({"values": vars(self.values)} if self.values is not None else {}),
            },
            "joints": robot.n,
            "joint_numbers": robot.numbers,
            **({"joint_names": robot.joint_names} if any(robot.joint_names) else {}),
            **({"frames": [_frame_entry(f) for f in robot.frames]} if robot.frames else {}),
            "standard_parameters": len(base.standard),
            "standard_names": [p.name for p in base.standard],
            "base_parameters": [
                {"name": b.name, "expression": b.expression, "unit": b.unit}
                for b in base.parameters
            ],
            "inertial_parameters": self.model.inertial,
            "no_effect": base.no_effect,
            "effects": [{"name": e.name, "kind": e.kind} for e in robot.effects],
            "kernels": [
                {
                    "name": k.name,
                    "inputs": [{"name": a.name, "shape": [a.size]} for a in k.inputs],
                    "outputs": [vars(o) for o in k.outputs],
                    "operations": vars(k.tape.operations),
                }
                for k in self.kernels
            ],
            "proof": {
                **vars(base.proof),
                "bound": bound(robot),
                "method": base.proof.method,
            },
            "verification": {
                "digits": DIGITS,
                "seed": SEED,
                "tolerance": TOLERANCE[self.dtype],
                "points": {name: entry["points"] for name, entry in verified.items()},
                "expected": {name: entry["expected"] for name, entry in verified.items()},
            },
        }


def _named_places(robot: Robot) -> list[tuple[str, int]]:
    """Return an ending of a C identifier for each joint with a name, and its place in q."""
    named = [(k, j.name) for k, j in enumerate(robot.movable) if j.name]
    endings = c_identifiers((name for _, name in named), "joint")
    return [(ending, k) for ending, (k, _) in zip(endings, named, strict=True)]


def _frame_entry(frame: Frame) -> dict[str, Any]:
    """Return a frame for the manifest."""
    return {"name": frame.name, "joint": frame.joint, "transform": frame.transform}


def _markdown(name: str) -> str:
    """Escape a text for Markdown, so that it forms no HTML tag, link or table cell."""
    return re.sub(r"([\\`*\[\]|!])", r"\\\1", html.escape(name, quote=False))

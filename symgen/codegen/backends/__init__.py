"""Backends: each writes the files of one target."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from symgen.codegen.kernel import Kernel
from symgen.codegen.kernels import ENERGY
from symgen.codegen.model import Model
from symgen.codegen.values import Values
from symgen.codegen.verification import verification
from symgen.files import rendered
from symgen.names import LICENSE, MAINTAINER
from symgen.robot.identifiers import c_fields

#: Version of the interface in C, CMake and pkg-config. The first number is that of the array
#: layout.
VERSION = "1.3.0"


@dataclass(frozen=True)
class Package:
    """The content of a package, from which backends write its files.

    Attributes:
        name: prefix of every file and function.
        model: the derived model.
        dtype: "double" or "float", of the C sources.
        kernels: the kernels to write.
        targets: the targets to write.
        values: values of the parameters, if known.
        license: license in manifests of other tools: an SPDX expression, or LICENSE.
        maintainer: maintainer there, as NAME <EMAIL>.
    """

    name: str
    model: Model
    dtype: str
    kernels: tuple[Kernel, ...]
    targets: tuple[str, ...] = ()
    values: Values | None = None
    license: str = LICENSE
    maintainer: str = MAINTAINER

    def has(self, *kernels: str) -> bool:
        """Return whether the package contains all these kernels."""
        return set(kernels) <= {k.name for k in self.kernels}

    @property
    def spdx(self) -> str:
        """The license for manifests that accept only SPDX expressions; "" if there is none."""
        return "" if self.license == LICENSE else self.license

    @property
    def contact(self) -> tuple[str, str]:
        """Name and e-mail address of the maintainer."""
        name, _, address = self.maintainer.removesuffix(">").rpartition(" <")
        return name, address

    @property
    def joint_fields(self) -> list[str]:
        """A variable of C for each movable joint: its name, or q and its number."""
        return c_fields(j.name or f"q{j.number}" for j in self.model.robot.movable)

    @cached_property
    def verified(self) -> Mapping[str, Any]:
        """Check values, as from `verification`."""
        return verification(self.model, self.kernels)

    @cached_property
    def runtime(self) -> tuple[str, ...]:
        """Parts of the C runtime: least squares, the identifiers, and the follower of a load, for
        the kernels of the package.
        """
        base = self.model.base
        regressor, power = ENERGY
        friction = len(base.parameters) > base.inertial
        torque = ["friction_torque"] if friction else []
        parts: list[str] = []
        if (
            self.model.robot.loaded or self.model.robot.floating
        ):  # friction without columns, wrenches
            return ()
        if self.has(regressor, *([power] if friction else [])):
            parts += ["least_squares", "identifier"]
            if self.has("momentum_regressor", *torque):
                parts.append("identifier_momentum")
        if self.has("load_momentum", "add_load", "generalized_momentum", *torque):
            parts.append("payload")
        return tuple(parts)

    def render(self, template: str, **data: Any) -> str:
        """Render a template with the names and sizes of the package and further data."""
        robot, base = self.model.robot, self.model.base
        return rendered(
            template,
            name=self.name,
            robot=robot.name,
            n=robot.n,
            p=len(base.parameters),
            inertial=base.inertial,
            gravity_input=robot.gravity_input,
            imu=robot.imu,
            floating=robot.floating,
            version=VERSION,
            dtype=self.dtype,
            **data,
        )

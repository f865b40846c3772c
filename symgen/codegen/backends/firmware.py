"""Firmware: the package as a library of Arduino, PlatformIO, ESP-IDF and Zephyr, and named fields.

All these tools compile the .c files of the folder itself. CMakeLists.txt of the target "c" has the
component of ESP-IDF.
"""

from __future__ import annotations

from symgen.codegen.backends import Package

_SECTION = "==> "  # begins the path of each manifest in the template


def files(package: Package) -> dict[str, str]:
    """Return the manifests, and NAME_state.h."""
    sentence = f"Dynamic model of the robot {package.model.robot.name} in its base parameters."
    manifests = package.render(
        "firmware/manifests.txt",
        sentence=sentence,
        maintainer=package.maintainer,
        contact=package.contact,
        license=package.spdx,
    )
    sections = (section.partition("\n") for section in manifests.split(_SECTION)[1:])
    out = {path: content for path, _, content in sections}
    state = package.render("firmware/state.h", fields=package.joint_fields)
    return {**out, f"{package.name}_state.h": state}

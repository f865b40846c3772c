"""The built-in robots. Listing them needs no heavy import."""

from __future__ import annotations

from importlib import resources


def library() -> tuple[str, ...]:
    """Return the names of the built-in robots."""
    folder = resources.files("symgen.robot") / "library"
    return tuple(
        sorted(f.name.removesuffix(".toml") for f in folder.iterdir() if f.name.endswith(".toml"))
    )


def library_text(name: str) -> str:
    """Return the robot.toml of a library robot."""
    return (resources.files("symgen.robot") / "library" / f"{name}.toml").read_text("utf-8")


def library_summary(name: str) -> tuple[str, str]:
    """Return the joint types of a library robot (for example "RRP") and its description."""
    import tomllib

    text = library_text(name)
    joints = tomllib.loads(text)["joint"]
    kinds = "".join(
        "RP"[joint.get("sigma", 0)]
        for joint in joints
        if joint.get("sigma", 0) != 2 and "follows" not in joint
    )
    return kinds, text.splitlines()[0].lstrip("# ")

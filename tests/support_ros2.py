"""ROS packages in tests: built with the installed pluginlib and stubs, and called from Python.

class_loader, pluginlib, ament_cmake, urdfdom and Eigen are Debian's own; rclcpp, ros2_control,
kinematics_interface and inverse_dynamics_solver are the stubs in tests/ros/stubs, with the
signatures of each distribution.
"""

from __future__ import annotations

import ctypes
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.managers import BaseManager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from packages import run

HERE = Path(__file__).parent / "ros"
DISTRIBUTIONS = {"humble": 1, "jazzy": 2, "lyrical": 3}
INSTALLED = ("pluginlib", "class_loader", "rcutils", "rcpputils", "ament_index_cpp", "eigen3")
SYSTEM = [part for name in INSTALLED for part in ("-isystem", f"/usr/include/{name}")]
FLAGS = "-std=c++17 -O2 -fPIC -Wall -Wextra -Wpedantic -Wshadow -Werror".split()


def needs_ros() -> None:
    """Skip where Debian's ROS packages or a C++ compiler are missing."""
    headers = [Path("/usr/include", name) for name in (*INSTALLED, "urdf_parser")]
    missing = [path.name for path in headers if not path.is_dir()]
    missing += [name for name in ("g++", "gcc") if shutil.which(name) is None]
    if missing:
        pytest.skip(f"{', '.join(missing)}: not installed (Debian: pluginlib-dev, liburdfdom-dev)")


def compiler(distribution: str) -> list[str]:
    """Return the command line of the C++ compiler for the stubs of a distribution."""
    chosen = f"-DDISTRIBUTION={DISTRIBUTIONS[distribution]}"
    return ["g++", *FLAGS, chosen, *SYSTEM, f"-I{HERE / 'stubs'}"]


def build(package: Path, distribution: str, into: Path) -> Path:
    """Build the plugins of a ROS package, and the host that loads them; return the folder."""
    into.mkdir(parents=True)
    sources = sorted((package / "model").glob("*.c"))
    run(["gcc", "-std=c99", "-O2", "-fPIC", "-c", *sources], into)
    objects = sorted(into.glob("*.o"))
    shared = [*compiler(distribution), f"-I{package / 'model'}", "-shared"]
    libraries = ["-lclass_loader", "-lurdfdom_model"]
    for stem in ("controller", "solver", "kinematics"):
        source = package / "src" / f"{stem}.cpp"
        run([*shared, source, *objects, *libraries, "-o", into / f"{stem}.so"], into)
    run([*shared, HERE / "host.cpp", "-lclass_loader", "-o", into / "host.so"], into)
    return into


def pointer(values: np.ndarray) -> Any:
    return values.ctypes.data_as(ctypes.c_void_p)


class Host:
    """A plugin of a built package."""

    def __init__(self, folder: Path, package: str, stem: str, **parameters: Any) -> None:
        self.library = ctypes.CDLL(str(folder / "host.so"))
        for name, kind in (
            ("last_log", ctypes.c_char_p),
            ("open_host", ctypes.c_void_p),
            ("interface_names", ctypes.c_char_p),
            ("time_solver", ctypes.c_double),
        ):
            getattr(self.library, name).restype = kind
        self.package = package
        self.handle = ctypes.c_void_p(self.library.open_host(str(folder / f"{stem}.so").encode()))
        for name, value in parameters.items():
            self.set(name.replace("__", "."), value)

    def set(self, name: str, value: Any) -> None:
        """Set a parameter of the node."""
        key = name.encode()
        if isinstance(value, bool):
            self.library.set_flag(self.handle, key, int(value))
        elif isinstance(value, str):
            self.library.set_text(self.handle, key, value.encode())
        elif len(value) and isinstance(value[0], str):
            self.library.set_names(self.handle, key, ",".join(value).encode())
        else:
            numbers = np.array(value, float)
            whole = len(value) > 0 and all(type(x) is int for x in value)
            call = self.library.set_integers if whole else self.library.set_numbers
            call(self.handle, key, pointer(numbers), len(numbers))

    def log(self) -> str:
        """Return the last message."""
        return self.library.last_log().decode()

    def start(self, kind: str, urdf: str) -> int:
        """Load a class by its name and begin it; 0 where it accepts."""
        begin = getattr(self.library, f"start_{kind}")
        types = {
            "controller": "ModelController",
            "solver": "InverseDynamicsSolver",
            "kinematics": "Kinematics",
        }
        return begin(self.handle, f"{self.package}::{types[kind]}".encode(), urdf.encode())

    def names(self, kind: int) -> list[str]:
        """Names of the commands (0), states (1) or references (2)."""
        return self.library.interface_names(self.handle, kind).decode().split(",")

    def chain(self, chained: bool) -> None:
        self.library.chain(self.handle, int(chained))

    def refer(self, values: Any) -> None:
        self.library.set_references(self.handle, pointer(np.array(values, float)))

    def cycle(self, q: Any, qd: Any = None) -> np.ndarray | None:
        """Return the torques of one cycle; None where the controller reports an error."""
        q = np.asarray(q, float)
        speed = np.zeros(len(q)) if qd is None else np.asarray(qd, float)
        state = np.stack([q, speed], axis=1).ravel()
        return None if self.library.cycle(self.handle, pointer(state)) else self.commands(len(q))

    def commands(self, n: int) -> np.ndarray:
        """Return the torques that the hardware has."""
        tau = np.zeros(n)
        self.library.get_commands(self.handle, pointer(tau))
        return tau

    def deactivate(self) -> None:
        self.library.deactivate(self.handle)

    def load(self, frame: str, mass: float, com: Any = (0, 0, 0), inertia: Any = (0,) * 6) -> str:
        """Publish a load; return the message of the log."""
        body = np.array([mass, *com, *inertia], float)
        self.library.publish_load(self.handle, frame.encode(), pointer(body))
        return self.log()

    def solve(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> dict[str, np.ndarray]:
        n = len(q)
        out = {name: np.zeros(n) for name in ("coriolis", "gravity", "friction", "torques")}
        out = {"inertia": np.zeros((n, n)), **out}
        inputs = map(pointer, (q, qd, qdd))
        assert not self.library.solve(self.handle, n, *inputs, *map(pointer, out.values())), (
            self.log
        )
        return out

    def locate(self, q: np.ndarray, link: str) -> tuple[np.ndarray, ...] | None:
        """Return pose, Jacobian and damped inverse of a link; None where it is refused."""
        n = len(q)
        T, J, inverse = np.zeros((4, 4)), np.zeros((n, 6)), np.zeros((6, n))
        call = self.library.locate
        if call(self.handle, n, pointer(q), link.encode(), *map(pointer, (T, J, inverse))):
            return None
        return T.T, J.T, inverse.T

    def seconds(self, which: int, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, n: int) -> float:
        """Seconds of one call of getTorques (0) or getInertiaMatrix (1), from n calls."""
        inputs = map(pointer, (q, qd, qdd))
        return self.library.time_solver(self.handle, len(q), *inputs, which, n) / n


class Hosts(BaseManager):
    """A process with plugins: class_loader finds a class by its name in all that are loaded."""


Hosts.register("Host", Host)


@dataclass(frozen=True)
class Built:
    """The plugins of a package, built, and the process that loads them."""

    folder: Path
    package: str
    hosts: Hosts

    @property
    def distribution(self) -> str:
        return self.folder.name

    def host(self, stem: str, **parameters: Any) -> Any:
        """Return a host of a plugin in the process."""
        return self.hosts.Host(self.folder, self.package, stem, **parameters)


@contextmanager
def process() -> Iterator[Hosts]:
    """Start a process for plugins."""
    with Hosts(ctx=get_context("spawn")) as hosts:
        yield hosts

"""The result of a simulation: true motions, and the logs that instruments made of them."""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.data.drive import motor_side
from symgen.data.log import Log, make_log
from symgen.errors import LogError
from symgen.experiment.instruments import Instruments
from symgen.robot.types import Drive

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Simulation:
    """What truly happened in every run, and what its log shows. Arrays are read-only.

    Attributes:
        robot: its name.
        t: (N,) stamps, s.
        q: (runs, N, n) true positions, rad or m.
        qd: (runs, N, n) true speeds, rad/s or m/s.
        tau: (runs, N, n) commanded torques, N m or N.
        q_log: (runs, N, n) positions in the logs.
        qd_log: (runs, N, n) speeds in the logs, None without tachometers.
        tau_log: (runs, N, n) torques in the logs.
        sigma: types of the joints.
        joints: their numbers in the robot file.
        notes: what was done, in words.
        drive: of the robot; files are on the side that it says that logs are on.
        temp: (N, n) temperatures in the logs, deg C, or None.
    """

    robot: str
    t: FloatArray
    q: FloatArray
    qd: FloatArray
    tau: FloatArray
    q_log: FloatArray
    qd_log: FloatArray | None
    tau_log: FloatArray
    sigma: tuple[int, ...]
    joints: tuple[int, ...]
    notes: tuple[str, ...] = ()
    drive: Drive | None = None
    temp: FloatArray | None = None

    def __repr__(self) -> str:
        """Return robot, runs and duration."""
        span = f"{self.t[-1] - self.t[0]:.4g} s"
        return f"<Simulation of {self.robot}: {self.runs} runs of {span}, {len(self.t)} stamps>"

    @property
    def runs(self) -> int:
        """Number of runs."""
        return len(self.q_log)

    def seen_by(self, instruments: Instruments, runs: range, seed: int) -> Simulation:
        """Return the same motions in the logs of some instruments.

        Args:
            instruments: what the logs show.
            runs: numbers of the runs: one a motion, or any of the one motion that there is.
            seed: of all noise.
        """
        count = len(self.t)
        noise = instruments.motion_noise(runs, seed, (count, len(self.sigma)))
        q, qd = instruments.delayed(self.t, self.q, self.qd, slice(0, count))
        q, qd = instruments.read(q, qd, *noise)
        arrays = (self.q, self.qd, self.tau, q, qd, instruments.torque(self.tau, runs, seed))
        shape = (len(runs), count, len(self.sigma))
        true_q, true_qd, tau, q, qd, tau_log = (_view(np.broadcast_to(x, shape)) for x in arrays)
        return replace(
            self, q=true_q, qd=true_qd, tau=tau, q_log=q,
            qd_log=qd if instruments.velocity else None, tau_log=tau_log,
        )  # fmt: skip

    def log(self, run: int = 0) -> Log:
        """Return the log of a run, on the joint side.

        Raises:
            LogError: it is no log that identification would take, such as one of under 10 samples.
        """
        qd = None if self.qd_log is None else self.qd_log[run]
        name = f"{self.robot} {run + 1}"
        q, tau = self.q_log[run], self.tau_log[run]
        log = make_log(name, self.t, q, tau, qd, sigma=self.sigma, temp=self.temp)
        return replace(log, mapped=self.drive is not None)

    def files(self, into: Path) -> Iterator[tuple[Path, bytes]]:
        """Yield path and content of every run's log: `into`, or NAME_1 and so on where several."""
        for run, path in enumerate(log_paths(into, self.runs)):
            yield path, self.file(run, path.suffix)

    def file(self, run: int = 0, suffix: str = ".csv") -> bytes:
        """Return the log of a run as the content of a CSV or NPZ file.

        Raises:
            LogError: the suffix is neither .csv nor .npz.
        """
        qd = None if self.qd_log is None else self.qd_log[run]
        log = Log(self.robot, self.t, self.q_log[run], qd, self.tau_log[run])
        if self.drive is not None:
            log = motor_side(log, self.drive)
        every = {"q": log.q, "qd": log.qd, "tau": log.tau, "i": log.current, "temp": self.temp}
        groups: dict[str, Any] = {r: array for r, array in every.items() if array is not None}
        if suffix == ".npz":
            out = io.BytesIO()
            np.savez(out, t=self.t, **groups)
            return out.getvalue()
        _require_format(suffix)
        names = [f"{role}{j + 1}" for role in groups for j in range(len(self.sigma))]
        rows = np.column_stack([self.t, *groups.values()]).tolist()
        form = ",".join(["%.12g"] * (1 + len(names)))
        return "\n".join([",".join(["t", *names]), *(form % tuple(r) for r in rows), ""]).encode()


def _view(array: FloatArray) -> FloatArray:
    """Return a view that nobody writes to; unlike `read_only`, without a copy."""
    view = array.view()
    view.setflags(write=False)
    return view


def log_paths(into: Path, runs: int) -> list[Path]:
    """Return the paths of the logs of some runs.

    Raises:
        LogError: the suffix is neither .csv nor .npz.
    """
    _require_format(into.suffix)
    if runs == 1:
        return [into]
    return [into.with_name(f"{into.stem}_{run + 1}{into.suffix}") for run in range(runs)]


def _require_format(suffix: str) -> None:
    if suffix not in (".csv", ".npz"):
        raise LogError(f"log {suffix or 'without a suffix'}; accepted: .csv or .npz")

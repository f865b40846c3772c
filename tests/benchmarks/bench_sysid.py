"""Position error after 1 s, and time to get there, beside MuJoCo's toolbox for identification.

    python tests/benchmarks/bench_sysid.py --peer PYTHON [--windows 24]

PYTHON is that of an environment with `mujoco[sysid]`. The log is that of the linear axis emps, in
the folder SYMGEN_DATA. Both identify mass, viscous and Coulomb friction and offset on train.csv;
test.csv judges, simulated with symgen's plant for both. The toolbox starts at 1.5 times symgen's
values, with bounds of a tenth and ten times its start. It fits positions of windows of 1 s of the
log that symgen filtered, from measured states. symgen reads, repairs and filters the log, chooses a
model and judges it: all of that counts. Linear least squares has no start and no bounds. Times are
of the processor.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

DATA = Path(os.environ.get("SYMGEN_DATA", "../shared/data")) / "emps"
NAMES = ("M1", "FV1", "FS1", "OF1")
START, FACTOR, SECONDS = 1.5, 10.0, 1.0
NEAR = 1.1
XML = """
<mujoco><option timestep="{step}" gravity="0 0 0" integrator="implicitfast"/>
<worldbody><body name="car"><inertial pos="0 0 0" mass="{M1}" diaginertia="1 1 1"/>
<joint name="q1" type="slide" axis="0 0 1" damping="{FV1}" frictionloss="{FS1}"/></body></worldbody>
<actuator><general name="tau1" joint="q1" biastype="affine" biasprm="{bias} 0 0"/></actuator>
<sensor><jointpos name="q1_pos" joint="q1"/></sensor></mujoco>
"""


def peer(path: Path) -> None:
    """Fit the windows of a file with mujoco.sysid; write the parameters of each iteration."""
    import mujoco
    from mujoco import sysid

    given = np.load(path)
    step, start = float(given["step"]), given["start"]

    def build(params: Any) -> Any:
        M1, FV1, FS1, OF1 = (params[name].value[0] for name in NAMES)
        return mujoco.MjModel.from_xml_string(
            XML.format(step=step, M1=M1, FV1=FV1, FS1=FS1, bias=-OF1)
        )

    params = sysid.ParameterDict()
    for name, value in zip(NAMES, start, strict=True):
        ends = sorted((value / FACTOR, value * FACTOR))
        params.add(sysid.Parameter(name, value, *(ends if name != "OF1" else (-50.0, 50.0))))
    model = build(params)
    began = time.process_time()
    sequences = []
    for k, (q, tau, qd) in enumerate(zip(given["q"], given["tau"], given["qd"], strict=True)):
        t = np.arange(len(q)) * step
        state = sysid.create_initial_state(model, q[:1], qd[:1], np.zeros(0))
        control = sysid.TimeSeries.from_control_names(t, tau[:, None], model)
        sensor = sysid.TimeSeries.from_names(t, q[:, None], model)
        sequences.append((f"w{k}", state, control, sensor))
    names, states, controls, sensors = zip(*sequences, strict=True)
    data = sysid.ModelSequences(
        "emps", mujoco.MjSpec.from_string(XML.format(step=step, M1=1, FV1=1, FS1=1, bias=0)),
        list(names), list(states), list(controls), list(sensors),
    )  # fmt: skip

    course: list[tuple[float, np.ndarray]] = [(0.0, start)]

    def measured(x: np.ndarray, *more: Any, **options: Any) -> Any:
        if x.ndim == 1 or x.shape[1] == 1:
            course.append((time.process_time() - began, np.ravel(x).copy()))
        return residual(x, *more, **options)

    residual = sysid.build_residual_fn(
        models_sequences=[data], build_model=lambda p, _=None: build(p)
    )
    best, _ = sysid.optimize(params, measured, "mujoco", verbose=False)
    course.append((time.process_time() - began, best.as_vector()))
    np.savez(path.with_name("found.npz"), t=[c[0] for c in course], X=[c[1] for c in course])


def main() -> None:
    """Fit both and print the errors of each on the held-out log."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--peer", default=sys.executable)
    parser.add_argument("--windows", type=int, default=24)
    parser.add_argument("--fit", type=Path, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.fit:
        peer(given.fit)
        return
    import symgen
    from symgen.estimation.band import Band
    from symgen.estimation.filtered_log import filter_log
    from symgen.estimation.playback import HORIZONS, model_mover, play, position_errors, windows_of
    from symgen.faults.repair import open_samples

    robot = symgen.read_robot(DATA / "robot.toml")
    symgen.load(symgen.derive(robot))
    began = time.process_time()
    found = symgen.identify(robot, DATA / "train.csv", validation=DATA / "test.csv")
    own = time.process_time() - began
    values = {p.name: p.value for p in found.parameters}
    order = [p.name for p in found.parameters]
    band = found.band
    assert isinstance(band, Band)
    logs = [filter_log(open_samples(DATA / f"{name}.csv", robot, None)[0], band)
            for name in ("train", "test")]  # fmt: skip
    train, test = (windows_of([log], given.windows) for log in logs)
    every = max(1, round(1e-3 / logs[0].step))
    rows = [slice(w.rows.start, w.rows.stop, every) for w in train]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "windows.npz"
        np.savez(
            path, step=logs[0].step * every, start=START * np.array([values[n] for n in NAMES]),
            q=[logs[0].q[r, 0] for r in rows], qd=[logs[0].qd[r, 0] for r in rows],
            tau=[logs[0].tau[r, 0] for r in rows],
        )  # fmt: skip
        environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
        subprocess.run([given.peer, __file__, "--fit", path], check=True, env=environment)
        theirs = np.load(path.with_name("found.npz"))
        times, X = theirs["t"], theirs["X"]

    model = symgen.derive(robot)
    t = np.array([0.0, *HORIZONS])

    def error(each: dict[str, float]) -> list[float]:
        x = np.array([each[name] for name in order])
        moved = play(model_mover(model, x), test, t)
        return [h.position_error for h in position_errors(test, t, moved)[0]]

    ours = error(values)
    course = [error(dict(zip(NAMES, x, strict=True))) for x in X]
    least = np.minimum.accumulate([c[-1] for c in course])
    near = times[np.argmax(least <= NEAR * least[-1])]
    print(f"position errors after {HORIZONS} s, and time")
    print(f"symgen: {np.round(ours, 4)}, {own:.2f} s; {values}")
    print(f"mujoco.sysid: {np.round(course[-1], 4)}, {times[-1]:.2f} s; {X[-1].tolist()}")
    print(f"its best, {least[-1]:.4f}, is near (within {NEAR} times) after {near:.2f} s")


if __name__ == "__main__":
    main()

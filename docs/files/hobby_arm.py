"""A simulated hobby arm, which plays the part of yours.

python hobby_arm.py            records the LeRobot data sets free, other and weight
python hobby_arm.py GOALS      follows two lists of goals, and prints their position errors
"""

import json
import sys
from pathlib import Path

import mujoco
import numpy as np
import pyarrow as pa
from pyarrow import parquet

FPS, STEP = 30, 0.001  # frames/s, s
TICK, GAIN = 2 * np.pi / 4096, 6.0  # rad, duty/rad
FULL = np.array([2.9, 3.1, 2.8, 2.9, 3.0, 2.9])  # torque at full duty, N m


def arm(weight: float) -> mujoco.MjModel:
    """Return the arm: links are 25 % heavier than in the file, and joints have rotors and friction."""
    spec = mujoco.MjSpec.from_file("hobby.urdf")
    spec.body("gripper").add_body(name="weight", ipos=[0.07, 0, 0], mass=1, inertia=[1e-5] * 3)
    spec.compiler.fusestatic = False
    model = spec.compile()
    model.body_mass[:] *= 1.25
    model.body_inertia[:] *= 1.25
    model.body("weight").mass = weight
    model.dof_armature[:] = 0.028
    model.dof_damping[:] = 0.5  # with the back-EMF of the motors
    model.dof_frictionloss[:] = 0.05
    model.dof_solref[:] = 0.002, 1.0
    model.opt.timestep, model.opt.integrator = STEP, mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    return model


def move(start: np.ndarray, goals: np.ndarray, weight: float = 0.0) -> np.ndarray:
    """Return the positions at each frame of goals, (N, 6) in rad, from those at the start."""
    model, seen = arm(weight), np.empty_like(goals)
    data = mujoco.MjData(model)
    data.qpos[:] = start
    ends = np.round(np.arange(1, len(goals) + 1) / FPS / STEP)
    for frame, goal in enumerate(goals):
        seen[frame] = np.round(data.qpos / TICK) * TICK
        while round(data.time / STEP) < ends[frame]:
            position = np.round(data.qpos / TICK) * TICK
            data.qfrc_applied[:] = FULL * np.clip(GAIN * (goal - position), -1, 1)
            mujoco.mj_step(model, data)
    return seen


def record(name: str, seed: int, seconds: int, weight: float = 0.0) -> None:
    """Write a data set with a slow random motion. The gripper stays closed."""
    random, t = np.random.default_rng(seed), np.arange(seconds * FPS) / FPS
    frequency, phase = random.uniform(0.05, 0.5, (5, 6)), random.uniform(0, 2 * np.pi, (5, 6))
    size = random.uniform(0.1, 0.4, (5, 6)) * [1, 1, 1, 1, 1, 0]
    angle = 2 * np.pi * frequency * t[:, None, None] + phase
    goals = np.round((size * np.sin(angle)).sum(axis=1) / TICK) * TICK
    states = move(goals[0], goals, weight)
    model, folder = arm(weight), Path(name)
    (folder / "meta").mkdir(parents=True)
    (folder / "data/chunk-000").mkdir(parents=True)
    feature = {"shape": [6], "names": [f"{model.joint(j).name}.pos" for j in range(6)]}
    info = {"fps": FPS, "features": {"observation.state": feature, "action": feature}}
    (folder / "meta/info.json").write_text(json.dumps(info))
    columns = {
        "observation.state": np.degrees(states).tolist(),
        "action": np.degrees(goals).tolist(),
        "episode_index": np.zeros(len(t), dtype=int),
        "index": np.arange(len(t)),
    }
    parquet.write_table(pa.table(columns), folder / "data/chunk-000/file-000.parquet")


def follow(file: str) -> None:
    """Follow wanted positions, and goals for them; each line has five of both."""
    table = np.loadtxt(file)
    gripper = np.zeros((len(table), 1))
    wanted, goals = np.hstack([table[:, :5], gripper]), np.hstack([table[:, 5:], gripper])
    plain, gravity = (np.degrees(move(wanted[0], x) - wanted) for x in (wanted, goals))
    print(f"largest position error: {np.abs(plain).max():.1f} degrees")
    print(f"with gravity compensation: {np.abs(gravity).max():.1f} degrees")
    shoulder = np.column_stack([np.arange(len(table)) / FPS, plain[:, 1], gravity[:, 1]])
    np.savetxt("errors.csv", shoulder, delimiter=",", header="t,plain,gravity", comments="")


if __name__ == "__main__":
    if len(sys.argv) > 1:
        follow(sys.argv[1])
    else:
        record("free", 1, 60)
        record("other", 2, 30)
        record("weight", 3, 60, 0.2)

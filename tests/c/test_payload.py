"""The load that an arm grips, on line in C, against an arm of seven joints in Pinocchio."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from oracles.transforms import LINK_PARAMETERS, Arm
from packages import STRICT, STRICT_CXX, run

import symgen
from symgen.cli import cli
from symgen.codegen.model import regrouping

pytest.importorskip("pinocchio", reason="Pinocchio (pin) is not installed")
from oracles.pinocchio_arm import PinocchioArm

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler (cc) here")

OK, NOT_EXCITED, CHANGING = 0, 8, 16384
RATE, EVERY = 1000, 10  # samples a second; samples between two reads
H = np.pi / 2
TABLE = {
    "sigma": [0] * 7, "alpha": [0, -H, H, H, -H, H, H], "d": [0, 0, 0, 0.0825, -0.0825, 0, 0.088],
    "r": [0.333, 0, 0.316, 0, 0.384, 0, 0],
}  # fmt: skip
ROTORS = np.array([0.6, 0.6, 0.5, 0.5, 0.25, 0.2, 0.2])
FS, FV = np.array([4.0, 4, 3, 3, 1.5, 1, 1]), np.array([5.0, 5, 4, 4, 1.5, 1, 1])
NOISE = np.array([0.2] * 4 + [0.05] * 3)  # N m
HOME = np.array([0, 0.3, 0, -1.6, 0, 1.7, 0])
#: Reads the load every EVERY samples, as a controller would, and prints status, load, std, and the
#: torque of gravity at home with the latest X whose status is OK.
DRIVER = """
#include "NAME_payload.h"
#include <stdio.h>
#include <string.h>
int main(void)
{
    static NAME_payload memory;
    NAME_real X[NAME_PARAMETERS], loaded[NAME_PARAMETERS], home[NAME_JOINTS], g[NAME_JOINTS];
    NAME_real x[3 * NAME_JOINTS], load[10], std[10];
    const NAME_real dt = (NAME_real)0.001;
    int k = 0;
    if (NAME_payload_init(&memory, NAME_payload_size(), 3, (NAME_real)0.3, 1) != NAME_OK ||
        fread(home, sizeof *home, NAME_JOINTS, stdin) != NAME_JOINTS ||
        fread(X, sizeof *X, NAME_PARAMETERS, stdin) != NAME_PARAMETERS)
        return 1;
    memcpy(loaded, X, sizeof loaded);
    while (fread(x, sizeof *x, 3 * NAME_JOINTS, stdin) == 3 * NAME_JOINTS) {
        (void)NAME_payload_step(&memory, x, x + NAME_JOINTS, x + 2 * NAME_JOINTS, dt, X);
        if (++k % 10 == 0) {
            const int status = NAME_payload_read(&memory, load, std);
            if (status == NAME_OK)
                NAME_add_load(X, load, loaded);
            NAME_gravity_torque(home, loaded, g);
            printf("%d", status);
            for (int i = 0; i < 10; i++) printf(" %.9g", (double)load[i]);
            for (int i = 0; i < 10; i++) printf(" %.9g", (double)std[i]);
            for (int i = 0; i < NAME_JOINTS; i++) printf(" %.9g", (double)g[i]);
            printf("\\n");
        }
    }
    return 0;
}
"""


def body(mass: float, centre: np.ndarray, inertia: np.ndarray) -> np.ndarray:
    """Parameters of a body about the origin of a frame, from those about its centre of mass."""
    about = np.diag(inertia) + mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    return np.array([*about[np.triu_indices(3)], *(mass * centre), mass])


LINKS = np.array([
    body(mass, np.array(centre), mass * np.array([0.01, 0.008, 0.006]))
    for mass, centre in (
        (3.0, [0.0, -0.03, -0.12]), (3.0, [0.0, -0.07, 0.03]), (3.2, [0.03, 0.03, -0.07]),
        (3.6, [-0.05, 0.1, 0.03]), (1.2, [-0.01, 0.04, -0.1]), (1.7, [0.06, -0.01, 0.0]),
        (0.7, [0.01, 0.0, 0.08]),
    )
])  # fmt: skip
LOAD = body(2.0, np.array([0.02, 0.01, 0.1]), np.array([0.01, 0.01, 0.008]))


def carrying(load: np.ndarray) -> PinocchioArm:
    links = LINKS.copy()
    links[6] += load
    return PinocchioArm(Arm.from_table(TABLE), links, ROTORS)


def recorded(
    duration: float, has: tuple[float, float], still: tuple[float, float] | None = None
) -> np.ndarray:
    """Record rows [q qd tau] of the arm with noise. It has the load between two times.

    still: the times between which it stands, held by static friction of any size; it slows down
    and starts within 0.3 s.
    """
    rng = np.random.default_rng(3)
    t = np.arange(round(duration * RATE)) / RATE
    pace = np.ones_like(t)
    if still:
        slowing, starting = (np.clip((t - begin) / 0.3, 0, 1) for begin in still)
        pace += (3 - 2 * starting) * starting**2 - (3 - 2 * slowing) * slowing**2
    phase = np.cumsum(pace) / RATE
    w, a = 2 * np.pi * rng.uniform(0.1, 0.6, (4, 7)), rng.uniform(0.1, 0.3, (4, 7))
    angle = phase[:, None, None] * w + rng.uniform(0, 2 * np.pi, (4, 7))
    speed = (a * w * np.cos(angle)).sum(1)
    q = HOME + (a * np.sin(angle)).sum(1)
    qd = pace[:, None] * speed
    qdd = pace[:, None] ** 2 * -(a * w**2 * np.sin(angle)).sum(1)
    qdd += np.gradient(pace, 1 / RATE)[:, None] * speed
    arms = [carrying(load) for load in (0 * LOAD, LOAD)]
    full = ((t >= has[0]) & (t < has[1])).astype(int)
    tau = np.array([arms[x].inverse_dynamics(*s) for x, *s in zip(full, q, qd, qdd, strict=True)])
    tau += FV * qd + np.where(pace[:, None] < 1e-9, rng.uniform(-0.7, 0.7, 7), np.sign(qd)) * FS
    noises = 2e-5, 2e-3, NOISE
    channels = [x + s * rng.normal(size=x.shape) for x, s in zip((q, qd, tau), noises, strict=True)]
    return np.hstack(channels)


def driver(dtype: str, folder: Path) -> Path:
    """Compile the driver with the package that the command writes."""
    package = folder / dtype
    command = [
        "generate",
        "panda",
        "--target",
        "c",
        "--dtype",
        dtype,
        "--kernels",
        "payload,gravity_torque",
    ]
    assert CliRunner().invoke(cli, [*command, "--into", str(package)]).exit_code == 0
    name = "pandaf" if dtype == "float" else "panda"
    (package / "main.c").write_text(DRIVER.replace("NAME", name))
    sources = ["main.c", *(path.name for path in package.glob(f"{name}_*.c"))]
    run(["cc", *STRICT, "-O1", *sources, "-lm", "-o", "driver"], package)
    return package / "driver"


def X() -> np.ndarray:
    model = symgen.derive("panda")
    rows = zip(LINKS, ROTORS, FS, FV, strict=True)
    value = {}
    for j, (link, rotor, coulomb, viscous) in enumerate(rows, 1):
        value |= {f"{p}{j}": x for p, x in zip(LINK_PARAMETERS, link, strict=True)}
        value |= {f"IA{j}": rotor, f"FS{j}": coulomb, f"FV{j}": viscous}
    return regrouping(model) @ [value[p.name] for p in model.base.standard]


@pytest.fixture(scope="module")
def follow(tmp_path_factory) -> Callable[[str, np.ndarray], tuple[np.ndarray, ...]]:
    """Return a function that runs the driver: times, status, load, std and gravity of all reads."""
    folder = tmp_path_factory.mktemp("payload")
    drivers = {dtype: driver(dtype, folder) for dtype in ("double", "float")}
    given = X()

    def followed(dtype: str, rows: np.ndarray) -> tuple[np.ndarray, ...]:
        real = np.float32 if dtype == "float" else np.float64
        sent = np.concatenate([HOME, given, rows.ravel()]).astype(real).tobytes()
        done = subprocess.run([drivers[dtype]], input=sent, capture_output=True, check=True)
        out = np.array([line.split() for line in done.stdout.splitlines()], float)
        t = (1 + np.arange(len(out))) * EVERY / RATE
        return t, out[:, 0], out[:, 1:11], out[:, 11:21], out[:, 21:]

    return followed


def gravity_error(load: np.ndarray) -> float:
    """Error of the gravity torque over 100 positions that a load in place of LOAD makes."""
    rng, zero = np.random.default_rng(9), np.zeros(7)
    believed = np.array([*LOAD[:6], *load[6:]])  # gravity asks for no inertia
    true, other = carrying(LOAD), carrying(believed)
    positions = HOME + rng.uniform(-1.2, 1.2, (100, 7))
    weight, error = [], []
    for q in positions:
        weight.append(true.inverse_dynamics(q, zero, zero))
        error.append(other.inverse_dynamics(q, zero, zero) - weight[-1])
    return float(np.linalg.norm(error) / np.linalg.norm(weight))


@pytest.mark.parametrize("dtype", ["double", "float"])
def test_a_load_is_known_soon_after_it_is_gripped_and_after_it_is_released(follow, dtype) -> None:
    grip, release = 2.5, 6.0
    t, status, load, std, weight = follow(dtype, recorded(8.0, (grip, release)))
    before = (t > 1) & (t <= grip)
    known = (t > grip + 1.5) & (t <= release)
    settled = (t > grip + 3) & (t <= release)
    after = t > release + 1.5
    assert (status[before | known | after] == OK).all()
    # From 0.15 s on nothing says that the old load holds.
    for change in (grip, release):
        assert (status[(t > change + 0.15) & (t <= change + 0.2)] == CHANGING).all()
    for when, held in ((before, 0 * LOAD), (known, LOAD), (after, 0 * LOAD)):
        assert (np.abs(load[when] - held) <= 5 * std[when]).all()
    assert (np.diff(weight, axis=0)[status[1:] != OK] == 0).all()  # held
    true = carrying(LOAD).inverse_dynamics(HOME, 0 * HOME, 0 * HOME)
    assert (np.linalg.norm(weight[known] - true, axis=1) < 0.01 * np.linalg.norm(true)).all()
    assert std[known, 9].max() < 0.02
    assert max(gravity_error(x) for x in load[known][::10]) < 0.01
    assert (np.abs(load[settled, 9] - 2) < 0.02 * 2).all()


@pytest.mark.parametrize("dtype", ["double", "float"])
def test_rest_missing_and_wild_samples_do_no_harm(follow, dtype) -> None:
    still = 2.0, 4.0
    rows = recorded(7.0, (3.0, 7.0), still)
    rng = np.random.default_rng(1)
    wild = rng.random(rows.shape) < 5e-4
    rows[wild] += rng.choice([-30.0, 30.0], wild.sum())
    for k in rng.integers(0, len(rows), 12):
        rows[k : k + rng.integers(1, 40)] = np.nan
    t, status, load, std, _ = follow(dtype, rows)
    resting = (t > still[0] + 0.4) & (t <= still[1])
    assert (status[resting] == NOT_EXCITED).all()
    moving = t > still[1] + 1.5
    good = moving & (status == OK)
    assert good.sum() > 0.8 * moving.sum()
    assert (np.abs(load[good] - LOAD) <= 5 * std[good]).all()
    assert max(gravity_error(x) for x in load[good][::10]) < 0.01


def test_a_motion_that_does_not_show_the_load_is_not_ok(follow) -> None:
    t = np.arange(3 * RATE) / RATE
    rows = np.zeros((len(t), 21))
    rows[:, :7] = HOME
    rows[:, 6] += 0.3 * np.sin(3 * t)
    rows[:, 13] = 0.9 * np.cos(3 * t)
    arm, rng = carrying(LOAD), np.random.default_rng(0)
    tau = [
        arm.inverse_dynamics(q, qd, 0 * q) for q, qd in zip(rows[:, :7], rows[:, 7:14], strict=True)
    ]
    rows[:, 14:] = tau + FV * rows[:, 7:14] + FS * np.sign(rows[:, 7:14])
    rows[:, 20] += (ROTORS[6] + LINKS[6, 5] + LOAD[5]) * -2.7 * np.sin(3 * t)
    rows[:, 7:] += np.array([2e-3] * 7 + [*NOISE]) * rng.normal(size=(len(t), 14))
    _, status, load, std, _ = follow("double", rows)
    assert (status != OK).all()
    assert (std[:, 9] > 1).all()  # of 3 kg that were assumed
    assert (np.abs(load - LOAD) <= 5 * std).all()


@pytest.mark.parametrize("gravity", ["[1.5, 0.0, -9.81]", '"input"'])
def test_the_load_is_on_the_link_of_payload(gravity, tmp_path) -> None:
    robot = symgen.parse_robot(
        f'[robot]\nname = "held"\ngravity = {gravity}\n[payload]\njoint = 2\n'
        '[[joint]]\nfriction = []\n[[joint]]\nalpha = "pi/2"\nfriction = []\n'
        "[[joint]]\nd = 0.4\nfriction = []\n"
    )
    model = symgen.derive(robot, ("payload",))
    names = [p.name for p in model.base.standard]
    G = regrouping(model)
    load, start = np.arange(1.0, 11.0), np.arange(1.0, 1 + len(G))
    columns = G[:, [names.index(f"{p}2") for p in LINK_PARAMETERS]]
    found = symgen.load(model)["add_load"](start, load)
    np.testing.assert_allclose(found, start + columns @ load, rtol=1e-14)
    symgen.write_package(symgen.generate(model, target="c", dtype="float"), tmp_path / "c")
    run(["cc", *STRICT, "-c", "heldf_payload.c"], tmp_path / "c")
    if shutil.which("c++"):
        run(["c++", *STRICT_CXX, "-c", "heldf_payload.c"], tmp_path / "c")


def test_a_package_has_it_only_by_name(tmp_path) -> None:
    def files(*options: str) -> set[str]:
        folder = tmp_path / "-".join(options)
        command = ["generate", "planar2r", "--target", "c", *options, "--into", str(folder)]
        done = CliRunner().invoke(cli, command)
        assert done.exit_code == 0, done.output
        return {path.name for path in folder.iterdir()}

    everything = files()
    with_load = files("--kernels", "all,payload")
    assert not [name for name in everything if "load" in name]
    added = {f"planar2r_{name}" for name in ("payload.h", "payload.c", "add_load.c")}
    assert added <= with_load - everything
    assert everything <= with_load
    done = CliRunner().invoke(cli, ["generate", "planar2r", "--kernels", "pay"])
    assert "accepted: some of all, payload" in str(done.exception)


@pytest.mark.parametrize(
    ("key", "table", "reason"),
    [
        ('base = "imu"', "", "a base at rest"),
        ("", '[[effect]]\nname = "load_dependent_friction"\njoints = [1]', "depends on the load"),
    ],
)
def test_where_no_load_can_be_followed_the_command_says_why(
    command, tmp_path, key, table, reason
) -> None:
    file = tmp_path / "arm.toml"
    file.write_text(f'[robot]\nname = "arm"\n{key}\n[[joint]]\n[[joint]]\nd = 0.4\n{table}\n')
    code, _, err = command("generate", file, "--kernels", "payload", "--into", tmp_path / "arm")
    assert code == 2
    assert reason in err

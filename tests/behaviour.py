"""What every public verb answers, kept as a reference for changes that must not alter behaviour.

    python tests/behaviour.py keep [CASE...]      # write reference/behaviour.json.gz
    python tests/behaviour.py compare [CASE...]   # run again, print what differs, exit 1 if any

A case is one or more command lines on logs that oracles make (Pinocchio, closed forms, seeded
noise) or on the real logs of SYMGEN_DATA. Kept are exit codes, the files that a refusal names, and
the values of every JSON that is written, each with the tolerance that TOLERANCES gives its name.
Cases of real logs are left out where the folder is absent.
"""

from __future__ import annotations

import argparse
import contextlib
import gzip
import hashlib
import io
import json
import os
import re
import shlex
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
from oracles import clean_runs, faults, planar2r

PROJECT = Path(__file__).resolve().parents[1]
KEPT = PROJECT / "tests" / "reference" / "behaviour.json.gz"
DATA = Path(os.environ.get("SYMGEN_DATA", PROJECT.parent / "shared" / "data"))
REAL = ("emps", "tx40", "ur10e", "ur10", "kr300", "dp_c0")
LIBRARY = ("emps", "planar2r", "puma560", "scara", "sr400", "twin", "panda")

#: Never compared: digests, versions, long arrays of curves.
LEFT_OUT = re.compile(r"provenance|digest|correlation|whiteness|curves|seconds$|sha256")
#: Relative tolerance by the last name of a value's path; the first that matches holds.
TOLERANCES: tuple[tuple[str, float], ...] = (
    (r"condition|gain|horizons|spread|position_error", 1e-4),
    (r"p_value|probability", 1e-3),
    (r"std|percent|sigma", 1e-5),
    (r"", 1e-6),
)

Run = Callable[..., None]
CASES: dict[str, Callable[[Path, Run], None]] = {}


def case(name: str) -> Callable[[Callable[[Path, Run], None]], Callable[[Path, Run], None]]:
    """Register a case under a name."""

    def add(body: Callable[[Path, Run], None]) -> Callable[[Path, Run], None]:
        CASES[name] = body
        return body

    return add


# Real logs.


def _real(robot: str) -> tuple[str, str, str]:
    folder = DATA / robot
    end = ".npz" if (folder / "train.npz").exists() else ".csv"
    return str(folder / "robot.toml"), str(folder / f"train{end}"), str(folder / f"test{end}")


for _robot in REAL if DATA.is_dir() else ():

    @case(f"real-{_robot}")
    def _(folder: Path, run: Run, robot: str = _robot) -> None:
        toml, train, test = _real(robot)
        run("identify", toml, train, "--validation", test, "--into", folder / "fit")
        run("predict", toml, test, "--parameters", folder / "fit", "--into", folder / "predicted")

    @case(f"diagnose-{_robot}")
    def _(folder: Path, run: Run, robot: str = _robot) -> None:
        toml, train, test = _real(robot)
        run("diagnose", toml, train, "--validation", test, "--into", folder / "why")


if DATA.is_dir():

    @case("several-logs")
    def _(folder: Path, run: Run) -> None:
        toml, _, test = _real("ur10e")
        logs = [DATA / "ur10e" / name for name in ("train.csv", "train2.csv", "ptp.csv")]
        run("identify", toml, *logs, "--validation", test, "--into", folder / "fit")

    for _model in ("energy", "momentum", "torque"):

        @case(f"model-{_model}")
        def _(folder: Path, run: Run, model: str = _model) -> None:
            toml, train, test = _real("tx40")
            run("identify", toml, train, "--validation", test, "--model", model,
                "--into", folder / "fit")  # fmt: skip


# Simulated logs.


def _simulated(folder: Path, seed: int, **options: Any) -> tuple[Path, Path, Path]:
    made = clean_runs.run(seed, **options)
    (folder / "robot.toml").write_text(made.robot_toml, "utf-8")
    return (folder / "robot.toml", made.train.save(folder / "train.npz"),
            made.validation.save(folder / "validation.npz"))  # fmt: skip


for _seed in range(10):

    @case(f"simulated-{_seed}")
    def _(folder: Path, run: Run, seed: int = _seed) -> None:
        robot, train, test = _simulated(folder, 700 + seed, faulty=0.5)
        run("identify", robot, train, "--validation", test, "--into", folder / "fit")


for _seed in range(4):

    @case(f"diagnose-simulated-{_seed}")
    def _(folder: Path, run: Run, seed: int = _seed) -> None:
        arms = ("planar2r", "elbow3r")
        robot, train, test = _simulated(folder, 800 + seed, arms=arms, effects=bool(seed % 2))
        run("diagnose", robot, train, "--validation", test, "--into", folder / "why")


_METHODS = ("ols", "huber", "tls", "iv", "ridge", "essential", "consistent", "recursive")
for _method in _METHODS:

    @case(f"method-{_method}")
    def _(folder: Path, run: Run, method: str = _method) -> None:
        robot, train, test = _simulated(folder, 900, arms=("elbow3r",), rates=(200,), effects=False)
        run("identify", robot, train, "--validation", test, "--method", method,
            "--model", "momentum", "--into", folder / "fit")  # fmt: skip


@case("options")
def _(folder: Path, run: Run) -> None:
    robot, train, test = _simulated(folder, 901, arms=("planar3r",), rates=(250,), effects=False)
    held = ("--validation", test)
    run("identify", robot, train, *held, "--cutoff", 8, "--window", 0.1, "--into", folder / "a")
    run("identify", robot, train, *held, "--mask", "rest", "--from", 2, "--into", folder / "b")
    run("identify", robot, train, "--prior", folder / "a", "--into", folder / "c")
    run("identify", robot, train, test, "--weights", "1,0.5", "--into", folder / "d")
    run("predict", robot, test, "--parameters", folder / "a" / "estimate.json", "--cutoff", 6,
        "--into", folder / "e")  # fmt: skip
    run("diagnose", robot, train, "--parameters", folder / "a", "--effects",
        "gravity_spring,stribeck_friction", "--into", folder / "f")  # fmt: skip
    run("report", folder / "a", folder / "b")


for _workers in (0, 2):

    @case(f"out-of-core-{_workers}")
    def _(folder: Path, run: Run, workers: int = _workers) -> None:
        import pyarrow as pa
        import pyarrow.parquet as pq

        made = clean_runs.run(902, arms=("elbow3r",), rates=(500,), speeds=True, effects=False)
        (folder / "robot.toml").write_text(made.robot_toml, "utf-8")
        (folder / "logs").mkdir()
        for k, log in enumerate((made.train, made.validation)):
            columns = {"t": log.t} | {
                f"{name}{j + 1}": x[:, j]
                for name, x in (("q", log.q), ("qd", log.qd), ("tau", log.tau))
                for j in range(log.n)
            }
            pq.write_table(pa.table(columns), folder / "logs" / f"{k}.parquet")
        spread = ("--workers", workers) if workers else ()
        run("identify", folder / "robot.toml", folder / "logs", *spread, "--into", folder / "fit")
        run("identify", folder / "robot.toml", folder / "logs", "--model", "torque", *spread,
            "--into", folder / "torque")  # fmt: skip


# Thirty spoiled logs.

for _number, _spoil in enumerate((*faults.LIGHT, *faults.HEAVY)):

    @case(f"fault-{_spoil.__name__}")
    def _(folder: Path, run: Run, number: int = _number, spoil: Any = _spoil) -> None:
        made = clean_runs.run(903, arms=("elbow3r",), rates=(200,), speeds=True, effects=False)
        (folder / "robot.toml").write_text(made.robot_toml, "utf-8")
        logs = []
        for name, log in (("train", made.train), ("validation", made.validation)):
            # Both logs alike, as one measuring chain leaves them.
            spoiled, _ = spoil(log, np.random.default_rng([number, 5]))
            logs.append(spoiled.save(folder / f"{name}.npz"))
        run("identify", folder / "robot.toml", logs[0], "--validation", logs[1], "--into",
            folder / "fit")  # fmt: skip
        if number % 4 == 0:
            run("diagnose", folder / "robot.toml", logs[0], "--validation", logs[1], "--into",
                folder / "why")  # fmt: skip


_REFUSED = {
    "decreasing": "t,q1,q2,tau1,tau2\n0,0,0,1,1\n0.1,0,0,1,1\n0.05,0,0,1,1\n",
    "columns": "t,q1,tau1\n0,0,0\n0.1,0,0\n",
    "empty": "",
    "text": "t,q1,q2,tau1,tau2\n0,a,0,1,1\n",
    "short": "t,q1,q2,tau1,tau2\n0,0,0,1,1\n0.1,0,0,1,1\n",
    "constant": "t,q1,q2,tau1,tau2\n" + "".join(f"{k / 100},0.5,0.5,1,1\n" for k in range(1000)),
}


@case("refused")
def _(folder: Path, run: Run) -> None:
    for name, text in _REFUSED.items():
        (folder / f"{name}.csv").write_text(text)
        run("identify", "planar2r", folder / f"{name}.csv", "--into", folder / "fit")
    run("identify", "no_such_robot", "log.csv", "--into", folder / "fit")
    run("predict", "planar2r", "log.csv", "--parameters", "absent.json", "--into", folder / "p")


# Robots of every kind: simulated by the verb itself, identified again.

_BODY = {"XX": 0.3, "XY": 0.01, "XZ": -0.02, "YY": 0.35, "YZ": 0.015, "ZZ": 0.4,
         "MX": 0.2, "MY": -0.1, "MZ": 0.15, "M": 2.5, "IA": 0.3, "FS": 1.2, "FV": 1.5,
         "OF": 0.2}  # fmt: skip
_JOINT = '[[joint]]\nalpha = "{alpha}"\nd = {d}\nfriction = ["coulomb", "viscous"]\n'


def _toml(name: str, joints: str, more: str = "") -> str:
    return (f'[robot]\nname = "{name}"\nconvention = "modified-dh"\n'
            f"gravity = [0.0, 0.0, -9.81]\n{joints}{more}")  # fmt: skip


_ELBOW = _JOINT.format(alpha="0", d=0.0) + _JOINT.format(alpha="pi/2", d=0.1)
_ROBOTS = {
    "planar": _toml("planar", _ELBOW),
    "prismatic": _toml("prismatic", _ELBOW + '[[joint]]\nsigma = 1\nalpha = "pi/2"\n'),
    "fixed": _toml("fixed", _ELBOW + "[[joint]]\nsigma = 2\nd = 0.2\n" + _JOINT.format(
        alpha="-pi/2", d=0.1)),
    "coupled": _toml("coupled", _ELBOW + _JOINT.format(alpha="-pi/2", d=0.2),
                     "[[coupling]]\njoints = [2, 3]\nratio = 1.0\n"),
    "spring": _toml("spring", _ELBOW, '[[effect]]\nname = "gravity_spring"\njoints = [2]\n'),
    "stribeck": _toml("stribeck", _ELBOW, '[[effect]]\nname = "stribeck_friction"\njoints = [1]\n'
                      "nonlinear = { vs = 0.2 }\n"),
    "payload": _toml("payload", _ELBOW, "[payload]\njoint = 2\n"),
}  # fmt: skip


def _parameters(robot: Any, path: Path) -> Path:
    """Write parameters of solid links, the same for every link but for its distance."""
    import symgen

    base = symgen.derive(robot).base
    lines = [f"{p.name} = {_BODY.get(p.prefix, 0.5)}" for p in base.standard]
    path.write_text("[parameters]\n" + "\n".join(lines) + "\n")
    return path


for _name, _text in _ROBOTS.items():

    @case(f"robot-{_name}")
    def _(folder: Path, run: Run, text: str = _text) -> None:
        import symgen

        (folder / "robot.toml").write_text(text)
        given = _parameters(symgen.read_robot(folder / "robot.toml"), folder / "p.toml")
        for seed, log in enumerate(("train", "test")):
            run("simulate", folder / "robot.toml", "--parameters", given, "--duration", 8,
                "--rate", 250, "--encoder", 1e-5, "--torque-noise-percent", 1, "--seed", seed,
                "--into", folder / f"{log}.csv")  # fmt: skip
        run("identify", folder / "robot.toml", folder / "train.csv", "--validation",
            folder / "test.csv", "--into", folder / "fit")  # fmt: skip


for _name in LIBRARY:

    @case(f"package-{_name}")
    def _(folder: Path, run: Run, name: str = _name) -> None:
        target = ("--target", "all") if name == "planar2r" else ()
        run("generate", name, *target, "--into", folder / name)
        run("check", folder / name)


# The other verbs.


def _planar_log(folder: Path, seed: int, friction: float = 0.0, mass: float = 0.0) -> Path:
    rng = np.random.default_rng(seed)
    t, q, qd, qdd = planar2r.harmonic_motion(rng, seed)
    X = np.array([3.5 + 0.25 * mass, 0.4 + 0.09 * mass, 0.3 + 0.3 * mass, 0.05])
    tau = planar2r.inverse_dynamics(q, qd, qdd, X, 0.5) + friction * np.sign(qd)
    tau += 0.01 * tau.std(axis=0) * rng.normal(size=tau.shape)
    path = folder / f"log{seed}-{mass}.npz"
    np.savez(path, t=t, q=q, qd=qd, tau=tau)
    return path


@case("drive")
def _(folder: Path, run: Run) -> None:
    z = np.load(_planar_log(folder, 3))
    ratio, constant = np.array([100.0, 80.0]), np.array([0.11, 0.09])
    (folder / "robot.toml").write_text(
        '[robot]\nname = "geared"\nconvention = "modified-dh"\ngravity = [0.0, 0.0, -9.81]\n'
        "[[joint]]\n[[joint]]\nd = 0.5\n[drive]\nratio = [100.0, 80.0]\n"
        "torque_constant = [0.11, 0.09]\n"
    )
    q, i = z["q"] * ratio, z["tau"] / ratio / constant
    rows = np.column_stack([z["t"], q, z["qd"] * ratio, i])
    head = "t,q1,q2,qd1,qd2,i1,i2"
    np.savetxt(folder / "log.csv", rows, delimiter=",", header=head, comments="")
    run("identify", folder / "robot.toml", folder / "log.csv", "--into", folder / "fit")


@case("loop")
def _(folder: Path, run: Run) -> None:
    import symgen

    given = _parameters(symgen.read_robot("sr400"), folder / "p.toml")
    run("simulate", "sr400", "--parameters", given, "--duration", 6, "--rate", 200, "--into",
        folder / "a.csv")  # fmt: skip
    run("identify", "sr400", folder / "a.csv", "--into", folder / "fit")


_PLANAR = "[parameters]\nZZ1R = 3.5\nZZ2 = 0.4\nMX2 = 0.3\nMY2 = 0.05\n"


@case("payload")
def _(folder: Path, run: Run) -> None:
    (folder / "p.toml").write_text(_PLANAR)
    empty, full = _planar_log(folder, 1), _planar_log(folder, 2, mass=2.0)
    run("payload", "planar2r", full, "--parameters", folder / "p.toml", "--into", folder / "a")
    run("payload", "planar2r", full, "--without", empty, "--into", folder / "b")
    run("payload", "planar2r", full, "--without", empty, "--mass", 2.0, "--into", folder / "c")


@case("static")
def _(folder: Path, run: Run) -> None:
    from oracles.still_poses import gravity_torque

    made = clean_runs.run(904, arms=("elbow3r",), effects=False)
    (folder / "robot.toml").write_text(made.robot_toml, "utf-8")
    rng = np.random.default_rng(4)
    q = rng.uniform(-1.5, 1.5, (60, 3))
    links = np.tile([0.3, 0, 0, 0.3, 0, 0.3, 0.4, 0.1, -0.2, 3.0], (3, 1))
    tau = gravity_torque(clean_runs.ARMS["elbow3r"], links, q) + 0.02 * rng.normal(size=q.shape)
    rows = np.column_stack([np.arange(60.0), q, tau])
    head = "t,q1,q2,q3,tau1,tau2,tau3"
    np.savetxt(folder / "poses.csv", rows, delimiter=",", header=head, comments="")
    run("identify", folder / "robot.toml", folder / "poses.csv", "--model", "static", "--into",
        folder / "fit")  # fmt: skip


@case("study")
def _(folder: Path, run: Run) -> None:
    (folder / "p.toml").write_text(_PLANAR)
    run("study", "planar2r", "--parameters", folder / "p.toml", "--runs", 8, "--duration", 6,
        "--encoder", 1e-4, "--torque-noise", 0.05, "--rate", 200, "--into", folder / "study",
        )  # fmt: skip


@case("fleet")
def _(folder: Path, run: Run) -> None:
    (folder / "logs").mkdir()
    for robot in (1, 2, 3):
        for day in range(1, 6):
            log = _planar_log(folder, 10 * robot + day, mass=1.0 if robot == 2 and day > 2 else 0.0)
            log.rename(folder / "logs" / f"r{robot}_2026-01-0{day}.npz")
    run("fleet", "planar2r", folder / "logs", "--cutoff", 10, "--into", folder / "fleet")


@case("excite")
def _(folder: Path, run: Run) -> None:
    run("excite", "planar2r", "--position", 1, "--velocity", 2, "--acceleration", 8, "--duration",
        10, "--searches", 2, "--iterations", 30, "--budget", 600, "--into", folder / "run.csv",
        )  # fmt: skip


@case("simulate")
def _(folder: Path, run: Run) -> None:
    (folder / "p.toml").write_text(_PLANAR)
    common = ("planar2r", "--parameters", folder / "p.toml", "--duration", 4)
    run("simulate", *common, "--into", folder / "a.csv")
    run("simulate", *common, "--controller", "pd", "--feedback", "measured", "--rate", 200,
        "--into", folder / "b.csv")  # fmt: skip


@case("export")
def _(folder: Path, run: Run) -> None:
    from oracles import gripper_arm

    (folder / "panda.urdf").write_text(gripper_arm.urdf())
    (folder / "train.csv").write_text(gripper_arm.recorded(gripper_arm.urdf(1.15), 1))
    run("identify", folder / "panda.urdf", folder / "train.csv", "--into", folder / "no")
    run("import", folder / "panda.urdf", "--fix", "panda_finger_joint1", "--into",
        folder / "robot.toml")  # fmt: skip
    run("identify", folder / "robot.toml", folder / "train.csv", "--into", folder / "fit")
    run("export", folder / "fit", "--from", folder / "panda.urdf", "--to", folder / "new.urdf")


@case("words")
def _(_folder: Path, run: Run) -> None:
    run("robots")
    run("explain", "gravity_spring")
    run("explain", "no_such_effect")


# Running, keeping, comparing.


def _flat(value: Any, at: str = "") -> Iterator[tuple[str, Any]]:
    """Leaves of a JSON by their path; names that LEFT_OUT knows are passed over."""
    if LEFT_OUT.search(at):
        return
    if isinstance(value, dict):
        for key in sorted(value):
            yield from _flat(value[key], f"{at}/{key}")
    elif isinstance(value, list):
        yield f"{at}/#", len(value)
        for k, each in enumerate(value):
            yield from _flat(each, f"{at}/{k}")
    else:
        yield at, float(f"{value:.12g}") if isinstance(value, float) else value


def _numbers_of(path: Path) -> dict[str, float]:
    """Moments of the columns of a CSV or URDF: shape, mean and root mean square."""
    if path.suffix == ".csv":
        x = np.genfromtxt(path, delimiter=",", names=True)
        columns = {n: x[n] for n in x.dtype.names or ()}
    else:
        text = path.read_text("utf-8")
        found = re.findall(r'(?<=[" ])-?\d+\.?\d*(?:e-?\d+)?(?=[" ])', text)
        columns = {"numbers": np.array(found, float)}
    moments = {"size": np.size, "mean": np.mean, "square": lambda x: np.mean(x**2)}
    return {
        f"{name}/{what}": float(f"{of(column):.10g}")
        for name, column in columns.items()
        for what, of in moments.items()
    }


def answers(name: str) -> dict[str, Any]:
    """Run a case in a folder of its own; return what it answers, by command and file."""
    from symgen import cli

    answered: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)

        def run(*words: Any) -> None:
            arguments = ["symgen", *map(str, words)]
            out, err = io.StringIO(), io.StringIO()
            before, sys.argv = sys.argv, arguments
            code: Any = 0
            try:
                with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
                    cli.main()
            except SystemExit as end:
                code = end.code
            finally:
                sys.argv = before
            tell = shlex.join(arguments).replace(place, "F").replace(str(DATA), "DATA")
            answered[tell] = {"code": code}
            if code == 2:
                # The kind of a refusal: the file, key or column that it names, not its sentence.
                found = re.findall(r"[\w.-]+\.(?:csv|toml|npz|urdf)\b", err.getvalue())
                answered[tell]["names"] = sorted(set(found))

        CASES[name](folder, run)
        for path in sorted(folder.rglob("*")):
            at = path.relative_to(folder).as_posix()
            if path.name == "manifest.json":
                answered[at] = hashlib.sha256(path.read_bytes()).hexdigest()[:16]
            elif path.suffix == ".json":
                answered[at] = dict(_flat(json.loads(path.read_text("utf-8"))))
            elif path.suffix in (".c", ".h", ".inc") and not path.stem.endswith("_values"):
                answered[at] = hashlib.sha256(path.read_bytes()).hexdigest()[:16]
            elif path.name in ("a.csv", "b.csv", "run.csv", "new.urdf"):
                answered[at] = _numbers_of(path)
    return answered


def _same(at: str, a: Any, b: Any) -> bool:
    if isinstance(a, bool) or isinstance(b, bool) or not isinstance(a, int | float):
        return bool(a == b)
    if not isinstance(b, int | float):
        return False
    # A name is the last word of the path that is no index.
    last = next((part for part in reversed(at.split("/")) if not part.isdigit()), at)
    tolerance = next(t for pattern, t in TOLERANCES if re.search(pattern, last))
    return a == b or abs(a - b) <= tolerance * max(abs(a), abs(b)) + 1e-12


#: Sentences may be said better; which fields have one may not change.
_SENTENCES = re.compile(r"/(reason|reasons|headline|notes|note|done|std_excludes|method)(/|$)")


def differences(was: dict[str, Any], now: dict[str, Any]) -> list[str]:
    """What differs between two sets of answers, a line each."""
    out = []
    for key in sorted({*was, *now}):
        if key not in now or key not in was:
            out.append(f"{key}: {'gone' if key not in now else 'new'}")
            continue
        a, b = was[key], now[key]
        if not isinstance(a, dict) or not isinstance(b, dict):
            out += [] if a == b else [f"{key}: {a} -> {b}"]
            continue
        for at in sorted({*a, *b}):
            if _SENTENCES.search(at):
                continue
            if at not in a or at not in b or not _same(at, a[at], b[at]):
                out.append(f"{key} {at}: {a.get(at, 'absent')} -> {b.get(at, 'absent')}")
    return out


@cache
def kept() -> dict[str, Any]:
    """Return the kept answers, by case."""
    return dict(json.loads(gzip.decompress(KEPT.read_bytes()))) if KEPT.exists() else {}


def main() -> int:
    """Keep or compare."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=("keep", "compare", "list"))
    parser.add_argument("cases", nargs="*", help="names, or beginnings of names; default all")
    chosen = parser.parse_args()
    names = [n for n in CASES if not chosen.cases or n.startswith(tuple(chosen.cases))]
    if chosen.what == "list":
        print("\n".join(names))
        return 0
    known = kept()
    different = 0
    for name in names:
        start = time.perf_counter()
        now = answers(name)
        took = f"{time.perf_counter() - start:.1f} s"
        if chosen.what == "keep":
            known[name] = now
            print(f"{name}: kept, {took}", flush=True)
            continue
        lines = differences(known.get(name, {}), json.loads(json.dumps(now)))
        different += bool(lines)
        print(f"{name}: {'same' if not lines else f'{len(lines)} differ'}, {took}", flush=True)
        for line in lines[:20]:
            print(f"    {line}", flush=True)
    if chosen.what == "keep":
        text = json.dumps(known, sort_keys=True)
        KEPT.write_bytes(gzip.compress(text.encode(), mtime=0))
    return int(different > 0)


if __name__ == "__main__":
    raise SystemExit(main())

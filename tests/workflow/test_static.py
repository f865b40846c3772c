"""identify --model static: still poses give gravity, springs and friction bounds.

Torques come from the potential energy of plain 4x4 transforms, with friction drawn within its
bound (`oracles.still_poses`).
"""

from __future__ import annotations

import json
import math
from statistics import NormalDist

import numpy as np
import pytest
from oracles.random_arms import to_toml
from oracles.still_poses import gravity_torque, held
from oracles.transforms import Arm
from support import sampled

import symgen

N = 6
ARM = Arm.from_table(
    {
        "sigma": [0] * N,
        "alpha": [0, -math.pi / 2, 0, -math.pi / 2, math.pi / 2, -math.pi / 2],
        "d": [0, 0, 0.43, 0, 0, 0],
        "r": [0, 0.2, 0, 0.43, 0, 0],
    }
)
#: XX XY XZ YY YZ ZZ MX MY MZ M: standstill sees the last four.
LINKS = np.array(
    [[0] * 6 + [m * x for x in c] + [m] for m, c in (
        (12, (0, 0, -0.1)), (10, (0.2, 0, 0.05)), (6, (0.02, -0.05, 0)),
        (3, (0, 0.01, -0.05)), (1.5, (0, -0.02, 0)), (0.6, (0.002, 0, 0.03)),
    )]
)  # fmt: skip
BOUND = np.array([4, 5, 3, 1, 0.8, 0.6])  # N m


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    path = tmp_path_factory.mktemp("static") / "robot.toml"
    path.write_text(to_toml(ARM, "arm", ("coulomb", "viscous"), False))
    return path


@pytest.fixture(scope="module")
def evaluator(robot):
    return symgen.load(symgen.derive(robot, ("torque_regressor", "inverse_dynamics")))


def poses(seed: int, count: int = 40, told: bool = True, least: float = 0.0):
    """q, direction of the last motion, tau: every pose twice, from both sides, where it is told."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(-2.5, 2.5, (count, N))
    direction = np.zeros((count, N))
    if told:
        q[1::2] = q[::2]
        direction = rng.choice([-1.0, 1.0], (count, N))
        direction[1::2] = -direction[::2]
    return q, direction, gravity_torque(ARM, LINKS, q) + held(rng, BOUND, direction, least)


def table(seed: int, **options):
    q, direction, tau = poses(seed, **options)
    return symgen.make_log(f"poses {seed}", np.arange(len(q)), q, tau, direction)


def truth(evaluator, names) -> dict[str, float]:
    """What standstill shows: least squares of the oracle without friction, and its bound."""
    q = np.random.default_rng(9).uniform(-2.5, 2.5, (300, N))
    W = evaluator["torque_regressor"](q, 0 * q, 0 * q).reshape(300 * N, -1)
    own = [n for n in names if not n.startswith("FS")]
    at = [evaluator.model.base.names.index(n) for n in own]
    X = np.linalg.lstsq(W[:, at], gravity_torque(ARM, LINKS, q).ravel(), rcond=None)[0]
    return dict(zip(own, X, strict=True)) | {f"FS{j}": b for j, b in enumerate(BOUND, 1)}


WAYS = {
    "approached from both sides": {},
    "stopped near the bound": {"least": 0.7},
    "no direction told": {"told": False},
}


@pytest.mark.parametrize("way", sampled(WAYS, 2))
def test_intervals_hold_the_truth(evaluator, way) -> None:
    """Values and friction bounds together, beside the chance of one in 1000 at 95 %."""
    runs, inside, wrong, trusted = 8, 0, 0.0, 0
    for k in range(runs):
        found = symgen.identify(evaluator, table(100 + k, **WAYS[way]), model="static")
        shown = {p.name: p for p in found.parameters if math.isfinite(p.std)}
        true = truth(evaluator, shown)
        z = np.array([(p.value - true[name]) / p.std for name, p in shown.items()])
        assert len(z) == 10 + N
        inside += int(np.sum(np.abs(z) < 1.96))
        wrong = max(wrong, float(np.abs(z).max()))
        trusted += found.verdict == "trusted"
    total = runs * (10 + N)
    # Parameters of one run are correlated: a run counts as a quarter of its parameters.
    spread = NormalDist().inv_cdf(0.999) * math.sqrt(0.05 * 0.95 / (total / 4))
    assert inside / total > 0.95 - spread, inside / total
    assert wrong < 5
    assert trusted >= runs - 1


def test_one_sided_friction_does_not_move_gravity(evaluator) -> None:
    """What was approached from one side alone is unbiased where the direction is told."""
    q, direction, tau = poses(7, count=60)
    one = np.abs(direction)
    rng = np.random.default_rng(8)
    tau = gravity_torque(ARM, LINKS, q) + held(rng, BOUND, one, 0.5)
    stamps = np.arange(len(q))
    blind = symgen.identify(evaluator, symgen.make_log("p", stamps, q, tau), model="static")
    told = symgen.identify(evaluator, symgen.make_log("p", stamps, q, tau, one), model="static")
    true = truth(evaluator, [p.name for p in told.parameters if math.isfinite(p.std)])
    place = {p.name: k for k, p in enumerate(told.parameters)}

    def worst(found) -> float:
        errors = [abs(found.parameters[place[n]].value - x) for n, x in true.items()
                  if not n.startswith("FS")]  # fmt: skip
        return max(errors)

    assert worst(told) < 0.6 * worst(blind)
    for j, b in enumerate(BOUND, 1):
        p = told.parameters[place[f"FS{j}"]]
        assert abs(p.value - b) < 4 * p.std < 0.5 * b


def test_a_sign_that_is_the_other_way_is_told(evaluator) -> None:
    q, direction, tau = poses(11, count=60, least=0.5)
    log = symgen.make_log("turned", np.arange(60), q, tau, -direction)
    found = symgen.identify(evaluator, log, model="static")
    assert found.verdict == "doubtful"
    assert any("friction helps the last motion" in reason for reason in found.reasons)


def test_what_standstill_does_not_show_has_no_std(evaluator) -> None:
    found = symgen.identify(evaluator, table(21), model="static")
    names = evaluator.model.base.names
    assert tuple(p.name for p in found.parameters) == names
    hidden = {p.name for p in found.parameters if not math.isfinite(p.std)}
    assert hidden
    for name in hidden:  # no inertia and no viscous friction makes a torque at rest
        assert name.rstrip("0123456789R") in {"XX", "XY", "XZ", "YY", "YZ", "ZZ", "FV"}, name
    assert not found.uses[2].ok
    assert hidden.isdisjoint(found.uses[1].known)
    content = found.to_json()
    stored = {p["name"]: p["std"] for p in content["parameters"]}
    assert all(stored[name] is None for name in hidden)


def test_a_spring_is_identified_as_a_column(tmp_path) -> None:
    path = tmp_path / "sprung.toml"
    text = to_toml(ARM, "sprung", ("coulomb", "viscous"), False)
    path.write_text(text + '\n[[effect]]\nname = "gravity_spring"\njoints = [2]\n')
    q, direction, tau = poses(31, count=80)
    tau[:, 1] -= -25.0 * (q[:, 1] - 0.3)  # the drive holds against the spring
    log = symgen.make_log("sprung", np.arange(80), q, tau, direction)
    found = symgen.identify(path, log, model="static")
    spring = next(p for p in found.parameters if p.name.startswith("K"))
    assert abs(spring.value - 25.0) < 3 * spring.std < 12
    plain = symgen.identify(_plain(tmp_path), log, model="static")
    assert plain.validation.relative > 1.5 * found.validation.relative


def _plain(folder):
    path = folder / "plain.toml"
    path.write_text(to_toml(ARM, "plain", ("coulomb", "viscous"), False))
    return path


def test_the_command_takes_a_table_without_time(robot, tmp_path, command) -> None:
    q, direction, tau = poses(41)
    names = [f"{role}{j}" for role in ("q", "qd", "tau") for j in range(1, N + 1)]
    rows = np.column_stack([q, direction, tau])
    np.savetxt(tmp_path / "poses.csv", rows, delimiter=",", header=",".join(names), comments="")
    into = tmp_path / "out"
    asked = ["identify", robot, tmp_path / "poses.csv", "--model", "static", "--into", into]
    code, out, err = command(*asked)
    assert code == 0, err
    assert "trusted" in out
    content = json.loads((into / "estimate.json").read_text())
    assert content["schema"] == "symgen.estimate/2"
    assert content["model"] == "static"
    page = (into / "report.html").read_text()
    assert "NaN" not in page.split("<script")[0]
    code, again, err = command("report", into)
    assert code == 0, err
    assert again.splitlines() == out.splitlines()[:-1]  # but for what was written
    code, _, err = command("identify", robot, tmp_path / "poses.csv", "--into", tmp_path / "no")
    assert code == 2
    assert "no column t" in err


REFUSED = {
    "too few": (lambda: table(1, count=10), {}, "too few"),
    "another method": (lambda: table(1), {"method": "tls"}, "accepted: wls, ols, huber"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_poses_cannot_do_is_refused(evaluator, case) -> None:
    log, options, says = REFUSED[case]
    with pytest.raises(symgen.SymgenError, match=says):
        symgen.identify(evaluator, log(), model="static", **options)

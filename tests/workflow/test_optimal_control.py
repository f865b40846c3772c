"""The example of optimal control in a package: it converges, and its torques reach the goal."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Callable

import numpy as np
import pytest

import symgen

KERNELS = ("inverse_dynamics", "inverse_dynamics_derivatives", "mass_matrix")
Run = Callable[..., tuple[np.ndarray, np.ndarray, list[tuple[int, float]]]]


@pytest.fixture(scope="module")
def solved(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Run a robot's example; return X, the torques, and iterations and effort of both solutions."""
    root = tmp_path_factory.mktemp("optimal")

    def run(name: str, limit: float = 150.0, *options: str) -> tuple[np.ndarray, np.ndarray, list]:
        package = root / name
        if not package.is_dir():
            model = symgen.derive(symgen.read_robot(name), KERNELS)
            symgen.write_package(symgen.generate(model, target="casadi"), package)
        text = (package / "example" / f"{name}_optimal_control.py").read_text()
        (package / "example" / "mine.py").write_text(
            text.replace("LIMIT = 150.0", f"LIMIT = {limit}")
        )
        command = [sys.executable, "-W", "error", "example/mine.py", "torques.csv", *options]
        done = subprocess.run(command, cwd=package, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
        X = np.array(re.findall(r"-?\d+\.\d+", text[text.index("X = [") : text.index("]")]), float)
        found = re.findall(r"start: (\d+) iterations, effort (\S+),", done.stdout)
        torques = np.loadtxt(package / "torques.csv", delimiter=",")
        return X, torques, [(int(count), float(effort)) for count, effort in found]

    return run


def played(name: str, X: np.ndarray, torques: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where our simulation ends when these torques are held in turn for 1 s."""
    n = torques.shape[1]
    t = np.linspace(0, 1, 20 * 20 + 1)
    tau = np.repeat(torques, 20, axis=0)
    tau = np.vstack([tau, tau[-1]])
    log = symgen.make_log("torques", t, np.zeros_like(tau), tau)
    rest = (np.zeros(n), np.zeros(n))
    done = symgen.simulate(name, X, torque=log, hold=True, initial=rest)
    return done.q[0, -1], done.qd[0, -1]


def goal(n: int) -> np.ndarray:
    """The second goal of the example."""
    return 0.6 * (-1.0) ** np.arange(n) + 0.05


def effort_of_smooth_motion(name: str, X: np.ndarray) -> float:
    """The effort of the polynomial of fifth degree between the same ends."""
    model = symgen.derive(symgen.read_robot(name), ("inverse_dynamics",))
    s = np.linspace(0, 1, 2001)[:, None]
    q, qd, qdd = (
        goal(model.robot.n) * polynomial
        for polynomial in (
            s**3 * (10 - 15 * s + 6 * s**2),
            30 * s**2 * (1 - s) ** 2,
            60 * s * (1 - s) * (1 - 2 * s),
        )
    )
    tau = symgen.load(model)["inverse_dynamics"](q, qd, qdd, X)
    return float(np.trapezoid((tau**2).sum(1), s[:, 0]))


@pytest.mark.parametrize("name", ["planar2r", "panda"])
def test_it_converges_starts_warm_and_reaches_the_goal(name: str, solved: Run) -> None:
    X, torques, (cold, warm) = solved(name)
    n = torques.shape[1]
    assert len(X) == len(symgen.derive(symgen.read_robot(name)).base.parameters)
    assert warm[0] < cold[0] < 50
    assert (torques**2).sum() / 20 == pytest.approx(warm[1], rel=1e-4)
    q, qd = played(name, X, torques)
    assert np.abs(q - goal(n)).max() < 1e-4
    assert np.abs(qd).max() < 1e-3
    smooth = effort_of_smooth_motion(name, X)
    assert 0.2 * smooth < warm[1] < 0.97 * smooth


def test_a_limit_binds_and_costs(solved: Run) -> None:
    X, free, (_, (_, effort)) = solved("planar2r")
    limit = round(0.75 * float(np.abs(free).max()), 3)
    X, torques, (_, (_, more)) = solved("planar2r", limit)
    assert np.abs(torques).max() == pytest.approx(limit, rel=1e-3)
    assert more > effort * 1.001
    q, _ = played("planar2r", X, torques)
    assert np.abs(q - goal(2)).max() < 1e-4


def test_derivatives_of_the_package_and_ad_find_the_same_motions(solved: Run) -> None:
    _, ours, found = solved("planar2r", 150.0, "--derivatives", "package")
    _, ad, same = solved("planar2r", 150.0, "--derivatives", "ad")
    assert [effort for _, effort in found] == pytest.approx([e for _, e in same], rel=1e-5)
    assert ours == pytest.approx(ad, abs=1e-6 * np.abs(ad).max())
    assert [count for count, _ in found] == [count for count, _ in same]


def test_it_says_so_when_nothing_reaches_the_goal(solved: Run) -> None:
    with pytest.raises(AssertionError, match="failed: Infeasible"):
        solved("planar2r", 0.01)


def test_it_is_there_where_it_can_work() -> None:
    path = "example/planar2r_optimal_control.py"
    model = symgen.derive(symgen.read_robot("planar2r"), KERNELS)
    assert path in symgen.generate(model).files
    assert path not in symgen.generate(model, target="c").files
    assert path not in symgen.generate(model, kernels=("inverse_dynamics", "mass_matrix")).files

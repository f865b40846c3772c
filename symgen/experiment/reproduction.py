"""The paper again: the example of Gautier and Khalil (1988), simulated and identified many times.

The canonical model is derived and compiled, the noisy measurements of the paper's two set-ups are
simulated, and every run is identified recursively.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.codegen.model import Model, derive
from symgen.data.log import make_log
from symgen.data.signals import sampled
from symgen.errors import IdentificationError
from symgen.estimation.batch import solve
from symgen.estimation.filtered import unfiltered
from symgen.estimation.system import LinearSystem, energy_equations
from symgen.experiment import paper
from symgen.identification.online.identifier import Identifier
from symgen.identification.workflow import identify
from symgen.robot.toml_io import read_robot
from symgen.runtime.evaluator import Evaluator, load

FloatArray = NDArray[np.float64]
#: Names of the files that are written.
MARKER, PAGE = "demo.json", "demo.html"
_SEED = 1988
# Runs whose way to the result is followed, sample by sample.
_FOLLOWED = 200


@dataclass(frozen=True, eq=False)
class Setup:
    """One of the paper's set-ups.

    Attributes:
        letter: a or b.
        words: how the measurements came about.
        runs: the simulated ones.
        history: estimates after every sample of the first runs, (F, N, 4).
        final: estimates of all runs, (R, 4).
    """

    letter: str
    words: str
    runs: paper.Runs
    history: FloatArray
    final: FloatArray

    def summary(self) -> dict[str, Any]:
        """Return for each parameter its errors beside the paper's, for demo.json."""
        final = self.final
        error = np.abs(final / paper.X_TRUE - 1)
        return {
            name: {
                "true": float(paper.X_TRUE[i]),
                "mean": float(final[:, i].mean()),
                "paper_relative_error": float(paper.PAPER_ERRORS[i]),
                "relative_error_quantiles": {
                    str(level): float(np.quantile(error[:, i], level))
                    for level in (0.05, 0.5, 0.95)
                },
                "share_below_paper": float(np.mean(error[:, i] < paper.PAPER_ERRORS[i])),
            }
            for i, name in enumerate(paper.NAMES)
        }

    def log(self, k: int) -> bytes:
        """Return one run as a log that `symgen identify planar2r` reads."""
        rows = np.column_stack([self.runs.t, self.runs.q[k], self.runs.qd[k], self.runs.tau[k]])
        lines = ["t,q1,q2,qd1,qd2,tau1,tau2", *(",".join(f"{v:.9g}" for v in row) for row in rows)]
        return ("\n".join(lines) + "\n").encode()


@dataclass(frozen=True, eq=False)
class Reproduction:
    """What became of the paper's example.

    Attributes:
        model: the canonical one.
        backend: that evaluated it.
        count: runs of each set-up.
        exact: largest relative errors without noise, by spline integrals and on line.
        setups: a and b.
        refused: why joint speeds proportional to each other are refused, without and with noise;
            empty where they are not.
    """

    model: Model
    backend: str
    count: int
    exact: tuple[float, float]
    setups: tuple[Setup, ...]
    refused: tuple[str, str]

    def files(self) -> dict[str, bytes]:
        """Return demo.json, and two runs of each set-up as logs."""
        summary = {"schema": "symgen.demo/1", "runs": self.count, "seed": _SEED}
        told = summary | {s.letter: s.summary() for s in self.setups}
        logs = {f"setup_{s.letter}_{k + 1}.csv": s.log(k) for s in self.setups for k in range(2)}
        return {MARKER: (json.dumps(told, indent=1) + "\n").encode(), **logs}


def reproduce(runs: int, say: Callable[[str], None]) -> Reproduction:
    """Derive, simulate and identify the paper's example.

    Args:
        runs: seeded runs of each set-up.
        say: is told what is being done.

    Raises:
        BuildError: there is no C compiler.
    """
    model = derive(read_robot("planar2r"))
    say("compiling the model")
    evaluator, simulated = load(model, backend="c"), paper.dynamics(model.robot)
    setups = []
    for letter, words, simulate in (
        ("a", "the robot follows the reference, the measurements are noisy", paper.setup_a),
        (
            "b",
            f"torques computed from X_d = {paper.WRONG:g} X, noise of "
            f"{100 * paper.TORQUE_NOISE:g} % of RMS torque, drive a simulated robot",
            paper.setup_b,
        ),
    ):
        say(f"({letter}) {runs} seeded runs of this set-up")
        measured = simulate(simulated, runs, _SEED)
        followed = min(runs, _FOLLOWED)
        history = np.array([_recursive(evaluator, measured, k) for k in range(followed)])
        final = [*history[:, -1], *(_last(evaluator, measured, k) for k in range(followed, runs))]
        setups.append(Setup(letter, words, measured, history, np.array(final)))
    still, shaken = (paper.proportional_run(simulated, noise) for noise in (None, 1))
    return Reproduction(
        model,
        evaluator.backend,
        runs,
        _returned(evaluator, paper.exact_run(simulated)),
        tuple(setups),
        (_refused(evaluator, still), _refused(evaluator, shaken)),
    )


def _recursive(evaluator: Evaluator, runs: paper.Runs, k: int) -> FloatArray:
    """Return the estimate after each sample of run k, (N, 4); NaN while it is undetermined."""
    identifier = Identifier(evaluator, mode="start")
    out = np.full((len(runs.t), len(paper.X_TRUE)), np.nan)
    for i, t in enumerate(runs.t):
        identifier.step(runs.q[k, i], runs.qd[k, i], runs.tau[k, i], float(t))
        if i >= 5:
            try:
                out[i] = identifier.read()[0]
            except IdentificationError:
                continue
    return out


def _last(evaluator: Evaluator, runs: paper.Runs, k: int) -> FloatArray:
    """Return the recursive estimate after all samples of run k, (4,)."""
    identifier = Identifier(evaluator, mode="start")
    identifier.run(runs.t, runs.q[k], runs.qd[k], runs.tau[k])
    return identifier.read()[0]


def _returned(evaluator: Evaluator, exact: paper.Runs) -> tuple[float, float]:
    """Return the largest relative errors without noise: spline integrals, and on line."""
    log = make_log("exact", exact.t, exact.q[0], exact.tau[0], exact.qd[0])
    equations = energy_equations(evaluator, unfiltered(sampled(log)), 10 * paper.STEP)
    spline = solve(LinearSystem(evaluator.model.base.names, (equations,))).X
    online = _recursive(evaluator, exact, 0)[-1]
    return _worst(spline), _worst(online)


def _worst(X: FloatArray) -> float:
    return float(np.abs(X / paper.X_TRUE - 1).max())


def _refused(evaluator: Evaluator, runs: paper.Runs) -> str:
    """Return why a run is refused; empty where it is not."""
    log = make_log("proportional", runs.t, runs.q[0], runs.tau[0], runs.qd[0])
    try:
        identify(evaluator, log, model="energy", window=10 * paper.STEP)
    except IdentificationError as error:
        return str(error)
    return ""

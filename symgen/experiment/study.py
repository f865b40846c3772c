"""study: accuracy of identified parameters for prescribed motions and sensors, by simulation.

Gautier and Khalil (1988) write that the bias of least squares is impossible to calculate, and ask
for a study "by simulation, for a given robot with given noise" (section 7). symgen simulates runs,
identifies them with each model and method, and compares them with the true values:

    bias = mean of X - X_true,    std = deviation of X over the runs
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from symgen.codegen.model import derive
from symgen.data.log import Log
from symgen.data.raw import FloatArray
from symgen.errors import IdentificationError, ParameterError
from symgen.estimation.band import Band
from symgen.estimation.equation_model import NEEDED, EquationModel, models_of, require_model
from symgen.estimation.estimators import Estimator
from symgen.estimation.torque_error import relative_error
from symgen.experiment.recording import Instruments, Recording
from symgen.experiment.reference import Reference, reference_of
from symgen.experiment.simulate import KERNELS, Parameters, Simulation, simulate, values_of
from symgen.identification.campaign import Campaign, Filtering
from symgen.identification.instruments import instrumented
from symgen.identification.known_band import open_in_known_band
from symgen.identification.possible import nearest_possible
from symgen.identification.solving import EquatedLog, Method, settle_load, solve_equations
from symgen.parallel import Meter, Say, silent
from symgen.robot.toml_io import read_robot
from symgen.robot.types import Robot, require_gravity
from symgen.runtime.evaluator import Evaluator, load
from symgen.schemas import Size, read_result, result_file, to_json
from symgen.views import Viewable

SCHEMA = "symgen.study/1"
MARKER = "study.json"
METHODS = ("ols", "wls", "iv")
_FEWEST = 3  # minimum number of runs
_HELD_HZ = 100.0
_HALF = 1.96  # half the 95 % interval of a normal distribution, in standard deviations


@dataclass(frozen=True)
class Precision:
    """Bias and standard deviation of a parameter.

    Attributes:
        name: name of the parameter.
        unit: unit of value, bias and standard deviations.
        value: true value.
        bias: mean of the estimates minus the true value.
        std: standard deviation of the estimates over the runs.
        stated_std: root mean square of the standard deviations in the estimates.
        coverage: share of the runs whose interval value +- 1.96 std contains the true value.
    """

    name: str
    unit: str
    value: float
    bias: float
    std: Size
    stated_std: Size
    coverage: Size


@dataclass(frozen=True)
class StudiedMethod:
    """The result of a model with a method.

    Attributes:
        model, method: names of model and method.
        band: filter band, chosen from the first run.
        failed: number of runs that did not determine the parameters.
        parameters: result of each parameter; empty if fewer than three runs have an estimate.
        torque_error: ||tau of X - tau|| / ||tau|| on a motion without noise that no run contains,
            root mean square over the runs; None without parameters.
        torque_error_per_joint: the same for each joint.
    """

    model: str
    method: str
    band: Band
    failed: int
    parameters: tuple[Precision, ...]
    torque_error: Size | None
    torque_error_per_joint: tuple[Size, ...]

    @property
    def name(self) -> str:
        """Name of model and method."""
        return f"{self.model} by {self.method}"

    @property
    def coverage(self) -> float:
        """Mean coverage of the parameters; NaN without any."""
        return float(np.mean([p.coverage for p in self.parameters] or [math.nan]))


@dataclass(frozen=True)
class Study(Viewable):
    """Bias and precision of estimates of a robot, by simulation.

    Attributes:
        robot: name of the robot.
        runs: number of runs of every model and method.
        seed: seed of all noise.
        trajectories: names of the motions.
        held_out: name of the motion on which the torque error is measured.
        window_s: window of energy and momentum.
        recording: instruments, controller, disturbance.
        results: results of models and methods, in the requested order.
    """

    robot: str
    runs: int
    seed: int
    trajectories: tuple[str, ...]
    held_out: str
    window_s: float
    recording: Recording
    results: tuple[StudiedMethod, ...]

    @property
    def best(self) -> StudiedMethod | None:
        """The model and method with the smallest torque error; None if none has a solution."""
        solved = [r for r in self.results if r.torque_error is not None]
        return min(solved, key=lambda r: r.torque_error or 0.0, default=None)

    def __repr__(self) -> str:
        """Return the robot, the runs, and the best model and method."""
        best = "none" if self.best is None else self.best.name
        return f"<Study of {self.robot}: {self.runs} runs, smallest torque error: {best}>"

    def to_json(self) -> dict[str, Any]:
        """Return the content of study.json."""
        return to_json(self, SCHEMA)


def read_study(path: str | Path) -> Study:
    """Read a study from its file.

    Args:
        path: the folder that `study` wrote, or the study.json in it.

    Raises:
        ParameterError: there is no study, or it is damaged.
    """
    return read_result(Study, result_file(path, MARKER), SCHEMA)


def study(
    robot: Robot | str | Path,
    parameters: Parameters,
    *,
    trajectories: Sequence[Reference | Log | str | Path] = (),
    held_out: Reference | Log | str | Path | None = None,
    recording: Recording | None = None,
    models: Sequence[str] = (),
    methods: Sequence[str | Estimator] = METHODS,
    window: float = 0.2,
    cutoff: float | None = None,
    duration: float = 20.0,
    runs: int = 100,
    seed: int = 0,
    progress: Say = silent,
    meter: Meter = silent,
) -> Study:
    """Simulate how accurately logs of prescribed motions and sensors determine the parameters.

    Args:
        robot: a robot, a path or a library name.
        parameters: true parameters: estimate.json, TOML with [parameters], names, or X (p,).
        trajectories: motions, one for each log, as in `simulate`; by default one seeded Fourier
            series within [limits].
        held_out: motion on which the torque error is measured; by default another such series.
        recording: instruments, controller, disturbance and rate.
        models: some of energy, momentum, torque; by default all.
        methods: estimators or their names. Method iv needs measured speeds.
        window: window of energy and momentum, s.
        cutoff: cutoff of the filter, Hz; by default chosen from the first run.
        duration: duration of the Fourier series, s.
        runs: number of runs.
        seed: seed of all noise, and of the Fourier series.
        progress: called with a text about the current step.
        meter: called with the finished part, from 0 to 1.

    Returns:
        Bias, standard deviation and stated standard deviation of every parameter, for every model
        and method.

    Raises:
        ParameterError: the parameters do not belong to this robot, or a number is out of range.
        IdentificationError: a model or method does not exist.
        LogError: a trajectory cannot be read, or has another number of joints.
    """
    if runs < _FEWEST or seed < 0:
        raise ParameterError(
            f"study: {runs} runs, seed {seed}; accepted: {_FEWEST} runs or more, seed 0 or more"
        )
    source = read_robot(robot)
    require_gravity(source, "a study")
    chosen = tuple(models) or models_of(source)
    for model in chosen:
        if model not in NEEDED:
            raise ParameterError(f"study: model {model!r}; accepted: {', '.join(NEEDED)}")
        require_model(source, model)
    ways = [(EquationModel(m, window), Method.of(method)) for m in chosen for method in methods]
    if not ways:
        raise ParameterError("study: no method; accepted: one or more, such as wls")
    progress("deriving and compiling the model")
    kernels = dict.fromkeys([*KERNELS, *(k for model, _ in ways for k in model.all_kernels)])
    evaluator = load(derive(source, tuple(kernels)))
    X = values_of(parameters, evaluator.model)
    made = recording or Recording()
    rate = made.rate or 1000.0
    aims = [
        reference_of(t, source, duration=duration, rate=rate, seed=seed)
        for t in trajectories or (None,)
    ]
    held = reference_of(held_out, source, duration=duration, rate=_HELD_HZ, seed=seed + 1)
    progress(f"identifying {runs} runs by {len(ways)} ways")
    bands: dict[bool, Band | None] = {method.name == "iv": None for _, method in ways}
    estimates: list[list[tuple[FloatArray, FloatArray] | None]] = [[] for _ in ways]
    for run, logs in enumerate(_recorded(evaluator, X, aims, made, runs, seed)):
        campaigns = _in_bands(evaluator, logs, cutoff, bands)
        bands = {iv: campaign.band for iv, campaign in campaigns.items()}
        for way, solutions in zip(ways, estimates, strict=True):
            solutions.append(_solved(campaigns[way[1].name == "iv"], *way))
        meter((run + 1) / runs)
    results = tuple(
        _result(evaluator, X, held, way, campaigns[way[1].name == "iv"].band, solutions)
        for way, solutions in zip(ways, estimates, strict=True)
    )
    names = tuple(aim.name for aim in aims)
    return Study(source.name, runs, seed, names, held.name, window, made, results)


def _recorded(
    evaluator: Evaluator,
    X: FloatArray,
    aims: Sequence[Reference],
    recording: Recording,
    runs: int,
    seed: int,
) -> Iterator[list[Log]]:
    """Yield the logs of each run, as recorded.

    A motion that all runs share is simulated once.
    """
    shared: list[Simulation] = []
    if recording.moves_alike:
        exact = replace(recording, instruments=Instruments())
        shared = [simulate(evaluator, X, trajectory=aim, recording=exact) for aim in aims]
    for run in range(runs):
        logs = []
        for k, aim in enumerate(aims):
            number = run * len(aims) + k
            only = range(number, number + 1)
            if shared:
                made = shared[k].recorded_by(recording.instruments, only, seed)
            else:
                made = simulate(
                    evaluator, X, trajectory=aim, recording=recording, runs=only, seed=seed
                )
            logs.append(made.log())
        yield logs


def _in_bands(
    evaluator: Evaluator,
    logs: Sequence[Log],
    cutoff: float | None,
    bands: Mapping[bool, Band | None],
) -> dict[bool, Campaign]:
    """Return the logs of a run, opened as `identify` does, for method iv (True) and the others.

    Args:
        evaluator: the compiled model.
        logs: the logs as recorded.
        cutoff: cutoff of the filter, Hz; None to choose it.
        bands: the bands of the first run; None to choose them.
    """
    first, *others = (Filtering(cutoff, iv, band) for iv, band in bands.items())
    opened = open_in_known_band(evaluator, None, logs, None, first)
    filtered = [opened, *(replace(opened, filtering=way).in_new_band() for way in others)]
    return dict(zip(bands, filtered, strict=True))


def _solved(
    campaign: Campaign, model: EquationModel, method: Method
) -> tuple[FloatArray, FloatArray] | None:
    """Return X and its standard deviations, (p,) each; None if the logs do not determine them."""
    evaluator, logs = campaign.evaluator, campaign.train
    if campaign.robot.loaded:
        model = settle_load(evaluator, logs, model)
    parts = [EquatedLog("train", log, model.equations(evaluator, log)) for log in logs]
    if method.name == "iv":
        parts = [instrumented(evaluator, part, model, None) for part in parts]
    with suppress(IdentificationError, np.linalg.LinAlgError):
        solution = solve_equations(parts, method, model)
        X = solution.X
        if method.is_bounded:
            X = nearest_possible(evaluator.model, X, solution.covariance).X
        return X, solution.std
    return None


def _result(
    evaluator: Evaluator,
    X: FloatArray,
    held_out: Reference,
    way: tuple[EquationModel, Method],
    band: Band,
    solutions: Sequence[tuple[FloatArray, FloatArray] | None],
) -> StudiedMethod:
    """Return the result of one model and method.

    Args:
        evaluator: the model.
        X: true parameters, (p,).
        held_out: the held-out motion.
        way: model and method.
        band: band of its logs.
        solutions: X and std of every run.
    """
    solved = [solution for solution in solutions if solution is not None]
    failed = len(solutions) - len(solved)
    model, method = way[0].name, way[1].label
    if len(solved) < _FEWEST:
        return StudiedMethod(model, method, band, failed, (), None, ())
    estimates, stated = np.stack(solved, axis=1)
    bias, std = estimates.mean(axis=0) - X, estimates.std(axis=0, ddof=1)
    rms = np.sqrt(np.mean(stated**2, axis=0))
    inside = np.mean(np.abs(estimates - X) <= _HALF * stated, axis=0)
    rows = np.column_stack([X, bias, std, rms, inside]).tolist()
    bases = zip(evaluator.model.base.parameters, rows, strict=True)
    parameters = tuple(Precision(p.name, p.unit, *row) for p, row in bases)
    motion = held_out.q, held_out.qd, held_out.qdd
    tau, error = evaluator.inverse_dynamics(*motion, X), np.zeros(held_out.q.shape[1])
    for x in estimates:
        error += np.sum((evaluator.inverse_dynamics(*motion, x) - tau) ** 2, axis=0) / len(solved)
    total = relative_error(error, np.sum(tau**2, axis=0), evaluator.model.robot.sigma)
    per_joint = total.per_joint or ()
    return StudiedMethod(model, method, band, failed, parameters, total.relative, per_joint)

"""study: accuracy of identified parameters for given motions and sensors, by simulation.

Gautier and Khalil (1988) write that the bias of least squares is impossible to calculate, and ask
for a study "by simulation, for a given robot with given noise" (section 7). symgen simulates runs,
identifies them with each model and method, and compares them with the true values:

    bias = mean of X - X_true,   std = deviation of X over the runs,   std(T) = std sqrt(T0 / T)

A parameter is within the target p after T = T0 std^2 / ((p X_true)^2 - bias^2), and never if the
bias alone is larger.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path

import numpy as np

from symgen.data.log import Log, make_log
from symgen.data.raw import FloatArray
from symgen.data.signals import Samples
from symgen.distributed import Meter, Say, Workers, executor, silent
from symgen.errors import IdentificationError, ParameterError
from symgen.estimation.band import Band
from symgen.estimation.chunks import packed_arrays, unpacked_arrays
from symgen.estimation.equation_model import NEEDED, EquationModel, require_model
from symgen.estimation.estimators import Estimator
from symgen.estimation.filtered_log import FilteredLog, filter_log
from symgen.experiment.recording import Instruments, Recording
from symgen.experiment.reference import Reference, reference_of
from symgen.experiment.simulate import Parameters, Simulation, simulate, values_of
from symgen.experiment.study_result import Precision, Settings, Study, Tried
from symgen.faults.logs import join_bands, open_logs
from symgen.identification.instruments import instrumented
from symgen.identification.model_choice import OpenLogs, Run, filter_in_band, undo_delay
from symgen.identification.out_of_core import load_model
from symgen.identification.solving import EquatedLog, Method, equate, settle_load, solve
from symgen.robot.toml_io import read_robot
from symgen.robot.toml_text import robot_toml
from symgen.robot.types import Robot, require_gravity
from symgen.runtime.evaluator import Evaluator
from symgen.runtime.plant import KERNELS

#: How many times the motions are recorded.
LENGTHS = (1, 2, 4)
#: Runs of a task: it is the same whoever works.
TOGETHER = 8


@dataclass(frozen=True, eq=False)
class Try:
    """A model with a method and its filter band."""

    model: EquationModel
    method: Method
    band: Band


@dataclass(frozen=True, eq=False)
class Trials:
    """The work of one task: simulate and identify some runs.

    Attributes:
        robot: text of robot.toml.
        kernels: necessary kernels.
        X: true parameters, (p,).
        aims: the references, one for each log; empty if they are not needed.
        recording: sensors and controller.
        seed: seed of all noise.
        moved: the motion along every reference, if all runs have the same; else empty.
        tries: models and methods.
        late: whether late torques are shifted, as `identify` does.
        held: q, qd, qdd (N, n) of a motion without noise, for the torque error.
    """

    robot: str
    kernels: tuple[str, ...]
    X: FloatArray
    aims: tuple[Reference, ...]
    recording: Recording
    seed: int
    moved: tuple[Simulation, ...] = ()
    tries: tuple[Try, ...] = ()
    late: bool = False
    held: tuple[FloatArray, ...] = ()

    @property
    def evaluator(self) -> Evaluator:
        """The model, compiled once in each process."""
        return load_model(self.robot, self.kernels)

    def samples(self, runs: range) -> Iterator[list[Samples]]:
        """Yield the logs of every run, read and repaired as `identify` does."""
        evaluator, r, count = self.evaluator, self.recording, len(self.moved or self.aims)
        made = []
        for k in range(count):
            numbers = range(runs.start * count + k, runs.stop * count, count)
            made.append(
                self.moved[k].seen_by(r.instruments, numbers, self.seed)
                if self.moved
                else simulate(
                    evaluator, self.X, trajectory=self.aims[k], recording=r, runs=numbers,
                    seed=self.seed,
                )
            )  # fmt: skip
        for run in range(len(runs)):
            logs = [done.log(run) for done in made]
            (opened,), _ = open_logs((logs,), evaluator.model.robot, None, silent)
            yield join_bands(opened, ())[0]

    def __call__(self, runs: range) -> bytes:
        """Return rows [X, std, squared error of torque] (tries, groups, 2 p + n) by size, as NPZ.

        A group is 1, 2 or 4 runs that are solved together. Groups without a solution are NaN.
        """
        evaluator = self.evaluator
        parts = [self._parts(evaluator, samples) for samples in self.samples(runs)]
        q, qd, qdd = self.held
        torque = evaluator.inverse_dynamics
        true = torque(q, qd, qdd, self.X)
        out: dict[str, FloatArray] = {}
        for size in LENGTHS:
            groups = range(0, len(runs) - size + 1, size)
            rows = np.full((len(self.tries), len(groups), 2 * len(self.X) + q.shape[1]), np.nan)
            for i, tried in enumerate(self.tries):
                for j, first in enumerate(groups):
                    group = [part for run in parts[first : first + size] for part in run[i]]
                    with suppress(IdentificationError, np.linalg.LinAlgError):
                        X, std = _solved(evaluator, group, tried)
                        error = np.sum((torque(q, qd, qdd, X) - true) ** 2, axis=0)
                        rows[i, j] = np.concatenate([X, std, error])
            out[str(size)] = rows
        return packed_arrays(out)

    def _parts(self, evaluator: Evaluator, samples: Sequence[Samples]) -> list[list[EquatedLog]]:
        """Return the logs of a run with their equations, for every try."""

        @cache
        def logs(band: Band) -> tuple[FilteredLog, ...]:
            run = Run(evaluator, band, tuple(filter_log(s, band) for s in samples))
            return (undo_delay(run) if self.late else run).train

        @cache
        def parts(model: EquationModel, band: Band, iv: bool) -> list[EquatedLog]:
            found = [equate(evaluator, log, model) for log in logs(band)]
            derived = band.velocity != "measured"
            return [
                instrumented(
                    evaluator, p, model, self._commanded(p.log.t, k) if derived else None
                ) if iv else p
                for k, p in enumerate(found)
            ]  # fmt: skip

        return [parts(t.model, t.band, t.method.name == "iv") for t in self.tries]

    def _commanded(self, t: FloatArray, log: int) -> Log:
        """Return the reference of a log at its stamps, as instruments if no speed is measured."""
        aim, sigma = self.aims[log].at(t), self.evaluator.model.robot.sigma
        ones = np.ones_like(aim[:, 0])
        made = make_log("reference", t, aim[:, 0], ones, aim[:, 1], sigma=sigma)
        return replace(made, mapped=True)


def _solved(
    evaluator: Evaluator, parts: Sequence[EquatedLog], tried: Try
) -> tuple[FloatArray, FloatArray]:
    """Return X and its standard deviations, as `identify` finds them from these logs."""
    model = tried.model
    if evaluator.model.robot.loaded:
        model = settle_load(evaluator, [part.log for part in parts], model)
        parts = [equate(evaluator, p.log, model) for p in parts]
    found = solve(evaluator, parts, tried.method, model)
    return found.X, found.std


METHODS = ("ols", "wls", "iv")
_FEWEST, _MOST = 8, 100_000  # runs
_HELD_HZ = 100.0
#: Standard errors from which a bias counts; and of a normal law, the half of a 95 % interval.
_COUNTS, _HALF = 3.0, 1.96
#: Part of the time that passes before the runs begin, about.
_BEFORE = 0.25
_FALLS = 3.0  # standard errors, of std at another length


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
    target: float = 0.02,
    seed: int = 0,
    workers: Workers | None = None,
    progress: Say = silent,
    meter: Meter = silent,
) -> Study:
    """Simulate how accurately logs of given motions and sensors determine the parameters.

    Args:
        robot: a robot, a path or a library name.
        parameters: true parameters: estimate.json, TOML with [parameters], names, or X (p,).
        trajectories: motions, one for each log, as in `simulate`; by default one seeded Fourier
            series within [limits].
        held_out: motion on which the torque error is measured; by default another such series.
        recording: instruments, controller, disturbance and rate.
        models: some of energy, momentum, torque; by default all.
        methods: estimators or their names. Method iv takes its instruments from the encoders if
            speeds are measured, and otherwise from the commanded motion.
        window: window of energy and momentum, s.
        cutoff: cutoff of the filter, Hz; by default chosen from the first run.
        duration: duration of the Fourier series, s.
        runs: number of runs.
        target: desired accuracy of a parameter, relative to its value.
        seed: seed of all noise, and of the Fourier series.
        workers: processes or scheduler that share the runs. The result does not depend on them.
        progress: called with a text about the current step.
        meter: called with the part that is done, from 0 to 1.

    Returns:
        Bias, standard deviation and stated standard deviation of every parameter, for every model
        and method.

    Raises:
        ParameterError: the parameters do not belong to this robot, or a number is out of range.
        IdentificationError: a model or method does not exist.
        LogError: a trajectory cannot be read, or has another number of joints.
    """
    if not (_FEWEST <= runs <= _MOST and 0 < target < 1 and seed >= 0):
        raise ParameterError(
            f"study: {runs} runs, target {100 * target:g} %, seed {seed}; accepted: {_FEWEST} to "
            f"{_MOST} runs, above 0 to below 100 %, seed 0 or more"
        )
    source = read_robot(robot)
    require_gravity(source, "a study")
    made = recording or Recording()
    chosen = tuple(models) or (("torque",) if source.loaded else tuple(NEEDED))
    for model in chosen:
        if model not in NEEDED:
            raise ParameterError(f"study: model {model!r}; accepted: {', '.join(NEEDED)}")
        require_model(source, model)
    ways = [(EquationModel(m, window), Method.of(method)) for m in chosen for method in methods]
    if not ways:
        raise ParameterError("study: no method; accepted: one or more, such as wls")
    progress("deriving and compiling the model")
    kernels = dict.fromkeys([*KERNELS, *(k for model, _ in ways for k in model.all_kernels)])
    text = robot_toml(source)
    evaluator = load_model(text, tuple(kernels))
    X = values_of(parameters, evaluator.model)
    made.unseen(source.n)
    rate = made.rate or 1000.0
    aims = tuple(
        reference_of(t, source, duration=duration, rate=rate, seed=seed)
        for t in trajectories or (None,)
    )
    held = reference_of(held_out, source, duration=duration, rate=_HELD_HZ, seed=seed + 1)
    motion = held.q, held.qd, held.qdd
    trials = Trials(text, tuple(kernels), X, aims, made, seed, held=motion)
    if made.moves_alike:
        trials = replace(trials, moved=tuple(_moved(trials, progress, meter)))
    progress("choosing the band")
    trials = _with_tries(trials, ways, cutoff)
    if trials.moved and made.instruments.velocity:
        trials = replace(trials, aims=())  # a reference is large, and travels with every task
    items = [range(k, min(k + TOGETHER, runs)) for k in range(0, runs, TOGETHER)]
    done: dict[int, bytes] = {}
    progress(f"identifying {runs} runs by {len(ways)} ways")
    with executor(workers) as by:
        for k, content in by.results(trials, items):
            done[k] = content
            meter(_BEFORE + (1 - _BEFORE) * len(done) / len(items))
    parts = [unpacked_arrays(done[k]) for k in range(len(items))]
    found = {m: np.concatenate([part[str(m)] for part in parts], axis=1) for m in LENGTHS}
    seconds = sum(float(a.t[-1] - a.t[0]) for a in aims)
    settings = Settings(
        runs, seed, seconds, LENGTHS, trials.tries[0].band.rate_hz, window, 100 * target,
        tuple(a.name for a in aims), held.name, made,
    )  # fmt: skip
    tau = evaluator.inverse_dynamics(*motion, X)
    results = tuple(
        _tried(trials, way, {key: x[i] for key, x in found.items()}, settings, tau)
        for i, way in enumerate(trials.tries)
    )
    return Study(source.name, settings, results, _notes(results, runs))


def _moved(trials: Trials, progress: Say, meter: Meter) -> list[Simulation]:
    """Return the motions along the references, which are the same for every run."""
    made, share = replace(trials.recording, instruments=Instruments()), _BEFORE / len(trials.aims)
    return [
        simulate(
            trials.evaluator, trials.X, trajectory=aim, recording=made, progress=progress,
            meter=lambda part, k=k: meter(share * (k + part)),  # type: ignore[misc]
        )
        for k, aim in enumerate(trials.aims)
    ]  # fmt: skip


def _with_tries(
    trials: Trials, ways: Sequence[tuple[EquationModel, Method]], cutoff: float | None
) -> Trials:
    """Choose the band of each model and method from the first run, and detect late torques."""
    (first,) = trials.samples(range(1))
    bands: dict[bool, Band] = {}
    late = False
    for iv in {method.name == "iv" for _, method in ways}:
        run = filter_in_band(OpenLogs(trials.evaluator, first), cutoff, own_speeds=iv)
        bands[iv] = run.band
        late |= undo_delay(run).delay != 0
    tries = tuple(Try(model, method, bands[method.name == "iv"]) for model, method in ways)
    return replace(trials, tries=tries, late=late)


def _tried(
    trials: Trials, way: Try, found: dict[int, FloatArray], settings: Settings, tau: FloatArray
) -> Tried:
    """Return the result of one model and method.

    Args:
        trials: the simulated work.
        way: the model and method.
        found: rows [X, std, squared error of torque] (groups, 2 p + n) by number of recordings.
        settings: settings of the study.
        tau: torque of the held-out motion, (N, n).
    """
    size = np.sum(tau**2, axis=0)
    count = len(trials.X)
    known = {m: rows[np.isfinite(rows[:, :count]).all(axis=1)] for m, rows in found.items()}
    of = partial(Tried, way.model.name, way.method.label, way.band, len(found[1]) - len(known[1]))
    enough = [m for m in LENGTHS if len(known[m]) > 2]
    if 1 not in enough:
        return of((), None, (), (), ())
    X = {m: known[m][:, :count] for m in enough}
    std = np.stack([X[m].std(axis=0, ddof=1) for m in enough])
    error = np.stack([known[m][:, 2 * count :].mean(axis=0) for m in enough])
    counts = np.array([len(X[m]) - 1 for m in enough])
    # One std for all lengths, each weighed by what it tells, as if recorded once.
    once = np.sqrt((counts * np.array(enough)) @ std**2 / counts.sum())
    said = known[1][:, count : 2 * count]
    rms, bias = np.sqrt(np.mean(said**2, axis=0)), X[1].mean(axis=0) - trials.X
    doubt = std[0] / math.sqrt(len(X[1]))
    inside = np.mean(np.abs(X[1] - trials.X) <= _HALF * said, axis=0)
    columns = (trials.X, bias, doubt, std[0], rms, inside, once, std.T)
    parameters = tuple(
        Precision(
            p.name, p.unit, true, off, error_of_bias, own, says if math.isfinite(says) else None,
            cover, tuple(course), _seconds(true, off, error_of_bias, single, settings),
        )
        for p, true, off, error_of_bias, own, says, cover, single, course in zip(
            trials.evaluator.model.base.parameters, *(c.tolist() for c in columns), strict=True
        )
    )  # fmt: skip
    moved = std[0] > 0
    ratios = np.sqrt(np.mean((std[:, moved] / std[0, moved]) ** 2, axis=1)) if any(moved) else ()
    by_length = np.sqrt(error.sum(axis=1) / size.sum()).tolist()
    per_joint = np.sqrt(error[0] / np.where(size > 0, size, np.inf)).tolist()
    return of(
        parameters, by_length[0], tuple(per_joint), tuple(by_length), tuple(map(float, ratios))
    )


def _seconds(
    true: float, bias: float, error: float, std: float, settings: Settings
) -> float | None:
    """Return the necessary recording time, s; None if no time is long enough."""
    wanted = settings.target_percent / 100 * abs(true)
    counted = bias if abs(bias) > _COUNTS * error else 0.0
    if wanted <= abs(counted):
        return None
    return settings.seconds * max(1.0, std**2 / (wanted**2 - counted**2))


def _notes(results: Sequence[Tried], runs: int) -> tuple[str, ...]:
    """Return notes on failed runs, and on std that does not fall as 1 / sqrt(length)."""
    out = []
    for r in results:
        if r.failed:
            out.append(f"{r.name}: {r.failed} of {runs} runs do not determine the parameters")
        for m, ratio in zip(LENGTHS[1:], r.std_ratio_by_length[1:], strict=False):
            doubt = _FALLS / math.sqrt(2 * max(runs // m - 1, 1))
            if abs(ratio * math.sqrt(m) - 1) > doubt:
                out.append(
                    f"{r.name}: {m} recordings reduce std to {ratio:.2g} of that of one; expected: "
                    f"{1 / math.sqrt(m):.2g}. The recording times in this study are wrong for it"
                )
    return tuple(out)

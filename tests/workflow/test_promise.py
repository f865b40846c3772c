"""What `diagnose` promises is what the line that it prints delivers, word by word.

The error in motion of identify with the written robot file equals the gap after to three digits,
the gap before is the error of identify with the declared file, and the exit codes agree.
"""

from __future__ import annotations

import io
import json
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from oracles.arm import HANGING, IN_PLANE, sines
from oracles.planar2r import robot_toml
from stored_logs import LOGS, save, stored
from studies.promise_study import DEVIATIONS, adopted, prepare
from support import data_folder

from symgen import cli

#: Three digits of a printed number.
DIGITS = 1e-3
STORED = [file.stem for file in sorted(LOGS.glob("*.npz")) if not stored(file.stem).parameters]
RIGS = "acromonk aliengo_leg dp_c0 emps kr300 panda30 tx40 ur10 ur10e".split()
WORDS = ["robot.toml", "train.npz", "--validation", "test.npz"]
#: Delay of torques, s.
DELAY = 0.012
Row = dict[str, Any]


@dataclass(frozen=True)
class Run:
    """What the commands of a case said, and what they delivered.

    Attributes:
        diagnosis: diagnosis.json.
        said: exit code of diagnose, gap before and gap after.
        delivered: exit code and error of the printed line, and the error of the declared file.
        predicted: error that predict prints of the written robot; None with several logs.
        declared: estimate.json of the declared file.
        distances: of each adopted effect in the written file from zero in the last estimate, in
            deviations of one coefficient; None where a coefficient has no name there.
    """

    diagnosis: Row
    said: Row
    delivered: Row
    predicted: float | None
    declared: Row
    distances: dict[str, float | None]


def attempt(
    call: Callable[[Sequence[str]], tuple[int, str]], folder: Path, words: list[str]
) -> Run:
    """Identify, diagnose, run the printed line, and predict.

    Args:
        call: runs the words of a command in the folder; returns its exit code and its output.
        folder: the folder of the logs.
        words: robot file and logs, with --validation before each validation log.
    """

    def read(file: str) -> Row:
        return json.loads((folder / file).read_text("utf-8"))

    declared_code, _ = call(["identify", *words, "--into", "declared"])
    code, out = call(["diagnose", *words, "--into", "why"])
    diagnosis, declared = read("why/diagnosis.json"), read("declared/estimate.json")
    line = re.search(r"^next: symgen (identify .*)$", out, re.MULTILINE)
    into, last_code = "declared", declared_code
    if line:
        typed = shlex.split(line[1])
        last_code, _ = call(typed)
        into = typed[typed.index("--into") + 1]
    estimate = read(f"{into}/estimate.json")
    gap = diagnosis["gap"]["in_motion"]
    before, after = (e["torque_residual_in_motion"]["relative"] for e in (declared, estimate))
    said = {"exit": code, "before": gap["before"]["total"], "after": gap["after"]["total"]}
    delivered = {"exit": last_code, "before": before, "after": after}
    predicted = None
    if words.count("--validation") == 1:
        known = ["why/robot.toml", words[-1], "--parameters", "why", "--into", "prediction"]
        assert call(["predict", *known])[0] == 0
        prediction = read("prediction/prediction.json")
        predicted = prediction["torque_error_in_motion"]["relative"]
    print(folder.name, diagnosis["verdict"], said, delivered, predicted)
    held = [e for e in diagnosis["effects"] if e["adopted"] and e["in_robot_toml"]]
    distances = {f"{e['name']} {e['joints']}": adopted(e, folder / into)["wald"] for e in held}
    return Run(diagnosis, said, delivered, predicted, declared, distances)


@pytest.fixture(scope="module")
def whole(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Run]:
    """Run the commands on a stored case or on the logs of a real robot."""
    kind, name = request.param.split("/")
    folder = tmp_path_factory.mktemp(name)
    words = (
        save(name, folder) if kind == "stored" else prepare(data_folder() / name, "whole", folder)
    )

    def call(words: Sequence[str]) -> tuple[int, str]:
        typed = [sys.executable, "-m", "symgen", *words]
        run = subprocess.run(typed, cwd=folder, capture_output=True, text=True)
        assert run.returncode in (0, 1), run.stderr
        return run.returncode, run.stdout

    yield attempt(call, folder, words)
    shutil.rmtree(folder)


CASES = pytest.mark.parametrize(
    "whole", [*(f"stored/{x}" for x in STORED), *(f"real/{x}" for x in RIGS)], indirect=True
)


@pytest.mark.slow
@CASES
def test_the_printed_line_delivers_what_is_promised(whole: Run) -> None:
    assert whole.said == pytest.approx(whole.delivered, rel=DIGITS)


@pytest.mark.slow
@CASES
def test_predict_prints_the_number_of_the_diagnosis(whole: Run) -> None:
    if whole.predicted is None:
        pytest.skip("predict reads one log")
    assert whole.predicted == pytest.approx(whole.said["after"], rel=DIGITS)


@pytest.mark.slow
@CASES
def test_no_adopted_effect_is_within_three_deviations_of_zero(whole: Run) -> None:
    print(whole.distances)
    assert all(x is None or x > DEVIATIONS for x in whole.distances.values())


def late(log: Row) -> np.ndarray:
    """Return torques that come DELAY late."""
    t = log["t"]
    return np.column_stack([np.interp(t - DELAY, t, tau) for tau in log["tau"].T])


#: Torques of an arm in a vertical plane, made from its log without a fault.
TORQUES: dict[str, Callable[[Row], np.ndarray]] = {
    "spring": lambda x: x["tau"] + np.outer(0.8 * (x["q"][:, 1] - 0.2), [0.0, 1.0]),
    "turned": lambda x: x["tau"] * [1.0, -1.0],
    "late": late,
}


@contextmanager
def commands_in(folder: Path) -> Iterator[Callable[[Sequence[str]], tuple[int, str]]]:
    """Give a function that runs a command in a folder; it returns exit code and output."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)

        def call(words: Sequence[str]) -> tuple[int, str]:
            patch.setattr(sys, "argv", ["symgen", *words])
            out = io.StringIO()
            with redirect_stdout(out), pytest.raises(SystemExit) as caught:
                cli.main()
            assert caught.value.code in (0, 1), out.getvalue()
            return int(caught.value.code), out.getvalue()

        yield call


@pytest.fixture(scope="module")
def arm(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Run]:
    """Run the commands in this process, in a folder of their own, on the logs of the arm."""
    folder = tmp_path_factory.mktemp(request.param)
    (folder / "robot.toml").write_text(robot_toml("arm", gravity=IN_PLANE), "utf-8")
    for seed, name in ((1, "train"), (2, "test")):
        rng, t = np.random.default_rng(seed), np.arange(0, 12, 0.01)
        phase = rng.uniform(0, 6, (2, 2))
        motion = sines(t, [[0.8, 0.6], [0.3, 0.4]], [[1.1, 1.7], [2.9, 4.3]], phase)
        t, q, tau, qd = HANGING.recorded(t, motion, rng)
        log = {"t": t, "q": q, "tau": tau, "qd": qd}
        np.savez(folder / f"{name}.npz", **log | {"tau": TORQUES[request.param](log)})
    with commands_in(folder) as call:
        yield attempt(call, folder, WORDS)


@pytest.mark.parametrize("arm", ["spring"], indirect=True)
def test_a_spring_is_promised_delivered_and_predicted(arm: Run) -> None:
    assert [e["name"] for e in arm.diagnosis["effects"]] == ["gravity_spring"]
    assert arm.said == pytest.approx(arm.delivered, rel=DIGITS)
    assert arm.said["exit"] == 0
    assert arm.predicted == pytest.approx(arm.said["after"], rel=DIGITS)


@pytest.mark.parametrize("arm", ["turned"], indirect=True)
def test_a_turned_torque_is_a_gain_of_the_written_file(arm: Run) -> None:
    """Identify with the declared file is doubtful, the written one is trusted."""
    assert "gain = [1.0, -1.0]" in Path("why/robot.toml").read_text("utf-8")
    assert arm.said == pytest.approx(arm.delivered, rel=DIGITS)
    assert (arm.declared["verdict"], arm.diagnosis["verdict"]) == ("doubtful", "explained")
    assert arm.said["exit"] == 0


@pytest.mark.parametrize("arm", ["late"], indirect=True)
def test_a_delay_is_a_repair_of_both_commands_and_changes_no_verdict(arm: Run) -> None:
    assert (arm.declared["verdict"], arm.diagnosis["verdict"]) == ("trusted", "consistent")
    assert arm.diagnosis["effects"] == []
    for result in (arm.declared, arm.diagnosis):
        (repair,) = result["repairs"]
        assert (repair["kind"], repair["done"]) == ("delay", "shifted")
        assert repair["value"] == pytest.approx(DELAY, abs=3 * repair["std"])
        assert repair["gap_reduction"] > 0.9
    assert arm.said == pytest.approx(arm.delivered, rel=DIGITS)
    assert arm.predicted == pytest.approx(arm.said["after"], rel=DIGITS)

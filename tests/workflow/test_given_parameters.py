"""--parameters takes the folder that identify wrote, or its estimate.json, with one outcome."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from support_commands import LOADED, PARAMETERS

import symgen
from symgen.cli import cli

#: Every command that takes parameters, with its other arguments. All but excite, which searches by
#: the clock and takes the values alone.
COMMANDS = {
    "predict": "planar2r other.csv",
    "diagnose": "planar2r other.csv --effects gravity_spring",
    "payload": "planar2r loaded.csv",
    "simulate": "planar2r --duration 1",
    "study": "planar2r --model momentum --method ols --duration 2 --runs 3",
}


def _option(name: str) -> str:
    """Return the option of a command that takes parameters; empty where none does."""
    command = cli.get_command(None, name)
    options = {word for parameter in command.params for word in parameter.opts}
    return next((o for o in ("--parameters", "--reference") if o in options), "")


def test_every_command_that_takes_parameters_is_asked() -> None:
    assert {*COMMANDS, "excite", "generate"} == {name for name in cli.commands if _option(name)}


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An estimate from a log at 200 Hz, and logs at 250 Hz, which another band suits."""
    folder = tmp_path_factory.mktemp("recorded")
    (folder / "p.toml").write_text(PARAMETERS)
    (folder / "loaded.toml").write_text(LOADED)
    noise = symgen.Instruments(position_noise=1e-4, torque_noise_relative=0.02)
    for name, values, duration in (("train", "p", 8), ("other", "p", 5), ("loaded", "loaded", 5)):
        made = symgen.simulate(
            "planar2r", folder / f"{values}.toml", duration=duration, seed=len(name),
            recording=symgen.Recording(rate=200.0 if name == "train" else 250.0, instruments=noise),
        )  # fmt: skip
        for path, content in made.files(folder / f"{name}.csv"):
            path.write_bytes(content)
    estimate = symgen.identify("planar2r", folder / "train.csv")
    symgen.write(estimate, folder / "result")
    return folder


@pytest.mark.parametrize("name", COMMANDS)
def test_a_folder_and_its_estimate_are_one(name, recorded, tmp_path, command, monkeypatch) -> None:
    monkeypatch.chdir(recorded)
    seen = []
    for given in ("result", "result/estimate.json"):
        into = tmp_path / given.replace("/", "_") / "out.csv"  # a log, or a folder
        words = [*COMMANDS[name].split(), _option(name), given, "--into", into]
        code, _, err = command(name, *words)
        assert code in (0, 1), err
        written = [into] if into.is_file() else sorted(p for p in into.rglob("*") if p.is_file())
        assert written
        seen.append({p.name: p.read_bytes() for p in written if p.suffix in (".json", ".csv")})
    assert seen[0] == seen[1]


def test_all_missing_parameters_are_named_at_once(tmp_path, command) -> None:
    model = symgen.derive(symgen.read_robot("puma560"))
    lacking = ("XY2", "XZ3", "MY3", "IA4", "FS6")
    given = [p.name for p in model.base.standard if p.name not in lacking]
    file = tmp_path / "parameters.toml"
    file.write_text("[parameters]\n" + "".join(f"{name} = 1.0\n" for name in given))
    asked = ["generate", "puma560", "--parameters", file, "--kernels", "gravity_torque"]
    code, _, err = command(*asked, "--target", "c", "--into", tmp_path / "out")
    assert code == 2
    for name in lacking:
        assert re.search(rf"\b{name}\b", err), name
    assert "XX5" not in err
    file.write_text(file.read_text() + "".join(f"{name} = 1.0\n" for name in lacking))
    code, _, err = command(*asked, "--target", "c", "--into", tmp_path / "out")
    assert code == 0, err

"""A lift that declares an offset, in a package that a controller copies: it must not fall."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner
from packages import STRICT, run

from symgen.cli import cli

ROBOT = """
[robot]
name = "lift"
gravity = [0.0, 0.0, -9.81]
[[joint]]
sigma = 1
friction = ["coulomb", "viscous", "offset"]
[[joint]]
alpha = "pi/2"
"""
VALUES = {
    "M1": 20.0, "M2": 5.0, "MX2": 1.0, "MY2": 0.0, "ZZ2": 0.5, "IA1": 3.0, "IA2": 0.1,
    "FS1": 10.0, "FV1": 50.0, "OF1": 0.0, "FS2": 0.5, "FV2": 0.5,
}  # fmt: skip
PROGRAM = """
#include <stdio.h>
#include "lift_values.h"
int main(void)
{
    const double q[2] = {0.1, 0.3}, up[2] = {1.1, 0.3}, zero[2] = {0.0, 0.0};
    const double com[3] = {0.0, 0.0, 0.0}, I[6] = {0.1, 0.0, 0.0, 0.1, 0.0, 0.1};
    double X[lift_PARAMETERS], out[2], p[2], T[1], low[1], high[1];
    for (int i = 0; i < lift_PARAMETERS; ++i) {
        X[i] = lift_values[i];
    }
    lift_gravity_torque(q, X, out);
    printf("gravity %.9g\\n", out[0]);
    lift_friction(zero, X, out);
    printf("friction %.9g\\n", out[0]);
    lift_generalized_momentum(q, zero, X, p, out);
    printf("rate %.9g\\n", out[0]);
    lift_energy(q, zero, X, T, low);
    lift_energy(up, zero, X, T, high);
    printf("rise %.9g\\n", high[0] - low[0]);
    lift_add_body(X, 2, 10.0, com, I);
    lift_gravity_torque(q, X, out);
    printf("loaded %.9g\\n", out[0]);
    return 0;
}
"""
KERNELS = ("gravity_torque", "friction", "generalized_momentum", "energy", "add_body")
WEIGHT = (20 + 5) * 9.81  # N


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler (cc) on this machine")
def test_a_lift_is_held_by_its_gravity_torque_and_not_by_its_friction(tmp_path: Path) -> None:
    (tmp_path / "lift.toml").write_text(ROBOT)
    lines = [f"{name} = {value}" for name, value in VALUES.items()]
    (tmp_path / "values.toml").write_text("\n".join(["[parameters]", *lines]))
    (tmp_path / "main.c").write_text(PROGRAM)
    folder = tmp_path / "lift"
    options = ["--parameters", str(tmp_path / "values.toml"), "--target", "c"]
    command = ["generate", str(tmp_path / "lift.toml"), *options, "--into", str(folder)]
    done = CliRunner().invoke(cli, command)
    assert done.exit_code == 0, done.output
    sources = [folder / f"lift_{name}.c" for name in KERNELS]
    run(["cc", *STRICT, f"-I{folder}", "main.c", *sources, "-lm", "-o", "main"], tmp_path)
    found = dict(line.split() for line in run([tmp_path / "main"], tmp_path).splitlines())
    assert {name: float(value) for name, value in found.items()} == pytest.approx(
        {
            "gravity": WEIGHT,
            "friction": 0.0,
            "rate": -WEIGHT,
            "rise": WEIGHT,
            "loaded": WEIGHT + 10 * 9.81,
        }
    )

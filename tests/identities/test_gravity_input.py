"""Gravity as an input, for tilted mountings: Pinocchio, 4x4 transforms, and what refuses it."""

from __future__ import annotations

import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from oracles.numeric_rank import numeric_rank, random_states
from oracles.random_arms import random_arm
from oracles.transforms import Arm, energy_regressor
from packages import STRICT, c_files, run
from support import messages, parsed, robot_of, sampled
from support_commands import LIMITS

import symgen
from symgen.robot.toml_text import robot_toml

SEEDS = sampled(range(6), 3)
NEED = (
    "energy_regressor",
    "power_regressor",
    "momentum_regressor",
    "torque_regressor",
    "inverse_dynamics",
    "gravity_torque",
    "bias_torque",
    "forward_dynamics",
    "energy",
    "slotine_li_regressor",
    "slotine_li_torque",
    "generalized_momentum",
    "inverse_dynamics_derivatives",
    "forward_dynamics_derivatives",
)
TILTED = ((0.0, 0.0, -9.81), (9.81, 0.0, 0.0), (1.7, -3.1, 8.2), (0.0, 0.0, 0.0))


def robot_with_input(arm: Arm, friction: tuple[str, ...] = ()) -> symgen.Robot:
    """An oracle's arm whose robot file leaves gravity open."""
    text = robot_toml(robot_of(arm, friction))
    begin = text.index("gravity = ")
    end = text.index("\n", begin)
    return parsed(f'{text[:begin]}gravity = "input"{text[end:]}')


@pytest.mark.parametrize("seed", [*SEEDS, *sampled(range(40, 52), 4)])
def test_parameters_are_minimal_for_every_gravity(seed: int) -> None:
    arm = random_arm(seed, max_joints=5)
    friction = ("viscous", "offset") if seed % 2 else ()
    model = symgen.derive(robot_with_input(arm, friction))
    rows = []
    for turn, g in enumerate(np.random.default_rng(seed).uniform(-9, 9, (6, 3))):
        q, qd = random_states(arm, 80, 100 * seed + turn)
        h = energy_regressor(replace(arm, gravity=tuple(g)), q, qd)
        rows.append(np.hstack([h, q])[1:] - np.hstack([h, q])[:1])
    matrix = np.vstack(rows)
    if not friction:
        matrix = matrix[:, : -arm.n]
    path_only = arm.n if friction else 0  # FV
    assert len(model.base.parameters) == numeric_rank(matrix) + path_only


def test_an_offset_and_a_weight_are_two_things_where_gravity_may_turn() -> None:
    text = """
[robot]
name = "lift"
gravity = {}
[[joint]]
sigma = 1
friction = ["offset"]
"""
    fixed = symgen.derive(parsed(text.format("[0.0, 0.0, -9.81]"))).base
    free = symgen.derive(parsed(text.format('"input"'))).base
    assert [p.expression for p in fixed.parameters] == ["M1 + 100/981*OF1", "IA1 - 100/981*OF1"]
    assert [p.expression for p in free.parameters] == ["M1", "IA1", "OF1"]


def test_g_is_the_last_input_of_what_needs_it_and_shared_by_all_samples(tmp_path: Path) -> None:
    model = symgen.derive(robot_with_input(random_arm(2, max_joints=4)), "all")
    assert {k.name for k in model.kernels if k.tape.inputs[-1][0] == "g"} == set(NEED)
    assert all("g" not in dict(k.tape.inputs[:-1]) for k in model.kernels)
    call = symgen.load(model, backend="casadi")
    q = np.random.default_rng(0).uniform(-1, 1, (3, 700, model.robot.n))
    g = np.array(TILTED[2])
    together = call["torque_regressor"](*q, g)
    for k in (0, 511, 699):
        one = call["torque_regressor"](*q[:, k], g)
        np.testing.assert_allclose(together[k], one, atol=1e-12)
    with pytest.raises(symgen.SymgenError, match=r"torque_regressor: gravity is an input"):
        call["torque_regressor"](*q)
    with pytest.raises(symgen.SymgenError, match=r"g has shape \(2,\); accepted: \(3,\)"):
        call["torque_regressor"](*q, g[:2])
    chosen = ("gravity_torque", "torque_regressor", "forward_dynamics")
    tree = symgen.generate(model, target="c", kernels=chosen)
    symgen.write_package(tree, tmp_path / "arm")
    name = model.robot.name
    header = (tmp_path / "arm" / f"{name}.h").read_text()
    assert f"void {name}_gravity_torque(const double q[" in header
    assert ", const double g[3], double tau[" in header
    files = c_files(tmp_path / "arm", check=True)
    run(["cc", *STRICT, "-O1", f"-I{tmp_path / 'arm'}", *files, "-lm", "-o", "check"], tmp_path)
    run([tmp_path / "check"], tmp_path)


LIFT = """
[robot]
name = "lift"
gravity = "input"
[[joint]]
sigma = 1
friction = ["viscous", "offset"]
[[joint]]
alpha = "pi/2"
"""
WATCH = """
#include "lift_identifier_momentum.h"
#include <stdio.h>

static double memory[4000];

int main(void)
{
    double row[8], X[lift_PARAMETERS];
    int begun = BEGIN(memory, sizeof memory, 40, lift_WINDOW_SLIDING, 1);
    for (int last = 0; begun == 0 && scanf("%lf", row) == 1;) {
        for (int i = 1; i < 8; i++) {
            if (scanf("%lf", row + i) != 1) {
                return 1;
            }
        }
        if (row[7] > last) {
            printf("%d\\n", lift_identifier_read(memory, X, NULL));
            last = 1;
        }
        if (lift_identifier_step(memory, row, row + 2, row + 4, 1e-2, last ? G[1] : G[0]) != 0) {
            return 2;
        }
    }
    printf("%d", lift_identifier_read(memory, X, NULL));
    for (int i = 0; i < lift_PARAMETERS; i++) {
        printf(" %.12g", X[i]);
    }
    const double nothing[3] = { 0, NAN, 0 };
    return begun + (lift_identifier_step(memory, row, row + 2, row + 4, 1e-2, nothing) == 0);
}
"""


@pytest.mark.parametrize("model", ["energy", "momentum"])
def test_the_identifier_learns_in_two_mountings_what_one_cannot_tell(
    model: str, tmp_path: Path
) -> None:
    """Mass and offset of a lift: one number while it stands upright, two once it leans."""
    needs = ("friction_power", "momentum_regressor", "friction_torque", "inverse_dynamics")
    derived = symgen.derive(parsed(LIFT), ("energy_regressor", *needs))
    symgen.write_package(symgen.generate(derived, target="c"), tmp_path / "lift")
    names = derived.base.names
    value = {name: 0.3 + 0.1 * i for i, name in enumerate(names)}
    value |= {"ZZ2": 0.5, "M1R": 3.0}
    X = np.array([value[name] for name in names])
    torque = symgen.load(derived, backend="casadi")["inverse_dynamics"]
    t = np.arange(0, 6, 1e-2)
    rows = []
    for mounting, g in enumerate(TILTED[0:3:2]):
        phase = np.array([3.0, 4.3]) * t[:, None] + mounting
        q, qd = np.sin(phase), [3.0, 4.3] * np.cos(phase)
        tau = torque(q, qd, -np.square([3.0, 4.3]) * np.sin(phase), X, g)
        rows.append(np.hstack([q, qd, tau, np.full((len(t), 2), mounting)]))
    begin = "lift_identifier_init" if model == "energy" else "lift_identifier_momentum_init"
    listed = ", ".join(f"{{{', '.join(map(repr, g))}}}" for g in TILTED[0:3:2])
    head = f"#include <math.h>\n#define BEGIN {begin}\n"
    head += f"static const double G[2][3] = {{{listed}}};\n"
    (tmp_path / "main.c").write_text(head + WATCH)
    files = ["main.c", *c_files(tmp_path / "lift")]
    run(["cc", *STRICT, "-O1", f"-I{tmp_path / 'lift'}", *files, "-lm", "-o", "main"], tmp_path)
    text = "\n".join(" ".join(map(repr, map(float, row))) for row in np.vstack(rows))
    done = subprocess.run(
        [tmp_path / "main"], input=text, capture_output=True, text=True, check=True
    )
    first, last = done.stdout.splitlines()
    assert int(first) != 0  # the number of a parameter that one mounting does not determine
    status, *found = last.split()
    assert status == "0"
    np.testing.assert_allclose(np.array(found, float), X, rtol=1e-5)


def test_in_python_the_identifier_says_that_it_cannot() -> None:
    call = symgen.load(symgen.derive(parsed(LIFT)))
    with pytest.raises(symgen.SymgenError, match=r"gravity.+on line") as refused:
        symgen.Identifier(call)
    assert "\n" not in str(refused.value)


def test_what_cannot_have_it_says_so(command, tmp_path: Path) -> None:
    robot = robot_with_input(random_arm(2, max_joints=4))
    file, log = tmp_path / "arm.toml", tmp_path / "log.csv"
    file.write_text(robot_toml(robot))
    n = robot.n
    t = np.arange(0, 4, 0.005)
    heads = ["t", *(f"{x}{j.number}" for x in ("q", "tau") for j in robot.movable)]
    data = np.column_stack([t, *(np.sin((1 + k) * t) for k in range(2 * n))])
    np.savetxt(log, data, delimiter=",", header=",".join(heads), comments="")
    values = "".join(f"{name} = 1.0\n" for name in symgen.derive(robot).base.names)
    (tmp_path / "X.toml").write_text(f"[parameters]\n{values}")
    given = ["--parameters", str(tmp_path / "X.toml"), "--into", str(tmp_path / "out")]
    for arguments in (
        ["identify", str(file), str(log), *given[2:]],
        ["predict", str(file), str(log), *given],
        ["diagnose", str(file), str(log), *given[2:]],
        ["simulate", str(file), *given[:3], f"{given[3]}.csv"],
        ["excite", str(file), "--into", f"{given[3]}.csv", *LIMITS],
    ):
        code, _, err = command(*arguments)
        (line,) = messages(err)
        assert (code, "gravity" in line) == (2, True), (arguments, line)


@pytest.mark.parametrize("value", ['"inputs"', '"-9.81"', "[0, 0]", "true"])
def test_another_word_is_refused_in_a_line(value: str) -> None:
    text = f'[robot]\nname = "lift"\ngravity = {value}\n[[joint]]\n'
    with pytest.raises(symgen.SymgenError, match="gravity") as refused:
        parsed(text)
    assert "\n" not in str(refused.value)

"""Formulas of base parameters: six digits where people read them, exact where programs do."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from symgen.cli import cli
from symgen.robot.expressions import six_digits

ROBOT = """
[robot]
name = "two"
gravity = [0.0, -9.81, 0.0]
[[joint]]
[[joint]]
d = {length}
"""


@pytest.mark.parametrize("length", ["0.17327300000000019", '"1234577/9999991"'])
def test_a_formula_is_short_in_text_and_exact_in_json(length: str, tmp_path: Path) -> None:
    (tmp_path / "two.toml").write_text(ROBOT.format(length=length))
    values = ["M1", "ZZ1", "MX1", "MY1", "M2", "ZZ2", "MX2", "MY2", "IA1", "IA2", "FS1", "FV1"]
    lines = ["[parameters]", *(f"{name} = 1.0" for name in (*values, "FS2", "FV2"))]
    (tmp_path / "values.toml").write_text("\n".join(lines))
    command = ["generate", str(tmp_path / "two.toml"), "--into", str(tmp_path / "two")]
    command += ["--target", "c", "--parameters", str(tmp_path / "values.toml")]
    done = CliRunner().invoke(cli, command)
    assert done.exit_code == 0, done.output
    exact = eval(length.strip('"'))
    manifest = json.loads((tmp_path / "two" / "manifest.json").read_text())
    whole = {p["name"]: p["expression"] for p in manifest["base_parameters"]}["MX1R"]
    factor = re.fullmatch(r"MX1 \+ (.+)\*M2", whole)
    assert factor is not None
    assert eval(factor[1]) == pytest.approx(exact, rel=1e-15)
    header = (tmp_path / "two" / "two.h").read_text()
    for text in (done.output, header, (tmp_path / "two" / "two_values.h").read_text()):
        assert "MX1 + 0.1" in text
        for formula in re.findall(r"MX1 \+ .*M2|ZZ1 \+ .*M2", text):
            assert not re.search(r"\d{7}", formula.replace("0.0", "")), formula


@pytest.mark.parametrize(
    ("whole", "short"),
    [
        ("ZZ1 + 6930920000000007937933343401/4e28*M4", "ZZ1 + 0.173273*M4"),
        ("L1**2*M12345678/12345678/3", "L1**2*M12345678/1.23457e+07/3"),
        ("x/123/45678901*M2 - 2**3/45678901*X", "x/123/4.56789e+07*M2 - 2**3/4.56789e+07*X"),
        ("M1 + 100/981*OF1 - 1/3*M2", "M1 + 100/981*OF1 - 1/3*M2"),
        ("-1.2345678e-08*MX1", "-1.23457e-08*MX1"),
    ],
)
def test_numbers_are_rounded_and_names_are_not(whole: str, short: str) -> None:
    assert six_digits(whole) == short

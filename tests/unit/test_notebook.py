"""What notebooks and debuggers show of robots, models and estimates."""

from __future__ import annotations

import ast
import json
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from support import PROJECT

import symgen
from symgen.report.store import load_result, result_page


class Cells(HTMLParser):
    """Texts of the cells of a table, row by row; complains of tags that do not close."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.rows, self.open = [], []
        self.feed(text)
        assert not self.open

    def handle_starttag(self, tag, _attrs):
        self.open.append(tag)
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] in ("td", "th"):
            self.rows[-1][-1] += data


@pytest.fixture(scope="module")
def model():
    return symgen.derive("planar2r")


def test_a_repr_is_one_short_line(model) -> None:
    assert repr(model.robot) == "<Robot planar2r: 2 of 2 joints movable>"
    assert repr(model) == "<Model planar2r: 2 joints, 4 base parameters>"
    assert repr(model.base) == "<BaseParameters: 4 of 20 standard ones>"


def test_results_are_one_short_line() -> None:
    X = [1.702, 0.05644, 0.15, 0.075]
    made = symgen.Recording(symgen.Instruments(torque_noise=1e-3), rate=100.0)
    done = symgen.simulate("planar2r", X, recording=made, runs=2, duration=4.0)
    assert repr(done) == "<Simulation of planar2r: 2 runs of 4 s, 401 stamps>"
    a, b = (symgen.identify("planar2r", done.log(k), model="energy") for k in (0, 1))
    assert repr(symgen.compare(a, b)).startswith("<Comparison of planar2r: ")
    read = Path(__file__).parents[1] / "reference" / "schemas"
    for folder, said in (
        ("prediction-2", "<Prediction of planar2r along "),
        ("payload-1", "<Payload of planar2r on joint 2: mass 2.005 kg>"),
        ("study-1", "<Study of planar2r: "),
    ):
        text = repr(load_result(read / folder))
        assert text.startswith(said), text
        assert len(text) < 200, text


def test_tables_hold_what_the_values_say(model) -> None:
    head, *rows = Cells(model.robot._repr_html_()).rows
    assert [dict(zip(head, row, strict=True))["d"] for row in rows] == ["0", "L1"]
    head, *rows = Cells(model._repr_html_()).rows
    assert head == ["base parameter", "formula", "unit"]
    assert [row[0] for row in rows] == list(model.base.names)
    assert [row[2] for row in rows] == ["kg m2", "kg m2", "kg m", "kg m"]


def test_names_of_a_file_are_no_markup(model) -> None:
    first, second = model.robot.joints
    named = replace(model.robot, joints=(replace(first, name="<script>x</script>"), second))
    assert "<script>" not in named._repr_html_()
    assert Cells(named._repr_html_()).rows[1][1] == "<script>x</script>"


def test_latex_has_a_formula_for_each_parameter_and_balanced_braces(model) -> None:
    text = model._repr_latex_()
    assert text.startswith("$$\\begin{aligned}")
    assert text.endswith("\\end{aligned}$$")
    assert text.count("{") == text.count("}")
    assert text.count("&") == len(model.base.parameters)
    assert "L_{1}^{2} M_{2} + ZZ_{1}" in text


def kept(kind: str):
    return load_result(Path(__file__).parents[1] / "reference" / "schemas" / kind)


@pytest.mark.parametrize(
    ("kind", "first", "other"),
    [
        ("estimate-2", None, None),
        ("prediction-2", "Measured and predicted torque", "Energy"),
    ],
)
def test_a_result_draws_the_figures_of_its_page(kind, first, other, tmp_path) -> None:
    result = kept(kind)
    if first is None:
        with pytest.raises(symgen.ParameterError, match="nothing to draw"):
            result.plot()
        return
    page = result_page(result)
    for name in (None, first, other):
        assert result.plot(name).html in page
    figure = result.plot(other)
    figure.save(tmp_path / "energy.html")
    assert figure.html in (tmp_path / "energy.html").read_text("utf-8")
    with pytest.raises(symgen.ParameterError, match=f"accepted: {first}, {other}"):
        result.plot("Spectrum")


def test_a_panel_holds_what_the_page_says_first_and_its_rules_stay_inside() -> None:
    for kind in ("estimate-2", "diagnosis-1", "prediction-2", "payload-1", "study-1"):
        result = kept(kind)
        panel, page = result._repr_html_(), result_page(result)
        table = panel[panel.index("<table") : panel.index("</table>")]
        assert table in page
        rules = panel[panel.index("<style>") + 7 : panel.index("</style>")]
        outer, depth = "", 0
        for letter in rules:  # what stands before a rule that is inside no other
            depth += {"{": 1, "}": -1}.get(letter, 0)
            outer += letter if depth == 0 and letter != "}" else ""
        assert set(outer.split()) == {".symgen"}
        assert depth == 0
        assert len(panel) < 20_000


def test_an_evaluator_shows_the_operations_of_its_kernels() -> None:
    evaluator = symgen.load(symgen.derive("planar2r", ("inverse_dynamics", "mass_matrix")))
    assert repr(evaluator).startswith("<Evaluator of planar2r: ")
    head, *rows = Cells(evaluator._repr_html_()).rows
    assert head == ["kernel", "mul", "add", "div", "sincos"]
    counted = {k.name: str(k.tape.operations.mul) for k in evaluator.model.kernels}
    assert {row[0]: row[1] for row in rows} == counted


@pytest.mark.slow
def test_the_notebook_runs_and_has_no_outputs(capfd) -> None:
    """Every cell, as a notebook runs it: what its last expression returns has a view."""
    book = json.loads((PROJECT / "docs/examples/missing_spring.ipynb").read_text("utf-8"))
    assert book["nbformat"] == 4
    known, shown = {}, []
    for cell in (c for c in book["cells"] if c["cell_type"] == "code"):
        assert (cell["outputs"], cell["execution_count"]) == ([], None)
        tree = ast.parse("".join(cell["source"]))
        last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
        exec(compile(tree, "cell", "exec"), known)
        if last is not None:
            shown.append(eval(compile(ast.Expression(last.value), "cell", "eval"), known))
    assert [type(x).__name__ for x in shown] == [
        *("Robot", "Estimate", "Figure", "Diagnosis", "Figure", "ndarray", "Evaluator")
    ]
    assert all(hasattr(x, "_repr_html_") for x in shown if not isinstance(x, np.ndarray))
    (effect,) = known["diagnosis"].effects
    (spring,) = effect.parameters
    assert (effect.name, effect.joints) == ("gravity_spring", (2,))
    assert abs(spring.value - 6.0) < 0.06
    assert known["better"].torque_validation.relative < known["estimate"].torque_validation.relative
    assert capfd.readouterr() == ("", "")  # functions print nothing

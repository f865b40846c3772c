"""Closed forms of kernels, and the LaTeX document of a model."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

import symgen


def test_the_paper_s_example_prints_its_four_energy_columns():
    # Gautier and Khalil (1988), section 8: DL1 to DL4 of the planar arm of two joints
    model = symgen.derive("planar2r")
    q2, qd1, qd2, L1 = (sp.Symbol(name, real=True) for name in ("q2", "qd1", "qd2", "L1"))
    DL1 = qd1**2 / 2
    DL2 = (qd1 + qd2) ** 2 / 2
    DL3 = L1 * qd1 * (qd1 + qd2) * sp.cos(q2)
    DL4 = -L1 * qd1 * (qd1 + qd2) * sp.sin(q2)
    assert model.closed_form("energy_regressor") == (DL1, DL2, DL3, DL4)


@pytest.mark.parametrize("robot", ["planar2r", pytest.param("scara", marks=pytest.mark.slow)])
def test_closed_forms_have_the_values_of_the_kernel(robot):
    model = symgen.derive(robot, ("torque_regressor", "mass_matrix"))
    for kernel in model.kernels:
        entries = model.closed_form(kernel.name)
        if entries is None:  # longer than a page
            continue
        rng = np.random.default_rng(3)
        values = dict(model.robot.values())
        inputs = []
        for _, symbols in kernel.tape.inputs:
            array = rng.uniform(-1, 1, len(symbols))
            values |= dict(zip(symbols, array, strict=True))
            inputs.append(array)
        out = np.ravel(symgen.load(model)[kernel.name](*inputs))
        formulas = [float(e.subs(values)) for e in entries]
        np.testing.assert_allclose(formulas, out, rtol=1e-12, atol=1e-12)


@pytest.mark.slow
def test_what_is_too_long_for_a_page_has_no_closed_form():
    model = symgen.derive("puma560", ("inverse_dynamics",))
    assert model.closed_form("inverse_dynamics") is None


def test_a_kernel_that_was_not_derived_is_refused():
    with pytest.raises(symgen.ParameterError, match="energy_regressor"):
        symgen.derive("planar2r").closed_form("coriolis")


def test_the_document_has_base_parameters_and_small_regressors():
    small = symgen.derive("planar2r", ("energy_regressor", "torque_regressor"))
    text = symgen.generate(small, target="c", tex=True).files["planar2r.tex"].decode()
    assert r"ZZ_{1\mathrm{R}} &= L_{1}^{2} M_{2} + ZZ_{1}" in text
    assert r"h_{1} &= \frac{\dot q_{1}^{2}}{2}" in text
    large = symgen.derive("puma560", ("energy_regressor",))
    text = symgen.generate(large, target="c", tex=True).files["puma560.tex"].decode()
    assert "h_{1}" not in text

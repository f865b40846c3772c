"""Equations of motion as formulas

symgen prints the mass matrix of a small robot as formulas. SymPy can calculate with them, here to
find the position in which the inertia at the first joint is largest.
"""

# ## The formulas
# The kernel mass_matrix has four entries for two joints. ZZ1R, ZZ2, MX2 and MY2 are the base
# parameters.

import numpy as np
import sympy as sp

import symgen

model = symgen.derive("planar2r", ("energy_regressor", "mass_matrix"))
for k, entry in enumerate(model.closed_form("mass_matrix")):
    print(f"M{k // 2 + 1}{k % 2 + 1} = {entry}")

# ## The largest inertia
# The derivative of the first entry is zero where the second link points outwards.

X = [3.5, 0.06, 0.124, 0.006]
known = {f"X_{name}": value for name, value in zip(model.base.names, X, strict=True)}
first = model.closed_form("mass_matrix")[0]
by_name = {symbol.name: symbol for symbol in first.free_symbols}
first = first.subs({s: {**known, "L1": 0.5}[name] for name, s in by_name.items() if name != "q2"})
q2 = by_name["q2"]
best = float(sp.nsolve(sp.diff(first, q2), q2, 0.0))
inertia = float(first.subs(q2, best))
print(f"largest inertia {inertia:.3f} kg m2 at q2 = {best:.3f} rad")

# ## Compared with the compiled function
# The same position, in the compiled mass matrix.

compiled = symgen.load(model).mass_matrix([0.0, best], X)[0, 0]
print(f"compiled:        {compiled:.3f} kg m2")
assert np.isclose(inertia, compiled, rtol=1e-12)

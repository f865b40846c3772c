"""The estimators by name, for the command line and for `identify`."""

from __future__ import annotations

from symgen.errors import IdentificationError
from symgen.estimation.errors_in_variables import TotalLeastSquares
from symgen.estimation.essential import Essential
from symgen.estimation.estimators import Estimator, Huber, Ols, Ridge, Wls
from symgen.estimation.instrumental import InstrumentalVariables
from symgen.estimation.regression import Solution
from symgen.estimation.system import LinearSystem

#: Estimators that need nothing but the equations, by the name of `--method`.
ESTIMATORS: dict[str, Estimator] = {
    e.name: e
    for e in (
        Wls(),
        Ols(),
        Huber(),
        TotalLeastSquares(),
        InstrumentalVariables(),
        Ridge(),
        Essential(),
    )
}
METHODS = tuple(ESTIMATORS)


def solve(system: LinearSystem, method: str = "wls") -> Solution:
    """Solve y = W X by a method of METHODS.

    Args:
        system: the equations, log by log.
        method: its name.

    Raises:
        IdentificationError: there is no such method, or the data do not determine the parameters.
    """
    if method not in ESTIMATORS:
        raise IdentificationError(f"method {method!r}; accepted: {', '.join(METHODS)}")
    return ESTIMATORS[method].solve(system)

"""Compile the identifier of a model for Python: the C of the package, as a separate module."""

from __future__ import annotations

from types import ModuleType

from symgen.codegen.backends import c
from symgen.codegen.model import Model
from symgen.errors import BuildError
from symgen.runtime.build import build_module, find_compiler, missing_compiler
from symgen.runtime.flags import kernel_flags

#: Functions of the identifiers for Python, by header.
_IDENTIFIERS = {
    "identifier.h": """
size_t NAME_identifier_size(size_t window);
int NAME_identifier_init(void *state, size_t bytes, size_t window, int mode, double forgetting);
int NAME_identifier_step(void *state, const double *q, const double *qd, const double *tau,
                         double dt);
int NAME_identifier_status(const void *state);
void NAME_identifier_restart(void *state);
int NAME_identifier_run(void *state, size_t N, const double *t, const double *q, const double *qd,
                        const double *tau);
int NAME_identifier_read(const void *state, double *X, double *std);
int NAME_identifier_rest(void *state, const double *noise);
int NAME_identifier_excited(const void *state, double *out);
typedef struct NAME_least_squares {
    double R[...]; double z[...]; double forgetting; double rss; double count; ...;
} NAME_least_squares;
const NAME_least_squares *NAME_identifier_state(const void *state);
int NAME_least_squares_init(NAME_least_squares *s, double forgetting);
int NAME_least_squares_update(NAME_least_squares *s, const double *row, double y);
void NAME_least_squares_merge(NAME_least_squares *s, const NAME_least_squares *other);
int NAME_least_squares_solve(const NAME_least_squares *s, double *X, double *std, double *rss);
""",
    "identifier_momentum.h": """
size_t NAME_identifier_momentum_size(size_t window);
int NAME_identifier_momentum_init(void *state, size_t bytes, size_t window, int mode,
                                  double forgetting);
""",
}


def identifier_module(model: Model) -> ModuleType:
    """Compile the identifiers for the kernels of the model, or load them from the cache.

    Raises:
        BuildError: there is no compiler, or it fails.
    """
    compiler = find_compiler()
    if compiler is None:
        raise BuildError(missing_compiler())
    name = model.robot.name
    sources = c.functions(model, runtime=True)
    declarations = ""
    for header, declared in _IDENTIFIERS.items():
        if f"{name}_{header}" in sources:
            declarations += declared.replace("NAME", name)
    return build_module(sources, declarations, compiler, kernel_flags(compiler))

"""symgen: dynamic models of robots, and their parameters from measured logs.

    robot = symgen.read_robot("planar2r")
    model = symgen.derive(robot)
    evaluator = symgen.load(model)
    estimate = symgen.identify(evaluator, ["train.csv"], validation=["test.csv"])

A name is imported on first use, so `import symgen` is fast. The stub `__init__.pyi` lists all
names, for this module and for editors and type checkers.
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from symgen.views import Views

_where: dict[str, str] = {}


def _modules() -> dict[str, str]:
    """Return name -> module, from the stub."""
    if not _where:
        import ast
        from pathlib import Path

        for line in ast.parse(Path(__file__).with_suffix(".pyi").read_text("utf-8")).body:
            if isinstance(line, ast.ImportFrom):
                _where.update({name.name: str(line.module) for name in line.names})
    return _where


def load_views() -> Views:
    """Return the functions that display results, see `symgen.views`."""
    import importlib

    return importlib.import_module("symgen.report.views")  # type: ignore[return-value]


def __getattr__(name: str) -> object:
    modules = _modules()
    if name == "__all__":
        return sorted(modules)
    if name not in modules:
        raise AttributeError(f"module 'symgen' has no attribute {name!r}")
    import importlib

    return getattr(importlib.import_module(modules[name]), name)


def __dir__() -> list[str]:
    return sorted(_modules())

"""What pages take from code: options, fields of files, kernels, examples.

docs/hooks.py puts the text of `NAME(ARGUMENT)` where a page has <!-- insert: NAME ARGUMENT -->.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import is_dataclass
from importlib import import_module
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

import click

DOCS = Path(__file__).parent
#: The module and the class of each result file.
RESULTS = {
    "estimate.json": ("symgen.identification.estimate", "Estimate"),
    "diagnosis.json": ("symgen.diagnosis.diagnosis", "Diagnosis"),
    "prediction.json": ("symgen.identification.prediction", "Prediction"),
    "payload.json": ("symgen.identification.payload", "Payload"),
    "simulation.json": ("symgen.experiment.playback", "SimulationComparison"),
    "study.json": ("symgen.experiment.study", "Study"),
}
#: Options of every command that reads logs.
READING = ("columns", "joints", "topic", "mask", "unit", "time_unit", "separator", "decimal",
           "header", "start", "until")  # fmt: skip
WORDS = {"str": "text", "float": "number", "int": "integer", "bool": "true or false"}
ARRAY = "array of numbers"
#: An attribute or several in a docstring, with its meaning up to the next attribute.
ATTRIBUTE = re.compile(r"^    (?P<names>\w[\w, ]*): (?P<text>.*(?:\n     +.*)*)", re.M)
#: The name of a constant in a docstring.
CONSTANT = re.compile(r"\b[A-Z][A-Z_]{4,}\b")


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table of Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    escaped = ([cell.replace("|", "\\|") for cell in line] for line in lines)
    return "\n".join(f"| {' | '.join(line)} |" for line in escaped)


def options(_: str) -> str:
    """Return usage, meaning and options of every command, as `--help` has them."""
    from symgen.cli.group import cli

    out = [_command(name, command) for name, command in sorted(cli.commands.items())]
    context = click.Context(cli.commands["identify"], show_default=True)
    reading = [p for p in context.command.params if p.name in READING]
    rows = [p.get_help_record(context) for p in reading]
    out.append("### Options for logs\nAll commands that read logs have them.")
    out.append(table(("option", "meaning"), [(f"`{name}`", text) for name, text in rows]))
    return "\n\n".join(out)


def _command(name: str, command: click.Command) -> str:
    """Return usage, meaning and options of a command."""
    context = click.Context(command, info_name=f"symgen {name}", show_default=True)
    usage = command.get_usage(context).removeprefix("Usage: ")
    choices = [p for p in command.params if isinstance(p, click.Option)]
    records = [p.get_help_record(context) for p in choices if p.name not in READING]
    rows = [(f"`{option}`", text) for option, text in records]
    if any(p.name in READING for p in choices):
        rows.append(("[options for logs](#options-for-logs)", "how to read the logs"))
    text = f"### {name}\n```text\n{usage}\n```\n\n{inspect.cleandoc(command.help or '')}"
    return f"{text}\n\n{table(('option', 'meaning'), rows)}" if rows else text


def fields(file: str) -> str:
    """Return the keys of a result file, with their types, from the classes that are written."""
    module, name = RESULTS[file]
    kind = getattr(import_module(module), name)
    schema = import_module(module).SCHEMA
    rows = [("`schema`", "text", f"`{schema}`"), *_fields(kind, "")]
    return table(("key", "type", "meaning"), rows)


def _fields(kind: Any, prefix: str) -> Iterator[tuple[str, str, str]]:
    """Yield key, type and meaning of each field of a class, and of those inside it."""
    meanings = _meanings(kind)
    for name, path, hint in _keys(kind):
        key = prefix + path
        yield f"`{key}`", _words(hint), meanings.get(name, "")
        inner, many = _inside(hint)
        if inner is not None and inner.__name__ not in _SHORT:
            yield from _fields(inner, f"{key}[]." if many else f"{key}.")


def _keys(kind: Any) -> Iterator[tuple[str, str, Any]]:
    """Yield name, key and type of each field of a dataclass or a named tuple."""
    from symgen import schemas

    hints = get_type_hints(kind)
    if not is_dataclass(kind):
        yield from ((name, name, hint) for name, hint in hints.items())
        return
    for name, path, form, _ in schemas.fields_in_file(kind):
        yield name, ".".join(path), form.kind if form else hints[name]


#: Classes whose fields stand in a table of their own on the page.
_SHORT = ("Reason", "Residual", "Fault", "Band")


def shared(name: str) -> str:
    """Return the keys of a value that several files hold."""
    modules = ("symgen.estimation.values", "symgen.faults.fault", "symgen.estimation.band")
    kinds = (getattr(import_module(module), name, None) for module in modules)
    kind = next(k for k in kinds if k is not None)
    return table(("key", "type", "meaning"), _fields(kind, ""))


def _meanings(kind: Any) -> dict[str, str]:
    """Return the meanings of attributes that the docstrings of a class and its bases give."""
    found: dict[str, str] = {}
    for base in reversed(kind.__mro__):
        _, _, listed = (base.__doc__ or "").partition("Attributes:\n")
        for match in ATTRIBUTE.finditer(re.sub(r"^    ", "", listed, flags=re.M)):
            text = " ".join(match["text"].split()).rstrip(".").replace("None", "null")
            module = import_module(base.__module__)
            text = CONSTANT.sub(lambda m, module=module: _value(module, m[0]), text)
            found |= dict.fromkeys(match["names"].split(", "), text)
    return found


def _value(module: Any, name: str) -> str:
    """Return the value of a constant of a module, in words; the name where there is none."""
    value = getattr(module, name, name)
    if isinstance(value, tuple):
        return ", ".join(value)
    return f"{value:g}" if isinstance(value, float) else str(value)


def _inside(hint: Any) -> tuple[Any, bool]:
    """Return the class with fields inside a type, and whether it is in a list; None without."""
    origin = get_origin(hint)
    if origin is Annotated:
        return _inside(get_args(hint)[0])
    if origin in (Union, UnionType):
        return next((_inside(a) for a in get_args(hint) if _inside(a)[0]), (None, False))
    if origin is tuple:
        return _inside(get_args(hint)[0])[0], True
    return (hint, False) if is_dataclass(hint) or hasattr(hint, "_fields") else (None, False)


def _words(hint: Any) -> str:
    """Return a type in words."""
    origin, arguments = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return _words(arguments[0])
    if origin in (Union, UnionType):
        return " or ".join("null" if a is type(None) else _words(a) for a in arguments)
    if origin is tuple:
        inner = list(dict.fromkeys(_words(a) for a in arguments if a is not Ellipsis))
        return f"list of {' and '.join(inner)}"
    if origin is dict or is_dataclass(hint) or hasattr(hint, "_fields"):
        return "object"
    if origin is not None and "ndarray" in str(origin):
        return ARRAY
    return WORDS.get(getattr(hint, "__name__", ""), "text")


def kernels(_: str) -> str:
    """Return the kernels with inputs, outputs and meaning, group by group."""
    from symgen.codegen.definition import GRAVITY
    from symgen.codegen.kernels import DEFINITIONS

    groups = list(dict.fromkeys(d.group for d in DEFINITIONS))
    rows = []
    for d in sorted(DEFINITIONS, key=lambda d: groups.index(d.group)):
        inputs = ", ".join(a.name for a in d.inputs if a.name != GRAVITY)
        outputs = ", ".join(a.text for a in d.outputs)
        meaning = d.doc.format(linear="p", standard="standard_names in manifest.json")
        rows.append((d.group, f"`{d.name}({inputs})`", outputs, meaning))
    return table(("group", "function", "outputs", "meaning"), rows)


def examples(_: str) -> str:
    """Return title and picture of every example, with a link to its page."""
    out = []
    for script in sorted((DOCS / "examples").glob("*.py")):
        title = script.read_text("utf-8").removeprefix('"""').splitlines()[0]
        name = script.stem
        out.append(f"### [{title}](examples/{name}.md)\n")
        if (DOCS / "pictures" / f"{name}.svg").exists():
            out.append(f"[![{title}](pictures/{name}.svg)](examples/{name}.md)\n")
    return "\n".join(out)
<<<<<<< HEAD
=======


def figures(path: Path) -> Any:
    """Return the figures that a study or a benchmark wrote."""
    return json.loads(path.read_text("utf-8"))


def ns(time: float | None) -> str:
    """Return a time in ns, with three digits; nothing where it was not measured."""
    return "" if time is None else f"{float(f'{time:.3g}'):,g}"


def command_times(_: str) -> str:
    """Return the processor time of each command."""
    rows = (
        (f"`{name}`", f"{row['first']:g} s", f"{row['again']:g} s")
        for name, row in figures(BENCHMARKS / "commands.json").items()
    )
    return table(("command", "first run", "later runs"), rows)


def speed_of_calls(_: str) -> str:
    """Return times of a call, and of a sample among many, beside other tools."""
    ways = {"single": "one call", "CasADi C": "CasADi's C", "Pinocchio C++": "Pinocchio C++",
            "Pinocchio Python": "Pinocchio Python", "NumPy": "NumPy", "panels": "in panels",
            "rows": "in rows"}  # fmt: skip
    rows = (
        (f"`{kernel}`", *(ns(row.get(way)) for way in ways))
        for kernel, row in figures(BENCHMARKS / "speed.json")["in_cache"].items()
    )
    return table(("kernel", *ways.values()), rows)


def speed_of_panels(_: str) -> str:
    """Return how many times as fast a sample in panels is as a single call, by instruction set."""
    measured = figures(BENCHMARKS / "speed.json")["panels_in_c"]
    found: dict[str, dict[str, float]] = {}
    for name, row in measured.items():
        kernel, instructions = name.split(", ")
        found.setdefault(kernel, {})[instructions] = row["single"] / row["panels"]
    sets = list(next(iter(found.values())))
    rows = ((f"`{k}`", *(f"{row[s]:.1f}" for s in sets)) for k, row in found.items())
    return table(("kernel", *sets), rows)


def speed_of_large_trees(_: str) -> str:
    """Return times of a humanoid, beside Pinocchio's."""
    rows = (
        (
            f"`{kernel}`",
            ns(row["hot"]),
            f"{row['Pinocchio hot'] / row['hot']:.1f}",
            ns(row["cold"]),
            f"{row['Pinocchio cold'] / row['cold']:.2f}",
        )
        for kernel, row in figures(BENCHMARKS / "speed.json")["large_tree"].items()
    )
    return table(("kernel", "hot, ns", "times Pinocchio", "cold, ns", "times Pinocchio"), rows)


def growth(_: str) -> str:
    """Return how derivation and compilation grow with the number of joints."""
    rows = (
        (
            f"`{row['kernel']}`",
            str(row["joints"]),
            f"{row['statements']:,}",
            f"{row['derive_s']:.2f}",
            f"{row['generate_s']:.2f}",
            f"{row['compile_s']:.2f}",
            ns(row["ns"]),
        )
        for row in figures(BENCHMARKS / "growth.json")["rows"]
    )
    times = ("derive, s", "generate, s", "compile, s", "one call, ns")
    head = ("kernel", "joints", "statements", *times)
    return table(head, rows)


def million(_: str) -> str:
    """Return time and memory of the identification of a million samples."""
    rows = (
        (row["model"], f"{row['user']:.1f} s", f"{1000 * row['GB']:.0f} MB")
        for row in figures(BENCHMARKS / "million.json")["rows"]
    )
    return table(("model", "processor time", "peak memory"), rows)


def on_line_times(_: str) -> str:
    """Return time and memory of the identifiers and of the follower of a load."""
    parts = {"energy": "identifier, energy", "momentum": "identifier, momentum",
             "payload": "load of a gripper"}  # fmt: skip
    measured = figures(BENCHMARKS / "identifier.json")
    rows = []
    for name, title in parts.items():
        row = measured[f"{name}, this"]
        times = (f"{row[key]:.2g} µs" for key in ("median_us", "worst_us", "read_us"))
        rows.append((title, *times, f"{row['bytes'] / 1000:.0f} kB"))
    return table(("", "median step", "longest step", "read", "memory"), rows)


def damaged_files(_: str) -> str:
    """Return what the readers did with damaged files."""
    rows = (
        (
            reader,
            f"{row['inputs']:,}",
            str(row["faults"]),
            f"{100 * row['refused_share']:.0f} %",
            f"{row['slowest_s']:g} s",
        )
        for reader, row in figures(PROJECT / "tests/robustness/fuzz_figures.json").items()
    )
    return table(("reader", "files", "faults", "refused", "slowest"), rows)


def intervals(_: str) -> str:
    """Return how many 95 % intervals contain the true value, by kind of log and of parameter."""
    families = {"noise": "noise of the sensors only", "misfit": "and a torque that no model has",
                "effects": "and effects that the file lacks"}  # fmt: skip
    rows = []
    for family, row in figures(STUDIES / "intervals.json")["summary"].items():
        every = row.pop("all")
        lowest = min(row, key=lambda kind: row[kind]["held"])
        contained = (
            f"{100 * every['held']:.0f} % ({100 * every['low']:.0f} to {100 * every['high']:.0f})"
        )
        least = f"{100 * row[lowest]['held']:.0f} %, {lowest}"
        rows.append((families[family], str(every["parameters"]), contained, least))
    head = ("simulated logs", "intervals", "contain the true value", "lowest kind of parameter")
    return table(head, rows)


def spoiled(_: str) -> str:
    """Return what identify says of spoiled logs and robot files."""
    found = figures(STUDIES / "spoiled.json")["summary"]
    words = {
        "spoiled": "spoiled cases",
        "seeable": "which a fit by hand shows",
        "costly": "of these: the error on clean motion is more than 1.2 times as large",
        "costly_named": "of these: symgen names the fault",
        "costly_good": "of these: symgen still trusts the estimate",
        "wrong_reason": "spoiled cases with another reason than the fault",
        "clean": "cases that are not spoiled",
        "clean_good": "of these: trusted",
    }
    return table(("cases", "number"), ((word, str(found[key])) for key, word in words.items()))


def taken_out(_: str) -> str:
    """Return what diagnose names where a term is taken out of a robot file."""
    cases = figures(STUDIES / "taken_out.json")["cases"]
    rows = []
    for robot in dict.fromkeys(case["robot"] for case in cases):
        own = [case for case in cases if case["robot"] == robot]
        counted = [case for case in own if "named" in case]
        first = sum(case["found"] for case in counted)
        right = sum(case["found"] or case["answered"] for case in counted)
        rows.append((robot, *map(str, (len(own), len(counted), first, right))))
    head = (
        "robot",
        "terms",
        "that matter",
        "named first",
        "named first, or explained",
    )
    return table(head, rows)
>>>>>>> d2f28c89 (On-line identification: the load of a gripper, with its loop, its statuses and measured times)

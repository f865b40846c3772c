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
    "payload.json": ("symgen.identification.load_result", "Payload"),
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


def floating_kernels(_: str) -> str:
    """Return the kernels of a floating base with inputs, outputs and meaning."""
    from symgen.codegen.kernels import DEFINITIONS

    rows = []
    for d in (d.floating for d in DEFINITIONS if "floating" in d.bases):
        inputs = ", ".join(a.name for a in d.inputs)
        outputs = ", ".join(a.text for a in d.outputs)
        meaning = d.doc.format(linear="p", standard="standard_names in manifest.json")
        rows.append((f"`{d.name}({inputs})`", outputs, meaning))
    return table(("function", "outputs", "meaning"), rows)


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

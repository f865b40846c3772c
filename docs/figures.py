"""Tables of measured figures: what benchmarks and studies keep in files, as text in the pages.

    python docs/figures.py        writes the tables of every page again, from the files

A page has a table between <!-- figures: NAME --> and <!-- end of figures -->, which the function
NAME makes. `keep` writes the file of a benchmark or a study, and then the tables.
"""

from __future__ import annotations

import json
import os
import platform
import re
from collections.abc import Iterable, Iterator
from datetime import date
from pathlib import Path
from typing import Any

from inserts import table

DOCS = Path(__file__).resolve().parent
PROJECT = DOCS.parent
BENCHMARKS, STUDIES = PROJECT / "tests" / "benchmarks", PROJECT / "tests" / "studies"
SPEED, GROWTH, MILLION, COMMANDS, EXPORT, IDENTIFIER, FIRMWARE, GPU = (
    BENCHMARKS / f"{name}.json"
    for name in "speed growth million commands export identifier firmware gpu".split()
)
INTERVALS, SPOILED, TAKEN_OUT = (
    STUDIES / f"{name}.json" for name in ("intervals", "spoiled", "taken_out")
)
FUZZING = PROJECT / "tests" / "robustness" / "fuzz_figures.json"
END = "<!-- end of figures -->"
#: A table of figures in a page.
FIGURES = re.compile(
    rf"^(?P<begin><!-- figures: (?P<name>\w+) -->)$.*?^{END}$", re.MULTILINE | re.DOTALL
)
#: Digits of the figures in a file, and characters of a line.
DIGITS, WIDTH = 4, 200


def keep(path: Path, found: dict[str, Any]) -> None:
    """Write what a benchmark or a study found, with day and machine; then all tables."""
    path.write_text(text({"measured": measured(), **found}) + "\n", "utf-8")
    write()


def measured() -> str:
    """Return day and machine of a run."""
    about = Path("/proc/cpuinfo")
    names = re.findall(r"^model name\s*: (.*)$", about.read_text() if about.exists() else "", re.M)
    machine = names[0] if names else platform.processor() or platform.machine()
    return f"{date.today()}, {machine}, {os.cpu_count()} cores"


def text(value: Any, margin: str = "") -> str:
    """Return JSON with four digits; what fits into a line is one."""
    line = json.dumps(value)
    line = json.dumps(json.loads(line, parse_float=lambda x: float(f"{float(x):.{DIGITS}g}")))
    if len(line) <= WIDTH:
        return line
    inside = margin + " "
    if isinstance(value, dict):
        lines = [f"{inside}{json.dumps(key)}: {text(x, inside)}" for key, x in value.items()]
    else:
        lines = [inside + text(x, inside) for x in value]
    begin, end = line[0], line[-1]
    return "\n".join((begin, ",\n".join(lines), margin + end))


def pages() -> Iterator[Path]:
    """Yield the pages that have tables of figures."""
    for page in (PROJECT / "README.md", *sorted(DOCS.glob("*.md"))):
        if FIGURES.search(page.read_text("utf-8")):
            yield page


def filled(page: str) -> str:
    """Return the text of a page, with its tables from the files."""
    return FIGURES.sub(lambda m: f"{m['begin']}\n\n{globals()[m['name']]()}\n\n{END}", page)


def write() -> None:
    """Write the tables of every page."""
    for page in pages():
        page.write_text(filled(page.read_text("utf-8")), "utf-8")


def figures(path: Path) -> Any:
    """Return the figures that a study or a benchmark wrote."""
    return json.loads(path.read_text("utf-8"))


def dated(made: str, path: Path) -> str:
    """Return a table with a line on the run of its figures: day, machine, compiler."""
    found = figures(path)
    run = ", ".join(found[key] for key in ("measured", "compiler") if key in found)
    return f"{made}\n\nMeasured: {run}."


def ns(time: float | None) -> str:
    """Return a time in ns, with three digits; nothing where it was not measured."""
    return "" if time is None else f"{float(f'{time:.3g}'):,g}"


def command_times() -> str:
    """Return the processor time of each command."""
    rows = (
        (f"`{name}`", f"{row['first']:g} s", f"{row['again']:g} s")
        for name, row in figures(COMMANDS)["commands"].items()
    )
    return dated(table(("command", "first run", "later runs"), rows), COMMANDS)


def speed_of_calls() -> str:
    """Return times of a call, and of a sample among many, beside other tools."""
    ways = {"single": "one call", "CasADi C": "CasADi's C", "Pinocchio C++": "Pinocchio C++",
            "Pinocchio Python": "Pinocchio Python", "NumPy": "NumPy", "panels": "in panels",
            "rows": "in rows"}  # fmt: skip
    rows = (
        (f"`{kernel}`", *(ns(row.get(way)) for way in ways))
        for kernel, row in figures(SPEED)["in_cache"].items()
    )
    return dated(table(("kernel", *ways.values()), rows), SPEED)


def speed_of_panels() -> str:
    """Return how many times as fast a sample in panels is as a single call, by instruction set."""
    measured = figures(SPEED)["panels_in_c"]
    found: dict[str, dict[str, float]] = {}
    for name, row in measured.items():
        kernel, instructions = name.split(", ")
        found.setdefault(kernel, {})[instructions] = row["single"] / row["panels"]
    sets = list(next(iter(found.values())))
    rows = ((f"`{k}`", *(f"{row[s]:.1f}" for s in sets)) for k, row in found.items())
    return dated(table(("kernel", *sets), rows), SPEED)


def speed_of_large_trees() -> str:
    """Return times of a humanoid, beside Pinocchio's."""
    rows = (
        (
            f"`{kernel}`",
            ns(row["hot"]),
            f"{row['Pinocchio hot'] / row['hot']:.1f}",
            ns(row["cold"]),
            f"{row['Pinocchio cold'] / row['cold']:.2f}",
            ns(row["warm"]),
            f"{row['Pinocchio cold'] / row['warm']:.2f}",
        )
        for kernel, row in figures(SPEED)["large_tree"].items()
    )
    of_three = ("hot, ns", "cold, ns", "after NAME_warm, ns")
    head = ("kernel", *(word for way in of_three for word in (way, "times Pinocchio")))
    return dated(table(head, rows), SPEED)


def growth() -> str:
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
        for row in figures(GROWTH)["rows"]
    )
    times = ("derive, s", "generate, s", "compile, s", "one call, ns")
    head = ("kernel", "joints", "statements", *times)
    return dated(table(head, rows), GROWTH)


def gpu_registers() -> str:
    """Return registers of a thread and bytes of spills of NAME.cu, one X for all states."""
    measured = figures(GPU)
    rows = []
    for kernel in measured["kernels"]:
        cells = (measured["compiled"][way][kernel] for way in measured["compiled"])
        shown = (f"{used}, spills {spills:,}" if spills else str(used) for used, spills in cells)
        rows.append((f"`{kernel}`", *shown))
    return dated(table(("kernel", *measured["compiled"]), rows), GPU)


def gpu_rates() -> str:
    """Return evaluations a second on a GPU, warm and without transfers."""
    found = figures(GPU)["rates"]
    if not found:
        return "Not measured: no GPU was available."
    rows = (
        (row["tool"], row["kernel"], row["dtype"], f"{row['N']:,}", f"{row['rate']:.2g}",
         f"{row['GB_s']:.0f}")
        for row in found
    )  # fmt: skip
    head = ("tool", "kernel", "type", "N", "evaluations a second", "GB a second")
    return dated(table(head, rows), GPU)


def million() -> str:
    """Return time and memory of the identification of a million samples."""
    rows = (
        (row["model"], f"{row['user']:.1f} s", f"{1000 * row['GB']:.0f} MB")
        for row in figures(MILLION)["rows"]
    )
    return dated(table(("model", "processor time", "peak memory"), rows), MILLION)


def on_line_times() -> str:
    """Return time and memory of the identifiers and of the follower of a load."""
    parts = {"energy": "identifier, energy", "momentum": "identifier, momentum",
             "payload": "load of a gripper"}  # fmt: skip
    measured = figures(IDENTIFIER)
    rows = []
    for name, title in parts.items():
        row = measured[f"{name}, this"]
        times = (f"{row[key]:.2g} µs" for key in ("median_us", "worst_us", "read_us"))
        rows.append((title, *times, f"{row['bytes'] / 1000:.0f} kB"))
    made = table(("", "median step", "longest step", "read", "memory"), rows)
    return dated(made, IDENTIFIER)


def damaged_files() -> str:
    """Return what the readers did with damaged files."""
    rows = (
        (
            reader,
            f"{row['inputs']:,}",
            str(row["faults"]),
            f"{100 * row['refused_share']:.0f} %",
            f"{row['slowest_s']:g} s",
            row["date"],
        )
        for reader, row in figures(FUZZING)["readers"].items()
    )
    return table(("reader", "files", "faults", "refused", "slowest", "run on"), rows)


def intervals() -> str:
    """Return how many 95 % intervals contain the true value, by kind of log and of parameter."""
    families = {"noise": "noise of the sensors only", "misfit": "and a torque that no model has",
                "effects": "and effects that the file lacks"}  # fmt: skip
    rows = []
    for family, row in figures(INTERVALS)["summary"].items():
        every = row.pop("all")
        lowest = min(row, key=lambda kind: row[kind]["held"])
        contained = (
            f"{100 * every['held']:.0f} % ({100 * every['low']:.0f} to {100 * every['high']:.0f})"
        )
        least = f"{100 * row[lowest]['held']:.0f} %, {lowest}"
        rows.append((families[family], str(every["parameters"]), contained, least))
    head = ("simulated logs", "intervals", "contain the true value", "lowest kind of parameter")
    return dated(table(head, rows), INTERVALS)


def spoiled() -> str:
    """Return what identify says of spoiled logs and robot files."""
    found = figures(SPOILED)["summary"]
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
    rows = ((word, str(found[key])) for key, word in words.items())
    return dated(table(("cases", "number"), rows), SPOILED)


def taken_out() -> str:
    """Return what diagnose names where a term is taken out of a robot file."""
    rows = ((robot, *map(str, (len(own), *named(own)))) for robot, own in taken_out_cases().items())
    head = ("robot", "terms", "that matter", "named first", "named first, or explained")
    return dated(table(head, rows), TAKEN_OUT)


def taken_out_cases() -> dict[str, list[dict[str, Any]]]:
    """Return the terms that were taken out of the file of each robot."""
    found: dict[str, list[dict[str, Any]]] = {}
    for case in figures(TAKEN_OUT)["cases"]:
        found.setdefault(case["robot"], []).append(case)
    return found


def named(cases: Iterable[dict[str, Any]]) -> tuple[int, int, int]:
    """Return how many terms matter, how many are named first, and how many that or explained."""
    counted = [case for case in cases if "named" in case]
    first = sum(case["found"] for case in counted)
    return len(counted), first, sum(case["found"] or case["answered"] for case in counted)


def exported() -> str:
    """Return the errors of two files in MuJoCo."""
    rows = (
        (f"`{name}`", percent(row["position_error"]), f"{row['diverged']} of {row['windows']}")
        for name, row in figures(EXPORT)["files"].items()
    )
    head = ("file", "position error after 1 s", "windows that diverge")
    return dated(table(head, rows), EXPORT)


def firmware() -> str:
    """Return code and stack of functions on two microcontrollers."""
    rows = []
    for row in figures(FIRMWARE)["rows"]:
        arm, avr = (row[part] for part in ("cortex_m4", "atmega2560"))
        sizes = (f"{part[key]:,}" for part in (arm, avr) for key in ("code", "stack"))
        rows.append((row["robot"], str(row["joints"]), f"`{row['kernel']}`", *sizes))
    bytes_of = [f"{chip}, {part}" for chip in ("Cortex-M4", "AVR") for part in ("code", "stack")]
    head = ("robot", "joints", "function", *bytes_of)
    return dated(table(head, rows), FIRMWARE)


def in_short() -> str:
    """Return the figures of the README: at most ten."""
    speed, long = figures(SPEED), figures(MILLION)["rows"][0]
    calls, tree = speed["in_cache"], speed["large_tree"]["forward_dynamics_derivatives"]
    commands = figures(COMMANDS)["commands"]
    original, exported_file = figures(EXPORT)["files"].values()
    matter, first, explained = named(figures(TAKEN_OUT)["cases"])
    robots = " and ".join(taken_out_cases())
    inverse, forward = calls["inverse_dynamics"], calls["forward_dynamics"]
    (chain,) = (
        row
        for row in figures(GROWTH)["rows"]
        if (row["kernel"], row["joints"]) == ("forward_dynamics", 7)
    )
    compiled = sum(chain[f"{step}_s"] for step in ("derive", "generate", "compile"))
    peer, cold = "Pinocchio C++", "Pinocchio cold"
    rows = [
        ("inverse dynamics of a Panda, one call", *beside(inverse, "single", peer), SPEED),
        ("forward dynamics of a Panda, one call", *beside(forward, "single", peer), SPEED),
        ("derivatives of forward dynamics, 30 joints, in cache", *beside(tree, "hot"), SPEED),
        ("the same not in the cache, after `NAME_warm`", *beside(tree, "warm", cold), SPEED),
        ("forward dynamics of 7 joints derived and compiled", f"{compiled:.1f} s", "", GROWTH),
        ("`identify`, two joints, 10 s at 200 Hz", *later(commands["identify"]), COMMANDS),
        ("`diagnose`, the same", *later(commands["diagnose"]), COMMANDS),
        (
            "`identify`, 7 joints, a million samples",
            f"{long['user']:.1f} s",
            f"memory: {1000 * long['GB']:.0f} MB",
            MILLION,
        ),
        (
            "position error of an exported MJCF after 1 s in MuJoCo",
            percent(exported_file["position_error"]),
            f"the original: {percent(original['position_error'])}",
            EXPORT,
        ),
        (
            f"terms missing in the files of {robots} that `diagnose` names",
            f"{first} of {matter}",
            f"named or explained: {explained} of {matter}",
            TAKEN_OUT,
        ),
    ]
    head = ("what", "symgen", "beside it", "measured")
    return table(head, ((*row, figures(path)["measured"]) for *row, path in rows))


def beside(row: dict[str, float], way: str, other: str = "") -> tuple[str, str]:
    """Return the time of a call, and Pinocchio's."""
    other = other or f"Pinocchio {way}"
    return f"{ns(row[way])} ns", f"Pinocchio C++: {ns(row[other])} ns"


def later(row: dict[str, float]) -> tuple[str, str]:
    """Return the processor time of a command, and that of its first run."""
    return f"{row['again']:g} s", f"the first run: {row['first']:g} s"


def percent(share: float) -> str:
    """Return a share in percent, up to ten times."""
    return "over 1000 %" if share > 10 else f"{100 * share:.2g} %"


if __name__ == "__main__":
    write()

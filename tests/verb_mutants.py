"""A hundred faults in code that public verbs reach: who is seen before a change is seen after it.

    python tests/verb_mutants.py draw TREE    # a checkout of the code before the change
    python tests/verb_mutants.py try [NUMBER...] [--tree TREE] [--keep before|after]

`draw` runs the quick cases of behaviour.py on the code of TREE, notes which lines of symgen/ each
one runs, and draws places on these lines by SEED into robustness/verb_mutants.json. `try` puts each
fault, or those of some NUMBERS, into a copy of this checkout or of TREE, wherever its line now
stands, and shows it to the cases that reached it, the quickest first, until one answers otherwise:
it prints a line for each. `--keep` notes that case, "" for none, and "gone" where the line is.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mutants import changed, nodes_of, shown

PROJECT = Path(__file__).resolve().parents[1]
DRAWN = PROJECT / "tests" / "robustness" / "verb_mutants.json"
SEED, COUNT = "verbs 1", 100
#: Of behaviour.py, each a second or two: identify, diagnose's fleet, payload, static poses, study,
#: simulate, refusals.
CASES = ("drive", "fleet", "payload", "refused", "simulate", "simulated-1", "simulated-4",
         "simulated-9", "static", "study", "words")  # fmt: skip
#: A case that takes so many seconds with a fault in it counts as answering otherwise.
SECONDS = 300.0


def _copied(symgen: Path, folder: Path) -> Path:
    """Copy the code of a checkout, and the tests of this one, into a folder."""
    for source in (symgen / "symgen", symgen / "templates", PROJECT / "tests"):
        shutil.copytree(source, folder / source.name, ignore=shutil.ignore_patterns("__pycache__"))
    return folder


def _run(folder: Path, script: str, *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, folder / "tests" / script, *words],
        cwd=folder, capture_output=True, text=True, timeout=SECONDS,
        env={**os.environ, "PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1"},
    )  # fmt: skip


def _reach(case: str) -> None:
    """Run a case; print its seconds and the lines of symgen/ that it runs, by file."""
    root, lines = str(PROJECT / "symgen"), defaultdict(set)

    def line(frame: Any, event: str, _: Any) -> Any:
        if event == "line":
            lines[frame.f_code.co_filename].add(frame.f_lineno)
        return line

    def call(frame: Any, *_: Any) -> Any:
        return line if frame.f_code.co_filename.startswith(root) else None

    import behaviour

    begun = time.process_time()
    sys.settrace(call)
    behaviour.answers(case)
    sys.settrace(None)
    seconds = time.process_time() - begun
    found = {Path(f).relative_to(PROJECT).as_posix(): sorted(k) for f, k in lines.items()}
    print(json.dumps([seconds, found]))


def _function(tree: ast.Module, line: int) -> str:
    """Return the innermost function or class at a line, "" at the top."""
    inside = [
        n for n in ast.walk(tree)
        if isinstance(n, ast.FunctionDef | ast.ClassDef) and n.lineno <= line <= (n.end_lineno or 0)
    ]  # fmt: skip
    return max(inside, key=lambda n: n.lineno).name if inside else ""


def _mutant(source: str, k: int) -> tuple[dict[str, str], str]:
    """Return what changes at a node of a file, and the text of the changed file."""
    tree = ast.parse(source)
    node: Any = nodes_of(tree)[k]
    text, was = source.splitlines()[node.lineno - 1].strip(), shown(node)
    changed(node)
    return {"text": text, "was": was, "now": shown(node)}, ast.unparse(tree)


def draw(tree: Path) -> None:
    """Draw mutants of a checkout on lines that quick cases run, and keep them."""
    reached: dict[tuple[str, int], list[tuple[float, str]]] = defaultdict(list)
    with tempfile.TemporaryDirectory() as place:
        folder = _copied(tree, Path(place).resolve())
        for case in CASES:
            done = _run(folder, "verb_mutants.py", "reach", case)
            assert done.returncode == 0, done.stderr[-2000:]
            seconds, lines = json.loads(done.stdout)
            print(f"{case}: {seconds:.1f} s, {sum(map(len, lines.values()))} lines", flush=True)
            for file, numbers in lines.items():
                for number in numbers:
                    reached[file, number].append((seconds, case))
    places = []
    for file in sorted({file for file, _ in reached}):
        for k, node in enumerate(nodes_of(ast.parse((tree / file).read_text("utf-8")))):
            if (file, getattr(node, "lineno", 0)) in reached and changed(node):
                places.append((file, k, node.lineno))
    found = []
    for file, k, line in random.Random(SEED).sample(places, COUNT):
        source = (tree / file).read_text("utf-8")
        what, _ = _mutant(source, k)
        found.append({
            "file": file, "function": _function(ast.parse(source), line), "line": line, **what,
            "cases": [case for _, case in sorted(reached[file, line])],
        })  # fmt: skip
    content = {"seed": SEED, "places": len(places), "drawn": found}
    DRAWN.write_text(json.dumps(content, indent=1) + "\n", "utf-8")


def _now(tree: Path, wanted: dict[str, Any]) -> tuple[str, str]:
    """Return the file in which a mutant's line now stands, and its changed text; "" if nowhere.

    The file that it came from is looked at first, then all others.
    """
    files = sorted((tree / "symgen").rglob("*.py"))
    files.sort(key=lambda p: p.name != Path(wanted["file"]).name)
    for path in files:
        source = path.read_text("utf-8")
        texts = [line.strip() for line in source.splitlines()]
        if wanted["text"] not in texts:
            continue
        for k, node in enumerate(nodes_of(ast.parse(source))):
            line = getattr(node, "lineno", 0)
            if line and texts[line - 1] == wanted["text"] and changed(node):
                what, text = _mutant(source, k)
                if (what["was"], what["now"]) == (wanted["was"], wanted["now"]):
                    return path.relative_to(tree).as_posix(), text
    return "", ""


def tried(tree: Path, wanted: list[dict[str, Any]]) -> Iterator[tuple[str, str]]:
    """Yield where mutants stand in a checkout, and the case that sees them, "" where none does."""
    unchanged: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as place:
        folder = _copied(tree, Path(place).resolve())
        for m in wanted:
            file, text = _now(tree, m)
            seen = (case for case in m["cases"] if _sees(folder, file, text, case, unchanged))
            yield file, next(seen, "") if file else "gone"


def _sees(folder: Path, file: str, text: str, case: str, unchanged: dict[str, Any]) -> bool:
    """Return whether a case answers otherwise, or not in time, with the text of a file changed."""
    if case not in unchanged:
        unchanged[case] = json.loads(_run(folder, "verb_mutants.py", "answer", case).stdout)
    original = (folder / file).read_text("utf-8")
    (folder / file).write_text(text, "utf-8")
    try:
        done = _run(folder, "verb_mutants.py", "answer", case)
    except subprocess.TimeoutExpired:
        return True
    finally:
        (folder / file).write_text(original, "utf-8")
    if done.returncode != 0:
        return True
    import behaviour

    return behaviour.differences(unchanged[case], json.loads(done.stdout)) != []


def main() -> None:
    """Draw, or try."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=("draw", "try", "reach", "answer"))
    parser.add_argument("of", nargs="*")
    parser.add_argument("--tree", type=Path, default=PROJECT)
    parser.add_argument("--keep", choices=("before", "after"))
    asked = parser.parse_args()
    if asked.what == "draw":
        draw(Path(asked.of[0]).resolve())
    elif asked.what == "reach":
        _reach(asked.of[0])
    elif asked.what == "answer":
        import behaviour

        print(json.dumps(behaviour.answers(asked.of[0])))
    else:
        content = json.loads(DRAWN.read_text("utf-8"))
        numbers = [int(k) for k in asked.of] or range(len(content["drawn"]))
        wanted = [content["drawn"][k] for k in numbers]
        for k, m, found in zip(numbers, wanted, tried(asked.tree.resolve(), wanted), strict=True):
            print(
                f"{k}: {found[0]}: {m['was']} -> {m['now']}: {found[1] or 'survives'}", flush=True
            )
            if asked.keep:
                m[asked.keep] = found[1]
                DRAWN.write_text(json.dumps(content, indent=1) + "\n", "utf-8")


if __name__ == "__main__":
    main()

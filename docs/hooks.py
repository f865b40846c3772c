"""Hooks of MkDocs: pages from scripts, and equations that need no network.

.mkdocs.yml uses them.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parent


def literate(script: Path) -> str:
    """Return a script as a page: docstring and comments at the margin become text.

    The file of the same name that ends in .txt holds the output of the script, and the one in
    docs/pictures that ends in .svg its picture; tests compare both.
    """
    head, _, rest = script.read_text("utf-8").removeprefix('"""').partition('"""\n')
    out, code = ["# " + head.strip()], list[str]()

    def flush() -> None:
        block = "\n".join(code).strip("\n")
        if block:
            out.append(f"```python\n{block}\n```")
        code.clear()

    for part in rest.split("\n\n"):
        lines = part.strip("\n").splitlines()
        if lines and all(line.startswith("#") for line in lines):
            flush()
            out.append("\n".join(line.removeprefix("#").removeprefix(" ") for line in lines))
        else:
            code += [part, ""]
    flush()
    printed = script.with_suffix(".txt").read_text("utf-8")
    out.append(f"## Output\n```text\n{printed}```")
    picture = Path("pictures") / f"{script.stem}.svg"
    title = re.search(r"<title>(.*?)</title>", (DOCS / picture).read_text("utf-8"))
    out.append(f"![{title[1] if title else ''}](../{picture.as_posix()})")
    out.append(f"This page is the script `docs/examples/{script.name}`. The tests run it.")
    return "\n\n".join(out) + "\n"


def equation(source: str, *_: Any, **__: Any) -> str:
    """Return an equation in LaTeX as MathML, which browsers draw by themselves."""
    from latex2mathml.converter import convert

    rows = (convert(line, display="block") for line in source.strip().split("\n\n"))
    return f'<div class="equation" style="overflow-x: auto">{"".join(rows)}</div>'


def on_config(config: Any) -> Any:
    """Draw ```math as equations, and add the threat model, whatever the name of its file."""
    fence = {"name": "math", "class": "math", "format": equation}
    config.mdx_configs.setdefault("pymdownx.superfences", {})["custom_fences"] = [fence]
    explanation = config.nav[-1]["Explanation"]
    explanation.extend({"Threat model": p.name} for p in sorted(DOCS.glob("threat?model.md")))
    return config


def on_files(files: Any, config: Any) -> Any:
    """Add a page for every script in docs/examples."""
    from mkdocs.structure.files import File

    for script in sorted((DOCS / "examples").glob("*.py")):
        name = f"examples/{script.stem}.md"
        files.append(File.generated(config, name, content=literate(script)))
    return files

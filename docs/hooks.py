"""Hooks of MkDocs: pages from scripts, tables from code, equations without a network.

.mkdocs.yml uses them. A page has a comment such as <!-- insert: options -->; docs/inserts.py makes
the text that stands there.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parent
#: What a page takes from docs/inserts.py: <!-- insert: NAME ARGUMENT -->
INSERT = re.compile(r"^<!-- insert: (?P<name>\w+) ?(?P<argument>\S*) -->$", re.M)
#: A link to an example where there is one: <!-- example: NAME -->
EXAMPLE = re.compile(r"^<!-- example: (?P<name>\w+) -->$", re.M)
#: A link to the script of an example, which has a page on the site.
SCRIPT = re.compile(r"\]\(examples/(?P<name>\w+)\.py\)")


def literate(script: Path) -> str:
    """Return a script as a page: docstring and comments at the margin become text.

    The file of the same name that ends in .txt holds the output of the script. The one in
    docs/pictures that ends in .svg is its picture, if it has one. Tests compare both.
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
    if (DOCS / picture).exists():
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
    """Draw ```math as equations, and list the examples in the contents of the site."""
    fence = {"name": "math", "class": "math", "format": equation}
    config.mdx_configs.setdefault("pymdownx.superfences", {})["custom_fences"] = [fence]
    start = config.nav[0]["Start"]
    pages = [f"examples/{script.stem}.md" for script in sorted((DOCS / "examples").glob("*.py"))]
    start[-1] = {"Examples": ["examples.md", *pages]}
    return config


def on_files(files: Any, config: Any) -> Any:
    """Add a page for every script in docs/examples."""
    from mkdocs.structure.files import File

    for script in sorted((DOCS / "examples").glob("*.py")):
        name = f"examples/{script.stem}.md"
        files.append(File.generated(config, name, content=literate(script)))
    return files


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Put tables and examples where a page asks for them, and link to pages of examples."""
    markdown = EXAMPLE.sub(lambda m: example(m["name"]), markdown)
    markdown = SCRIPT.sub(r"](examples/\g<name>.md)", markdown)
    if not INSERT.search(markdown):
        return markdown
    sys.path.insert(0, str(DOCS))
    try:
        import inserts
    finally:
        sys.path.remove(str(DOCS))
    return INSERT.sub(lambda m: getattr(inserts, m["name"])(m["argument"]), markdown)


def example(name: str) -> str:
    """Return a link to an example, with its title; nothing where there is no such example."""
    script = DOCS / "examples" / f"{name}.py"
    if not script.exists():
        return ""
    title = script.read_text("utf-8").removeprefix('"""').splitlines()[0]
    return f"**Example:** [{title}](examples/{name}.md)"

"""The documentation builds without a warning, and what its pages show runs as they say."""

from __future__ import annotations

import importlib.util
import io
import re
import shutil
import subprocess
import sys
from contextlib import redirect_stdout
from html import unescape
from pathlib import Path

import figures
import inserts
import pytest
from browser import BROWSER, seen_on_a_phone, visit
from documented import (
    DOCS,
    EXAMPLES,
    PAGES,
    SHOWN,
    Block,
    assert_quoted,
    assert_same_output,
    blocks,
    shell,
)
from support import PROJECT
from workshop import furnish, house

_NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]\d+)?")
#: Pages that a reader follows in an empty folder; each has a picture of what its commands write.
_TUTORIALS = [
    DOCS / f"{name}.md"
    for name in (
        "quick-start",
        "tutorial-controller",
        "tutorial-diagnose",
        "tutorial-hobby",
        "tutorial-simulator",
    )
]
_PICTURES = DOCS / "pictures"
_RUN = [
    p
    for p in PAGES
    if p not in _TUTORIALS and any(b.kind not in SHOWN and not b.elsewhere for b in blocks(p))
]
#: Pages that are made from code, with tables of many screens.
_LONG = ("commands", "json", "reference")
_SLOW_EXAMPLES = set(
    "hidden_spring intervals online_identifier paper_1988 payload planned_motion prior "
    "two_links wrong_sign".split()
)
_DRAWN = re.compile(r'<div class="equation"([^>]*)>(.*?)</div>', re.S)
#: A script of the tests with what follows it, as pages name it.
_SCRIPT = re.compile(r"(?:python|pytest)[^`\n]*? (?P<script>tests/[\w/]+\.py)(?P<options>[^`\n]*)")
#: A file of the code or of the tests, as pages name it.
_SOURCE = re.compile(r"`((?:symgen|tests|docs|robot|symbolic|codegen|runtime|data|faults|estimation"
                     r"|hypotheses|identification|diagnosis|experiment|report|templates)"
                     r"/[\w./-]+\.(?:py|toml|json|ipynb))`")  # fmt: skip
_INSERT = re.compile(r"^<!-- insert: (\w+) ?(\S*) -->$", re.M)
_FENCE = re.compile(r"^```.*?^```$", re.M | re.S)
#: How a section ends: a sentence, a table, a block, a picture, an insert, or entries of names.
_ENDS = re.compile(
    r"([.!?]\)?|\||\(block\)|<!-- (?:(?:insert|example): .*|end of figures) -->"
    r"|!\[[^\]]*\]\([^)]*\)|^:::.*(\n +.*)*)\Z",
    re.M,
)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The documentation as MkDocs builds it, without a warning."""
    if importlib.util.find_spec("mkdocs") is None or importlib.util.find_spec("material") is None:
        pytest.skip("mkdocs-material is not installed (pip install -e '.[docs]')")
    into = tmp_path_factory.mktemp("site")
    done = _mkdocs(PROJECT / ".mkdocs.yml", into)
    assert done.returncode == 0, done.stdout + done.stderr
    return into


def _mkdocs(settings: Path, into: Path) -> subprocess.CompletedProcess[str]:
    """Build a site; a warning is an error, unless --quiet is there too."""
    return subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "-f", settings, "--site-dir", into],
        cwd=PROJECT, capture_output=True, text=True,
    )  # fmt: skip


@pytest.mark.usefixtures("site")
def test_broken_links_stop_the_build(tmp_path: Path) -> None:
    """With the settings and the command that build the site, on a page of its own."""
    settings, pages = tmp_path / "mkdocs.yml", tmp_path / "pages"
    settings.write_text(
        f"INHERIT: {PROJECT / '.mkdocs.yml'}\nhooks: []\nnav: [index.md]\ndocs_dir: {pages}\n"
    )
    pages.mkdir()
    (pages / "index.md").write_text("# Page\n[one](missing.md), [another](index.md#nowhere)\n")
    done = _mkdocs(settings, tmp_path / "site")
    assert done.returncode == 1, done.stderr
    assert "missing.md" in done.stderr
    assert "#nowhere" in done.stderr


def test_pages_of_the_site_ask_for_nothing_from_elsewhere(site: Path) -> None:
    for page in ("index.html", "reference.html", "json.html", "examples/two_links.html"):
        text = (site / page).read_text("utf-8")
        assert not re.search(r'(?:src|href)="(?:https?:)?//(?!squidfunk)', text), page


def test_a_reader_sees_equations_and_not_their_source(site: Path) -> None:
    """Neither "&" nor a command of LaTeX, in what a browser draws or shows under the pointer."""
    equations = [b.code for page in PAGES for b in blocks(page) if b.kind == "math"]
    drawn = [m for page in site.rglob("*.html") for m in _DRAWN.findall(page.read_text("utf-8"))]
    assert len(drawn) >= len(equations) > 0
    for attributes, inside in drawn:
        seen = attributes + unescape(re.sub("<[^>]*>", " ", inside))
        assert not re.search(r"[&\\]", seen), seen


@pytest.mark.skipif(BROWSER is None, reason="no chromium, google-chrome or chrome is installed")
@pytest.mark.parametrize(
    "pages", ["a-l", "m-z", pytest.param("examples and long ones", marks=pytest.mark.slow)]
)
def test_nothing_on_a_page_is_clipped_on_a_phone(site: Path, tmp_path: Path, pages: str) -> None:
    """At 390 px no page scrolls sideways, and none shows markup in place of an equation."""
    written = sorted(f"{page.stem}.html" for page in DOCS.glob("*.md") if page.stem not in _LONG)
    first = [name for name in written if name < "m"]
    others = [f"{stem}.html" for stem in _LONG] + [f"examples/{p.stem}.html" for p in EXAMPLES]
    names = {"a-l": first, "m-z": written[len(first) :]}.get(pages, others)
    seen = seen_on_a_phone(site, tmp_path, names)
    assert set(names) == set(seen)
    assert {width for width, _ in seen.values()} == {390}
    assert not {page: wrong for page, (_, wrong) in seen.items() if wrong}


@pytest.mark.slow
@pytest.mark.skipif(BROWSER is None, reason="no chromium, google-chrome or chrome is installed")
def test_the_search_works_from_a_folder(site: Path, tmp_path: Path) -> None:
    """A browser that reaches no host finds pages of a site that it opens without a server."""
    found = f"{(site / 'index.html').as_uri()}?q=backlash"
    seen = visit(f"<meta http-equiv='refresh' content='0;url={found}'>", tmp_path)
    assert "matching documents" in seen.dom
    assert not seen.requests


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.stem)
def test_every_section_ends_in_a_full_sentence(page: Path) -> None:
    text = _FENCE.sub("(block)", page.read_text("utf-8"))
    for section in re.split(r"^#+ .*$", text, flags=re.M):
        assert not section.strip() or _ENDS.search(section.rstrip()), section[-200:]
    assert "&" not in re.sub("`[^`]*`", "", text)  # an alignment stands in an equation alone


@pytest.fixture(scope="module")
def workshop(tmp_path_factory) -> Path:
    """An arm, its logs and its estimate: made once, copied for every page."""
    folder = tmp_path_factory.mktemp("workshop")
    furnish(folder)
    return folder


@pytest.mark.parametrize("page", _RUN, ids=lambda p: p.stem)
def test_blocks_run(page: Path, workshop: Path, tmp_path: Path, monkeypatch) -> None:
    _run(page, [b for b in blocks(page) if not b.slow], workshop, tmp_path / "here", monkeypatch)


@pytest.mark.slow
@pytest.mark.parametrize(
    "page", [p for p in _RUN if any(b.slow for b in blocks(p))], ids=lambda p: p.stem
)
def test_slow_blocks_run_too(page: Path, workshop: Path, tmp_path: Path, monkeypatch) -> None:
    _run(page, list(blocks(page)), workshop, tmp_path / "here", monkeypatch)


@pytest.mark.slow
@pytest.mark.parametrize("page", _TUTORIALS, ids=lambda p: p.stem)
def test_a_tutorial_runs_in_an_empty_folder_and_shows_what_it_makes(
    page: Path, tmp_path: Path, monkeypatch
) -> None:
    empty = tmp_path / "empty"
    empty.mkdir()
    folder = tmp_path / "here"
    _run(page, list(blocks(page)), empty, folder, monkeypatch)
    name = page.stem.replace("-", "_")
    assert f"](pictures/{name}.svg)" in page.read_text("utf-8")
    _same_picture(name, folder)


def _run(page: Path, found: list[Block], workshop: Path, folder: Path, monkeypatch) -> None:
    """Run the blocks of a page in their order, in one folder; Python's share their names.

    A block of output is compared with what the block before it prints.
    """
    shutil.copytree(workshop, folder)
    if page.stem == "contributing":
        house(folder)
    monkeypatch.chdir(folder)
    names: dict[str, object] = {"__name__": "__main__"}
    printed = ""
    for block in found:
        where = f"{page.name}:{block.line}"
        if block.elsewhere or block.missing:
            continue
        if block.kind == "output":
            assert_quoted(block.code, printed)
        elif block.kind in SHOWN:
            continue
        elif block.file:
            (folder / block.file).write_text(block.code, encoding="utf-8")
        elif block.kind == "sh":
            done = shell(block.code, folder)
            printed = f"{where}\n{done.stdout}{done.stderr}"
            assert done.returncode == block.code_expected, printed
        elif block.kind == "python":
            with redirect_stdout(io.StringIO()) as stream:
                exec(compile(block.code, where, "exec", dont_inherit=True), names)
            printed = stream.getvalue()
        else:
            pytest.fail(f"{where}: a block of {block.kind} that is neither a file nor run")


@pytest.mark.parametrize(
    "script",
    [
        pytest.param(p, marks=[pytest.mark.slow] * (p.stem in _SLOW_EXAMPLES), id=p.stem)
        for p in EXAMPLES
    ],
)
def test_an_example_prints_what_its_page_shows(script: Path, tmp_path: Path) -> None:
    """The same words, every number within 2 % of what the page shows, and its picture if any."""
    drawn = _PICTURES / script.name
    done = shell(f"python {drawn if drawn.exists() else script}", tmp_path)
    assert done.returncode == 0, done.stderr
    assert_same_output(done.stdout, script.with_suffix(".txt").read_text("utf-8"))
    if drawn.exists():
        _same_drawing(script.stem, tmp_path)


PRINTED = "torque error: 1.27 %\njoint 3  39.7 %  1.89 N m\nnote: 15 of 22"


@pytest.mark.parametrize("quotation", ["torque error: 1.28 %\n...\nnote: 15 of 22", "3 39.5 % ..."])
def test_a_quotation_leaves_out_lines_and_may_differ_by_two_percent(quotation: str) -> None:
    assert_quoted(quotation, PRINTED)


@pytest.mark.parametrize(
    "quotation", ["torque error: 1.39 %", "joint 2 39.7 %", "note: 15 of 22 ... joint 3", "a note"]
)
def test_a_quotation_that_was_not_printed_is_refused(quotation: str) -> None:
    with pytest.raises(AssertionError):
        assert_quoted(quotation, PRINTED)


def test_every_page_is_in_the_table_of_contents() -> None:
    contents = (PROJECT / ".mkdocs.yml").read_text("utf-8")
    for page in (PROJECT / "docs").glob("*.md"):
        assert f" {page.name}\n" in contents or f" {page.name}  #" in contents, page


def test_every_page_can_be_reached_from_the_readme() -> None:
    readme = (PROJECT / "README.md").read_text("utf-8")
    for page in DOCS.glob("*.md"):
        own = page.stem in ("index", "examples", "reference")  # the README, its folder, Python
        assert own or f"](docs/{page.name})" in readme, page


def test_tables_of_figures_are_those_of_the_files() -> None:
    """`python docs/figures.py` writes them; the README has one table of ten at most."""
    shown = {page: page.read_text("utf-8") for page in PAGES}
    assert {page for page in PAGES if "| --- |" in shown[page]} == set(figures.pages())
    for page in figures.pages():
        assert figures.filled(shown[page]) == shown[page], page
    (short,) = figures.FIGURES.finditer(shown[PROJECT / "README.md"])
    assert short[0].count("\n| ") <= 2 + 10


def test_tables_of_code_are_made() -> None:
    """Each insert of a page gives a table."""
    for page in PAGES:
        for name, argument in _INSERT.findall(page.read_text("utf-8")):
            assert getattr(inserts, name)(argument).count("|") > 4 or name == "examples", name


def test_fields_and_options_are_those_of_the_code() -> None:
    fields = inserts.fields("estimate.json")
    assert "| `uses.prediction.grade` | text |" in fields
    assert "| `parameters[].relative_std_percent` | number |" in fields
    options = inserts.options("")
    assert "### identify" in options
    assert "`--accept FLOAT RANGE`" in options
    assert options.count("`--time-unit TEXT`") == 1


def test_tutorials_have_pictures_and_pictures_have_scripts() -> None:
    """Their own tests compare them with what their scripts draw."""
    tutorials = {p.stem.replace("-", "_") for p in _TUTORIALS}
    drawn = {p.stem for p in _PICTURES.glob("*.svg")}
    assert tutorials <= drawn <= tutorials | {p.stem for p in EXAMPLES}
    assert drawn <= {p.stem for p in _PICTURES.glob("*.py")}


def test_pictures_of_reports_are_small_and_a_script_takes_them() -> None:
    script = (_PICTURES / "screenshots.py").read_text("utf-8")
    texts = [page.read_text("utf-8") for page in PAGES]
    for picture in _PICTURES.glob("*.webp"):
        assert f'"{picture.name}"' in script, picture
        assert any(f"pictures/{picture.name})" in text for text in texts), picture
        assert picture.stat().st_size < 150_000, picture


def _same_picture(name: str, folder: Path) -> None:
    """Draw a picture from what is in a folder, and compare it with the one that pages show."""
    done = shell(f"python {_PICTURES / name}.py {folder}", folder)
    assert done.returncode == 0, done.stderr
    _same_drawing(name, folder)


def _same_drawing(name: str, folder: Path) -> None:
    """Compare a picture in a folder with the one that pages show: lines to a pixel, words."""
    drawn, shown = ((at / f"{name}.svg").read_text("utf-8") for at in (folder, _PICTURES))
    assert _NUMBER.sub("#", drawn) == _NUMBER.sub("#", shown), name
    points = zip(_NUMBER.findall(drawn), _NUMBER.findall(shown), strict=True)
    assert max(abs(float(got) - float(want)) for got, want in points) <= 1  # pixel


def test_pages_docstrings_and_templates_have_no_misspelled_word() -> None:
    """Codespell knows common misspellings; pyproject.toml lists the names that it takes for one."""
    if importlib.util.find_spec("codespell_lib") is None:
        pytest.skip("codespell is not installed (pip install -e '.[docs]')")
    read = ("docs", "symgen", "templates", "README.md", "CHANGELOG.md")
    done = subprocess.run(
        [sys.executable, "-m", "codespell_lib", "--skip", "*.svg,*.webp", *read],
        cwd=PROJECT, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.stem)
def test_scripts_that_a_page_names_exist_and_have_its_options(page: Path) -> None:
    for command in _SCRIPT.finditer(page.read_text("utf-8")):
        script = PROJECT / command["script"]
        assert script.exists(), command[0]
        for option in re.findall("--[a-z-]+", command["options"]):
            assert option in script.read_text("utf-8"), command[0]


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.stem)
def test_files_of_the_code_that_a_page_names_exist(page: Path) -> None:
    """Of the project, or of symgen/; placeholders such as NAME and generated files aside."""
    for name in _SOURCE.findall(page.read_text("utf-8")):
        assert (PROJECT / name).exists() or (PROJECT / "symgen" / name).exists(), name


def test_links_of_the_readme_lead_somewhere() -> None:
    text = (PROJECT / "README.md").read_text("utf-8")
    for target in re.findall(r"\]\(([^)#]+)[^)]*\)", text) + re.findall(r'src="([^"]+)"', text):
        assert (PROJECT / target).exists(), target


def test_install_and_test_commands_are_those_of_ci() -> None:
    ci = (PROJECT / ".ci" / "run").read_text("utf-8").replace("[test,docs,jax]", "[test]")
    readme = (PROJECT / "README.md").read_text("utf-8")
    start, test = (b.code.strip() for b in blocks(PROJECT / "README.md") if ".venv" in b.code)
    assert test in ci
    assert start in (PROJECT / "docs" / "index.md").read_text("utf-8")
    assert start in readme

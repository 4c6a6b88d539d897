"""The reference site is built without a warning, is whole, and needs no network."""

import importlib.util
import json
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest

import elastic_tendon as et
from site_pages.law import typeset

ROOT = Path(__file__).parents[1]
NEEDED = ("sphinx", "myst_parser", "numpydoc", "furo")
EFFECTS = [effect.id for effect in et.effects.CATALOGUE]
PAGES = (
    "index",
    "which_tool",
    "servo_friction",
    "known_machines",
    "importers",
    "ARCHITECTURE",
    "decisions/index",
    "commands",
    "equations",
    "search",
)
CONTRACTS = ("model", "measurements", "fmu", "comparison", "diagnosis")

needs_sphinx = pytest.mark.skipif(
    not all(map(importlib.util.find_spec, NEEDED)), reason="the extra docs is not installed"
)


@pytest.fixture
def site(tmp_path) -> Path:
    """Built by the script, which also follows every link."""
    script = ROOT / "build_scripts" / "build_site.py"
    run = subprocess.run([sys.executable, script, tmp_path], capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr
    return tmp_path


class Loaded(HTMLParser):
    """What a browser fetches by itself."""

    def __init__(self, page: Path) -> None:
        super().__init__()
        self.addresses: list[str] = []
        self.feed(page.read_text())

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        fetched = {"src", "srcset", "data", "poster"} | ({"href"} if tag == "link" else set())
        self.addresses += [value or "" for name, value in attrs if name in fetched]


@needs_sphinx
def test_the_site_is_whole_and_needs_no_network(site) -> None:
    """One test, since the site is built for it: some twenty seconds."""
    check_nothing_is_loaded_from_the_network(site)
    check_every_public_name_has_an_entry(site)
    check_every_effect_has_a_page_with_law_and_picture(site)
    check_what_else_is_there(site)


def check_nothing_is_loaded_from_the_network(site: Path) -> None:
    pages = list(site.rglob("*.html"))
    loaded = {address for page in pages for address in Loaded(page).addresses}
    assert len(pages) > 50
    assert not [address for address in loaded if re.match(r"(https?:)?//", address)]
    for style in site.rglob("*.css"):
        assert not re.search(r"(url\(|@import)\s*['\"]?(https?:)?//", style.read_text()), style


def check_every_public_name_has_an_entry(site: Path) -> None:
    pages = "".join(page.read_text() for page in (site / "reference").glob("*.html"))
    anchors = set(re.findall(r'id="([^"]+)"', pages))
    assert {f"elastic_tendon.{name}" for name in et.__all__} <= anchors


def check_every_effect_has_a_page_with_law_and_picture(site: Path) -> None:
    for effect in EFFECTS:
        page = (site / "effects" / f"{effect}.html").read_text()
        assert "<math" in page, effect
        assert f"_images/{effect}.svg" in page, effect
        assert (site / "_images" / f"{effect}.svg").stat().st_size > 10_000, effect


def check_what_else_is_there(site: Path) -> None:
    for page in (*PAGES, *(f"contracts/{name}" for name in CONTRACTS)):
        assert (site / f"{page}.html").is_file(), page
    assert (site / "searchindex.js").stat().st_size > 10_000
    assert "ELASTIC_TENDON_CC" in (site / "guide_set_up.html").read_text()
    for folder in (ROOT / "examples").iterdir():
        assert not folder.is_dir() or (site / "examples" / folder.name / "README.html").is_file()


@needs_sphinx
def test_faults_of_a_site_are_found(tmp_path) -> None:
    from build_site import problems

    (tmp_path / "a.html").write_text('<p id="here"><a href="#here">x</a><a href="b.html">x</a>')
    assert list(problems(tmp_path)) == ["a.html: b.html is not there"]
    (tmp_path / "b.html").write_text(
        '<a href="a.html#there">x</a><a href="https://example.org">x</a>'
        '<script src="//cdn.example.org/x.js"></script>'
    )
    (tmp_path / "c.css").write_text("@import 'https://example.org/font.css'")
    assert list(problems(tmp_path)) == [
        "b.html loads //cdn.example.org/x.js",
        "b.html: a.html#there is no place of that page",
        "c.css loads https://example.org/font.css",
    ]


def test_a_notebook_becomes_text_and_code(tmp_path) -> None:
    from site_pages.guides import from_notebook

    cells = [
        {"cell_type": "markdown", "source": ["# First steps\n", "Load a model."]},
        {"cell_type": "code", "source": ["import elastic_tendon"]},
    ]
    (tmp_path / "steps.ipynb").write_text(json.dumps({"cells": cells}))
    shown = from_notebook(tmp_path / "steps.ipynb")
    assert shown.startswith("## First steps\nLoad a model.\n\n")
    assert "python\nimport elastic_tendon\n" in shown


@pytest.mark.parametrize("effect", et.effects.CATALOGUE, ids=lambda effect: effect.id)
def test_a_typeset_law_says_what_the_law_says(effect) -> None:
    lines = typeset(effect.law, [parameter.name for parameter in effect.parameters])
    shown = " ".join(lines).replace(r"\displaystyle", "").replace("{math}", "")
    shown = re.sub(r"\\(text|operatorname|left|right|frac|[,; ])", "", shown)
    shown = shown.replace(r"\theta", "θ").replace(r"\tau", "τ").replace(r"\pm", "±")
    shown = shown.replace(r"\prime", "'").replace("\\", "")
    law = effect.law.translate(str.maketrans("²³", "23"))
    # without what only arranges: fractions, powers, brackets, the signs between equations
    only = re.compile(r"[\s/^(){}_`,;]")
    assert only.sub("", shown) == only.sub("", law)


def test_fractions_and_powers_are_typeset() -> None:
    assert typeset("c' = (e - c) / tau_1; rest where q > upper²", ["upper"]) == [
        r"{math}`\displaystyle c^{\prime } =\frac{e -c }{\text{tau_1}\,}`",
        r"rest where {math}`\displaystyle q >\text{upper}\,^{2}`",
    ]

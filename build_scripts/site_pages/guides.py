"""What is written for people already, as pages: README, architecture, examples, commands."""

import ast
import inspect
import json
import re
import shutil
from pathlib import Path

import typer
from typer.cli import get_docs_for_click
from typer.main import get_command

from elastic_tendon.cli import app
from elastic_tendon.native import compiler
from elastic_tendon.native.library import cache_folder
from site_pages import Pages
from site_pages.markdown import code, from_rst, sidebar

ROOT = Path(__file__).resolve().parents[2]
TEXTS = ROOT / "fmu_src"
REFERENCE = (
    *("effects/index", "equations", "reference/index", "commands", "contracts/index"),
    "examples/index",
)
ABOUT = ("known_machines", "servo_friction", "which_tool", "importers", "ARCHITECTURE")
SKIPPED = shutil.ignore_patterns("__pycache__", "logs", "*.fmu")


def readme() -> Pages:
    """The beginning of README.md as start page, and a page for each of its sections."""
    text = _linked_to_pages((ROOT / "README.md").read_text())
    start, *sections = re.split(r"^## ", text, flags=re.MULTILINE)
    titles = [section.partition("\n")[0] for section in sections]
    named = [f"guide_{_slug(title)}" for title in titles]
    lists = sidebar(named, "Guide") + sidebar(REFERENCE, "Reference") + sidebar(ABOUT, "About")
    yield "index.md", f"{start}\n{lists}"
    for name, title, section in zip(named, titles, sections, strict=True):
        own = _set_up() if title == "Set up" else ""
        yield f"{name}.md", f"# {section}\n{own}"


def _linked_to_pages(text: str) -> str:
    """The text with links to folders and files of the project led to the pages made of them."""
    text = re.sub(r"\]\(examples/(\w+)\)", r"](examples/\1/README.md)", text)
    text = text.replace("](examples)", "](examples/index.md)")
    return re.sub(r"\]\(fmu_src/(\w+\.md)\)", r"](\1)", text)


def _set_up() -> str:
    """What can be set by the environment."""
    notes = (inspect.getdoc(compiler), inspect.getdoc(cache_folder))
    return "## By environment variables\n\n" + "\n\n".join(from_rst(note or "") for note in notes)


def architecture(folder: Path) -> Pages:
    """ARCHITECTURE.md with what it leads to."""
    text = (TEXTS / "ARCHITECTURE.md").read_text().replace("(decisions)", "(decisions/index.md)")
    others = ("CONTRIBUTING.md", "CHANGELOG.md", "decisions/index.md")
    yield "ARCHITECTURE.md", text + sidebar(others)
    for name in others[:2]:
        yield name, (TEXTS / name).read_text()
    shutil.copytree(TEXTS / "decisions", folder / "decisions")
    names = sorted(path.name for path in (TEXTS / "decisions").glob("*.md"))
    yield "decisions/index.md", "# Decisions\n\n" + code("\n".join(names), "{toctree}")


def examples(folder: Path) -> Pages:
    """A page for each folder of examples: its README, else what its script says, and its code."""
    shutil.copytree(ROOT / "examples", folder / "examples", ignore=SKIPPED)
    paths = sorted(path for path in (ROOT / "examples").iterdir() if path.is_dir())
    for path in paths:
        yield f"examples/{path.name}/README.md", _example(path)
    names = "\n".join(f"{path.name}/README" for path in paths)
    yield "examples/index.md", "# Examples\n\n" + code(names, "{toctree}")


def _example(folder: Path) -> str:
    written, script = folder / "README.md", folder / "run.py"
    scripts = sorted(folder.glob("*.py"))
    if written.exists():
        parts = [written.read_text()]
    else:
        parts = [_from_script(script) if script.exists() else f"# {folder.name.capitalize()}"]
    parts += [f"## {path.name}\n\n{code(path.read_text(), 'python')}" for path in scripts]
    parts += [from_notebook(path) for path in sorted(folder.glob("*.ipynb"))]
    return "\n\n".join(parts)


def _from_script(script: Path) -> str:
    """A script's docstring, and its pictures."""
    text = ast.get_docstring(ast.parse(script.read_text())) or ""
    title, _, rest = text.partition("\n")
    title = re.split(r"[.:,]", title)[0]
    pictures = [f"![]({path.name})" for path in sorted(script.parent.glob("*.png"))]
    return "\n\n".join([f"# {title}", from_rst(text if rest else ""), *pictures])


def from_notebook(path: Path) -> str:
    """The cells of a notebook, its headings below that of the page."""
    cells = json.loads(path.read_text())["cells"]
    texts = [("".join(cell["source"]), cell["cell_type"]) for cell in cells]
    return "\n\n".join(
        code(text, "python") if kind == "code" else re.sub(r"^#", "##", text, flags=re.MULTILINE)
        for text, kind in texts
    )


def commands() -> Pages:
    """The command line, as typer tells of it."""
    command = get_command(app)
    context = typer.Context(command, info_name="elastic-tendon")
    text = get_docs_for_click(obj=command, ctx=context, name="elastic-tendon")
    # a star within a line is one of a formula
    text = f"# Command line\n{text.partition(chr(10))[2]}"
    yield "commands.md", re.sub(r"(?<=[^*\n])\*(?=[^*\s])", r"\\*", text)


def _slug(title: str) -> str:
    """A title as the name of a file."""
    return re.sub(r"\W+", "_", title.lower()).strip("_")

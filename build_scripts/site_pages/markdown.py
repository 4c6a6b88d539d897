"""Pieces of MyST Markdown."""

import re
from collections.abc import Iterable, Sequence


def plain(text: str) -> str:
    """Text whose signs mean nothing in Markdown."""
    return re.sub(r"([\\`*_<>\[\]|#$])", r"\\\1", text)


def from_rst(text: str) -> str:
    """A docstring, of which names in single or double backticks are code."""
    return text.replace("``", "`")


def table(heading: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table; its cells are Markdown."""
    lines = [heading, ["---"] * len(heading), *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines) + "\n"


def code(text: str, language: str = "") -> str:
    """A block of code, or a directive of Sphinx."""
    return f"````{language}\n{text.strip()}\n````\n"


def sidebar(pages: Iterable[str], caption: str = "") -> str:
    """Pages that follow in the sidebar, unseen on the page itself."""
    options = [":hidden:", *([f":caption: {caption}"] if caption else [])]
    return code("\n".join([*options, "", *pages]), "{toctree}")


def from_docstrings(directives: Iterable[str], module: str = "elastic_tendon") -> str:
    """What Sphinx finds in docstrings, by directives of its own."""
    return code("\n\n".join((f".. currentmodule:: {module}", *directives)), "{eval-rst}")

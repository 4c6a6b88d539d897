"""What stands at the head of a model.toml: what made it, and from what."""

from collections.abc import Iterable


def comments(lines: Iterable[str]) -> str:
    """Lines as comments for the head of a TOML file, and an empty line after them.

    Parameters
    ----------
    lines : text; names of files and models, which a user chose, may be in it
    """
    return "".join(f"# {_printable(line)}\n" for line in lines) + "\n"


def _printable(line: str) -> str:
    """A line for a comment: names of files may hold what TOML and UTF-8 do not allow there."""
    return "".join(
        letter if letter.isprintable() else "\N{REPLACEMENT CHARACTER}" for letter in line
    )

"""What all results have in common: a short text, plain data, a file."""

import json
import math
from abc import ABC, abstractmethod
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from elastic_tendon.output import write_text

LONGEST = 1200  # characters that a result shows of itself


class Result(ABC):
    """A result that can be printed, shown in a notebook and written as JSON."""

    @abstractmethod
    def summary(self) -> str:
        """What matters, in a few lines of text."""

    @abstractmethod
    def to_dict(self) -> dict[str, Any]:
        """The result as plain data for JSON; SI units."""

    def save_json(self, path: str | Path, *, force: bool = False) -> None:
        """Write `to_dict` to a file.

        Parameters
        ----------
        path : of the file, which is written whole or not at all
        force : whether a file that exists is replaced

        Raises
        ------
        OutputError : the file exists or cannot be written
        """
        text = json.dumps(self.to_dict(), indent=2, allow_nan=False) + "\n"
        write_text(Path(path), text, force=force)

    def __repr__(self) -> str:
        text = self.summary()
        return text if len(text) <= LONGEST else f"{text[:LONGEST]}…"

    def _repr_html_(self) -> str:
        return f"<pre>{escape(repr(self))}</pre>"


def plain(value: Any) -> Any:
    """Arrays become lists, numbers that are not finite None, at any depth."""
    if isinstance(value, dict):
        return {name: plain(item) for name, item in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value

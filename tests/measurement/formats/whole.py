"""A group of a source as one table, and refusals with their sentence."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement.formats import Source, open_source
from elastic_tendon.progress import silent


def whole(source: Source, group: str = "") -> dict[str, NDArray[Any]]:
    """All columns of a group, their chunks put together."""
    columns = next(each.columns for each in source.groups if each.name == group)
    chunks = list(source.read(group, columns, silent))
    return {name: np.concatenate([chunk[name] for chunk in chunks]) for name in columns}


def group_named(source: Source, name: str) -> Any:
    return next(each for each in source.groups if each.name == name)


def assert_refused(path: Path, *parts: str) -> None:
    """Opening a file, or reading all of it, ends in one sentence with these parts."""
    with pytest.raises(MeasurementError) as refusal:
        _read(path)
    sentence = str(refusal.value)
    assert "\n" not in sentence
    assert path.name in sentence
    for part in parts:
        assert part in sentence, sentence


def _read(path: Path) -> None:
    source = open_source(path)
    for group in source.groups:
        whole(source, group.name)


def truncated(path: Path, share: float = 0.6) -> Path:
    """The same file without its end."""
    content = path.read_bytes()
    short = path.with_name(f"short_{path.name}")
    short.write_bytes(content[: int(share * len(content))])
    return short

"""What studies of the diagnosis share: one JSON a case in a folder, so they may be interrupted."""

import argparse
import json
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from platformdirs import user_cache_path

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.diagnosis.diagnose import diagnose
from elastic_tendon.measurement import Measurement

Content = dict[str, Any]
Order = TypeVar("Order")  # what a case is made of
Outcome = TypeVar("Outcome")
SIGNAL = "joint_position"
UNEXPLAINED = ("unexplained", "unknown_effect")


@dataclass(frozen=True)
class Said:
    """What the tool said of a case: `error` in rad RMS, of the fitted recordings."""

    verdict: str
    named: list[str]
    error: float
    seconds: float


def asked(given: Model, fit: Sequence[Measurement], validation: Sequence[Measurement] = ()) -> Said:
    """Ask the tool."""
    begin = time.perf_counter()
    answer = diagnose(given, fit, validation)
    seconds = time.perf_counter() - begin
    error = float(answer.comparison.rmse()[SIGNAL])
    return Said(str(answer.verdict), sorted(answer.added), error, seconds)


def kept(path: Path, make: Callable[[], Content]) -> Content:
    """The content of a JSON file, made and written whole where there is none."""
    if path.exists():
        content: Content = json.loads(path.read_text())
        return content
    content = make()
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_suffix(f".{os.getpid()}")
    beside.write_text(json.dumps(content, indent=1))
    beside.replace(path)
    return content


def _attempted(order: Order, judged: Callable[[Order], Content]) -> Content:
    try:
        return judged(order)
    except Exception as fault:
        return {"order": str(order), "fault": f"{type(fault).__name__}: {fault}"}


def answers(
    wanted: Sequence[Order], judged: Callable[[Order], Content], jobs: int
) -> Iterator[Content]:
    """The row of each case as they come, with its number on the way; a fault ends no study."""
    work = partial(_attempted, judged=judged)
    begin = time.monotonic()
    for number, row in enumerate(mapped(work, wanted, jobs), start=1):
        elapsed = time.monotonic() - begin
        print(f"\r{number} of {len(wanted)}, {elapsed:.0f} s  ", end="", file=sys.stderr)
        yield row


def mapped(
    work: Callable[[Order], Outcome], wanted: Sequence[Order], jobs: int
) -> Iterator[Outcome]:
    """What some processes make of each case, as it comes."""
    if jobs == 1:
        yield from map(work, wanted)
        return
    # an interrupt is the parent's to handle: it ends the workers
    ignore = (signal.SIGINT, signal.SIG_IGN)
    with multiprocessing.get_context("spawn").Pool(jobs, signal.signal, ignore) as pool:
        yield from pool.imap_unordered(work, wanted)


def collected(
    wanted: Sequence[Order], judged: Callable[[Order], Content], jobs: int
) -> tuple[list[Content], list[Content]]:
    """All rows, and those of cases that could not be judged; an interrupt keeps what is done."""
    rows: list[Content] = []
    faults: list[Content] = []
    try:
        for row in answers(wanted, judged, jobs):
            (faults if "fault" in row else rows).append(row)
    except KeyboardInterrupt:
        print("\ninterrupted; what is done is kept", file=sys.stderr)
    print(file=sys.stderr)
    return rows, faults


def parser_of(about: str | None, folder: str) -> argparse.ArgumentParser:
    """Options that these studies share; results are kept in `folder` of the user's cache."""
    parser = argparse.ArgumentParser(description=(about or "").splitlines()[0])
    parser.add_argument("--seeds", choices=("dev", "report"), default="dev")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--only", default="", help="cases whose name holds this")
    parser.add_argument(
        "--folder", type=Path, default=user_cache_path(folder), help="where results are kept"
    )
    return parser


def print_columns(rows: Sequence[Sequence[str]]) -> None:
    """Rows of text, the first of them the heads, in columns."""
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    for row in rows:
        cells = (cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        print("  ".join(cells).rstrip())


def print_faults(faults: Sequence[Content]) -> None:
    """Cases that could not be judged."""
    for row in faults:
        print(f"failed: {row['order']}: {row['fault']}")

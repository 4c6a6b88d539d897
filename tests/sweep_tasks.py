"""A task for sweeps whose runs can be counted, fail, and end their process."""

import os
import signal
import time
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
import pandas as pd


@dataclass(frozen=True)
class Draws:
    """Run i draws a number from the seed (`seed`, i).

    Parameters
    ----------
    journal : file to which each run appends its number and that of its process, "" for none
    seconds : that a run sleeps
    raising, killing : runs that raise, and that end their process
    ballast : makes the task large
    sick : where the environment has a variable of this name, or there is such a file, runs
        cannot be done
    """

    runs: int
    journal: str = ""
    seconds: float = 0.0
    raising: tuple[int, ...] = ()
    killing: tuple[int, ...] = ()
    threads: bool = False
    seed: int = 1
    ballast: bytes = b""
    sick: str = ""

    @property
    def identity(self) -> dict[str, str]:
        return {"seed": str(self.seed), "kind": "draws"}

    def batch(self) -> int:
        return 5

    def rows(self, start: int, stop: int) -> pd.DataFrame:
        return pd.concat([self._row(run) for run in range(start, stop)], ignore_index=True)

    def failed(self, run: int, reason: str) -> pd.DataFrame:
        return _table(run, float("nan"), reason)

    def _row(self, run: int) -> pd.DataFrame:
        if self.sick and (self.sick in os.environ or Path(self.sick).exists()):
            raise OSError(28, "No space left on device")
        time.sleep(self.seconds)
        if self.journal:
            with Path(self.journal).open("a") as journal:
                journal.write(f"{run} {os.getpid()}\n")
        if run in self.killing:
            os.kill(os.getpid(), signal.SIGKILL)
        if run in self.raising:
            raise ValueError(f"run {run}\nis odd")
        return _table(run, float(np.random.default_rng([self.seed, run]).normal()), "")


def _table(run: int, value: float, failure: str) -> pd.DataFrame:
    return pd.DataFrame({"run": [run], "value": [value], "failure": [failure]})


def runs_in(journal: Path) -> list[int]:
    """Numbers of the runs that were begun, sorted."""
    return sorted(int(line.split()[0]) for line in journal.read_text().splitlines())


def processes_in(journal: Path) -> list[int]:
    """Numbers of the processes that did runs, in the order in which these began."""
    return [int(line.split()[1]) for line in journal.read_text().splitlines()]


def read(path: Path | BinaryIO) -> pd.DataFrame:
    """A table of results, number for number; "" stays text."""
    return pd.read_csv(path, keep_default_na=False, na_values={"value": [""]})

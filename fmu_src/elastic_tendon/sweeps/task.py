"""What is swept: numbered runs, each of which any process can do by itself."""

from typing import Protocol

import pandas as pd

from elastic_tendon.errors import BuildError, ElasticTendonError

RUN = "run"  # first column of every table of results: the number of the run, from 0
FAILURE = "failure"  # last column: why a run failed, "" where it did not
ROBOT, VERDICT, DRIFTED, APPEARED = "robot", "verdict", "drifted", "appeared"  # of a fleet
TEXTS = (ROBOT, VERDICT, DRIFTED, APPEARED, FAILURE)  # columns that hold text


class UnfitError(ElasticTendonError):
    """What a run needs is missing where it is done: the computer is at fault, not the run."""


# what a run may raise that says nothing of it: another computer may do it
ENVIRONMENT = (UnfitError, BuildError, MemoryError, OSError, ImportError)


class Task(Protocol):
    """Runs 0, 1, ..., `runs` - 1 of one kind.

    A task is frozen and can be pickled. What a run gives depends on the task and its number alone:
    not on the runs beside it, on their order, or on the machine.
    """

    @property
    def runs(self) -> int:
        """How many there are."""
        ...

    @property
    def identity(self) -> dict[str, str]:
        """All that the results depend on, as text: a sweep goes on only where this is the same."""
        ...

    @property
    def threads(self) -> bool:
        """Whether runs spend their time in C, so that threads of one process do them at once."""
        ...

    def batch(self) -> int:
        """Number of runs to do at once: some half a second of work, and little memory."""
        ...

    def rows(self, start: int, stop: int) -> pd.DataFrame:
        """Results of the runs `start` to `stop` - 1, in order.

        Returns
        -------
        DataFrame; columns of the same names and types whatever the runs: numbers are float64
            (NaN where a run has none), `RUN` is int64, text is never missing. What runs fail of
            is told in `FAILURE`, or raised where `stop` is `start` + 1.

        Raises
        ------
        one of `ENVIRONMENT` : the run cannot be done here, and is to be done elsewhere
        """
        ...

    def failed(self, run: int, reason: str) -> pd.DataFrame:
        """What `rows` gives for one run that failed, where `rows` could not tell."""
        ...

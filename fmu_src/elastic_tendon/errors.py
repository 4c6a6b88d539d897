"""The errors that a user can meet; every message is one sentence that says what to do."""


class ElasticTendonError(Exception):
    """Base of all errors raised on purpose; the command line prints it and exits with 1."""


class ModelError(ElasticTendonError):
    """A model.toml that cannot be used; `problems` lists every fault found, one sentence each."""

    def __init__(self, source: str, problems: list[str]) -> None:
        self.source = source
        self.problems = problems
        super().__init__(f"{source}: " + "; ".join(problems))


class MeasurementError(ElasticTendonError):
    """A data file that cannot be used; the message names file, column and row."""


class BuildError(ElasticTendonError):
    """The compiler refused, or the cache folder cannot be written."""


class SimulationError(ElasticTendonError):
    """The solver could not go on; the message names the time and the reason."""


class ArmError(ElasticTendonError):
    """An arm that cannot be driven or cut into joints; the message says what to change."""


class EffectError(ElasticTendonError):
    """An effect of the user's own that cannot be used; the message names file, line, reason.

    `line` : the same line, None where there is none.
    """

    def __init__(self, message: str, line: int | None = None) -> None:
        self.line = line
        super().__init__(message)


class LinearisationError(ElasticTendonError):
    """There is no linear model as asked for; the message says what to ask for instead."""


class SweepError(ElasticTendonError):
    """A sweep that cannot begin or go on; the message says what to do."""


class EvidenceError(ElasticTendonError):
    """Evidence that cannot be gathered or read; the message says what to do."""

"""What a user may ask of a diagnosis."""

from collections.abc import Iterator
from dataclasses import dataclass

from elastic_tendon import effects
from elastic_tendon.actuator import problems
from elastic_tendon.errors import ModelError

RELEVANCE = 0.05  # share of the error as given below which nobody wants to hear of a change


@dataclass(frozen=True)
class Options:
    """Options of a diagnosis.

    `only`, `without` : ids of effects that alone, or never, are candidates. `relevance` : share of
    a signal's error as given (0 to 1) below which neither a change matters nor what is left, and
    the user answers for what that hides; None: 5 % for changes, nothing for what is left, which
    matters from 1.5 times the noise on. `horizon` : recordings are simulated in windows of so many
    s, each from its own initial state; None: as a whole, but where the noise of a measured motor
    torque makes the motor drift (`windows`). `time_limit` : s after which the best answer so far
    is given; None: no limit.
    """

    only: tuple[str, ...] = ()
    without: tuple[str, ...] = ()
    relevance: float | None = None
    horizon: float | None = None
    time_limit: float | None = None

    @property
    def least_change(self) -> float:
        """Share of the error as given below which a change does not matter."""
        return RELEVANCE if self.relevance is None else self.relevance

    @property
    def least_left(self) -> float:
        """Share of the error as given below which what is left does not matter."""
        return self.relevance or 0.0

    def check_ids(self) -> None:
        """Refuse effects that the catalogue does not have.

        Raises
        ------
        ModelError : names them
        """
        if unknown := list(self._unknown()):
            raise ModelError("effects", unknown)

    def _unknown(self) -> Iterator[str]:
        for effect_id in (*self.only, *self.without):
            if effects.BY_ID.find(effect_id) is None:
                yield problems.unknown_effect(effect_id, effects.BY_ID.ids())

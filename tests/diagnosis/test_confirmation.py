"""Answers that excerpts do not tell apart, and all samples do."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from types import SimpleNamespace

import pytest

from elastic_tendon.diagnosis import confirmation
from elastic_tendon.diagnosis.confirmation import LESS, MOST, confirm, errs_more
from elastic_tendon.diagnosis.evidence import DECISIVE_IN_PLACE, MUCH
from elastic_tendon.progress import Progress, silent

OFFSET, TORQUE, GRAVITY = ("joint_encoder_offset",), ("constant_torque",), ("gravity_load",)


@dataclass(frozen=True)
class Fit:
    """An answer, on excerpts or on everything."""

    added: tuple[str, ...]
    evidence: float
    mean_square: float
    complexity: int = 1


@dataclass
class Ended:
    """A search that holds its answers, the first not refused for the best, for alike."""

    answers: list[Fit]
    refused: dict[tuple[str, ...], str] = field(default_factory=dict)

    @property
    def allowed(self) -> list[Fit]:
        return [one for one in self.answers if one.added not in self.refused]

    @property
    def answer(self) -> Fit:
        return self.allowed[0]

    @property
    def evidence(self) -> "Ended":
        return self

    @staticmethod
    def of_fitted(answers: list[Fit]) -> list[float]:
        return [one.evidence for one in answers]


@pytest.fixture
def confirmed(monkeypatch) -> Callable[..., tuple[Ended, list[tuple[str, ...]]]]:
    """A search after all samples were asked, and which sets were fitted to them."""

    def confirms(
        evidence: dict[tuple[str, ...], float], left: float = 1.0, beside: float | None = None
    ) -> tuple[Ended, list[tuple[str, ...]]]:
        def fitted(_data: None, answer: Fit, _report: Progress, best: Fit | None = None) -> Fit:
            return answer if best is None or beside is None else replace(answer, evidence=beside)

        search = Ended([Fit(added, value, left) for added, value in evidence.items()])
        monkeypatch.setattr(confirmation, "answers_alike", lambda search, _: tuple(search.allowed))
        monkeypatch.setattr(confirmation, "on_everything", fitted)
        return search, list(confirm(None, search, silent))

    return confirms


def test_what_explains_less_of_all_samples_is_refused(confirmed) -> None:
    search, fitted = confirmed({OFFSET: 0.0, TORQUE: 1.1 * DECISIVE_IN_PLACE, GRAVITY: 5.0})
    assert fitted == [OFFSET, TORQUE, GRAVITY]
    assert search.refused == {TORQUE: LESS}


def test_what_came_to_a_wrong_minimum_begins_again_beside_the_best(confirmed) -> None:
    search, fitted = confirmed({OFFSET: 2.0 * DECISIVE_IN_PLACE, TORQUE: 0.0}, beside=1.0)
    assert fitted == [OFFSET, TORQUE]
    assert not search.refused


def test_another_becomes_the_answer_where_all_samples_say_so(confirmed) -> None:
    search, fitted = confirmed({OFFSET: 1.1 * DECISIVE_IN_PLACE, TORQUE: 0.0})
    assert search.answer.added == TORQUE
    assert search.refused == {OFFSET: LESS}
    assert fitted == [OFFSET, TORQUE]  # each once


def test_only_so_many_are_fitted_to_everything(confirmed) -> None:
    others = {(f"effect_{number}",): 0.0 for number in range(2 * MOST)}
    assert len(confirmed(others)[1]) == MOST


def test_where_much_is_left_only_the_answer_is_fitted(confirmed) -> None:
    search, fitted = confirmed({OFFSET: 100.0, TORQUE: 0.0}, left=2.0 * MUCH)
    assert fitted == [OFFSET]
    assert not search.refused


@pytest.mark.parametrize(("alone", "more"), [(2.0, True), (20.0, False)])
def test_what_errs_more_than_with_fewer_effects_is_no_answer(alone, more, monkeypatch) -> None:
    left = {OFFSET: alone, (*OFFSET, *TORQUE): 9.0}
    monkeypatch.setattr(
        confirmation,
        "on_everything",
        lambda _data, answer, _report: replace(answer, mean_square=left[answer.added]),
    )
    both = Fit((*OFFSET, *TORQUE), 0.0, 1.0)
    search = SimpleNamespace(answer=both, answers={OFFSET: Fit(OFFSET, 9.0, 4.0)})
    whole = replace(both, mean_square=9.0)
    assert errs_more(None, search, whole, silent) is more
    assert not errs_more(None, search, both, silent)  # excerpts show all

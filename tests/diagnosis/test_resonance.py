"""A light mass that rings for long is found, where only its frequency is not known."""

import pytest

from elastic_tendon.actuator.parameters import typical_value
from elastic_tendon.diagnosis.answer import Answer, refit
from elastic_tendon.diagnosis.resonance import AROUND, REFITTING, Resonance, frequencies, swings
from elastic_tendon.effects import BY_ID
from elastic_tendon.errors import SimulationError
from elastic_tendon.estimation.fit import QUICK
from smooth_motion import GIVEN, played

MASS = "effects.spring_mass.mass"
NOISE, SHORT = 2e-5, 3.0  # rad, s


def unchecked(_share: float) -> None:
    """Nobody wants to stop."""


def heavy(mass: float, damping: float):
    """Springs with these shares of a typical mass and its damping."""
    typical = {one.name: typical_value(GIVEN, one) for one in BY_ID["spring_mass"].parameters}
    values = {"mass": mass * typical["mass"], "damping": damping * typical["damping"]}
    return GIVEN.with_effect("spring_mass", values)


TRUTH = heavy(1.37, 0.2)


@pytest.fixture(scope="module")
def recordings():
    return [played(TRUTH, SHORT).recording(NOISE)]


@pytest.fixture(scope="module")
def resonance(recordings) -> Resonance:
    return Resonance(GIVEN, ("spring_mass",), "spring_mass", recordings, unchecked)


@pytest.fixture(scope="module")
def beside(resonance, recordings) -> list[Answer]:
    return resonance.beside(refit(GIVEN, (), recordings, effort=QUICK))


def mass_of(answer: Answer) -> float:
    return answer.values("spring_mass")["mass"] / TRUTH.effects["spring_mass"]["mass"]


def test_an_effect_that_sets_a_frequency_swings() -> None:
    assert swings("spring_mass")
    assert not swings("coulomb_friction")


def test_the_mass_is_found_beside_a_refit_without_it(beside) -> None:
    assert beside[0].mean_square == pytest.approx(1.0, abs=0.1)
    assert mass_of(beside[0]) == pytest.approx(1.0, abs=1e-3)


def test_the_mass_is_found_where_noise_hides_its_peak(
    resonance, recordings, beside, monkeypatch
) -> None:
    monkeypatch.setattr("elastic_tendon.diagnosis.resonance.frequencies", lambda *_: [])
    without = refit(GIVEN, (), recordings, effort=QUICK)
    assert mass_of(resonance.beside(without)[0]) == pytest.approx(1.0, rel=0.05)
    assert resonance.beside(beside[0]) == []  # which leaves little


def test_a_wrong_frequency_leads_to_the_right_one_around_it(resonance, recordings) -> None:
    wrong = TRUTH.with_values({MASS: 0.8 * TRUTH.values()[MASS]})
    place = refit(GIVEN, ("spring_mass",), recordings, [wrong], REFITTING)
    found = resonance.around(place)
    assert place.mean_square > 1.2  # a fit from there ends in a wrong minimum
    assert found[0].mean_square == pytest.approx(1.0, abs=0.1)
    assert mass_of(found[0]) == pytest.approx(1.0, abs=1e-3)


def test_starts_that_lead_to_one_minimum_are_followed_once(
    resonance, recordings, monkeypatch
) -> None:
    refitted: dict[int, int] = {}

    def noted(given, added, measurements, *how):
        samples = len(measurements[0].time)
        refitted[samples] = refitted.get(samples, 0) + 1
        return refit(given, added, measurements, *how)

    monkeypatch.setattr("elastic_tendon.diagnosis.resonance.refit", noted)
    wrong = heavy(1.37 * 1.2, 0.2)
    start = refit(GIVEN, ("spring_mass",), recordings, [wrong], effort=REFITTING)
    found = resonance.around(start)
    assert mass_of(found[0]) == pytest.approx(1.0, abs=1e-3)
    first, *others = (count for _, count in sorted(refitted.items()))
    assert len(AROUND) <= first
    assert sum(others) <= 2 * len(others)


def test_nothing_is_found_where_a_beginning_is_met_as_well_without_it() -> None:
    friction = GIVEN.with_effect("coulomb_friction", {"torque": 0.05})
    recordings = [played(friction, SHORT).recording(NOISE)]
    without = refit(GIVEN, (), recordings, effort=QUICK)
    assert frequencies("spring_mass", without)  # it seems to swing
    look = Resonance(GIVEN, ("spring_mass",), "spring_mass", recordings, unchecked)
    assert look.beside(without) == []


def test_where_nothing_can_be_simulated_nothing_is_found(resonance, beside, monkeypatch) -> None:
    def fails(*_):
        raise SimulationError("it runs away")

    monkeypatch.setattr("elastic_tendon.diagnosis.resonance.refit", fails)
    assert resonance.beside(beside[0]) == []
    assert resonance.around(beside[0]) == []


def test_a_look_can_be_stopped(resonance, beside) -> None:
    def stop(_share: float) -> None:
        raise KeyboardInterrupt

    stopped = Resonance(GIVEN, ("spring_mass",), "spring_mass", resonance.measurements, stop)
    with pytest.raises(KeyboardInterrupt):
        stopped.around(beside[0])

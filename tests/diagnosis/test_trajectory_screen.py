"""A look along the whole trajectory tells the effect that hides from those that do not."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest

from elastic_tendon import effects
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.diagnosis import trajectory_screen
from elastic_tendon.diagnosis.answer import Answer, refit
from elastic_tendon.diagnosis.candidates import starts
from elastic_tendon.diagnosis.trajectory_screen import TrajectoryScreen
from elastic_tendon.errors import SimulationError
from elastic_tendon.estimation.fit import QUICK
from smooth_motion import GIVEN, played, typical_model

COULOMB, GRAVITY, DRAG = "coulomb_friction", "gravity_load", "quadratic_drag"
RIVALS = (COULOMB, GRAVITY, DRAG, "spring_hardening", "measurement_delay", "gear_backlash")
NOISE, SHORT = 2e-4, 3.0  # rad, s


def unchecked(_share: float) -> None:
    """Nobody wants to stop."""


@dataclass(frozen=True)
class Looked:
    """The base model refitted to data in which an effect hides, and the screen beside it."""

    hidden: str
    answer: Answer
    screen: TrajectoryScreen

    def models(self, effect_id: str) -> Iterator[Model]:
        """With a third of the typical strength."""
        recordings = self.answer.result.problem.measurements
        for values in starts(GIVEN, effects.BY_ID[effect_id], recordings, (0.3,)):
            yield self.answer.result.model.with_effect(effect_id, values)

    def left(self, effect_id: str, values: dict[str, float] | None = None) -> float:
        """By numbers that are told, or the best of a third of the typical strength."""
        model = self.answer.result.model
        models = (
            self.models(effect_id) if values is None else [model.with_effect(effect_id, values)]
        )
        return self.screen.best(models, unchecked)[0][0]


def looked(hidden: str) -> Looked:
    recording = played(typical_model(hidden), SHORT).recording(NOISE)
    answer = refit(GIVEN, (), [recording], effort=QUICK)
    return Looked(hidden, answer, TrajectoryScreen(answer))


@pytest.fixture(scope="module")
def sticking() -> Looked:
    return looked(COULOMB)


@pytest.fixture(scope="module")
def hanging() -> Looked:
    return looked(GRAVITY)


@pytest.fixture(scope="module")
def dragging() -> Looked:
    return looked(DRAG)


@pytest.mark.parametrize("case", ["sticking", "hanging", "dragging"])
def test_what_hides_leaves_far_less_than_others(case, request) -> None:
    found = request.getfixturevalue(case)
    left = {effect_id: found.left(effect_id) for effect_id in RIVALS}
    own = left.pop(found.hidden)
    assert own < 0.5
    assert own < 0.6 * min(left.values())


def test_the_best_start_is_told_first(hanging) -> None:
    """Of the quadrants of its angle the one in which gravity really pulls, or that beside it."""
    found = hanging.screen.best(hanging.models(GRAVITY), unchecked)
    shares = [share for share, _ in found]
    assert len(found) == 4
    assert shares == sorted(shares)
    true = typical_model(GRAVITY).effects[GRAVITY]["angle"]
    assert np.cos(found[0][1].effects[GRAVITY]["angle"] - true) >= np.cos(np.pi / 4) - 1e-9
    assert np.cos(found[-1][1].effects[GRAVITY]["angle"] - true) < 0.0
    assert shares[-1] == pytest.approx(1.0, abs=0.05)  # it only pulls the other way


def test_its_strength_follows(sticking) -> None:
    """To first order it does not matter how much of an effect is looked at."""
    little, some = (sticking.left(COULOMB, {"torque": torque}) for torque in (0.03, 0.1))
    assert little == pytest.approx(some, abs=0.05)
    assert max(little, some) < 0.2


def test_a_parameter_at_its_bound_does_not_follow_beyond_it() -> None:
    """A late signal drives the dampings of the springs to zero, and would farther."""
    delayed = looked("measurement_delay")
    values = delayed.answer.result.model.values()
    assert values["transmission.upper_spring.damping"] == 0.0
    left = {effect_id: delayed.left(effect_id) for effect_id in RIVALS}
    assert left.pop("measurement_delay") < 0.2
    assert min(left.values()) > 0.5


@pytest.mark.parametrize(
    ("effect_id", "values"),
    [
        (DRAG, {"coefficient": 0.0}),
        ("measurement_delay", {"delay": 0.0}),
        ("joint_stop", {"lower": -3.0, "upper": 3.0, "stiffness": 1e3, "damping": 1.0}),
        ("overstretch_protection", {"engagement": 1.9, "stiffness": 3e4}),
    ],
)
def test_an_effect_that_does_nothing_leaves_all(sticking, effect_id, values) -> None:
    assert sticking.left(effect_id, values) == 1.0


@pytest.mark.parametrize("effect_id", [GRAVITY, DRAG, "spring_hardening", "measurement_delay"])
def test_what_shares_a_library_leaves_as_much_as_alone(dragging, effect_id) -> None:
    light = (GRAVITY, DRAG, "spring_hardening", "measurement_delay")
    shared = TrajectoryScreen(dragging.answer, light)
    alone = dragging.screen.best(dragging.models(effect_id), unchecked)
    together = shared.best(dragging.models(effect_id), unchecked)
    assert [left for left, _ in together] == pytest.approx([left for left, _ in alone], rel=1e-6)
    assert [model.effects for _, model in together] == [model.effects for _, model in alone]


def test_what_changes_by_rounding_alone_leaves_all(sticking, dragging) -> None:
    left = [
        sticking.left("gear_backlash", {"gap": 0.0}),
        dragging.left(COULOMB, {"torque": 0.0}),
    ]
    assert left == pytest.approx([1.0, 1.0], abs=1e-6)


def test_nothing_leaves_more_than_there_was(hanging) -> None:
    assert (
        max(share for share, _ in hanging.screen.best(hanging.models(COULOMB), unchecked))
        < 1.0 + 1e-9
    )


def test_the_wrong_sign_explains_nothing(sticking) -> None:
    """Of so much friction there is too much damping left; drag would only add to it."""
    assert sticking.left(DRAG) == 1.0


def test_what_cannot_be_simulated_leaves_all(sticking, monkeypatch) -> None:
    whole = trajectory_screen.simulate_measurement

    def simulate(model: Model, *arguments):
        if DRAG in model.effect_ids:
            raise SimulationError("it runs away")
        return whole(model, *arguments)

    monkeypatch.setattr(trajectory_screen, "simulate_measurement", simulate)
    models = [*sticking.models(DRAG), *sticking.models(COULOMB)]
    found = sticking.screen.best(models, unchecked)
    assert [model.effect_ids for _, model in found] == [(COULOMB,), (DRAG,)]
    assert found[0][0] < 0.2
    assert found[1][0] == 1.0


def test_a_look_ends_where_simulations_fail_again_and_again(hanging, monkeypatch) -> None:
    tried = []

    def simulate(model: Model, *_):
        tried.append(model)
        raise SimulationError("more than a hundred thousand events")

    monkeypatch.setattr(trajectory_screen, "simulate_measurement", simulate)
    models = list(hanging.models(GRAVITY))
    assert len(models) > trajectory_screen.MOST_FAILURES
    found = hanging.screen.best(models, unchecked)
    assert len(tried) == len(found) == trajectory_screen.MOST_FAILURES
    assert {left for left, _ in found} == {1.0}


def test_a_motion_that_grows_without_bound_leaves_all(sticking, monkeypatch) -> None:
    monkeypatch.setattr(
        trajectory_screen,
        "residuals_of",
        lambda _trajectory, part: {"joint_position": np.full(len(part.time), np.inf)},
    )
    assert sticking.left(COULOMB) == 1.0


def test_a_look_can_be_stopped_before_each_simulation(hanging) -> None:
    asked = []

    def check(share: float) -> None:
        asked.append(share)
        if len(asked) == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        hanging.screen.best(hanging.models(GRAVITY), check)
    assert len(asked) == 3


def test_two_changes_are_scored_together(hanging) -> None:
    """One that makes room for the other, one that comes in with the other sign, and one alike."""
    screen, rng = hanging.screen, np.random.default_rng(1)
    left = screen._residuals
    room = 10.0 * float(np.std(left)) * rng.standard_normal(len(left))
    shares, times = screen.together([room - left, -room, left, 0.5 * (room - left)])
    assert times[0, 1] == pytest.approx(1.0)
    assert times[3, 1] == pytest.approx(2.0)
    assert shares[0, 1] == pytest.approx(0.0, abs=1e-6)
    assert shares[0, 1] == shares[1, 0]
    assert shares[0, 0] > 0.8
    assert shares[1, 1] > 0.8
    assert (shares[2] == 1.0).all()
    assert shares[0, 3] == 1.0

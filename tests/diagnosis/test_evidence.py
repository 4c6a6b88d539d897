"""The evidence: what counts for an answer, what against it, and which answer is taken."""

from dataclasses import dataclass, field
from math import log
from types import SimpleNamespace

import numpy as np
import pytest

from elastic_tendon import effects
from elastic_tendon.actuator.parameters import load_model, typical_value
from elastic_tendon.diagnosis import evidence
from elastic_tendon.diagnosis.evidence import (
    DECISIVE,
    HARDLY,
    Evidence,
    audible,
    beside_unknown,
    explained,
    implausible_values,
    is_plausible,
    probabilities,
)
from elastic_tendon.diagnosis.held_out import EXPLAINED
from elastic_tendon.diagnosis.verdict import hedge
from elastic_tendon.measurement import NoiseFloor

GIVEN = load_model("biorob_x4_joint_3")
N = 1000  # samples, independent facts all of them


@dataclass(frozen=True)
class Made:
    """An answer by its errors alone; `typical` : share of the typical values of its effects."""

    added: tuple[str, ...]
    square: float
    implausibility: float = 0.0
    typical: float = 1.0
    heldout: float = 1.0
    result: SimpleNamespace = field(
        default_factory=lambda: SimpleNamespace(
            model=GIVEN,
            problem=SimpleNamespace(measurements=(), coordinates=SimpleNamespace(sizes={})),
        )
    )

    @property
    def floored(self):
        return np.sqrt(self.square) * np.ones(N)

    @property
    def mean_square(self) -> float:
        return self.square

    @property
    def complexity(self) -> int:
        return sum(len(effects.BY_ID[effect_id].parameters) for effect_id in self.added)

    def values(self, effect_id: str) -> dict[str, float]:
        return {
            parameter.name: parameter.null
            + self.typical * (typical_value(GIVEN, parameter) - parameter.null)
            for parameter in effects.BY_ID[effect_id].parameters
        }


@pytest.fixture(autouse=True)
def facts(monkeypatch) -> None:
    """Every sample is a fact; errors on held-out recordings are those that were made up."""
    monkeypatch.setattr(evidence, "_facts", lambda _answer, _recordings, errors: float(len(errors)))


def judge(*, heldout: bool = False, monkeypatch=None) -> Evidence:
    if heldout:
        made = lambda _self, answer: np.sqrt(answer.heldout) * np.ones(100)  # noqa: E731
        monkeypatch.setattr(Evidence, "heldout_errors", made)
    return Evidence((SimpleNamespace(),) if heldout else ())


BASE = Made((), 4.0)
COULOMB = Made(("coulomb_friction",), 1.0)


def test_a_smaller_error_counts_for_an_answer_and_its_parameters_against_it() -> None:
    base, coulomb = judge().of([BASE, COULOMB])
    assert base == pytest.approx(N * log(4.0))
    assert coulomb == pytest.approx(log(N))


def test_errors_below_the_noise_count_no_further() -> None:
    half, none = judge().of([Made((), 0.25), Made((), 1e-8)])
    assert half == none


def test_what_leaves_the_prior_costs() -> None:
    near, far = judge().of([Made((), 1.0), Made((), 1.0, implausibility=25.0)])
    assert far - near == pytest.approx(25.0)


def test_an_implausible_value_costs() -> None:
    ordinary, huge = judge().of([COULOMB, Made(("coulomb_friction",), 1.0, typical=100.0)])
    assert huge - ordinary == pytest.approx(evidence.IMPLAUSIBLE)
    assert implausible_values(COULOMB) == {}
    (path,) = implausible_values(Made(("coulomb_friction",), 1.0, typical=100.0))
    assert path == "effects.coulomb_friction.torque"


def test_an_implausible_value_never_wins_a_near_tie() -> None:
    wild = Made(("coulomb_friction",), 1.0, typical=100.0)
    plausible = Made(("stribeck_friction",), 1.0)
    values = judge().of([wild, plausible])
    assert abs(values[0] - values[1]) < evidence.DECISIVE
    assert judge().best([wild, plausible]) is plausible


def test_a_value_at_a_bound_is_implausible_unless_it_does_nothing_there() -> None:
    (relaxation,) = (one for one in effects.BY_ID["spring_relaxation"].parameters if one.shape)
    path = f"effects.spring_relaxation.{relaxation.name}"
    assert not is_plausible(GIVEN, path, relaxation.upper)
    assert is_plausible(GIVEN, "effects.coulomb_friction.torque", 0.0)


def test_held_out_errors_take_part(monkeypatch) -> None:
    good, bad, lost = (Made((), 1.0, heldout=square) for square in (1.0, 2.0, np.inf))
    values = judge(heldout=True, monkeypatch=monkeypatch).of([good, bad, lost])
    assert values[1] - values[0] == pytest.approx(100.0 * log(2.0))
    assert values[2] == np.inf


def test_of_refits_only_those_that_could_win_are_asked_on_held_out_recordings(monkeypatch) -> None:
    asked = []

    def made(_self, answer):
        asked.append(answer)
        return np.sqrt(answer.heldout) * np.ones(100)

    monkeypatch.setattr(Evidence, "heldout_errors", made)
    judging = Evidence((SimpleNamespace(),))
    best, near, far = (Made((), square, heldout=1.0) for square in (1.0, 1.001, 4.0))
    assert judging.likeliest([far, near, best]) is best
    assert far not in asked
    elsewhere = Made((), 1.0, heldout=9.0)  # its fit is the best, but not what held-out data say
    assert judging.likeliest([near, elsewhere]) is near


def test_little_is_asked_of_who_leaves_far_more_than_a_better_answer(monkeypatch) -> None:
    asked = []

    def made(_result, _recordings, hopeless):
        asked.append(hopeless)
        return np.ones(100)

    monkeypatch.setattr(evidence, "heldout_errors", made)
    judging = Evidence((SimpleNamespace(),))
    good, better, worse = (Made((), square) for square in (1.0, 0.9, 3.0))
    judging.heldout_errors(good)
    for answer in (good, worse, better):
        judging.expect_like([answer])
    judging.heldout_errors(Made((), 1.2))
    assert judging.far_more == pytest.approx(0.9 * evidence.SURELY)
    assert asked[0] == EXPLAINED
    assert asked[-1] == pytest.approx(0.9 * evidence.HOPELESS)


def test_while_much_is_left_no_refit_is_hopeless() -> None:
    judging = judge()
    judging.expect_like([Made((), 100.0)])
    assert judging.far_more == np.inf


def test_held_out_data_that_nothing_explains_refute_none_that_explains_far_more(
    monkeypatch,
) -> None:
    judging = judge(heldout=True, monkeypatch=monkeypatch)
    friction = ("coulomb_friction",)
    base = Made((), 1000.0, heldout=1000.0)
    far_better = Made(friction, 100.0, heldout=1100.0)
    assert judging.lasting(far_better, [base])
    assert not judging.lasting(Made(friction, 500.0, heldout=1100.0), [base])  # not so much better
    assert not judging.lasting(Made(friction, 100.0, heldout=2000.0), [base])  # far worse there
    assert judging.lasting(Made(friction, 20.0, heldout=2000.0), [base])  # and far, far better here
    explained = Made((), 1000.0, heldout=1.0)
    assert not judging.lasting(Made(friction, 100.0, heldout=1.1), [explained])


def test_a_model_that_cannot_follow_a_recording_errs_without_end() -> None:
    broken = SimpleNamespace(time=np.arange(3.0))
    found = Evidence((broken,))
    errors = np.array([np.inf])
    found._errors[id(BASE)] = (BASE, errors)
    assert found.heldout_errors(BASE) is errors


def test_of_near_equals_the_simplest_is_taken() -> None:
    stribeck = Made(("stribeck_friction",), 0.99)
    assert judge().best([BASE, stribeck, COULOMB]) is COULOMB
    clearly = Made(("stribeck_friction",), 0.9)
    assert judge().best([BASE, clearly, COULOMB]) is clearly


def test_of_laws_of_the_same_size_the_more_common_is_taken() -> None:
    drag = Made(("quadratic_drag",), 1.0)
    assert judge().best([BASE, drag, COULOMB]) is COULOMB


def test_of_laws_of_the_same_size_the_likelier_is_taken_where_that_is_worth_a_mention() -> None:
    likelier = Made(("quadratic_drag",), 0.995)
    judging = judge()
    values = judging.of([BASE, likelier, COULOMB])
    assert HARDLY < values[2] - values[1] < DECISIVE
    assert judging.best([BASE, likelier, COULOMB]) is likelier


def test_what_nobody_would_hear_of_is_left_out() -> None:
    clean = Made((), 1.0)
    faint, loud = (Made(("gravity_load",), 1.0 - gain) for gain in (0.02, 0.04))
    assert not audible(faint, [clean, faint])
    assert audible(loud, [clean, loud])
    many = 50_000.0  # facts, of which the faint one would be sure
    assert many * log(1.0 / 0.98) > DECISIVE + 2 * log(many)
    assert judge().allowed([clean, faint]) == [clean]
    assert judge().allowed([clean, loud], [("gravity_load",)]) == [clean]


def test_what_only_held_out_data_hear_of_is_not_left_out(monkeypatch) -> None:
    judging = judge(heldout=True, monkeypatch=monkeypatch)
    clean = Made((), 12.0, heldout=500.0)
    shown, not_shown = (
        Made(("overstretch_protection",), 11.9, heldout=square) for square in (60.0, 200.0)
    )
    assert judging.allowed([clean, shown]) == [clean, shown]
    assert judging.allowed([clean, not_shown]) == [clean]
    lost = Made((), 12.0, heldout=np.inf)  # nobody asked how much
    assert judging.allowed([lost, shown]) == [lost]


def test_beside_slow_noise_that_was_given_more_has_to_be_heard() -> None:
    """As of a load that was computed: nobody knows its shape, and an effect may stand for it."""
    clean, near, far = Made((), 1.4), Made(("gravity_load",), 1.2), Made(("gravity_load",), 1.0)
    assert audible(near, [clean, near])
    floor = NoiseFloor(3e-3, "white", "what was given", spectrum=1e-3)
    recording = SimpleNamespace(static=False, noise={"joint_position": floor})
    for answer in (near, far):
        answer.result.problem.measurements = (recording,)
    assert not audible(near, [clean, near])
    assert audible(far, [clean, far])


def test_an_effect_may_stand_for_the_little_of_the_noise_whose_shape_is_unknown() -> None:
    clean, faint, loud = Made((), 1.1), Made(("gravity_load",), 1.06), Made(("gravity_load",), 1.0)
    floor = NoiseFloor(1.04e-3, "white", "what was given", spectrum=1e-3)  # 7.5 % of it
    for answer in (clean, faint, loud):
        answer.result.problem.measurements = (
            SimpleNamespace(static=False, noise={"joint_position": floor}),
        )
    assert not audible(faint, [clean, faint])
    assert audible(loud, [clean, loud])


def test_against_a_large_error_only_a_share_of_it_is_heard() -> None:
    rough, better = Made((), 100.0), Made(("gravity_load",), 99.0)
    assert not audible(better, [rough, better])
    # beside a set that is none of its parts nothing is asked
    assert audible(better, [COULOMB, better])


def test_beside_something_unknown_a_richer_law_has_to_be_heard_beside_a_simpler_one() -> None:
    simple = Made(("coulomb_friction",), 100.0)
    hardly, far = (Made(("lugre_friction",), square) for square in (90.0, 70.0))
    assert not audible(hardly, [simple, hardly])
    assert audible(far, [simple, far])
    # evidence decides where nothing unknown is left
    near, exact = Made(("coulomb_friction",), 1.2), Made(("lugre_friction",), 1.0)
    assert audible(exact, [near, exact])
    noise = {"joint_position": NoiseFloor(3e-3, "white", "what was given", spectrum=1e-3)}
    more, less = Made(("coulomb_friction",), 1.4), Made(("lugre_friction",), 1.2)
    for answer in (exact, less):
        answer.result.problem.measurements = (SimpleNamespace(static=False, noise=noise),)
    assert not audible(less, [more, less])
    assert audible(exact, [near, exact])  # it leaves nothing unknown


@pytest.mark.parametrize(
    ("fall", "word"),
    [(1.2, "perhaps"), (2.5, "perhaps"), (6.0, "probably"), (12.0, "surely"), (1e6, "surely")],
)
def test_beside_something_unknown_only_a_large_fall_is_sure(fall: float, word: str) -> None:
    assert hedge(beside_unknown(fall * 30.0, 30.0)) == word


def test_probabilities_sum_to_one() -> None:
    found = probabilities([3.0, 3.0, 3.0 + 2 * log(4.0), np.inf])
    assert sum(found) == pytest.approx(1.0)
    assert found[0] == found[1]
    assert found[0] / found[2] == pytest.approx(4.0)
    assert found[3] < 1e-300
    assert probabilities([]) == []
    assert probabilities([-1e6]) == [1.0]


def test_where_nothing_can_follow_a_held_out_recording_the_simplest_is_taken(monkeypatch) -> None:
    lost = [Made(added, 1.0, heldout=np.inf) for added in ((), ("coulomb_friction",))]
    found = judge(heldout=True, monkeypatch=monkeypatch)
    assert found.best(lost) is lost[0]
    assert probabilities(found.of(lost)) == [0.5, 0.5]


@pytest.mark.parametrize("effect", effects.CATALOGUE, ids=lambda effect: effect.id)
def test_typical_values_are_plausible(effect) -> None:
    for parameter in effect.parameters:
        path = f"effects.{effect.id}.{parameter.name}"
        assert is_plausible(GIVEN, path, typical_value(GIVEN, parameter))


def test_what_no_actuator_has_is_implausible() -> None:
    path = "effects.coulomb_friction.torque"
    parameter = effects.BY_ID["coulomb_friction"].parameters[0]
    typical = typical_value(GIVEN, parameter)
    assert is_plausible(GIVEN, path, 29.0 * typical)
    assert not is_plausible(GIVEN, path, 31.0 * typical)
    assert is_plausible(GIVEN, path, 0.0)


def test_a_shape_may_be_too_small_as_well() -> None:
    path = "effects.stribeck_friction.stribeck_velocity"
    parameter = next(
        part
        for part in effects.BY_ID["stribeck_friction"].parameters
        if part.name == "stribeck_velocity"
    )
    typical = typical_value(GIVEN, parameter)
    assert parameter.shape
    assert not is_plausible(GIVEN, path, typical / 31.0)


def test_where_an_angle_lies_is_the_machines_own() -> None:
    assert is_plausible(GIVEN, "effects.gravity_load.angle", 1e3)
    assert is_plausible(GIVEN, "link.inertia", 1e3)  # it has its prior


def test_no_answers_have_no_evidence() -> None:
    assert judge().of([]) == []


def test_what_errs_more_on_held_out_recordings_is_not_allowed(monkeypatch) -> None:
    found = judge(heldout=True, monkeypatch=monkeypatch)
    worse, better = (Made(("coulomb_friction",), 1.0, heldout=square) for square in (30.0, 0.9))
    assert found.allowed([BASE, worse]) == [BASE]
    assert found.allowed([BASE, better]) == [BASE, better]


def test_what_held_out_recordings_do_not_share_fades(monkeypatch) -> None:
    """Of the fitted errors nine tenths are explained: of the others half of that has to be."""
    found = judge(heldout=True, monkeypatch=monkeypatch)
    base = Made((), 11.0, heldout=5.0)
    much, little = (Made(("coulomb_friction",), 2.0, heldout=square) for square in (2.8, 3.6))
    assert not found.fades(much, base)
    assert found.fades(little, base)
    quiet = Made((), 11.0, heldout=1.2)  # where the effect would not show
    assert not found.fades(Made(("coulomb_friction",), 2.0, heldout=1.2), quiet)
    assert not found.fades(base, base)


@pytest.mark.parametrize(
    ("before", "after", "share"),
    [(0.9, 0.9, 0.0), (11.0, 6.0, 0.5), (2.0, 3.0, 0.0), (0.9, 0.5, 1.0)],
)
def test_what_is_explained_is_a_share_of_what_lies_beyond_the_noise(before, after, share) -> None:
    assert explained(before, after) == share

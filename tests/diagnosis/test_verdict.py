"""The verdict and its sentence follow from the numbers."""

from types import SimpleNamespace

import pytest

from elastic_tendon.comparison.comparison import Comparison, FileComparison, SignalError
from elastic_tendon.diagnosis import verdict
from elastic_tendon.diagnosis.lack_of_fit import LackOfFit
from elastic_tendon.diagnosis.options import Options
from elastic_tendon.diagnosis.result import RecordingSummary, Remaining
from elastic_tendon.diagnosis.verdict import (
    changed_parameters,
    contradicting_of,
    fall,
    hedge,
    matters_somewhere,
    no_chance,
    only_chance,
    remaining_of,
    sentence_of,
    unexplained,
    verdict_of,
)
from elastic_tendon.estimation.determinability import Estimate
from elastic_tendon.measurement import NoiseFloor

NAME = "joint_position"
RELEVANCE = 0.05
GRAVITY = ("gravity_load",)
NOISE = 1e-3  # rad


def comparison(ratio: float):
    """A model beside data from which it is so many times the noise."""
    return SimpleNamespace(
        model=SimpleNamespace(name="arm"),
        rmse=lambda: {NAME: ratio * NOISE},
        noise_ratio=lambda: {NAME: ratio},
        pooled=lambda _quantity: {NAME: NOISE},
    )


def left(*, significant: bool, matters: bool) -> dict[str, Remaining]:
    return {NAME: Remaining(2.0, 0.1, significant, matters, 0.01)}


NOTHING = left(significant=False, matters=False)


# ---- words ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("probability", "word"),
    [
        (1.0, "surely"),
        (0.99, "surely"),
        (0.989, "probably"),
        (0.9, "probably"),
        (0.899, "perhaps"),
        (0.0, "perhaps"),
    ],
)
def test_words_for_probabilities_are_fixed(probability: float, word: str) -> None:
    assert hedge(probability) == word


# ---- verdicts ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("added", "changed", "fell", "expected"),
    [
        ((), (), 0.0, "adequate"),
        ((), ("link.inertia",), 0.9, "wrong_parameter"),
        ((), ("link.inertia",), 0.04, "adequate"),  # the error hardly fell
        ((), (), 0.9, "adequate"),  # no parameter surely moved
        (("gravity_load",), (), 0.9, "missing_effect"),
        (("gravity_load",), ("link.inertia",), 0.9, "missing_effect"),
    ],
)
def test_the_verdict_is_that_of_the_contract(added, changed, fell, expected) -> None:
    assert verdict_of(added, changed, NOTHING, fell, RELEVANCE) == expected


@pytest.mark.parametrize("added", [(), ("gravity_load",)])
@pytest.mark.parametrize("changed", [(), ("link.inertia",)])
@pytest.mark.parametrize("fell", [0.0, 0.04, 1.0])
def test_no_model_is_adequate_while_what_is_left_matters(added, changed, fell) -> None:
    remaining = {"joint_torque": NOTHING[NAME], **left(significant=True, matters=True)}
    assert unexplained(remaining)
    assert verdict_of(added, changed, remaining, fell, RELEVANCE) == "unexplained"


@pytest.mark.parametrize(("significant", "matters"), [(True, False), (False, True), (False, False)])
def test_what_is_chance_or_too_little_to_matter_is_no_verdict(significant, matters) -> None:
    assert not unexplained(left(significant=significant, matters=matters))


def test_relevance_is_the_share_of_the_error_that_must_fall() -> None:
    for relevance, expected in ((0.2, "adequate"), (0.05, "wrong_parameter")):
        assert verdict_of((), ("link.inertia",), NOTHING, 0.1, relevance) == expected


def test_parameters_may_be_off_together() -> None:
    """Without a load only their ratios show: each alone may be what was given."""
    for as_given, expected in ((2.0, "adequate"), (100.0, "wrong_parameter")):
        found = verdict_of((), (), NOTHING, 0.9, RELEVANCE, as_given=as_given)
        assert found == expected
    assert sentence("wrong_parameter").startswith(
        "No effect is missing, but parameters are off together, of which these data determine none"
    )


# ---- what is left --------------------------------------------------------------------------------


def remaining(before: float, after: float, *, significant: bool = False, relevance: float = 0.0):
    lack = {NAME: LackOfFit(0.3, significant, (), 0.0)}
    return remaining_of(comparison(before), comparison(after), lack, relevance)[NAME]


def test_what_is_left_is_counted_above_the_noise() -> None:
    found = remaining(5.0, 2.0)
    assert found.noise_ratio == pytest.approx(2.0)
    assert found.share_of_initial == pytest.approx(3.0 / 24.0)
    assert found.p_value == 0.3
    assert remaining(5.0, 0.9).share_of_initial == 0.0


def test_it_is_significant_where_it_depends_on_the_state() -> None:
    assert not remaining(100.0, 10.0).significant
    assert remaining(100.0, 2.0, significant=True).significant


def test_it_matters_by_the_noise_however_far_off_the_given_model_was() -> None:
    assert not remaining(10.0, verdict.LEFT - 0.01).matters
    assert remaining(10.0, verdict.LEFT + 0.01).matters
    assert remaining(100.0, verdict.LEFT + 0.01).matters


def test_the_relevance_asked_for_is_a_share_of_the_error_as_given_above_the_noise() -> None:
    # of 100 times the noise 10 are left, both above it: sqrt(99 / 9999) = 9.95 %
    assert not remaining(100.0, 10.0, relevance=0.0996).matters
    assert remaining(100.0, 10.0, relevance=0.0994).matters
    # however little was asked for, noise does not matter
    assert not remaining(2.0, verdict.LEFT - 0.01, relevance=1e-6).matters
    # and where nothing helped, no share below 1 hides it
    assert remaining(2.0, 2.0, relevance=0.99).matters


@pytest.mark.parametrize(
    ("options", "matters"), [(Options(), True), (Options(relevance=0.05), False)]
)
def test_nothing_is_hidden_from_who_did_not_ask_for_it(options, matters) -> None:
    found = remaining(100.0, 3.0, significant=True, relevance=options.least_left)
    assert (found.significant, found.matters) == (True, matters)
    assert no_chance({NAME: found})
    assert options.least_change == RELEVANCE
    expected = "unexplained" if matters else "missing_effect"
    given = {NAME: found}, 0.97, options.least_change
    assert verdict_of(("gravity_load",), (), *given) == expected


def test_an_error_of_any_size_is_left_where_nothing_helped() -> None:
    found = remaining(50.0, 50.0, significant=True)
    assert found.share_of_initial == pytest.approx(1.0)
    assert found.significant
    assert found.matters


def test_where_that_was_not_judged_what_matters_is_no_chance() -> None:
    for after, significant in ((verdict.LEFT - 0.01, False), (verdict.LEFT + 0.01, True)):
        found = remaining_of(comparison(10.0), comparison(after), {})[NAME]
        assert (found.significant, found.p_value) == (significant, None)
        assert unexplained({NAME: found}) is significant


def test_the_fall_is_that_of_the_signal_where_it_is_largest() -> None:
    given, last = comparison(4.0), comparison(1.0)
    assert fall(given, last) == pytest.approx(0.75)
    given.rmse = lambda: {NAME: 4.0, "joint_torque": 0.0}
    last.rmse = lambda: {NAME: 4.0, "joint_torque": 0.0}
    assert fall(given, last) == 0.0


# ---- which parameters moved ----------------------------------------------------------------------


def answer_with(*estimates: Estimate):
    return SimpleNamespace(result=SimpleNamespace(findings=SimpleNamespace(estimates=estimates)))


def estimate(path: str, fitted: float, half_width: float, *, determined: bool = True) -> Estimate:
    interval = (fitted - half_width, fitted + half_width)
    return Estimate(path, "1", 1.0, fitted, 0.1, interval, determined)


@pytest.fixture(autouse=True)
def shown(monkeypatch) -> dict[str, float]:
    """By how many times the noise each shift shows; all of them loudly unless said."""
    known: dict[str, float] = {}
    monkeypatch.setattr(
        verdict, "_shown_by", lambda _, moved: {one.path: known.get(one.path, 9.0) for one in moved}
    )
    return known


def changed(*estimates: Estimate, ratio: float = 10.0):
    return changed_parameters(answer_with(*estimates), comparison(ratio), RELEVANCE)


@pytest.mark.parametrize(
    ("half_width", "moved"),
    # one sigma is 0.1; of few stretches of time the interval is wider than the usual 0.2
    [(0.2, ("link.inertia",)), (0.39, ("link.inertia",)), (0.41, ())],
)
def test_a_parameter_has_moved_only_where_its_interval_excludes_it(half_width, moved):
    assert changed(estimate("link.inertia", 1.4, half_width)) == (moved, ())


def test_of_many_parameters_one_that_barely_moved_is_chance() -> None:
    steady = [estimate(f"link.number_{number}", 1.0, 0.2) for number in range(19)]
    assert changed(estimate("link.inertia", 1.24, 0.2)) == (("link.inertia",), ())
    assert changed(estimate("link.inertia", 1.24, 0.2), *steady) == ((), ())


def test_effects_and_what_the_data_leave_open_do_not_count() -> None:
    effect = estimate("effects.coulomb_friction.torque", 2.0, 0.2)
    left_open = estimate("link.inertia", 2.0, 0.2, determined=False)
    assert changed(effect, left_open) == ((), ())


def test_a_shift_that_hardly_shows_is_told_apart(shown) -> None:
    shown["link.damping"] = 0.4
    both = estimate("link.inertia", 2.0, 0.2), estimate("link.damping", 2.0, 0.2)
    assert changed(*both) == (("link.inertia",), ("link.damping",))
    # beside a small error the same shift matters
    assert changed(*both, ratio=1.0) == (("link.inertia", "link.damping"), ())


# ---- sentences -----------------------------------------------------------------------------------


def sentence(kind, added=(), certainty=None, moved=(), after=1.04, alike=(), **said) -> str:
    given, last = comparison(162.3), comparison(after)
    said = {"complete": True, **said}
    return sentence_of(kind, added, certainty or {}, alike, moved, given, last, **said)


def test_an_adequate_model_is_said_so_with_what_is_left() -> None:
    assert sentence("adequate") == "arm explains these data: what is left is 1.04 times the noise."


def test_of_several_signals_the_one_that_errs_most_in_the_end_is_told() -> None:
    given, last = (
        SimpleNamespace(
            model=SimpleNamespace(name="arm"),
            noise_ratio=lambda ratios=ratios: ratios,
        )
        for ratios in ({NAME: 95.2, "motor_torque": 60.0}, {NAME: 2.89, "motor_torque": 18.0})
    )
    said = sentence_of("missing_effect", GRAVITY, {}, (), (), given, last, complete=True)
    assert "falls from 60.0 to 18.0 times the noise of motor torque" in said


def test_much_that_is_left_by_chance_is_said_to_be_so() -> None:
    assert sentence("adequate", after=3.46) == (
        "arm explains these data: what is left is 3.46 times the noise; this depends on the motion "
        "by no more than chance, as a disturbance would."
    )
    assert "chance" not in sentence("unexplained", after=3.46)


def test_what_is_no_chance_makes_nothing_sure_however_little_it_is() -> None:
    chance, little = LackOfFit(0.4, False, (), 0.02), LackOfFit(0.01, False, (), 0.1)
    assert only_chance({"joint_position": chance})
    assert not only_chance({"joint_position": chance, "joint_torque": little})


def test_what_is_no_chance_but_too_small_to_matter_is_told() -> None:
    words = "; some of that depends on the motion by more than chance, but is too small to matter."
    for kind in ("adequate", "wrong_parameter", "missing_effect"):
        assert sentence(kind, structured=True, after=1.4).endswith(words)
    assert sentence("wrong_parameter", structured=True).startswith("No effect that matters is")
    assert "too small" not in sentence("unexplained", structured=True, after=3.4)


@pytest.mark.parametrize("kind", ["adequate", "wrong_parameter", "missing_effect"])
def test_what_was_not_to_matter_is_told_with_its_size_and_not_called_chance(kind) -> None:
    said = sentence(kind, ("gravity_load",), moved=("link.inertia",), after=9.14, ignored=0.125)
    assert said.endswith(
        "9.14 times the noise; what of it is no chance is less than 12.5 % of the error as given, "
        "and was not to matter."
    )
    assert "matter" not in sentence("unexplained", after=9.14, ignored=0.125)


def test_what_may_be_there_instead_is_named_once() -> None:
    alike = ("stribeck_friction", "", "stribeck_friction", "gravity_load+joint_stop")
    said = sentence("missing_effect", ("coulomb_friction",), alike=alike)
    assert "friction, Stribeck friction or Gravity load with Joint stop is perhaps missing" in said
    nothing = sentence("missing_effect", ("coulomb_friction",), alike=("",))
    assert "Coulomb friction is perhaps missing:" in nothing


def test_wrong_parameters_are_listed() -> None:
    said = sentence("wrong_parameter", moved=("link.inertia",))
    assert said == (
        "No effect is missing, but link.inertia is off: refitted, the error falls from 162 to "
        "1.04 times the noise."
    )
    assert "link.inertia, link.damping are off" in sentence(
        "wrong_parameter", moved=("link.inertia", "link.damping")
    )


@pytest.mark.parametrize(
    ("probability", "word"), [(0.999, "surely"), (0.95, "probably"), (0.4, "perhaps")]
)
def test_a_missing_effect_is_hedged(probability, word) -> None:
    said = sentence("missing_effect", ("gravity_load",), {"gravity_load": probability})
    assert said == (
        f"Gravity load is {word} missing: the error falls from 162 to 1.04 times the noise."
    )


def test_several_effects_are_listed_each_with_its_own_certainty() -> None:
    pair = ("gravity_load", "coulomb_friction")
    alike = sentence("missing_effect", pair, dict.fromkeys(pair, 1.0))
    assert alike.startswith("Gravity load and Coulomb friction are surely missing: ")
    unlike = sentence("missing_effect", pair, {"gravity_load": 1.0, "coulomb_friction": 0.5})
    assert unlike.startswith("Missing: Gravity load surely, Coulomb friction perhaps: ")
    three = (*pair, "quadratic_drag")
    listed = sentence("missing_effect", three, dict.fromkeys(three, 1.0))
    assert listed.startswith("Gravity load, Coulomb friction and ")


def test_what_may_be_there_instead_is_said_with_it() -> None:
    said = sentence(
        "missing_effect",
        ("gear_backlash",),
        {"gear_backlash": 1.0},
        alike=("coulomb_friction+gravity_load", "lugre_friction"),
    )
    assert said.startswith(
        "Gear backlash, Coulomb friction with Gravity load or LuGre friction is surely missing, "
        "and these data do not tell which: "
    )
    pair = ("gear_backlash", "quadratic_drag")
    said = sentence("missing_effect", pair, dict.fromkeys(pair, 1.0), alike=("lugre_friction",))
    assert said.startswith(
        "Gear backlash and Quadratic drag are surely missing, or else LuGre friction, which these "
        "data do not tell apart: "
    )


def test_of_many_rivals_a_sentence_names_the_first_and_counts_the_others() -> None:
    many = ("lugre_friction", "coulomb_friction+gravity_load", "quadratic_drag", "joint_stop")
    alone = {"gear_backlash": 1.0}
    said = sentence("missing_effect", ("gear_backlash",), alone, alike=many)
    assert said.startswith(
        "Gear backlash, LuGre friction, Coulomb friction with Gravity load or one of 2 others is "
        "surely missing, and these data do not tell which: "
    )
    three = sentence("missing_effect", ("gear_backlash",), alone, alike=many[:3])
    assert "Quadratic drag" in three
    assert "others" not in three
    pair = ("gear_backlash", "spring_relaxation")
    said = sentence("missing_effect", pair, dict.fromkeys(pair, 1.0), alike=many)
    assert ", or else LuGre friction, Coulomb friction with Gravity load or one of 2 others, " in (
        said
    )


def test_an_effect_of_unknown_certainty_is_perhaps_missing() -> None:
    assert "is perhaps missing" in sentence("missing_effect", ("gravity_load",))


def test_what_nothing_explains_is_said_with_its_size() -> None:
    assert sentence("unexplained", after=9.14) == (
        "Something is missing that no effect of the catalogue explains: 9.14 times the noise is "
        "left."
    )
    beside = sentence("unexplained", ("gravity_load",), {"gravity_load": 1.0}, after=12.34)
    assert beside == (
        "Gravity load is surely missing; beyond it 12.3 times the noise is left that no effect of "
        "the catalogue explains."
    )


def test_no_more_effects_are_spoken_of_than_were_tried() -> None:
    gravity = ("unexplained", ("gravity_load",), {"gravity_load": 1.0})
    assert "that no effect of the catalogue explains" in sentence("unexplained", after=9.1)
    assert "that no effect that was asked for explains" in sentence(
        "unexplained", after=9.1, chosen=True
    )
    assert "is left that no effect that was asked for explains" in sentence(
        *gravity, after=9.1, chosen=True
    )
    assert sentence(*gravity, after=9.1, complete=False).endswith(
        "9.10 times the noise is left that no effect tried so far explains; the search was stopped "
        "before its end."
    )
    assert sentence("unexplained", after=9.1, complete=False).startswith(
        "No effect tried so far explains these data: 9.10 times the noise is left; "
    )


@pytest.mark.parametrize("kind", ["adequate", "wrong_parameter", "missing_effect", "unexplained"])
def test_a_search_that_was_stopped_says_so(kind) -> None:
    said = sentence(kind, complete=False)
    assert said.endswith("; the search was stopped before its end.")


def test_a_recording_that_is_not_explained_has_the_veto_and_is_named() -> None:
    assert verdict_of((), (), NOTHING, 0.0, RELEVANCE, "second.csv") == "unexplained"
    assert verdict_of(("gravity_load",), (), NOTHING, 0.9, RELEVANCE, "x.csv") == "missing_effect"
    assert sentence("unexplained", elsewhere="second.csv") == (
        "Something is missing that the fitted recordings do not show: 1.04 times the noise is left "
        "there; second.csv, which was held out, is not explained."
    )


# ---- recordings that contradict one another ------------------------------------------------------


def summary(file: str, *contradicts: str, role="fitted") -> RecordingSummary:
    return RecordingSummary(file, role, {}, contradicts=contradicts)


def test_the_recording_that_contradicts_most_fitted_ones_is_told_first() -> None:
    three = [summary("a", "c"), summary("b", "c"), summary("c", "a", "b")]
    assert contradicting_of(three) == ("c", "a", "b")
    assert contradicting_of([summary("a"), summary("b")]) == ()
    # what was held out has a verdict of its own
    assert contradicting_of([summary("a", "x"), summary("x", "a", role="validation")]) == ()


@pytest.mark.parametrize("added", [(), ("gravity_load",)])
def test_no_model_explains_recordings_that_contradict_one_another(added) -> None:
    assert verdict_of(added, (), NOTHING, 0.9, RELEVANCE, "", ("c", "a", "b")) == "unexplained"
    said = sentence("unexplained", added, after=2.0, contradicting=("c", "a", "b"))
    assert "2.00 times the noise is left" in said
    assert said.endswith("; c contradicts a and b: no parameters suit them together.")


def in_files(*ratios: float) -> Comparison:
    """A model beside recordings from each of which it is so many times the noise."""
    floor = NoiseFloor(NOISE, "white")
    errors = [
        SignalError(ratio * NOISE, 0.0, 0.0, None, ratio, 100, noise=floor, slack_states={})
        for ratio in ratios
    ]
    return Comparison(None, tuple(FileComparison(None, None, None, {NAME: e}) for e in errors))


def test_what_is_left_may_matter_in_one_recording_and_not_over_all() -> None:
    given, last = in_files(*[9.0] * 8), in_files(2.0, *[1.0] * 7)
    assert not remaining_of(given, last, {})[NAME].matters
    assert matters_somewhere(given, last, 0.0)
    assert not matters_somewhere(given, in_files(*[1.4] * 8), 0.0)
    assert not matters_somewhere(given, last, 0.3)

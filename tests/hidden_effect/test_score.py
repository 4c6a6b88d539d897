"""The score of single results and of the table's rows, by results made by hand."""

import math
from dataclasses import replace
from typing import Any

import pytest

from hidden_effect.score import (
    Figure,
    Result,
    class_among,
    covered,
    decided,
    figures,
    found_both,
    limit_ratio,
    percentile,
    ranked,
    told_apart,
    true_class,
    undecidable,
)

COULOMB, STRIBECK = "coulomb_friction", "stribeck_friction"


def said(*added: str, first: tuple[str, ...] = (), **more: Any) -> dict[str, Any]:
    """A diagnosis JSON that adds some effects, with candidates of its first round."""
    candidates = [{"ids": [effect_id]} for effect_id in first or added]
    return {
        "verdict": "missing_effect" if added else "adequate",
        "added": list(added),
        "rounds": [{"chosen": list(added[:1]), "candidates": candidates}],
        "ladder": [{"heldout_rmse": {"joint_position": 1.01e-4}}],
        "parameters": [],
        "indistinguishable": [],
    } | more


RESULT = Result(
    name="coulomb",
    family="effect",
    effects=(COULOMB,),
    ratio=1.0,
    experiment="multisine",
    noise="white",
    interpolation="cubic",
    samples=5000,
    rivals={COULOMB: {COULOMB: 0.0, "": 4000.0, STRIBECK: 17.0, "gear_backlash": 6.0}},
    numbers={"link.inertia": 0.03, "link.damping": 0.1},
    floor={"joint_position": 1e-4},
    diagnosis=said(COULOMB),
    follow_up=None,
    seconds=10.0,
)
NOTHING = replace(RESULT, name="nothing", family="nothing", effects=(), rivals={}, diagnosis=said())


def figure(results: list[Result], what: str) -> Figure:
    (found,) = [one for one in figures(results) if what in one.what]
    return found


def test_a_class_is_what_lies_within_ten_of_the_truth():
    assert true_class(RESULT, COULOMB) == {COULOMB, "gear_backlash"}
    law = replace(RESULT, effects=("Dahl friction",), rivals={})
    assert "lugre_friction" in true_class(law, "Dahl friction")


@pytest.mark.parametrize(
    ("first", "among_one", "among_three"),
    [
        ((COULOMB,), True, True),
        (("gear_backlash",), True, True),
        ((STRIBECK, "spring_mass", COULOMB), False, True),
        ((STRIBECK, "spring_mass", "gravity_load", COULOMB), False, False),
        ((), True, True),
    ],
)
def test_the_first_candidates_count(first, among_one, among_three):
    result = replace(RESULT, diagnosis=said(COULOMB, first=first))
    assert class_among(result, 1) is among_one
    assert class_among(result, 3) is among_three


def test_no_round_and_no_effect_are_right_only_where_none_is_needed():
    silent = replace(RESULT, diagnosis=said(rounds=[]))
    assert ranked(silent) == [""]
    assert not class_among(silent, 3)
    aliased = replace(silent, rivals={COULOMB: {"": -8.0, COULOMB: 0.0}})
    assert class_among(aliased, 1)


def test_a_set_is_not_the_effect_alone():
    listed = [{"ids": [COULOMB, "gravity_load"]}, {"ids": [COULOMB]}]
    result = replace(RESULT, diagnosis=said(rounds=[{"candidates": listed}]))
    assert ranked(result) == [f"{COULOMB}+gravity_load", COULOMB]
    assert not class_among(result, 1)


def test_the_limit_strength_is_that_at_which_the_nearest_rival_costs_ten():
    # no more numbers than the truth: misfit 6 at R = 1, so 10 at sqrt(10 / 6)
    assert limit_ratio(RESULT, COULOMB) == pytest.approx(math.sqrt(10.0 / 6.0))
    # two more numbers cost 17 without any misfit, so the truth is ahead at every strength
    nested = replace(RESULT, rivals={COULOMB: {COULOMB: 0.0, STRIBECK: 17.04}})
    assert limit_ratio(nested, COULOMB) == 0.0
    # a rival that needs no misfit is never beaten
    alias = replace(RESULT, rivals={COULOMB: {COULOMB: 0.0, "gear_backlash": 0.0}})
    assert limit_ratio(alias, COULOMB) == math.inf


def test_exact_effects_are_asked_for_only_where_the_truth_is_clearly_ahead():
    clear = replace(RESULT, rivals={COULOMB: {COULOMB: 0.0, "gear_backlash": 50.0}})
    assert figure([RESULT, clear], "exact effect").count == 1
    wrong = replace(clear, name="wrong", diagnosis=said("gear_backlash"))
    found = figure([clear, wrong], "exact effect")
    assert (found.value, found.missed, found.met) == (50.0, ("wrong",), False)


def test_what_is_blamed_when_nothing_is_missing_counts_for_its_noise():
    alarmed = replace(NOTHING, name="alarmed", diagnosis=said(COULOMB))
    unknown = replace(
        NOTHING, name="unknown", noise="coloured", diagnosis=said(verdict="unexplained")
    )
    shifted = replace(NOTHING, diagnosis=said(verdict="wrong_parameter"))
    results = [NOTHING, shifted, alarmed, unknown]
    assert figure(results, "nothing is, white").value == pytest.approx(100.0 / 3.0)
    assert figure(results, "nothing is, white").missed == ("alarmed",)
    assert figure(results, "nothing is, coloured").missed == ("unknown",)
    assert figure(results, "nothing is, quantised").met is None


def test_wrong_parameters_and_missing_effects_are_told_apart():
    wrong = replace(NOTHING, family="wrong parameter")
    assert told_apart(replace(wrong, diagnosis=said(verdict="wrong_parameter")))
    assert not told_apart(wrong)
    assert not told_apart(replace(wrong, diagnosis=said(COULOMB)))
    assert told_apart(RESULT)
    assert not told_apart(replace(RESULT, diagnosis=said(verdict="wrong_parameter")))


def test_an_effect_outside_the_catalogue_is_to_be_unknown_and_not_blamed():
    outside = replace(
        RESULT, family="outside", effects=("cogging",), diagnosis=said(verdict="unexplained")
    )
    blamed = replace(outside, name="blamed", diagnosis=said(COULOMB, verdict="unexplained"))
    assert figure([outside, blamed], "called unexplained").value == 100.0
    assert figure([outside, blamed], "blamed").missed == ("blamed",)


def test_what_is_called_surely_missing_is_to_be_missing():
    right = replace(RESULT, diagnosis=said(COULOMB, certainty={COULOMB: 0.995}))
    blamed = replace(
        NOTHING, name="blamed", diagnosis=said(COULOMB, certainty={COULOMB: 1.0, STRIBECK: 0.5})
    )
    found = figure([right, blamed, RESULT], "called surely missing")
    assert (found.value, found.count, found.missed) == (pytest.approx(50.0), 2, ("blamed",))
    assert figure([right, blamed], "called perhaps missing").value == 0.0


def test_both_of_two_effects_are_found_in_any_order_and_by_their_classes():
    rivals = {
        COULOMB: {COULOMB: 0.0, STRIBECK: 3.0},
        "gravity_load": {"gravity_load": 0.0, COULOMB: 900.0},
    }
    two = replace(RESULT, effects=(COULOMB, "gravity_load"), rivals=rivals)
    assert found_both(replace(two, diagnosis=said("gravity_load", STRIBECK)))
    assert not found_both(replace(two, diagnosis=said(COULOMB)))


def test_intervals_are_judged_only_where_determined_and_the_model_has_the_true_effects():
    numbers = [
        {"path": "link.inertia", "interval": [0.029, 0.031], "determined": True},
        {"path": "link.damping", "interval": [0.11, 0.2], "determined": True},
        {"path": "link.damping", "interval": [0.11, 0.2], "determined": False},
    ]
    result = replace(RESULT, diagnosis=said(COULOMB, parameters=numbers))
    assert covered(result) == [True, False]
    other = replace(RESULT, diagnosis=said(STRIBECK, parameters=numbers))
    assert figure([result, other], "truth, at least").count == 2


def test_a_proposed_experiment_decides_when_only_the_truth_is_left():
    pair = [[COULOMB, "gear_backlash"]]
    asked = replace(RESULT, diagnosis=said(COULOMB, indistinguishable=pair))
    assert figure([asked, RESULT], "undecidable pairs").value == 50.0
    assert not decided(asked)
    assert decided(replace(asked, follow_up=said(COULOMB)))
    assert not decided(replace(asked, follow_up=said(COULOMB, indistinguishable=pair)))
    assert not decided(replace(asked, follow_up=said("gear_backlash")))


def test_a_law_with_needless_numbers_is_no_rival_of_the_simple_one():
    weak = {STRIBECK: 0.0, COULOMB: -16.0, "tendon_guide_friction": -14.0, "": 30.0}
    result = replace(RESULT, effects=(STRIBECK,), rivals={STRIBECK: weak})
    assert true_class(result, STRIBECK) == {STRIBECK, COULOMB, "tendon_guide_friction"}
    assert undecidable(result) == {COULOMB, "tendon_guide_friction"}


def test_what_no_experiment_decides_is_not_asked_of_one():
    offsets = ("joint_encoder_offset", "motor_encoder_offset")
    said_so = said(offsets[1], indistinguishable=[offsets])
    result = replace(
        RESULT,
        effects=offsets[:1],
        rivals={offsets[0]: dict.fromkeys(offsets, 0.0)},
        diagnosis=said_so,
    )
    assert figure([result], "undecidable pairs").value == 100.0
    assert figure([result], "then decides").count == 0
    # with a third answer the experiment has something to decide
    third = {offsets[0]: dict.fromkeys((*offsets, "gravity_load"), 0.0)}
    asked = replace(result, rivals=third, follow_up=said_so)
    assert figure([asked], "then decides").value == 100.0


def test_held_out_errors_are_in_units_of_the_floor():
    worse = replace(
        RESULT, name="worse", diagnosis=said(ladder=[{"heldout_rmse": {"joint_position": 2e-4}}])
    )
    found = figure([RESULT, worse], "floor, 95th percentile")
    assert (found.value, found.missed) == (pytest.approx(2.0), ("worse",))
    assert figure([RESULT, RESULT, worse], "floor, median").value == pytest.approx(1.01)


def test_harder_cases_stand_in_rows_of_their_own():
    harder = [
        replace(RESULT, noise="coloured", diagnosis=said(STRIBECK)),
        replace(RESULT, interpolation="linear", diagnosis=said(STRIBECK)),
        replace(RESULT, experiment="only taut", diagnosis=said(STRIBECK)),
    ]
    results = [RESULT, *harder]
    assert figure(results, "class first, R ≥ 0.3").count == 1
    assert figure(results, "class first, coloured noise").value == 0.0
    assert figure(results, "straight lines").count == 1
    assert figure(results, "only taut only").count == 1


@pytest.mark.parametrize(("part", "expected"), [(0.95, 19), (0.5, 10), (1.0, 20)])
def test_percentiles_are_values_that_occur(part, expected):
    assert percentile(range(1, 21), part) == expected


def test_no_result_makes_a_table_without_verdicts():
    assert all(one.met is None for one in figures([]))

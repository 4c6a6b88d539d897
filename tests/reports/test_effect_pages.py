"""The page of an effect and its picture show the declaration and the experiments as they are."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from rich.console import Console

from elastic_tendon.actuator.parameters import load_model, typical_value
from elastic_tendon.effects import BY_ID, CATALOGUE
from elastic_tendon.effects.base import Effect, Slot
from elastic_tendon.reports.effects import ACTS_ON, effect_page
from elastic_tendon.reports.signature_figure import signature_figure
from elastic_tendon.simulation.signature import signature

WIDTH = 80


@pytest.fixture(scope="module")
def example():
    return load_model("biorob_x4_joint_3")


def printed(page) -> str:
    console = Console(width=WIDTH, force_terminal=False)
    with console.capture() as capture:
        console.print(page, highlight=False)
    return capture.get()


def in_one_line(page) -> str:
    return " ".join(printed(page).split())


def test_every_slot_has_words():
    assert ACTS_ON.keys() == set(Slot)


@pytest.mark.parametrize("effect", CATALOGUE, ids=lambda effect: effect.id)
def test_page_has_all_that_is_declared(effect, example):
    page = in_one_line(effect_page(effect, example))
    texts = (effect.physics, effect.in_data, effect.law, effect.confused_with, effect.confirm)
    for text in (*texts, effect.cure, effect.magnitude, effect.reference, ACTS_ON[effect.slot]):
        assert text in page
    for parameter in effect.parameters:
        unit = parameter.unit.replace(".", "·")
        for written in ("m2", "m3", "rad2", "rad3", "s2", "s3"):
            unit = unit.replace(written, written[:-1] + "²³"[int(written[-1]) - 2])
        assert f"effects.{effect.id}.{parameter.name} ({unit})" in page
        assert (
            f"typical {typical_value(example, parameter):.3g}, default {parameter.null:g}" in page
        )
        assert parameter.meaning in page
    for state in effect.states:
        assert f"{effect.id}.{state.name}" in page
    for alias in BY_ID.aliases_of(effect):
        assert alias.when in page


def test_page_keeps_within_the_terminal(example):
    for effect in CATALOGUE:
        lines = printed(effect_page(effect, example)).splitlines()
        assert max(len(line) for line in lines) <= WIDTH


def test_page_names_what_is_excluded(example):
    page = in_one_line(effect_page(BY_ID["stribeck_friction"], example))
    assert "Not together with coulomb_friction, lugre_friction: a model takes one law of" in page
    assert "Not together with" not in in_one_line(effect_page(BY_ID["gear_backlash"], example))


def test_page_leaves_out_what_an_effect_does_not_say(example):
    bare = Effect(
        id="bare",
        title="Bare",
        slot=Slot.JOINT_TORQUE,
        physics="Physics.",
        in_data="Data.",
        parameters=(),
        equations=lambda *_: None,
        reference="a book",
    )
    headings = [line for line in printed(effect_page(bare, example)).splitlines() if line]
    assert [line for line in headings if not line.startswith(" ")] == [
        "Bare (bare)",
        "What it is",
        "Acts on",
        "How it shows in data",
        "Reference",
    ]


@pytest.fixture(scope="module")
def backlash(example):
    return signature(BY_ID["gear_backlash"], example)


def test_picture_draws_the_experiments_with_units(backlash):
    figure = signature_figure(backlash)
    labels = [(axes.get_xlabel(), axes.get_ylabel()) for axes in figure.axes]
    assert labels == [
        ("measured deflection (rad)", "load torque (N·m)"),
        ("measured deflection (rad)", "torque of the tendons on the joint (N·m)"),
        ("time (s)", "measured joint position (rad)"),
    ]
    slow = {line.get_label(): line for line in figure.axes[0].lines}
    assert np.array_equal(slow["without"].get_xdata(), backlash.slow_loop.without.x)
    assert np.array_equal(slow["with the effect"].get_ydata(), backlash.slow_loop.with_it.y)
    step = {line.get_label(): line for line in figure.axes[2].lines}
    assert np.array_equal(step["motor"].get_ydata(), backlash.motor.y)
    assert plt.get_fignums() == []  # nothing is left open in pyplot


def test_picture_says_how_strong_the_effect_is(backlash):
    title = " ".join(signature_figure(backlash).get_suptitle().split())
    gap = backlash.numbers["gap"]
    assert f"{backlash.times_typical:g} × the typical size" in title
    assert f"gap = {gap:.3g} rad" in title


def test_picture_says_where_nothing_is_to_be_seen(example):
    hidden = signature_figure(signature(BY_ID["joint_stop"], example))
    titles = [axes.get_title(loc="left") for axes in hidden.axes]
    assert ["hardly any difference" in title for title in titles] == [True, False, False]

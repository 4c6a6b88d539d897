"""What users learn from an effect's declaration is there, and names what it speaks of."""

import re

import pytest

import name_effects
from elastic_tendon import effects as effects_room
from elastic_tendon.effects import CATALOGUE

SENTENCES = ("physics", "in_data", "confused_with", "confirm", "cure", "magnitude")
# look-alikes that are numbers or inputs of the base model
BASE = ("damping", "inertia", "stiffness", "springs", "radius", "load")
YEAR = re.compile(r"\b(19|20)\d\d\b")

effects = pytest.mark.parametrize("effect", CATALOGUE, ids=lambda effect: effect.id)


@effects
@pytest.mark.parametrize("field", SENTENCES)
def test_texts_are_sentences(effect, field):
    text = getattr(effect, field)
    assert text.endswith(".")
    assert "  " not in text
    assert len(text.split()) >= 12


@effects
def test_law_names_every_parameter(effect):
    missing = [
        parameter.name for parameter in effect.parameters if parameter.name not in effect.law
    ]
    assert not missing


@effects
def test_look_alikes_are_called_by_their_titles(effect):
    """Each look-alike starts a sentence, "Title: what tells it apart"."""
    titles = {listed.title for listed in CATALOGUE} - {effect.title}
    named = [title for title in titles if title.lower() in effect.confused_with.lower()]
    assert named
    for sentence in effect.confused_with.rstrip(".").split(". "):
        subject, colon, difference = sentence.partition(": ")
        assert any(name.lower() in subject.lower() for name in (*titles, *BASE)), sentence
        assert colon
        assert len(difference.split()) >= 3


def test_looking_alike_is_mutual():
    def named(effect):
        text = effect.confused_with.lower()
        return {
            listed.id
            for listed in CATALOGUE
            if listed is not effect and listed.title.lower() in text
        }

    pairs = {(effect.id, rival) for effect in CATALOGUE for rival in named(effect)}
    assert not [(first, second) for first, second in pairs if (second, first) not in pairs]


@effects
def test_in_data_says_in_which_state_and_at_which_speed(effect):
    text = effect.in_data.lower()
    assert re.search(r"slack|taut|every motion", text)
    assert re.search(r"speed|velocity|motion|frequency|fast", text)


@effects
def test_reference_is_a_publication_or_the_paper(effect):
    assert YEAR.search(effect.reference) or "the paper" in effect.reference


def test_the_catalogue_has_a_stable_order_and_names_that_type_checkers_know():
    orders = [effect.catalogue_order for effect in CATALOGUE]
    assert orders == sorted(set(orders))
    assert all(getattr(effects_room, effect.id) is effect for effect in CATALOGUE)
    told = "run build_scripts/name_effects.py"
    assert name_effects.STUB.read_text(encoding="utf-8") == name_effects.names(), told

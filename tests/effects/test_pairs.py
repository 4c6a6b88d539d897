"""Every two effects together: they compose, in any order, and each still vanishes at its null.

A sample of the pairs runs in CI, all of them with ``-m slow``.
"""

from itertools import combinations

import numpy as np
import pytest
from contract_cases import (
    CROOKED,
    assert_sensitivities_agree_with_differences,
    measured,
    with_typical,
)

from effects_at import placed
from elastic_tendon.effects import CATALOGUE
from elastic_tendon.errors import ModelError

NULL_ERROR = 1e-8  # rad
DIFFERENCES = 1e-4  # relative: two effects have more events, at which differences lose digits
SAMPLE = 12  # of twenty that are drawn

ALLOWED = [
    pair
    for pair in combinations(CATALOGUE, 2)
    if not pair[0].law_of or pair[0].law_of != pair[1].law_of
]
REFUSED = [pair for pair in combinations(CATALOGUE, 2) if pair not in ALLOWED]
IN_CI = set(np.random.default_rng(5).choice(len(ALLOWED), 20, replace=False)[:SAMPLE])


def name(pair):
    return "-".join(effect.id for effect in pair)


allowed = pytest.mark.parametrize(
    "pair",
    [
        pytest.param(pair, id=name(pair), marks=[] if i in IN_CI else [pytest.mark.slow])
        for i, pair in enumerate(ALLOWED)
    ],
)


@allowed
def test_two_effects(pair):
    first, second = pair
    model = with_typical(with_typical(CROOKED, first), second)
    reverse = with_typical(with_typical(CROOKED, second), first)
    both = measured(model, tolerance=1e-11)
    assert np.isfinite(both).all()
    assert np.array_equal(both, measured(reverse, tolerance=1e-11))
    for kept, dropped in (pair, pair[::-1]):
        alone = placed(with_typical(CROOKED, kept), dropped)
        vanished = measured(alone.with_effect(dropped.id, None), tolerance=1e-11)
        assert np.abs(vanished - measured(alone, tolerance=1e-11)).max() < NULL_ERROR, dropped.id


@allowed
def test_sensitivities_of_two_effects(pair):
    model = with_typical(with_typical(CROOKED, pair[0]), pair[1])
    paths = [path for path in model.values() if path.startswith("effects.")]
    assert_sensitivities_agree_with_differences(model, paths, DIFFERENCES)


def test_a_spring_that_its_damper_slackens_may_have_a_tendon_that_does_not_stretch():
    """The tendon became taut again at once, and so on without end."""
    values = {"transmission.upper_spring.damping": 60.0, "transmission.lower_spring.damping": 60.0}
    relaxing = {"stiffness": 6e4, "time_constant": 2e-3}
    model = CROOKED.with_values(values).with_effect("spring_relaxation", relaxing)
    both = measured(model.with_effect("tendon_compliance", None), tolerance=1e-11)
    assert np.abs(both - measured(model, tolerance=1e-11)).max() < NULL_ERROR


@pytest.mark.parametrize("pair", REFUSED, ids=name)
def test_two_laws_of_the_same_are_refused(pair):
    with pytest.raises(ModelError, match="both laws of"):
        with_typical(with_typical(CROOKED, pair[0]), pair[1])


def test_there_are_pairs_of_both_kinds():
    assert len(ALLOWED) > 100
    assert len(REFUSED) == 3

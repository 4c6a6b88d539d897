"""Which effects a model can take, and where the search for each begins."""

import numpy as np
import pytest

from elastic_tendon import effects
from elastic_tendon.diagnosis.candidates import candidates, shapes
from elastic_tendon.parameters import load_model


def test_all_effects_are_candidates_of_the_bare_model() -> None:
    assert candidates(load_model("biorob_x4_joint_3")) == effects.BY_ID.ids()


def test_a_law_excludes_others_of_the_same_thing() -> None:
    model = load_model("biorob_x4_joint_3").with_effect("stribeck_friction", None)
    left = candidates(model)
    assert "stribeck_friction" not in left
    assert "lugre_friction" not in left
    assert "gravity_load" in left


@pytest.mark.parametrize("effect_id", [one.id for one in effects.CATALOGUE])
def test_every_shape_tried_is_allowed(effect_id, sticking) -> None:
    known, recording, _ = sticking
    effect = effects.BY_ID[effect_id]
    tried = list(shapes(known.model, effect, [recording]))
    assert tried
    assert len(tried) == len({tuple(one.values()) for one in tried})
    bounds = {one.name: (one.lower, one.upper) for one in effect.parameters}
    for values in tried:
        assert all(bounds[name][0] <= value <= bounds[name][1] for name, value in values.items())


def test_stops_are_sought_at_the_ends_of_the_range(sticking) -> None:
    known, recording, _ = sticking
    position = recording.signals["joint_position"]
    tried = list(shapes(known.model, effects.BY_ID["joint_stop"], [recording]))
    low = sorted({one["lower"] for one in tried})
    assert np.all(np.array(low[1:]) > position.min())
    assert low[1] - position.min() < 0.01 * np.ptp(position)

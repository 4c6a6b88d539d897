"""Which effects a model can take, and where the search for each begins."""

import numpy as np
import pytest

from elastic_tendon import effects
from elastic_tendon.diagnosis.candidates import candidates, shapes
from elastic_tendon.identify.initial_state import estimate_initial_state
from elastic_tendon.identify.residuals import simulate_measurement
from elastic_tendon.measurement import Measurement
from elastic_tendon.parameters import load_model


def test_all_effects_are_candidates_of_the_bare_model(sticking) -> None:
    _, recording, _ = sticking
    assert candidates(load_model("biorob_x4_joint_3"), [recording]) == effects.BY_ID.ids()


def static_curve(load: np.ndarray, position: np.ndarray) -> Measurement:
    time = 1000.0 * np.arange(len(load))
    signals = {"joint_position": position}
    return Measurement("curve", time, 0.0 * time, signals, load_torque=load, static=True)


def test_a_mass_is_sought_only_where_something_moves(sticking) -> None:
    _, recording, _ = sticking
    model = load_model("biorob_x4_joint_3")
    curve = static_curve(np.zeros(10), np.zeros(10))
    left = candidates(model, [curve, curve])
    assert left == tuple(one for one in effects.BY_ID.ids() if one != "spring_mass")
    assert candidates(model, [curve, recording]) == effects.BY_ID.ids()


def test_a_static_curve_is_the_same_with_masses_in_the_springs() -> None:
    """Damped well, so that few steps are needed; slack states included."""
    bare = load_model("biorob_x4_joint_3")
    heavy = bare.with_effect("spring_mass", {"mass": 0.3, "damping": 100.0})
    load = np.concatenate([np.linspace(0.0, 8.0, 5), np.linspace(6.0, -8.0, 8)])
    curve = static_curve(load, np.zeros(len(load)))
    light, loaded = (
        simulate_measurement(one, curve, estimate_initial_state(one, curve))["joint_position"]
        for one in (bare, heavy)
    )
    assert np.ptp(light) > 0.2  # beyond both slack boundaries, +-0.115 rad
    assert loaded == pytest.approx(light, abs=1e-7)


def test_a_law_excludes_others_of_the_same_thing(sticking) -> None:
    _, recording, _ = sticking
    model = load_model("biorob_x4_joint_3").with_effect("stribeck_friction", None)
    left = candidates(model, [recording])
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

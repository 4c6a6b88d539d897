"""Which effects a model can take, and where the search for each begins."""

from dataclasses import replace

import numpy as np
import pytest

from effects_at import loaded_at_position, seen_in_positions
from elastic_tendon import effects
from elastic_tendon.actuator.parameters import load_model, typical_value
from elastic_tendon.comparison.initial_state import estimate_initial_state
from elastic_tendon.comparison.residuals import simulate_measurement
from elastic_tendon.diagnosis.candidates import (
    LITTLE_DAMPING,
    candidates,
    sensible,
    shapes,
    starts,
)
from elastic_tendon.measurement import Measurement


def without(hidden: str, effect_ids: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(effect_id for effect_id in effect_ids if not effect_id.startswith(hidden))


def test_all_effects_are_candidates_of_the_bare_model(sticking) -> None:
    """That of a sensor only where what it measures was measured."""
    _, recording, _ = sticking
    none = np.zeros(len(recording.time))
    cells = ("joint_torque", "motor_torque", "upper_spring_force", "lower_spring_force")
    signals = {**recording.signals, **dict.fromkeys(cells, none)}
    bent = replace(recording, motor_share=1.0, signals=signals)
    model = load_model("biorob_x4_joint_3")
    assert candidates(model, [bent]) == loaded_at_position()
    driven = without("motor_reading", effects.BY_ID.ids())  # it is given
    assert candidates(model.at("torque"), [bent]) == driven
    assert candidates(model, [recording]) == seen_in_positions()


def static_curve(load: np.ndarray, position: np.ndarray) -> Measurement:
    time = 1000.0 * np.arange(len(load))
    signals = {"joint_position": position}
    return Measurement(time, 0.0 * time, signals, load_torque=load, static=True, name="curve")


def test_a_mass_is_sought_only_where_something_moves(sticking) -> None:
    _, recording, _ = sticking
    model = load_model("biorob_x4_joint_3")
    curve = static_curve(np.zeros(10), np.zeros(10))
    moving = candidates(model, [curve, recording])
    assert "spring_mass" in moving
    assert candidates(model, [curve, curve]) == without("spring_mass", moving)


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


@pytest.mark.parametrize("effect_id", [one.id for one in effects.CATALOGUE])
def test_looks_begin_at_shares_of_typical_strengths(effect_id, sticking) -> None:
    """With every shape that is tried; also with little damping where nothing of it is singular."""
    known, recording, _ = sticking
    model, effect, asked = known.model, effects.BY_ID[effect_id], (0.3, 2.0)
    found = list(starts(model, effect, [recording], asked))
    tried = list(shapes(model, effect, [recording]))
    dampings = LITTLE_DAMPING if effect.singular_null else (1.0,)
    expected = [
        {
            one.name: shape[one.name]
            if one.shape
            else one.null
            + share
            * (damped if "damping" in one.name else 1.0)
            * (typical_value(model, one) - one.null)
            for one in effect.parameters
        }
        for shape in tried
        for share in asked
        for damped in dampings
    ]
    assert len(found) == len(tried) * len(asked) * len(dampings)
    assert found == [pytest.approx(values) for values in expected]


def test_little_damping_is_tried_only_where_nothing_is_singular(sticking) -> None:
    known, recording, _ = sticking
    stop = list(starts(known.model, effects.BY_ID["joint_stop"], [recording], (1.0,)))
    assert len({one["damping"] for one in stop}) == 1
    for effect_id, name in (("spring_mass", "damping"), ("lugre_friction", "bristle_damping")):
        found = list(starts(known.model, effects.BY_ID[effect_id], [recording], (1.0,)))
        low, high = sorted({one[name] for one in found})
        assert low == pytest.approx(0.01 * high)
        assert (
            len({one["mass" if name == "damping" else "bristle_stiffness"] for one in found}) == 1
        )


def test_bristles_and_stops_may_be_softer_than_a_mass_may_be_light(sticking) -> None:
    known, recording, _ = sticking
    limits = sensible(known.model, ("lugre_friction", "spring_mass", "joint_stop"), [recording])
    for effect_id, name, share in (
        ("lugre_friction", "bristle_stiffness", 0.002),
        ("lugre_friction", "coulomb_torque", 0.002),
        ("joint_stop", "stiffness", 0.002),
        ("spring_mass", "mass", 0.03),
    ):
        (parameter,) = [p for p in effects.BY_ID[effect_id].parameters if p.name == name]
        least = share * typical_value(known.model, parameter)
        assert limits[f"effects.{effect_id}.{name}"] == (pytest.approx(least), np.inf)


def test_a_machine_keeps_inertia_and_stiffness(sticking) -> None:
    """Ten standard deviations up or down, as a factor: never to nothing."""
    known, recording, _ = sticking
    given = known.model.values()
    limits = sensible(known.model, (), [recording])
    for path, sigma in (("link.inertia", 0.3), ("transmission.upper_spring.stiffness", 0.1)):
        reach = 1.0 + 10.0 * sigma
        assert limits[path] == pytest.approx((given[path] / reach, given[path] * reach))

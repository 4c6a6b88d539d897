"""What a diagnosis works on: clean recordings, short enough; and which effects may be missing."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from effects_at import searched_in_positions
from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.comparison.compare import compare
from elastic_tendon.diagnosis import data
from elastic_tendon.diagnosis.data import (
    EVERYTHING,
    FEWER,
    MOST,
    STRETCHES,
    data_of,
    idle_effects,
)
from elastic_tendon.diagnosis.options import Options
from elastic_tendon.diagnosis.windows import FEWEST
from elastic_tendon.errors import MeasurementError, ModelError
from elastic_tendon.measurement import Measurement

GIVEN = load_model("biorob_x4_joint_3")
NOISE = 2e-4  # rad


def recording(n: int, step: float = 0.002, seed: int = 1, *, name: str = "made") -> Measurement:
    """A joint that rests in the first half and moves in the second."""
    time = step * np.arange(n)
    motion = 0.3 * np.sin(2 * np.pi * 0.7 * np.maximum(time - time[n // 2], 0.0))
    noise = NOISE * np.random.default_rng(seed).standard_normal(n)
    signals = {"joint_position": motion + noise}
    return Measurement(time, motion, signals, load_torque=0.1 * motion, name=name)


def samples(recordings: tuple[Measurement, ...]) -> int:
    return sum(len(part.time) for part in recordings)


# ---- how much of it ------------------------------------------------------------------------------


def test_a_short_recording_is_taken_whole() -> None:
    found = data_of(GIVEN, [recording(3000)], [])
    assert found.fitted == found.whole
    assert samples(found.fitted) == 3000


@pytest.mark.parametrize("lengths", [(50_000,), (40_000, 30_000), (16_000, 1000), (1200,) * 16])
def test_of_long_recordings_the_search_sees_excerpts(lengths: tuple[int, ...]) -> None:
    parts = [recording(n, seed=k, name=f"{k} of {n}") for k, n in enumerate(lengths)]
    found = data_of(GIVEN, parts, [])
    assert samples(found.whole) == sum(lengths)
    assert 0.6 * FEWER < samples(found.fitted) <= FEWER
    assert len(parts) <= len(found.fitted) <= max(STRETCHES, len(parts))


def test_everything_is_all_that_excerpts_leave_out() -> None:
    parts = [recording(MOST, seed=1), recording(1000, seed=2, name="second")]
    everything = data_of(GIVEN, parts, []).everything
    assert everything is not None
    assert everything.fitted == everything.motions == everything.whole
    assert samples(everything.fitted) == MOST + 1000
    assert everything.everything is None
    assert data_of(GIVEN, [recording(EVERYTHING + 1000)], []).everything is None


def test_stretches_where_a_model_errs_most_come_beside_the_liveliest() -> None:
    part = recording(16_000, step=0.1)
    found = data_of(GIVEN, [part], [])
    errors = np.where(np.arange(16_000) < 2000, 0.1, 0.0)  # while the joint rests
    more = found.with_worst([{"joint_position": errors}])
    assert more.motions[: len(found.motions)] == found.motions
    assert more.fitted == more.motions
    assert min(part.time[0] for part in more.fitted[len(found.fitted) :]) == part.time[0]
    lively = np.where(np.arange(16_000) >= 8000, 0.1, 0.0)
    again = found.with_worst([{"joint_position": lively}])
    assert samples(again.fitted) <= samples(more.fitted)
    assert len({part.time[0] for part in again.fitted}) == len(again.fitted)


def test_a_stretch_where_a_model_errs_may_be_the_last() -> None:
    part = recording(16_000, step=0.1)
    errors = np.where(np.arange(16_000) >= 15_700, 0.1, 0.0)
    more = data_of(GIVEN, [part], []).with_worst([{"joint_position": errors}])
    assert max(piece.time[-1] for piece in more.fitted) == part.time[-1]


def test_excerpts_have_the_noise_of_the_whole_recording() -> None:
    whole = recording(50_000, step=0.2)
    sigma = whole.noise["joint_position"].sigma
    for part in data_of(GIVEN, [whole], []).fitted:
        assert part.noise["joint_position"].sigma == pytest.approx(sigma)


def test_excerpts_are_where_the_joint_moves() -> None:
    (whole,) = (recording(50_000),)
    found = data_of(GIVEN, [whole], []).fitted
    moving = whole.time[len(whole.time) // 2]
    assert all(part.time[0] >= moving - 1.0 for part in found)
    starts = [part.time[0] for part in found]
    assert starts == sorted(starts)


def test_a_motion_as_quick_as_its_samples_is_not_averaged() -> None:
    whole = recording(50_000, step=0.2)  # 7 samples in a swing
    for part in data_of(GIVEN, [whole], []).fitted:  # samples are the recording's own
        assert np.isin(part.time, whole.time).all()


def test_a_slow_motion_is_seen_from_end_to_end() -> None:
    whole = recording(9000, step=2.5e-4)
    (found,) = data_of(GIVEN, [whole], []).fitted
    assert len(found.time) <= FEWER
    assert found.time[0] < 0.01
    assert found.time[-1] > whole.time[-1] - 0.01


def test_samples_closer_than_need_be_are_averaged() -> None:
    fast = recording(30_000, step=2.5e-4)
    (found,) = data_of(GIVEN, [fast], []).fitted
    assert len(found.time) <= FEWER
    steps = np.diff(found.time)
    assert np.allclose(steps, steps[0])
    assert fast.time[1] < steps[0]
    count = round(steps[0] / fast.time[1])
    left = found.signals["joint_position"] - np.interp(found.time, fast.time, fast.motor_position)
    # the mean of so many samples has so much less noise
    assert np.std(left) == pytest.approx(NOISE / np.sqrt(count), rel=0.1)
    assert found.load_torque == pytest.approx(0.1 * found.motor_position, abs=1e-3)
    known = replace(fast, given_noise={"joint_position": NOISE})
    (found,) = data_of(GIVEN, [known], []).fitted
    assert found.noise["joint_position"].sigma == pytest.approx(NOISE / np.sqrt(count))


def test_means_of_coloured_noise_have_more_of_it() -> None:
    calm, step = recording(30_000, step=2.5e-4), 2.5e-4
    random = np.random.default_rng(3).standard_normal(len(calm.time))
    coloured = NOISE * np.sqrt(1.0 - 0.8**2) * lfilter([1.0], [1.0, -0.8], random)
    signals = {"joint_position": calm.motor_position + coloured}
    given = {"joint_position": NOISE}
    for part in data_of(GIVEN, [replace(calm, signals=signals, given_noise=given)], []).fitted:
        motion = np.interp(part.time, calm.time, calm.motor_position)
        left = float(np.std(part.signals["joint_position"] - motion))
        assert left > 2.0 * NOISE / np.sqrt(round((part.time[1] - part.time[0]) / step))
        assert part.noise["joint_position"].sigma == pytest.approx(left, rel=0.1)


@pytest.mark.parametrize(("noisy", "size"), [("motor_position", 0.02), ("load_torque", 0.5)])
def test_means_have_all_of_what_the_noise_of_an_input_moves(noisy: str, size: float) -> None:
    """A joint follows it slowly."""
    calm = recording(30_000)
    calm = replace(calm, load_torque=20.0 * calm.motor_position)
    noise = size * np.random.default_rng(4).standard_normal(len(calm.time))
    data = data_of(GIVEN, [replace(calm, **{noisy: getattr(calm, noisy) + noise})], [])
    moved = np.sqrt(data.whole[0].noise["joint_position"].sigma ** 2 - NOISE**2)
    assert moved > NOISE
    for part, quiet in zip(data.fitted, data_of(GIVEN, [calm], []).fitted, strict=True):
        own = quiet.noise["joint_position"].sigma
        assert own < 0.7 * NOISE
        assert part.noise["joint_position"].sigma == pytest.approx(np.hypot(own, moved), rel=0.1)


def test_static_curves_stay_whole() -> None:
    n = MOST + 100
    time = 1000.0 * np.arange(n)
    signals = {"joint_position": np.linspace(0.0, 0.1, n)}
    curve = Measurement(
        time, 0.0 * time, signals, load_torque=0.0 * time, static=True, name="curve"
    )
    (found,) = data_of(GIVEN, [curve], [], Options(horizon=1.0)).fitted
    assert len(found.time) == n


def test_noise_of_a_static_curves_torque_counts() -> None:
    n, random = 200, np.random.default_rng(1)
    time, angle = 1000.0 * np.arange(n), np.linspace(-0.05, 0.05, n)
    load = 40.0 * angle + 0.1 * random.standard_normal(n)
    curve = Measurement(
        time, 0.0 * time, {"joint_position": angle}, load, static=True, name="curve"
    )
    found = data_of(GIVEN, [curve], [])
    assert found.whole == (curve,)
    (part,) = compare(GIVEN, found.fitted).files
    (shown,) = compare(GIVEN, [curve]).files
    known = found.fitted[0].noise["joint_position"].sigma
    assert known == pytest.approx(shown.signals["joint_position"].noise.sigma)
    assert known == part.signals["joint_position"].noise.sigma  # it is not counted twice
    assert known > 10.0 * curve.noise["joint_position"].sigma


def test_held_out_recordings_stay_whole() -> None:
    found = data_of(GIVEN, [recording(3000)], [recording(MOST + 1000, seed=2)])
    assert samples(found.heldout) == MOST + 1000


# ---- a horizon -----------------------------------------------------------------------------------


def test_a_horizon_makes_windows() -> None:
    whole = recording(3000)  # 6 s
    found = data_of(GIVEN, [whole], [], Options(horizon=1.5))
    assert len(found.fitted) == 4
    assert samples(found.fitted) == 3000
    assert found.fitted == found.whole
    assert samples(found.motions) == 3000
    assert len(found.motions) == 1
    for part in found.fitted:
        assert part.time[-1] - part.time[0] <= 1.5
    joined = np.concatenate([part.time for part in found.fitted])
    np.testing.assert_array_equal(joined, whole.time)


def test_a_horizon_of_too_few_samples_is_none() -> None:
    whole = recording(3000)
    assert len(data_of(GIVEN, [whole], [], Options(horizon=0.5 * FEWEST * 0.002)).fitted) == 1
    assert len(data_of(GIVEN, [whole], [], Options(horizon=100.0)).fitted) == 1


# ---- candidates ----------------------------------------------------------------------------------


def test_every_effect_is_a_candidate_of_a_bare_model() -> None:
    """That of a deflection sensor only where a deflection was measured."""
    bent, unbent = replace(recording(500), motor_share=1.0), recording(500)
    added = set(data_of(GIVEN, [bent], []).candidates) - set(
        data_of(GIVEN, [unbent], []).candidates
    )
    assert added == {"deflection_gain"}
    assert data_of(GIVEN, [unbent], []).candidates == searched_in_positions()


def test_some_effects_are_candidates_only_on_request() -> None:
    rare = "directional_damping"
    found = data_of(GIVEN, [recording(500)], [])
    assert rare not in found.candidates
    assert rare in found.rare
    assert rare not in data_of(GIVEN, [recording(500)], [], Options(without=(rare,))).rare
    assert data_of(GIVEN, [recording(500)], [], Options(only=("gravity_load",))).rare == ()
    assert data_of(GIVEN, [recording(500)], [], Options(only=(rare,))).candidates == (rare,)
    at_nulls = GIVEN.with_effect(rare, None)
    assert rare in data_of(at_nulls, [recording(500)], []).candidates


def test_only_and_without() -> None:
    wanted = ("gravity_load", "coulomb_friction")
    found = data_of(GIVEN, [recording(500)], [], Options(only=wanted))
    assert found.candidates == ("coulomb_friction", "gravity_load")
    found = data_of(GIVEN, [recording(500)], [], Options(only=wanted, without=wanted[:1]))
    assert found.candidates == ("coulomb_friction",)
    found = data_of(GIVEN, [recording(500)], [], Options(without=wanted))
    assert set(searched_in_positions()) - set(found.candidates) == set(wanted)


def test_unknown_ids_are_refused_by_name() -> None:
    with pytest.raises(ModelError, match="gravity_lood"):
        Options(only=("gravity_lood",)).check_ids()
    with pytest.raises(ModelError, match="no_such"):
        Options(without=("coulomb_friction", "no_such")).check_ids()
    Options(only=("coulomb_friction",), without=("gravity_load",)).check_ids()


def test_effects_at_values_at_which_they_do_nothing_are_candidates() -> None:
    model = GIVEN.with_effect("coulomb_friction", {"torque": 0.0})
    model = model.with_effect("gravity_load", {"torque": 0.0, "angle": 0.4})
    assert set(idle_effects(model)) == {"coulomb_friction", "gravity_load"}
    found = data_of(model, [recording(500)], [])
    assert found.given.effect_ids == ()
    assert {"coulomb_friction", "gravity_load"} <= set(found.candidates)


def test_effects_that_do_something_stay() -> None:
    model = GIVEN.with_effect("coulomb_friction", {"torque": 0.1})
    assert idle_effects(model) == ()
    found = data_of(model, [recording(500)], [])
    assert found.given == model
    assert "coulomb_friction" not in found.candidates


# ---- what is refused -----------------------------------------------------------------------------


def test_a_held_out_recording_needs_the_fitted_signals() -> None:
    own, other = recording(500), recording(500, seed=2, name="second")
    richer = replace(own, signals={**own.signals, "joint_torque": own.motor_position})
    with pytest.raises(MeasurementError) as refused:
        data_of(GIVEN, [richer], [other])
    text = str(refused.value)
    assert text == (
        "second: it is to validate and lacks joint_torque, which the fitted recordings have; give "
        "a recording with the same signals"
    )


def test_a_held_out_recording_may_have_more() -> None:
    own, other = recording(500), recording(500, seed=2)
    richer = replace(other, signals={**other.signals, "joint_torque": other.motor_position})
    assert len(data_of(GIVEN, [own], [richer]).heldout) == 1


def test_fitted_samples_cannot_judge() -> None:
    own = recording(500)
    with pytest.raises(MeasurementError, match="shares samples"):
        data_of(GIVEN, [own], [replace(own, name="again")])


def test_the_motor_encoders_noise_is_taken_away(monkeypatch) -> None:
    seen = []
    monkeypatch.setattr(data, "smoothed", lambda part: seen.append(part.name) or part)
    data_of(GIVEN, [recording(500)], [recording(500, seed=2, name="second")])
    assert seen == ["made", "second"]


def test_what_no_equilibrium_shows_is_known_beside_static_curves_only() -> None:
    given = GIVEN.model_copy(update={"uncertainty": {"link.inertia": 0.2, "link.damping": 0.5}})
    curve = replace(recording(200), static=True)
    data = data_of(given, [curve], [])
    known = {path for path in data.given.values() if data.given.uncertainty_of(path) == 0.0}
    assert {"link.inertia", "link.damping", "transmission.upper_spring.damping"} <= known
    assert "transmission.upper_spring.stiffness" not in known
    fitted = data.given.model_copy(
        update={"uncertainty": {**data.given.uncertainty, "transmission.pretension_force": 0.01}}
    )
    assert data.unsettled(fitted).uncertainty == {
        **given.uncertainty,
        "transmission.pretension_force": 0.01,
    }
    moving = data_of(given, [recording(200)], [])
    assert moving.given == moving.unsettled(moving.given) == given

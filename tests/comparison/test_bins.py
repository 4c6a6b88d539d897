"""Bins: their arithmetic, and that only real failures stand out of them."""

import numpy as np
import pytest

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.actuator.transmission import slack_boundaries
from elastic_tendon.comparison.averaging import block_means, block_sizes
from elastic_tendon.comparison.bins import Bin, bins_of, noise_density
from elastic_tendon.comparison.partition import (
    FEW,
    blocks_of,
    last_way,
    memory_of,
    partitions,
    range_text,
)
from elastic_tendon.measurement import NoiseFloor
from study_locate import SENSORS, false_alarms, found, motions

MODEL = load_model("biorob_x4_joint_3")
# where numbers were chosen; the study reports seeds from 1000 on
SEED = 500
N = 5000
TIME = 0.002 * np.arange(N)
WHITE = NoiseFloor(1.0, "white")
ALL = {
    *("slack_state", "deflection", "joint_velocity", "velocity_sign", "joint_acceleration"),
    *("joint_position", "motor_position", "load_torque", "time"),
}


def variables() -> dict[str, np.ndarray]:
    deflection = 0.2 * np.sin(7.0 * TIME)
    velocity = 1.4 * np.cos(7.0 * TIME) + 0.5 * np.cos(1.3 * TIME)
    edge = slack_boundaries(MODEL.transmission)[1]
    state = np.where(deflection > edge, 1.0, np.where(deflection < -edge, 2.0, 3.0))
    return {
        "time": TIME,
        "slack_state": state,
        "deflection": deflection,
        "joint_velocity": velocity,
        "joint_acceleration": np.gradient(velocity, TIME),
        "joint_position": deflection + 0.4 * np.sin(1.3 * TIME),
        "motor_position": 0.4 * np.sin(1.3 * TIME),
        "load_torque": np.sin(3.0 * TIME),
    }


def split(residual: np.ndarray, noise: NoiseFloor = WHITE, *, static: bool = False):
    parts = partitions(variables(), MODEL, 0.0, static=static)
    return bins_of(residual, np.zeros(N), TIME, parts, noise, static=static)


def of(bins: tuple[Bin, ...], by: str) -> list[Bin]:
    return [bin_ for bin_ in bins if bin_.by == by]


def white(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal(N)


def test_shares_of_each_variable_add_to_one() -> None:
    bins = split(white(1) + 2.0 * np.sin(40.0 * TIME))
    assert {bin_.by for bin_ in bins} == ALL | {"frequency"}
    for by in ALL | {"frequency"}:
        assert sum(bin_.share for bin_ in of(bins, by)) == pytest.approx(1.0)
    for by in ALL:
        assert sum(bin_.count for bin_ in of(bins, by)) == N


def test_figures_of_a_bin_are_those_of_its_samples() -> None:
    residual = white(2) + 0.3
    bins = of(split(residual), "motor_position")
    position = variables()["motor_position"]
    for bin_ in bins:
        inside = (position >= bin_.lower) & (position < bin_.upper)
        if bin_ is bins[-1]:
            inside |= position == bin_.upper
        assert bin_.count == np.count_nonzero(inside)
        assert bin_.rmse == pytest.approx(np.sqrt(np.mean(residual[inside] ** 2)))
        assert bin_.bias == pytest.approx(np.mean(residual[inside]))


def test_slack_boundaries_are_edges_of_the_deflection() -> None:
    edges = {bin_.lower for bin_ in of(split(white(3)), "deflection")}
    assert set(slack_boundaries(MODEL.transmission)) <= edges


def test_scarce_ends_join_their_neighbours() -> None:
    values = variables() | {"motor_position": np.append(np.linspace(0.0, 0.5, N - 1), 4.0)}
    parts = partitions(values, MODEL, 0.0, static=False)
    part = parts["motor_position"]
    assert np.min(part.counts) >= 0.01 * N
    assert part.edges[-1] == 4.0
    assert np.sum(part.counts) == N


def test_what_does_not_change_is_no_variable() -> None:
    values = variables() | {"load_torque": np.zeros(N), "motor_position": np.full(N, 0.3)}
    parts = partitions(values, MODEL, 0.0, static=False)
    assert set(parts) == ALL - {"load_torque", "motor_position"}


def test_a_static_curve_has_no_speeds_no_time_and_no_frequencies() -> None:
    bins = split(white(4), static=True)
    moving = {"joint_velocity", "joint_acceleration", "joint_position", "time"}
    assert {bin_.by for bin_ in bins} == ALL - moving


def test_a_short_recording_has_no_bins_of_a_few_samples() -> None:
    short = {name: values[:13] for name, values in variables().items()}
    parts = partitions(short, MODEL, 0.0, static=False)
    residual = 5.0 + white(9)[:13]
    bins = bins_of(residual, np.zeros(13), TIME[:13], parts, WHITE, static=False)
    assert all(np.min(part.counts) >= FEW for part in parts.values() if part.edges is not None)
    assert not any(bin_.stands_out for bin_ in bins if bin_.count < FEW and bin_.by != "frequency")


def test_labels_tell_their_ends_apart() -> None:
    assert range_text(2.0, 2.05) == "2 to 2.05"
    assert range_text(2.0, 2.5) == "2 to 2.5"
    assert range_text(1700000000.0, 1700000001.5) == "1700000000 to 1700000001.5"
    assert range_text(-0.12345, 0.2, " and ") == "-0.123 and 0.2"


def test_blocks_of_samples_give_the_figures_of_all_samples() -> None:
    stride = 3  # which does not divide the number of samples
    residual = white(10) * np.where(variables()["joint_velocity"] > 0.0, 3.0, 1.0)
    blocks = {name: block_means(values, stride) for name, values in variables().items()}
    blocks["slack_state"] = np.rint(blocks["slack_state"])
    sizes = block_sizes(N, stride)
    parts = partitions(blocks, MODEL, 0.0, static=False, sizes=sizes)
    bins = bins_of(residual, np.zeros(N), TIME, parts, WHITE, static=False, stride=stride)
    for by in ALL:
        chosen = of(bins, by)
        assert sum(bin_.count for bin_ in chosen) == N
        squares = sum(bin_.count * bin_.rmse**2 for bin_ in chosen)
        assert squares == pytest.approx(np.sum(residual**2))
    alike = of(split(residual), "velocity_sign")
    for bin_, same in zip(of(bins, "velocity_sign"), alike, strict=True):
        if bin_.bin != "at rest":  # a block at its edge is on one side or the other
            assert bin_.rmse == pytest.approx(same.rmse, rel=0.01)


def test_an_error_in_one_direction_stands_out_there_and_only_there() -> None:
    forward = variables()["joint_velocity"] > 0.0
    bins = of(split(white(5) * np.where(forward, 3.0, 1.0)), "velocity_sign")
    told = {bin_.bin: bin_ for bin_ in bins}
    assert told["positive"].stands_out
    assert told["positive"].significance > 10.0
    assert told["positive"].share > 0.8
    assert not told["negative"].stands_out


def test_a_sine_stands_out_in_its_octave() -> None:
    bins = of(split(white(6) + 0.7 * np.sin(2.0 * np.pi * 3.0 * TIME)), "frequency")
    out = [bin_ for bin_ in bins if bin_.stands_out]
    assert len(out) == 1
    assert out[0].lower < 3.0 < out[0].upper


def test_memory_takes_away_significance() -> None:
    """The same squares in lumps are fewer facts than one by one."""
    rng = np.random.default_rng(7)
    lumps = np.repeat(rng.standard_normal(N // 100), 100) * 1.5
    shuffled = rng.permutation(lumps)
    together, apart = (
        [bin_.significance or 0.0 for bin_ in of(split(values), "velocity_sign")]
        for values in (lumps, shuffled)
    )
    assert max(together) < 0.5 * max(apart)


def test_a_bin_without_an_independent_sample_is_not_judged() -> None:
    drift = np.linspace(-1.0, 1.0, N) ** 3
    bins = of(split(drift), "time")
    assert any(bin_.significance is None for bin_ in bins)
    assert not any(bin_.stands_out for bin_ in bins if bin_.significance is None)


def test_coloured_noise_has_the_density_of_its_correlation() -> None:
    angle = np.linspace(0.0, np.pi, 20001)
    density = noise_density(angle, NoiseFloor(1.0, "coloured", correlation=0.9))
    assert np.mean(density) == pytest.approx(1.0, rel=1e-3)
    assert density[0] == pytest.approx(19.0)


def test_blocks_are_as_long_as_the_memory() -> None:
    blocks = blocks_of(5.0, 1000)
    assert blocks[-1] == 99
    assert np.all(np.bincount(blocks) == 10)


def test_memory_of_a_long_series_is_that_of_its_stretches() -> None:
    rng = np.random.default_rng(8)
    values = np.repeat(rng.standard_normal(20_000), 10)
    # a lump of ten equal values: 1 + 2 (9 + 8 + ... + 1) / 10
    assert memory_of(values) == pytest.approx(10.0, rel=0.15)


@pytest.mark.parametrize("kind", SENSORS)
def test_noise_alone_seldom_stands_out(kind: str) -> None:
    """A sample of the study: 24 recordings, of which 5 % and chance allow four."""
    alarms = false_alarms(SENSORS[kind], motions(3.0, SEED), range(SEED, SEED + 6))
    assert len(alarms) == 24
    assert sum(map(bool, alarms)) <= 4


@pytest.mark.parametrize("effect", ["coulomb_friction", "spring_hardening"])
def test_an_effect_as_large_as_the_noise_stands_out(effect: str) -> None:
    assert found(effect, "multisine", SEED)


def test_the_last_way_is_kept_at_rest_and_noise_does_not_turn_it() -> None:
    there, back = np.linspace(0.0, 1.0, 100), np.linspace(1.0, 0.2, 80)
    position = np.concatenate([np.zeros(50), there, np.ones(60), back, np.full(60, 0.2)])
    noisy = position + 1e-3 * np.random.default_rng(8).uniform(-1.0, 1.0, len(position))
    way = last_way(noisy)
    assert np.all(way[55:210] == 1.0)
    assert np.all(way[215:] == -1.0)
    assert not last_way(np.full(20, 0.3)).any()


def test_the_noise_of_the_velocity_counts_as_rest() -> None:
    values = variables() | {"joint_velocity": np.append(np.full(N - 1, 0.02), 1.0)}
    moving, shaking = (partitions(values, MODEL, noise, static=False) for noise in (0.0, 0.01))
    assert moving["velocity_sign"].words == ("positive",)
    assert shaking["velocity_sign"].words == ("at rest", "positive")

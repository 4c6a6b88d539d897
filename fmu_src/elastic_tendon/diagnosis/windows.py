"""Noise of a recording's inputs, and windows in which that does little.

The noise of a measured motor torque, of a load, and of a joint position that is given, is an error
of the model's input. It moves a joint on springs, and what it does there counts as noise of the
signals. A rotor integrates it: the simulated motor drifts ever further, soon beyond any encoder's
noise, and effects are named for it. So recordings of rotors are cut into windows in which it drifts
less, each simulated from an initial state of its own.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.comparison.initial_state import estimate_initial_state, residuals_from_beginning
from elastic_tendon.comparison.residuals import (
    Array,
    residuals_of,
    rms,
    sensitivity,
    simulate_measurement,
    stack,
)
from elastic_tendon.diagnosis.inputs import noise_stands_alone, smoothed
from elastic_tendon.errors import ElasticTendonError
from elastic_tendon.estimation.problem import TOLERANCE
from elastic_tendon.measurement import Measurement
from elastic_tendon.measurement.noise import noise_floors

JOINT, MOTOR, LOAD = "joint_position", "motor_position", "load_torque"
POSITIONS = (JOINT, MOTOR)
# of inputs whose noise moves the machine
UNITS = {"motor_torque": "N·m", LOAD: "N·m", JOINT: "rad", MOTOR: "rad"}
# of the standard deviation of an input: below it is computed and not measured, above, and where it
# is no noise alone, a load is meant to excite all frequencies
EXACT, EXCITES = 1e-5, 0.3
FEWEST = 20  # samples in a window
# s of a window that is chosen, how many of a recording, and the share of the larger noise of both
# encoders from which a drift is seen
SHORTEST, MOST, HARDLY_SEEN = 0.2, 64, 0.5
# windows of a recording that tell how far the motor drifts, and how often each at most
LOOKED_AT, DRAWS = 16, 4
BEGINNING = 20_000  # samples that tell as much of a joint on springs
MATTERS = 0.1  # of an encoder's noise, from which a drift counts


def horizon_for(model: Model, measurements: Sequence[Measurement]) -> float | None:
    """Length of windows (s) in which a rotor drifts by no more than the noise of the encoders, or
    as short as windows may be; None where recordings are so as a whole.

    Parameters
    ----------
    model : Model
    measurements : at its interface
    """
    horizons = [horizon for part in measurements if (horizon := _horizon(model, part)) is not None]
    return min(horizons, default=None)


def windows(measurements: Iterable[Measurement], horizon: float | None) -> tuple[Measurement, ...]:
    """Recordings in windows of so many s, each with its own initial state; None: as they are."""
    return tuple(piece for part in measurements for piece in _pieces(part, horizon))


def drift_of(model: Model, measurement: Measurement, horizon: float | None) -> dict[str, float]:
    """RMS by signal of what the noise of a recording's inputs leaves in windows of so many s, None:
    in the whole, once initial states have followed; nothing where the inputs have none."""
    if not _input_noise(measurement):
        return {}
    return _rms(_left(model, *pair) for pair in _pairs(measurement, horizon))


def with_drift(measurement: Measurement, drift: Mapping[str, float]) -> Measurement:
    """A recording whose noise is that of its signals and a drift, where that matters."""
    return _with_noise(measurement, drift) if _matters(drift, measurement) else measurement


def heldout_with_drift(
    model: Model, measurement: Measurement, horizon: float | None
) -> Measurement | None:
    """A held-out recording that is judged in windows of so many s, where the motor drifts; its
    noise is what a true model errs from an initial state that the first 0.1 s of each show. None
    where it is judged as a whole."""
    drift = drift_of(model, measurement, None)
    if horizon is None or not _matters(drift, measurement):
        return None
    return _with_noise(measurement, _error_from_beginning(model, measurement, horizon))


def input_notes(
    model: Model, measurements: Sequence[Measurement], asked: float | None, horizon: float | None
) -> list[str]:
    """Where the noise of inputs moves the machine by more than the noise of its encoders.

    Parameters
    ----------
    model : Model
    measurements : at its interface
    asked, horizon : s, length of the windows that the user asked for, and of those that are used;
        None: whole recordings
    """
    notes = []
    for part in measurements:
        drift = drift_of(model, part, asked)
        if all(size < part.noise[name].sigma for name, size in drift.items()):
            continue
        rotor = part.kind.has_rotor
        moves = "motor drifts" if rotor else "joint moves"
        text = (
            f"{part.name}: {' and '.join(_told_noises(part))}, by which the simulated {moves} by "
            f"{drift[MOTOR if rotor else JOINT]:.2g} rad, beyond the encoder's noise"
        )
        if not rotor:
            text += "; effects of that size may be named wrongly"
        elif asked is None and horizon is not None:
            text += (
                f"; so it is simulated in windows of {horizon:.2g} s, each from an initial state "
                "of its own (--horizon sets another length)"
            )
        else:
            text += "; effects of that size may be named wrongly. Shorter windows drift less"
        notes.append(text)
    return notes


def _horizon(model: Model, measurement: Measurement) -> float | None:
    """As `horizon_for`, of one recording; springs hold a joint without a rotor where it is."""
    if not measurement.kind.has_rotor:
        return None
    whole = float(measurement.time[-1] - measurement.time[0])
    step = whole / max(len(measurement.time) - 1, 1)
    shortest = max(SHORTEST, FEWEST * step, whole / MOST)
    # an encoder may have far less noise than others
    least = HARDLY_SEEN * max(
        (measurement.noise[name].sigma for name in POSITIONS if name in measurement.noise),
        default=0.0,
    )
    horizon = whole
    while horizon >= 2.0 * shortest and any(
        size > max(measurement.noise[name].sigma, least)
        for name, size in drift_of(model, measurement, horizon).items()
    ):
        horizon /= 2.0
    return horizon if horizon < whole else None


def _pieces(measurement: Measurement, horizon: float | None) -> Iterator[Measurement]:
    """Windows of one recording; static curves stay whole."""
    whole = float(measurement.time[-1] - measurement.time[0])
    count = max(round(whole / (horizon or np.inf)), 1)
    if measurement.static or count == 1 or len(measurement.time) < FEWEST * count:
        yield measurement
        return
    for part in np.array_split(np.arange(len(measurement.time)), count):
        start, end = float(measurement.time[part[0]]), float(measurement.time[part[-1]])
        yield measurement.window(start, end)


def _with_noise(measurement: Measurement, more: Mapping[str, float]) -> Measurement:
    """A recording with noise that comes to that of its signals."""
    noise = {
        name: float(np.hypot(floor.sigma, more.get(name, 0.0)))
        for name, floor in measurement.noise.items()
    }
    return replace(measurement, given_noise=noise)


def _input_noise(measurement: Measurement) -> dict[str, float]:
    """Standard deviation of the noise of inputs that move a rotor, and of the load of a joint on
    springs, by name; a load that itself is noise, as it excites all frequencies, has none."""
    kind = measurement.kind
    if measurement.static or not kind.has_springs:
        return {}
    moving = tuple(UNITS) if kind.has_rotor else (LOAD, MOTOR)
    inputs = {name: values for name, values in measurement.inputs.items() if name in moving}
    floors = noise_floors(measurement.time, {}, inputs)
    return {
        name: floors[name].sigma
        for name, values in inputs.items()
        if floors[name].sigma > EXACT * np.std(values)
        if name not in (LOAD, MOTOR) or _is_noise(values, floors[name].sigma)
    }


def _is_noise(values: Array, sigma: float) -> bool:
    """Whether what an input has at high frequencies is noise, and not what it is meant to do."""
    return sigma < EXCITES * float(np.std(values)) and noise_stands_alone(values)


def _told_noises(measurement: Measurement) -> Iterator[str]:
    for name, sigma in _input_noise(measurement).items():
        yield f"the {name.replace('_', ' ')} has noise of {sigma:.2g} {UNITS[name]}"


def _matters(drift: Mapping[str, float], measurement: Measurement) -> bool:
    """Whether some signal drifts by what counts beside its noise."""
    return any(size >= MATTERS * measurement.noise[name].sigma for name, size in drift.items())


def _error_from_beginning(
    model: Model, measurement: Measurement, horizon: float
) -> dict[str, float]:
    """RMS by signal of what a true model errs beyond an encoder's noise in windows, from an initial
    state that the first 0.1 s of each show."""
    floors, random = measurement.noise, np.random.default_rng(1)
    found = _rms(_from_beginning(model, *pair, random) for pair in _pairs(measurement, horizon))
    return {
        name: float(np.sqrt(max(size**2 - floors[name].sigma ** 2, 0.0)))
        for name, size in found.items()
    }


def _pairs(
    measurement: Measurement, horizon: float | None
) -> list[tuple[Measurement, Measurement]]:
    """Some windows, evenly spread, of what is simulated, and with as much noise of the inputs
    once more, several times where windows are few; the noise is the same each time."""
    if not measurement.kind.has_rotor:  # the noise goes on as it began
        measurement = measurement.samples(slice(BEGINNING))
    known = {name: floor.sigma for name, floor in measurement.noise.items()}
    sigmas = _input_noise(measurement)
    pairs: list[tuple[Measurement, Measurement]] = []
    for seed in range(DRAWS):
        parts = (measurement, _noisier(measurement, sigmas, np.random.default_rng(seed)))
        calm = (replace(smoothed(part), given_noise=known) for part in parts)
        pairs += zip(*(_pieces(part, horizon) for part in calm), strict=True)
        if len(pairs) >= LOOKED_AT:
            break
    return pairs[:: -(-len(pairs) // LOOKED_AT)]


def _noisier(
    measurement: Measurement, sigmas: Mapping[str, float], random: np.random.Generator
) -> Measurement:
    """A recording with so much noise of its inputs once more."""
    inputs = {
        name: measurement.inputs[name] + sigma * random.standard_normal(len(measurement.time))
        for name, sigma in sigmas.items()
    }
    load = inputs.pop(LOAD, measurement.load_torque)
    motor = inputs.pop(MOTOR, measurement.motor_position)
    driving = {**measurement.driving, **inputs}
    return replace(measurement, motor_position=motor, load_torque=load, driving=driving)


def _left(model: Model, window: Measurement, noisy: Measurement) -> dict[str, Array]:
    """By signal, (n,): what noise of the inputs leaves in a window once its initial state has
    followed; nothing where the model cannot follow."""
    with suppress(ElasticTendonError):
        initial = estimate_initial_state(model, window)
        found = sensitivity(model, window, initial, (), TOLERANCE)
        errors = residuals_of(simulate_measurement(model, noisy, initial, TOLERANCE), noisy)
        changes = {name: values - found.residuals[name] for name, values in errors.items()}
        sigmas = window.given_noise
        change, slopes = (stack([part], [sigmas]) for part in (changes, found.derivatives))
        rest = np.split(change - slopes @ np.linalg.lstsq(slopes, change)[0], len(changes))
        return {name: sigmas[name] * part for name, part in zip(changes, rest, strict=True)}
    return {}


def _from_beginning(
    model: Model, window: Measurement, noisy: Measurement, random: np.random.Generator
) -> dict[str, Array]:
    """By signal, (n,): what the model errs on a noisy recording of its own motion; nothing where it
    cannot follow."""
    with suppress(ElasticTendonError):
        initial = estimate_initial_state(model, window)
        own = simulate_measurement(model, window, initial, TOLERANCE)
        signals = {
            name: own[own.measured(name)] + sigma * random.standard_normal(len(window.time))
            for name, sigma in window.given_noise.items()
        }
        return residuals_from_beginning(model, replace(noisy, signals=signals), TOLERANCE)
    return {}


def _rms(errors: Iterable[Mapping[str, Array]]) -> dict[str, float]:
    """RMS by signal of errors in several windows."""
    every = [part for part in errors if part]
    names = dict.fromkeys(name for part in every for name in part)
    return {name: rms(np.concatenate([part[name] for part in every])) for name in names}

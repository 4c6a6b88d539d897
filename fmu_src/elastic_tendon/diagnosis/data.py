"""What a diagnosis works on: recordings without the motor encoder's noise, or excerpts of them.

Most of a search on a long recording is done on means of neighbouring samples, as far as these show
the same motion, or on its liveliest stretches; the answer is confirmed on everything.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from elastic_tendon import effects
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.comparison.compare import compare
from elastic_tendon.comparison.initial_state import residuals_from_beginning
from elastic_tendon.comparison.residuals import Array, rms
from elastic_tendon.diagnosis.candidates import candidates
from elastic_tendon.diagnosis.inputs import smoothed
from elastic_tendon.diagnosis.motion import per_angle
from elastic_tendon.diagnosis.options import Options
from elastic_tendon.diagnosis.windows import (
    FEWEST,
    drift_of,
    heldout_with_drift,
    windows,
    with_drift,
)
from elastic_tendon.errors import MeasurementError, SimulationError
from elastic_tendon.estimation.add import check_apart
from elastic_tendon.estimation.problem import TOLERANCE
from elastic_tendon.measurement import Measurement
from elastic_tendon.measurement.noise import NoiseFloor

# samples of all recordings together up to which a search works on each, and of an excerpt of more
MOST, FEWER = 7_500, 3_000
EVERYTHING = 100_000  # ... up to which all are searched where excerpts show nothing but noise
STRETCHES = 2  # stretches of all recordings together that an excerpt has, at least one of each
# RMS by which straight lines from mean to mean of samples may miss the motion: shares of the noise
# that means have, and of the error of the model as given
OF_NOISE, OF_ERROR = 0.5, 1e-3


@dataclass(frozen=True)
class Data:
    """The model as given, recordings, and which effects are candidates.

    `given` : without effects whose values do nothing, which are candidates like any other; in it
    `known` paths are taken as known, whatever their `uncertainty` as given.
    `fitted` : what the search works on, excerpts where recordings are long, in windows where they
    are asked for; `motions` : the same without windows; `whole` : all of the recordings.
    `heldout` : never fitted. `only`, `without` : ids, see `Options`; `idle` : of effects whose
    values do nothing in the model as given.
    """

    given: Model
    fitted: tuple[Measurement, ...]
    motions: tuple[Measurement, ...]
    heldout: tuple[Measurement, ...]
    whole: tuple[Measurement, ...]
    only: tuple[str, ...] = ()
    without: tuple[str, ...] = ()
    idle: tuple[str, ...] = ()
    known: tuple[str, ...] = ()
    uncertainty: Mapping[str, float] = field(default_factory=dict)

    def unsettled(self, model: Model) -> Model:
        """A model with the uncertainties as given of what was taken as known."""
        kept = {path: sigma for path, sigma in model.uncertainty.items() if path not in self.known}
        again = {path: self.uncertainty[path] for path in self.known if path in self.uncertainty}
        return model.model_copy(update={"uncertainty": kept | again})

    @property
    def excerpts(self) -> bool:
        """Whether the search works on less than everything."""
        return self.fitted is not self.whole

    @property
    def everything(self) -> "Data | None":
        """All samples of the recordings to search in; None where that is done anyway, they are too
        many, or some recording is static."""
        total = sum(len(part.time) for part in self.whole)
        searched = sum(len(part.time) for part in self.motions)
        if not searched < total <= EVERYTHING or any(part.static for part in self.whole):
            return None
        return replace(self, fitted=self.whole, motions=self.whole)

    def with_worst(self, errors: Sequence[Mapping[str, Array]]) -> "Data":
        """Excerpts where a model errs most beside those there are.

        Parameters
        ----------
        errors : of each whole recording, signal -> (n,) in its unit
        """
        total = sum(len(part.time) for part in self.whole)
        count = max(STRETCHES // len(self.whole), 1)
        known = {(part.name, part.time[0]) for part in self.motions}
        worst = tuple(
            piece
            for part, found in zip(self.whole, errors, strict=True)
            for piece in _excerpt(self.given, part, FEWER / total, count, found[part.first_signal])
            if (piece.name, piece.time[0]) not in known
        )
        return replace(self, fitted=(*self.fitted, *worst), motions=(*self.motions, *worst))

    @cached_property
    def candidates(self) -> tuple[str, ...]:
        """Effects that may be missing, in the catalogue's order."""
        return tuple(
            effect_id
            for effect_id in candidates(self.given, self.fitted)
            if effect_id not in self.without and self._asked_for(effect_id)
        )

    @cached_property
    def rare(self) -> tuple[str, ...]:
        """Effects that are tried only where all others leave much, in the catalogue's order."""
        return tuple(
            effect_id
            for effect_id in candidates(self.given, self.fitted)
            if not (self.only or effect_id in (*self.without, *self.candidates))
        )

    def may_add(self, added: Collection[str]) -> bool:
        """Whether all of these effects may be missing."""
        return {*added} <= {*self.candidates, *self.rare}

    def _asked_for(self, effect_id: str) -> bool:
        if self.only:
            return effect_id in self.only
        effect = effects.BY_ID[effect_id]
        pushing = self.given.kind.has_springs and self.given.transmission.slack == 0
        common = not effect.on_request or (effect.common_without_slack and pushing)
        return common or effect_id in self.idle


def data_of(
    model: Model,
    measurements: Sequence[Measurement],
    validation: Sequence[Measurement],
    options: Options | None = None,
) -> Data:
    """What a diagnosis works on.

    Parameters
    ----------
    model : Model as given; its uncertainties are the prior of every step
    measurements : fitted
    validation : never fitted
    options : Options; None: the defaults

    Raises
    ------
    MeasurementError : a recording is both fitted and held out, or a held-out one lacks a signal
    """
    options = options or Options()
    check_apart(measurements, validation)
    _check_signals(measurements, validation)
    bare = tuple(map(_clean, measurements))
    # of means as of samples: what the noise of inputs moves is slow
    drifts = [drift_of(model, part, options.horizon) for part in measurements]
    clean = tuple(map(with_drift, bare, drifts))
    total = sum(len(part.time) for part in clean)
    motions = clean
    if any(part.static for part in clean):
        motions = tuple(_with_torque_noise(model, part) for part in clean)
    if total > MOST:
        count = max(STRETCHES // len(motions), 1)
        motions = tuple(
            with_drift(piece, drift)
            for part, drift in zip(bare, drifts, strict=True)
            for piece in _excerpt(model, _with_torque_noise(model, part), FEWER / total, count)
        )
    whole = windows(clean, options.horizon)
    idle = idle_effects(model)
    given = model.without(idle)
    known = _shown_by_motion(given) if all(part.static for part in measurements) else ()
    return Data(
        given=given.model_copy(
            update={"uncertainty": {**given.uncertainty, **dict.fromkeys(known, 0.0)}}
        ),
        fitted=whole if motions is clean else windows(motions, options.horizon),
        motions=motions,
        heldout=tuple(
            piece for part in validation for piece in _heldout(model, part, options.horizon)
        ),
        whole=whole,
        only=options.only,
        without=options.without,
        idle=idle,
        known=known,
        uncertainty=given.uncertainty,
    )


def _clean(measurement: Measurement) -> Measurement:
    return smoothed(measurement).settled()


def _heldout(
    model: Model, measurement: Measurement, horizon: float | None
) -> tuple[Measurement, ...]:
    """A held-out recording with what the noise of its inputs does, in windows where its motor
    drifts."""
    if not measurement.kind.has_rotor:
        return (with_drift(_clean(measurement), drift_of(model, measurement, None)),)
    drifting = heldout_with_drift(model, measurement, horizon)
    if drifting is None:
        return (_clean(measurement),)
    return windows([_clean(drifting)], horizon)


def _shown_by_motion(model: Model) -> tuple[str, ...]:
    """Paths of what no equilibrium depends on.

    Free, dampings would run to where a motion over the long times of a static curve never ends.
    """
    return tuple(
        path
        for path in model.values()
        if path == "link.inertia" or (path.endswith(".damping") and not path.startswith("effects."))
    )


def idle_effects(model: Model) -> tuple[str, ...]:
    """Effects that a model has at values at which they do nothing."""
    return tuple(
        effect_id
        for effect_id, values in model.effects.items()
        if all(
            values[parameter.name] == parameter.null
            for parameter in effects.BY_ID[effect_id].parameters
            if not parameter.shape
        )
    )


def _check_signals(measurements: Sequence[Measurement], validation: Sequence[Measurement]) -> None:
    wanted = {name for part in measurements for name in part.signals}
    for part in validation:
        if missing := sorted(wanted - set(part.signals)):
            raise MeasurementError(
                f"{part.name}: it is to validate and lacks {', '.join(missing)}, which the fitted "
                "recordings have; give a recording with the same signals"
            )


def _with_torque_noise(model: Model, measurement: Measurement) -> Measurement:
    """A static curve with the noise that its torque has too, as the comparison counts it."""
    if not measurement.static or "joint_position" in measurement.given_noise:
        return measurement
    try:
        (file,) = compare(model, [measurement]).files
    except SimulationError:
        return measurement
    known = {"joint_position": file.signals["joint_position"].noise.sigma}
    return replace(measurement, given_noise={**measurement.given_noise, **known})


def _excerpt(
    model: Model,
    measurement: Measurement,
    share: float,
    stretches: int,
    errors: Array | None = None,
) -> Iterator[Measurement]:
    """Means of samples, or the liveliest stretches of them, about this share of their number; those
    of the largest errors (n,) of the first signal, where these are known."""
    wanted = int(share * len(measurement.time))
    short = measurement if measurement.static else _coarser(model, measurement, wanted)
    n = len(short.time)
    if n <= wanted or short.static:
        yield short
        return
    # of few samples the noise is known badly
    known = {name: noise.sigma for name, noise in short.noise.items()}
    short = replace(short, given_noise=known)
    length = max(wanted // stretches, FEWEST)
    starts = np.unique([*range(0, n - length, length), n - length])  # the end too
    if errors is None:
        telling = np.abs(np.gradient(short.joint_position))
    else:
        telling = np.interp(short.time, measurement.time, errors**2)
    lively = [float(np.mean(telling[start : start + length])) for start in starts]
    taken: list[int] = []
    for start in starts[np.argsort(lively)[::-1]].tolist():
        if len(taken) < stretches and all(abs(start - other) >= length for other in taken):
            taken.append(start)
    for start in sorted(taken):
        yield short.samples(slice(start, start + length))


def _coarser(model: Model, measurement: Measurement, wanted: int) -> Measurement:
    """Means of as many neighbouring samples as show the same motion, no fewer than are wanted."""
    noise = measurement.noise[measurement.first_signal].sigma / per_angle(model, measurement)
    of_error = OF_ERROR * _error_of(model, measurement)
    low, high = 1, -(-len(measurement.time) // wanted)
    while low < high:  # the largest number that shows the same
        count = (low + high + 1) // 2
        allowed = max(OF_NOISE * noise / np.sqrt(count), of_error)
        low, high = (
            (count, high) if _missed(_averaged(measurement, count)) <= allowed else (low, count - 1)
        )
    return _averaged(measurement, low)


def _error_of(model: Model, measurement: Measurement) -> float:
    """RMS error of the joint position, or as large a one, rad; 0 where the model cannot follow."""
    try:
        errors = residuals_from_beginning(model, measurement, TOLERANCE)
    except SimulationError:
        return 0.0
    return rms(errors[measurement.first_signal]) / per_angle(model, measurement)


def _missed(measurement: Measurement) -> float:
    """RMS by which straight lines from sample to sample miss the joint's and the motor's motion."""
    positions = measurement.joint_position, measurement.motor_position
    return max(rms(np.diff(position, 2)) for position in positions) / 8.0


def _averaged(measurement: Measurement, count: int) -> Measurement:
    """Means of so many neighbouring samples."""
    if count < 2:
        return measurement
    n = len(measurement.time) // count * count

    def mean(values: Array) -> Array:
        return np.asarray(values[:n].reshape(-1, count).mean(axis=1))

    load = measurement.load_torque
    return replace(
        measurement,
        time=mean(measurement.time),
        motor_position=mean(measurement.motor_position),
        signals={name: mean(values) for name, values in measurement.signals.items()},
        load_torque=None if load is None else mean(load),
        driving={name: mean(values) for name, values in measurement.driving.items()},
        given_noise={
            name: _of_mean(measurement.noise[name], count) for name in measurement.given_noise
        },
    )


def _of_mean(noise: NoiseFloor, count: int) -> float:
    """Standard deviation of the mean of so many neighbouring samples' noise."""
    apart = np.arange(1, count)
    together = 2.0 * float(np.sum((1.0 - apart / count) * noise.correlation**apart))
    return noise.sigma * float(np.sqrt((1.0 + together) / count))

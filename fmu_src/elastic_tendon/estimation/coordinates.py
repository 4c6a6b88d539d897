"""The variables in which a fit moves, and the prior that holds them.

Every free parameter is measured from its given value in units of its prior's sigma. The Gaussian
prior then is a unit circle, parameters of very different size become alike, and a damping or a
friction torque can reach zero, which a logarithm would forbid.

The pretension is free up to (27), and (27) moves with the stiffnesses. Its variable is therefore
its share of (27), so that every point within the bounds is a model that exists.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import starmap

import numpy as np

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.quantity import Quantity
from elastic_tendon.comparison.residuals import Array
from elastic_tendon.measurement import Measurement

PRETENSION = "transmission.pretension_force"
SPRINGS = ("transmission.upper_spring", "transmission.lower_spring")
UNLIMITED = (-np.inf, np.inf)
Limits = Mapping[str, tuple[float, float]]  # lowest and highest value by dotted path


def own_path(path: str, recording: str) -> str:
    """What stands for a parameter that a recording has of its own."""
    return f"{path}@{recording}"


def owner_of(path: str) -> tuple[str, str]:
    """Dotted path of the parameter for which a path stands, and the recording whose it is; "" where
    it is the model's."""
    parameter, _, recording = path.partition("@")
    return parameter, recording


def parameter_of(path: str) -> str:
    """Dotted path of the parameter for which a path stands."""
    return owner_of(path)[0]


def free_parameters(model: Model) -> tuple[str, ...]:
    """Dotted paths of the parameters that the prior does not call known."""
    return tuple(
        quantity.path
        for quantity in model.quantities()
        if not quantity.integer and model.uncertainty_of(quantity.path) > 0.0
    )


def declared_quantities(model: Model) -> dict[str, Quantity]:
    """What each parameter of a model may be, by dotted path."""
    return {quantity.path: quantity for quantity in model.quantities()}


@dataclass(frozen=True)
class Coordinates:
    """Way between the fit's variables x (m,) and the free parameters of a model.

    `given` is the model that the prior is centred on; `paths` are the m free parameters: those of
    the model, then what further recordings have of their own, each as `own_path` of it and the
    recording. `sigma` (m,) is the prior's one sigma in their units and `centre` (m,) their given
    values. `limits` (m, 2) are bounds beside those of the quantities; `sizes`, see `sizes_in`.
    `recordings` : names; the model has the values of the first.
    """

    given: Model
    paths: tuple[str, ...]
    recordings: tuple[str, ...]
    centre: Array
    sigma: Array
    limits: Array
    sizes: Mapping[str, float]

    @classmethod
    def of(
        cls,
        given: Model,
        paths: Sequence[str],
        limits: Limits | None = None,
        measurements: Sequence[Measurement] = (),
    ) -> "Coordinates":
        """Coordinates for some of a model's parameters; each needs an uncertainty above zero.

        Where the load drives the machine, its springs do not say how large an effect's torque may
        be: that is uncertain by no less than the largest load torque of the measurements, and what
        makes a torque of the velocity by no less than what takes that load at the largest speed.
        Springs that are used in a part of their range may be curved as much there: a cubic
        stiffness is uncertain by no less than what doubles their force where they were.

        Recordings each have their own zeros; pieces of one share them.
        """
        declared = declared_quantities(given)
        recordings = tuple(dict.fromkeys(part.recording for part in measurements))
        own = [path for path in paths if declared[path].of_recording]
        further = [(path, name) for name in recordings[1:] for path in own]
        every = [*paths, *starmap(own_path, further)]
        known = [given.own(name).get(path) for path, name in further]
        given = given.counted_from(recordings, own)
        values, sizes = given.values(), sizes_in(given, measurements)
        centre = [values[path] for path in paths]
        centre += [
            values[path] if value is None else value
            for (path, _), value in zip(further, known, strict=True)
        ]

        def sigma(path: str) -> float:
            own = given.uncertainty_of(path)
            told = path in given.uncertainty or not path.startswith("effects.")
            return own if told else max(own, sizes.get(declared[path].unit, 0.0))

        of_model = [parameter_of(path) for path in every]
        bounds = [(limits or {}).get(path, UNLIMITED) for path in of_model]
        return cls(
            given=given,
            paths=tuple(every),
            recordings=recordings,
            centre=np.array(centre),
            sigma=np.array([sigma(path) for path in of_model]),
            limits=np.array(bounds).reshape(-1, 2),
            sizes=sizes,
        )

    def with_recordings(self, names: Sequence[str]) -> "Coordinates":
        """With what recordings of these names have of their own beside those there are, if these
        have some."""
        new = [name for name in dict.fromkeys(names) if name not in self.recordings]
        if not self.of_recording or not new:
            return self
        more = [(path, name) for name in new for path in self.of_recording]
        like = [self.paths.index(path) for path, _ in more]
        return replace(
            self,
            paths=(*self.paths, *starmap(own_path, more)),
            recordings=(*self.recordings, *new),
            centre=np.concatenate([self.centre, self.centre[like]]),
            sigma=np.concatenate([self.sigma, self.sigma[like]]),
            limits=np.concatenate([self.limits, self.limits[like]]),
        )

    @cached_property
    def of_model(self) -> tuple[str, ...]:
        """Dotted paths of those that are the model's, the first of `paths`."""
        return tuple(path for path in self.paths if parameter_of(path) == path)

    @cached_property
    def of_recording(self) -> tuple[str, ...]:
        """Dotted paths of those that each recording has of its own, where there are several."""
        return tuple(dict.fromkeys(map(parameter_of, self.paths[len(self.of_model) :])))

    def own(self, x: Array, recording: str) -> dict[str, float]:
        """What a recording has of its own at x (m,), by dotted path."""
        values = dict(zip(self.paths, self.values(x).tolist(), strict=True))
        return self.own_among(values, recording)

    def own_among(self, values: Mapping[str, float], recording: str) -> dict[str, float]:
        """What a recording has of its own, known or among these values of `paths`."""
        found = {owner_of(path): value for path, value in values.items()}
        free = {path: value for (path, owner), value in found.items() if owner == recording}
        return {**self.given.own(recording), **free}

    def columns(self, derivatives: Array, recording: str) -> Array:
        """Derivatives by `paths`, (N, m), of what a recording shows; from those by `of_model`."""
        if not self.of_recording:
            return derivatives
        placed = np.zeros((len(derivatives), len(self.paths)))
        for path, column in zip(self.of_model, derivatives.T, strict=True):
            own = own_path(path, recording)
            placed[:, self.paths.index(own if own in self.paths else path)] = column
        return placed

    def values(self, x: Array) -> Array:
        """Free parameters (m,) at x (m,), each in its unit."""
        # rounding must not lead out of the bounds, nor lift the pretension above its limit
        values = np.clip(self.centre + self.sigma * x, *self._range)
        if PRETENSION in self.paths:
            index = self.paths.index(PRETENSION)
            limit = self._pretension_limit(dict(zip(self.paths, values, strict=True)))[0]
            values[index] = min(values[index] * limit / self._given_limit(), limit)
        return values

    def variables(self, values: Array) -> Array:
        """Inverse of `values`."""
        plain = np.array(values, dtype=np.float64)
        if PRETENSION in self.paths:
            index = self.paths.index(PRETENSION)
            limit = self._pretension_limit(dict(zip(self.paths, values, strict=True)))[0]
            plain[index] *= self._given_limit() / limit
        return (plain - self.centre) / self.sigma

    def derivatives(self, x: Array) -> Array:
        """d values / d x, (m, m)."""
        matrix = np.diag(self.sigma)
        if PRETENSION in self.paths:
            index = self.paths.index(PRETENSION)
            values = self.centre + self.sigma * x
            limit, slopes = self._pretension_limit(dict(zip(self.paths, values, strict=True)))
            matrix[index, index] *= limit / self._given_limit()
            for path, slope in slopes.items():
                if path in self.paths:
                    column = self.paths.index(path)
                    matrix[index, column] = (
                        values[index] / self._given_limit() * slope * self.sigma[column]
                    )
        return matrix

    def bounds(self) -> tuple[Array, Array]:
        """Lowest and highest x, two (m,) arrays, from the bounds of the quantities and (27)."""
        lower, upper = (limits.copy() for limits in self._range)
        for index, path in enumerate(self.paths):
            if path == PRETENSION:
                upper[index] = min(upper[index], self._given_limit())
            elif PRETENSION not in self.paths:
                lower[index] = max(lower[index], self._least_for_pretension(path))
        return (lower - self.centre) / self.sigma, (upper - self.centre) / self.sigma

    @cached_property
    def _range(self) -> tuple[Array, Array]:
        """Lowest and highest values (m,), from the bounds of the quantities and the limits."""
        declared = declared_quantities(self.given)
        quantities = [declared[parameter_of(path)] for path in self.paths]
        lower = np.maximum([quantity.lower for quantity in quantities], self.limits[:, 0])
        upper = np.minimum([quantity.upper for quantity in quantities], self.limits[:, 1])
        return lower, upper

    def model(self, x: Array) -> Model:
        """The model at x (m,).

        Raises
        ------
        ModelError : the values together are no model
        """
        values = self.values(x)[: len(self.of_model)].tolist()
        return self.given.with_values(dict(zip(self.of_model, values, strict=True)))

    def _given_limit(self) -> float:
        return self.given.transmission.largest_pretension

    def _pretension_limit(self, free: Mapping[str, float]) -> tuple[float, dict[str, float]]:
        """(27) in N, and its slope to the stiffness and deflection of the spring that sets it."""
        values = self.given.values() | dict(free)
        forces = {spring: _largest_force(values, spring) for spring in SPRINGS}
        weakest = min(forces, key=forces.__getitem__)
        slopes = {
            path: forces[weakest] / values[path]
            for path in (f"{weakest}.stiffness", f"{weakest}.max_deflection")
        }
        return forces[weakest], slopes

    def _least_for_pretension(self, path: str) -> float:
        """Lowest stiffness or deflection at which a known pretension is borne, (27)."""
        spring, _, name = path.rpartition(".")
        if spring not in SPRINGS or name not in ("stiffness", "max_deflection"):
            return -np.inf
        values = self.given.values()
        return values[path] * values[PRETENSION] / _largest_force(values, spring)


def _largest_force(values: Mapping[str, float], spring: str) -> float:
    """Force of a spring at its largest deflection, N."""
    stiffness = values[f"{spring}.stiffness"] * values[f"{spring}.parallel"]
    return stiffness * values[f"{spring}.max_deflection"]


def sizes_in(given: Model, measurements: Sequence[Measurement]) -> dict[str, float]:
    """By unit, how large an effect has to be that matters in some recordings, in that unit."""
    return _load_sizes(measurements) | _spring_sizes(given, measurements)


def _load_sizes(measurements: Sequence[Measurement]) -> dict[str, float]:
    """By unit, what makes a torque as large as the largest load of some recordings."""
    loads = [part.load_torque for part in measurements if part.load_torque is not None]
    load = max((float(np.abs(torque).max()) for torque in loads), default=0.0)
    speed = max(map(_largest_speed, measurements), default=0.0)
    powers = {"N.m": 0, "N.m.s/rad": 1, "N.m.s2/rad2": 2, "N.m.s3/rad3": 3}
    return {unit: load / speed**power for unit, power in powers.items() if speed or not power}


def _spring_sizes(given: Model, measurements: Sequence[Measurement]) -> dict[str, float]:
    """By unit, what doubles the force of the stiffer spring at the largest deflection measured."""
    springs = given.transmission
    share = springs.motor_share
    reached = max(
        (
            float(np.abs(part.signals["joint_position"] - share * part.motor_position).max())
            for part in measurements
            if "joint_position" in part.signals
        ),
        default=0.0,
    )
    stiffness = max(springs.upper_spring.stiffness, springs.lower_spring.stiffness)
    elongation = reached * springs.joint_pulley_radius
    if not elongation:
        return {}
    return {"N/m2": stiffness / elongation, "N/m3": stiffness / elongation**2}


def _largest_speed(measurement: Measurement) -> float:
    """Largest speed of the joint, rad/s; between samples so far apart that noise does not count."""
    if "joint_position" not in measurement.signals:
        return 0.0
    apart = max(len(measurement.time) // 1000, 1)
    passed, moved = (
        values[apart:] - values[:-apart]
        for values in (measurement.time, measurement.signals["joint_position"])
    )
    return float(np.abs(moved / passed).max(initial=0.0))

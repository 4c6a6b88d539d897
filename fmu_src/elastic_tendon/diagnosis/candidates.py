"""Which effects may be missing, and where a search for each begins."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import product

import numpy as np

from elastic_tendon import effects
from elastic_tendon.actuator.effect_numbers import exclusion
from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.actuator.parameters import Model, typical_value
from elastic_tendon.actuator.transmission import prestretched_length
from elastic_tendon.actuator.variables import FORCE_READINGS
from elastic_tendon.effects.base import Effect, Parameter, Slot, Spread
from elastic_tendon.errors import ModelError
from elastic_tendon.estimation.coordinates import SPRINGS
from elastic_tendon.measurement import Measurement

MULTIPLES = (0.1, 0.3, 1.0, 3.0, 10.0)  # of a shape's typical magnitude
STIFFNESSES = tuple(f"{spring}.stiffness" for spring in SPRINGS)
QUADRANTS = (0.0, 0.5 * np.pi, np.pi, -0.5 * np.pi)
REACHES = tuple(0.05 * step for step in range(20))  # of the largest displacement
MARGINS = (0.002, 0.01, 0.05)  # of the range of the joint, from either end
FARTHEST = 0.45  # of that range, from its end to where a stop may be
LITTLE_DAMPING = (1.0, 0.01)  # of the typical one, where an effect oscillates
FAR = 10.0  # standard deviations of the prior by which inertia and stiffness may grow, or shrink
# of an estimate, where its other minima may lie; of what sets a frequency these are close together
FACTORS = tuple(np.geomspace(0.4, 2.5, 31))
CLOSE = tuple(np.linspace(0.96, 1.04, 65))


def candidates(model: Model, measurements: Sequence[Measurement]) -> tuple[str, ...]:
    """Ids of the effects that this model can take and that could show in any of the recordings.

    Parameters
    ----------
    model : Model
    measurements : fitted

    Returns
    -------
    tuple of str, in the catalogue's order
    """
    hidden: set[Slot] = set()
    if all(recording.static for recording in measurements):
        # in equilibrium a spring with a mass is the same, and over the long times of a static
        # curve one that is hardly damped takes millions of steps
        hidden.add(Slot.SPRING_MASS)
    if all(recording.motor_share is None for recording in measurements):
        hidden.add(Slot.DEFLECTION_SIGNAL)
    measured = {name for recording in measurements for name in recording.signals}
    hidden |= {slot for slot, (name, _) in FORCE_READINGS.items() if name not in measured}
    found = filter(None, map(effects.BY_ID.find, effects.BY_ID.ids()))
    return tuple(
        effect.id for effect in found if effect.slot not in hidden and _welcome(model, effect)
    )


def _welcome(model: Model, effect: Effect) -> bool:
    """Whether a model has a place for an effect, and no other law of the same thing."""
    if effect.id in model.effect_ids or not model.kind.has_slot(effect.slot):
        return False
    turns = any(parameter.spread is Spread.TURN for parameter in effect.parameters)
    if turns and model.motion is MotionKind.LINEAR:  # what slides has no whole turn
        return False
    return not exclusion((*map(effects.BY_ID.__getitem__, model.effect_ids), effect))


def shapes(
    model: Model, effect: Effect, measurements: Sequence[Measurement]
) -> Iterator[Mapping[str, float]]:
    """Values of an effect's shape parameters, by name, from which a search begins."""
    names = [parameter.name for parameter in effect.parameters if parameter.shape]
    spreads = [
        _spread(model, parameter, measurements)
        for parameter in effect.parameters
        if parameter.shape
    ]
    for values in product(*spreads):
        yield dict(zip(names, values, strict=True))


def sensible(
    model: Model, effect_ids: Iterable[str], measurements: Sequence[Measurement]
) -> dict[str, tuple[float, float]]:
    """Between which values the machine is still the same, and each effect still what it is.

    A link without inertia or a spring without stiffness is no finding, whatever its prior's tail
    allows. A lighter mass or a softer bristle, of effects that are structurally absent at their
    null, would only be invisible, and slow to simulate. A stop in the middle of the motion is none,
    nor is one that only damps.
    """
    values = model.values()
    limits = {}
    for path in ("link.inertia", "motor.inertia", *STIFFNESSES):
        if path not in values:
            continue
        reach = 1.0 + FAR * model.uncertainty_of(path) / values[path]
        limits[path] = (values[path] / reach, values[path] * reach)
    for effect in map(effects.BY_ID.__getitem__, effect_ids):
        for parameter in effect.parameters:
            path = f"effects.{effect.id}.{parameter.name}"
            held = effect.singular_null or any(
                beside.spread is Spread.JOINT_RANGE for beside in effect.parameters
            )
            if held and not parameter.shape and not is_damping(parameter):
                least = effect.smallest_share * typical_value(model, parameter)
                limits[path] = (parameter.null + least, np.inf)
            elif parameter.spread is Spread.JOINT_RANGE:
                end, inward = _end(parameter, measurements)
                border = end + FARTHEST * inward
                limits[path] = (-np.inf, border) if parameter.null < 0.0 else (border, np.inf)
    return limits


def stops_shown(
    model: Model, fitted: Sequence[Measurement], heldout: Sequence[Measurement]
) -> Iterator[dict[str, float]]:
    """Stops that fitted recordings never reach, where held-out ones go farther and seem to end:
    dotted path -> rad; at several depths, for nobody knows how far these press into them."""
    unreached = []
    for effect_id, values in model.effects.items():
        for parameter in effects.BY_ID[effect_id].parameters:
            if parameter.spread is Spread.JOINT_RANGE:
                (end, inward), (farther, across) = _end(parameter, fitted), _end(parameter, heldout)
                if max((values[parameter.name] - end) * inward, (farther - end) * inward) < 0.0:
                    unreached.append((f"effects.{effect_id}.{parameter.name}", farther, across))
    for margin in MARGINS if unreached else ():
        yield {path: farther + margin * across for path, farther, across in unreached}


def is_damping(parameter: Parameter) -> bool:
    """Whether a parameter damps, so that none of it is nothing singular."""
    return parameter.name.endswith("damping")


def starts(
    model: Model,
    effect: Effect,
    measurements: Sequence[Measurement],
    shares: Sequence[float],
    dampings: Sequence[float] | None = None,
) -> Iterator[dict[str, float]]:
    """Parameters of an effect, by name, from which a look at it may begin.

    Parameters
    ----------
    model : to which it is added
    effect : Effect
    measurements : fitted
    shares : of the typical strength
    dampings : shares of these at which damping begins; None: a singular effect's far lower too
    """
    if dampings is None:
        dampings = LITTLE_DAMPING if effect.singular_null else (1.0,)
    for shape, share, damped in product(shapes(model, effect, measurements), shares, dampings):
        strengths = {
            parameter.name: parameter.null
            + share
            * (damped if is_damping(parameter) else 1.0)
            * (typical_value(model, parameter) - parameter.null)
            for parameter in effect.parameters
            if not parameter.shape
        }
        yield {**strengths, **shape}


def elsewhere(
    model: Model, effect_ids: Iterable[str], measurements: Sequence[Measurement]
) -> Iterator[Model]:
    """The model with other parameters of some effects: each alone and all strengths together,
    times FACTORS or CLOSE, and a like strength of every shape from which a search begins."""
    for effect_id in effect_ids:
        effect, own = effects.BY_ID[effect_id], model.effects[effect_id]
        strengths = [part for part in effect.parameters if not part.shape]
        groups = dict.fromkeys((tuple(strengths), *((part,) for part in effect.parameters)))
        changes = [
            {part.name: part.null + factor * (own[part.name] - part.null) for part in group}
            for group in groups
            for factor in (FACTORS if group[0].at_frequency is None else (*FACTORS, *CLOSE))
        ]
        if len(strengths) < len(effect.parameters):
            sizes = [(part, abs(typical_value(model, part) - part.null)) for part in strengths]
            shares = [abs(own[part.name] - part.null) / size for part, size in sizes if size]
            share = max(shares, default=1.0)
            changes += starts(model, effect, measurements, [share * by for by in FACTORS[::3]])
        for number, change in enumerate(changes):
            if change in changes[:number]:  # of what is nothing every multiple is
                continue
            with suppress(ModelError):
                yield model.with_values(
                    {f"effects.{effect_id}.{name}": value for name, value in change.items()}
                )


def _end(parameter: Parameter, measurements: Sequence[Measurement]) -> tuple[float, float]:
    """The end of the joint's range at which a parameter lies, and the way to the other end."""
    positions = np.concatenate([recording.joint_position for recording in measurements])
    low, high = float(positions.min()), float(positions.max())
    return (low, high - low) if parameter.null < 0.0 else (high, low - high)


def _spread(
    model: Model, parameter: Parameter, measurements: Sequence[Measurement]
) -> tuple[float, ...]:
    if parameter.spread is Spread.NULL:
        return (parameter.null,)
    if parameter.spread is Spread.TURN:
        return QUADRANTS
    if parameter.spread is Spread.ELONGATION:
        return _elongations(model, measurements)
    if parameter.spread is Spread.JOINT_RANGE:
        end, inward = _end(parameter, measurements)
        return (parameter.null, *(end + margin * inward for margin in MARGINS))
    typical = typical_value(model, parameter)
    inside = np.clip(
        [typical * multiple for multiple in MULTIPLES], parameter.lower, parameter.upper
    )
    return tuple(dict.fromkeys(float(value) for value in inside))


def _elongations(model: Model, measurements: Sequence[Measurement]) -> tuple[float, ...]:
    """Elongations of the upper spring, as shares of the largest, that divide what it reaches."""
    transmission = model.transmission
    radius, spring = transmission.joint_pulley_radius, transmission.upper_spring
    deflections = [
        part.joint_position - part.motor_position * transmission.motor_pulley_radius / radius
        for part in measurements
    ]
    reach = radius * max(float(np.max(np.abs(deflection))) for deflection in deflections)
    rest = prestretched_length(transmission.pretension_force, spring.combined_stiffness)
    return tuple((rest + share * reach) / spring.max_deflection for share in REACHES)

"""What varies in a sweep: one parameter of a model, with its values or its distribution."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from elastic_tendon.actuator import problems
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.quantity import Quantity, unit_suffix
from elastic_tendon.errors import SweepError

Array = NDArray[np.float64]

MOST_VALUES = 100_000  # of one factor: all of them are kept
FORMS = (
    "PATH alone for the model's own uncertainty, PATH=5% for a Gaussian of that sigma, "
    "PATH=LOW:HIGH or PATH=-5%:5% for a uniform distribution, with :COUNT behind for even steps, "
    "or PATH=A,B,C for these values"
)


@dataclass(frozen=True)
class Values:
    """Some values, each as likely as the others; the only kind that a grid takes."""

    values: tuple[float, ...]

    def at(self, share: Array) -> Array:
        """Value below which this share (0 to 1, any shape) of all draws lies."""
        index = (share * len(self.values)).astype(np.int64)
        return np.array(self.values)[np.minimum(index, len(self.values) - 1)]


@dataclass(frozen=True)
class Uniform:
    """All values from `low` to `high` alike."""

    low: float
    high: float

    def at(self, share: Array) -> Array:
        """Value below which this share (0 to 1, any shape) of all draws lies."""
        return self.low + share * (self.high - self.low)


@dataclass(frozen=True)
class Normal:
    """A Gaussian of `mean` and one `sigma`, cut off below `low` and above `high`."""

    mean: float
    sigma: float
    low: float
    high: float

    def at(self, share: Array) -> Array:
        """Value below which this share (0 to 1, any shape) of all draws lies."""
        below, above = ndtr((np.array([self.low, self.high]) - self.mean) / self.sigma)
        drawn = self.mean + self.sigma * ndtri(below + share * (above - below))
        return np.asarray(np.clip(drawn, self.low, self.high))  # rounding may go astray by a hair


Distribution = Values | Uniform | Normal


@dataclass(frozen=True)
class Factor:
    """One parameter of a model (its dotted path) and how it varies, in its own unit."""

    path: str
    distribution: Distribution


def parse_factor(model: Model, text: str) -> Factor:
    """Read what a user types: ``link.damping``, or ``link.damping=`` and one of four forms.

    Parameters
    ----------
    model : Model whose number varies
    text : ``PATH``: Gaussian with the uncertainty of the model; ``PATH=5%``: Gaussian, one sigma
        is 5 % of the value; ``PATH=LOW:HIGH``: uniform; ``PATH=LOW:HIGH:COUNT``: values in even
        steps, both ends among them; ``PATH=A,B,C``: these values. Units are those of model.toml;
        ``-5%:5%`` are limits relative to the value

    Returns
    -------
    Factor; all its values are within the bounds of the number

    Raises
    ------
    SweepError
        for an unknown path, a form that is none of these, or a value that is not allowed
    """
    path, equals, form = (part.strip() for part in text.partition("="))
    known = {declared.path: declared for declared in model.quantities()}
    if path not in known:
        raise SweepError(problems.unknown_key(path or repr(text), path, known, model.name))
    quantity = known[path]
    if not equals:
        return Factor(path, _as_stated(model, quantity))
    value = model.values()[path]
    if ":" in form:
        return Factor(path, _between(quantity, value, form.split(":")))
    if form.endswith("%"):
        return Factor(path, _relative(quantity, value, _number(form[:-1], path)))
    return Factor(path, _values(quantity, tuple(_number(item, path) for item in form.split(","))))


def stated_factors(model: Model) -> tuple[Factor, ...]:
    """Gaussians of all parameters to which [uncertainty] of a model.toml gives one.

    Parameters
    ----------
    model : Model

    Returns
    -------
    tuple of Factor, in the order of `quantities`

    Raises
    ------
    SweepError
        where the model states none
    """
    stated = tuple(
        Factor(quantity.path, _as_stated(model, quantity))
        for quantity in model.quantities()
        if model.uncertainty.get(quantity.path, 0.0) > 0.0
    )
    if not stated:
        raise SweepError(
            f"{model.name}: [uncertainty] states nothing that could vary; write lines such as "
            '"link.damping" = 0.2 there (one sigma, relative to the value), or say what varies'
        )
    return stated


# ---- the forms -----------------------------------------------------------------------------


def _as_stated(model: Model, quantity: Quantity) -> Normal:
    path = quantity.path
    sigma = 0.0 if quantity.integer else model.uncertainty_of(path)
    if sigma == 0.0:
        form = "A,B,C" if quantity.integer else "5%"
        aside = "" if quantity.integer else f', or "{path}" = 0.05 in [uncertainty] of the model'
        raise SweepError(f"{path}: nothing says how far it varies; write {path}={form}{aside}")
    return _normal(quantity, model.values()[path], sigma)


def _relative(quantity: Quantity, value: float, percent: float) -> Normal:
    path = quantity.path
    if not percent > 0.0:
        raise SweepError(f"{path}: {percent:g}% is no spread; write a share above 0%")
    if value == 0.0:
        raise SweepError(f"{path}: its value is 0, and so is any share of it; write {path}=0:HIGH")
    return _normal(quantity, value, percent / 100.0 * abs(value))


def _normal(quantity: Quantity, value: float, sigma: float) -> Normal:
    _check_continuous(quantity)
    return Normal(value, sigma, quantity.lower, quantity.upper)


def _between(quantity: Quantity, value: float, parts: list[str]) -> Values | Uniform:
    path = quantity.path
    if len(parts) > 3:
        raise SweepError(f"{path}={':'.join(parts)}: cannot be read; write {FORMS}")
    low, high = (_limit(part, value, path) for part in parts[:2])
    if not low < high:
        raise SweepError(f"{path}: {low:g} is not below {high:g}; write LOW:HIGH")
    _check_bounds(quantity, (low, high))
    if len(parts) == 2:
        _check_continuous(quantity)
        return Uniform(low, high)
    count = _number(parts[2], path)
    if not (count.is_integer() and 2 <= count <= MOST_VALUES):
        raise SweepError(
            f"{path}: a count of {count:g} is none; write a whole number from 2 to {MOST_VALUES}"
        )
    return _values(quantity, tuple(np.linspace(low, high, int(count)).tolist()))


def _limit(text: str, value: float, path: str) -> float:
    """A limit, or one that is so many percent from the value."""
    if not text.endswith("%"):
        return _number(text, path)
    if value == 0.0:
        raise SweepError(f"{path}: its value is 0, and so is any share of it; write {path}=0:HIGH")
    return value + abs(value) * _number(text[:-1], path) / 100.0


def _values(quantity: Quantity, values: tuple[float, ...]) -> Values:
    path = quantity.path
    if len(values) == 1:
        raise SweepError(
            f"{path}={values[0]:g}: one value does not vary; write {path}={values[0]:g}% for a "
            "Gaussian, several values A,B,C, or put this one into the model"
        )
    _check_bounds(quantity, values)
    broken = [value for value in values if quantity.integer and not value.is_integer()]
    if broken:
        raise SweepError(f"{quantity.path}: {broken[0]:g} is not a whole number; write such, A,B,C")
    return Values(values)


# ---- what is refused -----------------------------------------------------------------------


def _number(text: str, path: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise SweepError(f"{path}: {text.strip()!r} is not a number; write {FORMS}")
    return value


def _check_continuous(quantity: Quantity) -> None:
    if quantity.integer:
        raise SweepError(f"{quantity.path}: takes whole numbers; write the values as A,B,C")


def _check_bounds(quantity: Quantity, values: tuple[float, ...]) -> None:
    outside = [value for value in values if not quantity.lower <= value <= quantity.upper]
    if outside:
        unit = unit_suffix(quantity.unit)
        raise SweepError(
            f"{quantity.path}: {outside[0]:g} is outside {quantity.lower:g} to "
            f"{quantity.upper:g}{unit}; write values within"
        )

"""A number of a model, declared once: unit, bounds, meaning, default uncertainty."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, get_args

from pydantic import BaseModel, ConfigDict, Field
from pydantic.fields import FieldInfo

STRICT = ConfigDict(strict=True, frozen=True, extra="forbid", allow_inf_nan=False)


def unit_text(unit: str) -> str:
    """A unit of a model as people write it: ``kg.m2`` is kg·m²."""
    powers = re.sub(r"(?<=[a-z])[23]", lambda digit: "²³"[digit[0] == "3"], unit)
    return powers.replace(".", "·")


def unit_suffix(unit: str) -> str:
    """A unit as it follows a number; nothing for plain numbers."""
    return "" if unit == "1" else f" {unit_text(unit)}"


@dataclass(frozen=True)
class Quantity:
    """A number of a model, as it stands at `path` in model.toml.

    `default` holds where the key is left out (`nominal`, where it must be given).
    `uncertainty` is the default one sigma,
    relative to the value (of an effect: to the typical value); `Model.uncertainty_of`
    says what it comes to. `tunable`: it may change while the machine runs, by load, adjustment,
    temperature or wear, and so while the FMU does; the others are fixed by construction.
    `of_recording`: what a fit to several recordings estimates for each.
    """

    path: str
    unit: str
    meaning: str
    lower: float
    upper: float
    default: float
    nominal: float
    integer: bool
    uncertainty: float
    tunable: bool
    of_recording: bool = False


def declare(
    unit: str,
    meaning: str,
    bounds: tuple[float, float],
    nominal: float,
    *,
    uncertainty: float = 0.0,
    default: float | None = None,
    tunable: bool = False,
    run_time: bool = True,
) -> Any:
    """Declare a field of a section as a quantity.

    Parameters
    ----------
    unit : of the value, its bounds and its nominal
    meaning : one phrase
    bounds : lowest and highest value allowed
    nominal : typical size
    uncertainty : one sigma relative to the value, 0 where the value counts as known
    default : value where the key is left out; None: the key must be given
    tunable : see `Quantity`
    run_time : false for a number that the equations do not use
    """
    return Field(
        ... if default is None else default,
        ge=bounds[0],
        le=bounds[1],
        description=meaning,
        json_schema_extra={
            "unit": unit,
            "lower": bounds[0],
            "upper": bounds[1],
            "nominal": nominal,
            "uncertainty": uncertainty,
            "tunable": tunable,
            "run_time": run_time,
        },
    )


def declared_in(
    section: type[BaseModel], *, run_time_only: bool = False, prefix: str = ""
) -> Iterator[Quantity]:
    """Quantities of a section and of those below it, in the order of their declaration."""
    for name, field in section.model_fields.items():
        below = _section_of(field)
        if below is not None:
            yield from declared_in(below, run_time_only=run_time_only, prefix=f"{prefix}{name}.")
        elif isinstance(field.json_schema_extra, dict):
            extra: dict[str, Any] = dict(field.json_schema_extra)
            if extra.pop("run_time") or not run_time_only:
                yield Quantity(
                    path=prefix + name,
                    meaning=field.description or "",
                    default=extra["nominal"] if field.is_required() else field.default,
                    integer=field.annotation is int,
                    **extra,
                )


def _section_of(field: FieldInfo) -> type[BaseModel] | None:
    for candidate in (field.annotation, *get_args(field.annotation)):
        if isinstance(candidate, type) and issubclass(candidate, BaseModel):
            return candidate
    return None

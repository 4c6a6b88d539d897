"""The numbers of effects in model.toml, derived from the effects' declarations."""

from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import Any

from pydantic import BaseModel, Field, create_model

from elastic_tendon.effects.base import Effect, Parameter, Scale
from elastic_tendon.quantity import STRICT, Quantity

WIDE = 10.0  # default one sigma of an effect's parameter, in typical values


def magnitude(parameter: Parameter, *, torque: float, stiffness: float) -> float:
    """Typical magnitude of a parameter, in its unit.

    Parameters
    ----------
    parameter : as the effect declares it
    torque : maximum joint torque R k l_max of the actuator, N·m
    stiffness : stiffness of one of its softer springs, N/m
    """
    scales = {Scale.ONE: 1.0, Scale.TORQUE: torque, Scale.STIFFNESS: stiffness}
    return parameter.typical * scales[parameter.scale]


def effect_quantities(effect: Effect, *, torque: float, stiffness: float) -> Iterator[Quantity]:
    """Quantities of an effect, nominal for an actuator of this torque and stiffness."""
    for parameter in effect.parameters:
        yield Quantity(
            path=f"effects.{effect.id}.{parameter.name}",
            unit=parameter.unit,
            meaning=parameter.meaning,
            lower=parameter.lower,
            upper=parameter.upper,
            default=parameter.null,
            nominal=magnitude(parameter, torque=torque, stiffness=stiffness),
            integer=False,
            uncertainty=WIDE,
        )


def closed_schema(title: str, fields: Mapping[str, tuple[Any, Any]]) -> type[BaseModel]:
    """Model class with exactly these keys, whatever characters they contain."""
    # aliases, because a key may hold dots or be the name of a method of BaseModel
    definitions: dict[str, Any] = {}
    for index, (key, (annotation, constraints)) in enumerate(fields.items()):
        definitions[f"field_{index}"] = (annotation, Field(alias=key, **constraints))
    return create_model(title, __config__=STRICT, **definitions)


@lru_cache
def effects_schema(present: tuple[Effect, ...]) -> type[BaseModel]:
    """Schema of the table [effects] that names these effects."""
    fields: dict[str, tuple[Any, Any]] = {one.id: (_effect_schema(one), {}) for one in present}
    return closed_schema("effects", fields)


@lru_cache
def _effect_schema(effect: Effect) -> type[BaseModel]:
    fields = {
        one.name: (float, {"default": one.null, "ge": one.lower, "le": one.upper})
        for one in effect.parameters
    }
    return closed_schema(effect.id, fields)

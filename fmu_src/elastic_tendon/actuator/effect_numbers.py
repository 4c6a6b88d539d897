"""The numbers of effects in model.toml, derived from the effects' declarations."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import lru_cache
from typing import Any

from pydantic import BaseModel, Field, create_model, model_validator
from pydantic_core import PydanticCustomError

from elastic_tendon.actuator.problems import REFUSED
from elastic_tendon.actuator.quantity import STRICT, Quantity
from elastic_tendon.effects.base import Check, Effect, Sizes, Slot
from elastic_tendon.effects.source import blame

WIDE = 10.0  # default one sigma of an effect's parameter, in typical values
SPRING_MASS = "the springs' mass"  # of which any effect in that slot is the whole law
Judge = Callable[[Mapping[str, Any]], str]


def effect_quantities(effect: Effect, sizes: Sizes) -> Iterator[Quantity]:
    """Quantities of an effect, nominal for an actuator of these sizes."""
    for parameter in effect.parameters:
        yield Quantity(
            path=f"effects.{effect.id}.{parameter.name}",
            unit=parameter.unit,
            meaning=parameter.meaning,
            lower=parameter.lower,
            upper=parameter.upper,
            default=parameter.null,
            nominal=abs(parameter.typical_for(sizes)),
            integer=False,
            uncertainty=WIDE,
            tunable=not parameter.shape,
            of_recording=parameter.of_recording,
        )


def cautions(numbers: Mapping[str, Mapping[str, float]], present: Iterable[Effect]) -> list[str]:
    """What the effects warn of, one sentence each; `numbers` by id and name."""
    cautions_of = (
        (effect, _sentence_of(effect.cautions, numbers[effect.id])) for effect in present
    )
    return [f"effects.{effect.id}: {sentence}" for effect, sentence in cautions_of if sentence]


def closed_schema(
    title: str, fields: Mapping[str, tuple[Any, Any]], refuses: Judge | None = None
) -> type[BaseModel]:
    """Model class with exactly these keys, whatever characters they contain.

    `refuses` judges the content as a whole, where each key is well: a sentence, or nothing.
    """
    # aliases, because a key may hold dots or be the name of a method of BaseModel
    definitions: dict[str, Any] = {}
    for index, (key, (annotation, constraints)) in enumerate(fields.items()):
        definitions[f"field_{index}"] = (annotation, Field(alias=key, **constraints))
    validators = {} if refuses is None else {"judge": _validator(refuses)}
    return create_model(title, __config__=STRICT, __validators__=validators, **definitions)


def _validator(refuses: Judge) -> Any:
    def judge(content: BaseModel) -> BaseModel:
        if sentence := refuses(content.model_dump(by_alias=True)):
            raise PydanticCustomError(REFUSED, "{sentence}", {"sentence": sentence})
        return content

    return model_validator(mode="after")(judge)


def exclusion(present: Iterable[Effect]) -> str:
    """Sentence for the first law that several of these effects claim to be, or nothing."""
    laws: dict[str, list[str]] = {}
    for effect in present:
        law = SPRING_MASS if effect.slot is Slot.SPRING_MASS else effect.law_of
        laws.setdefault(law, []).append(effect.id)
    for law, ids in laws.items():
        if law and len(ids) > 1:
            named = f"{', '.join(ids[:-1])} and {ids[-1]}"
            both, advice = ("both", "remove one") if len(ids) == 2 else ("all", "keep one")
            return f"{named} are {both} laws of {law}; a model takes one; {advice}"
    return ""


@lru_cache
def effects_schema(catalogue: tuple[Effect, ...]) -> type[BaseModel]:
    """Schema of the table [effects]; None stands for an effect that it does not name."""
    fields: dict[str, tuple[Any, Any]] = {
        effect.id: (_effect_schema(effect), {"default": None}) for effect in catalogue
    }

    def refuses(numbers: Mapping[str, Any]) -> str:
        return exclusion([effect for effect in catalogue if numbers[effect.id] is not None])

    return closed_schema("effects", fields, refuses)


@lru_cache
def _effect_schema(effect: Effect) -> type[BaseModel]:
    fields = {
        number.name: (float, {"default": number.null, "ge": number.lower, "le": number.upper})
        for number in effect.parameters
    }
    return closed_schema(effect.id, fields, lambda numbers: _sentence_of(effect.refuses, numbers))


def _sentence_of(check: Check, numbers: Mapping[str, float]) -> str:
    """What an effect says of its numbers; a fault in a user's own file is reported as such."""
    try:
        return check(numbers)
    except Exception as error:
        raise blame(check, error) from None

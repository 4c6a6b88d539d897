"""The catalogue of physical effects; a new effect is its file and one line here."""

from elastic_tendon.effects import coulomb_friction, overstretch_protection
from elastic_tendon.effects.base import Effect

CATALOGUE: tuple[Effect, ...] = (
    coulomb_friction.EFFECT,
    overstretch_protection.EFFECT,
)
BY_ID: dict[str, Effect] = {effect.id: effect for effect in CATALOGUE}

"""A model as it travels to other processes, with the effects of the user's own."""

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache

from elastic_tendon import effects
from elastic_tendon.actuator.parameters import Model, model_from_toml
from elastic_tendon.errors import ElasticTendonError
from elastic_tendon.sweeps.task import UnfitError


@dataclass(frozen=True)
class ShippedModel:
    """Text of a model.toml, with name and content of the files of effects that it needs, and id
    and SHA-256 of the effects of installed packages."""

    text: str
    own_effects: tuple[tuple[str, bytes], ...]
    installed: tuple[tuple[str, str], ...] = ()

    @property
    def model(self) -> Model:
        """The model, in whatever process this is.

        Raises
        ------
        UnfitError
            where an effect is missing in this process, or is another than the one that was packed
        """
        return _unpacked(self)


def ship(model: Model, effect_ids: Iterable[str] | None = None) -> ShippedModel:
    """Pack a model for other processes; effects of installed packages must be installed there.

    Parameters
    ----------
    model : Model
    effect_ids : of the effects that go along; None: those of the model
    """
    needed = tuple(model.effect_ids if effect_ids is None else effect_ids)
    own = effects.BY_ID.own_files(needed)
    contents = {content for _, content in own}
    catalogue = {effect.id for effect in effects.CATALOGUE}
    installed = tuple(
        (effect_id, _digest(effect_id))
        for effect_id in needed
        if effect_id not in catalogue
        and effects.BY_ID.content(effects.BY_ID[effect_id]) not in contents
    )
    return ShippedModel(model.to_toml(), own, installed)


def _digest(effect_id: str) -> str:
    return hashlib.sha256(effects.BY_ID.content(effects.BY_ID[effect_id])).hexdigest()


@lru_cache(maxsize=4)
def _unpacked(shipped: ShippedModel) -> Model:
    for name, content in shipped.own_effects:
        _load(name, content)
    for effect_id, digest in shipped.installed:
        _compare(effect_id, digest)
    try:
        return model_from_toml(shipped.text, "the model of the sweep")
    except ElasticTendonError as error:  # it was a model where the sweep was begun
        raise UnfitError(str(error)) from None


def _load(name: str, content: bytes) -> None:
    try:
        effects.load_text(content, name)
    except ElasticTendonError as error:
        raise UnfitError(f"{error} (start the workers anew if {name} has changed)") from None


def _compare(effect_id: str, digest: str) -> None:
    try:
        known = effects.BY_ID.find(effect_id) is not None
    except ElasticTendonError as error:
        raise UnfitError(str(error)) from None
    if not known:
        raise UnfitError(f"the package that has the effect {effect_id} is not installed")
    if _digest(effect_id) != digest:
        raise UnfitError(
            f"the effect {effect_id} is another one; install the same package on all computers"
        )

"""A model as it travels to other processes, with the effects of the user's own."""

import tempfile
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from elastic_tendon import effects
from elastic_tendon.actuator.parameters import Model, model_from_toml
from elastic_tendon.errors import EffectError


@dataclass(frozen=True)
class ShippedModel:
    """Text of a model.toml, and name and content of the files of effects that it needs."""

    text: str
    own_effects: tuple[tuple[str, bytes], ...]

    @property
    def model(self) -> Model:
        """The model, in whatever process this is.

        Raises
        ------
        EffectError
            where an effect's file differs from the one that this process has loaded
        """
        return _unpacked(self)


def ship(model: Model) -> ShippedModel:
    """Pack a model for other processes; effects of installed packages must be installed there."""
    return ShippedModel(model.to_toml(), effects.BY_ID.own_files(model.effect_ids))


@lru_cache(maxsize=4)
def _unpacked(shipped: ShippedModel) -> Model:
    for name, content in shipped.own_effects:
        _load(name, content)
    return model_from_toml(shipped.text, "the model of the sweep")


def _load(name: str, content: bytes) -> None:
    if any(content == known for _, known in effects.BY_ID.own_files(effects.BY_ID)):
        return
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        path.write_bytes(content)
        try:
            effects.load(path)
        except EffectError as error:
            raise EffectError(f"{error} (start the workers anew if {name} has changed)") from None

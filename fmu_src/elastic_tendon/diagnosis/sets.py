"""Sets of effects: what they bring, how they differ, and models that have them."""

from collections.abc import Iterable, Iterator, Mapping

from elastic_tendon import effects
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.diagnosis.answer import bounded

Set = tuple[str, ...]  # ids of effects in the catalogue's order


def in_order(effect_ids: Iterable[str]) -> Set:
    """Ids in the catalogue's order, which names a set whatever the order of adding."""
    order = list(effects.BY_ID)
    return tuple(sorted(dict.fromkeys(effect_ids), key=order.index))


def size_of(added: Set) -> int:
    """Number of parameters that effects bring."""
    return sum(len(effects.BY_ID[effect_id].parameters) for effect_id in added)


def simpler(added: Set) -> Iterator[Set]:
    """The set with a simpler law of the same thing in the place of each law, where there is one."""
    return (near for near in _other_laws(added) if size_of(near) < size_of(added))


def richer(added: Set) -> Iterator[Set]:
    """The set with a richer law of the same thing in the place of each law, where there is one."""
    return (near for near in _other_laws(added) if size_of(near) > size_of(added))


def limiting(added: Set) -> Iterator[Set]:
    """The set with what an effect comes to, where data show no more of it, in its place."""
    for effect_id in added:
        limit = effects.BY_ID[effect_id].limit
        if limit and limit not in added:
            yield in_order((*without(added, effect_id), limit))


def _other_laws(added: Set) -> Iterator[Set]:
    for effect_id in added:
        law_of = effects.BY_ID[effect_id].law_of
        for effect in effects.BY_ID.values():
            if law_of and effect.law_of == law_of:
                yield in_order((*without(added, effect_id), effect.id))


def aliases(added: Set) -> Iterator[Set]:
    """The set with an effect that measurements may not tell from it in the place of each."""
    for effect_id in added:
        similar = {
            of_id
            for alias in effects.BY_ID.aliases_of(effects.BY_ID[effect_id])
            for of_id in alias.of
        }
        for similar_id in sorted(similar & set(effects.BY_ID)):
            yield in_order((*without(added, effect_id), similar_id))


def without(added: Set, effect_id: str) -> Set:
    """The set less one effect."""
    return tuple(kept for kept in added if kept != effect_id)


def change_between(before: Set, after: Set) -> str | None:
    """What makes one set of another: "+id", "-id" or "id -> id"; None if more than one change."""
    gone = [effect_id for effect_id in before if effect_id not in after]
    came = [effect_id for effect_id in after if effect_id not in before]
    if len(gone) > 1 or len(came) > 1:
        return None
    if gone and came:
        return f"{gone[0]} -> {came[0]}"
    return f"+{came[0]}" if came else f"-{gone[0]}"


def model_with(given: Model, added: Set, values: Mapping[str, float]) -> Model:
    """The given model with some effects and these values."""
    model = given
    for effect_id in added:
        own = {
            parameter.name: values[f"effects.{effect_id}.{parameter.name}"]
            for parameter in effects.BY_ID[effect_id].parameters
        }
        model = bounded(model, effect_id, own)
    own_paths = [path for path in given.values() if path in values]
    return model.with_values({path: values[path] for path in own_paths})


def told(words: str, added: Set) -> str:
    """Words for what is being done with a set, as "refitting: Gravity load"."""
    titles = ", ".join(effects.BY_ID[effect_id].title for effect_id in added)
    return f"{words}: {titles}" if titles else words

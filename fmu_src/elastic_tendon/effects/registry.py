"""The effects that are known: those of the catalogue, and those that the user named.

An effect of one's own is a Python file that defines ``EFFECT``, given by its path, or an entry
point of the group ``elastic_tendon.effects`` in an installed package. The entry point is named by
the effect's id and refers to the module that defines ``EFFECT`` or to the `Effect` in it. Nothing
is run before a command, a call or a model.toml names it.
"""

from collections.abc import Callable, Iterable
from functools import _lru_cache_wrapper, lru_cache
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from inspect import getfile
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar

from elastic_tendon.effects.base import Alias, Effect
from elastic_tendon.effects.source import Source, read_source, reason
from elastic_tendon.errors import EffectError

T = TypeVar("T")

GROUP = "elastic_tendon.effects"
_KEPT: "list[_lru_cache_wrapper[Any]]" = []


def kept_by_ids(function: Callable[..., T]) -> "_lru_cache_wrapper[T]":
    """`lru_cache` of what follows from ids of effects, of which one may come to mean another."""
    kept = lru_cache(function)
    _KEPT.append(kept)
    return kept


class Registry(dict[str, Effect]):
    """Effects by id: the catalogue in its order, then those that were loaded, by their ids.

    The order does not depend on that of loading, and so neither do the order in which effects
    act, the compiled library and the FMU.
    """

    def __init__(self, catalogue: Iterable[Effect]) -> None:
        super().__init__((effect.id, effect) for effect in catalogue)
        self._catalogue = tuple(self)
        self._sources: dict[str, Source] = {}
        self._own: set[str] = set()  # ids of those that the user's files and texts brought
        self._texts: set[str] = set()  # of those among them that texts brought

    def load(self, path: str | Path) -> Effect:
        """Run a Python file and register the effect that it defines as ``EFFECT``.

        Parameters
        ----------
        path : of the file; a file that is loaded already is not run again

        Returns
        -------
        Effect

        Raises
        ------
        EffectError
            for a file that cannot be used
        """
        source = read_source(Path(path))
        if source.path.suffix != ".py":
            raise source.error("an effect is a Python file, whose name ends in .py")
        for effect_id, loaded in self._sources.items():
            if loaded.file == source.file:
                if loaded.content != source.content:
                    raise source.error("it changed after it was loaded; start Python anew")
                return self[effect_id]
        return self._run(source)

    def load_text(self, content: bytes, name: str) -> Effect:
        """As `load`, of a text that lies in no file.

        Parameters
        ----------
        content : what the file would hold; a text that is loaded already is not run again
        name : what messages call it

        Raises
        ------
        EffectError
            for a text that cannot be used
        """
        if (known := self.loaded_from(content)) is not None:
            return known
        effect = self._run(Source(Path(name), name, content))
        self._texts.add(effect.id)
        return effect

    def forget(self, effect_id: str) -> None:
        """Know an effect no more that a user's file or text brought; its id is free again."""
        self._own.remove(effect_id)
        self._texts.discard(effect_id)
        del self._sources[effect_id], self[effect_id]
        for kept in _KEPT:
            kept.cache_clear()

    def loaded_from(self, content: bytes) -> Effect | None:
        """The effect that a user's file or text of this content brought, None where none did."""
        for effect_id in self._own:
            if self._sources[effect_id].content == content:
                return self[effect_id]
        return None

    @property
    def from_texts(self) -> frozenset[str]:
        """Ids of the effects that came by `load_text`."""
        return frozenset(self._texts)

    def _run(self, source: Source) -> Effect:
        effect = _checked(source.run(), source)
        self._check_free(effect.id, source)
        self._own.add(effect.id)
        return self._add(effect, source)

    def find(self, effect_id: str) -> Effect | None:
        """The effect with this id, imported from an installed package where one has it.

        Raises
        ------
        EffectError
            for an effect of a package that cannot be used
        """
        if effect_id not in self and (entries := self.installed().get(effect_id)):
            self._import(entries)
        return self.get(effect_id)

    def installed(self) -> dict[str, tuple[EntryPoint, ...]]:
        """Entry points of effects that are not loaded, by id; none of them is imported."""
        entries: dict[str, tuple[EntryPoint, ...]] = {}
        for entry in entry_points(group=GROUP):
            if entry.name not in self:
                entries[entry.name] = (*entries.get(entry.name, ()), entry)
        return entries

    def ids(self) -> tuple[str, ...]:
        """What a model can name: the effects that are loaded, then those only installed."""
        return (*self, *sorted(self.installed()))

    def aliases_of(self, effect: Effect) -> tuple[Alias, ...]:
        """What an effect is indistinguishable from: what it says, and what says so of it."""
        told_by = (
            Alias((rival.id,), alias.when)
            for rival in self.values()
            for alias in rival.aliases
            if effect.id in alias.of
        )
        return (*effect.aliases, *told_by)

    def content(self, effect: Effect) -> bytes:
        """The Python file from which an effect was loaded, as it was then."""
        source = self._sources.get(effect.id)
        return source.content if source else Path(getfile(effect.equations)).read_bytes()

    def own_files(self, effect_ids: Iterable[str]) -> tuple[tuple[str, bytes], ...]:
        """Name and content of the user's files from which some of these effects were loaded."""
        own = [self._sources[effect_id] for effect_id in effect_ids if effect_id in self._own]
        return tuple((source.path.name, source.content) for source in own)

    def _import(self, entries: tuple[EntryPoint, ...]) -> None:
        entry = entries[0]
        words = f"the effect {entry.name} of {package(entry)}"
        if len(entries) > 1:
            packages = " and ".join(package(point) for point in entries)
            raise EffectError(f"{packages} both have an effect {entry.name}; uninstall one")
        try:
            spec = find_spec(entry.module)
        except Exception as error:
            raise EffectError(f"{words} cannot be imported: {reason(error)}") from None
        if spec is None or spec.origin is None or not spec.has_location:
            raise EffectError(f"{words} cannot be imported: there is no module {entry.module}")
        source = read_source(Path(spec.origin), spec.origin)
        try:
            loaded = entry.load()
        except (Exception, SystemExit) as error:
            raise source.blamed(error, f"{words} cannot be imported") from None
        effect = _checked(loaded, source)
        if effect.id != entry.name:
            raise source.error(
                f"its id is {effect.id}, but its entry point is called {entry.name}; "
                "give both the same name",
                source.line_of(effect.id),
            )
        self._add(effect, source)

    def _check_free(self, effect_id: str, source: Source) -> None:
        if effect_id in self._sources:
            owner = str(self._sources[effect_id].path)
        elif effect_id in self:
            owner = "the catalogue"
        elif entries := self.installed().get(effect_id):
            owner = package(entries[0])
        else:
            return
        fault = f"{owner} has an effect {effect_id} already; give this one another id"
        raise source.error(fault, source.line_of(effect_id))

    def _add(self, effect: Effect, source: Source) -> Effect:
        self._sources[effect.id] = source
        self[effect.id] = effect
        for effect_id in sorted(self.keys() - set(self._catalogue)):
            self[effect_id] = self.pop(effect_id)
        return effect


def _checked(loaded: object, source: Source) -> Effect:
    """The effect, if it is one that can be used; of a module its ``EFFECT``."""
    from elastic_tendon.effects.checks import check  # needs CasADi

    if not isinstance(loaded, ModuleType):
        return check(loaded, source)
    if not hasattr(loaded, "EFFECT"):
        raise source.error("it defines no EFFECT; end it with EFFECT = Effect(...)")
    return check(loaded.EFFECT, source)


def package(entry: EntryPoint) -> str:
    """Name and version of the installed package that has an entry point."""
    return f"{entry.dist.name} {entry.dist.version}" if entry.dist else "an installed package"

"""What a user has chosen and reached, as one frozen value that the browser's session keeps.

Nothing heavy is in it: recordings are named by keys of files that the server holds, models are
their TOML text. What follows from a document is computed by `results`.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, replace
from hashlib import sha256
from typing import Any, Literal, Self

from pydantic import BaseModel, model_validator

from elastic_tendon.actuator.parameters import Model, model_from_toml
from elastic_tendon.actuator.quantity import STRICT
from elastic_tendon.errors import EffectError
from elastic_tendon.measurement.options import DEFAULT, ReadOptions

GIVEN, EDITED = "as given", "edited by hand"  # titles of models that were made from no other

OPTIONS = tuple(field.name for field in fields(ReadOptions))
Role = Literal["fit", "validate", "split", "off"]


class Source(BaseModel):
    """A file with recordings, and how it is read.

    Parameters
    ----------
    key : of a file in the `Workspace`; never a path
    name : what the user calls it
    role : "fit"; "validate", which is never fitted; "split": fitted before `split` s and never
        after it; "off": left out
    window : s, None where it is open
    options : how it is read else
    left_out : why it cannot be used, in a sentence, "" where it can or nobody tried yet
    """

    model_config = STRICT

    key: str
    name: str
    role: Role = "fit"
    split: float | None = None
    window: tuple[float | None, float | None] = (None, None)
    options: ReadOptions = DEFAULT
    left_out: str = ""

    def changed(self, **changes: Any) -> "Source":
        """The same read otherwise, which nobody tried; an option changes by its own name.

        Raises
        ------
        MeasurementError, pydantic.ValidationError : a change is not allowed
        """
        options = {name: changes.pop(name) for name in OPTIONS if name in changes}
        own = dict(self) | {"left_out": ""} | changes
        own["options"] = replace(self.options, **options)
        return Source.model_validate(own)


class Version(BaseModel):
    """One model on the way; versions form a tree whose roots are models as given.

    Parameters
    ----------
    id : unique within the document
    parent : id of the version it was made from, None for a root
    title : what was done, as "as given", "parameters refitted", "+ Coulomb friction", or a name
        that the user gave it
    change : id of the effect that came in with this step, None where none did
    added : ids of all effects that came in since the root, in this order
    model : text of its model.toml
    given : the same as it was loaded, where parameters were edited by hand since; else ""
    effective : numbers that the data determine, see `estimation.ladder.Step`
    fitted_to : `Document.data_key` of the data that it was fitted to, "" where it was not
    searched : `Document.search_key` with which more was searched from here, else ""
    """

    model_config = STRICT

    id: str
    parent: str | None
    title: str
    change: str | None = None
    added: tuple[str, ...] = ()
    model: str
    given: str = ""
    effective: float = 0.0
    fitted_to: str = ""
    searched: str = ""

    def loaded(self) -> Model:
        """The model itself."""
        return model_from_toml(self.model, self.title)

    def as_loaded(self) -> Model:
        """The model before its parameters were edited by hand."""
        return model_from_toml(self.given or self.model, self.title)

    @property
    def mark(self) -> str:
        """Changes with the model's numbers, and with what they were loaded as."""
        return sha256(f"{self.model}\0{self.given}".encode()).hexdigest()


class OwnEffect(BaseModel):
    """An effect that the user typed on the page: its id, and the text of its Python file.

    It is text like any other here; see `own_effects` for who may have it run.
    """

    model_config = STRICT

    id: str
    text: str

    @property
    def file_name(self) -> str:
        """What its file is called."""
        return f"{self.id}.py"


class Document(BaseModel):
    """All that a user has chosen and reached; changed by making another one."""

    model_config = STRICT

    sources: tuple[Source, ...] = ()
    own_effects: tuple[OwnEffect, ...] = ()
    versions: tuple[Version, ...]
    current: str

    @model_validator(mode="after")
    def _is_whole(self) -> Self:
        known: set[str | None] = {None}
        for version in self.versions:
            if version.parent not in known:
                raise ValueError(f"version {version.id} is older than what it was made from")
            known.add(version.id)
        if self.current not in known:
            raise ValueError(f"there is no version {self.current}")
        return self

    @property
    def version(self) -> Version:
        """The version that is looked at."""
        return self.find(self.current)

    def find(self, version_id: str) -> Version:
        """Version with this id.

        Raises
        ------
        KeyError : there is none
        """
        return {version.id: version for version in self.versions}[version_id]

    def path(self) -> tuple[Version, ...]:
        """Versions from the root to the current one."""
        path = [self.version]
        while path[-1].parent is not None:
            path.append(self.find(path[-1].parent))
        return tuple(reversed(path))

    def children(self, version_id: str) -> tuple[Version, ...]:
        """Versions made from this one, the oldest first."""
        return tuple(version for version in self.versions if version.parent == version_id)

    @property
    def used(self) -> tuple[Source, ...]:
        """Sources that are fitted or held out: those that can be, all where none can."""
        wanted = tuple(source for source in self.sources if source.role != "off")
        return tuple(source for source in wanted if not source.left_out) or wanted

    def data_key(self) -> str:
        """Changes whenever other data are fitted or held out, or the same ones read otherwise."""
        text = "\n".join(source.model_dump_json(exclude={"left_out"}) for source in self.used)
        return sha256(text.encode()).hexdigest()

    def search_key(self) -> str:
        """Changes with `data_key`, and whenever other effects are candidates."""
        if not self.own_effects:
            return self.data_key()
        texts = "\n".join(own.model_dump_json() for own in self.own_effects)
        return sha256(f"{self.data_key()}\n{texts}".encode()).hexdigest()

    # ---- changes ---------------------------------------------------------------------------

    def with_sources(self, sources: Sequence[Source]) -> "Document":
        """The same with other data."""
        return self.model_copy(update={"sources": tuple(sources)})

    def with_source(self, key: str, **changes: object) -> "Document":
        """The same with one source read otherwise.

        Raises
        ------
        MeasurementError, pydantic.ValidationError : a change is not allowed
        """
        return self.with_sources(
            [source.changed(**changes) if source.key == key else source for source in self.sources]
        )

    def with_own_effect(self, own: OwnEffect) -> "Document":
        """The same with an effect of the user's own, once."""
        if own in self.own_effects:
            return self
        return self.model_copy(update={"own_effects": (*self.own_effects, own)})

    def without_own_effect(self, effect_id: str) -> "Document":
        """The same less an effect of the user's own.

        Raises
        ------
        EffectError : a version has it
        """
        having = [
            version.title for version in self.versions if effect_id in version.loaded().effect_ids
        ]
        if having:
            raise EffectError(
                f"{effect_id} is in {', '.join(having)}; delete that in the step Add first"
            )
        left = tuple(own for own in self.own_effects if own.id != effect_id)
        return self.model_copy(update={"own_effects": left})

    def with_model(self, model: Model, title: str = GIVEN) -> "Document":
        """Look at another model as given: in place of one that was left as it was, else beside.

        Parameters
        ----------
        model : Model
        title : of the version
        """
        version = Version(id=self.current, parent=None, title=title, model=model.to_toml())
        return self._replacing(version) if self._bare(self.version) else self.adding(version)

    def edited(self, model: Model) -> "Document":
        """The current version's model with parameters changed by hand, as a model given.

        In place of a root on which nothing was built, else beside; what it was loaded as is kept.
        """
        current = self.version
        loaded, text = current.given or current.model, model.to_toml()
        given = "" if text == loaded else loaded
        if current.parent is None and not self.children(current.id):
            usual = current.title in (GIVEN, EDITED)  # else the user's own
            title = (EDITED if given else GIVEN) if usual else current.title
            update = {"model": text, "given": given, "title": title}
            return self._replacing(current.model_copy(update=update))
        return self.adding(Version(id="", parent=None, title=EDITED, model=text, given=given))

    def adding(self, version: Version) -> "Document":
        """The same with one more version, which gets an id and becomes the current one."""
        taken = max((int(version.id) for version in self.versions), default=0)
        named = version.model_copy(update={"id": str(taken + 1)})
        return self.model_copy(update={"versions": (*self.versions, named), "current": named.id})

    def at(self, version_id: str) -> "Document":
        """Look at another version: undo, redo, or a branch.

        Raises
        ------
        KeyError : there is none
        """
        return self.model_copy(update={"current": self.find(version_id).id})

    def renamed(self, version_id: str, title: str) -> "Document":
        """The same with another title of a version."""
        return self._replacing(self.find(version_id).model_copy(update={"title": title}))

    def with_search(self, version_id: str, search_key: str) -> "Document":
        """The same with a note that more was searched from a version; see `search_key`."""
        update = {"searched": search_key}
        return self._replacing(self.find(version_id).model_copy(update=update))

    def without(self, version_id: str) -> "Document":
        """The same less a version and all that was made from it; one root always stays."""
        gone = {version_id, *(child.id for child in self._below(version_id))}
        parent = self.find(version_id).parent
        left = tuple(version for version in self.versions if version.id not in gone)
        if not left:
            return self
        current = self.current
        if current in gone:
            current = parent or left[-1].id
        return self.model_copy(update={"versions": left, "current": current})

    def _below(self, version_id: str) -> Iterator[Version]:
        for child in self.children(version_id):
            yield child
            yield from self._below(child.id)

    def _bare(self, version: Version) -> bool:
        """Whether nothing of the user's is lost with a version."""
        return version.parent is None and not version.given and not self.children(version.id)

    def _replacing(self, version: Version) -> "Document":
        versions = tuple(
            version if existing.id == version.id else existing for existing in self.versions
        )
        return self.model_copy(update={"versions": versions})


def new_document(model: Model, sources: Sequence[Source] = ()) -> Document:
    """A document that looks at a model as given."""
    root = Version(id="1", parent=None, title=GIVEN, model=model.to_toml())
    return Document(sources=tuple(sources), versions=(root,), current="1")


def from_browser(stored: Mapping[str, object]) -> Document:
    """The document that a browser kept.

    Raises
    ------
    pydantic.ValidationError : it is none
    """
    return Document.model_validate_json(str(stored["document"]))

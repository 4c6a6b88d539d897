"""What a user has chosen and reached, as one frozen value that the browser's session keeps.

Nothing heavy is in it: recordings are named by keys of files that the server holds, models are
their TOML text. What follows from a document is computed by `results`.
"""

from collections.abc import Iterator, Mapping, Sequence
from hashlib import sha256
from typing import Literal

from pydantic import BaseModel, Field

from elastic_tendon.interpolation import Interpolation
from elastic_tendon.parameters import Model, model_from_toml
from elastic_tendon.quantity import STRICT

Role = Literal["fit", "validate", "split", "off"]


class Source(BaseModel):
    """A file with recordings, and how it is read.

    Parameters
    ----------
    key : of a file in the `Workspace`; never a path
    name : what the user calls it
    role : "fit"; "validate", which is never fitted; "split": fitted before `split` s and never
        after it; "off": left out
    mapping, time_shift, resample, remove_offset, interpolation : see `reader.read_prepared`
    window : s, None where it is open
    as_declared : take the data as they are, even if they look read wrongly
    """

    model_config = STRICT

    key: str
    name: str
    role: Role = "fit"
    split: float | None = None
    mapping: tuple[str, ...] = ()
    time_shift: dict[str, float | Literal["auto"]] = Field(default_factory=dict)
    resample: float | None = Field(default=None, gt=0.0)
    remove_offset: tuple[str, ...] = ()
    interpolation: Interpolation = "linear"
    window: tuple[float | None, float | None] = (None, None)
    as_declared: bool = False


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
    effective : numbers that the data determine, see `identify.ladder.Step`
    """

    model_config = STRICT

    id: str
    parent: str | None
    title: str
    change: str | None = None
    added: tuple[str, ...] = ()
    model: str
    effective: float = 0.0

    def loaded(self) -> Model:
        """The model itself."""
        return model_from_toml(self.model, self.title)


class Document(BaseModel):
    """All that a user has chosen and reached; changed by making another one."""

    model_config = STRICT

    sources: tuple[Source, ...] = ()
    versions: tuple[Version, ...]
    current: str

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
        return {one.id: one for one in self.versions}[version_id]

    def path(self) -> tuple[Version, ...]:
        """Versions from the root to the current one."""
        found = [self.version]
        while found[-1].parent is not None:
            found.append(self.find(found[-1].parent))
        return tuple(reversed(found))

    def children(self, version_id: str) -> tuple[Version, ...]:
        """Versions made from this one, the oldest first."""
        return tuple(one for one in self.versions if one.parent == version_id)

    def data_key(self) -> str:
        """Changes whenever other data are fitted or held out, or the same ones read otherwise."""
        text = "\n".join(one.model_dump_json() for one in self.sources if one.role != "off")
        return sha256(text.encode()).hexdigest()

    # ---- changes ---------------------------------------------------------------------------

    def with_sources(self, sources: Sequence[Source]) -> "Document":
        """The same with other data."""
        return self.model_copy(update={"sources": tuple(sources)})

    def with_source(self, key: str, **changes: object) -> "Document":
        """The same with one source read otherwise.

        Raises
        ------
        pydantic.ValidationError : a change is not allowed
        """
        return self.with_sources(
            [
                Source.model_validate(one.model_dump() | changes) if one.key == key else one
                for one in self.sources
            ]
        )

    def with_model(self, model: Model, title: str = "as given") -> "Document":
        """Look at another model as given: in place of one on which nothing was built, else beside.

        Parameters
        ----------
        model : Model
        title : of the version
        """
        current = self.version
        if current.parent is None and not self.children(current.id):
            version = current.model_copy(update={"model": model.to_toml(), "title": title})
            return self._replacing(version)
        return self.adding(Version(id="", parent=None, title=title, model=model.to_toml()))

    def adding(self, version: Version) -> "Document":
        """The same with one more version, which gets an id and becomes the current one."""
        taken = max((int(one.id) for one in self.versions), default=0)
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

    def without(self, version_id: str) -> "Document":
        """The same less a version and all that was made from it; one root always stays."""
        gone = {version_id, *(one.id for one in self._below(version_id))}
        parent = self.find(version_id).parent
        left = tuple(one for one in self.versions if one.id not in gone)
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

    def _replacing(self, version: Version) -> "Document":
        versions = tuple(version if one.id == version.id else one for one in self.versions)
        return self.model_copy(update={"versions": versions})


def new_document(model: Model, sources: Sequence[Source] = ()) -> Document:
    """A document that looks at a model as given."""
    root = Version(id="1", parent=None, title="as given", model=model.to_toml())
    return Document(sources=tuple(sources), versions=(root,), current="1")


def from_browser(stored: Mapping[str, object]) -> Document:
    """The document that a browser kept.

    Raises
    ------
    pydantic.ValidationError : it is none
    """
    return Document.model_validate_json(str(stored["document"]))

"""The parameters of a model: model.toml as frozen, strict data classes.

The tables stand in `sections`, those of the effects in the effects' own files; `quantities`,
the checks and the messages are derived from these declarations.
All numbers are SI. Symbols of the paper: R, r pulley radii; F_p pretension; k_i, d_i,
l_max,i stiffness, damping and largest deflection of the upper (1) and lower (2) spring;
J, b inertia and damping of the link.
"""

import math
import tomllib
import unicodedata
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from functools import cached_property, lru_cache
from itertools import chain
from numbers import Real
from pathlib import Path
from typing import Any

import tomli_w
from pydantic import (
    BaseModel,
    Field,
    SerializerFunctionWrapHandler,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_serializer,
)
from pydantic_core import PydanticCustomError

from elastic_tendon import effects
from elastic_tendon.actuator import problems
from elastic_tendon.actuator.effect_numbers import (
    cautions,
    closed_schema,
    effect_quantities,
    effects_schema,
)
from elastic_tendon.actuator.interfaces import AS_RECORDED, InterfaceKind, kinds_with
from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.actuator.quantity import STRICT, Quantity, declared_in
from elastic_tendon.actuator.sections import (
    NO_LINK,
    NO_SPRINGS,
    InterfaceSection,
    Link,
    Motor,
    Spring,
    Transmission,
)
from elastic_tendon.effects.base import Effect, Parameter, Sizes, Slot
from elastic_tendon.effects.registry import kept_by_ids
from elastic_tendon.errors import ModelError

MODELS_FOLDER = Path(__file__).parents[1] / "models"
SPRING_MASS_SHARE = 0.1  # paper, section II: springs at least a magnitude lighter than the link
WIDE_DAMPING_RATIO = 0.3  # one sigma of a damping given as 0: more than most joints have
# without springs nothing says how large torques are, and without a link how inert one is: typical
# are springs with which the link swings once in a second, that far
FREE_FREQUENCY, FREE_REACH = 2.0 * math.pi, 0.1  # rad/s, rad


class Model(BaseModel):
    """One actuator: the paper's numbers, its effects and what is known of them."""

    model_config = STRICT

    name: str
    motion: MotionKind = Field(MotionKind.ROTARY, strict=False)
    interface: InterfaceSection | None = None
    transmission: Transmission = Field(default=NO_SPRINGS, validate_default=True)
    link: Link = Field(default=NO_LINK, validate_default=True)
    # id -> parameter -> value; complete, in catalogue order
    effects: dict[str, dict[str, float]] = Field(default_factory=dict)
    motor: Motor | None = Field(default=None, validate_default=True)
    # dotted path -> one sigma, relative to the value, absolute where the value is 0
    uncertainty: dict[str, float] = Field(default_factory=dict)
    # name of a recording -> dotted path -> its own zero or load, where that is not the model's
    recordings: dict[str, dict[str, float]] | None = None

    @field_validator("name")
    @classmethod
    def _readable(cls, value: str) -> str:
        if not value.strip() or any(unicodedata.category(letter) == "Cc" for letter in value):
            raise PydanticCustomError("name", "a name is one line of text that can be read")
        return value

    @field_validator("transmission")
    @classmethod
    def _as_the_interface_says(cls, value: Transmission, info: ValidationInfo) -> Transmission:
        section = info.data.get("interface")
        kind = section.kind if section else None
        if value.absent and kind not in (None, InterfaceKind.POSITION, InterfaceKind.LOAD):
            raise _refused(
                f"missing; interface {kind} needs springs between motor and joint: give this "
                "table, or leave [interface] out, where the load alone moves the link (a motor "
                "that is rigidly connected adds n_t^2 times its inertia to that of the link, and "
                "n_t times its torque to the load)"
            )
        if kind is InterfaceKind.LOAD and not value.absent:
            raise _refused(
                "interface load is that of a link without springs; leave this table out, or "
                "choose interface position"
            )
        return value

    @field_validator("link")
    @classmethod
    def _moved_by_the_load(cls, value: Link, info: ValidationInfo) -> Link:
        kind = _kind_of(info.data)
        if value.absent and kind.has_link:
            elsewhere = "; where another simulator has it, take interface joint or torque_joint"
            raise _refused(
                f"missing; a table [link] with inertia, damping is expected, as interface {kind} "
                f"moves the link{elsewhere if kind.has_springs else ''}"
            )
        return value

    @field_validator("effects", mode="before")
    @classmethod
    def _declared_effects(cls, value: object) -> dict[str, Any]:
        listed = value if isinstance(value, Mapping) else ()
        for effect_id in listed:
            effects.BY_ID.find(effect_id)  # imports that of an installed package
        schema = effects_schema(tuple(effects.BY_ID.values()))
        return schema.model_validate(value).model_dump(by_alias=True, exclude_none=True)

    @field_validator("effects")
    @classmethod
    def _with_a_place(
        cls, value: dict[str, dict[str, float]], info: ValidationInfo
    ) -> dict[str, dict[str, float]]:
        kind = _kind_of(info.data)
        for effect_id in value:
            slot = effects.BY_ID[effect_id].slot
            if not kind.has_slot(slot):
                raise _refused(_no_place(effect_id, slot, kind))
        return value

    @field_validator("motor")
    @classmethod
    def _moved_by_torque(cls, value: Motor | None, info: ValidationInfo) -> Motor | None:
        kind = _kind_of(info.data)
        if not kind.has_rotor:
            return value
        if value is None:
            raise _refused(
                f"missing; interface {kind} moves the rotor: give a table [motor] with its inertia"
            )
        if value.friction_torque > 0.0:
            raise _refused(
                f"friction_torque = {value.friction_torque:g} N.m is for designs only; at "
                f"interface {kind} give it as torque of [effects.motor_friction]"
            )
        return value

    @field_validator("uncertainty", mode="before")
    @classmethod
    def _known_paths(cls, value: object, info: ValidationInfo) -> dict[str, Any]:
        # with broken effects every declared path is let pass: their own problem is reported
        effect_ids = info.data.get("effects", effects.BY_ID)
        kind = _kind_of(info.data)
        given = value if isinstance(value, Mapping) else ()
        declared = (quantity.path for quantity in quantities(effect_ids, kind))
        listed = _uncertainty_schema(tuple(path for path in declared if path in given))
        return listed.model_validate(value).model_dump(by_alias=True)

    @field_validator("recordings")
    @classmethod
    def _own_values(
        cls, value: dict[str, dict[str, float]] | None, info: ValidationInfo
    ) -> dict[str, dict[str, float]] | None:
        declared = quantities(info.data.get("effects", ()), _kind_of(info.data))
        possible = {quantity.path: quantity for quantity in declared if quantity.of_recording}
        for name, own in (value or {}).items():
            for path, number in own.items():
                if path not in possible:
                    listed = ", ".join(possible) or "none, as no such effect is in it"
                    raise _refused(
                        f"{name}: {path} is not what a recording has of its own; of this model "
                        f"that may be: {listed}"
                    )
                low, high = possible[path].lower, possible[path].upper
                if not low <= number <= high:
                    raise _refused(
                        f"{name}: {path} = {number:g} is not from {low:g} to {high:g} "
                        f"{possible[path].unit}"
                    )
        return {name: own for name, own in (value or {}).items() if own} or None

    @property
    def effect_ids(self) -> tuple[str, ...]:
        """Ids of the effects present, in the catalogue's order."""
        return tuple(self.effects)

    @property
    def kind(self) -> InterfaceKind:
        """What is given and what is computed; load where there is no [transmission]."""
        return _kind_of({"interface": self.interface, "transmission": self.transmission})

    @property
    def structure(self) -> tuple[tuple[str, ...], InterfaceKind]:
        """What decides the equations, but no number: effects and interface."""
        return self.effect_ids, self.kind

    def at(self, kind: InterfaceKind | str) -> "Model":
        """The same actuator at another interface, without uncertainties of what it does not use.

        Raises
        ------
        ModelError
            for an interface that there is not, or one without [motor] or a place for an effect
        """
        tree = self.model_dump() | {"interface": {"kind": str(kind)}}
        if kind in tuple(InterfaceKind):
            used = InterfaceKind(kind).has_quantity
            tree["uncertainty"] = {
                path: sigma for path, sigma in self.uncertainty.items() if used(path)
            }
        return parse_model(tree, self.name)

    def at_position(self) -> "Model":
        """The same actuator at interface position, without effects that act on the rotor; one
        without springs as it is."""
        if not self.kind.has_springs:
            return self
        position = InterfaceKind.POSITION
        without_place = [
            effect_id
            for effect_id in self.effects
            if not position.has_slot(effects.BY_ID[effect_id].slot)
        ]
        return self.without(without_place).at(position)

    def check_interface(self, what: str, allowed: Sequence[InterfaceKind] = AS_RECORDED) -> None:
        """Refuse what does not work at this model's interface; `what` begins the sentence.

        Raises
        ------
        ModelError
            at an interface that is not allowed
        """
        if self.kind in allowed:
            return
        if not self.kind.has_springs:
            advice = "needs springs; give the model a table [transmission]"
            raise ModelError(self.name, [f"{what} {advice}"])
        places = " or ".join(kind for kind in allowed if kind.has_springs)
        raise ModelError(
            self.name,
            [
                f"interface: {what} works at interface {places}, not at {self.kind}; write "
                f'kind = "{allowed[0]}" in its file, or take it with --interface {allowed[0]}, '
                f'model.at("{allowed[0]}") in Python'
            ],
        )

    def quantities(self) -> tuple[Quantity, ...]:
        """Run-time parameters of this model, in the order of their declaration."""
        return self.motion.quantities(quantities(*self.structure))

    def values(self) -> dict[str, float]:
        """Run-time numbers by dotted path (SI), in the order of `quantities`."""
        return dict(self._values)

    @cached_property
    def _values(self) -> Mapping[str, float]:
        tree = self.model_dump()
        return {
            quantity.path: float(_descend(tree, quantity.path)) for quantity in self.quantities()
        }

    def with_values(self, values: Mapping[str, float]) -> "Model":
        """Model with other run-time numbers (SI), checked as a whole.

        Raises
        ------
        ModelError
            for a path that is no run-time number of this model, or a value not allowed
        """
        known = {quantity.path: quantity for quantity in self.quantities()}
        unknown = [
            problems.unknown_key(path, path, known, "this model")
            for path in values
            if path not in known
        ]
        if unknown:
            raise ModelError(self.name, unknown)
        tree = self.model_dump()
        for path, value in values.items():
            parent, _, key = path.rpartition(".")
            _descend(tree, parent)[key] = _plain(value, known[path].integer)
        return parse_model(tree, self.name)

    def own(self, recording: str) -> Mapping[str, float]:
        """By dotted path, what a recording of this name has of its own in place of the model's."""
        return (self.recordings or {}).get(recording, {})

    def with_recordings(self, own: Mapping[str, Mapping[str, float]]) -> "Model":
        """Model with what recordings have of their own, by name and dotted path, beside those that
        it knows.

        Raises
        ------
        ModelError
            for what is not a recording's own
        """
        known = self.recordings or {}
        added = {name: {**known.get(name, {}), **values} for name, values in own.items()}
        tree = self.model_dump() | {"recordings": {**known, **added}}
        return parse_model(tree, self.name)

    def counted_from(self, recordings: Sequence[str], paths: Container[str]) -> "Model":
        """Model that has of some parameters what the first of some recordings has of its own, and
        forgets what all of these have."""
        if not any(map(self.own, recordings)):
            return self
        first = self.own(recordings[0])
        tree = self.with_values({path: first[path] for path in first if path in paths}).model_dump()
        for name in recordings:
            kept = {path: value for path, value in self.own(name).items() if path not in paths}
            tree["recordings"][name] = kept
        return parse_model(tree, self.name)

    def with_effect(self, effect_id: str, values: Mapping[str, float] | None) -> "Model":
        """Model with one more effect, or other numbers for it; None for its null values.

        Raises
        ------
        ModelError
            for an unknown effect or parameter, or a value not allowed
        """
        tree = self.model_dump()
        tree["effects"][effect_id] = {
            name: _plain(value, False) for name, value in (values or {}).items()
        }
        return parse_model(tree, self.name)

    def without(self, effect_ids: Iterable[str]) -> "Model":
        """Model without some of its effects, all other numbers the same."""
        gone = tuple(f"effects.{effect_id}." for effect_id in effect_ids)
        tree = self.model_dump()
        tree["effects"] = {
            name: numbers
            for name, numbers in tree["effects"].items()
            if f"effects.{name}." not in gone
        }
        tree["uncertainty"] = {
            path: sigma for path, sigma in self.uncertainty.items() if not path.startswith(gone)
        }
        tree["recordings"] = {
            name: {path: value for path, value in own.items() if not path.startswith(gone)}
            for name, own in (self.recordings or {}).items()
        }
        return parse_model(tree, self.name)

    def uncertainty_of(self, path: str) -> float:
        """One sigma of the Gaussian prior of a run-time number, in its own unit; 0: known.

        From [uncertainty], else the field's default: an effect's parameter is uncertain by
        ten typical values, whatever its value; a damping of 0 by what gives the joint a
        damping ratio of 0.3 in state III.
        """
        quantity = {known.path: known for known in self.quantities()}[path]
        value = self._values[path]
        if path in self.uncertainty:
            return self.uncertainty[path] * (abs(value) if value else 1.0)
        if path.startswith("effects."):
            _, effect_id, name = path.split(".")
            declared = {
                parameter.name: parameter for parameter in effects.BY_ID[effect_id].parameters
            }
            return quantity.uncertainty * abs(typical_value(self, declared[name]))
        if value == 0.0 and path.endswith(".damping"):
            return self._wide_damping(path)
        return quantity.uncertainty * (abs(value) if value else 1.0)

    def _wide_damping(self, path: str) -> float:
        """What this damping must be to give the joint WIDE_DAMPING_RATIO in state III."""
        transmission = self.transmission
        stiffness = sizes_of(transmission, self.link).joint_stiffness  # (25)
        damping = 2.0 * WIDE_DAMPING_RATIO * math.sqrt(stiffness * self.link.inertia)
        if path == "link.damping":
            return damping
        springs = (transmission.upper_spring, transmission.lower_spring)
        parallel = sum(spring.parallel for spring in springs)
        return damping / (transmission.joint_pulley_radius**2 * parallel)

    def warnings(self) -> list[str]:
        """What is allowed but unwise, one sentence each."""
        present = tuple(effects.BY_ID[effect_id] for effect_id in self.effects)
        of_springs = self._spring_warnings(present) if self.kind.has_springs else []
        return [*map(self.motion.words, of_springs + cautions(self.effects, present))]

    def _spring_warnings(self, present: Sequence[Effect]) -> list[str]:
        warnings = []
        transmission = self.transmission
        if transmission.pretension_force > transmission.recommended_pretension:
            warnings.append(
                f"transmission.pretension_force: {transmission.pretension_force:g} N is above the "
                f"recommended {transmission.recommended_pretension:g} N, paper (30); more "
                "pretension narrows the range of high stiffness and lowers the largest torque"
            )
        if not any(effect.slot is Slot.SPRING_MASS for effect in present):
            warnings += self._heavy_springs()
        return warnings

    def _heavy_springs(self) -> Iterator[str]:
        link_mass = self.link.inertia / self.transmission.joint_pulley_radius**2
        for side in ("upper_spring", "lower_spring"):
            spring: Spring = getattr(self.transmission, side)
            mass = spring.parallel * spring.mass
            if mass > SPRING_MASS_SHARE * link_mass:
                yield (
                    f"transmission.{side}.mass: {mass:g} kg is more than a tenth of the effective "
                    f"link mass J/R^2 = {link_mass:g} kg, paper section II; spring and link "
                    "may oscillate as two masses, which this model leaves out"
                )

    @model_serializer(mode="wrap")
    def _as_tables(self, tables_of: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """As in a model.toml, without tables that it does not have; most are rotary."""
        tree: dict[str, Any] = tables_of(self)
        if self.motion is MotionKind.ROTARY:
            tree.pop("motion", None)
        if self.link.absent:
            tree.pop("link", None)
        if self.transmission.absent:
            tree.pop("transmission", None)
        return tree

    def to_toml(self) -> str:
        """Text of a model.toml that loads as this model (comments are not kept)."""
        tree = self.model_dump(exclude_none=True)
        return tomli_w.dumps({key: value for key, value in tree.items() if value != {}})


def _kind_of(tables: Mapping[str, Any]) -> InterfaceKind:
    """Interface of a model with these tables, as far as they are well."""
    transmission: Transmission | None = tables.get("transmission")
    if transmission is not None and transmission.absent:
        return InterfaceKind.LOAD
    section: InterfaceSection | None = tables.get("interface")
    return section.kind if section else InterfaceKind.POSITION


def _refused(sentence: str) -> PydanticCustomError:
    return PydanticCustomError(problems.REFUSED, "{sentence}", {"sentence": sentence})


def _no_place(effect_id: str, slot: Slot, kind: InterfaceKind) -> str:
    if not kind.has_springs:
        return (
            f"{effect_id} acts on motor or springs, which a model without [transmission] does not "
            "have; leave it out, or give that table"
        )
    moved = "link" if not kind.has_link and InterfaceKind.POSITION.has_slot(slot) else "rotor"
    there = " or ".join(kinds_with(slot))
    return (
        f"{effect_id} acts on the motion of the {moved}, which interface {kind} does not compute; "
        f"leave it out, or choose interface {there}"
    )


def quantities(
    effect_ids: Iterable[str], kind: InterfaceKind = InterfaceKind.POSITION
) -> tuple[Quantity, ...]:
    """Run-time parameters of a model with these effects: transmission, link, motor, effects.

    The order is that of the declarations and of the catalogue, not of `effect_ids`. Link and motor
    have some where they are moved.
    """
    return _quantities(frozenset(effect_ids), kind)


@kept_by_ids
def _quantities(wanted: frozenset[str], kind: InterfaceKind) -> tuple[Quantity, ...]:
    if unknown := sorted(wanted - effects.BY_ID.keys()):
        raise KeyError(f"no effect named {', '.join(unknown)}")
    base = (
        quantity
        for quantity in declared_in(Model, run_time_only=True)
        if kind.has_quantity(quantity.path)
    )
    added = (
        quantity
        for effect in effects.BY_ID.values()
        if effect.id in wanted
        for quantity in _effect_quantities(effect)
    )
    return (*base, *added)


def sizes_of(transmission: Transmission, link: Link) -> Sizes:
    """Characteristic sizes of an actuator, by which typical magnitudes are measured."""
    if transmission.absent:
        stiffness = link.inertia * FREE_FREQUENCY**2
        return Sizes(
            torque=stiffness * FREE_REACH,
            stiffness=stiffness,
            max_deflection=FREE_REACH,
            joint_stiffness=stiffness,
            inertia=link.inertia,
            radius=1.0,
            parallel=1,
        )
    springs = (transmission.upper_spring, transmission.lower_spring)
    radius = transmission.joint_pulley_radius
    stiffness = radius**2 * sum(spring.combined_stiffness for spring in springs)
    return Sizes(
        torque=radius * min(spring.largest_force for spring in springs),
        stiffness=min(spring.stiffness for spring in springs),
        max_deflection=min(spring.max_deflection for spring in springs),
        joint_stiffness=stiffness,
        inertia=stiffness / FREE_FREQUENCY**2 if link.absent else link.inertia,
        radius=radius,
        parallel=min(spring.parallel for spring in springs),
    )


def typical_value(model: Model, parameter: Parameter) -> float:
    """Typical magnitude of an effect's parameter on this actuator, in the parameter's unit."""
    return parameter.typical_for(sizes_of(model.transmission, model.link))


class BundledModels:
    """The models that come with the package: their names in turn, each an attribute too."""

    def __iter__(self) -> Iterator[str]:
        return iter(sorted(path.stem for path in MODELS_FOLDER.glob("*.toml")))

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def __contains__(self, name: object) -> bool:
        return name in tuple(self)

    def __getattr__(self, name: str) -> Model:
        if name not in self:
            raise AttributeError(f"there is no bundled model {name}; there are {', '.join(self)}")
        return load_model(name)

    def __dir__(self) -> list[str]:
        return list(self)

    def __repr__(self) -> str:
        return f"bundled models: {', '.join(self)}"


models = BundledModels()


def load_model(model: str | Path | Mapping[str, Any]) -> Model:
    """Read a model.toml, or a bundled model by its name, or check the content of one.

    A bundled name means the bundled model also where a file is called the same; write
    ``./name`` for the file.

    Parameters
    ----------
    model : path of a model.toml, one of `models`, or what a model.toml would hold, as a dict

    Returns
    -------
    Model

    Raises
    ------
    ModelError
        for a file that cannot be read or used, with all its problems
    EffectError
        for an effect of an installed package that cannot be used
    """
    if isinstance(model, Mapping):
        return parse_model(model, "the model")
    source = str(model)
    path = MODELS_FOLDER / f"{source}.toml" if source in models else Path(source)
    return model_from_toml(_read(path, source), source)


def parse_model(tree: Mapping[str, Any], source: str) -> Model:
    """Check the content of a model.toml; `source` names it in messages.

    Raises
    ------
    ModelError
        with all problems at once
    EffectError
        for an effect of an installed package that cannot be used
    """
    try:
        return Model.model_validate(tree)
    except ValidationError as error:
        listed = tree.get("effects")
        present = effects.BY_ID.keys() & (listed if isinstance(listed, Mapping) else ())
        of_effects = (_effect_quantities(effect) for effect in effects.BY_ID.values())
        every = (*declared_in(Model), *chain.from_iterable(of_effects))
        linear = tree.get("motion") == MotionKind.LINEAR
        motion = MotionKind.LINEAR if linear else MotionKind.ROTARY
        declared = {quantity.path: quantity for quantity in motion.quantities(every)}
        keys = _known_keys(declared, present, "transmission" in tree)
        raise ModelError(source, problems.sentences(error, declared, keys)) from None


def model_from_toml(content: bytes | str, source: str) -> Model:
    """The model that the text of a model.toml describes; errors as of `parse_model`."""
    try:
        text = content if isinstance(content, str) else content.decode("utf-8-sig")
        tree = tomllib.loads(text)
    except UnicodeDecodeError:
        fault = "this is not a text file; a model.toml is expected"
    except tomllib.TOMLDecodeError as error:
        fault = f"this is not valid TOML: {error}"
    except RecursionError:
        fault = "its tables or lists are nested too deeply"
    except ValueError as error:
        fault = f"cannot be read: {error}"
    else:
        return parse_model(tree, source)
    raise ModelError(source, [fault])


def _read(path: Path, source: str) -> bytes:
    try:
        if not path.is_dir():
            return path.read_bytes()
        fault = "this is a folder; give the model.toml in it"
    except (FileNotFoundError, NotADirectoryError):
        fault = (
            "there is no such file; give the path of a model.toml or one of the bundled models "
            + ", ".join(models)
        )
    except (OSError, ValueError) as error:  # ValueError: a NUL in the path
        fault = f"cannot be read: {error}"
    raise ModelError(source, [fault])


def _effect_quantities(effect: Effect) -> Iterator[Quantity]:
    """Quantities of an effect, nominal for an actuator of nominal numbers."""
    return effect_quantities(effect, _nominal_sizes())


@lru_cache
def _nominal_sizes() -> Sizes:
    tree: dict[str, Any] = {}
    for quantity in declared_in(Model):
        *tables, key = quantity.path.split(".")
        table = tree
        for name in tables:
            table = table.setdefault(name, {})
        table[key] = quantity.default if quantity.integer else quantity.nominal
    return sizes_of(
        Transmission.model_validate(tree["transmission"]), Link.model_validate(tree["link"])
    )


@lru_cache
def _uncertainty_schema(paths: tuple[str, ...]) -> type[BaseModel]:
    bound = {"default": 0.0, "ge": 0.0}
    return closed_schema("uncertainty", dict.fromkeys(paths, (float, bound)))


def _known_keys(
    declared: Mapping[str, Quantity], present: Iterable[str], springs: bool
) -> dict[str, list[str]]:
    """Keys that each table of model.toml may hold, by the table's dotted path."""
    kind = InterfaceKind.POSITION if springs else InterfaceKind.LOAD
    keys: dict[str, list[str]] = {"": list(Model.model_fields)}
    for path in declared:
        parts = path.split(".")
        for depth in range(1, len(parts)):
            siblings = keys.setdefault(".".join(parts[:depth]), [])
            if parts[depth] not in siblings:
                siblings.append(parts[depth])
    keys["effects"] = list(effects.BY_ID.ids())
    keys["uncertainty"] = [quantity.path for quantity in quantities(present, kind)]
    return keys


def _descend(tree: Any, path: str) -> Any:
    for key in path.split("."):
        tree = tree[key]
    return tree


def _plain(value: Any, integer: bool) -> Any:
    """Python number of a numpy one, and 2 of 2.0 where whole numbers are kept."""
    if isinstance(value, bool) or not isinstance(value, Real):
        return value
    plain = float(value)
    return int(plain) if integer and plain.is_integer() else plain

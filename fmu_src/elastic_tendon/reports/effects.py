"""The catalogue of effects and the page of each, for the terminal, from their declarations."""

from collections.abc import Iterable, Iterator, Mapping

from rich.console import Group
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from elastic_tendon.actuator.parameters import Model, typical_value
from elastic_tendon.actuator.quantity import unit_text
from elastic_tendon.actuator.variables import places
from elastic_tendon.effects import BY_ID
from elastic_tendon.effects.base import Effect, Parameter, Slot

ACTS_ON = {
    Slot.MOTOR_SIGNAL: "the reading of the motor encoder",
    Slot.ANGLE_MAP: "the way from motor to motor pulley",
    Slot.SERIES_ELEMENT: "each tendon, in series with its springs",
    Slot.SPRING_LAW: "each spring, beside its own force",
    Slot.SPRING_MASS: "each spring, between its halves",
    Slot.TENDON_LOSS: "the tendons' forces on their way to the joint",
    Slot.JOINT_TORQUE: "the joint, as a torque",
    Slot.DRY_FRICTION: "the joint, as dry friction that can hold it",
    Slot.JOINT_SIGNAL: "the reading of the joint encoder",
    Slot.DEFLECTION_SIGNAL: "the reading of a deflection sensor",
    Slot.JOINT_TORQUE_SIGNAL: "the measured joint torque",
    Slot.MOTOR_TORQUE_SIGNAL: "the measured motor torque",
    Slot.UPPER_FORCE_SIGNAL: "the measured force of the upper tendon",
    Slot.LOWER_FORCE_SIGNAL: "the measured force of the lower tendon",
    Slot.SIGNAL_DELAY: "the time at which the joint's signals are recorded",
    Slot.MOTOR_TORQUE: "the rotor, as a torque",
    Slot.MOTOR_FRICTION: "the rotor, as dry friction that can hold it",
}


def effects_table(effects: Iterable[Effect], elsewhere: Mapping[str, str]) -> Table:
    """Effects that are loaded, then those `elsewhere`: id and the package that has it."""
    table = Table(
        title="Effects that can be added to a model",
        caption="elastic-tendon effects ID explains one and draws how it shows",
    )
    table.add_column("id", no_wrap=True)
    table.add_column("what it is")
    table.add_column("parameters")
    for effect in effects:
        names = ", ".join(
            f"{parameter.name} ({unit_text(parameter.unit)})" for parameter in effect.parameters
        )
        table.add_row(effect.id, effect.title, names)
    for effect_id, package in sorted(elsewhere.items()):
        table.add_row(effect_id, f"(from {package}; runs when you name it)", "")
    return table


def effect_page(effect: Effect, example: Model) -> Group:
    """One effect in full; typical values are those on the model `example`."""
    parts: list[Text | Padding] = [Text(f"{effect.title} ({effect.id})", style="bold underline")]
    for heading, paragraphs in effect_sections(effect, example):
        parts.append(Text(f"\n{heading}", style="bold"))
        parts += [Padding(Text(text), (0, 0, 0, 2), expand=False) for text in paragraphs]
    return Group(*parts)


ON_REQUEST = (
    "Where it is asked for: by its name in `add`, in `diagnose --only` beside what else may be "
    "missing, or at its defaults in the model. Else only at the end, where all other effects leave "
    "much, and for an answer that leaves nothing but noise."
)


def effect_sections(effect: Effect, example: Model) -> list[tuple[str, list[str]]]:
    """Headings of an effect's page, each with its paragraphs; what says nothing is left out.

    Parameters
    ----------
    effect : Effect
    example : Model, on which typical values are told
    """
    sections = (
        ("What it is", [effect.physics]),
        ("Acts on", [ACTS_ON[effect.slot]]),
        ("Law", [effect.law]),
        ("How it shows in data", [effect.in_data]),
        ("Easily confused with", [effect.confused_with, *_aliases(effect)]),
        ("Searched for", [ON_REQUEST] if effect.on_request else []),
        ("How to make sure", [effect.confirm]),
        ("Cure", [effect.cure]),
        ("Size", [effect.magnitude]),
        (
            f"Parameters, typical on {example.name}; at the defaults the effect is absent",
            [_parameter(effect, parameter, example) for parameter in effect.parameters],
        ),
        ("States", _states(effect)),
        ("Not together with", _rivals(effect)),
        ("Reference", [effect.reference]),
    )
    filled = ((heading, [text for text in texts if text]) for heading, texts in sections)
    return [(heading, texts) for heading, texts in filled if texts]


def _parameter(effect: Effect, parameter: Parameter, example: Model) -> str:
    return (
        f"effects.{effect.id}.{parameter.name} ({unit_text(parameter.unit)}): "
        f"typical {typical_value(example, parameter):.3g}, default {parameter.null:g}, "
        f"from {parameter.lower:g} to {parameter.upper:g}; {parameter.meaning}"
    )


def _aliases(effect: Effect) -> Iterator[str]:
    for alias in BY_ID.aliases_of(effect):
        yield f"Indistinguishable from {' and '.join(alias.of)} as long as {alias.when}."


def _states(effect: Effect) -> list[str]:
    names = places(effect, (effect,))
    return [
        f"{', '.join(f'{place}.{state.name}' for place in names)} "
        f"({unit_text(state.unit)}): {state.meaning}"
        for state in effect.states
    ]


def _rivals(effect: Effect) -> list[str]:
    """Effects that claim to be the same law; a model takes one of them."""
    others = [
        rival.id for rival in BY_ID.values() if rival.law_of == effect.law_of and rival != effect
    ]
    if not effect.law_of or not others:
        return []
    return [f"{', '.join(others)}: a model takes one law of {effect.law_of}"]

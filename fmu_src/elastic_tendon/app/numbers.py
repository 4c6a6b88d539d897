"""The parameters of a model as a table in which they are edited; nothing of the page is here."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import groupby

from elastic_tendon import effects
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.quantity import Quantity, unit_text
from elastic_tendon.errors import ModelError

DIGITS = 6  # of a number in its field; one that is not touched keeps all of them


@dataclass(frozen=True)
class Number:
    """One number: `text` is what its field shows, `was` the same of the model as it was loaded."""

    path: str
    words: str
    value: float
    text: str
    was: str
    unit: str
    bounds: str
    meaning: str

    @property
    def changed(self) -> bool:
        """Whether it was edited since the model was loaded."""
        return self.text != self.was


@dataclass(frozen=True)
class Section:
    """Numbers of one part of the machine, or of one effect."""

    title: str
    numbers: tuple[Number, ...]


def sections(model: Model, loaded: Model) -> tuple[Section, ...]:
    """All run-time parameters of a model, part by part.

    Parameters
    ----------
    model : Model
    loaded : the same model before numbers were edited
    """
    values, before = model.values(), loaded.values()
    return tuple(
        Section(
            _title(table),
            tuple(
                Number(
                    path=quantity.path,
                    words=quantity.path.rpartition(".")[2].replace("_", " "),
                    value=values[quantity.path],
                    text=shown(values[quantity.path]),
                    was=shown(before[quantity.path]),
                    unit=unit_in_words(quantity.unit),
                    bounds=f"{_bound(quantity.lower)} to {_bound(quantity.upper)}",
                    meaning=quantity.meaning,
                )
                for quantity in group
            ),
        )
        for table, group in _by_table(model)
    )


def _by_table(model: Model) -> list[tuple[str, list[Quantity]]]:
    def table(quantity: Quantity) -> str:
        return quantity.path.rpartition(".")[0]

    # the pretension stands behind the springs, and belongs to the transmission
    order = list(dict.fromkeys(map(table, model.quantities())))
    ordered = sorted(model.quantities(), key=lambda quantity: order.index(table(quantity)))
    return [(name, list(group)) for name, group in groupby(ordered, key=table)]


def _title(table: str) -> str:
    first, _, last = table.partition(".")
    if first == "effects":
        return effects.BY_ID[last].title
    return (last or first).replace("_", " ").capitalize()


def _bound(value: float) -> str:
    return with_minus(f"{value:g}")


def unit_in_words(unit: str) -> str:
    """A unit as people write it; "" of what has none."""
    return "" if unit == "1" else unit_text(unit)


def shown(value: float) -> str:
    """A number as its field shows it."""
    return with_minus(f"{value:.{DIGITS}g}")


def with_minus(text: str) -> str:
    """Numbers in a text as people write them: 1e6 for 1e+06, a minus for a hyphen."""
    plain = re.sub(r"(?<=\d)e([+-])0*(?=\d)", lambda sign: "e" + sign[1].strip("+"), text)
    return re.sub(r"(?<![\w.)])-(?=\d)|(?<=\de)-(?=\d)", "−", plain)


def parsed(text: str) -> float | None:
    """The number that a field holds, None where it is none; Python alone would take 1_000."""
    plain = text.replace("−", "-")
    try:
        return float(plain) if plain.isascii() and "_" not in plain else None
    except ValueError:
        return None


def edited(model: Model, texts: Mapping[str, str]) -> tuple[Model, dict[str, str]]:
    """Take over what the fields hold, as far as it is allowed.

    Parameters
    ----------
    model : Model; a number whose field shows it as it is keeps all its digits
    texts : dotted path -> what its field holds; paths that the model does not have are passed over

    Returns
    -------
    the model with all that is allowed, and for each path that is not a sentence why
    """
    refused: dict[str, str] = {}
    before, values = model, model.values()
    for path, text in texts.items():
        if path not in values or text == shown(values[path]):
            continue
        number = parsed(text)
        if number is None:
            refused[path] = f"“{text}” is not a number; the last one is kept."
            continue
        try:
            model = model.with_values({path: number})
        except ModelError as error:
            problems = "; ".join(problem.removeprefix(f"{path}: ") for problem in error.problems)
            # as the user wrote the number, and as the table writes its bounds
            problems = with_minus(problems.replace(f"{number} is", f"{text.strip()} is"))
            refused[path] = f"{problems}; {shown(values[path])} is kept."
    # what was taken may allow what was refused before it
    return edited(model, texts) if refused and model != before else (model, refused)

"""Sentences for what pydantic found wrong in a model.toml."""

import difflib
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from pydantic import ValidationError

from elastic_tendon.actuator.quantity import Quantity

# unit wanted -> (factor, unit in which people have such numbers at hand)
LOOKALIKES: Mapping[str, Sequence[tuple[float, str]]] = {
    "m": ((1e-3, "millimetres"), (1e-2, "centimetres")),
    "N/m": ((1e3, "kN/m or N/mm"),),
    "kg.m2": ((1e-4, "kg.cm2"), (1e-6, "kg.mm2")),
    "kg": ((1e-3, "grams"),),
}
LONGEST_VALUE = 60  # characters of a found value that a sentence repeats
MOST_KEYS = 6  # keys of a missing table that a sentence names
REFUSED = "refused"  # type of a problem whose message is a sentence already

WRONG_TYPES = {
    "float_type": "a number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "string_type": "a text",
    "model_type": "a table",
    "model_attributes_type": "a table",
    "dict_type": "a table",
}


def sentences(
    error: ValidationError, declared: Mapping[str, Quantity], keys: Mapping[str, Sequence[str]]
) -> list[str]:
    """One sentence for each problem: the dotted field, the value found, what is allowed.

    Parameters
    ----------
    error : what pydantic found
    declared : quantity at each dotted path
    keys : keys known in each table, by the table's dotted path ("" is the file itself)
    """
    return [_sentence(dict(problem), declared, keys) for problem in error.errors()]


def unknown_key(path: str, key: str, known: Iterable[str], where: str) -> str:
    """Sentence for a key that nobody reads, with the nearest known one."""
    known = list(known)
    nearest = difflib.get_close_matches(key, known, n=1)
    advice = f"did you mean {nearest[0]}?" if nearest else f"known are {', '.join(known)}"
    return f"{path}: not known in {where}; {advice}"


def unknown_effect(effect_id: str, known: Iterable[str]) -> str:
    """Sentence for an effect that nobody has loaded, with the nearest known one."""
    known = list(known)
    nearest = difflib.get_close_matches(effect_id, known, n=1)
    advice = f"did you mean {nearest[0]}?" if nearest else f"choose one of {', '.join(known)}"
    return (
        f"there is no effect {effect_id!r}; {advice} "
        "(your own is loaded by --effect FILE.py, in Python by effects.load)"
    )


def _sentence(
    problem: dict[str, Any], declared: Mapping[str, Quantity], keys: Mapping[str, Sequence[str]]
) -> str:
    location = [str(part) for part in problem["loc"]]
    path, parent = ".".join(location), ".".join(location[:-1])
    kind, value = problem["type"], _shown(problem["input"])
    quantity = declared.get(path)
    if kind == REFUSED:
        return f"{path}: {problem['msg']}"
    if kind == "extra_forbidden" and parent == "effects":
        return f"{path}: {unknown_effect(location[-1], keys[parent])}"
    if kind == "extra_forbidden":
        where = f"[{parent}]" if parent else "a model.toml"
        return unknown_key(path, location[-1], keys.get(parent, ()), where)
    if kind == "missing":
        return f"{path}: missing; {_wanted(path, quantity, keys)}"
    if kind in WRONG_TYPES:
        fault = f"is not {WRONG_TYPES[kind]}; {_wanted(path, quantity, keys)}"
    elif kind == "finite_number":
        fault = f"is not finite; {_wanted(path, quantity, keys)}"
    elif kind in ("greater_than_equal", "less_than_equal") and quantity is not None:
        unit = "" if quantity.unit == "1" else f" {quantity.unit}"
        fault = f"is outside {quantity.lower:g} to {quantity.upper:g}{unit}"
        fault += _hint(problem["input"], quantity)
    else:
        fault = "is refused: " + problem["msg"][:1].lower() + problem["msg"][1:]
    return f"{path}: {value} {fault}"


def _wanted(path: str, quantity: Quantity | None, keys: Mapping[str, Sequence[str]]) -> str:
    if quantity is not None:
        number = "a whole number" if quantity.integer else "a number"
        unit = "" if quantity.unit == "1" else f" in {quantity.unit}"
        bounds = f"{quantity.lower:g} to {quantity.upper:g}"
        return f"{number}{unit} from {bounds} is expected ({quantity.meaning})"
    if path in keys:
        shown = [*keys[path][:MOST_KEYS], "..."] if len(keys[path]) > MOST_KEYS else keys[path]
        return f"a table [{path}] with {', '.join(shown)} is expected"
    return "a number is expected" if path.startswith("uncertainty.") else "a text is expected"


def _hint(value: float, quantity: Quantity) -> str:
    for factor, unit in LOOKALIKES.get(quantity.unit, ()):
        if quantity.lower <= value * factor <= quantity.upper:
            return f" (is it in {unit}?)"
    return ""


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= LONGEST_VALUE else text[: LONGEST_VALUE - 3] + "..."

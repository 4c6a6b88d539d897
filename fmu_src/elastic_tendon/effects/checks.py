"""Whether an effect of a user's own can be used: its declaration, and its equations once called.

Each check yields a word of the declaration, by which its line is found, and what is wrong.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import fields
from inspect import isfunction
from itertools import chain
from keyword import iskeyword
from math import isfinite
from numbers import Real
from types import NoneType, SimpleNamespace, UnionType
from typing import Any, get_args, get_origin, get_type_hints

import casadi as ca
import numpy as np

from elastic_tendon.effects.base import (
    Answer,
    Contribution,
    Effect,
    FrictionBounds,
    HalfTensions,
    Joint,
    JointPulley,
    Motor,
    MotorAngle,
    Parameter,
    Relation,
    Signal,
    Sizes,
    Slot,
    Spring,
    SpringHalves,
    State,
    Tendon,
)
from elastic_tendon.effects.source import Source
from elastic_tendon.effects.symbolic import one_at_a_time
from elastic_tendon.effects.units import base_exponents
from elastic_tendon.errors import BuildError

Fault = tuple[str, str]  # word whose line is at fault, and what is wrong

_TRIALS = 8  # random numbers and modes at which an effect is looked for where it must be absent
_VANISHED = 1e-12  # what may be left there by rounding, of quantities of order one

_TEXTS = ("title", "physics", "in_data", "reference")
_TRIAL = Sizes(  # of some actuator, to try out what depends on sizes
    torque=10.0,
    stiffness=1e4,
    max_deflection=0.01,
    joint_stiffness=20.0,
    inertia=0.03,
    radius=0.03,
    parallel=2,
)
_PLACES: Mapping[Slot, type | None] = {
    Slot.MOTOR_SIGNAL: Signal,
    Slot.ANGLE_MAP: MotorAngle,
    Slot.SERIES_ELEMENT: Tendon,
    Slot.SPRING_LAW: Spring,
    Slot.SPRING_MASS: SpringHalves,
    Slot.TENDON_LOSS: JointPulley,
    Slot.JOINT_TORQUE: Joint,
    Slot.DRY_FRICTION: Joint,
    Slot.JOINT_SIGNAL: Signal,
    Slot.DEFLECTION_SIGNAL: Signal,
    Slot.JOINT_TORQUE_SIGNAL: Signal,
    Slot.MOTOR_TORQUE_SIGNAL: Signal,
    Slot.UPPER_FORCE_SIGNAL: Signal,
    Slot.LOWER_FORCE_SIGNAL: Signal,
    Slot.SIGNAL_DELAY: None,
    Slot.MOTOR_TORQUE: Motor,
    Slot.MOTOR_FRICTION: Motor,
}
_ANSWERS: Mapping[Slot, type] = {
    Slot.SPRING_MASS: HalfTensions,
    Slot.TENDON_LOSS: FrictionBounds,
    Slot.DRY_FRICTION: FrictionBounds,
    Slot.MOTOR_FRICTION: FrictionBounds,
}


@one_at_a_time
def check(effect: object, source: Source) -> Effect:
    """The effect, if it can be used.

    Parameters
    ----------
    effect : what the file calls EFFECT
    source : the file

    Returns
    -------
    Effect

    Raises
    ------
    EffectError
        for the first fault, with its line
    """
    if not isinstance(effect, Effect):
        raise source.error(
            f"EFFECT is of type {type(effect).__name__}; an Effect of "
            "elastic_tendon.effects is expected",
            source.line_of("EFFECT"),
        )
    declared = chain(_types(effect), _texts(effect), _names(effect), _numbers(effect))
    _raise_first(declared, source)
    _raise_first(_functions(effect, source), source)
    _check_equations(effect, source)
    return effect


def _raise_first(faults: Iterable[Fault], source: Source) -> None:
    for word, fault in faults:
        raise source.error(fault, source.line_of(word))


# ---- declaration ---------------------------------------------------------------------------


def _parts(effect: Effect) -> Iterator[Any]:
    yield from (*effect.parameters, *effect.states, *effect.relations, *effect.aliases)


def _types(effect: Effect) -> Iterator[Fault]:
    """Fields that are not of the type that the class declares, which Python does not ask."""
    yield from _types_in(effect)
    for part in _parts(effect):
        yield from _types_in(part)


def _types_in(thing: Any) -> Iterator[Fault]:
    kind = type(thing)
    named = getattr(thing, "name", "")
    owner = f"{kind.__name__} {named}".rstrip()
    for name, hint in get_type_hints(kind).items():
        value = getattr(thing, name)
        if not _fits(value, hint):
            wanted = _words(hint)
            if get_origin(hint) is tuple and get_args(hint)[0] is type(value):
                wanted += " (one alone needs a comma behind it)"
            word = named if isinstance(named, str) and named else name
            yield word, f"{name} of {owner} is {_shown(value)}; {wanted} is expected"


def _fits(value: object, hint: Any) -> bool:
    origin, arguments = get_origin(hint), get_args(hint)
    if origin is tuple:
        return isinstance(value, tuple) and all(_fits(item, arguments[0]) for item in value)
    if origin is UnionType:
        return any(_fits(value, argument) for argument in arguments)
    if origin is Callable or hint is Callable:
        return callable(value)
    if hint is float:
        return isinstance(value, Real) and not isinstance(value, bool)
    return isinstance(value, hint)


def _words(hint: Any) -> str:
    origin, arguments = get_origin(hint), get_args(hint)
    if origin is tuple:
        return f"a tuple of {_words(arguments[0]).removeprefix('a ')}"
    if origin is UnionType:
        return " or ".join(_words(argument) for argument in arguments)
    plain = {str: "a text", float: "a number", bool: "True or False", NoneType: "None"}
    return plain.get(hint) or ("a function" if origin is Callable else f"a {hint.__name__}")


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 40 else f"a {type(value).__name__}"


def _texts(effect: Effect) -> Iterator[Fault]:
    for name in _TEXTS:
        if not getattr(effect, name).strip():
            yield name, f"{name} is empty; write a sentence, it is shown to users"
    for part in _named(effect):
        if not part.meaning.strip():
            yield part.name, f"meaning of {part.name!r} is empty; say what it is, in one phrase"


def _names(effect: Effect) -> Iterator[Fault]:
    for name in (effect.id, *(part.name for part in _named(effect))):
        if not re.fullmatch("[A-Za-z][A-Za-z0-9_]*", name) or iskeyword(name):
            yield (
                name or "id",
                f"{name!r} cannot be a name; one of letters, digits and _ that begins with a "
                "letter is expected, as in Python",
            )
    parameters, others = len(effect.parameters), [part.name for part in _named(effect)]
    for names in (others[:parameters], others[parameters:]):
        for name in names:
            if names.count(name) > 1:
                yield name, f"the name {name!r} stands twice; give each its own"


def _named(effect: Effect) -> tuple[Parameter | State | Relation, ...]:
    return (*effect.parameters, *effect.states, *effect.relations)


def _numbers(effect: Effect) -> Iterator[Fault]:
    with_unit: tuple[Parameter | State, ...] = (*effect.parameters, *effect.states)
    for part in with_unit:
        try:
            base_exponents(part.unit)
        except BuildError as error:
            yield part.name, f"unit {part.unit!r} of {part.name} is not known: {error}"
    for parameter in effect.parameters:
        name, lower, upper = parameter.name, parameter.lower, parameter.upper
        if not lower < upper:
            yield name, f"{name}: lower {lower:g} is not below upper {upper:g}"
        if not (isfinite(parameter.null) and lower <= parameter.null <= upper):
            yield name, f"{name}: null {parameter.null:g} is outside {lower:g} to {upper:g}"
    for state in effect.states:
        if not (isfinite(state.nominal) and state.nominal > 0.0):
            yield state.name, f"{state.name}: nominal {state.nominal:g} is not a positive size"
        if state.start is not None and not isfinite(state.start):
            yield state.name, f"{state.name}: start {state.start:g} is not finite"


# ---- functions -----------------------------------------------------------------------------


def _functions(effect: Effect, source: Source) -> Iterator[Fault]:
    """Typical sizes and judgements, tried on numbers; where the equations are written."""
    if not isfunction(effect.equations) or effect.equations.__code__.co_filename != source.file:
        yield (
            "equations",
            "equations is not a function written in this file; define it here, because a library "
            "is compiled anew when this file changes",
        )
    typical = {}
    for parameter in effect.parameters:
        name, lower, upper = parameter.name, parameter.lower, parameter.upper
        value = _tried(parameter.typical_for, _TRIAL, name, source, f"typical of {name}")
        if not (_fits(value, float) and isfinite(value) and value != 0.0):
            yield name, f"{name}: typical is {_shown(value)}; a number not 0 is expected"
        if not lower <= value <= upper:
            yield name, f"{name}: typical {value:g} is outside {lower:g} to {upper:g}"
        typical[name] = min(max(value, lower), upper)
    null = {parameter.name: parameter.null for parameter in effect.parameters}
    for words, numbers in (("null", null), ("typical", typical)):
        for name in ("refuses", "cautions"):
            sentence = _tried(getattr(effect, name), numbers, name, source, name)
            if not isinstance(sentence, str):
                yield name, f"{name} returns {_shown(sentence)}; a text is expected"
            if sentence and name == "refuses":
                yield name, f"it refuses its own {words} values: {sentence}"


def _tried(
    function: Callable[[Any], Any], given: object, word: str, source: Source, words: str
) -> Any:
    try:
        return function(given)
    except Exception as error:
        raise source.blamed(error, f"{words} cannot be evaluated", source.line_of(word)) from None


# ---- equations -----------------------------------------------------------------------------


def _check_equations(effect: Effect, source: Source) -> None:
    """Call the equations with symbols, as the model will, and look at what they return."""
    line = effect.equations.__code__.co_firstlineno
    at = _place(effect.slot)
    names = (effect.parameters, effect.states, effect.relations)
    p, state, mode = (
        SimpleNamespace(**{part.name: ca.SX.sym(part.name) for part in parts}) for parts in names
    )
    try:
        answer = effect.equations(at, p, state, mode)
    except Exception as error:
        raise source.blamed(error, "the equations cannot be evaluated", line) from None
    given = [
        *_symbols(at),
        *(symbol for space in (p, state, mode) for symbol in vars(space).values()),
    ]
    for fault in chain(_shape(effect, answer), _expressions(answer, given), _rate(at, answer)):
        raise source.error(f"the equations {fault}", line)
    null = ca.vertcat(*(parameter.null for parameter in effect.parameters))
    absent = [
        ca.substitute(added, ca.vertcat(*vars(p).values()), null) for added in _added(at, answer)
    ]
    for fault in _vanishes(absent, given, list(vars(mode).values())):
        raise source.error(f"the equations {fault}", line)


def _added(at: Any, answer: Answer) -> list[ca.SX]:
    """What must be zero where the effect is absent."""
    if isinstance(answer, FrictionBounds):
        return [ca.SX(answer.lower), ca.SX(answer.upper)]
    if isinstance(answer, Contribution):
        return [ca.SX(answer.value) - (at.motor_position if isinstance(at, MotorAngle) else 0)]
    return []  # a spring's mass has no value of its own


def _vanishes(absent: list[ca.SX], given: list[ca.SX], modes: list[ca.SX]) -> Iterator[str]:
    """Whether nothing is left at the nulls, tried on random numbers and modes."""
    trial = ca.Function("trial", given, absent)
    random = np.random.default_rng(1)
    is_mode = [any(ca.is_equal(symbol, mode) for mode in modes) for symbol in given]
    for _ in range(_TRIALS):
        numbers = [random.integers(2) if mode else random.uniform(0.1, 1.0) for mode in is_mode]
        for left in trial.call([ca.DM(float(number)) for number in numbers]):
            if not abs(float(left)) < _VANISHED:
                yield (
                    f"leave {float(left):.3g} where all parameters have their null values; there "
                    "the effect must be absent"
                )
                return


def _place(slot: Slot) -> Any:
    kind = _PLACES[slot]
    if kind is None:
        return None
    given: dict[str, Any] = {field.name: ca.SX.sym(field.name) for field in fields(kind)}
    if kind is SpringHalves:
        given |= dict.fromkeys(("motor_half", "joint_half"), lambda x, v: ca.fmax(x + v, 0))
    return kind(**given)


def _symbols(at: Any) -> list[ca.SX]:
    values = () if at is None else (getattr(at, field.name) for field in fields(at))
    return [value for value in values if isinstance(value, ca.SX)]


def _shape(effect: Effect, answer: object) -> Iterator[str]:
    """Whether class and names of the answer are those that slot and declaration promise."""
    kind = _ANSWERS.get(effect.slot, Contribution)
    if not isinstance(answer, kind):
        slot = f"Slot.{effect.slot.name}"
        yield f"return {_shown(answer)}; {kind.__name__} is expected in {slot}"
    calculated = tuple(state for state in effect.states if state.start is None)
    for name, declared, where in (
        ("rates", effect.states, "states"),
        ("starts", calculated, "states with start None"),
        ("thresholds", effect.relations, "relations"),
    ):
        given = getattr(answer, name, {})
        if not isinstance(given, Mapping):
            yield f"return {_shown(given)} as {name}; a dict is expected"
        names = {item.name for item in declared}
        if missing := ", ".join(sorted(names - given.keys())):
            yield f"give no {name} for {missing}, declared among the {where}"
        if unknown := ", ".join(sorted(map(str, given.keys() - names))):
            yield f"give {name} for {unknown}, not declared among the {where}"


def _values(answer: Any) -> Iterator[tuple[str, Any]]:
    """Every expression of an answer, by what it is called."""
    for field in fields(answer):
        value = getattr(answer, field.name)
        if isinstance(value, Mapping):
            yield from ((f"{field.name}[{name!r}]", item) for name, item in value.items())
        else:
            yield field.name, value


def _expressions(answer: Any, given: list[ca.SX]) -> Iterator[str]:
    """Whether each value is a number or one expression of the symbols that were given."""
    for name, value in _values(answer):
        try:
            expression = ca.SX(value)
        except NotImplementedError:  # so CasADi calls what is no expression
            yield f"return {_shown(value)} as {name}; an expression of symbols is expected"
            return
        if expression.shape != (1, 1):
            yield f"return {expression.numel()} values as {name}; a single one is expected"
        function = ca.Function("f", given, [expression], {"allow_free": True})
        if free := function.get_free():
            yield f"return {name} with the symbol {free[0]}, which they were not given"
        if not all(isfinite(constant) for constant in _constants(function)):
            yield (
                f"return {name} with a number that is not finite; take functions from "
                "elastic_tendon.effects.symbolic, those of math make nan of a symbol"
            )


def _constants(function: ca.Function) -> Iterator[float]:
    for k in range(function.n_instructions()):
        if function.instruction_id(k) == ca.OP_CONST:
            yield function.instruction_constant(k)


def _rate(at: Any, answer: Any) -> Iterator[str]:
    """Whether a spring's force and state rates are affine in the rate of elongation."""
    if not isinstance(at, Spring):
        return
    for name, value in _values(answer):
        if name == "value" or name.startswith("rates"):
            slope = ca.simplify(ca.jacobian(ca.SX(value), at.rate))
            if ca.depends_on(slope, at.rate):
                yield (
                    f"return {name} that is not affine in at.rate; turn a choice by its sign into "
                    "a relation"
                )

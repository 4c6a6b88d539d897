"""What an FMU of this software has by name: parameters, modes, and all that is needed of it."""

import difflib
import re
from collections.abc import Mapping
from functools import reduce
from typing import Any

import numpy as np
from fmpy.model_description import ModelVariable
from pydantic import ValidationError

from elastic_tendon.actuator.parameters import quantities
from elastic_tendon.actuator.sections import Transmission
from elastic_tendon.actuator.system import HYSTERESIS
from elastic_tendon.actuator.variables import INPUTS, JOINT_MOTION, OUTPUTS, interface
from elastic_tendon.effects import BY_ID
from elastic_tendon.errors import LinearisationError
from elastic_tendon.linear.model_exchange import Instance

VELOCITY_USED = "motor_velocity_connected"
INPUT_NAMES = tuple(variable.name for variable in INPUTS)
STARTING = 1e-6  # rad/s, at which a joint starts that shall slide
_TRANSMISSION = "transmission."
_FIRST_STATES = ("joint_position", "joint_velocity")


def mode_places(instance: Instance) -> Mapping[str, tuple[int, ...]]:
    """Places of each mode's event indicators.

    FMI 3.0 names the indicators; for FMI 2.0 they are known where all effects are. Else they are
    numbered, from ``indicator_1``, and only the joint's motion has its name.

    Parameters
    ----------
    instance : that has just started with its joint moving up at `STARTING`
    """
    z = instance.indicators()
    names = _indicator_names(instance)
    if len(names) != len(z):
        names = [f"indicator_{i + 1}" for i in range(len(z))]
        # those of the joint's motion come last, if there are any, and say that it moves up
        if np.array_equal(z[-2:], [STARTING + HYSTERESIS, -1.0]):
            names[-2:] = [JOINT_MOTION.name] * 2
    places: dict[str, tuple[int, ...]] = {}
    for i, name in enumerate(names):
        places[name] = (*places.get(name, ()), i)
    return places


def _indicator_names(instance: Instance) -> list[str]:
    """The mode of each event indicator, as far as they can be known."""
    if instance.version == 3:
        named = [indicator.variable.name for indicator in instance.description.eventIndicators]
        return [re.sub(r"\.indicator(\[\d+])?$", "", name) for name in named]
    effects = {name.split(".")[1] for name in instance.variables if name.startswith("effects.")}
    modes = interface(tuple(effects & BY_ID.keys())).modes
    return [mode.name for mode in modes for _ in range(mode.indicators)]


def check_names(instance: Instance) -> None:
    """Refuse an FMU that lacks what a linear model needs.

    Raises
    ------
    LinearisationError
        by the first name that is missing
    """
    needed = [
        *INPUT_NAMES,
        *(variable.name for variable in OUTPUTS),
        VELOCITY_USED,
        *_pulleys_and_springs(),
    ]
    missing = [name for name in needed if name not in instance.variables]
    missing += [name for name in _FIRST_STATES if name not in instance.states[:2]]
    if missing:
        raise LinearisationError(
            f"{instance.name}: the FMU has no {missing[0]}, so it is none of elastic-tendon; "
            "give one that elastic-tendon export wrote"
        )
    if not instance.description.modelExchange.canGetAndSetFMUstate:
        raise LinearisationError(
            f"{instance.name}: the FMU cannot get and set its state, which is needed here; "
            "export it anew"
        )


def check_start_values(instance: Instance, values: Mapping[str, float]) -> None:
    """Refuse what is no parameter of the FMU, or no value of its type.

    Raises
    ------
    LinearisationError
        by the first of them
    """
    for name, value in values.items():
        variable = instance.variables.get(name)
        if variable is None or variable.causality != "parameter":
            known = [
                n for n, declared in instance.variables.items() if declared.causality == "parameter"
            ]
            nearest = difflib.get_close_matches(name, known, n=1) or known[:1]
            raise LinearisationError(
                f"{instance.name}: start value {name}: the FMU has no such parameter; did you mean "
                f"{nearest[0]}?"
            )
        if not np.isfinite(value) or (_is_whole(variable) and value != int(value)):
            kind = "whole" if _is_whole(variable) else "finite"
            raise LinearisationError(
                f"{instance.name}: start value {name}: {value} is no {kind} number; give one"
            )


def _is_whole(variable: ModelVariable) -> bool:
    return variable.type in ("Integer", "Int32")


def _pulleys_and_springs() -> list[str]:
    return [quantity.path for quantity in quantities(()) if quantity.path.startswith(_TRANSMISSION)]


def transmission_of(instance: Instance) -> Transmission:
    """The paper's numbers, as the FMU has them now.

    Raises
    ------
    LinearisationError
        where they do not go together
    """
    tables: dict[str, Any] = {}
    for path in _pulleys_and_springs():
        *parents, last = path.removeprefix(_TRANSMISSION).split(".")
        table = reduce(lambda outer, key: outer.setdefault(key, {}), parents, tables)
        value = instance.get(path)
        table[last] = int(value) if _is_whole(instance.variables[path]) else value
    try:
        return Transmission.model_validate(tables)
    except ValidationError as error:
        problem = error.errors()[0]
        path = ".".join(map(str, problem["loc"]))
        raise LinearisationError(
            f"{instance.name}: {_TRANSMISSION}{path} = {problem['input']}: {problem['msg']}; give "
            "other start values"
        ) from None

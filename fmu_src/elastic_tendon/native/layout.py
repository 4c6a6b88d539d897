"""Variables of the FMU in their order: value references, roles and start values.

The description (XML) and the binary (a C table) are both made from this list, so they agree. One
table of unique value references serves every FMI version. Nothing here needs CasADi.
"""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from math import inf, isnan, nan

from elastic_tendon.actuator.variables import (
    MOTOR_VELOCITY,
    OUTPUTS,
    Interface,
    Kind,
    Mode,
    Variable,
)

MOTOR_VELOCITY_CONNECTED = Variable(
    "motor_velocity_connected",
    "1",
    "whether the input motor_velocity is used; false: co-simulation takes the derivative of "
    "motor_position where an importer of FMI 2.0 gives it, else the difference of successive "
    "communication points over their distance; model exchange takes 0",
    Kind.BOOLEAN,
    lower=0.0,
    upper=1.0,
)
_SLACK_STATE = next(output for output in OUTPUTS if output.kind is Kind.SLACK_STATE)
_SLACK_STATE_NUMBER = replace(
    _SLACK_STATE,
    name=f"{_SLACK_STATE.name}_number",
    meaning=f"{_SLACK_STATE.name} as an integer, for importers that take no enumerations",
    kind=Kind.INTEGER,
)
OUTSIDE_VALIDITY = Variable(
    "outside_validity",
    "1",
    "whether inputs or motion are outside the range in which the model was validated; in model "
    "exchange as of the last event",
    Kind.BOOLEAN,
    lower=0.0,
    upper=1.0,
)
_EVERYWHERE = (-inf, inf)
_TIME = Variable("time", "s", "simulation time")
_TYPICAL_DURATION = 0.1  # s, in which a state moves by its nominal value


class Role(Enum):
    """What a variable is to the model; the value is its name in C."""

    TIME = "ROLE_TIME"
    INPUT = "ROLE_INPUT"
    STATE = "ROLE_STATE"
    DERIVATIVE = "ROLE_DERIVATIVE"
    OUTPUT = "ROLE_OUTPUT"
    PARAMETER = "ROLE_PARAMETER"
    OPTION = "ROLE_OPTION"  # motor_velocity_connected
    VALIDITY = "ROLE_VALIDITY"  # outside_validity, where it was asked for
    INDICATOR = "ROLE_INDICATOR"  # only in FMI 3.0


@dataclass(frozen=True)
class FmuVariable:
    """A variable of the FMU.

    `index` counts within the role: among the states, the inputs, ... of the model. `start` is
    None where the value is calculated. `is_output` marks outputs, of which some are states.
    `valid` : least and largest value of where the model was validated.
    """

    value_reference: int
    variable: Variable
    role: Role
    index: int
    is_output: bool
    start: float | None
    valid: tuple[float, float] = _EVERYWHERE

    @property
    def name(self) -> str:
        """Name, structured by dots."""
        return self.variable.name

    @property
    def variability(self) -> str:
        """When the value may change, in FMI's terms."""
        if self.role is Role.OPTION or (self.role is Role.PARAMETER and not self.variable.tunable):
            return "fixed"
        if self.role is Role.PARAMETER:
            return "tunable"
        return "discrete" if self.variable.discrete else "continuous"


# fields of FmuVariable after the first, but the last
_Row = tuple[Variable, Role, int, bool, float | None]


def rate_unit(unit: str) -> str:
    """Unit of the time derivative of a variable, such as ``rad/s2`` for ``rad/s``."""
    if unit.endswith("/s"):
        return unit + "2"
    if "/" in unit:
        above, below = unit.split("/")
        return f"{above}/({below.strip('()')}.s)"
    return unit + "/s"


def _derivative(state: Variable) -> Variable:
    return Variable(
        f"der({state.name})",
        rate_unit(state.unit),
        f"time derivative of {state.name}",
        nominal=state.nominal / _TYPICAL_DURATION,
    )


def _indicators(mode: Mode) -> Iterator[Variable]:
    for number in range(1, mode.indicators + 1):
        place = f"[{number}]" if mode.indicators > 1 else ""
        yield Variable(
            f"{mode.name}.indicator{place}", "1", f"changes its sign at an event: {mode.meaning}"
        )


def layout(
    interface: Interface,
    parameters: Mapping[str, float],
    *,
    indicators: bool = False,
    validity: Mapping[str, tuple[float, float]] | None = None,
) -> tuple[FmuVariable, ...]:
    """Variables of the FMU; a variable's place in the tuple is its value reference.

    Parameters
    ----------
    interface : of the structure
    parameters : value of each parameter by its dotted path, SI
    indicators : whether event indicators are variables too, as FMI 3.0 wants them
    validity : name -> range, SI, of inputs, states and outputs that the variable outside_validity
        watches; None: there is no such variable
    """
    states = {state.name: i for i, state in enumerate(interface.states)}
    rows: list[_Row] = [(_TIME, Role.TIME, 0, False, None)]
    for i, variable in enumerate(interface.inputs):
        rows.append((variable, Role.INPUT, i, False, variable.start))
    for i, variable in enumerate(interface.outputs):
        if variable.name in states:
            number = states[variable.name]
            state = interface.states[number]  # its nominal is what the solver works with
            rows.append((state, Role.STATE, number, True, state.start))
        else:
            rows.append((variable, Role.OUTPUT, i, True, None))
    for i, variable in enumerate(interface.states):
        if variable.name not in interface.output_names:
            rows.append((variable, Role.STATE, i, False, variable.start))
    for i, variable in enumerate(interface.states):
        rows.append((_derivative(variable), Role.DERIVATIVE, i, False, None))
    for i, variable in enumerate(interface.parameters):
        rows.append((variable, Role.PARAMETER, i, False, parameters[variable.name]))
    if MOTOR_VELOCITY in interface.inputs:
        option, velocity = MOTOR_VELOCITY_CONNECTED, interface.inputs.index(MOTOR_VELOCITY)
        rows.append((option, Role.OPTION, velocity, False, option.start))
    if indicators:
        listed = (variable for mode in interface.modes for variable in _indicators(mode))
        rows.extend(
            (indicator, Role.INDICATOR, i, False, None) for i, indicator in enumerate(listed)
        )
    if _SLACK_STATE in interface.outputs:
        number = interface.outputs.index(_SLACK_STATE)
        rows.append((_SLACK_STATE_NUMBER, Role.OUTPUT, number, True, None))
    if validity is not None:
        rows.append((OUTSIDE_VALIDITY, Role.VALIDITY, 0, True, None))
    ranges = [(validity or {}).get(row[0].name, _EVERYWHERE) for row in rows]
    return tuple(
        FmuVariable(reference, *row, valid=valid)
        for reference, (row, valid) in enumerate(zip(rows, ranges, strict=True))
    )


def default_layout(interface: Interface) -> tuple[FmuVariable, ...]:
    """Layout with the default of every parameter, as the cached library has it."""
    return layout(
        interface, {parameter.name: parameter.start or 0.0 for parameter in interface.parameters}
    )


def _c_start(variable: FmuVariable) -> float:
    """Start value; NaN asks the solver to calculate that of a state."""
    if variable.start is None:
        return nan if variable.role is Role.STATE else 0.0
    return variable.start


def _c_number(value: float) -> str:
    if isnan(value):
        return "NAN"
    if value in (inf, -inf):
        return "INFINITY" if value > 0 else "-INFINITY"
    return repr(float(value))


def _c_text(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)


def text_table(name: str, texts: Iterable[str]) -> str:
    """C source of a table of texts."""
    return f"static const char *const {name}[] = {{{', '.join(map(_c_text, texts))}}};"


def structure(name: str, fields: Mapping[str, str]) -> str:
    """C source of a structure, its fields by name with their types."""
    declared = "".join(f"  {kind} {field};\n" for field, kind in fields.items())
    return f"typedef struct {name} {{\n{declared}}} {name};"


_COLUMNS: Mapping[str, tuple[str, Callable[[FmuVariable], str]]] = {  # type in C, and what it shows
    "name": ("const char *", lambda variable: _c_text(variable.name)),
    "type": ("Type", lambda variable: f"TYPE_{variable.variable.kind.value.upper()}"),
    "role": ("Role", lambda variable: variable.role.value),
    "index": ("int", lambda variable: str(variable.index)),
    "is_output": ("int", lambda variable: str(int(variable.is_output))),
    "tunable": ("int", lambda variable: str(int(variable.variable.tunable))),
    "start": ("double", lambda variable: _c_number(_c_start(variable))),
    "lower": ("double", lambda variable: _c_number(variable.variable.lower)),
    "upper": ("double", lambda variable: _c_number(variable.variable.upper)),
    "valid_low": ("double", lambda variable: _c_number(variable.valid[0])),
    "valid_high": ("double", lambda variable: _c_number(variable.valid[1])),
}


def c_tables(
    variables: Iterable[FmuVariable],
    modes: Sequence[Mode],
    tolerance: float,
    fmi_version: int,
) -> str:
    """C source of the tables that `native/runtime/instance.c` works from.

    Parameters
    ----------
    variables : from `layout`
    modes : of the model, in order
    tolerance : of the solver where the importer sets none
    fmi_version : 2 or 3
    """
    rows = [
        f"  {{{', '.join(cell(variable) for _, cell in _COLUMNS.values())}}},"
        for variable in variables
    ]
    return "\n".join(
        [
            f"#define FMI_VERSION {fmi_version}",
            f"#define N_VARIABLES {len(rows)}",
            '#include "token.h"',
            f"#define MODEL_TOLERANCE {tolerance!r}",
            '#include "shared.h"',
            structure("VariableInfo", {name: kind for name, (kind, _) in _COLUMNS.items()}),
            '#include "instance.h"',
            "static const VariableInfo variables[] = {",
            *rows,
            "};",
            text_table("mode_name", (mode.name for mode in modes)),
            text_table("mode_warning", (mode.meaning if mode.warns else "" for mode in modes)),
            "",
        ]
    )

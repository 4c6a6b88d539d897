"""Facts that C and Python share, each written once, here or in `layout` and `actuator/variables`.

`header` writes them for C; Python takes numbers, texts and classes for ctypes from here.
"""

import ctypes
from collections.abc import Iterable, Mapping

from elastic_tendon.actuator.variables import Kind
from elastic_tendon.native.interpolation import INTERPOLATIONS
from elastic_tendon.native.layout import Role, structure, text_table

Fields = Mapping[str, str]  # name -> its type in C

TOLERANCES = (1e-14, 1e-2)  # smallest and largest, of the solver
OUTCOMES = {  # of the solver; what it says to the user
    "SOLVED": "solved",
    "AT_EVENT": "stopped at an event",  # which is left to the caller
    "STEP_TOO_SMALL": "the step size fell below the resolution of time",
    "TOO_MANY_STEPS": "far too many steps would be needed: "
    "something in the model moves much faster than its inputs and samples",
    "TOO_MANY_EVENTS": "more than a hundred thousand events: take shorter steps, or, where slack, "
    "friction or hysteresis change to and fro without end, smaller spring damping or hysteresis",
    "EVENTS_DO_NOT_SETTLE": "the slack or friction states do not settle",
    "STARTS_DO_NOT_SETTLE": "the starts of the springs' states do not settle",
    "NOT_FINITE": "a state, its rate or an event indicator is not finite",
    "SHORT_OF_MEMORY": "memory is short",
    "INTERRUPTED": "interrupted",
}
LOG_CATEGORIES = {  # of an FMU: name, and what is told there
    "LOG_WARNING": ("logStatusWarning", "what may not be meant"),
    "LOG_DISCARD": ("logStatusDiscard", "steps that cannot be taken"),
    "LOG_ERROR": ("logStatusError", "calls that are refused"),
    "LOG_EVENTS": (
        "logEvents",
        "tendons that become slack or taut, friction that sticks or slides",
    ),
}
STATISTICS = ("steps", "implicit_steps", "rejected", "rates", "events", "grazing")
STRUCTURES: Mapping[str, Fields] = {  # sizes in elements, arrays row by row
    "Statistics": dict.fromkeys(STATISTICS, "long long"),
    "Simulation": {
        "n_samples": "long long",
        "time": "const double *",  # s, increasing
        # inputs but those that are rates of others: N_GIVEN x n_samples
        "input": "const double *",
        "input_slope": "const double *",  # per second, the same, for CUBIC
        "interpolation": "long long",
        "parameters": "const double *",
        "initial_state": "const double *",
        "tolerance": "double",
        "most_steps": "long long",  # after which it is given up; 0: the solver's own limit
        "n_directions": "long long",
        "direction": "const int *",  # index in v = [x; u; p]: of an initial state or a parameter
        "states": "double *",  # out: n_samples x N_STATES
        "outputs": "double *",  # out: n_samples x N_OUTPUTS
        "output_derivatives": "double *",  # out: n_samples x N_OUTPUTS x n_directions
        "event_time": "double *",  # out, s: of the first event_capacity located events
        "event_capacity": "long long",
        "interrupted": "Interrupted *",  # asked once a second whether to stop; optional
        "second": "long long",  # in which it was asked
        "statistics": "Statistics",  # out
        "failure_time": "double",  # out, s, where the outcome is not SOLVED
    },
    "Runs": {  # one motion, again and again with other parameters
        "n_runs": "long long",
        "parameters": "const double *",  # n_runs x N_PARAMETERS
        "n_kept": "long long",
        "kept": "const int *",  # indices of the outputs that are kept
        "outputs": "double *",  # out: n_runs x n_kept x n_samples, NaN of a run that failed
        "outcome": "int *",  # out: an Outcome for each run
        "failure_time": "double *",  # out: n_runs, s
    },
    "EachStep": {  # of actuators that another simulator steps: what is common to all
        "duration": "double",  # s
        "tolerance": "double",
        "n_results": "long long",  # outputs that are written, the first of each
    },
    "ListedActuator": {  # one of them, with functions of its own library
        "act": "Act *",
        "memory": "void *",  # all that changes
        "constants": "const double *",
        "input": "const double *",  # N_INPUTS
        "result": "double *",  # out
    },
}
_TOLERANCES = tuple(zip(("SMALLEST", "LARGEST"), TOLERANCES, strict=True))
_ENUMERATIONS: Mapping[str, Iterable[str]] = {
    "Interpolation": [name.upper() for name in INTERPOLATIONS],
    "Outcome": OUTCOMES,
    "Type": [f"TYPE_{kind.value.upper()} = {1 << i}" for i, kind in enumerate(Kind)],  # bits
    "Role": [role.value for role in Role],
    "Category": [*LOG_CATEGORIES, "N_CATEGORIES"],
}


def classes(
    structures: Mapping[str, Fields], address: type = ctypes.c_void_p
) -> dict[str, type[ctypes.Structure]]:
    """Classes for ctypes, by name, of structures that may hold those before them; with pointers
    of the type `address`."""
    known: dict[str, type] = {"long long": ctypes.c_longlong, "double": ctypes.c_double}
    made: dict[str, type[ctypes.Structure]] = {}
    for name, fields in structures.items():
        listed = [
            (field, address if kind.endswith("*") else (known | made)[kind])
            for field, kind in fields.items()
        ]
        made[name] = type(name, (ctypes.Structure,), {"_fields_": listed})
    return made


def places_in_page(structure: str) -> dict[str, tuple[int, str]]:
    """Where a page, whose addresses have 32 bits, finds the numbers of a structure.

    Returns
    -------
    dict of offsets in bytes and types in C by field, also of structures in it, whose names are
    put before; "" has the size of all
    """
    made = classes(STRUCTURES, ctypes.c_uint32)[structure]
    places: dict[str, tuple[int, str]] = {"": (ctypes.sizeof(made), "")}
    for field, kind in STRUCTURES[structure].items():
        start = getattr(made, field).offset
        if kind in STRUCTURES:
            inner = places_in_page(kind).items()
            places |= {f"{field}.{name}": (start + at, of) for name, (at, of) in inner if name}
        else:
            places[field] = (start, kind)
    return places


def header(structures: Mapping[str, Fields] = STRUCTURES) -> str:
    """C source of ``shared.h``: enumerations, their texts, and structures."""
    enumerations = (
        f"typedef enum {{ {', '.join(members)} }} {name};"
        for name, members in _ENUMERATIONS.items()
    )
    lines = [
        "/* Written by native/shared.py, which explains what stands here. */",
        *("#ifndef SHARED_H", "#define SHARED_H"),
        *(f"#define {name}_TOLERANCE {value:g}" for name, value in _TOLERANCES),
        "typedef int Interrupted(void);",
        "struct EachStep;",
        "typedef int Act(void *, const double *, const struct EachStep *, const double *,",
        "                double *);",
        *enumerations,
        text_table("outcome_text", OUTCOMES.values()),
        text_table("category_name", (name for name, _ in LOG_CATEGORIES.values())),
        *(structure(name, fields) for name, fields in structures.items()),
        "#endif\n",
    ]
    return "\n".join(lines)

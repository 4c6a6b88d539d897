"""The model that lives in a page: its module for WebAssembly, and a panel with its numbers."""

import json
import math
import zlib
from base64 import b64encode
from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import sha256
from string import Template
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastic_tendon import effects
from elastic_tendon.actuator.design import design
from elastic_tendon.actuator.parameters import Model, typical_value
from elastic_tendon.actuator.quantity import Quantity, unit_text
from elastic_tendon.actuator.variables import SIGNALS, interface
from elastic_tendon.fmu.icon import PAGES
from elastic_tendon.native.interpolation import INTERPOLATIONS
from elastic_tendon.native.library import DEFAULT_TOLERANCE, page_module
from elastic_tendon.native.shared import OUTCOMES, places_in_page
from elastic_tendon.progress import Progress, silent
from elastic_tendon.simulation.excitation import motor_amplitude
from elastic_tendon.simulation.simulate import EVENT_CAPACITY, given_names

Intervals = Mapping[str, tuple[float, float]]  # of estimates, by dotted path

LARGEST = 350_000  # characters of a module in a page; models with very many effects exceed it
ALLOWED = "'wasm-unsafe-eval'"  # what a content security policy must allow beside the script
_SAMPLES = 600  # of a step
_PERIODS, _SHORTEST, _LONGEST = 12.0, 0.3, 4.0  # of the joint with both tendons taut, s
_MOST_STEPS = 50_000  # of a simulation that a slider asks for: what takes longer is given up
_WIDEST = 4.0  # sizes of a number by which its slider goes beyond it, however wide the interval
_NEAR = 3  # whole numbers that a slider offers on each side
# of the page in an FMU
_LINK = '<a href="#try">Try it</a>\n'
_INTRODUCTION = """
<h2 id="try">Try it</h2>
<p>The model runs in this page: each slider simulates it anew, with the solver of the binary. The
step may be dragged in the upper diagram, too.</p>
"""
_INSTEAD = """<p>Here the model itself would run and follow your sliders. It needs JavaScript and
WebAssembly, one of which is switched off; the picture under Equations shows its torque at rest.</p>
"""


# ---- the module --------------------------------------------------------------------------------


def described(model: Model, progress: Progress = silent) -> dict[str, Any]:
    """What `pages/model.js` needs to simulate a structure, for JSON.

    Parameters
    ----------
    model : Model
    progress : told where its module has to be compiled

    Raises
    ------
    BuildError
        where the compiler refuses
    """
    variables = interface(*model.structure)
    module = zlib.compress(page_module(*model.structure, progress), 9)
    return {
        "module": b64encode(module).decode(),
        "places": places_in_page("Simulation"),
        "interpolations": INTERPOLATIONS,
        "outcomes": tuple(OUTCOMES.values()),
        "tolerance": DEFAULT_TOLERANCE,
        "mostSteps": _MOST_STEPS,
        "eventCapacity": EVENT_CAPACITY,
        "inputs": given_names(model),
        "start": [state.start for state in variables.states],
        "states": variables.state_names,
        "outputs": variables.output_names,
        # of a call, after the parameters; see `Interface.reads_signals`
        "settings": [True] * variables.reads_signals,
        "parameterCount": len(variables.parameters),
    }


# ---- sliders -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Number:
    """A slider: what it is called and means, its value, range and 95 % interval, in `unit`."""

    path: str
    label: str
    note: str
    unit: str
    value: float
    low: float
    high: float
    interval: tuple[float, float] | None = None
    whole: bool = False


def numbers(model: Model, intervals: Intervals) -> tuple[Number, ...]:
    """A slider for each parameter of a model, in the order in which the library takes them.

    Parameters
    ----------
    model : Model
    intervals : 95 % intervals of what was estimated, which a slider covers
    """
    values = model.values()
    return tuple(
        _number(model, quantity, values[quantity.path], intervals.get(quantity.path))
        for quantity in model.quantities()
    )


def _number(
    model: Model, quantity: Quantity, value: float, interval: tuple[float, float] | None
) -> Number:
    low, high = _range(quantity, value, _size(model, quantity, value), interval or (value, value))
    parts = quantity.path.split(".")
    of_effect = parts[0] == "effects"
    unit = "" if quantity.unit == "1" else unit_text(quantity.unit)
    return Number(
        path=quantity.path,
        label=model.motion.words(" ".join(parts[2 if of_effect else 1 :]).replace("_", " ")),
        note=quantity.meaning,
        unit=unit,
        value=value,
        low=low,
        high=high,
        interval=interval,
        whole=quantity.integer,
    )


def _size(model: Model, quantity: Quantity, value: float) -> float:
    """How far a number is moved: by itself, of an effect by what is typical at least."""
    if not quantity.path.startswith("effects."):
        return abs(value) or quantity.nominal
    _, effect_id, name = quantity.path.split(".")
    declared = {parameter.name: parameter for parameter in effects.BY_ID[effect_id].parameters}
    return max(abs(value), abs(typical_value(model, declared[name])))


def _range(
    quantity: Quantity, value: float, size: float, interval: tuple[float, float]
) -> tuple[float, float]:
    """From half to twice a number, of an effect from where it vanishes; never beyond its bounds."""
    if quantity.integer:
        low, high = value - _NEAR, value + _NEAR
    else:
        vanishing = quantity.default if quantity.path.startswith("effects.") else value
        low = min(vanishing, value - size / 2, max(interval[0], value - _WIDEST * size))
        high = max(vanishing, value + size, min(interval[1], value + _WIDEST * size))
    return max(low, quantity.lower), min(high, quantity.upper)


def groups(model: Model, intervals: Intervals | None = None) -> list[dict[str, Any]]:
    """Sliders in groups: those of effects first, then what was estimated, then, closed, the rest.

    Each number has its place in the library's order.

    Parameters
    ----------
    model : Model
    intervals : see `numbers`; none where nothing was estimated
    """
    intervals = intervals or {}
    found: dict[tuple[int, str], list[dict[str, Any]]] = {}
    for place, number in enumerate(numbers(model, intervals)):
        first, second, *_ = number.path.split(".")
        if first == "effects":
            rank, title = 0, effects.BY_ID[second].title
        elif number.interval or not intervals:
            rank, title = 1, first.capitalize()
        else:
            rank, title = 2, f"{first.capitalize()}, not fitted"
        found.setdefault((rank, title), []).append(vars(number) | {"place": place})
    ordered = sorted(found.items(), key=lambda group: group[0][0])
    return [
        {"title": model.motion.words(title), "open": rank < 2, "numbers": members}
        for (rank, title), members in ordered
    ]


# ---- motions -----------------------------------------------------------------------------------


def _step(model: Model) -> dict[str, Any]:
    """A step of what drives the motor: a slider for its size and one for its time."""
    table = design(model)
    signal = "motor_torque" if model.kind.has_rotor else "motor_position"
    periods = _PERIODS * 2.0 * math.pi / table.frequency_state_3 if model.kind.has_link else 1.0
    duration = min(max(periods, _SHORTEST), _LONGEST)
    share = model.transmission.motor_share
    size = motor_amplitude(table) / share
    if model.kind.has_rotor:
        size *= table.stiffness_state_3 * share**2
    unit = unit_text(model.motion.unit(SIGNALS[signal].unit))
    words = _words(model, signal)
    return {
        "signal": signal,
        "title": f"a step of the {words}",
        "samples": _SAMPLES,
        "duration": duration,
        "numbers": [
            vars(Number("", f"step of the {words}", "", unit, size, -2 * size, 2 * size)),
            vars(Number("", "time of the step", "", "s", 0.1 * duration, 0.0, 0.9 * duration)),
        ],
    }


@dataclass(frozen=True)
class LiveRecording:
    """A recording to lay beside the model: what drives it, and what was measured.

    `time` (n,) s; `inputs` (n,) arrays by name, SI; `slopes` of them, per second, where they run
    in curves; `start` : first value of the states by name; `measured` (n,) arrays by signal, SI;
    `readings` : the output that shows what a signal's sensor reads; `small`, `small_unit` : factor
    from SI to the unit of the first signal's error, as of a machine that turns.
    """

    title: str
    time: NDArray[np.float64]
    inputs: Mapping[str, NDArray[np.float64]]
    slopes: Mapping[str, NDArray[np.float64]]
    interpolation: str
    start: Mapping[str, float]
    measured: Mapping[str, NDArray[np.float64]]
    readings: Mapping[str, str]
    small: float
    small_unit: str


def _words(model: Model, signal: str) -> str:
    return model.motion.words(signal.replace("_", " "))


def _shown(model: Model, signal: str) -> dict[str, str]:
    unit = unit_text(model.motion.unit(SIGNALS[signal].unit))
    return {"words": _words(model, signal), "unit": unit}


def _packed(values: NDArray[np.float64]) -> str:
    return b64encode(np.ascontiguousarray(values, dtype="<f8").tobytes()).decode()


def _recorded(model: Model, recording: LiveRecording) -> dict[str, Any]:
    none = np.zeros(len(recording.time))
    states = interface(*model.structure).states
    names = given_names(model)
    return {
        "title": recording.title,
        "time": _packed(recording.time),
        "inputs": [_packed(recording.inputs.get(name, none)) for name in names],
        "slopes": [_packed(recording.slopes.get(name, none)) for name in names],
        "interpolation": recording.interpolation,
        "start": [recording.start.get(state.name, state.start) for state in states],
        "measured": {name: _packed(values) for name, values in recording.measured.items()},
        "readings": recording.readings,
        "erring": _words(model, next(iter(recording.measured))),
        "small": recording.small,
        "smallUnit": model.motion.words(recording.small_unit),
    }


# ---- the panel ---------------------------------------------------------------------------------


def live_panel(
    model: Model,
    instead: str,
    *,
    intervals: Intervals | None = None,
    recording: LiveRecording | None = None,
    progress: Progress = silent,
) -> str:
    """HTML of a panel in which a model runs; its page needs `script`, `style` and `ALLOWED` too.

    "" where there is no step to show (see `runs_in_page`), or the module is larger than a page
    bears.

    Parameters
    ----------
    model : Model
    instead : HTML that is shown in its place where WebAssembly is off, and on paper
    intervals : 95 % intervals of what was estimated
    recording : to lay beside it
    progress : told where its module has to be compiled

    Raises
    ------
    BuildError
        where the compiler refuses
    """
    if not runs_in_page(model):
        return ""
    content = {
        **described(model, progress),
        "groups": groups(model, intervals),
        "step": _step(model),
        "shown": {name: _shown(model, name) for name in ("joint_position", "joint_torque")},
        "recording": None if recording is None else _recorded(model, recording),
    }
    if len(content["module"]) > LARGEST:
        return ""
    return Template(_text("live.html")).substitute(instead=instead, model=script_safe(content))


def runs_in_page(model: Model) -> bool:
    """Whether a page can show a model: it has springs, and the numbers of its link."""
    return model.kind.has_springs and not model.link.absent


def fmu_panel(model: Model) -> str:
    """The panel of an FMU's page, with the sentence above it; errors as of `live_panel`."""
    panel = live_panel(model, _INSTEAD)
    return _INTRODUCTION + panel if panel else ""


def page_parts(panel: str) -> dict[str, str]:
    """What else the page of an FMU holds for its panel, by place; nothing where there is none."""
    code = f"/*<![CDATA[*/\n{script()}/*]]>*/"  # the page is XML, too
    policy = f"default-src 'none'; script-src {source_expression(code)} {ALLOWED}; "
    policy += "style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'"
    parts = {
        "live": panel,
        "live_link": _LINK,
        "policy": f'<meta http-equiv="Content-Security-Policy" content="{policy}"/>\n',
        "script": f"<script>{code}</script>\n",
    }
    return parts if panel else dict.fromkeys(parts, "")


def script() -> str:
    """What makes a panel alive."""
    return "".join(map(_text, ("model.js", "curves.js", "live.js")))


def style() -> str:
    """How a panel looks."""
    return _text("live.css")


def _text(name: str) -> str:
    return (PAGES / name).read_text("utf-8")


def source_expression(code: str) -> str:
    """How a content security policy allows just this script."""
    digest = b64encode(sha256(code.encode()).digest()).decode()
    return f"'sha256-{digest}'"


def script_safe(tree: Any) -> str:
    """JSON that cannot end the script element it stands in, nor begin a comment there."""
    text = json.dumps(tree, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    for letter in "<>&":  # they occur in strings only
        text = text.replace(letter, f"\\u{ord(letter):04x}")
    return text

"""Linear models for the terminal: where each holds, what it says; numbers come from `linear`."""

from collections.abc import Callable, Iterator, Sequence
from math import degrees, pi

from rich.box import SIMPLE_HEAD
from rich.table import Table

from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.actuator.variables import JOINT_MOTION
from elastic_tendon.linear.analysis import (
    JOINT_TORQUE,
    Analysis,
    Pole,
    analyse,
    frequency_span,
    is_joint_given,
    main_channels,
    motor_input,
)
from elastic_tendon.linear.drive import MOTOR_POSITION, MOTOR_VELOCITY
from elastic_tendon.linear.names import all_effects, state_name
from elastic_tendon.linear.result import Boundary, Drive, LinearModel

DRIVES = {
    Drive.SOURCE: "motor position and velocity",
    Drive.POSITION: "motor position",
    Drive.VELOCITY: "motor velocity",
    Drive.TORQUE: "motor torque",
}
TOWARDS = ("towards −", "towards +")  # of deflection: the models of both sides
ABREAST = 3  # models in one table of the terminal
NOTHING = "–"

Channels = Sequence[tuple[str, str]]  # input and output


def columns(models: Sequence[LinearModel]) -> list[tuple[str, LinearModel]]:
    """Models with what distinguishes them beside their state; on a boundary, those of both sides.

    A model that is that of neither side of its boundary comes first.
    """
    named: list[tuple[str, LinearModel]] = []
    for model in models:
        states = [side.validity.slack_state for side in model.sides]
        if model.validity.slack_state not in states:
            named.append(("", model))
        for labelled in zip(TOWARDS, model.sides, strict=False):
            if not any(_same(labelled[1], known) for _, known in named):
                named.append(labelled)
    return named


def title_of(name: str, model: LinearModel) -> str:
    """Name of an actuator, and what moves the motor and the joint of its linear models."""
    also = ", joint given" if is_joint_given(model) else ""
    return f"{name}: linear models, driven by {DRIVES[model.drive]}{also}"


def linear_table(
    name: str, models: Sequence[LinearModel], channels: Channels | None = None
) -> Table:
    """One column for each state: where it lies, whether it is active, what it says.

    Parameters
    ----------
    name : of the actuator
    models : of one drive, with all inputs and outputs
    channels : inputs and outputs of which zeros are shown; None: the main ones of the drive
    """
    return _table(name, columns(models), channels)


def linear_tables(
    name: str, models: Sequence[LinearModel], channels: Channels | None = None
) -> Iterator[Table]:
    """The same in several tables, of no more columns than 80 letters are enough for."""
    shown = columns(models)
    for start in range(0, len(shown), ABREAST):
        yield _table(name, shown[start : start + ABREAST], channels)


def _table(name: str, shown: Sequence[tuple[str, LinearModel]], channels: Channels | None) -> Table:
    title = title_of(name, shown[0][1])
    table = Table(title=title, box=SIMPLE_HEAD, min_width=len(title))
    table.add_column("", no_wrap=True)
    for towards, model in shown:
        heading = model.validity.slack_state.label.replace(": ", "\n")
        table.add_column(f"{heading}\n{towards}".rstrip(), justify="right")
    every = [model for _, model in shown]
    for label, tell in _PLACE:
        _add(table, label, [tell(model) for model in every])
    table.add_section()
    analyses = [analyse(model) for model in every]
    for label, read in _NUMBERS:
        _add(table, label, [read(analysis) for analysis in analyses])
    table.add_section()
    for input_name, output_name in channels or _present(main_channels(shown[0][1]), every):
        label = f"zeros, {_words(input_name)}\n→ {_words(output_name)} (rad/s)"
        zeros_of_states = [analysis.channel(input_name, output_name).zeros for analysis in analyses]
        _add(
            table,
            label,
            [_roots([zero for zero in zeros if zero.imag >= 0]) for zeros in zeros_of_states],
        )
    if shown[0][1].drive is Drive.TORQUE:
        driving = motor_input(shown[0][1])
        collocated = [analysis.channel(driving, MOTOR_POSITION) for analysis in analyses]
        frequencies = [
            "\n".join(map(_digits, channel.anti_resonances)) or NOTHING for channel in collocated
        ]
        _add(table, "motor's anti-resonance (rad/s)", frequencies)
    return table


def remarks(models: Sequence[LinearModel]) -> list[str]:
    """Sentences below the table: the span of frequencies, and what a reader has to know."""
    every = [model for _, model in columns(models)]
    sentences = []
    analyses = [analyse(model) for model in every]
    span = frequency_span(analyses)
    without = [
        state_name(model.validity.slack_state)
        for model, analysis in zip(every, analyses, strict=True)
        if analysis.tendon_oscillation is None
    ]
    if span is not None and len(every) - len(without) > 1:
        sentences.append(
            f"Between the states the tendons' natural frequency spans {span.lowest:.3g} to "
            f"{span.highest:.3g} rad/s, a factor {span.ratio:.3g}."
        )
    if without and span is not None:
        sentences.append(
            f"In state {' and '.join(without)} the joint does not oscillate on its tendons."
        )
    on = [_at(model) for model in every if model.validity.on_boundary]
    here = {
        boundary.deflection: _switching(boundary) for boundary in reversed(on)
    }  # as the first side tells it
    sentences.extend(
        f"The operating point lies on a switching boundary ({words}): the models of both sides "
        "are given."
        for words in here.values()
    )
    if any(_slides_at_rest(model) for model in every):
        sentences.append(
            "Dry friction of the joint counts as sliding, in which it is constant; of a "
            f"model.toml, --mode {JOINT_MOTION.name}=0 gives the joint that sticks."
        )
    if not all(model.validity.active for model in every):
        sentences.append(
            "Where a state is not active, the boundaries are those of the state that is."
        )
    if any(JOINT_TORQUE not in model.output_labels for model in every):
        sentences.append(
            "Torques of damped springs need the motor's velocity, which --drive position has not."
        )
    if any(map(_has_memory, every)):
        sentences.append(
            "Stiffness and damping of the tendons are those of a small and sudden motion, in which "
            "nothing has relaxed; the static stiffness is that of the joint in the long run."
        )
    if any(_velocity_acts(model) for model in every):
        sentences.append(
            "Motor position and velocity are inputs of their own, as of the FMU, so a zero is that "
            "of one of them alone; --drive position or velocity joins them."
        )
    return sentences


def mode_words(name: str, value: int) -> str:
    """What happens where a mode takes a value, as "lower tendon goes slack"."""
    side = name.partition("_")[0]
    if name.endswith(".taut"):
        return f"{side} tendon {'comes taut' if value else 'goes slack'}"
    if name.endswith(".spans"):
        return f"{side} spring {'spans' if value else 'is longer than'} its slack tendon"
    if name.endswith(".overstretched"):
        return f"{side} spring {'' if value else 'no longer '}overstretched"
    meanings = {mode.name: mode.meaning for mode in all_effects().modes}
    place = f"{side} spring: " if name.startswith(("upper_spring.", "lower_spring.")) else ""
    return f"{place}{meanings.get(name, name)}{'' if value else ' no more'}"


def _present(channels: Channels, models: Sequence[LinearModel]) -> Channels:
    """Channels that all have: with damped springs, a motor driven by position has no torque."""
    names = [(model.input_labels, model.output_labels) for model in models]
    return [
        (input_name, output_name)
        for input_name, output_name in channels
        if all(input_name in inputs and output_name in outputs for inputs, outputs in names)
    ]


def _same(first: LinearModel, second: LinearModel) -> bool:
    return first.validity.modes == second.validity.modes and (
        first.validity.operating_point == second.validity.operating_point
    )


def _add(table: Table, label: str, cells: Sequence[str]) -> None:
    if any(cells):
        table.add_row(label, *cells)


# ---- where a model lies --------------------------------------------------------------------


def _deflection(model: LinearModel) -> str:
    value = model.validity.operating_point.outputs["deflection"]
    turned = f"\n{degrees(value):.4g}°" if model.motion is MotionKind.ROTARY else ""
    return f"{_digits(value)} rad{turned}"


def _input(name: str, unit: str) -> Callable[[LinearModel], str]:
    return lambda model: f"{_digits(model.validity.operating_point.inputs[name])} {unit}"


def _velocity(model: LinearModel) -> str:
    value = model.validity.operating_point.states["joint_velocity"]
    return f"{_digits(value)} rad/s" if value else ""


def _active(model: LinearModel) -> str:
    validity = model.validity
    if validity.active:
        return "yes"
    there = validity.operating_point
    if there.slack_state is not validity.slack_state:
        return f"no: {state_name(there.slack_state)} is"
    differ = [
        mode_words(name, value)
        for name, value in there.modes.items()
        if value != validity.modes.get(name, value) and name != JOINT_MOTION.name
    ]
    return f"no: there {', '.join(differ)}" if differ else "no"


def _engaged(model: LinearModel) -> str:
    """Modes of effects that are on; a tendon's slack is in the heading."""
    modes = model.validity.modes
    engaged = [
        mode_words(name, value)
        for name, value in modes.items()
        if value and name != JOINT_MOTION.name and not name.endswith(".taut")
    ]
    if modes.get(JOINT_MOTION.name) == 0:
        engaged.append("joint sticks")
    return "\n".join(engaged)


def _next(sign: int) -> Callable[[LinearModel], str]:
    def tell(model: LinearModel) -> str:
        boundaries = [boundary for boundary in model.validity.boundaries if _of_place(boundary)]
        # that on which the model lies ends it on one side
        ends = boundaries[-1:] if sign > 0 else boundaries[:1]
        beyond = [boundary for boundary in ends if sign * boundary.deflection_margin >= 0]
        if not beyond:
            return "none"
        nearest = beyond[0]
        margins = f"{nearest.deflection_margin:+.4g} rad\n{nearest.torque_margin:+.4g} N·m"
        return f"{margins}\n{_switching(nearest)}"

    return tell


def _of_place(boundary: Boundary) -> bool:
    """Whether a boundary lies elsewhere along the deflection, or here; no break-away."""
    return JOINT_MOTION.name not in boundary.switches


def _breakaway(model: LinearModel) -> str:
    """Loads beside the one at rest that set a sticking joint in motion."""
    return "\n".join(
        f"{boundary.torque_margin:+.4g} N·m"
        for boundary in model.validity.boundaries
        if JOINT_MOTION.name in boundary.switches
    )


def _at(model: LinearModel) -> Boundary:
    """The boundary on which a model lies."""
    return next(
        boundary
        for boundary in model.validity.boundaries
        if boundary.deflection_margin == 0.0 and boundary.torque_margin == 0.0
    )


def _switching(boundary: Boundary) -> str:
    return ", ".join(mode_words(*switch) for switch in boundary.switches.items())


def _slides_at_rest(model: LinearModel) -> bool:
    sliding = model.validity.modes.get(JOINT_MOTION.name, 0) != 0
    return sliding and model.validity.operating_point.states["joint_velocity"] == 0.0


def _has_memory(model: LinearModel) -> bool:
    """Whether effects have states of their own."""
    return any("." in name for name in model.state_labels)


def _velocity_acts(model: LinearModel) -> bool:
    joined = model.drive is Drive.SOURCE and not is_joint_given(model)
    if not joined or MOTOR_VELOCITY not in model.input_labels:
        return False
    column = model.input_labels.index(MOTOR_VELOCITY)
    return bool(model.B[:, column].any() or model.D[:, column].any())


_PLACE: tuple[tuple[str, Callable[[LinearModel], str]], ...] = (
    ("deflection", _deflection),
    ("motor position", _input("motor_position", "rad")),
    ("joint velocity", _velocity),
    ("load torque", _input("load_torque", "N·m")),
    ("active there", _active),
    ("in force", _engaged),
    ("to the next boundary below", _next(-1)),
    ("to the next boundary above", _next(1)),
    ("added load to break away", _breakaway),
)


# ---- what a model says ---------------------------------------------------------------------


def _digits(value: float) -> str:
    return f"{value:.4g}"


def _or_nothing(value: float | None) -> str:
    return NOTHING if value is None else _digits(value)


def _words(name: str) -> str:
    return name.replace("_", " ")


def _roots(values: Sequence[complex]) -> str:
    """Roots, one in a line, complex pairs together."""
    return "\n".join(_root(value) for value in values) or "none"


def _root(value: complex) -> str:
    if not value.imag:
        return _digits(value.real)
    real = f"{_digits(value.real)} " if value.real else ""
    return f"{real}± {_digits(value.imag)}j"


def _of_pairs(tell: Callable[[Pole], str]) -> Callable[[Analysis], str]:
    def read(analysis: Analysis) -> str:
        return "\n".join(tell(pole) for pole in analysis.poles if pole.oscillates) or NOTHING

    return read


_NUMBERS: tuple[tuple[str, Callable[[Analysis], str]], ...] = (
    ("tendons' stiffness (N·m/rad)", lambda analysis: _or_nothing(analysis.tendon_stiffness)),
    ("tendons' damping (N·m·s/rad)", lambda analysis: _or_nothing(analysis.tendon_damping)),
    ("static stiffness (N·m/rad)", lambda analysis: _digits(analysis.stiffness)),
    ("natural frequency (rad/s)", _of_pairs(lambda pole: _digits(pole.natural_frequency))),
    ("natural frequency (Hz)", _of_pairs(lambda pole: _digits(pole.natural_frequency / (2 * pi)))),
    ("damping ratio", _of_pairs(lambda pole: _digits(pole.damping_ratio))),
    ("poles (rad/s)", lambda analysis: _roots([pole.value for pole in analysis.poles])),
)

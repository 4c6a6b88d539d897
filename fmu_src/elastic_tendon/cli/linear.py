"""The command of linear models: around each stiffness state, for the design of controllers."""

from collections.abc import Callable, Sequence
from functools import partial
from itertools import product
from pathlib import Path
from typing import Annotated

import typer

import elastic_tendon as et
from elastic_tendon.cli.shared import (
    EffectOption,
    ForceOption,
    InterfaceOption,
    JsonOption,
    PlotOption,
    app,
    check_outputs,
    load,
    load_effects,
    notice,
    output,
    progress_bar,
    reporting,
    save_json,
    save_picture,
)

STATES = ("III", "I", "II", "both")  # in this order the active one is looked for
WITHOUT_POINT = ("I", "II", "III")  # each where it is active
DRIVES = ("source", "position", "velocity", "torque")

SourceArgument = Annotated[
    str,
    typer.Argument(
        metavar="MODEL",
        help="A model.toml, the name of a bundled model, or an FMU that export wrote.",
    ),
]
StateOption = Annotated[
    list[str] | None,
    typer.Option(
        "--state",
        metavar="I|II|III|both",
        help="Slack state; repeatable. Default: I, II and III, each where it is active; with an "
        "operating point, the state that is active there.",
    ),
]
LoadOption = Annotated[
    float | None, typer.Option("--load", metavar="N·m", help="Load torque on the joint.")
]
MotorOption = Annotated[
    float | None,
    typer.Option("--motor-position", metavar="RAD", help="Angle of the motor pulley."),
]
JointOption = Annotated[
    float | None, typer.Option("--joint-position", metavar="RAD", help="Angle of the joint.")
]
DeflectionOption = Annotated[
    float | None,
    typer.Option("--deflection", metavar="RAD", help="Joint less motor, counted at the joint."),
]
VelocityOption = Annotated[
    float,
    typer.Option("--joint-velocity", metavar="RAD/S", help="Of steady motion, motor and joint."),
]
DriveOption = Annotated[
    str,
    typer.Option(
        "--drive",
        metavar="|".join(DRIVES),
        help="What moves the motor. source: position and velocity, inputs of their own as of the "
        "FMU; torque: a rotor, needs its section motor in model.toml.",
    ),
]
InputOption = Annotated[
    list[str] | None,
    typer.Option("--input", metavar="NAME", help="Input to keep; repeatable. Default: all."),
]
OutputOption = Annotated[
    list[str] | None,
    typer.Option("--output", metavar="NAME", help="Output to keep; repeatable. Default: all."),
]
ModeOption = Annotated[
    list[str] | None,
    typer.Option(
        "--mode",
        metavar="NAME=VALUE",
        help="Mode to hold, as joint_motion=0 for a joint that sticks; repeatable.",
    ),
]
MatOption = Annotated[
    Path | None, typer.Option("--mat", metavar="F", help="Write for MATLAB and Octave.")
]
DescribeOption = Annotated[
    Path | None,
    typer.Option(
        "--describe",
        metavar="F",
        help="Draw the equivalent stiffness over the amplitude of an oscillation.",
    ),
]


@app.command()
@reporting
def linearise(
    model: SourceArgument,
    state: StateOption = None,
    load_torque: LoadOption = None,
    motor_position: MotorOption = None,
    joint_position: JointOption = None,
    deflection: DeflectionOption = None,
    joint_velocity: VelocityOption = 0.0,
    drive: DriveOption = "source",
    inputs: InputOption = None,
    outputs: OutputOption = None,
    modes: ModeOption = None,
    json_file: JsonOption = None,
    mat_file: MatOption = None,
    plot: PlotOption = None,
    describe: DescribeOption = None,
    own_effects: EffectOption = None,
    interface: InterfaceOption = None,
    force: ForceOption = False,
) -> None:
    """Linear models around each slack state: poles, zeros, stiffness, and how far they hold.

    Two of --load, --motor-position, --joint-position and --deflection settle the operating point;
    of what is not given, the load is 0 first, then the motor's position.
    """
    for slack_state in state or ():
        _check("slack state", slack_state, STATES, "--state")
    _check("drive", drive, DRIVES, "--drive")
    held = dict(map(_mode, modes or ()))
    check_outputs(json_file, mat_file, describe, picture=plot, force=force, read=[model])
    check_outputs(picture=describe, force=force)
    asked = et.OperatingPoint(
        load_torque, motor_position, joint_position, deflection, joint_velocity
    )
    point = None if asked == et.OperatingPoint() else asked
    if model.endswith(".fmu"):
        if held or describe is not None:
            raise typer.BadParameter("--mode and --describe need a model.toml, not an FMU")
        load_effects(own_effects)
        name, linear = Path(model).stem, partial(et.linearise_fmu, model)
    else:
        loaded = load(model, own_effects, interface)
        name, linear = loaded.name, partial(et.linearise, loaded, modes=held)
    linear_in = partial(linear, operating_point=point, drive=et.Drive(drive))
    models = [_active(linear_in)] if point and not state else _every(linear_in, state)
    channels = _channels(models[0], inputs, outputs)
    _show(name, models, channels)
    if json_file is not None:
        from elastic_tendon.linear.linear_json import linear_json

        content = linear_json(name, models, inputs=inputs, outputs=outputs)
        save_json(content, json_file, force)
    if mat_file is not None:
        from elastic_tendon.linear.mat import write_mat
        from elastic_tendon.linear.selection import selected

        write_mat(
            name,
            [selected(linear_model, inputs, outputs) for linear_model in models],
            mat_file,
            force=force,
        )
    if plot is not None:
        from elastic_tendon.reports.linear_figures import linear_figure

        save_picture(linear_figure(name, models, channels[0] if channels else None), plot, force)
    if describe is not None:
        _describe(loaded, describe, force)


def _check(kind: str, value: str, allowed: Sequence[str], option: str) -> None:
    if value not in allowed:
        fault = f"there is no {kind} {value!r}; choose {', '.join(sorted(allowed))}"
        raise typer.BadParameter(fault, param_hint=option)


def _mode(text: str) -> tuple[str, int]:
    name, _, value = text.partition("=")
    try:
        return name, int(value)
    except ValueError:
        fault = f"{text!r} is no mode; give NAME=VALUE with a whole number, as joint_motion=0"
        raise typer.BadParameter(fault, param_hint="--mode") from None


def _active(linear_in: Callable[[str], "et.LinearModel"]) -> "et.LinearModel":
    """The linear model of the state that is active at the operating point."""
    faults: list[et.LinearisationError] = []
    for state in STATES:
        try:
            model = linear_in(state)
        except et.LinearisationError as fault:  # of an FMU, also that the state is not active
            faults.append(fault)
        else:
            at = [side.validity.slack_state for side in model.sides]
            if model.validity.slack_state in (at or [model.validity.operating_point.slack_state]):
                return model
    raise faults[0]


def _every(
    linear_in: Callable[[str], "et.LinearModel"], states: Sequence[str] | None
) -> list["et.LinearModel"]:
    """The linear models of states; of those not asked for by name, the ones that there are."""
    wanted = list(dict.fromkeys(states or WITHOUT_POINT))
    models: list[et.LinearModel] = []
    faults: list[et.LinearisationError] = []
    with progress_bar() as progress:
        for index, state in enumerate(wanted):
            progress(f"linearising in state {state}", index / len(wanted))
            try:
                models.append(linear_in(state))
            except et.LinearisationError as fault:
                faults.append(fault)
    if faults and (states or not models):
        raise faults[0]
    for refusal in faults:
        notice.print(f"note: {refusal}", markup=False, soft_wrap=True)
    return models


def _channels(
    model: "et.LinearModel", inputs: Sequence[str] | None, outputs: Sequence[str] | None
) -> list[tuple[str, str]] | None:
    """The channels that were asked for; None where none was."""
    from elastic_tendon.linear.selection import selected

    if not inputs and not outputs:
        return None
    wanted = selected(model, inputs, outputs)
    return list(product(wanted.input_labels, wanted.output_labels))


def _show(
    name: str, models: Sequence["et.LinearModel"], channels: Sequence[tuple[str, str]] | None
) -> None:
    from elastic_tendon.reports.linear_tables import linear_tables, remarks

    for table in linear_tables(name, models, channels):
        output.print(table)
    for sentence in remarks(models):
        output.print(sentence, highlight=False)


def _describe(model: "et.Model", picture: Path, force: bool) -> None:
    with progress_bar() as progress:
        function = et.describing_function(model, progress=progress)
    save_picture(function.plot(), picture, force)

"""Export the bundled models in every flavour and run them in importers that are not ours.

    python build_scripts/importers.py [MODEL...] [--effects] [-o PAGE.md]

One line for each model and flavour, one column for each importer: the largest difference from
`simulate`, in rad, of the joint position and of what a sensor reads where an effect acts on that,
of forces and torques the deflection that makes as much; or ok, for those that only read; or FAILED,
and why below. The last model has several effects (named below the table); `--effects` adds each
effect of the catalogue alone, at typical numbers. `-o` writes the table as a page of the site, with
the time that each importer takes for a communication step of 1 ms, versions, what failed, and what
each does not support:

    python build_scripts/importers.py --effects -o fmu_src/site/importers.md

The motion goes through slack at constant inputs, so co-simulation has nothing to interpolate;
CasADi knows no events and gets as far as the first. Exit status 1 if anything failed. An importer
that is not installed is skipped; the extra `test` brings all of them where they exist.
"""

import argparse
import ctypes
import importlib.util
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from functools import cache
from importlib.metadata import files, packages_distributions, version
from multiprocessing import get_context
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from elastic_tendon import effects
from elastic_tendon.actuator.design import design
from elastic_tendon.actuator.interfaces import InterfaceKind
from elastic_tendon.actuator.parameters import Model, load_model, models, typical_value
from elastic_tendon.actuator.variables import interface
from elastic_tendon.errors import ElasticTendonError
from elastic_tendon.fmu.export import export_fmu
from elastic_tendon.fmu.pythonfmu_flavour import export_pythonfmu
from elastic_tendon.simulation.simulate import Array, Trajectory, simulate

STEP = 1e-3  # s
DURATION = 1.0  # s
START = {"motor_position": 0.5, "joint_velocity": 1.0}  # rad, rad/s; far enough for slack
MOTOR_TORQUE = 1.0  # N m, where that is given and not the position; friction does not hold it
TOLERANCE = 1e-8  # that of `simulate` and of an FMU that is told none
FINER = 1e-2  # times that, where an importer errs much


@dataclass(frozen=True)
class Found:
    """Largest difference from `simulate`, rad; time of a step, s, where the importer steps."""

    apart: float
    step_time: float | None = None


Check = Callable[[Path, Model], Found | None]


class ImporterError(Exception):
    """An importer that refuses the FMU; the message is its own."""


def several_effects() -> Model:
    """Dry friction, a stop against overstretching, and weight."""
    model = load_model("biorob_x4_joint_3").with_effect("coulomb_friction", {"torque": 0.35})
    model = model.with_effect("overstretch_protection", {"engagement": 0.4, "stiffness": 2e4})
    return model.with_effect("gravity_load", {"torque": 1.5})


# ---- what each importer finds --------------------------------------------------------------


def start_of(model: Model) -> dict[str, float]:
    """Starts of constant inputs and of states."""
    return START | ({"motor_torque": MOTOR_TORQUE} if model.kind.has_rotor else {})


def expected(model: Model, time: Array, start: dict[str, float]) -> Trajectory:
    """What `simulate` gives at constant inputs."""
    inputs = interface(*model.structure).input_names
    held = {name: np.full(time.size, value) for name, value in start.items() if name in inputs}
    states = {name: value for name, value in start.items() if name not in inputs}
    return simulate(
        *(model, time, held.get("motor_position")),
        motor_torque=held.get("motor_torque"),
        initial_state=states,
        tolerance=TOLERANCE,
    )


def compared(model: Model) -> tuple[str, ...]:
    """Outputs that are compared: the joint position, and what sensors read that effects act on."""
    names = interface(*model.structure).output_names
    return ("joint_position", *(name for name in names if name.startswith("measured_")))


def _apart(model: Model, time: Array, found: Sequence[Array], start: dict[str, float]) -> float:
    """Largest difference of what is `compared` from `simulate`, rad.

    What holds before the first step, not all importers show.
    """
    wanted = expected(model, time, start)
    return max(
        float(np.abs(wanted[name] - values)[1:].max()) / _per_rad(model, name)
        for name, values in zip(compared(model), found, strict=True)
    )


def _per_rad(model: Model, output: str) -> float:
    """What a radian of deflection makes of a force or a torque; of a position it is itself."""
    if output.endswith("position"):
        return 1.0
    stiffness = design(model).stiffness_state_3
    radius = model.transmission.joint_pulley_radius
    return stiffness / radius if output.endswith("force") else stiffness


def with_typical(model: Model, effect_id: str) -> Model:
    """The model with an effect at numbers of a typical machine."""
    parameters = effects.BY_ID[effect_id].parameters
    return model.with_effect(effect_id, {one.name: typical_value(model, one) for one in parameters})


def fmpy_validation(path: Path, _model: Model) -> None:
    """Rules of both standards, by fmpy."""
    from fmpy.validation import validate_fmu

    if faults := validate_fmu(str(path)):
        raise ImporterError("; ".join(faults))


def toolbox_check(path: Path, _model: Model) -> None:
    """Schemas and rules of both standards, by fmu-manipulation-toolbox."""
    command = ("-m", "fmu_manipulation_toolbox.cli.fmutool", "-input", str(path), "-check")
    run = subprocess.run([sys.executable, *command], capture_output=True, text=True, check=False)
    if run.returncode != 0:
        faults = [line for line in run.stdout.splitlines() if line.startswith("ERROR")]
        raise ImporterError("; ".join(faults) or run.stderr)


def _fmpy(path: Path, model: Model, kind: str, **options: bool) -> Found:
    from fmpy import simulate_fmu

    start, steps, names = start_of(model), list[float](), compared(model)

    def stepped(_time: float, _recorder: object) -> bool:
        steps.append(perf_counter())
        return True

    run = simulate_fmu(
        str(path),
        fmi_type=kind,
        stop_time=DURATION,
        output_interval=STEP,
        relative_tolerance=TOLERANCE,
        start_values=start,
        output=list(names),
        step_finished=stepped,
        **options,
    )
    time, rows = np.unique(run["time"], return_index=True)  # at events there may be two
    step_time = (steps[-1] - steps[0]) / (len(steps) - 1)
    return Found(_apart(model, time, [run[name][rows] for name in names], start), step_time)


def fmpy_co_simulation(path: Path, model: Model) -> Found:
    """One instance."""
    return _fmpy(path, model, "CoSimulation")


def fmpy_event_mode(path: Path, model: Model) -> Found:
    """One instance whose steps end at events, which fmpy then handles."""
    return _fmpy(path, model, "CoSimulation", use_event_mode=True, early_return_allowed=True)


def fmpy_model_exchange(path: Path, model: Model) -> Found:
    """Integrated by CVode, which finds the events."""
    return _fmpy(path, model, "ModelExchange", record_events=False)


def casadi_model_exchange(path: Path, model: Model) -> Found:
    """Integrated by CasADi's CVODES with the FMU's derivatives, up to before the first event.

    Raises `ImporterError` where the Jacobian differs from differences.
    """
    import casadi as ca
    from fmpy import extract

    # it tells states before initialisation nothing of their starts: from rest, which sets the same
    # relations; backwards, as a velocity of 0 counts
    start = start_of(model) | {"motor_position": -0.02, "joint_velocity": 0.0}
    motion = expected(model, np.linspace(0.0, 0.2, 201), start)
    events = motion.event_times
    time = np.linspace(0.0, min([0.2, *0.9 * events[:1]]), 21)
    with tempfile.TemporaryDirectory() as folder:
        imported = ca.DaeBuilder("actuator", str(extract(str(path), folder)), {})
        for name, value in start.items():
            imported.set(name, value)
        rates = imported.create("rates", ["x", "u"], ["ode"])
        imported.set_y(list(compared(model)))  # it reads no enumeration
        shown = imported.create("shown", ["x", "u"], ["y"])
        names = {"x": imported.x(), "u": imported.u(), "y": imported.y()}
        x0 = np.array([motion[name][0] for name in names["x"]])  # some starts are calculated
        u0 = np.array([start.get(name, 0.0) for name in names["u"]])
        compare_jacobian(rates, x0, u0)
        x, u = ca.MX.sym("x", x0.size), ca.MX.sym("u", u0.size)
        problem = {"x": x, "p": u, "ode": rates(x, u)}
        options = {"abstol": 1e-11, "reltol": 1e-11}
        integrate = ca.integrator("integrate", "cvodes", problem, 0.0, list(time), options)
        outputs = np.array(shown(integrate(x0=x0, p=u0)["xf"], u0))
    found = [outputs[names["y"].index(name)] for name in compared(model)]
    return Found(_apart(model, time, found, start))


def compare_jacobian(rates: Any, x: Array, u: Array) -> None:
    """Raise `ImporterError` where the derivatives of rates by states differ from differences."""
    given = np.array(rates.jacobian()(x, u, 0)[0])
    step = 1e-5
    found = [
        (rates(x + step_along, u) - rates(x - step_along, u)) / (2 * step)
        for step_along in step * np.eye(x.size)
    ]
    apart = np.abs(np.hstack([np.array(column) for column in found]) - given).max()
    if not apart <= 1e-6 * np.abs(given).max():
        raise ImporterError(f"the Jacobian differs from differences by {apart:.1g}")


def load_tbb() -> None:
    """Load the library that Ecos is linked with and does not find by itself."""
    for file in files("tbb") or ():
        if file.name == "libtbb.so.12":
            ctypes.CDLL(str(file.locate()), mode=ctypes.RTLD_GLOBAL)


def ecos_co_simulation(path: Path, model: Model) -> Found:
    """Two instances in one system, thrown in opposite directions."""
    load_tbb()
    from ecospy import EcosSimulation, EcosSimulationStructure

    start, names = start_of(model), compared(model)
    starts = {"one": start, "other": start | {"joint_velocity": -start["joint_velocity"]}}
    values = {
        f"{instance}::{variable}": value
        for instance, start in starts.items()
        for variable, value in start.items()
    }
    shown = [f"{instance}::{name}" for instance in starts for name in names]
    rows = [(0.0, *np.zeros(len(shown)))]
    with EcosSimulationStructure() as structure:
        for instance in starts:
            structure.add_model(instance, str(path))
        structure.add_parameter_set("start", values)
        with EcosSimulation(STEP, structure=structure) as simulation:
            simulation.init(parameter_set="start")
            began = perf_counter()
            while simulation.get_time() < DURATION:
                simulation.step()
                rows.append((simulation.get_time(), *map(simulation.get_real, shown)))
            step_time = (perf_counter() - began) / (len(rows) - 1) / len(starts)
            simulation.terminate()
    time, *columns = np.array(rows).T
    shares = np.split(np.array(columns), len(starts))
    pairs = zip(shares, starts.values(), strict=True)
    return Found(max(_apart(model, time, [*found], start) for found, start in pairs), step_time)


def libcosim_co_simulation(path: Path, model: Model) -> Found:
    """One instance; the library keeps time in nanoseconds."""
    from fmpy import read_model_description
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    log_output_level(CosimLogLevel.FATAL)
    variables = read_model_description(str(path)).modelVariables
    reference = {variable.name: variable.valueReference for variable in variables}
    execution = CosimExecution.from_step_size(round(1e9 * STEP))
    slave = CosimLocalSlave(fmu_path=str(path), instance_name="actuator")
    index = execution.add_local_slave(slave)
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    start, names = start_of(model), compared(model)
    for name, value in start.items():
        execution.real_initial_value(index, reference[name], value)
    rows = [(0.0, *np.zeros(len(names)))]
    began = perf_counter()
    while rows[-1][0] < DURATION:
        if not execution.step():
            raise ImporterError(f"no step at {rows[-1][0]} s")
        values = observer.last_real_values(index, [reference[name] for name in names])
        rows.append((1e-9 * execution.status().current_time, *values))
    step_time = (perf_counter() - began) / (len(rows) - 1)
    time, *found = np.array(rows).T
    return Found(_apart(model, time, found, start), step_time)


def fmuloader_co_simulation(path: Path, model: Model) -> Found:
    """One instance, of which the loader knows what the description says only by who calls it."""
    from fmpy import read_model_description

    description = read_model_description(str(path))
    references = {one.name: one.valueReference for one in description.modelVariables}
    identifier = description.coSimulation.modelIdentifier
    if description.fmiVersion.startswith("2"):
        from fmuloader.fmi2 import Fmi2Slave, Fmi2Type

        slave = Fmi2Slave(path, model_identifier=identifier)
        slave.instantiate("actuator", Fmi2Type.CO_SIMULATION, guid=description.guid)
        slave.setup_experiment(tolerance=TOLERANCE)
        set_numbers, get_numbers, begin = slave.set_real, slave.get_real, {}
    else:
        from fmuloader.fmi3 import Fmi3Slave

        slave = Fmi3Slave(path, model_identifier=identifier)
        slave.instantiate_co_simulation("actuator", instantiation_token=description.guid)
        set_numbers, get_numbers, begin = (
            slave.set_float64,
            slave.get_float64,
            {"tolerance": TOLERANCE},
        )
    start, shown = start_of(model), [references[name] for name in compared(model)]
    set_numbers([references[name] for name in start], [*start.values()])
    slave.enter_initialization_mode(**begin)
    slave.exit_initialization_mode()
    rows = [(0.0, *np.zeros(len(shown)))]
    began = perf_counter()
    while rows[-1][0] < DURATION:
        slave.do_step(rows[-1][0], STEP)
        rows.append((rows[-1][0] + STEP, *get_numbers(shown)))
    step_time = (perf_counter() - began) / (len(rows) - 1)
    slave.terminate()
    slave.free_instance()
    time, *found = np.array(rows).T
    return Found(_apart(model, time, found, start), step_time)


# ---- importers and flavours ----------------------------------------------------------------

ABSENT = "absent"
EVERY = ("FMI 2", "FMI 3", "pythonfmu")
COMPILED = EVERY[:2]  # without a Python in the importer


@cache
def _distributions() -> Mapping[str, Sequence[str]]:
    """Of each package; looking through all that is installed takes a second."""
    return packages_distributions()


@dataclass(frozen=True)
class Importer:
    """An importer: the package that it needs, the flavours it can load, what is allowed in rad.

    `lacks`: what it does not support of what the FMUs offer.
    """

    name: str
    package: str
    check: Check
    flavours: tuple[str, ...] = EVERY
    allowed: float = 0.0
    lacks: str = ""

    @property
    def installed(self) -> bool:
        """Whether its package is there."""
        return importlib.util.find_spec(self.package) is not None

    @property
    def version(self) -> str:
        """Of its package."""
        distribution = _distributions()[self.package][0]
        return f"{distribution} {version(distribution)}"


# Where communication points are the same, co-simulation agrees to rounding: of times in nanoseconds
# and of what is multiplied by them. Points at events make other steps, which agree to the solver's
# tolerance. Model exchange has the error of the importer's own integrator.
IMPORTERS = (
    Importer("fmpy rules", "fmpy", fmpy_validation, lacks="terminals"),
    Importer(
        "toolbox",
        "fmu_manipulation_toolbox",
        toolbox_check,
        lacks="running an FMU; terminals beside an icon",
    ),
    Importer(
        *("fmpy CS", "fmpy", fmpy_co_simulation),
        allowed=1e-12,
        lacks="derivatives of inputs (it has room for exactly nine inputs)",
    ),
    Importer(
        *("fmpy events", "fmpy", fmpy_event_mode, ("FMI 3",)),
        allowed=1e-9,
        lacks="event mode in FMI 2.0, which has none",
    ),
    Importer(
        *("fmpy ME", "fmpy", fmpy_model_exchange, COMPILED),
        allowed=1e-6,
        lacks="inputs that move inside a step of its integrator: see `fmpy_inputs`",
    ),
    Importer(
        *("CasADi ME", "casadi", casadi_model_exchange, COMPILED),
        allowed=1e-8,
        lacks="events, so it is run up to the first; starts of states in initialisation, so it is "
        "run from rest; co-simulation",
    ),
    Importer(
        *("Ecos CS", "ecospy", ecos_co_simulation, COMPILED),
        allowed=1e-12,
        lacks="enumerations: read `slack_state_number`; model exchange; input derivatives",
    ),
    Importer(
        *("libcosim CS", "libcosimpy", libcosim_co_simulation, ("FMI 2",)),
        allowed=1e-12,
        lacks="FMI 3.0; enumerations: read `slack_state_number`; model exchange; input derivatives",
    ),
    Importer(
        *("fmuloader CS", "fmuloader", fmuloader_co_simulation, COMPILED),
        allowed=1e-12,
        lacks="reading a description, which is left to others; an integrator for model exchange",
    ),
)
# what was tried besides, and what stands against it
NOT_INSTALLED = (
    "OMSimulator (package OMSimulator 3.0.0): when it is installed it fetches its program from its "
    "makers' server, and where that cannot be reached there is none.",
    "PyFMI (package pyfmi 2.5, of 2018): it is built with FMI Library, which no package brings.",
    "FMI++ (package fmipp 2.1.0): it is built with SUNDIALS 3.1.2 of all versions.",
)


def export(model: Model, flavour: str, folder: Path) -> Path:
    """The FMU of a model in one of the flavours."""
    path = folder / f"{model.name}_{flavour.replace(' ', '_')}.fmu"
    if flavour == "pythonfmu":
        return export_pythonfmu(model, path)
    return export_fmu(model, path, fmi_version=3 if flavour == "FMI 3" else 2)


@dataclass(frozen=True)
class Outcome:
    """Cell of the table, and the reason where it failed."""

    cell: str
    failure: str = ""
    step_time: float | None = None  # s


def _begin(log: Path, tolerance: float) -> None:
    """Send what this process prints, in C too, into a file; all in it simulates as exactly."""
    global TOLERANCE
    TOLERANCE = tolerance
    with log.open("w") as file:
        for stream in (1, 2):
            os.dup2(file.fileno(), stream)


def _checked(
    importer: Importer, path: Path, model: Model, tolerance: float
) -> Found | Outcome | None:
    """Run an importer in a process of its own, so that none can harm another or this one."""
    log = path.with_suffix(".log")
    spawn = get_context("spawn")
    with ProcessPoolExecutor(1, spawn, initializer=_begin, initargs=(log, tolerance)) as process:
        try:
            return process.submit(importer.check, path, model).result()
        except BrokenProcessPool:
            last = log.read_text(errors="replace").strip().splitlines()[-1:]
            return Outcome("FAILED", " ".join(["the importer's process died;", *last]))
        except Exception as error:  # whatever an importer raises is its verdict
            return Outcome("FAILED", str(error) or type(error).__name__)


def outcome(importer: Importer, path: Path, model: Model) -> Outcome:
    """What an importer makes of an FMU; where it errs too much, what it errs with a smaller
    tolerance, which tells the error of its solver from one of the FMU."""
    found = _checked(importer, path, model, TOLERANCE)
    if isinstance(found, Outcome):
        return found
    if found is None:
        return Outcome("ok")
    if found.apart <= importer.allowed:
        return Outcome(f"{found.apart:.1g}", step_time=found.step_time)
    told = f"{found.apart:.2g} rad from simulate, {importer.allowed:g} allowed"
    closer = _checked(importer, path, model, FINER * TOLERANCE)
    if isinstance(closer, Found):
        told += f"; {closer.apart:.1g} where both have a tolerance of {FINER * TOLERANCE:g}"
    return Outcome("FAILED", told)


def outcomes(model: Model, flavour: str) -> Iterator[Outcome]:
    """Outcome of every importer for one model and flavour."""
    with tempfile.TemporaryDirectory() as folder:
        path = export(model, flavour, Path(folder))
        for importer in IMPORTERS:
            if flavour not in importer.flavours:
                yield Outcome("-")
            elif not importer.installed:
                yield Outcome(ABSENT)
            else:
                yield outcome(importer, path, model)


# ---- the table -----------------------------------------------------------------------------


INSTALL = f'{ABSENT}: not installed; pip install ".[test]" brings what there is for this platform'


def _line(first: str, cells: Sequence[str]) -> str:
    """Line of at most 120 characters for bundled models."""
    widths = [max(len(importer.name), len(ABSENT)) + 1 for importer in IMPORTERS]
    shown = (f"{cell:>{width}}" for cell, width in zip(cells, widths, strict=True))
    return f"{first:<29}" + "".join(shown)


def chosen(names: Sequence[str], *, each_effect: bool) -> list[tuple[str, Model]]:
    """Models by their titles; that of several effects, and of each effect, besides."""
    found = [(name, load_model(name)) for name in names]
    if each_effect:
        base = load_model("biorob_x4_joint_3")
        driven = base.at(InterfaceKind.TORQUE)  # for effects on a rotor
        found += [
            (one.id, with_typical(base if base.kind.has_slot(one.slot) else driven, one.id))
            for one in effects.CATALOGUE
        ]
    return [*found, ("several effects", several_effects())]


def page(rows: Sequence[tuple[str, Sequence[Outcome]]]) -> str:
    """The table as a page of the site."""
    listed = ", ".join(several_effects().effect_ids)
    heads = [importer.name for importer in IMPORTERS]
    lines = [
        "# Importers",
        "Every bundled model, each effect alone at typical numbers, and several at once, as FMUs "
        "in the importers that can be installed from the package index. A cell shows the largest "
        "difference from `simulate`, in rad, over a motion through slack at constant inputs: of "
        "the joint position, and of what a sensor reads where an effect acts on that, of forces "
        "and torques the deflection that makes as much; and the time that the importer takes for "
        "a step of 1 ms; ok where it only reads; – where it does not know the kind of FMU. Effects "
        "on a rotor are driven by a torque. Made by `build_scripts/importers.py`.",
        "\n".join(
            f"| {' | '.join(cells)} |"
            for cells in (
                ["FMU", *heads],
                ["---"] * (len(heads) + 1),
                *([title, *map(_cell, outcomes)] for title, outcomes in rows),
            )
        ),
        f"Several effects: {listed}.",
        *_failed(rows),
        "## Versions, and what each does not support",
        "\n".join(f"* {one.name} ({one.version}): {one.lacks}." for one in IMPORTERS),
        "## What could not be installed",
        "Tried from the package index, on Linux:",
        "\n".join(f"* {one}" for one in NOT_INSTALLED),
        "Packages that run FMUs through one of these importers have no column of their own.",
    ]
    return "\n\n".join(lines) + "\n"


def _failed(rows: Sequence[tuple[str, Sequence[Outcome]]]) -> Iterator[str]:
    if listed := _failures(rows):
        yield "## What failed"
        yield "\n".join(f"* {failure}." for failure in listed)


def _failures(rows: Sequence[tuple[str, Sequence[Outcome]]]) -> list[str]:
    return [
        f"{title}, {importer.name}: {result.failure}"
        for title, found in rows
        for importer, result in zip(IMPORTERS, found, strict=True)
        if result.failure
    ]


def _cell(outcome: Outcome) -> str:
    if outcome.step_time is None:
        return "–" if outcome.cell == "-" else outcome.cell
    return f"{outcome.cell}; {1e6 * outcome.step_time:.0f} µs"


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit status: 0 all is well, 1 something failed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("model", nargs="*", metavar="MODEL", help="default: all bundled models")
    parser.add_argument("--effects", action="store_true", help="each effect alone, too")
    parser.add_argument("-o", "--output", type=Path, metavar="PAGE.md", help="page to write")
    given = parser.parse_args(arguments)
    try:
        wanted = chosen(given.model or list(models), each_effect=given.effects)
    except ElasticTendonError as error:
        print(error, file=sys.stderr)
        return 1
    rows = []
    print(_line("difference from simulate, rad", [importer.name for importer in IMPORTERS]))
    for title, model in wanted:
        for flavour in COMPILED if title in effects.BY_ID else EVERY:
            found = list(outcomes(model, flavour))
            rows.append((f"{title}, {flavour}", found))
            print(_line(f"{title}, {flavour}", [result.cell for result in found]), flush=True)
    if given.output:
        given.output.write_text(page(rows))
    listed = ", ".join(several_effects().effect_ids)
    print(f"\n-: not for this flavour; 0: to the last bit; several effects: {listed}")
    if not all(importer.installed for importer in IMPORTERS):
        print(INSTALL)
    failures = _failures(rows)
    print("", *failures, sep="\n")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())

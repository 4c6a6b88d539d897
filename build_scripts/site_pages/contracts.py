"""What files hold: models, measurements, FMUs, JSON; from schemas and docstrings of the code."""

import ast
import inspect
import json
from collections.abc import Iterable
from dataclasses import is_dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from pydantic import BaseModel

import elastic_tendon as et
from elastic_tendon.actuator import sections
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.quantity import declared_in, unit_text
from elastic_tendon.actuator.variables import interface
from elastic_tendon.comparison import bins, compare, missing_torque
from elastic_tendon.comparison.comparison_json import comparison_json
from elastic_tendon.diagnosis import result
from elastic_tendon.diagnosis.diagnosis_json import diagnosis_json
from elastic_tendon.estimation import determinability, ladder
from elastic_tendon.fmu.documentation import documentation
from elastic_tendon.measurement import formats, noise, preparation
from elastic_tendon.measurement.columns import find_layout
from elastic_tendon.measurement.units import LINEAR, USUAL
from elastic_tendon.native.layout import default_layout
from elastic_tendon.result import Result
from site_pages import Pages
from site_pages.markdown import code, from_docstrings, from_rst, plain, table

EXAMPLE = et.load_model("biorob_x4_joint_3")
SCHEMAS: dict[str, type[BaseModel]] = {"model": Model, "preparation": preparation.Preparation}
LONGEST = 2  # entries of a list, of an example that is shown


def pages(folder: Path) -> Pages:
    """A page for each kind of file, and one of all; JSON schemas go to the folder ``contracts``."""
    (folder / "contracts").mkdir()
    for name, schema in SCHEMAS.items():
        text = json.dumps(schema.model_json_schema(), indent=2)
        (folder / "contracts" / f"{name}.schema.json").write_text(text)
    made = {"model": _model(), "measurements": _measurements(), "fmu": _fmu(), **_results()}
    for name, page in made.items():
        yield f"contracts/{name}.md", page
    yield "contracts/index.md", "# Data contracts\n\n" + code("\n".join(made), "{toctree}")


def _model() -> str:
    rows = (
        (
            *(f"`{quantity.path}`", unit_text(quantity.unit), plain(quantity.meaning)),
            *(f"{quantity.lower:g} to {quantity.upper:g}", f"{quantity.uncertainty:g}"),
        )
        for quantity in declared_in(Model)
    )
    heading = ("key", "unit", "meaning", "bounds", "uncertainty")
    parts = [
        "# model.toml",
        from_rst(inspect.getdoc(sections) or ""),
        "As a [JSON schema](model.schema.json). `[effects]` holds a table for each "
        "[effect](../effects/index.md). `uncertainty` is one sigma, relative to the value, where "
        "`[uncertainty]` says no other.",
        table(heading, rows),
        "A bundled model:",
        code(EXAMPLE.to_toml(), "toml"),
    ]
    return "\n\n".join(parts)


def _measurements() -> str:
    signals = [
        (f"`{name}`", kind, _columns(name, kind), _columns(name, LINEAR.get(kind, kind)))
        for name, kind in preparation.DIMENSIONS.items()
    ]
    heads = ("signal", "kind", "columns that are found by their name", "of a machine that slides")
    parts = [
        "# Measurements",
        table(heads, signals),
        from_rst((inspect.getdoc(find_layout) or "").partition("\n\nParameters")[0]),
        "## Kinds of files",
        *_formats(),
        "## How a file is read",
        from_rst(inspect.getdoc(preparation) or ""),
        "As a [JSON schema](preparation.schema.json).",
        _classes(preparation),
    ]
    return "\n\n".join(parts)


def _columns(signal: str, kind: str) -> str:
    return ", ".join(f"`{signal}_{unit}`" for unit in USUAL[kind])


def _formats() -> Iterable[str]:
    """What each module that opens a file says first."""
    for path in sorted(Path(formats.__file__).parent.glob("*.py")):
        tree = ast.parse(path.read_text())
        if any(getattr(node, "name", "") == "open_file" for node in tree.body):
            yield "* " + from_rst((ast.get_docstring(tree) or "").partition("\n\n")[0])


def _fmu() -> str:
    variables = default_layout(interface(()))
    rows = (
        (f"`{variable.name}`", unit_text(variable.variable.unit), plain(variable.variable.meaning))
        for variable in variables
    )
    return "# FMU\n\n" + table(("variable", "unit", "meaning"), rows)


def equations() -> Pages:
    """The model without effects: the equations as they stand in the documentation of its FMU."""
    variables = default_layout(interface(()))
    page = documentation(EXAMPLE, variables, 3)["documentation/index.html"].decode()
    start, end = '<h2 id="equations">Equations</h2>', '<h2 id="effects">'
    shown = page.partition(start)[2].partition(end)[0]
    paper = page.partition('<h2 id="sources">')[2].partition("<li>")[2].partition("</li>")[0]
    shown = shown.replace('href="#effects"', 'href="effects/index.html"')
    yield (
        "equations.md",
        f'# Equations\n\n````{{raw}} html\n{shown}<p id="sources">{paper}</p>\n````\n',
    )


def _results() -> dict[str, str]:
    """The JSON of a comparison and of a diagnosis, each with one that is made here."""
    recording = _recording()
    options = et.Options(only=("coulomb_friction",))
    modules = (compare, bins, missing_torque), (result, determinability, ladder, noise)
    return {
        "comparison": _result(comparison_json, et.compare(EXAMPLE, recording), modules[0]),
        "diagnosis": _result(
            diagnosis_json, et.diagnose(EXAMPLE, recording, options=options), modules[1]
        ),
    }


def _result(function: Any, made: Result, modules: Iterable[ModuleType]) -> str:
    example = json.dumps(_shortened(made.to_dict()), indent=2, ensure_ascii=False)
    name = function.__module__.rpartition(".")[2].removesuffix("_json")
    return "\n\n".join(
        [
            f"# {name.capitalize()} as JSON",
            from_rst(inspect.getdoc(inspect.getmodule(function)) or ""),
            f"An example, of which lists are cut to {LONGEST} entries:",
            code(example, "json"),
            "## What its keys mean",
            *(_classes(module) for module in modules),
        ]
    )


def _recording() -> et.Measurement:
    """Of a machine with friction: short, so that it is soon diagnosed."""
    time = np.linspace(0.0, 2.0, 401)
    motor, load = 0.4 * np.sin(8.0 * time), 7.0 * np.sin(2.0 * time)
    machine = EXAMPLE.with_effect("coulomb_friction", {"torque": 0.3})
    noise = 1e-4 * np.random.default_rng(1).standard_normal(time.size)
    position = et.simulate(machine, time, motor, load)["joint_position"] + noise
    return et.Measurement(
        time=time, motor_position=motor, signals={"joint_position": position}, load_torque=load
    )


def _shortened(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _shortened(item) for key, item in value.items()}
    return [_shortened(item) for item in value[:LONGEST]] if isinstance(value, list) else value


def _classes(module: ModuleType) -> str:
    """All classes of data that a module declares and that are not public by themselves."""
    names = [
        name
        for name, thing in vars(module).items()
        if inspect.isclass(thing) and thing.__module__ == module.__name__
        if (is_dataclass(thing) or hasattr(thing, "model_fields"))
        if name not in dir(et) and not name.startswith("_")
    ]
    return from_docstrings((f".. autoclass:: {name}" for name in names), module.__name__)

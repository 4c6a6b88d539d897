"""Every cell of interface x capability: each does what it says, or refuses in one sentence.

What the cells compute is held against the truth elsewhere (`actuator/test_interfaces`,
`fmu/test_interfaces_fmu`, `diagnosis/test_interfaces_diagnosed`); here none is left out: an
interface that is added to `InterfaceKind` has all of these cells at once.
"""

import re
import zipfile
from dataclasses import replace
from functools import cache

import control
import fmpy
import numpy as np
import pandas as pd
import pytest

import elastic_tendon as et
from elastic_tendon.actuator.interfaces import InterfaceKind
from elastic_tendon.actuator.variables import moved_states
from elastic_tendon.app import results, takeaway, walk
from elastic_tendon.app.document import Source, new_document
from elastic_tendon.app.workspace import Cache, Workspace
from elastic_tendon.evidence.experiment import result_names
from elastic_tendon.evidence.gather import PARAMETERS
from elastic_tendon.evidence.manifest import FOLDER
from elastic_tendon.evidence.seal import SEAL, add_seal
from elastic_tendon.fmu.packing import write_archive
from elastic_tendon.native.compiler import host_platform
from elastic_tendon.progress import silent
from elastic_tendon.simulation.simulate import given_names
from elastic_tendon.sweeps.bootstrap import bootstrap
from elastic_tendon.sweeps.simulations import measured_motion

TIME = np.arange(0.0, 3.0, 4e-3)
NOISE = {"joint_position": 1e-4, "motor_position": 1e-4, "joint_torque": 0.02}
TREE = {
    "name": "machine",
    "transmission": {
        "joint_pulley_radius": 0.03,
        "motor_pulley_radius": 0.02,
        "pretension_force": 60.0,
        "upper_spring": {"stiffness": 9000.0, "max_deflection": 0.02, "damping": 5.0},
        "lower_spring": {"stiffness": 9000.0, "max_deflection": 0.02, "damping": 5.0},
    },
    "link": {"inertia": 0.03, "damping": 0.1},
    "motor": {"inertia": 0.004, "damping": 0.03},
}
LOAD = 1.2 * np.sin(2.3 * TIME) + 0.6 * np.sin(5.9 * TIME)
HIDDEN = {  # an effect that has a place at the interface
    InterfaceKind.LOAD: ("coulomb_friction", {"torque": 0.2}),
    None: ("pulley_eccentricity", {"amplitude": 0.05, "phase": 0.7}),
}


def machine(kind):
    if not kind.has_springs:
        return et.load_model({"name": "axis", "link": TREE["link"]})
    return et.load_model(TREE).at(kind)


def true_machine(kind):
    """The machine that is recorded: a tenth off."""
    model = machine(kind)
    off = {"link.inertia": 0.033}
    off |= {f"transmission.{side}_spring.stiffness": 8100.0 for side in ("upper", "lower")}
    return model.with_values({path: off[path] for path in off if path in model.values()})


def hidden_at(kind):
    return HIDDEN.get(kind, HIDDEN[None])


@cache
def recording(kind, *, with_effect):
    """Of the true machine, in which an effect may hide; with all that its interface needs."""
    driven = InterfaceKind.TORQUE if kind.has_springs else kind
    true = true_machine(driven)
    if with_effect:
        true = true.with_effect(*hidden_at(kind))
    given = {"load_torque": LOAD}
    if kind.has_springs:
        given["motor_torque"] = 0.8 * np.sin(4.1 * TIME) + 0.6 * np.sin(7.7 * TIME)
    moved = et.simulate(true, TIME, interpolation="cubic", **given)
    random = np.random.default_rng(7)
    signals = {
        name: moved[name] + sigma * random.standard_normal(len(TIME))
        for name, sigma in NOISE.items()
        if name in moved.output_names
    }
    motor = signals.pop("motor_position", None)
    if kind.has_rotor:  # elsewhere a motor torque is that of the tendons alone
        signals["motor_torque"] = given["motor_torque"]
    known = {name: NOISE[name] for name in signals if name in NOISE}
    return et.Measurement(
        TIME, motor, signals, LOAD, interpolation="cubic", given_noise=known, name="machine"
    )


# ---- capabilities --------------------------------------------------------------------------------


def simulates(kind, _folder):
    """The machine as it is moves as recorded, and the model as given does not."""
    shown = recording(kind, with_effect=False)
    found, given = (
        et.compare(model, shown).noise_ratio().values()
        for model in (true_machine(kind), machine(kind))
    )
    assert max(found) < 3.0  # noise of measured inputs moves it too
    assert max(given) > 3.0 * max(found)


def exports(kind, folder, fmi_type, version):
    """An FMU moves as the model is simulated; without dampers, as held inputs have no velocity."""
    model = machine(kind)
    dampings = (f"transmission.{side}_spring.damping" for side in ("upper", "lower"))
    model = model.with_values({path: 0.0 for path in dampings if path in model.values()})
    path = et.export_fmu(model, folder / "x.fmu", fmi_version=version)
    taken = replace(recording(kind, with_effect=False).for_model(model), interpolation="hold")
    given = {name: taken.inputs[name] for name in given_names(model)}
    expected = et.simulate(model, TIME, interpolation="hold", **given)
    names = [*moved_states(kind)[::2]] or ["joint_torque"]
    found = fmpy.simulate_fmu(
        str(path), fmi_type=fmi_type, input=et.fmpy_inputs(taken), output=names,
        output_interval=4e-3, stop_time=0.5, relative_tolerance=1e-9,
    )  # fmt: skip
    at = np.searchsorted(found["time"], TIME[:100] - 1e-6)[1:]
    for name in names:
        # inputs change after the row of a sample, and the torque of a given joint with them
        wanted = expected[name][:99] if name == "joint_torque" else expected[name][1:100]
        np.testing.assert_allclose(found[name][at], wanted, rtol=0, atol=1e-5 * np.ptp(wanted))


def linearises(kind, _folder):
    """A small motion is that of the linear model."""
    model = machine(kind)
    linear = et.linearise(model, "III")
    small = {name: 1e-3 * np.sin(9.0 * TIME) for name in given_names(model)}
    expected = et.simulate(model, TIME, interpolation="cubic", **small)
    rates = {name: np.gradient(values, TIME, edge_order=2) for name, values in small.items()}
    of_inputs = [
        small[name] if name in small else rates[name.replace("velocity", "position")]
        for name in linear.input_labels
    ]
    found = control.forced_response(linear, TIME, np.array(of_inputs)).outputs
    row = linear.output_labels.index("joint_torque")
    wanted = expected["joint_torque"]
    assert np.abs(np.atleast_2d(found)[row] - wanted).max() < 2e-3 * np.ptp(wanted)
    assert linear.to_dict()["models"][0]["analysis"]
    assert linear.plot().axes


def fits(kind, _folder):
    found = et.fit(machine(kind), recording(kind, with_effect=False)).model.values()
    if kind.has_link:
        assert found["link.inertia"] == pytest.approx(0.033, rel=0.02)
    if kind.has_springs:
        both = sum(found[f"transmission.{side}_spring.stiffness"] for side in ("upper", "lower"))
        assert both == pytest.approx(2 * 8100.0, rel=0.02)


def diagnoses(kind, folder):
    effect_id, numbers = hidden_at(kind)
    options = et.Options(only=(effect_id,))
    found = et.diagnose(machine(kind), recording(kind, with_effect=True), options=options)
    assert found.added == (effect_id,)
    (name, *_) = numbers
    assert found.model.effects[effect_id][name] == pytest.approx(numbers[name], rel=0.05)
    et.report(found, folder / "x.html")


def sweeps(kind, _folder):
    model = machine(kind)
    shown = recording(kind, with_effect=False)
    spread = (
        {"transmission.pretension_force": "50:60"}
        if kind.has_springs
        else {"link.damping": "0.1:0.2"}
    )
    points = et.vary(model, spread, runs=3)
    for motion in (None, measured_motion(model, shown)):
        table = et.simulations(model, points, motion=motion).rows(0, 3)
        assert not any(table["failure"])
    assert [name for name in table if "rms_error" in name]


def bootstraps(kind, _folder):
    path = "transmission.upper_spring.stiffness" if kind.has_springs else "link.inertia"
    shown = [recording(kind, with_effect=False).for_model(machine(kind))]
    task = bootstrap(machine(kind), shown, runs=2, seed=0, free=[path])
    table = task.rows(0, 2)
    assert not any(table["failure"])
    assert table[path].nunique() == 2


def written(shown, folder):
    """The recording as a file."""
    units = {"position": "rad", "torque": "Nm"}
    columns = {**shown.inputs, **shown.signals}
    table = {f"{name}_{units[name.rpartition('_')[2]]}": columns[name] for name in columns}
    pd.DataFrame({"time_s": TIME, **table}).to_csv(folder / "robot.csv", index=False)
    return folder / "robot.csv"


def diagnoses_fleets(kind, folder):
    written(recording(kind, with_effect=False), folder)
    row = et.fleet(machine(kind), [folder / "robot.csv"]).rows(0, 1).iloc[0]
    assert not row["failure"]
    assert row["appeared"] == ""
    assert [name for name in row.index if "_noise_ratio_after" in name and row[name] < 1.5]


def proves(kind, folder):
    """Its FMU reproduces the evidence that it carries, and not one that was changed."""
    model = machine(kind)
    straight = replace(recording(kind, with_effect=False), interpolation="linear")
    evidence = et.gather_evidence(model, straight)
    slides = et.load_model({**model.model_dump(exclude_none=True), "motion": "linear"})
    of_sliding = et.gather_evidence(slides, straight)
    assert of_sliding.report["motion"] == "linear"
    assert of_sliding.report["recordings"] == evidence.report["recordings"]
    assert b'unit="N.m' not in of_sliding.files[PARAMETERS]
    path = et.export_fmu(model, folder / "x.fmu", evidence=evidence, outside_validity=True)
    found = et.verify(path, inputs=straight)
    assert found.faults == ()
    assert found.ranges.keys() >= {*given_names(model), *moved_states(kind)}
    assert tuple(found.differences) == result_names(kind)
    (errors,) = found.errors.values()
    assert errors.keys() == evidence.comparison.files[0].signals.keys()
    for stated, replayed in errors.values():
        assert replayed == pytest.approx(stated, rel=1e-9)
    name = f"{FOLDER}smoke_test_results.csv"
    changed = re.sub(rb"\n0\.5,[^,\n]+", b"\n0.5,1e6", evidence.files[name])
    with zipfile.ZipFile(path) as archive:
        files = {one: archive.read(one) for one in archive.namelist() if one != SEAL}
    write_archive(path, files | {name: changed})
    add_seal(path, None)
    (fault,) = et.verify(path).faults
    assert fault.startswith(f"smoke_test: {result_names(kind)[0]} is 1e+06 ")


def shows_in_the_app(kind, folder):
    """Its steps: add data, compare, diagnose, the result and all that can be taken away."""
    files = {"data": written(recording(kind, with_effect=True), folder)}
    document = new_document(machine(kind), [Source(key="data", name="robot.csv")])
    workspace, cache = Workspace(document, files), Cache()
    depot = takeaway.Depot(workspace)
    compared = cache.obtain(results.compared(document, document.version, files), silent)
    assert max(compared.fitted.noise_ratio().values()) > 2.0
    assert cache.obtain(results.located(document, document.version, files), silent).files
    ranked = cache.obtain(walk.ranked(document, document.version, files), silent)
    assert ranked.round.chosen == (hidden_at(kind)[0],)
    here = takeaway.FmuChoice(platforms=(host_platform().name,))
    made = {
        "fmu": takeaway.fmu(document, here, depot),
        "model": takeaway.model_file(document, files, depot),
        "report": takeaway.report_page(document, files, depot),
        "findings": takeaway.findings(document, files, depot),
        "data": takeaway.data(document, files, depot),
    }
    if kind.has_springs:
        made["linear"] = takeaway.linear(document, depot)
    built = {name: result.compute(cache, silent) for name, result in made.items()}
    assert fmpy.read_model_description(str(built["fmu"].path)).modelName
    with zipfile.ZipFile(built["data"].path) as archive:
        (table,) = (name for name in archive.namelist() if name.startswith("recordings/"))
        (folder / "again.csv").write_bytes(archive.read(table))
    again = et.read(folder / "again.csv").for_model(machine(kind))
    (file,) = compared.fitted.files
    assert again.inputs.keys() == file.measurement.inputs.keys()
    assert again.signals.keys() == file.measurement.signals.keys()
    workspace.close()


CAPABILITIES = {
    "simulate": simulates,
    **{
        f"FMU {short} of FMI {version}.0": (
            lambda kind, folder, long=long, version=version: exports(kind, folder, long, version)
        )
        for short, long in (("CS", "CoSimulation"), ("ME", "ModelExchange"))
        for version in (2, 3)
    },
    "linearise": linearises,
    "fit": fits,
    "diagnose": diagnoses,
    "sweep": sweeps,
    "bootstrap": bootstraps,
    "fleet": diagnoses_fleets,
    "evidence": proves,
    "app": shows_in_the_app,
}
REFUSED = {
    (InterfaceKind.LOAD, "linearise"): "a linear model needs springs",
}


@pytest.mark.usefixtures("made_soon")
@pytest.mark.parametrize("capability", CAPABILITIES)
@pytest.mark.parametrize("kind", InterfaceKind)
def test_cell(kind, capability, tmp_path):
    if refusal := REFUSED.get((kind, capability)):
        with pytest.raises(et.ModelError, match=refusal) as refused:
            CAPABILITIES[capability](kind, tmp_path)
        assert len(str(refused.value).splitlines()) == 1
    else:
        CAPABILITIES[capability](kind, tmp_path)

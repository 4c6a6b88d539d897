"""Importers that stop at anything but OK take every effect, bundled model and interface."""

import pytest
from fmu_cases import motion, with_typical

from effects_at import placed
from elastic_tendon.actuator.interfaces import WITH_SPRINGS, InterfaceKind
from elastic_tendon.actuator.parameters import load_model, models
from elastic_tendon.effects import CATALOGUE
from elastic_tendon.fmu.export import export_fmu
from fmu_driver import Fmu, run_co_simulation, run_model_exchange

TOLERANCE = 1e-6
BASE = load_model("biorob_x4_joint_3")
MODELS = {
    **{name: load_model(name) for name in models},
    **{effect.id: with_typical(placed(BASE, effect), effect.id) for effect in CATALOGUE},
    **{kind: BASE.at(kind) for kind in WITH_SPRINGS if kind is not InterfaceKind.POSITION},
}


# in CI each model in one version of FMI, in turn: what it computes is the same C in both
CASES = [
    pytest.param(version, name, marks=[] if (i + version) % 2 else [pytest.mark.slow])
    for i, name in enumerate(MODELS)
    for version in (2, 3)
]


@pytest.mark.parametrize(("version", "name"), CASES, indirect=["version"])
@pytest.mark.usefixtures("made_soon")
def test_every_call_returns_ok(name, version, instances, tmp_path):
    """Spring damping and rates without the motor's velocity, springs stretched too far."""
    model = MODELS[name]
    fmu = Fmu(export_fmu(model, tmp_path / "x.fmu", fmi_version=version), tmp_path / "unpacked")
    driven = "motor_torque" if model.kind.has_rotor else "motor_position"
    for make, run in ((fmu.slave, run_co_simulation), (fmu.model, run_model_exchange)):
        instance = instances(make())
        calls = []
        instance.fmu.fmiCallLogger = calls.append
        segments = motion(False, n=51, amplitude=0.6)
        run(instance, segments, tolerance=TOLERANCE, connected=False, driven=driven)
        assert len(calls) > 150
        assert [call for call in calls if not call.endswith("-> OK")] == []

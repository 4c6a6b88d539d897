"""Importers that stop at anything but OK, as some do, take every effect and every bundled model."""

import pytest
from fmu_cases import BOTH, motion, with_typical

from effects_at import IDS_AT_POSITION
from elastic_tendon.actuator.parameters import load_model, models
from elastic_tendon.fmu.export import export_fmu
from fmu_driver import Fmu, run_co_simulation, run_model_exchange

TOLERANCE = 1e-6
MODELS = {name: load_model(name) for name in models} | {
    effect_id: with_typical(load_model("biorob_x4_joint_3"), effect_id)
    for effect_id in IDS_AT_POSITION
}


@pytest.mark.parametrize("name", MODELS)
@BOTH
@pytest.mark.usefixtures("made_soon")
def test_every_call_returns_ok(name, version, instances, tmp_path):
    """Spring damping and rates without the motor's velocity, springs stretched too far."""
    path = export_fmu(MODELS[name], tmp_path / "x.fmu", fmi_version=version)
    fmu = Fmu(path, tmp_path / "unpacked")
    for make, run in ((fmu.slave, run_co_simulation), (fmu.model, run_model_exchange)):
        instance = instances(make())
        calls = []
        instance.fmu.fmiCallLogger = calls.append
        run(instance, motion(False, n=51, amplitude=0.6), tolerance=TOLERANCE, connected=False)
        assert len(calls) > 150
        assert [call for call in calls if not call.endswith("-> OK")] == []

"""Recordings of two machines are told from recordings of one whose law is wrong."""

import numpy as np
import pytest

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.diagnosis.answer import refit
from elastic_tendon.diagnosis.contradictions import contradictions
from elastic_tendon.diagnosis.diagnose import diagnose
from elastic_tendon.diagnosis.options import Options
from elastic_tendon.estimation.fit import QUICK
from elastic_tendon.measurement import Measurement
from elastic_tendon.simulation.simulate import simulate
from smooth_motion import GIVEN, typical_model

NOISE = 2e-4  # rad
GRAVITY = "gravity_load"
SLIGHTLY = 1.03
HEAVIER = GIVEN.with_values({"link.inertia": 1.6 * GIVEN.link.inertia})


def recorded(model: Model, name: str, frequency: float) -> Measurement:
    time = np.arange(0.0, 4.0, 0.002)
    turns = 2 * np.pi * frequency * time
    motor = 0.3 * np.minimum(time, 1.0) * np.sin(turns)
    load = 0.5 * np.minimum(time, 1.0) * np.sin(1.7 * turns)
    run = simulate(model, time, motor, load, interpolation="cubic", as_measured=True)
    noise = NOISE * np.random.default_rng(len(name)).standard_normal(len(time))
    shown = run[run.measured("joint_position")] + noise
    return Measurement(
        time, motor, {"joint_position": shown}, load, interpolation="cubic", name=name
    )


def told(*recordings: Measurement):
    return contradictions(GIVEN, refit(GIVEN, (), recordings, effort=QUICK), recordings)


def test_the_recording_of_another_machine_contradicts_the_others():
    found = told(
        recorded(GIVEN, "monday", 1.1),
        recorded(GIVEN, "tuesday", 1.4),
        recorded(HEAVIER, "with a tool", 1.2),
    )
    assert found["with a tool"] == ("monday", "tuesday")
    assert found["monday"] == found["tuesday"] == ("with a tool",)


def test_it_can_be_stopped_between_recordings():
    recordings = recorded(GIVEN, "monday", 1.1), recorded(HEAVIER, "tuesday", 1.4)
    answer = refit(GIVEN, (), recordings, effort=QUICK)
    shares = []

    def report(_text: str, share: float) -> None:
        shares.append(share)
        if share >= 0.5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        contradictions(GIVEN, answer, recordings, report)
    assert shares == [0.0, 0.25, 0.5]


def test_recordings_of_one_machine_agree():
    found = told(recorded(HEAVIER, "monday", 1.1), recorded(HEAVIER, "tuesday", 1.4))
    assert found == {"monday": (), "tuesday": ()}


def test_a_missing_effect_is_no_contradiction():
    machine = typical_model("coulomb_friction")
    found = told(recorded(machine, "monday", 1.1), recorded(machine, "tuesday", 1.4))
    assert found == {"monday": (), "tuesday": ()}


def test_recordings_that_contradict_one_another_are_named_where_no_effect_came_in():
    # what is left over all of them depends on the motion by no more than chance
    lighter, heavier = (
        GIVEN.with_values({"link.inertia": factor * GIVEN.link.inertia})
        for factor in (1.0 / SLIGHTLY, SLIGHTLY)
    )
    machines = ((lighter, "monday", 1.1), (GIVEN, "tuesday", 1.4), (heavier, "friday", 1.2))
    found = diagnose(GIVEN, [recorded(*one) for one in machines], options=Options(only=(GRAVITY,)))
    assert found.added == ()
    assert not found.remaining["joint_position"].significant
    assert found.verdict == "unexplained"
    assert found.sentence.endswith(
        "times the noise is left; monday contradicts friday: no parameters suit them together."
    )
    assert {part.file: part.contradicts for part in found.recordings} == {
        "monday": ("friday",),
        "tuesday": (),
        "friday": ("monday",),
    }

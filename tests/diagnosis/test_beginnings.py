"""What a fit hides in initial states, on axes of an independent simulator that nearly integrate."""

from dataclasses import replace

import numpy as np
import pytest

import elastic_tendon as et
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.comparison.compare import compare
from elastic_tendon.diagnosis.beginnings import beginning_notes
from truth.axis import CONSTANT, DRY, MASS, VISCOUS, recorded

LINK = {"inertia": MASS, "damping": VISCOUS}
ROUGH = {"name": "axis", "motion": "linear", "link": LINK}
TRUE = et.load_model(ROUGH).with_effect("coulomb_friction", {"torque": DRY})
TRUE = TRUE.with_effect("constant_torque", {"torque": -CONSTANT})
SECONDS = 10.0


def recording(lacking: str, seed: int, late: float = 0.0) -> et.Measurement:
    """The drive's force is the load of the axis."""
    run = recorded(lacking, np.random.default_rng(seed), SECONDS, late)
    measured = et.Measurement(
        time=run.time,
        motor_position=np.zeros(len(run.time)),
        load_torque=run.force,
        signals={"joint_position": run.position},
        name="axis.csv",
    )
    return measured.to_compare(TRUE)


def notes(model: Model, measurement: et.Measurement) -> list[str]:
    """Of a fit to the recording."""
    found = et.fit(model, measurement)
    fitted = compare(found.model, found.problem.measurements, found.initial_states)
    return list(beginning_notes(fitted))


@pytest.mark.parametrize("late", [0.0, 1.3])
def test_the_numbers_of_an_axis_that_lacks_nothing_are_found(late: float) -> None:
    found = et.fit(TRUE.with_values({"link.inertia": 80.0}), recording("nothing", 1, late))
    values = found.model.values()
    for path, true in TRUE.values().items():
        if path in found.problem.coordinates.paths:
            assert values[path] == pytest.approx(true, rel=0.01), path


def test_an_error_that_hides_in_the_initial_velocity_is_told() -> None:
    model = TRUE.without(["coulomb_friction"])
    (told,) = notes(model, recording("nothing", 1, late=1.3))
    assert told.startswith("axis.csv: begun as its first 0.1 s show, the model errs ")
    times = float(told.split(" errs ")[1].split()[0])
    assert times > 1.5


def test_where_nothing_hides_nothing_is_told() -> None:
    own = recording("nothing", 1, late=1.3)
    begun = compare(TRUE.without(["coulomb_friction"]), own)
    assert list(beginning_notes(begun)) == []  # an unseen recording begins so anyway


def test_what_the_noise_does_to_the_beginning_is_not_told() -> None:
    own = recording("nothing", 1, late=1.3)
    noise = 1e-3 * np.random.default_rng(2).standard_normal(len(own.time))  # m
    noisy = {"joint_position": own.signals["joint_position"] + noise}
    assert notes(TRUE, replace(own, signals=noisy)) == []

"""Machines that nearly integrate are fitted through segments; truth is an independent simulator."""

from dataclasses import replace

import numpy as np
import pytest

import elastic_tendon as et
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.estimation.coordinates import free_parameters
from elastic_tendon.estimation.fit import THOROUGH, FitResult, fit
from elastic_tendon.estimation.problem import Problem, problem_of
from elastic_tendon.estimation.segments import in_segments, promise_less
from truth.axis import CONSTANT, DRY, MASS, VISCOUS, recorded

EVERY = 10  # of so many samples one is fitted: 100 a s
TRUE = {
    "link.inertia": MASS,
    "link.damping": VISCOUS,
    "effects.coulomb_friction.torque": DRY,
    "effects.constant_torque.torque": -CONSTANT,  # it acts along the position
}


def axis(inertia: float = MASS, damping: float = VISCOUS) -> Model:
    """As believed, with both effects at nothing."""
    link = {"inertia": inertia, "damping": damping}
    model = et.load_model({"name": "axis", "motion": "linear", "link": link})
    return model.with_effect("coulomb_friction", None).with_effect("constant_torque", None)


def recording(lacking: str, seed: int, seconds: float = 25.0) -> et.Measurement:
    """The drive's force is the load of the axis."""
    run = recorded(lacking, np.random.default_rng(seed), seconds)
    return et.Measurement(
        time=run.time[::EVERY],
        motor_position=np.zeros(len(run.time[::EVERY])),
        load_torque=run.force[::EVERY],
        signals={"joint_position": run.position[::EVERY]},
        name="axis.csv",
    )


def problem_at(model: Model, *recordings: et.Measurement) -> tuple[Problem, np.ndarray]:
    problem = problem_of(model, recordings, free_parameters(model))
    return problem, problem.start(model)


def left(found: FitResult) -> float:
    return found.problem.mean_square(found.vector)


@pytest.mark.parametrize("lacking", ["nothing", "pitch of the screw", "other friction backwards"])
def test_segments_lead_to_where_a_good_start_leads(lacking: str) -> None:
    """Damping believed ten times too small, which whole recordings mislead."""
    own, given = recording(lacking, 61), axis(damping=0.1 * VISCOUS)
    directly = fit(given, own, effort=replace(THOROUGH, in_segments=False))
    found, best = fit(given, own), fit(axis(), own)
    assert [len(part.time) for part in found.problem.measurements] == [len(own.time)]
    assert left(found) < min(0.01 * left(directly), 1.25 * left(best))
    for path in TRUE:
        value, good = (part.model.values()[path] for part in (found, best))
        assert value == pytest.approx(good, rel=0.05), path
    assert directly.model.link.damping < 0.5 * best.model.link.damping


def test_an_axis_that_lacks_nothing_is_found_from_a_wrong_damping() -> None:
    found = fit(axis(damping=0.1 * VISCOUS), recording("nothing", 62))
    for path, true in TRUE.items():
        assert found.model.values()[path] == pytest.approx(true, rel=0.02), path


def test_a_fit_that_ended_well_does_not_ask_segments() -> None:
    own = recording("other friction backwards", 63, seconds=10.0)
    found = fit(axis(), own)
    assert left(found) > 100.0  # the axis has what the model lacks
    assert not promise_less(found.problem, found.vector)


def test_segments_promise_less_where_an_axis_is_far_off() -> None:
    own = recording("nothing", 64, seconds=10.0)
    assert promise_less(*problem_at(axis(damping=0.1 * VISCOUS), own))


def test_springs_take_back_where_a_joint_began(frictionless) -> None:
    known, measured = frictionless
    values = known.model.values()
    off = known.model.with_values({"link.inertia": 3.0 * values["link.inertia"]})
    problem, vector = problem_at(off, measured)
    assert problem.mean_square(vector) > 100.0
    assert not promise_less(problem, vector)


def test_recordings_are_cut_to_equal_lengths_and_keep_their_noise() -> None:
    own = recording("nothing", 65, seconds=10.0)
    long, short = replace(own, name="long"), replace(own.samples(slice(0, 300)), name="short")
    problem, _ = problem_at(axis(), long, short)
    pieces = in_segments(problem, 4).measurements
    assert [part.name for part in pieces] == ["long"] * 3 + ["short"]
    assert sum(len(part.time) for part in pieces) == len(long.time) + len(short.time)
    floors = {part.noise["joint_position"].sigma for part in pieces[:3]}
    assert floors == {long.noise["joint_position"].sigma}


def test_many_short_recordings_stay_whole() -> None:
    own = recording("nothing", 66, seconds=8.0)
    parts = [replace(own.samples(slice(100 * i, 100 * i + 100)), name=f"{i}") for i in range(8)]
    problem, vector = problem_at(axis(damping=0.1 * VISCOUS), *parts)
    assert in_segments(problem, 8).measurements == problem.measurements
    assert not promise_less(problem, vector)

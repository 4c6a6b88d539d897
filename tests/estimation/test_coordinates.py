"""The fit's variables: inverse, derivatives, and models that exist everywhere within bounds."""

from dataclasses import replace

import numpy as np
import pytest

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.estimation.coordinates import PRETENSION, Coordinates, free_parameters
from elastic_tendon.measurement import Measurement

UPPER = "transmission.upper_spring.stiffness"


@pytest.fixture
def coordinates() -> Coordinates:
    model = load_model("figure_7")
    return Coordinates.of(model, free_parameters(model))


def test_what_is_known_or_whole_is_not_free() -> None:
    paths = free_parameters(load_model("biorob_x4_joint_3"))
    assert {UPPER, PRETENSION, "link.inertia", "link.damping"} <= set(paths)
    assert not any("radius" in path or "parallel" in path for path in paths)


def test_given_model_is_the_origin(coordinates: Coordinates) -> None:
    origin = np.zeros(len(coordinates.paths))
    assert coordinates.values(origin) == pytest.approx(coordinates.centre)
    assert coordinates.model(origin) == coordinates.given


def test_variables_invert_values(coordinates: Coordinates) -> None:
    x = np.random.default_rng(1).uniform(0.0, 0.5, len(coordinates.paths))
    assert coordinates.variables(coordinates.values(x)) == pytest.approx(x)


def test_derivatives_agree_with_differences(coordinates: Coordinates) -> None:
    x = np.random.default_rng(2).uniform(0.0, 0.5, len(coordinates.paths))
    exact = coordinates.derivatives(x)
    step = 1e-6
    for column in range(len(x)):
        shift = step * np.eye(len(x))[column]
        difference = (coordinates.values(x + shift) - coordinates.values(x - shift)) / (2 * step)
        # rounding of values up to 1e4 in differences over 2e-6
        assert exact[:, column] == pytest.approx(difference, rel=1e-6, abs=1e-5)


def test_every_corner_of_the_bounds_is_a_model(coordinates: Coordinates) -> None:
    lower, upper = coordinates.bounds()
    pretension = coordinates.paths.index(PRETENSION)
    stiffness = coordinates.paths.index(UPPER)
    for softness in (-5.0, 0.0, 5.0):
        x = np.zeros(len(coordinates.paths))
        x[stiffness] = max(softness, lower[stiffness])
        x[pretension] = upper[pretension]
        model = coordinates.model(x)
        limit = model.transmission.largest_pretension
        assert model.transmission.pretension_force == pytest.approx(limit)


def test_stiffness_alone_stays_above_what_a_known_pretension_needs() -> None:
    model = load_model("biorob_x4_joint_3")
    alone = Coordinates.of(model, [UPPER])
    softest = alone.model(alone.bounds()[0])
    transmission = softest.transmission
    assert transmission.pretension_force == pytest.approx(transmission.upper_spring.largest_force)


@pytest.mark.parametrize("load", [0.1, 400.0])
def test_a_load_beyond_the_springs_widens_the_prior_of_an_effects_torque(load) -> None:
    model = load_model("biorob_x4_joint_3").with_effect("coulomb_friction", None)
    path, time = "effects.coulomb_friction.torque", np.linspace(0.0, 1.0, 11)
    measurement = Measurement(
        time, 0.0 * time, {"joint_position": 0.0 * time}, -load * time, name="run"
    )
    (sigma,) = Coordinates.of(model, [path], None, [measurement]).sigma
    assert sigma == max(load, model.uncertainty_of(path))
    assert Coordinates.of(model, [UPPER], None, [measurement]).sigma == model.uncertainty_of(UPPER)


def test_a_load_widens_the_prior_of_what_makes_a_torque_of_the_velocity() -> None:
    model = load_model("biorob_x4_joint_3").with_effect("quadratic_drag", None)
    path, time = "effects.quadratic_drag.coefficient", np.linspace(0.0, 1.0, 11)
    moved = Measurement(time, 0.0 * time, {"joint_position": 2.0 * time}, 400.0 + time, name="run")
    (sigma,) = Coordinates.of(model, [path], None, [moved]).sigma
    assert sigma == pytest.approx(401.0 / 2.0**2)
    assert sigma > model.uncertainty_of(path)
    still = replace(moved, signals={"joint_position": 0.0 * time})
    (unmoved,) = Coordinates.of(model, [path], None, [still]).sigma
    assert unmoved == model.uncertainty_of(path)  # nothing tells how large it may be


def test_rounding_never_leads_out_of_the_bounds(coordinates: Coordinates) -> None:
    lower, upper = coordinates.bounds()
    for x in (np.nextafter(lower, -np.inf), lower - 1e-12):
        assert coordinates.model(np.where(np.isfinite(x), x, 0.0))
    assert coordinates.model(np.where(np.isfinite(upper), upper + 1e-12, 0.0))

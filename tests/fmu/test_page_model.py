"""The model in a page does what the library of this machine does."""

import math
from collections.abc import Iterator

import numpy as np
import pytest

pytest.importorskip("playwright")

from fmu_cases import MODELS, with_typical
from playwright.sync_api import Page

from app_driver import CHROMIUM, browser
from elastic_tendon import simulate
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.variables import interface
from elastic_tendon.fmu.icon import PAGES
from elastic_tendon.fmu.live import described
from elastic_tendon.native import library
from elastic_tendon.simulation.simulate import Trajectory, given_names

SAME = 1e-12  # of the largest value of a signal
TIME = np.linspace(0.0, 1.5, 151)
MOTIONS = {
    "motor_position": 0.3 * np.sin(9.0 * TIME) + 0.15 * np.sin(23.0 * TIME),
    "motor_torque": 2.0 * np.sin(9.0 * TIME),
    "joint_position": 0.05 * np.sin(11.0 * TIME),
    "load_torque": 3.0 * np.sin(5.0 * TIME),
}
RUN = """async ({described, motion, parameters}) => {
  const {run} = await simulator(await compiledModel(described), described, motion);
  run(parameters.map((value) => 1.001 * value));  // what one run leaves is nothing to the next
  const {outcome, states, outputs, eventTimes} = run(parameters);
  return {outcome, states: [...states], outputs: [...outputs], events: [...eventTimes]};
}"""

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")


def with_all(*effect_ids: str) -> Model:
    model = MODELS["base"]
    for effect_id in effect_ids:
        model = with_typical(model, effect_id)
    return model


def moved_by_torque() -> Model:
    motor = {"inertia": 0.01, "damping": 0.05}
    content = MODELS["base"].model_dump(exclude_none=True)
    model = Model.model_validate(content | {"motor": motor})
    return with_typical(model.at("torque"), "motor_friction")


CASES = {
    "of the paper": (MODELS["base"], "linear"),
    "contact and friction": (MODELS["effects"], "linear"),
    "implicit equations, states that remember": (MODELS["implicit"], "linear"),
    "hysteresis": (with_all("spring_hysteresis"), "hold"),
    "delay and offset": (with_all("measurement_delay", "joint_encoder_offset"), "cubic"),
    "sines": (with_all("gravity_load", "pulley_eccentricity", "gear_backlash"), "linear"),
    "rotor": (moved_by_torque(), "linear"),
    "joint moved": (MODELS["damped"].at("joint"), "cubic"),
}


@pytest.fixture(scope="module")
def page() -> Iterator[Page]:
    with browser() as chromium:
        opened = chromium.new_page()
        opened.add_script_tag(content=(PAGES / "model.js").read_text())
        yield opened


def of_library(model: Model, interpolation: str) -> Trajectory:
    inputs = {name: MOTIONS[name] for name in given_names(model)}
    return simulate(model, TIME, **inputs, interpolation=interpolation)


def of_page(page: Page, model: Model, interpolation: str) -> dict:
    from scipy.interpolate import CubicSpline

    variables = interface(*model.structure)
    inputs = [MOTIONS[name] for name in given_names(model)]
    starts = [np.nan if state.start is None else state.start for state in variables.states]
    motion = {
        "time": TIME.tolist(),
        "inputs": [values.tolist() for values in inputs],
        "slopes": [CubicSpline(TIME, values)(TIME, 1).tolist() for values in inputs],
        "interpolation": interpolation,
        "start": starts,
    }
    parameters = [*model.values().values(), *[0.0] * variables.reads_signals]
    given = {"described": described(model), "motion": motion, "parameters": parameters}
    return page.evaluate(RUN, given)


@pytest.mark.parametrize("case", CASES)
def test_a_page_simulates_as_the_library_does(case: str, page: Page) -> None:
    model, interpolation = CASES[case]
    native = of_library(model, interpolation)
    there = of_page(page, model, interpolation)
    assert there["outcome"] == "solved"
    for values, expected in ((there["states"], native.states), (there["outputs"], native.outputs)):
        difference = np.abs(np.reshape(values, expected.shape) - expected).max(axis=0)
        assert (difference <= SAME * np.abs(expected).max(axis=0)).all(), difference
    np.testing.assert_allclose(there["events"], native.event_times, rtol=0.0, atol=SAME)


def test_bristles_are_off_by_no_more_than_the_last_bit_of_a_number(page: Page) -> None:
    """They are so stiff that a bit decides which steps are implicit: of a page's `pow`, too."""
    model = with_all("lugre_friction")
    native = of_library(model, "linear")
    there = np.reshape(of_page(page, model, "linear")["states"], native.states.shape)
    path = "link.inertia"
    changed = model.with_values({path: math.nextafter(model.values()[path], math.inf)})
    off = of_library(changed, "linear").states - native.states
    assert np.abs(off).max() > SAME
    assert np.abs(there - native.states).max() < 10.0 * np.abs(off).max()


def test_the_cases_hold_slack_and_states_that_remember() -> None:
    native = [of_library(*case) for case in CASES.values()]
    assert {1.0, 2.0, 3.0} <= set(native[0]["slack_state"])
    assert all(len(trajectory.event_times) > 10 for trajectory in native[:2])
    remembered = {name.rpartition(".")[2] for one in native for name in one.state_names}
    assert len(remembered) > 3


def test_a_module_asks_for_nothing_but_mathematics(page: Page) -> None:
    model, _ = CASES["sines"]
    asked = page.evaluate(
        "async (described) => WebAssembly.Module.imports(await compiledModel(described))",
        described(model),
    )
    assert {one["module"] for one in asked} == {"Math"}
    assert {one["name"] for one in asked} <= {"pow", "exp", "log", "sin", "cos"}


def test_a_module_is_small_and_kept_in_the_cache() -> None:
    model, _ = CASES["contact and friction"]
    assert len(described(model)["module"]) < 60_000
    key = library._key_for(library.structure_key(*model.structure), library.compiler.PAGE)
    kept = library._cached(f"{key}-*")
    assert kept is not None
    assert kept.read_bytes().startswith(b"\0asm")

"""The model that runs in the page of an FMU."""

import json
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

pytest.importorskip("playwright")
pytest.importorskip("axe_playwright_python")

from fmu_cases import MODELS

from app_driver import CHROMIUM
from elastic_tendon.actuator.design import design
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.variables import interface
from elastic_tendon.fmu import live
from elastic_tendon.fmu.documentation import documentation
from elastic_tendon.fmu.live import described, fmu_panel, numbers
from elastic_tendon.native.layout import layout
from live_panel import opened

LARGEST = 400_000  # bytes that a panel may add

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")


def page_of(model: Model, panel: str) -> bytes:
    variables = layout(interface(*model.structure), model.values())
    return documentation(model, variables, 2, panel=panel)["documentation/index.html"]


def moved_by_torque() -> Model:
    content = MODELS["effects"].model_dump(exclude_none=True) | {"motor": {"inertia": 0.01}}
    return Model.model_validate(content).at("torque")


def that_slides() -> Model:
    content = MODELS["effects"].model_dump(exclude_none=True)
    return Model.model_validate(content | {"motion": "linear"})


def written(model: Model, folder: Path) -> Path:
    path = folder / "index.html"
    path.write_bytes(page_of(model, fmu_panel(model)))
    return path


@pytest.fixture(scope="module")
def page(tmp_path_factory) -> Path:
    return written(MODELS["effects"], tmp_path_factory.mktemp("page"))


@pytest.mark.parametrize("model", [MODELS["effects"], moved_by_torque()], ids=lambda one: one.kind)
def test_the_model_follows_sliders_and_nothing_is_asked_for(model: Model, tmp_path: Path) -> None:
    with opened(written(model, tmp_path)) as panel:
        panel.wait()
        begun = panel.numbers
        panel.press("pretension force", "End")
        assert panel.numbers != begun
        panel.page.get_by_role("button", name="Reset all").click()
        panel.settle()
        assert panel.numbers == begun
        assert panel.faults == []


def test_a_step_follows_the_pointer(page: Path) -> None:
    with opened(page) as panel:
        panel.wait()
        canvas = panel.page.locator(".live canvas")
        canvas.scroll_into_view_if_needed()
        time = panel.slider("time of the step")
        before = float(time.input_value())
        canvas.hover(position={"x": 300, "y": 60})
        panel.page.mouse.down()
        panel.settle()
        assert float(time.input_value()) > before + 20
        canvas.hover(position={"x": 200, "y": 60})
        panel.settle()
        assert before < float(time.input_value()) < 100
        panel.page.mouse.up()


def test_one_that_slides_is_shown_in_metres_and_newtons(tmp_path: Path) -> None:
    model = that_slides()
    assert not re.search(r"\brad\b|N·m\b|kg·m²", json.dumps(live.groups(model), ensure_ascii=False))
    with opened(written(model, tmp_path)) as panel:
        panel.wait()
        assert re.search(r"Largest joint force [\d.]+ N\.", panel.numbers)
        panel.press("step of the motor position", "End")
        told = panel.slider("step of the motor position").get_attribute("aria-valuetext")
        limits = (-design(model).negative_max_deflection, design(model).positive_max_deflection)
        farthest = 2.0 * min(limits) / model.transmission.motor_share
        assert told == f"{farthest:.3g} m"
        assert panel.faults == []


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_everybody_can_read_and_reach_it(page: Path, theme: str) -> None:
    with opened(page, theme=theme) as panel:
        panel.wait()
        assert panel.shortcomings() == []


def test_without_webassembly_there_is_a_sentence_and_the_picture(page: Path) -> None:
    with opened(page, webassembly=False) as panel:
        panel.page.get_by_text("the picture under Equations").wait_for()
        assert panel.page.locator(".live").is_hidden()
        assert panel.page.locator("figure svg").is_visible()


def test_the_page_is_well_formed_and_little_larger() -> None:
    model = MODELS["implicit"]
    alive, plain = page_of(model, fmu_panel(model)), page_of(model, "")
    assert ElementTree.fromstring(alive).find(".//*[@id='live-model']") is not None
    assert 20_000 < len(alive) - len(plain) < LARGEST
    assert b"<script" not in plain


def test_a_slider_covers_value_interval_and_where_an_effect_vanishes() -> None:
    model = MODELS["effects"]
    intervals = {"link.inertia": (0.02, 1.0), "transmission.pretension_force": (0.0, 1e9)}
    listed = {number.path: number for number in numbers(model, intervals)}
    assert tuple(listed) == interface(*model.structure).parameter_names
    for quantity in model.quantities():
        number = listed[quantity.path]
        assert quantity.lower <= number.low <= number.value <= number.high <= quantity.upper
        assert number.low < number.high
    inertia = listed["link.inertia"]
    assert inertia.low <= 0.02
    assert inertia.high == pytest.approx(5.0 * inertia.value)  # no further, whatever the interval
    assert listed["effects.coulomb_friction.torque"].low == 0.0


def test_a_model_that_is_too_large_stays_out(monkeypatch) -> None:
    model = MODELS["effects"]
    monkeypatch.setattr(live, "LARGEST", 1000)
    assert fmu_panel(model) == ""
    assert page_of(model, fmu_panel(model)) == page_of(model, "")


def test_equal_models_give_equal_modules() -> None:
    model = MODELS["effects"]
    other = model.with_values({"link.inertia": 0.05})
    assert described(model) == described(other)

"""What an FMU shows to people: a page about its own model, the license, the icon."""

import re
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from fmu_cases import MODELS
from matplotlib.image import imread

import draw_icon
from effects_at import placed
from elastic_tendon import effects
from elastic_tendon.actuator.design import design
from elastic_tendon.actuator.parameters import (
    load_model,
    models,
    parse_model,
    typical_value,
)
from elastic_tendon.actuator.transmission import characteristic_torque
from elastic_tendon.actuator.variables import interface
from elastic_tendon.effects import CATALOGUE
from elastic_tendon.effects.registry import Registry
from elastic_tendon.fmu.characteristic_plot import HEIGHT, WIDTH, characteristic_plot
from elastic_tendon.fmu.documentation import documentation
from elastic_tendon.fmu.icon import flanges, icon
from elastic_tendon.native.layout import Role, layout

ROOT = Path(__file__).parents[2]
LARGEST_PAGE = 40_000  # bytes

# children that an element of MathML must have
OPERANDS = {"mfrac": 2, "msub": 2, "msup": 2}
TOKENS = {"mi", "mn", "mo", "mtext", "mspace"}

WICKED = """
from elastic_tendon.effects.base import Contribution, Effect, Parameter, Slot

EFFECT = Effect(
    id="wicked",
    title="<script>title</script> & $name",
    slot=Slot.JOINT_TORQUE,
    physics="</p><script>physics</script> & more.",
    in_data="In data.",
    parameters=(
        Parameter("size", "N.m", "</td><script>size</script> & such", null=0.0, lower=0.0,
            upper=1.0, typical=0.5),
    ),
    equations=lambda at, p, _state, _mode: Contribution(-p.size * at.velocity),
    law="-size v < 0 & <b>bold</b> ${R2}",
    reference="<a href='https://example.org'>Reference</a>",
)
"""


def variables_of(model, fmi_version=2):
    structure = interface(model.effect_ids)
    return layout(structure, model.values(), indicators=fmi_version == 3)


def page(model, fmi_version=2):
    files = documentation(model, variables_of(model, fmi_version), fmi_version)
    return files["documentation/index.html"].decode()


def parsed(model, fmi_version=2):
    """The page's elements; it is well-formed XML too, so nothing is left open."""
    return ElementTree.fromstring(page(model, fmi_version))


def text_of(element):
    return " ".join("".join(element.itertext()).split())


def rows(root):
    """Cells of the tables' rows by the first one, which is unique for variables."""
    listed = [[text_of(cell) for cell in row.iter("td")] for row in root.iter("tr")]
    return {cells[0]: cells for cells in listed if cells}


def with_effect(model, effect):
    numbers = {
        one.name: float(np.clip(typical_value(model, one), one.lower, one.upper))
        for one in effect.parameters
    }
    return model.with_effect(effect.id, numbers)


def models_with_effects():
    base = MODELS["base"]
    return [with_effect(placed(base, effect), effect) for effect in CATALOGUE]


@pytest.fixture(params=[2, 3])
def version(request):
    return request.param


# ---- the page --------------------------------------------------------------------------------


def test_lists_every_input_output_and_state(name, version):
    model = MODELS[name]
    found = rows(parsed(model, version))
    for one in variables_of(model, version):
        if one.role in (Role.INPUT, Role.OUTPUT, Role.STATE):
            assert found[one.name][-1] == one.variable.meaning
            starts = "calculated" if one.start is None else f"{one.start:g}"
            assert found[one.name][2] == starts


def test_lists_every_parameter_with_the_value_of_this_model(name, version):
    model = MODELS[name].with_values({"link.inertia": 0.0421, "transmission.pretension_force": 77})
    found = rows(parsed(model, version))
    for one in variables_of(model, version):
        if one.role is Role.PARAMETER:
            _, _, start, bounds, variability, meaning = found[one.name]
            assert float(start) == pytest.approx(model.values()[one.name], rel=1e-5)
            assert [float(bound) for bound in bounds.split(" to ")] == [
                one.variable.lower,
                one.variable.upper,
            ]
            assert (variability, meaning) == (one.variability, one.variable.meaning)
    assert found["link.inertia"][1:4] == ["kg·m²", "0.0421", "1e-9 to 10000"]
    assert found["motor_velocity_connected"][1:5] == ["Boolean", "false", "", "fixed"]


def test_slack_states_have_the_numbers_of_this_model():
    model = MODELS["damped"].with_values({"transmission.lower_spring.stiffness": 9000.0})
    numbers = design(model)
    found = rows(parsed(model))
    lower, upper, none = found["1: I"], found["2: II"], found["3: III"]
    assert lower[1] == "lower tendon"
    assert f"= {numbers.negative_slack_boundary:.4g} rad" in lower[2]
    assert f"= {numbers.positive_slack_boundary:.4g} rad" in upper[2]
    for cells, stiffness, damping in (
        (lower, numbers.stiffness_state_1, numbers.damping_state_1),
        (upper, numbers.stiffness_state_2, numbers.damping_state_2),
        (none, numbers.stiffness_state_3, numbers.damping_state_3),
    ):
        assert f"= {stiffness:.4g} (" in cells[3]
        assert f"= {damping:.4g} (" in cells[4]
    limits = text_of(parsed(model))
    assert f"= {numbers.negative_max_deflection:.4g} rad to" in limits
    assert f"= {numbers.positive_max_deflection:.4g} rad, (16)" in limits


@pytest.mark.parametrize("model", models_with_effects(), ids=lambda one: one.effect_ids[0])
def test_explains_each_effect(model, version):
    (effect,) = interface(model.effect_ids).effects
    text = text_of(parsed(model, version))
    for said in (effect.title, effect.physics, effect.law, effect.reference):
        assert " ".join(said.split()) in text
    for mode in interface(model.effect_ids).modes:
        assert mode.name in text
    assert len(page(model, version).encode()) <= LARGEST_PAGE


def test_paper_s_model_has_no_effects_and_its_states_do_not_jump():
    text = text_of(parsed(MODELS["base"]))
    assert "None: this is the model of the paper." in text
    assert "No state jumps." in text
    assert "begins to stick" in text_of(parsed(MODELS["effects"]))


def test_speaks_of_functions_of_its_version_only(version):
    text = page(MODELS["base"], version)
    named = set(re.findall(r"\bfmi\d\w+", text))
    functions = Path(find_spec("fmpy").origin).parent / "c-code" / f"fmi{version}Functions.h"
    types = functions.with_name(f"fmi{version}FunctionTypes.h")
    known = set(re.findall(r"\bfmi\d\w+", functions.read_text() + types.read_text()))
    assert named
    assert named <= known
    assert f"FMI {version}.0" in text


@pytest.mark.parametrize("name", models)
def test_is_small_and_needs_nothing_else(name, version):
    text = page(load_model(name), version)
    assert len(text.encode()) <= LARGEST_PAGE
    without_namespace = text.replace(draw_icon.SVG, "")
    assert not re.search(r"https?:|<script|<link|@import|url\(|<img", without_namespace)


def test_links_lead_somewhere(version):
    model = MODELS["base"]
    root = parsed(model, version)
    files = documentation(model, variables_of(model, version), version)
    places = {f"#{one.get('id')}" for one in root.iter() if one.get("id")}
    files_beside = {path.removeprefix("documentation/") for path in files}
    targets = {one.get("href") for one in root.iter("a")}
    assert targets <= places | files_beside
    assert places <= targets


def test_formulas_are_complete(version):
    formulas = list(parsed(MODELS["effects"], version).iter("math"))
    assert len(formulas) > 20
    for formula in formulas:
        for element in formula.iter():
            assert len(element) == OPERANDS.get(element.tag, len(element))
            assert element.tag in TOKENS or not (element.text or "").strip()
            assert not (element is not formula and (element.tail or "").strip())


def test_what_a_model_says_is_never_markup(tmp_path, monkeypatch, version):
    monkeypatch.setattr(effects, "BY_ID", Registry(CATALOGUE))
    file = tmp_path / "wicked.py"
    file.write_text(WICKED)
    wicked = effects.load(file)
    tree = with_effect(MODELS["base"], wicked).model_dump()
    name = "<script>name</script> & ${R2} $style"
    model = parse_model(tree | {"name": name}, "model.toml")
    text = page(model, version)
    assert "<script" not in text
    assert "<b>" not in text
    assert "example.org" in text
    assert text_of(parsed(model, version).find("head/title")) == name
    shown = text_of(parsed(model, version))
    for said in (wicked.title, wicked.physics, wicked.law, wicked.reference):
        assert said in shown
    assert rows(parsed(model, version))["effects.wicked.size"][-1] == (
        "</td><script>size</script> & such"
    )


def test_equal_models_have_equal_pages(name, version):
    model = MODELS[name]
    again = parse_model(model.model_dump(), "again")
    assert page(model, version) == page(again, version)


def test_versions_differ_in_what_they_say_of_use():
    two, three = (text_of(parsed(MODELS["base"], version)) for version in (2, 3))
    for told in ("joint_flange", "There are no clocks"):
        assert told in three
        assert told not in two


def test_building_is_explained_where_there_are_sources(version):
    model = MODELS["base"]
    files = documentation(model, variables_of(model, version), version, library="joint")
    root = ElementTree.fromstring(files["documentation/index.html"])
    folder = {2: "linux64", 3: "x86_64-linux"}[version]
    assert f"sources/library.c -o binaries/{folder}/joint.so -lm" in (
        text_of(root.find(".//pre")).replace("\\ ", "")
    )
    assert '"#build"' not in page(model, version)


def test_license_is_that_of_the_project(version):
    files = documentation(MODELS["base"], variables_of(MODELS["base"]), version)
    assert files["documentation/licenses/license.txt"] == (ROOT / "LICENSE").read_bytes()


# ---- the curve -------------------------------------------------------------------------------


def points_of(svg, style):
    (line,) = [one for one in svg.iter("polyline") if one.get("class") == style]
    return np.array([point.split(",") for point in line.get("points").split()], dtype=float)


def test_curve_is_the_characteristic(name):
    transmission = MODELS[name].transmission
    numbers = design(MODELS[name])
    x, y = points_of(characteristic_plot(transmission), "curve").T
    low, high = numbers.negative_max_deflection, numbers.positive_max_deflection
    deflection = low + (x - x[0]) / (x[-1] - x[0]) * (high - low)
    boundaries = [numbers.negative_slack_boundary, numbers.positive_slack_boundary]
    np.testing.assert_allclose(deflection[1:-1], boundaries, atol=1e-3 * (high - low))
    torque = characteristic_torque(deflection, transmission)
    drawn = torque[0] + (y - y[0]) / (y[-1] - y[0]) * (torque[-1] - torque[0])
    np.testing.assert_allclose(drawn, torque, atol=1e-3 * (torque[0] - torque[-1]))
    assert y[0] < y[-1]  # upwards is more torque, and the picture's y points downwards
    assert (x.min(), y.min()) > (0, 0)
    assert (x.max(), y.max()) < (WIDTH, HEIGHT)


@pytest.mark.parametrize("pretension", [0.0, 300.0, 347.4])
def test_curve_of_any_pretension(pretension):
    """Without it state III is a point, above (30) it is all there is, at (27) nothing is left."""
    model = MODELS["base"].with_values({"transmission.pretension_force": pretension})
    plot = characteristic_plot(model.transmission)
    parsed(model)  # there is a page in every case
    if pretension == 347.4:
        assert plot is None
        return
    names = {text.text for text in plot.iter("text")} & {"I", "II", "III"}
    assert names == ({"I", "II"} if pretension == 0.0 else {"III"})


# ---- the icon --------------------------------------------------------------------------------


def test_pictures_are_as_the_script_draws_them():
    """Exactly as SVG; as PNG but for the last bits of smoothing."""
    pictures, drawn = icon() | flanges(), draw_icon.files()
    assert set(pictures) == set(drawn)
    for name, content in pictures.items():
        if name.endswith(".svg"):
            assert content == drawn[name]
            continue
        kept, new = (imread(BytesIO(png)) for png in (content, drawn[name]))
        assert kept.shape == new.shape
        different = np.abs(kept - new).max(axis=2) > 0.25
        assert different.mean() < 1e-3


def test_icon_is_a_card_on_any_ground():
    """Opaque but for its corners, so it reads on white and on black."""
    alpha = imread(BytesIO(icon()["icon.png"]))[..., 3]
    assert alpha[0, 0] == 0
    assert alpha[20:-20, 20:-20].min() == 1

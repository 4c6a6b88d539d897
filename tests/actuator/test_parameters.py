"""model.toml: what is accepted and what comes of it."""

import subprocess
import sys
import tomllib
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from elastic_tendon import effects
from elastic_tendon.actuator.parameters import (
    load_model,
    models,
    parse_model,
    quantities,
    typical_value,
)
from elastic_tendon.effects.base import Parameter, Sizes
from elastic_tendon.errors import ModelError

BUNDLED = (
    *("bench_actuator", "biorob_x4_joint_3", "figure_7", "figure_8"),
    *("mrd_jaw", "mrd_tool_4", "muir_bench"),
)
ALL_EFFECTS = tuple(effect.id for effect in effects.CATALOGUE)
# by coulomb_friction, and by a motor torque that is given
EXCLUDED = (
    *("stribeck_friction", "lugre_friction"),
    *("motor_reading_gain", "motor_reading_offset"),
)
COMPATIBLE = tuple(effect_id for effect_id in ALL_EFFECTS if effect_id not in EXCLUDED)
ROUNDING = 1e-12  # relative: a few operations in double precision


@pytest.fixture
def tree() -> dict[str, Any]:
    """Content of a good model.toml, for each test to spoil."""
    return load_model("biorob_x4_joint_3").model_dump(exclude_none=True)


# ---- bundled models and the round trip ----


def test_bundled_models_are_those_promised() -> None:
    assert tuple(models) == BUNDLED


@pytest.mark.parametrize("name", BUNDLED)
def test_bundled_model_loads_warns_of_nothing_and_survives_the_round_trip(
    name: str, tmp_path: Path
) -> None:
    model = load_model(name)
    path = tmp_path / "model.toml"
    path.write_text(model.to_toml(), encoding="utf-8")
    assert model.name == name
    assert model.warnings() == []
    assert load_model(path) == model


def test_round_trip_keeps_every_section_and_every_digit(tree: dict[str, Any]) -> None:
    tree["motor"] = {"inertia": 1e-5, "damping": 0.1, "friction_torque": 1 / 3}
    tree["uncertainty"] = {"link.inertia": 0.1, "effects.coulomb_friction.torque": 2.0}
    tree["effects"] = {"overstretch_protection": {"stiffness": 1e4 / 3}, "coulomb_friction": {}}
    model = parse_model(tree, "made here")
    assert parse_model(tomllib.loads(model.to_toml()), "again") == model
    assert model.motor is not None


def test_defaults_are_those_of_the_contract() -> None:
    spring = {"stiffness": 1000, "max_deflection": 0.01}  # whole numbers are numbers
    model = parse_model(
        {
            "name": "small",
            "transmission": {
                "joint_pulley_radius": 0.03,
                "motor_pulley_radius": 0.03,
                "pretension_force": 0,
                "upper_spring": spring,
                "lower_spring": spring,
            },
            "link": {"inertia": 0.1},
        },
        "small",
    )
    assert model.transmission.upper_spring.parallel == 1
    assert model.transmission.upper_spring.damping == 0.0
    assert model.link.damping == 0.0
    assert model.effects == {}
    assert model.motor is None


def test_a_windows_file_loads(tmp_path: Path) -> None:
    path = tmp_path / "model.toml"
    text = load_model("figure_7").to_toml().replace("\n", "\r\n")
    path.write_bytes(b"\xef\xbb\xbf" + text.encode())
    assert load_model(path) == load_model("figure_7")


def test_loading_a_model_does_not_import_casadi() -> None:
    code = (
        "import sys; from elastic_tendon.actuator.parameters import load_model; "
        "load_model('figure_7'); sys.exit('casadi' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


# ---- files that are no model ----


def no_file(folder: Path) -> Path:
    return folder / "nowhere.toml"


def a_folder(folder: Path) -> Path:
    return folder


def binary(folder: Path) -> Path:
    path = folder / "binary.toml"
    path.write_bytes(bytes(range(256)))
    return path


def broken_toml(folder: Path) -> Path:
    path = folder / "broken.toml"
    path.write_text('name = "x"\n[transmission\n', encoding="utf-8")
    return path


def too_deep(folder: Path) -> Path:
    path = folder / "deep.toml"
    path.write_text("x = " + "[" * 100_000, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("make", "fragments"),
    [
        (no_file, ["there is no such file", *BUNDLED]),
        (a_folder, ["folder"]),
        (binary, ["not a text file"]),
        (broken_toml, ["not valid TOML", "line 2"]),
        (too_deep, ["nested too deeply"]),
    ],
)
def test_unreadable_file_is_one_sentence(
    make: Callable[[Path], Path], fragments: list[str], tmp_path: Path
) -> None:
    path = make(tmp_path)
    with pytest.raises(ModelError) as caught:
        load_model(path)
    (sentence,) = caught.value.problems
    assert caught.value.source == str(path)
    assert "\n" not in sentence
    for fragment in fragments:
        assert fragment in sentence


def test_nul_in_a_path_is_one_sentence() -> None:
    with pytest.raises(ModelError, match="cannot be read"):
        load_model("a\0b")


@pytest.mark.parametrize("name", ["", " \t ", "a\0b", "two\nlines"])
def test_a_name_that_cannot_be_read_is_refused(tree: dict[str, Any], name: str) -> None:
    with pytest.raises(ModelError, match="a name is one line of text") as caught:
        parse_model(tree | {"name": name}, "model.toml")
    assert len(caught.value.problems) == 1


# ---- warnings ----


def test_pretension_at_the_limit_is_allowed_and_warned_of() -> None:
    model = load_model("biorob_x4_joint_3")
    limit = model.transmission.largest_pretension
    at_limit = model.with_values({"transmission.pretension_force": limit})
    (warning,) = at_limit.warnings()
    assert "transmission.pretension_force" in warning
    assert "173.7 N, paper (30)" in warning


def test_pretension_at_the_recommended_limit_is_not_warned_of() -> None:
    model = load_model("biorob_x4_joint_3")
    recommended = model.transmission.recommended_pretension
    assert model.with_values({"transmission.pretension_force": recommended}).warnings() == []


def test_heavy_springs_are_warned_of(tree: dict[str, Any]) -> None:
    # J/R^2 is 33.3 kg; two springs of 1.7 kg are more than a tenth, two of 1.6 kg are not
    spring = tree["transmission"]["upper_spring"]
    spring["mass"] = 1.6
    light = parse_model(tree, "light")
    spring["mass"] = 1.7
    heavy = parse_model(tree, "heavy")
    assert light.warnings() == []
    (warning,) = heavy.warnings()
    assert warning.startswith("transmission.upper_spring.mass: 3.4 kg")


# ---- numbers by dotted path ----


def test_values_come_in_the_order_of_the_quantities() -> None:
    model = load_model("biorob_x4_joint_3").with_effect("coulomb_friction", {"torque": 0.35})
    values = model.values()
    assert list(values) == [quantity.path for quantity in quantities(model.effect_ids)]
    assert values["transmission.joint_pulley_radius"] == 0.03
    assert values["transmission.upper_spring.parallel"] == 2.0
    assert values["effects.coulomb_friction.torque"] == 0.35
    assert all(type(value) is float for value in values.values())


def test_quantities_are_the_run_time_numbers_only() -> None:
    paths = [quantity.path for quantity in quantities(())]
    springs = [
        f"transmission.{side}.{name}"
        for side in ("upper_spring", "lower_spring")
        for name in ("stiffness", "parallel", "damping", "max_deflection")
    ]
    assert paths == [
        "transmission.joint_pulley_radius",
        "transmission.motor_pulley_radius",
        *springs,
        "transmission.pretension_force",
        "transmission.slack",
        "link.inertia",
        "link.damping",
    ]


@pytest.mark.parametrize("quantity", quantities(ALL_EFFECTS), ids=lambda quantity: quantity.path)
def test_quantity_is_declared_in_full(quantity: Any) -> None:
    assert quantity.unit
    assert len(quantity.meaning) > 10
    assert quantity.lower < quantity.upper
    assert quantity.lower <= quantity.default <= quantity.upper
    assert quantity.lower <= quantity.nominal <= quantity.upper
    assert quantity.nominal > 0.0
    assert quantity.integer == quantity.path.endswith((".parallel", ".slack"))


def test_order_of_effects_is_the_catalogue_s() -> None:
    there = [quantity.path for quantity in quantities(ALL_EFFECTS)]
    back = [quantity.path for quantity in quantities(reversed(ALL_EFFECTS))]
    model = load_model("biorob_x4_joint_3").at("torque")
    for effect_id in reversed(COMPATIBLE):
        model = model.with_effect(effect_id, None)
    assert there == back
    assert model.effect_ids == COMPATIBLE


def test_quantities_of_an_unknown_effect_are_refused() -> None:
    with pytest.raises(KeyError, match="perpetual_motion"):
        quantities(["perpetual_motion"])


def test_with_values_changes_only_what_it_is_told() -> None:
    model = load_model("biorob_x4_joint_3")
    changed = model.with_values(
        {"link.inertia": np.float64(0.05), "transmission.upper_spring.parallel": 3.0}
    )
    expected = model.values() | {"link.inertia": 0.05, "transmission.upper_spring.parallel": 3.0}
    assert changed.values() == expected
    assert type(changed.link.inertia) is float
    assert model == load_model("biorob_x4_joint_3")


@pytest.mark.parametrize(
    ("values", "fragment"),
    [
        ({"link.inertai": 1.0}, "did you mean link.inertia?"),
        ({"name": 1.0}, "not known in this model"),
        ({"link.inertia": -1.0}, "-1.0 is outside"),
        ({"link.inertia": float("nan")}, "not finite"),
        ({"transmission.upper_spring.parallel": 2.5}, "not a whole number"),
        ({"transmission.pretension_force": 400.0}, "(27)"),
        ({"effects.coulomb_friction.torque": 1.0}, "not known in this model"),
    ],
)
def test_with_values_checks_the_whole_model(values: dict[str, float], fragment: str) -> None:
    with pytest.raises(ModelError) as caught:
        load_model("biorob_x4_joint_3").with_values(values)
    assert fragment in str(caught.value)


def test_effect_left_open_takes_its_null_values() -> None:
    model = load_model("biorob_x4_joint_3").with_effect("overstretch_protection", None)
    nulls = {
        parameter.name: parameter.null
        for parameter in effects.BY_ID["overstretch_protection"].parameters
    }
    assert model.effects == {"overstretch_protection": nulls}


def test_with_effect_refuses_what_is_not_declared() -> None:
    model = load_model("biorob_x4_joint_3")
    with pytest.raises(ModelError, match="did you mean coulomb_friction"):
        model.with_effect("coulomb_fricton", None)
    with pytest.raises(ModelError, match="did you mean torque"):
        model.with_effect("coulomb_friction", {"torqe": 1.0})


def test_models_are_frozen() -> None:
    with pytest.raises(ValueError, match="frozen"):
        load_model("figure_7").name = "other"


# ---- uncertainty and typical values ----


@pytest.mark.parametrize(
    ("path", "sigma"),
    [
        ("transmission.joint_pulley_radius", 0.0),
        ("transmission.upper_spring.max_deflection", 0.0),
        ("transmission.upper_spring.parallel", 0.0),
        ("transmission.upper_spring.stiffness", 0.1 * 11580.0),
        ("transmission.pretension_force", 0.3 * 80.0),
        ("link.inertia", 0.3 * 0.03),
        ("link.damping", 1.0 * 0.16),
    ],
)
def test_default_uncertainty(path: str, sigma: float) -> None:
    found = load_model("biorob_x4_joint_3").uncertainty_of(path)
    assert found == pytest.approx(sigma, rel=ROUNDING)


def test_given_uncertainty_is_relative_to_the_value_and_absolute_at_zero(
    tree: dict[str, Any],
) -> None:
    tree["uncertainty"] = {"link.inertia": 0.5, "transmission.upper_spring.damping": 7.0}
    model = parse_model(tree, "made here")
    assert model.uncertainty_of("link.inertia") == pytest.approx(0.5 * 0.03, rel=ROUNDING)
    assert model.uncertainty_of("transmission.upper_spring.damping") == 7.0


@pytest.mark.parametrize("path", ["link.damping", "transmission.upper_spring.damping"])
def test_unknown_damping_is_as_wide_as_a_damping_ratio(path: str) -> None:
    model = load_model("biorob_x4_joint_3").with_values({"link.damping": 0.0})
    # both springs of both sides as damped as that, or the link
    torque_damping = model.uncertainty_of(path) * (4 * 0.03**2 if "spring" in path else 1.0)
    ratio = torque_damping / (2 * np.sqrt(41.688 * 0.03))
    assert ratio == pytest.approx(0.3, rel=ROUNDING)


def test_effects_are_uncertain_by_ten_typical_values() -> None:
    model = load_model("biorob_x4_joint_3").with_effect("coulomb_friction", {"torque": 0.35})
    (parameter,) = effects.BY_ID["coulomb_friction"].parameters
    typical = 0.03 * 0.03 * 23160.0 * 0.015  # a share of the largest torque
    assert typical_value(model, parameter) == pytest.approx(typical, rel=ROUNDING)
    path = "effects.coulomb_friction.torque"
    assert model.uncertainty_of(path) == pytest.approx(10 * typical, rel=ROUNDING)


def test_direction_of_a_typical_value_is_no_matter_of_its_uncertainty() -> None:
    model = load_model("biorob_x4_joint_3").with_effect("joint_stop", None)
    lower = next(
        parameter
        for parameter in effects.BY_ID["joint_stop"].parameters
        if parameter.name == "lower"
    )
    typical = typical_value(model, lower)
    assert typical < 0.0
    assert model.uncertainty_of("effects.joint_stop.lower") == -10.0 * typical


FIGURE_7 = Sizes(  # the softer, shorter and weaker of springs that differ
    torque=0.05 * min(22820 * 0.005, 17115 * 0.00665),
    stiffness=17115.0,
    max_deflection=0.005,
    joint_stiffness=0.05**2 * (22820.0 + 17115.0),
    inertia=0.03,
    radius=0.05,
    parallel=1,
)


@pytest.mark.parametrize("size", [field.name for field in fields(Sizes)])
def test_typical_value_is_measured_by_the_actuator(size: str) -> None:
    parameter = Parameter("x", "1", "a number", 0.0, 0.0, 1.0, lambda sizes: getattr(sizes, size))
    expected = getattr(FIGURE_7, size)
    assert typical_value(load_model("figure_7"), parameter) == pytest.approx(expected, rel=ROUNDING)


# ---- effects together ----


@pytest.mark.parametrize(
    ("ids", "sentence"),
    [
        (
            ("stribeck_friction", "lugre_friction"),
            "effects: stribeck_friction and lugre_friction are both laws of the joint's dry "
            "friction; a model takes one; remove one",
        ),
        (
            ("lugre_friction", "gravity_load", "coulomb_friction", "stribeck_friction"),
            "effects: coulomb_friction, stribeck_friction and lugre_friction are all laws of the "
            "joint's dry friction; a model takes one; keep one",
        ),
    ],
)
def test_laws_of_the_same_exclude_each_other(ids: tuple[str, ...], sentence: str) -> None:
    tree = load_model("biorob_x4_joint_3").model_dump(exclude_none=True)
    tree["effects"] = {effect_id: {} for effect_id in ids}
    with pytest.raises(ModelError) as caught:
        parse_model(tree, "made here")
    assert caught.value.problems == [sentence]


def test_two_masses_of_the_springs_exclude_each_other(monkeypatch: pytest.MonkeyPatch) -> None:
    second = replace(effects.BY_ID["spring_mass"], id="second_mass", law_of="something else")
    monkeypatch.setitem(effects.BY_ID, "second_mass", second)
    model = load_model("biorob_x4_joint_3").with_effect("spring_mass", None)
    with pytest.raises(ModelError, match="spring_mass and second_mass are both laws of the spring"):
        model.with_effect("second_mass", None)


def test_effect_refuses_numbers_that_do_not_go_together() -> None:
    model = load_model("biorob_x4_joint_3").with_effect("joint_stop", {"lower": -1.0, "upper": 1.0})
    with pytest.raises(ModelError) as caught:
        model.with_values({"effects.joint_stop.lower": 2.0})
    (sentence,) = caught.value.problems
    assert sentence.startswith("effects.joint_stop: lower 2 rad is not below upper 1 rad")


def test_effect_warns_of_unusual_numbers() -> None:
    numbers = {"coulomb_torque": 1.0, "static_torque": 2.0}
    usual = load_model("biorob_x4_joint_3").with_effect("stribeck_friction", numbers)
    unusual = usual.with_values({"effects.stribeck_friction.static_torque": 0.5})
    assert usual.warnings() == []
    (warning,) = unusual.warnings()
    assert warning.startswith("effects.stribeck_friction: static_torque 0.5 N.m is below")


def test_heavy_springs_with_a_mass_of_their_own_are_not_warned_of(tree: dict[str, Any]) -> None:
    tree["transmission"]["upper_spring"]["mass"] = 1.7
    tree["effects"] = {"spring_mass": {"mass": 1.7}}
    assert parse_model(tree, "heavy").warnings() == []

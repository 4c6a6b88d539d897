"""Fields of a model.toml that are refused, and in which words."""

from copy import deepcopy
from typing import Any

import pytest

from elastic_tendon.actuator.parameters import load_model, parse_model
from elastic_tendon.errors import ModelError


@pytest.fixture
def tree() -> dict[str, Any]:
    """Content of a good model.toml, for each test to spoil."""
    return load_model("biorob_x4_joint_3").model_dump(exclude_none=True)


def spoilt(tree: dict[str, Any], path: str, value: Any) -> dict[str, Any]:
    """Copy with `value` at a dotted path."""
    changed = deepcopy(tree)
    *parents, key = path.split("/")
    table = changed
    for parent in parents:
        table = table[parent]
    table[key] = value
    return changed


def problems_of(content: dict[str, Any]) -> list[str]:
    """Sentences with which a model is refused."""
    with pytest.raises(ModelError) as caught:
        parse_model(content, "bad.toml")
    assert str(caught.value).startswith("bad.toml: ")
    return caught.value.problems


JOINT_RADIUS = "transmission/joint_pulley_radius"
UPPER = "transmission/upper_spring"

BAD_FIELDS: list[tuple[str, Any, str]] = [
    (JOINT_RADIUS, 30.0, "30.0 is outside 0.0005 to 2 m (is it in millimetres?)"),
    (JOINT_RADIUS, -0.03, "-0.03 is outside 0.0005 to 2 m"),
    (JOINT_RADIUS, 0, "0 is outside"),
    (JOINT_RADIUS, "30 mm", "'30 mm' is not a number; a number in m from 0.0005 to 2 is expected"),
    (JOINT_RADIUS, "0.03", "a number in m"),
    (JOINT_RADIUS, True, "True is not a number"),
    (JOINT_RADIUS, float("nan"), "nan is not finite; a number in m"),
    (JOINT_RADIUS, float("inf"), "inf is not finite"),
    (JOINT_RADIUS, 10**400, "..."),
    (JOINT_RADIUS, [0.03], "[0.03] is not a number"),
    (f"{UPPER}/stiffness", 11.58, "11.58 is outside 20 to 1e+08 N/m (is it in kN/m or N/mm?)"),
    (f"{UPPER}/stiffness", -11580.0, "-11580.0 is outside 20 to 1e+08 N/m"),
    (f"{UPPER}/damping", -0.1, "-0.1 is outside 0 to"),
    (f"{UPPER}/max_deflection", 15, "15 is outside 0.0001 to 1 m (is it in millimetres?)"),
    (f"{UPPER}/parallel", 0, "0 is outside 1 to 100"),
    (f"{UPPER}/parallel", 2.0, "2.0 is not a whole number"),
    (f"{UPPER}/parallel", True, "True is not a whole number"),
    (f"{UPPER}/mass", -1.0, "-1.0 is outside 0 to 100 kg"),
    (f"{UPPER}/mass", 250.0, "(is it in grams?)"),
    (f"{UPPER}/max_defection", 0.1, "did you mean max_deflection?"),
    (UPPER, 3.0, "3.0 is not a table; a table [transmission.upper_spring] with stiffness"),
    ("transmission/pretension_force", -1.0, "-1.0 is outside 0 to"),
    ("transmission/pretension_force", 347.5, "347.5 is refused: it is above the 347.4 N"),
    ("link/inertia", 0.0, "0.0 is outside"),
    ("link/inertia", 3e5, "(is it in kg.cm2?)"),
    ("link/damping", -0.16, "-0.16 is outside"),
    ("link/dampling", 0.1, "did you mean damping?"),
    ("name", 3, "3 is not a text"),
    ("name", "", "one line of text"),
    ("nmae", "x", "not known in a model.toml; did you mean name?"),
    ("zzz", "x", "known are name, motion, interface, transmission, link, effects, motor, unc"),
    ("motor", {}, "missing; a number in kg.m2"),
    ("effects", 3, "3 is not a table; a table [effects] with coulomb_friction"),
    ("effects/coulomb_frictoin", {"torque": 1.0}, "did you mean coulomb_friction?"),
    ("effects/magic", {}, "there is no effect 'magic'; choose one of coulomb_friction, stribeck_"),
    ("effects/magic", {}, "loaded by --effect FILE.py, in Python by effects.load"),
    ("effects/joint_stop", {"lower": 1.0, "upper": 1.0}, "lower 1 rad is not below upper 1 rad"),
    ("effects/coulomb_friction", {"torque": -1.0}, "-1.0 is outside 0 to 10000 N.m"),
    ("effects/coulomb_friction", {"torque": "x"}, "'x' is not a number; a number in N.m"),
    ("effects/coulomb_friction", {"torqe": 1.0}, "did you mean torque?"),
    ("effects/coulomb_friction", 0.35, "0.35 is not a table"),
    ("uncertainty", [0.3], "is not a table; a table [uncertainty]"),
    ("uncertainty/link.inertai", 0.3, "did you mean link.inertia?"),
    ("uncertainty/link.inertia", -0.3, "-0.3 is refused"),
    ("uncertainty/link.inertia", "x", "'x' is not a number"),
    ("uncertainty/link.inertia", float("nan"), "nan is not finite"),
    ("uncertainty/effects.coulomb_friction.torque", 0.3, "not known in [uncertainty]"),
    ("uncertainty/transmission.upper_spring.mass", 0.3, "not known in [uncertainty]"),
]


@pytest.mark.parametrize(("path", "value", "fragment"), BAD_FIELDS)
def test_bad_field_is_one_sentence_with_field_value_and_advice(
    tree: dict[str, Any], path: str, value: Any, fragment: str
) -> None:
    (sentence,) = problems_of(spoilt(tree, path, value))
    assert sentence.startswith(path.replace("/", "."))
    assert fragment in sentence
    assert "\n" not in sentence


def test_all_problems_are_told_at_once(tree: dict[str, Any]) -> None:
    for path, value in (
        (JOINT_RADIUS, 30.0),
        (f"{UPPER}/stiffness", "stiff"),
        ("transmission/pretension_force", 500.0),
        ("link/inertai", 1.0),
        ("effects/coulomb_friction", {"torque": -1.0, "torqe": 1.0}),
        ("effects/nothing_of_the_kind", {}),
        ("uncertainty/link.dampig", 1.0),
        ("uncertainty/link.damping", -1.0),
    ):
        tree = spoilt(tree, path, value)
    del tree["link"]["inertia"]
    del tree["name"]
    told = {sentence.split(": ")[0] for sentence in problems_of(tree)}
    assert told == {
        "name",
        "transmission.joint_pulley_radius",
        "transmission.upper_spring.stiffness",
        "transmission.pretension_force",
        "link.inertia",
        "link.inertai",
        "effects.coulomb_friction.torque",
        "effects.coulomb_friction.torqe",
        "effects.nothing_of_the_kind",
        "uncertainty.link.dampig",
        "uncertainty.link.damping",
    }


def test_missing_table_says_what_it_holds(tree: dict[str, Any]) -> None:
    del tree["link"]
    (sentence,) = problems_of(tree)
    assert sentence.startswith("link: missing; a table [link] with ")
    assert sentence.endswith("where another simulator has it, take interface joint or torque_joint")

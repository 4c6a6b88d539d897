"""Columns are found by their names, units and the preparation; doubt is refused."""

from math import pi

import pytest

from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement.columns import Layout, find_layout
from elastic_tendon.measurement.formats import Group
from elastic_tendon.measurement.options import ReadOptions
from elastic_tendon.measurement.preparation import Preparation

BASE = ("time_s", "motor_position_rad")


def prepared(*mapping: str) -> Preparation:
    return ReadOptions(mapping).over(Preparation())


def layout(
    *columns: str, items: tuple[str, ...] = (), units: dict[str, str] | None = None
) -> Layout:
    """Layout of a table with time and motor position beside these columns."""
    group = Group("", (*BASE, *columns), units or {})
    return find_layout([group], prepared(*items), "run.csv")


def joint(found: Layout) -> tuple[str, float, str | None]:
    """Name, factor and unit of the joint position."""
    (column,) = (column for column in found.signals if column.signal == "joint_position")
    return column.name, column.factor, column.prepared.unit


@pytest.mark.parametrize(
    ("name", "factor", "unit"),
    [
        ("joint_position_rad", 1.0, "rad"),
        ("joint_position_deg", pi / 180, "deg"),
        ("joint_position [deg]", pi / 180, "deg"),
        ("joint_position (mrad)", 1e-3, "mrad"),
        ("joint_position[°]", pi / 180, "deg"),
        ("joint_position_arcmin", pi / 180 / 60, "arcmin"),
        ("measured_joint_position_deg", pi / 180, "deg"),
    ],
)
def test_unit_in_the_name(name: str, factor: float, unit: str) -> None:
    assert joint(layout(name)) == (name, pytest.approx(factor), unit)


def test_measured_column_comes_first() -> None:
    found = layout("joint_position_rad", "measured_joint_position_rad")
    assert joint(found)[0] == "measured_joint_position_rad"
    assert found.notes == ("not used: joint_position_rad",)


def test_unit_that_the_file_says() -> None:
    found = layout("joint_position", units={"joint_position": "deg"})
    assert joint(found) == ("joint_position", pytest.approx(pi / 180), "deg")
    assert found.notes == ("joint_position was read from joint_position in deg",)


@pytest.mark.parametrize(
    ("column", "item", "factor"),
    [
        ("enc", "joint_position=enc", 1.0),
        ("enc_deg", "joint_position=enc_deg", pi / 180),
        ("enc [deg]", "joint_position=enc [deg]", pi / 180),
        ("enc_m", "joint_position=enc_m", 1.0),
        ("enc_deg", "joint_position=enc_deg:mrad", 1e-3),
        ("enc", "joint_position=enc:deg*-2", -2 * pi / 180),
        ("joint_position_filtered", "joint_position=joint_position_filtered:deg", pi / 180),
    ],
)
def test_mapped_column(column: str, item: str, factor: float) -> None:
    found = layout(column, items=(item,))
    assert joint(found)[:2] == (column, pytest.approx(factor))


@pytest.mark.parametrize(
    ("columns", "items", "units", "fragment"),
    [
        ((), (), {}, r"no column joint_position_rad \(found: time_s, motor_position_rad\)"),
        (("Joint_Position_rad",), (), {}, r"--map joint_position=Joint_Position_rad$"),
        (("Joint_Position [deg]",), (), {}, r'--map joint_position="Joint_Position \[deg\]"$'),
        # not that of another signal, however near it is
        (("load_torque_Nm",), (), {}, "with --map joint_position=COLUMN$"),
        # with a torque that shows what the joint does, its position may be missing; here it is not
        (
            ("motor_torque_Nm", "Joint_Position_rad"),
            (),
            {},
            r"--map joint_position=Joint_Position_rad$",
        ),
        (
            ("joint_position",),
            (),
            {},
            "which unit it is; say it with --map joint_position=",
        ),
        (("joint_position_mm",), (), {}, "in mm, as of a linear one; give both in units"),
        (("joint_position_count",), (), {}, "'count', which is no unit of angle"),
        (("joint_position [ticks]",), (), {}, "'ticks', which is not known"),
        (("joint_position_filtered",), (), {}, "there is no column joint_position_rad"),
        (("joint_position_rad", "joint_position_deg"), (), {}, "comes twice, as joint_position_"),
        (
            ("joint_position_deg",),
            (),
            {"joint_position_deg": "rad"},
            "in deg by its name and in rad by the file; say which with --map",
        ),
        (("q",), ("joint_position=q:furlong",), {}, "'furlong', which is not known"),
        (("q",), ("joint_position=qq",), {}, "there is no column qq"),
        (
            ("joint_position_rad", "load_torque [N]"),
            (),
            {},
            "in N, as of a linear one; give both in units",
        ),
        (("joint_position_deg_filtered",), (), {}, "=joint_position_deg_filtered:deg$"),
        (("joint_position_filtered",), (), {}, "=joint_position_filtered:UNIT$"),
        (("joint_position_grad",), (), {}, "there is no column joint_position_rad"),
        (("joint_position [grad]",), (), {}, "'grad', which is not known"),
        (("q$ [deg]",), ("joint_position=q",), {}, "--map joint_position=COLUMN$"),
        (("T_MS",), ("joint_position=T_MS", "time=T_MS"), {}, "'MS', which is no unit of time"),
        (("enc",), ("joint_position=enc", "load_torque=enc"), {}, "enc is read as joint_position "),
    ],
)
def test_doubt_is_refused(
    columns: tuple[str, ...], items: tuple[str, ...], units: dict[str, str], fragment: str
) -> None:
    with pytest.raises(MeasurementError, match=fragment) as refused:
        layout(*columns, items=items, units=units)
    assert str(refused.value).startswith("run.csv: ")
    assert "\n" not in str(refused.value)


def test_unused_columns_are_counted_not_listed_for_ever() -> None:
    found = layout("joint_position_rad", *(f"extra{i}" for i in range(40)))
    assert found.notes == (
        "not used: " + ", ".join(f"extra{i}" for i in range(12)) + " and 28 more",
    )


def test_motor_velocity_is_said_not_to_be_used() -> None:
    found = layout("joint_position_rad", "motor_velocity_rad_per_s")
    assert any("motor position is differentiated" in note for note in found.notes)
    assert {column.signal for column in found.signals} == {"motor_position", "joint_position"}


GROUPS = (
    Group("motor", ("time_s", "motor_position_rad")),
    Group("joint", ("stamp", "position", "time_s")),
    Group("spare", ("position",)),
)


def test_signals_of_several_groups_have_their_own_time() -> None:
    preparation = prepared("joint_position=joint/position:deg")
    found = find_layout(GROUPS, preparation, "run.mf4")
    assert {group: column.name for group, column in found.times.items()} == {
        "motor": "time_s",
        "joint": "time_s",
    }
    assert [column.label for column in found.signals] == [
        "motor/motor_position_rad",
        "joint/position",
    ]


def test_time_mapped_in_one_group_is_found_by_name_in_the_others() -> None:
    preparation = prepared("joint_position=joint/position", "time=joint/stamp:ms")
    found = find_layout(GROUPS, preparation, "run.mf4")
    assert found.times["joint"].label == "joint/stamp"
    assert found.times["joint"].factor == 1e-3
    assert found.times["motor"].label == "motor/time_s"
    assert found.times["motor"].factor == 1.0


@pytest.mark.parametrize(
    ("items", "fragment"),
    [
        (("joint_position=position",), "comes twice, as joint/position and spare/position"),
        (("joint_position=spare/position",), "group spare has no column time_s"),
    ],
)
def test_groups_in_doubt(items: tuple[str, ...], fragment: str) -> None:
    with pytest.raises(MeasurementError, match=fragment):
        find_layout(GROUPS, prepared(*items), "run.mf4")


def test_deflection_and_torque_without_time_are_a_static_curve() -> None:
    group = Group("", ("joint_deflection_deg", "joint_torque_mNm"))
    found = find_layout([group], Preparation(), "curve.csv")
    assert found.static
    assert [column.signal for column in found.signals] == ["joint_deflection", "joint_torque"]


def test_static_curve_with_time_and_without_motor_is_refused() -> None:
    group = Group("", ("time_s", "joint_deflection_rad", "joint_torque_Nm"))
    with pytest.raises(MeasurementError, match="beside the time, but no motor position"):
        find_layout([group], Preparation(), "curve.csv")


@pytest.mark.parametrize(
    ("name", "advice"),
    [
        ("Load_Torque_Nm", "load_torque=Load_Torque_Nm"),
        ("load torque [Nm]", 'load_torque="load torque [Nm]"'),
        ("load_torque_Nm_filt", "load_torque=load_torque_Nm_filt:Nm"),
        ("load_torque_act", "load_torque=load_torque_act:UNIT"),
        ("load_torque_in", "load_torque=load_torque_in:UNIT"),
        ("load_torque_L", "load_torque=load_torque_L:UNIT"),
        ("load torque `N`", "load_torque='load torque `N`:UNIT'"),
    ],
)
def test_load_that_is_nearly_named_is_refused(name: str, advice: str) -> None:
    with pytest.raises(MeasurementError, match="simulated without load") as refused:
        layout("joint_position_rad", name)
    assert f"--map {advice}, or rename" in str(refused.value)
    used = layout("joint_position_rad", name, items=(f"joint_torque={name}:Nm",))
    assert "joint_torque" in {column.signal for column in used.signals}


def test_suffix_that_is_no_unit_of_a_signal_makes_another_quantity() -> None:
    found = layout("joint_position_rad", "joint_torque_in", "motor_torque_act")
    assert found.notes == ("not used: joint_torque_in, motor_torque_act",)


def test_unit_that_nobody_says_is_noted_as_assumed() -> None:
    found = layout("enc", items=("joint_position=enc",))
    assert found.notes == ("joint_position was read from enc in rad, assumed",)


@pytest.mark.parametrize("name", ["data[1]", "position[motor]"])
def test_brackets_of_a_place_are_no_unit(name: str) -> None:
    group = Group("", (*BASE, name), bracketed_units=False)
    found = find_layout([group], prepared(f"joint_position={name}"), "run.mcap")
    assert joint(found) == (name, 1.0, "rad")


def test_number_in_brackets_is_no_unit() -> None:
    assert joint(layout("data[1]", items=("joint_position=data[1]",)))[2] == "rad"


def test_a_torque_shows_what_a_joint_does_whose_position_is_missing():
    found = layout("motor_torque_Nm")
    assert {column.signal for column in found.signals} == {"motor_position", "motor_torque"}
    assert any("there is no column joint_position_rad: what moves" in note for note in found.notes)

"""What the robots of a fleet show together, of tables made by hand and of random fleets."""

import numpy as np
import pandas as pd
import pytest

import elastic_tendon as et
from elastic_tendon.estimation.determinability import CONFIDENCE
from elastic_tendon.sweeps.fleet import HIGH, LOW, Robot
from elastic_tendon.sweeps.fleet_findings import pooled

MODEL = et.load_model("biorob_x4_joint_3")
DAMPING, INERTIA, TORQUE = "link.damping", "link.inertia", "effects.coulomb_friction.torque"


def fleet_of(count, **columns):
    """Results of a fleet; robots are called 0, 1, ..."""
    row = et.fleet(MODEL, [Robot("0", ("0.csv",))]).failed(0, "")
    table = pd.concat([row] * count, ignore_index=True)
    return table.assign(robot=[f"{i}" for i in range(count)], verdict="adequate", **columns)


def estimates(path, values, error):
    """Columns of estimates (n,) with one standard error."""
    half = CONFIDENCE * error
    return {path: values, path + LOW: values - half, path + HIGH: values + half}


def with_friction(table, rows, torques):
    table.loc[rows, ["appeared", "verdict"]] = ["coulomb_friction", "missing_effect"]
    table.loc[rows, TORQUE] = torques
    return table


def test_the_answer_is_in_words():
    table = fleet_of(6, **estimates(DAMPING, np.full(6, 0.16), 0.001))
    table = with_friction(table, [1, 4], [0.21, 0.43])
    table.loc[2, ["drifted", "verdict", DAMPING]] = [DAMPING, "wrong_parameter", 0.31]
    table.loc[3, ["verdict", "failure"]] = ["", "3.csv: there is no column"]
    table.loc[5, ["appeared", "verdict"]] = ["unknown: no effect explains it", "unexplained"]
    found = et.fleet_findings(MODEL, table)
    assert f"{found}".splitlines()[:5] == [
        "coulomb_friction appeared: 2 robots (1, 4), torque 0.21 to 0.43 N·m",
        "link.damping drifted: 1 robot (2), now 0.31 N·m·s/rad",
        "no known effect explains what is left: 1 robot (5)",
        "adequate: 1 robot (0)",
        "not diagnosed: 1 robot (3)",
    ]
    assert found.failed == {"3": "3.csv: there is no column"}
    assert found.to_dict()["appeared"][0]["sizes"] == {TORQUE: [0.21, 0.43]}


def test_many_names_are_cut_short():
    found = et.fleet_findings(MODEL, fleet_of(20))
    assert f"{found}" == "adequate: 20 robots (0, 1, 2, 3, 4, 5, 6, 7, ...)"


def test_an_average_by_hand():
    """DerSimonian and Laird: of two with equal errors, half the squared difference less those."""
    mean, half, between = pooled(np.array([1.0, 3.0]), np.array([0.5, 0.5]))
    assert mean == pytest.approx(2.0)
    assert between == pytest.approx(np.sqrt(2.0 - 0.25))
    assert half == pytest.approx(12.7062 * 1.0, rel=1e-4)  # Student's with one degree of freedom


def test_intervals_of_averages_are_honest():
    random = np.random.default_rng(7)
    held = []
    for _ in range(1000):
        errors = random.uniform(0.2, 2.0, 6)
        values = 5.0 + random.standard_normal(6) + errors * random.standard_normal(6)
        mean, half, _ = pooled(values, errors)
        held.append(abs(mean - 5.0) < half)
    assert 0.93 < np.mean(held) < 0.99


def test_what_is_shared_is_averaged_over_those_who_tell_it():
    random = np.random.default_rng(3)
    values = 0.16 * (1.0 + 0.05 * random.standard_normal(40))
    table = fleet_of(40, **estimates(DAMPING, values, 0.001))
    table = table.assign(**estimates(INERTIA, np.full(40, 0.03), 10.0))  # no recording tells it
    found = et.fleet_findings(MODEL, table)
    (shared,) = found.pooled
    assert (shared.path, shared.robots) == (DAMPING, 40)
    assert shared.interval[0] < 0.16 < shared.interval[1]
    assert shared.spread == pytest.approx(0.008, rel=0.3)
    assert found.to_dataframe()["unit"].tolist() == ["N.m.s/rad"]
    assert found.unlike == ()


def test_the_robot_that_contradicts_its_neighbours_is_named():
    random = np.random.default_rng(4)
    values = 0.16 * (1.0 + 0.02 * random.standard_normal(12))
    values[5] = 0.2
    found = et.fleet_findings(MODEL, fleet_of(12, **estimates(DAMPING, values, 0.001)))
    (unlike,) = found.unlike
    assert (unlike.robot, unlike.path, unlike.estimate) == ("5", DAMPING, 0.2)
    assert unlike.expected[0] < 0.16 < unlike.expected[1] < 0.2
    assert "5 is unlike the others: link.damping 0.2, by theirs" in f"{found}"


def test_fleets_of_robots_alike_name_nobody():
    random = np.random.default_rng(5)
    table = fleet_of(20)
    named = 0
    for _ in range(200):
        values = 0.16 * (1.0 + 0.02 * random.standard_normal(20))
        found = et.fleet_findings(MODEL, table.assign(**estimates(DAMPING, values, 0.001)))
        named += bool(found.unlike)
    assert named <= 12  # about 1 % are allowed, and the median scatters more than its formula says


@pytest.fixture(scope="module")
def worn():
    """Thirty robots; friction appeared in those of many hours, and grows with them."""
    hours = np.linspace(0.0, 4000.0, 30)
    old = np.flatnonzero(hours > 1500.0)
    noise = 0.01 * np.random.default_rng(6).standard_normal(len(old))
    return hours, with_friction(fleet_of(30), old, 1e-4 * hours[old] + noise)


@pytest.mark.parametrize("column", ["hours", "built"])
def test_what_grows_with_hours_or_age_is_told(worn, column, tmp_path):
    hours, table = worn
    dates = pd.Timestamp("2026-01-01") - pd.to_timedelta(hours, unit="h")
    known = {"hours": hours, "built": dates.strftime("%Y-%m-%d")}
    path = tmp_path / "robots.csv"
    pd.DataFrame({"robot": table["robot"], column: known[column]}).to_csv(path, index=False)
    found = et.fleet_findings(MODEL, table, path)
    (onset,), (trend,) = found.onsets, found.trends
    assert (onset.effect, trend.path) == ("coulomb_friction", TORQUE)
    sign = 1.0 if column == "hours" else -1.0
    assert np.sign(onset.present - onset.absent) == np.sign(trend.change) == sign
    truth = sign * 1e-4 * np.ptp(hours[hours > 1500.0])
    assert trend.interval[0] < truth < trend.interval[1]
    words = "grows" if sign > 0.0 else "falls"
    assert f"coulomb_friction.torque {words} with {column}: by 0.2" in f"{found}"


def test_what_has_nothing_to_do_with_hours_is_not_told(worn):
    _, table = worn
    random = np.random.default_rng(8)
    for _ in range(50):
        about = pd.DataFrame({"robot": table["robot"], "hours": random.uniform(0, 1, 30)})
        found = et.fleet_findings(MODEL, table, about)
        assert found.trends == found.onsets == ()


@pytest.mark.parametrize(
    ("about", "words"),
    [
        ({"name": ["0"]}, r"no column robot \(found: name\); add it"),
        ({"robot": ["0", "0"]}, "two rows for 0; keep one"),
        ({"robot": ["0"]}, "no row for 1; add it"),
    ],
)
def test_what_is_known_of_robots_is_checked(about, words):
    with pytest.raises(et.MeasurementError, match=words):
        et.fleet_findings(MODEL, fleet_of(2), pd.DataFrame(about))


def test_a_file_that_is_no_table_is_refused(tmp_path):
    with pytest.raises(et.MeasurementError, match=r"none\.csv: No such file"):
        et.fleet_findings(MODEL, fleet_of(2), tmp_path / "none.csv")
    (tmp_path / "x.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(et.MeasurementError, match=r"x\.csv: this is no CSV table"):
        et.fleet_findings(MODEL, fleet_of(2), tmp_path / "x.csv")

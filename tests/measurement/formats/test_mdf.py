"""MDF channel groups come back with their rates, units and time."""

from pathlib import Path

import numpy as np
import pytest
from asammdf import MDF, Signal
from asammdf.blocks.mdf_v3 import MDF3
from asammdf.blocks.mdf_v4 import MDF4
from whole import assert_refused, group_named, truncated, whole

from elastic_tendon.measurement.formats import mdf, open_source
from elastic_tendon.progress import silent

FAST, SLOW = np.arange(2000) * 0.001, np.arange(300) * 0.01


@pytest.fixture(params=["4.10", "3.30"])
def path(request, tmp_path: Path) -> Path:
    with MDF(version=request.param) as file:
        motor = Signal(np.sin(FAST), FAST, unit="deg", name="motor")
        count = Signal(np.arange(2000, dtype=np.int16), FAST, name="count")
        scale = {"a": 0.5, "b": 1.0}
        raw = Signal(np.arange(300, dtype=np.uint8), SLOW, unit="Nm", name="tau", conversion=scale)
        file.append([motor, count], acq_name="bench")
        file.append(raw)
        written = file.save(tmp_path / "run.mf4", overwrite=True)
    return Path(written)


def test_groups_rates_units_and_conversions(path: Path, monkeypatch) -> None:
    monkeypatch.setattr(mdf, "_FRAGMENT", 4000)
    source = open_source(path)
    fast, slow = source.groups
    assert (fast.rows, slow.rows) == (2000, 300)
    assert fast.columns == ("time_s", "motor", "count")
    assert fast.units == {"time_s": "s", "motor": "deg"}
    assert slow.units == {"time_s": "s", "tau": "Nm"}
    assert len(list(source.read(fast.name, ["count"], silent))) > 3
    table = whole(source, fast.name)
    assert np.allclose(table["time_s"], FAST, atol=1e-12)
    assert np.array_equal(table["motor"], np.sin(FAST))
    assert np.array_equal(table["count"], np.arange(2000.0))
    expected = 0.5 * np.arange(300, dtype=np.uint8) + 1.0
    assert np.array_equal(whole(source, slow.name)["tau"], expected)


def test_a_group_has_its_acquisitions_name(tmp_path: Path) -> None:
    with MDF(version="4.10") as file:
        file.append(Signal(FAST, FAST, name="q"), acq_name="bench")
        file.append(Signal(SLOW, SLOW, name="q"), acq_name="bench")
        written = Path(file.save(tmp_path / "run.mf4"))
    assert [group.name for group in open_source(written).groups] == ["bench", "group 1"]


def test_samples_marked_invalid_are_nan(tmp_path: Path) -> None:
    invalid = np.zeros(300, dtype=bool)
    invalid[[3, 50]] = True
    signal = Signal(SLOW + 1.0, SLOW, name="q", invalidation_bits=invalid)
    with MDF(version="4.10") as file:
        file.append(signal, acq_name="bench")
        written = Path(file.save(tmp_path / "run.mf4"))
    source = open_source(written)
    assert group_named(source, "bench").rows == 300
    assert np.flatnonzero(np.isnan(whole(source, "bench")["q"])).tolist() == [3, 50]


@pytest.mark.parametrize("share", [0.02, 0.3, 0.9])
def test_a_truncated_file_is_refused(path: Path, share: float) -> None:
    assert_refused(truncated(path, share), "MDF file is damaged or not complete")


def test_damage_leaves_other_files_of_the_library_as_they_are(path: Path) -> None:
    closing = MDF4.__del__, MDF3.__del__, MDF4.close, MDF3.close
    assert_refused(truncated(path, 0.9), "MDF file is damaged or not complete")
    assert closing == (MDF4.__del__, MDF3.__del__, MDF4.close, MDF3.close)
    assert MDF4.__del__.__module__ == "asammdf.blocks.mdf_v4"

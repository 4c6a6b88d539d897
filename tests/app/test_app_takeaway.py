"""What the step Take away builds: files that are what they say, under names that are safe."""

import html
import json
import tomllib
import zipfile
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.io import loadmat

pytest.importorskip("dash")

from elastic_tendon import demo
from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.app import takeaway
from elastic_tendon.app.document import Document, Source, Version, new_document
from elastic_tendon.app.server import dash_app
from elastic_tendon.app.steps.take_away import GONE, OFFERS, offered
from elastic_tendon.app.takeaway import Built, Depot, FmuChoice
from elastic_tendon.app.uploads import size_in_words
from elastic_tendon.app.workspace import Cache, Failure, Workspace
from elastic_tendon.errors import BuildError, ElasticTendonError
from elastic_tendon.measurement.reader import read_measurements

FILES = {"fit": demo.DATA / "demo_fit.csv", "validate": demo.DATA / "demo_validate.csv"}
RUDE = "<b>\n\x07 ../x"
MODEL = load_model(demo.DATA / "demo_model.toml")
HEAVIER = MODEL.with_values({"link.inertia": 0.04})


def quiet(_words: str, _share: float) -> None:
    pass


def document(name: str = "demo_fit.csv") -> Document:
    sources = [
        Source(key="fit", name=name),
        Source(key="validate", name="demo_validate.csv", role="validate"),
    ]
    return new_document(MODEL, sources).adding(
        Version(id="", parent="1", title="made heavier", model=HEAVIER.to_toml())
    )


@pytest.fixture
def depot() -> Iterator[Depot]:
    workspace = Workspace(document(), FILES)
    yield Depot(workspace)
    workspace.close()


def members(built: Built) -> dict[str, bytes]:
    with zipfile.ZipFile(built.path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def test_a_model_says_how_it_came_about(depot: Depot) -> None:
    built = takeaway.model_file(document(RUDE), FILES, depot).compute(Cache(), quiet)
    text = built.path.read_text()
    assert "# steps: as given → made heavier\n" in text
    assert "# fitted: <b>\N{REPLACEMENT CHARACTER}\N{REPLACEMENT CHARACTER} ../x\n" in text
    assert "# held out: demo_validate.csv\n" in text
    assert tomllib.loads(text)["link"]["inertia"] == 0.04
    assert load_model(built.path) == HEAVIER


def test_linear_models_are_those_before_and_after(depot: Depot) -> None:
    found = members(takeaway.linear(document(), depot).compute(Cache(), quiet))
    assert set(found) == {"before.json", "before.mat", "after.json", "after.mat"}
    poles = [
        [
            linear_model["analysis"]["poles"]
            for linear_model in json.loads(found[f"{label}.json"])["models"]
        ]
        for label in ("before", "after")
    ]
    assert len(poles[0]) == 3
    assert poles[0] != poles[1]
    assert set(loadmat(BytesIO(found["after.mat"]))) >= {"state_I", "state_II", "state_III"}


def test_a_recording_is_handed_out_beside_its_simulations(depot: Depot, tmp_path: Path) -> None:
    found = members(takeaway.data(document(), FILES, depot).compute(Cache(), quiet))
    (name,) = (name for name in found if name.startswith("recordings/") and "demo_fit" in name)
    table = pd.read_csv(BytesIO(found[name]))
    error = table["simulated_joint_position_rad"] - table["measured_joint_position_rad"]
    np.testing.assert_allclose(table["error_joint_position_rad"], error, atol=1e-12)
    given = table["as_given_error_joint_position_rad"]
    assert np.std(given - error) > 1e-3
    # what was measured can be read again, and is what it was
    (tmp_path / "again.csv").write_bytes(found[name])
    (again,) = read_measurements(str(tmp_path / "again.csv"))
    (once,) = read_measurements(str(FILES["fit"]))
    np.testing.assert_array_equal(again.signals["joint_position"], once.signals["joint_position"])
    np.testing.assert_array_equal(again.load_torque, once.load_torque)


def test_every_figure_comes_with_units(depot: Depot) -> None:
    found = members(takeaway.data(document("../<b>.csv"), FILES, depot).compute(Cache(), quiet))
    figures = {
        name: pd.read_csv(BytesIO(text)) for name, text in found.items() if "figures/" in name
    }
    words = "characteristic joint_position torque_loop missing_torque error_maps shares ladder"
    assert all(any(word in name for name in figures) for word in words.split())
    assert all(".." not in name and "<" not in name for name in found)
    assert all(any("(" in column for column in table.columns) for table in figures.values())


def test_the_numbers_are_those_of_the_comparison(depot: Depot) -> None:
    built = takeaway.findings(document(), FILES, depot).compute(Cache(), quiet)
    content = json.loads(built.path.read_text())
    assert content["schema"] == "elastic-tendon/comparison/1"
    assert [file["name"] for file in content["files"]] == ["demo_fit.csv"]
    assert str(depot.find(built.key).path.parent) not in built.path.read_text()


@pytest.mark.parametrize(
    ("version", "command"),
    [
        ("1", "elastic-tendon compare demo_actuator.toml 'a b.csv'"),
        (
            "2",
            "elastic-tendon app demo_actuator.toml 'a b.csv' --validate demo_validate.csv  "
            "# demo_actuator.toml: as given; on the page: made heavier",
        ),
    ],
)
def test_a_report_says_how_to_come_to_the_same(depot: Depot, version: str, command: str) -> None:
    chosen = document("a b.csv").at(version)
    built = takeaway.report_page(chosen, FILES, depot).compute(Cache(), quiet)
    text = html.unescape(built.path.read_text())
    assert command in text
    assert str(FILES["fit"]) not in text


def test_an_fmu_needs_a_platform(depot: Depot) -> None:
    with pytest.raises(BuildError, match="choose at least one"):
        takeaway.fmu(document(), FmuChoice(), depot).compute(Cache(), quiet)


def test_without_data_there_is_still_a_model(depot: Depot) -> None:
    bare, cache = new_document(MODEL), Cache()
    assert takeaway.model_file(bare, {}, depot).compute(cache, quiet).size > 100
    for make in (takeaway.data, takeaway.findings, takeaway.report_page):
        result = make(bare, {}, depot)
        with pytest.raises(ElasticTendonError, match="no recording is fitted"):
            cache.obtain(result, quiet)
        assert isinstance(cache.find(result), Failure)


def test_other_choices_are_other_files(depot: Depot) -> None:
    fitted = document()
    keys = [
        found.key
        for each in (
            fitted,
            fitted.at("1"),
            fitted.renamed("2", "otherwise"),
            fitted.with_source("fit", role="off"),
        )
        for choice in (FmuChoice(), FmuChoice(3))
        for found in offered(each, FILES, choice, depot).values()
    ]
    assert len(OFFERS) == len(offered(fitted, FILES, FmuChoice(), depot))
    # all but the FMU are the same for both choices
    assert len(set(keys)) == 4 * (len(OFFERS) + 1)


def test_files_go_when_nobody_keeps_them(depot: Depot) -> None:
    built = depot.build("x.toml", lambda path: path.write_text("kept"))
    key, path = built.key, built.path
    assert depot.find(key) is built
    assert path.read_text() == "kept"
    del built
    assert depot.find(key) is None
    assert not path.exists()


def test_a_file_that_is_gone_is_told_in_a_sentence() -> None:
    workspace = Workspace(document(), FILES)
    client = dash_app(workspace, "token").server.test_client()
    answer = client.get("/token/file/unknown")
    workspace.close()
    assert (answer.status_code, answer.text) == (404, f"{GONE}\n")


def test_what_was_stopped_leaves_no_file(depot: Depot) -> None:
    seen: list[Path] = []

    def write(path: Path) -> None:
        path.write_text("half")
        seen.append(path)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        depot.build("x.csv", write)
    assert not seen[0].exists()


@pytest.mark.parametrize(
    ("text", "safe"),
    [("run.csv[0:5]", "run_csv_0_5"), ("../../etc", "etc"), ("<b>", "b"), ("…", "unnamed")],
)
def test_names_in_archives_are_letters(text: str, safe: str) -> None:
    assert takeaway.safe_name(text) == safe


@pytest.mark.parametrize(
    ("size", "words"),
    [(490, "490 bytes"), (3396, "3.3 kB"), (10_200, "10 kB"), (25 << 20, "25 MB")],
)
def test_sizes_are_told_for_people(size: int, words: str) -> None:
    assert size_in_words(size) == words

"""Files on the page: each is read for itself, and what is wrong with one is told beside it."""

from pathlib import Path

import pytest

from elastic_tendon.progress import silent

pytest.importorskip("dash")

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.app import results, uploads
from elastic_tendon.app.document import Document, Source, new_document
from elastic_tendon.app.source_card import Form, card, facts, findings, overview
from elastic_tendon.app.steps.data import STEP, changes, mark, seen, summary
from elastic_tendon.app.uploads import check_harmless, content_of
from elastic_tendon.app.workspace import CANCELLED, Failure, Session
from elastic_tendon.demo import DATA
from elastic_tendon.errors import ElasticTendonError, MeasurementError
from elastic_tendon.reports.interactive.theme import LIGHT

GOOD = Source(key="good", name="fit.csv")


def opened(tmp_path: Path, *sources: Source, **contents: str) -> Session:
    """A session in which all that the step needs was computed, as far as it can be."""
    files = {"good": DATA / "demo_fit.csv"}
    for key, content in contents.items():
        files[key] = tmp_path / f"server-{key}"
        files[key].write_text(content)
    document = new_document(load_model(DATA / "demo_model.toml"), sources)
    session = Session("1", document, files)
    compute(session)
    return session


def compute(session: Session) -> None:
    for result in STEP.needs(session.document, session.files):
        try:
            session.cache.obtain(result, silent)
        except ElasticTendonError:
            continue  # kept in the cache


def test_a_bad_file_is_told_by_its_own_name_and_the_others_are_read(tmp_path: Path) -> None:
    bad = Source(key="bad", name="<b>mine</b>.csv")
    session = opened(tmp_path, bad, GOOD, bad="time_s,colour\n0,1\n1,2\n")
    wrong, right = (seen(session, source) for source in (bad, GOOD))
    assert wrong.sentence().startswith("<b>mine</b>.csv: there is no column motor_position_rad")
    assert "server-bad" not in wrong.sentence()
    assert wrong.columns == ("time_s", "colour")
    assert "are the motor position and the joint position; choose them below" in wrong.fault()
    rows = overview(wrong, LIGHT)[0].children[0].children[1].children
    assert [cell.children for cell in rows[1].children] == ["colour", "1", "2"]
    assert right.sentence() == ""
    assert facts(right) == "5000 samples, 10.0 s at 500 Hz"
    assert summary(session) == "1 recording is fitted; none validates."
    alone = session.document.with_sources([GOOD])
    assert session.document.data_key() != alone.data_key()  # nobody knew
    results.judge_files(session)
    left_out = session.document.sources[0].left_out
    assert left_out.startswith("<b>mine</b>.csv is left out: there is no column motor_position_rad")
    assert session.document.data_key() == alone.data_key()
    assert results.as_used(session.document, session.files, session.cache).sources == (GOOD,)
    again = session.document.with_source("bad", mapping=("motor_position=colour",))
    assert again.data_key() not in (session.document.data_key(), alone.data_key())


def test_nothing_is_compared_without_a_good_file(tmp_path: Path) -> None:
    session = opened(tmp_path, Source(key="bad", name="bad.csv"), bad="time_s,colour\n0,1\n1,2\n")
    assert summary(session).startswith("No file that is to be fitted can be used as it is")


def test_a_file_whose_reading_was_cancelled_is_not_left_out() -> None:
    other = Source(key="other", name="other.csv")
    document = new_document(load_model(DATA / "demo_model.toml"), [GOOD, other])
    session = Session("1", document, {"good": DATA / "demo_fit.csv"})
    session.cache.put(results.checked(document, other, session.files), Failure(CANCELLED))
    with pytest.raises(ElasticTendonError, match=CANCELLED):
        session.cache.obtain(results.data(document, session.files), silent)
    results.judge_files(session)
    assert session.document == document


def test_a_file_is_mended_on_the_page(tmp_path: Path) -> None:
    text = (DATA / "demo_fit.csv").read_text()
    text = text.replace("motor_position_rad", "m", 1).replace("joint_position_rad", "j", 1)
    session = opened(tmp_path, Source(key="mine", name="mine.csv"), mine=text)
    for signal, column in (("motor_position", "m"), ("joint_position", "j")):
        known = seen(session, session.document.sources[0])
        assert known.sentence()
        new = changes(known, "column", signal, column)
        session.change(lambda document, new=new: document.with_source("mine", **new))
        compute(session)
    known = seen(session, session.document.sources[0])
    assert known.sentence() == ""
    assert [row.column for row in known.rows()[1:3]] == ["m", "j"]
    assert summary(session) == "1 recording is fitted; none validates."


def test_what_looks_misread_can_be_taken_as_declared(tmp_path: Path) -> None:
    source = GOOD.changed(mapping=("joint_position=joint_position_rad:deg",))
    session = opened(tmp_path, source)
    known = seen(session, source)
    assert known.sentence().endswith("; if the file is right, add --as-declared")
    assert '"as_declared"' in "".join(map(str, form_of(known).structure))
    assert [offer.items for offer in known.offers()] == [("joint_position=joint_position_rad:rad",)]
    insisted = source.changed(**changes(known, "as_declared", "", ["yes"]))
    session.change(lambda document: document.with_sources([insisted]))
    compute(session)
    known = seen(session, insisted)
    assert known.sentence() == ""
    assert len(findings(known)) > len(findings(seen(opened(tmp_path, GOOD), GOOD)))


def form_of(known) -> Form:
    form = Form()
    card(known, form)
    return form


def test_a_new_split_leaves_most_to_be_fitted_and_one_too_late_is_told(tmp_path: Path) -> None:
    session = opened(tmp_path, GOOD)
    new = changes(seen(session, GOOD), "role", "", "split")
    assert new["split"] == pytest.approx(7.0, abs=0.01)
    late = GOOD.model_copy(update={"role": "split", "split": 99.0})
    session.change(lambda document: document.with_sources([late]))
    compute(session)
    assert "the window holds 0 samples" in seen(session, late).sentence()


def test_fields_are_made_anew_only_where_they_change(tmp_path: Path) -> None:
    before = form_of(seen(opened(tmp_path, GOOD), GOOD))
    later = GOOD.model_copy(update={"window": (2.0, None)})
    after = form_of(seen(opened(tmp_path, later), later))
    assert mark(before.structure) == mark(after.structure)
    assert before.shown != after.shown
    split = GOOD.model_copy(update={"role": "split", "split": 5.0})
    assert mark(form_of(seen(opened(tmp_path, split), split)).structure) != mark(before.structure)


def test_noise_and_what_no_column_tells_are_findings(tmp_path: Path) -> None:
    known = seen(opened(tmp_path, GOOD), GOOD)
    told = findings(known)
    assert told[0].startswith("Noise of the joint position: 0.2")
    assert "There is no measured torque: only the joint position tests the model." in told
    drawn, _ = overview(known, LIGHT)
    graph, _ = drawn.children
    assert [trace.name for trace in graph.figure.data] == [
        *("motor position", "joint position", "load torque"),
    ]


def test_without_data_the_step_says_what_a_file_needs(tmp_path: Path) -> None:
    session = opened(tmp_path)
    assert STEP.needs(session.document, session.files) == []
    assert summary(session).startswith("There are no data yet.")


def test_a_file_that_crashes_its_reader_is_refused(tmp_path: Path, monkeypatch) -> None:
    path = tmp_path / "key"
    path.write_bytes(b"MATLAB 5.0 MAT-file" + bytes(200))
    check_harmless(path, "run.mat")  # damaged, but nothing crashes
    monkeypatch.setattr(uploads, "_TRY", "import os; os.abort()")
    with pytest.raises(MeasurementError, match=r"^run\.mat: the file is damaged; export it again$"):
        check_harmless(path, "run.mat")


def test_an_upload_is_taken_whole_or_refused() -> None:
    assert content_of("data:text/csv;base64,YWJj", "a.csv", 3) == b"abc"
    with pytest.raises(
        ElasticTendonError, match=r"larger than 2\.0 MB; name it on the command line"
    ):
        content_of("data:;base64," + "A" * 2**22, "a.csv", 2**21)
    with pytest.raises(ElasticTendonError, match=r"a\.csv: it did not arrive whole"):
        content_of("data:text/csv;base64,YW?", "a.csv", 3)


def test_a_file_that_the_server_lost_is_told() -> None:
    document: Document = new_document(load_model("figure_7"), [Source(key="x", name="lost.csv")])
    session = Session("1", document, {})
    with pytest.raises(MeasurementError, match=r"lost\.csv: the app holds it no longer"):
        session.cache.obtain(results.contents(document.sources[0], {}), silent)

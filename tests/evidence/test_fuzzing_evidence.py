"""Changed evidence gives a result or one sentence; `build_scripts/fuzz_evidence.py` tries more."""

from random import Random

import pytest
from evidence_cases import packed

import elastic_tendon as et
from elastic_tendon.evidence.experiment import from_csv
from elastic_tendon.evidence.manifest import MANIFEST, Related, manifest
from elastic_tendon.evidence.parameter_set import read_values
from elastic_tendon.evidence.verify import read_fmu
from fuzz_evidence import Subject, changed, finding, read_one, readers, verify_one


@pytest.fixture(scope="module")
def subject(sealed):
    """The FMU for FMI 2.0."""
    return Subject(*read_fmu(sealed(2)))


def test_readers_answer_every_change(subject) -> None:
    assert [found for number in range(3000) if (found := read_one(subject, number))] == []


def test_verify_answers_every_change(subject, tmp_path) -> None:
    path = tmp_path / "x.fmu"
    assert [found for number in range(60) if (found := verify_one(subject, number, path))] == []


def test_changes_get_past_the_first_check(subject) -> None:
    """Of each reader's, some are still read."""
    for name, read in readers(subject).items():
        contents = (changed(Random(number), name, subject.files[name]) for number in range(100))
        altered = [content for content in contents if content != subject.files[name]]
        assert len(altered) > 50
        answers = []
        for content in altered:
            try:
                answers.append(bool(read(content)))
            except et.EvidenceError:
                answers.append(False)
        assert any(answers), name


@pytest.mark.parametrize("wrong", [KeyError("x"), et.EvidenceError(""), et.EvidenceError("a\nb")])
def test_what_is_no_sentence_is_found(wrong) -> None:
    def read():
        raise wrong

    assert finding(read)


def test_what_fuzzing_found_is_one_sentence(subject, tmp_path) -> None:
    """Encodings that there are not, addresses that are none, lines in names, tables of no row."""
    with pytest.raises(et.EvidenceError, match="x is no XML"):
        read_values(b'<?xml version="1.0" encoding="ut-1f-8"?><a/>', "x")
    with pytest.raises(et.EvidenceError, match="a table with the columns time is expected"):
        from_csv(b"time\n", "x.csv")
    path = tmp_path / "x.fmu"
    plain = {"modelDescription.xml": subject.files["modelDescription.xml"]}
    packed(path, plain | {MANIFEST: manifest([Related("http://[", "text/csv", "experiment")])})
    with pytest.raises(et.EvidenceError, match="no address of a file"):
        et.verify(path)
    packed(path, plain | {MANIFEST: manifest([Related("a\nb", "text/csv", "experiment")])})
    assert et.verify(path).faults == ("a b is listed and missing",)

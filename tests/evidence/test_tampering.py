"""Whatever is changed in an FMU with evidence, verify says so."""

import json
import re
import struct

import pytest
from evidence_cases import contents, entry, packed, resealed

import elastic_tendon as et
from elastic_tendon.evidence.gather import PARAMETERS, REPORT
from elastic_tendon.evidence.manifest import FOLDER, MANIFEST
from elastic_tendon.evidence.seal import SEAL

BINARY = "binaries/linux64/demo_actuator.so"


def _replaced(name, old, new):
    """Replace text in one file, hashes left as they are."""

    def tamper(path, files, _keys):
        changed = re.sub(old, new, files[name], count=1)
        assert changed != files[name]
        return packed(path, files | {name: changed})

    return tamper


def _without(name):
    return lambda path, files, _keys: packed(
        path, {one: content for one, content in files.items() if one != name}
    )


def _bytes(change):
    """Change the bytes of the archive itself."""

    def tamper(path, _files, _keys):
        whole = bytearray(path.read_bytes())
        change(whole)
        return bytes(whole)

    return tamper


def _flip(whole, at, bit=0):
    whole[at] ^= 1 << bit


def _binary_flipped(path, files, _keys):
    code = bytearray(files[BINARY])
    code[len(code) // 2] ^= 1
    return packed(path, files | {BINARY: bytes(code)})


def _resealed(name, old, new, key=None):
    """Replace text and make new hashes, without a signature or with another's."""

    def tamper(path, files, keys):
        changed = {**files, name: re.sub(old, new, files[name], count=1)}
        report = changed[REPORT]
        if key is None:  # who covers their tracks also takes out that it was signed
            report = re.sub(rb'"signed_by": "\w+"', b'"signed_by": null', report)
        assert changed[name] != files[name]
        return resealed(path, {**changed, REPORT: report}, keys[key] if key else None)

    return tamper


def _stripped(path, files, _keys):
    seal = json.loads(files[SEAL]) | {"signature": None}
    return packed(path, files | {SEAL: json.dumps(seal, sort_keys=True, indent=0).encode() + b"\n"})


def _signed_by_another(path, files, keys):
    return resealed(path, files, keys["theirs"])


def _taken_from_another(path, files, keys):
    """The seal of another FMU that its maker has signed too."""
    other = resealed(path, {**files, "resources/x": b""}, keys["ours"])
    path.write_bytes(other)
    return packed(path, {**files, SEAL: contents(path)[SEAL]})


TAMPERINGS = {
    "a bit of the binary": _binary_flipped,
    "a start value": _replaced("modelDescription.xml", rb'start="0\.3499', b'start="0.4499'),
    "a unit": _replaced("modelDescription.xml", rb"N\.m\.s/rad", b"N.m.s/deg"),
    "a measured value": _replaced(f"{FOLDER}recording_1_measured.csv", rb"0\.002,", b"0.003,"),
    "an input": _replaced(f"{FOLDER}recording_2_inputs.csv", rb"\n0\.5,", b"\n0.51,"),
    "a reference result": _replaced(f"{FOLDER}smoke_test_results.csv", rb"\n0\.5,", b"\n0.51,"),
    "an error": _replaced(REPORT, rb'"rmse": 0', b'"rmse": 1'),
    "a tolerance": _replaced(REPORT, rb"e-05", b"e-01"),
    "the range": _replaced(REPORT, rb'("joint_velocity": \[\s+-)', rb"\g<1>1"),
    "the verdict": _replaced(REPORT, b"missing_effect", b"adequate"),
    "the date": _replaced(REPORT, rb'"date": "\d{4}', b'"date": "2001'),
    "a stated parameter": _replaced(PARAMETERS, rb'value="0\.3499', b'value="0.3599'),
    "the covariance": _replaced(PARAMETERS, b"<row>", b"<row>1"),
    "the manifest": _replaced(MANIFEST, rb'role="result"', b'role="report"'),
    "a file put in": lambda path, files, _: packed(path, files | {"resources/x": b""}),
    "a file taken out": _without(f"{FOLDER}recording_1_measured.csv"),
    "the documentation": _replaced("documentation/index.html", b"</", b" </"),
    "the licence": _without("documentation/licenses/license.txt"),
    "the report taken out": _without(REPORT),
    "the seal taken out": _without(SEAL),
    "the signature stripped": _stripped,
    "signed by another": _signed_by_another,
    "a seal of another": _taken_from_another,
    "a signature's digit": _replaced(
        SEAL, rb'("value": ")(\w)', lambda found: found[1] + (b"1" if found[2] == b"0" else b"0")
    ),
    "the seal's layout": _replaced(SEAL, b"\n", b"\n\n"),
    "packed anew": lambda path, files, _: packed(path, files),
    "a file's time": _bytes(lambda whole: _flip(whole, entry(whole, BINARY) + 10)),
    "the table of contents": _bytes(lambda whole: _flip(whole, whole.rindex(b"PK\1\2") + 38)),
    "the archive's comment": _bytes(
        lambda whole: whole.__setitem__(slice(-2, None), struct.pack("<H", 2) + b"no")
    ),
    "bytes behind it": _bytes(lambda whole: whole.extend(b"\0")),
    "bytes before it": _bytes(lambda whole: whole.__setitem__(slice(0, 0), b"\0")),
    "cut off": _bytes(lambda whole: whole.__delitem__(slice(-100, None))),
}
# by who makes all hashes anew: what the FMU does gives it away
COVERED = {
    "another binary's numbers": _resealed(
        f"{FOLDER}smoke_test_results.csv", rb"\n3\.0,0\.0", b"\n3.0,0.1"
    ),
    "a better error": _resealed(REPORT, rb'"rmse": 0\.0002', b'"rmse": 0.0001'),
    "another parameter": _resealed(PARAMETERS, rb'value="0\.3499', b'value="0.3599'),
    "another's binary": _resealed("modelDescription.xml", rb'guid="\{\w', b'guid="{x'),
}


def _found(tampered, path, **options) -> str:
    path.write_bytes(tampered)
    try:
        found = et.verify(path, **options)
    except et.EvidenceError as error:
        return str(error)
    assert found.passed == (not found.faults)
    return "; ".join(found.faults)


@pytest.mark.parametrize("tampering", [*TAMPERINGS, *COVERED])
def test_it_is_found(tampering, sealed, keys, tmp_path) -> None:
    path = tmp_path / "x.fmu"
    path.write_bytes(sealed(2).read_bytes())
    change = (TAMPERINGS | COVERED)[tampering]
    tampered = change(path, contents(path), keys)
    told = _found(tampered, path)
    if tampering == "packed anew":
        assert told == "the archive was packed anew or changed between its files"
    assert told
    assert "\n" not in told
    assert "Traceback" not in told


def test_twenty_and_more_were_tried() -> None:
    assert len(TAMPERINGS) + len(COVERED) >= 20


def test_who_makes_all_anew_has_not_the_key(sealed, keys, tmp_path) -> None:
    """Without the key the FMU holds together, and is not signed by whom it was asked for."""
    path = tmp_path / "x.fmu"
    path.write_bytes(sealed(2).read_bytes())
    files = contents(path)
    anew = _resealed("documentation/index.html", b"</", b" </")(path, files, keys)
    assert _found(anew, path) == ""
    told = _found(anew, path, public_key=keys["ours"].with_suffix(".pub"))
    assert told == "it is not signed, and a signature was asked for"
    told = _found(_signed_by_another(path, files, keys), path)
    assert told == "it was signed, and the signature was taken out or replaced"


def test_every_byte_counts(sealed, tmp_path) -> None:
    """A bit flipped at 150 places all over the archive, and at every place of its end."""
    whole = sealed(2).read_bytes()
    path = tmp_path / "x.fmu"
    places = [*range(0, len(whole), len(whole) // 150), *range(len(whole) - 60, len(whole))]
    for count, at in enumerate(places):
        flipped = bytearray(whole)
        _flip(flipped, at, count % 8)
        assert _found(bytes(flipped), path), at

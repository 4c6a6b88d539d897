"""Random changes of what `verify` reads; every answer has to be a result or one sentence.

    python build_scripts/fuzz_evidence.py [--changes 1000000] [--whole 10000] [--first 0]

Changes go by the structure of the content: elements and attributes of XML, nodes of JSON, cells of
tables, and bytes of anything. `--changes` of them are read by the reader of their kind alone (sets
of parameters, manifests, tables, seals); `--whole` are packed into an FMU, sealed anew or not, and
verified. A change follows from its number, from `--first` on. Exit status: 0 nothing found, 1 a
finding, which is printed with its number.
"""

import argparse
import json
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import Any
from xml.etree import ElementTree

import elastic_tendon as et
from elastic_tendon.evidence.experiment import from_csv
from elastic_tendon.evidence.gather import PARAMETERS, REPORT
from elastic_tendon.evidence.manifest import FOLDER, MANIFEST, read_manifest
from elastic_tendon.evidence.parameter_set import read_values
from elastic_tendon.evidence.seal import SEAL, add_seal, check_seal
from elastic_tendon.evidence.verify import read_fmu
from elastic_tendon.fmu.packing import write_archive

TABLE = f"{FOLDER}smoke_test_inputs.csv"
DESCRIPTION = "modelDescription.xml"
ODD = (
    *("", "nan", "inf", "-1e999", "1e308", "5e-324", "-1", "0", "1_0", "9" * 400, "True", "null"),
    *("\0", "é\udcff", "a\nb", "<", "&x;", "%s", "../../x", "http://[", "file:///x", "[]", "{"),
)
VALUES: tuple[Any, ...] = (None, True, 0, -1, 10**400, float("nan"), 1e308, [], {}, [[]], *ODD)

Reader = Callable[[bytes], object]


# ---- changes -------------------------------------------------------------------------------


def _bytes(draw: Random, content: bytes) -> bytes:
    changed = bytearray(content)
    at, length = draw.randrange(len(content) + 1), draw.choice((1, 2, 8, 100))
    match draw.randrange(4):
        case 0 if at < len(changed):
            changed[at] ^= 1 << draw.randrange(8)
        case 1:
            del changed[at : at + length]
        case 2:
            changed[at:at] = changed[at : at + length]
        case _:
            changed[at:at] = draw.choice(ODD).encode(errors="surrogatepass")
    return bytes(changed)


def _xml(draw: Random, content: bytes) -> bytes:
    try:
        root = ElementTree.fromstring(content)
    except ElementTree.ParseError:  # by an earlier change
        return _bytes(draw, content)
    element, other = draw.choices([*root.iter()], k=2)
    match draw.randrange(6):
        case 0 if len(element):
            element.remove(draw.choice(element))
        case 1 if element not in other.iter():
            element.append(other)
        case 2 if element.attrib:
            element.set(draw.choice([*element.attrib]), draw.choice(ODD))
        case 3 if element.attrib:
            del element.attrib[draw.choice([*element.attrib])]
        case 4:
            element.tag = draw.choice((other.tag, "x", "{x}y"))
        case _:
            element.text = draw.choice(ODD)
    return ElementTree.tostring(root).replace(b"\0", b"&#1;")


def _json(draw: Random, content: bytes) -> bytes:
    root = node = json.loads(content)
    while True:
        keys: list[Any] = [*node] if isinstance(node, dict) else [*range(len(node))]
        if not keys:
            break
        key = draw.choice(keys)
        inside = node[key]
        if isinstance(inside, (dict, list)) and draw.random() < 0.8:
            node = inside
            continue
        if draw.randrange(3):
            node[key] = draw.choice(VALUES)
        else:
            del node[key]
        break
    return json.dumps(root, indent=1).encode()


def _table(draw: Random, content: bytes) -> bytes:
    rows = [row.split(b",") for row in content.splitlines()]
    row, other = draw.choices(range(len(rows)), k=2)
    match draw.randrange(3):
        case 0:
            rows[row], rows[other] = rows[other], rows[row][: draw.randrange(4)]
        case 1:
            del rows[row:other]
        case _:
            odd = draw.choice(ODD).encode(errors="surrogatepass")
            rows[row][draw.randrange(len(rows[row]))] = odd
    return b"\n".join(b",".join(row) for row in rows)


_BY_ENDING = {"xml": _xml, "ssv": _xml, "json": _json, "csv": _table}


def changed(draw: Random, name: str, content: bytes) -> bytes:
    """Content of a file with one to three changes, those of bytes last."""
    for _ in range(draw.randrange(3)):
        content = _BY_ENDING.get(name.rpartition(".")[2], _bytes)(draw, content)
    return _bytes(draw, content) if draw.randrange(3) == 0 else content


# ---- what is read --------------------------------------------------------------------------


@dataclass(frozen=True)
class Subject:
    """An FMU with evidence: its bytes, and its files by path."""

    whole: bytes
    files: Mapping[str, bytes]


def subject(folder: Path) -> Subject:
    """FMU of the demo's model with a short recording."""
    demo = et.load_demo()
    model = demo.model.with_effect("coulomb_friction", {"torque": 0.35})
    evidence = et.gather_evidence(model, demo.recording.window(0.0, 0.5))
    path = et.export_fmu(model, folder / "subject.fmu", evidence=evidence, overwrite=True)
    return Subject(*read_fmu(path))


def readers(given: Subject) -> dict[str, Reader]:
    """By the path of what they read."""
    return {
        PARAMETERS: lambda content: read_values(content, "x.ssv"),
        MANIFEST: lambda content: [one.path for one in read_manifest(content, "x.fmu")],
        TABLE: lambda content: from_csv(content, "x.csv", ("time", "motor_position")),
        SEAL: lambda content: check_seal(given.whole, {**given.files, SEAL: content})[0],
    }


def packed(draw: Random, given: Subject, path: Path) -> None:
    """Write the FMU with a file changed, or its bytes; sealed anew, as it was, or by nobody."""
    if draw.randrange(8) == 0:
        path.write_bytes(_bytes(draw, given.whole))
        return
    names = [REPORT, PARAMETERS, MANIFEST, SEAL, TABLE, DESCRIPTION]
    names += [name for name in given.files if name.endswith(".csv")]
    name = draw.choice(names)
    files = {**given.files, name: changed(draw, name, given.files[name])}
    kind = draw.randrange(4)
    if kind == 0:  # as of another maker
        del files[REPORT], files[SEAL]
    if kind in (0, 1) or name == SEAL:
        write_archive(path, files)
        return
    del files[SEAL]
    write_archive(path, files)
    add_seal(path, None)


def finding(read: Callable[[], object]) -> str:
    """Nothing where an answer is a result or one sentence; else what it was."""
    try:
        answer = read()
    except et.EvidenceError as error:
        sentences = [str(error)]
    except Exception:
        return traceback.format_exc()
    else:
        told = answer.faults if isinstance(answer, et.Verification) else answer
        sentences = [one for one in told if one] if isinstance(told, (list, tuple)) else []
        sentences = [one for one in sentences if " " in one]  # paths of a manifest are none
    wrong = [one for one in sentences if not one.strip() or len(one.splitlines()) > 1]
    return f"no sentence: {wrong[0]!r}" if wrong else ""


def read_one(given: Subject, number: int) -> str:
    """Change a file and read it; what is wrong with the answer."""
    draw = Random(number)
    name, read = draw.choice([*readers(given).items()])
    content = given.files[name]
    if name == TABLE:
        content = b"\n".join(content.splitlines()[:20])
    content = changed(draw, name, content)
    return finding(lambda: read(content))


def verify_one(given: Subject, number: int, path: Path) -> str:
    """Change an FMU and verify it; what is wrong with the answer."""
    packed(Random(number), given, path)
    return finding(lambda: et.verify(path))


def main() -> int:
    """Exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--changes", type=int, default=1_000_000, metavar="N")
    parser.add_argument("--whole", type=int, default=10_000, metavar="N", help="FMUs")
    parser.add_argument("--first", type=int, default=0, metavar="N", help="number of the first")
    chosen = parser.parse_args()
    warnings.simplefilter("error")
    found = 0
    with tempfile.TemporaryDirectory() as work:
        given, path = subject(Path(work)), Path(work) / "x.fmu"
        rounds: tuple[tuple[str, int, Callable[[int], str]], ...] = (
            ("changes read", chosen.changes, lambda number: read_one(given, number)),
            ("FMUs verified", chosen.whole, lambda number: verify_one(given, number, path)),
        )
        for title, count, try_one in rounds:
            longest, started = 0.0, time.monotonic()
            for number in range(chosen.first, chosen.first + count):
                before = time.monotonic()
                if wrong := try_one(number):
                    print(f"FOUND, number {number} of {title}: {wrong}", flush=True)
                    found += 1
                longest = max(longest, time.monotonic() - before)
            passed = time.monotonic() - started
            print(f"{count} {title} in {passed:.0f} s, the longest in {longest:.2f} s", flush=True)
    print("nothing found" if not found else f"{found} found")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

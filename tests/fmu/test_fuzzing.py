"""Random sequences of calls, with sanitizers; `build_scripts/fuzz_fmus.py` makes more."""

import shutil

import pytest
from fmu_cases import BOTH
from refusals import functions_of_header

from fuzz_fmus import FUZZERS, KINDS, SEVERAL, build

SEQUENCES = 2000  # of each case: above 100 000 calls of each version


@BOTH
def test_every_function_of_the_header_is_called(version):
    """By its name, or by a macro for what both versions have."""
    own, shared = (
        (FUZZERS / name).read_text("utf-8") for name in (f"fuzz_fmi{version}.c", "fuzz.h")
    )
    for name in functions_of_header(version):
        short = name.removeprefix(f"fmi{version}")
        by_macro = [f"FMI({short})", f"CLOCK_CALL({short},"]
        by_macro += [f"ACCESS({short[3:]},"] if short[:3] in ("Get", "Set") else []
        assert name in own or any(one in own + shared for one in by_macro), name


def cases():
    """Each structure in one version or the other, by turns; in the other it is a long study."""
    for number, effects in enumerate(SEVERAL):
        for version in (2, 3):
            marks = [pytest.mark.slow] * ((number + version) % 2)
            yield pytest.param(effects, version, marks=marks, id=f"fmi{version}-{effects}")


@pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")
@pytest.mark.parametrize(("effects", "version"), list(cases()), indirect=["version"])
def test_sanitizers_find_nothing_in_random_calls(effects, version, tmp_path):
    """gcc's, because zig's do not link; warnings of the hand-written C are errors here too."""
    kind = KINDS.get(effects, "position")
    fuzzer = build(SEVERAL[effects], version, tmp_path, kind)
    assert fuzzer.warnings == ()
    told, finding = fuzzer.run(SEQUENCES, seed=1)
    assert finding == ""
    assert int(told.partition(" ")[0]) > 40_000

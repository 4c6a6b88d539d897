"""What C and Python share comes from one table: whatever that says, both sides follow."""

import ctypes
import subprocess
import sys
from typing import get_args

import pytest

from elastic_tendon.native import compiler, shared
from elastic_tendon.native.interpolation import Interpolation

_PROGRAM = """
#include <stddef.h>
#include <stdio.h>
#include "shared.h"
int main(void) {{
{lines}
  return 0;
}}
"""


def _grown(structures):
    """The table as if someone had put a field first, one in the midst, and turned all around."""
    grown = {name: dict(reversed(fields.items())) for name, fields in structures.items()}
    grown["Statistics"] = {"first": "double"} | grown["Statistics"]
    grown["Runs"] = {"statistics": "Statistics", "address": "const char *"} | grown["Runs"]
    return grown


def _in_c(structures, folder):
    """Size and offsets of each structure, as the compiler has them."""
    lines = [
        f'  printf("%zu\\n", {asked});'
        for name, fields in structures.items()
        for asked in (f"sizeof({name})", *(f"offsetof({name}, {field})" for field in fields))
    ]
    (folder / "shared.h").write_text(shared.header(structures))
    (folder / "program.c").write_text(_PROGRAM.format(lines="\n".join(lines)))
    target = compiler.host_platform().target
    command = [  # target and flags as the models', else zig builds its own once more for this one
        *(sys.executable, "-m", "ziglang", "cc", "-target", target, "-O2", "-g0", "-s"),
        *("-Wall", "-Werror", "program.c", "-o", "x"),
    ]
    subprocess.run(command, cwd=folder, check=True)
    done = subprocess.run([str(folder / "x")], capture_output=True, text=True, check=True)
    return [int(line) for line in done.stdout.split()]


@pytest.mark.parametrize("table", [shared.STRUCTURES, _grown(shared.STRUCTURES)])
def test_structures_are_the_same_in_c_and_python(table, tmp_path):
    made = shared.classes(table)
    sizes = [
        size
        for name, fields in table.items()
        for size in (
            ctypes.sizeof(made[name]),
            *(getattr(made[name], field).offset for field in fields),
        )
    ]
    assert _in_c(table, tmp_path) == sizes


def test_a_page_finds_what_the_compiler_lays_out(tmp_path):
    """Where addresses have 32 bits; what is not so does not compile."""
    places = shared.places_in_page("Simulation")
    lines = [
        f"_Static_assert(offsetof(Simulation, {field}) == {offset}, {field!r});".replace("'", '"')
        for field, (offset, _) in places.items()
        if field
    ]
    size, _ = places[""]
    lines.append(f'_Static_assert(sizeof(Simulation) == {size}, "size");')
    (tmp_path / "shared.h").write_text(shared.header())
    source = tmp_path / "program.c"
    source.write_text("\n".join(["#include <stddef.h>", '#include "shared.h"', *lines]))
    compiler.compile_library(source, tmp_path / "program.wasm", compiler.PAGE)
    assert len(lines) > 20


def test_every_way_to_interpolate_can_be_asked_for():
    assert get_args(Interpolation) == shared.INTERPOLATIONS

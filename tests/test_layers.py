"""Rooms stand upon one another, and no two modules need each other."""

import ast
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import elastic_tendon

PACKAGE = Path(elastic_tendon.__file__).parent
# from what needs nothing to what shows everything; each room may use those before it
ROOMS = (
    *("errors", "version", "progress", "output", "result"),
    *("effects", "actuator", "native", "simulation", "measurement", "arm"),
    *("comparison", "estimation", "misreadings", "diagnosis"),
    *("evidence", "fmu", "linear", "sweeps", "reports", "demo", "app", "cli"),
    *("__init__", "__main__"),
)


def modules() -> dict[str, Path]:
    """Every module of the package by its dotted name below it."""
    paths = sorted(PACKAGE.rglob("*.py"))
    return {".".join(path.relative_to(PACKAGE).with_suffix("").parts): path for path in paths}


def needed(path: Path) -> set[str]:
    """What a module imports from the package when it is itself imported, by dotted name."""
    found: set[str] = set()
    for node in ast.parse(path.read_text()).body:  # not below functions, nor for types alone
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("elastic_tendon"):
            base = (node.module or "").removeprefix("elastic_tendon").lstrip(".")
            for alias in node.names:
                inner = f"{base}.{alias.name}".lstrip(".")
                found |= {name for name in (inner, f"{inner}.__init__", base) if name in MODULES}
                found |= {f"{base}.__init__"} & MODULES.keys()
    return found


MODULES = modules()
NEEDED = {name: needed(path) for name, path in MODULES.items()}


def room_of(module: str) -> str:
    return module.split(".")[0]


@pytest.mark.parametrize("module", MODULES)
def test_a_room_needs_only_those_below_it(module) -> None:
    height = ROOMS.index(room_of(module))
    above = {one for one in NEEDED[module] if ROOMS.index(room_of(one)) > height}
    assert not above


def test_no_two_modules_need_each_other() -> None:
    without_itself = {name: uses - {name} for name, uses in NEEDED.items()}
    assert len(tuple(TopologicalSorter(without_itself).static_order())) == len(MODULES)


def test_every_room_says_what_it_is_for() -> None:
    for room in (path for path in PACKAGE.iterdir() if (path / "__init__.py").is_file()):
        text = ast.get_docstring(ast.parse((room / "__init__.py").read_text()))
        assert text, room.name


def test_tests_stand_in_the_rooms_of_what_they_test() -> None:
    """Beside them only what shares no code with the product."""
    tests = Path(__file__).parent
    rooms = {path.parent.relative_to(tests) for path in tests.rglob("test_*.py")}
    of_truth = {Path(name) for name in ("engine", "hidden_effect", "other_machines", "truth")}
    assert [
        room for room in rooms - of_truth if not (PACKAGE / room / "__init__.py").is_file()
    ] == []

"""Public functions and classes say what they do, and name every argument with its unit."""

import inspect
import re

import pytest

import elastic_tendon

PUBLIC = [
    thing
    for thing in (getattr(elastic_tendon, name) for name in elastic_tendon.__all__)
    if inspect.isfunction(thing) or inspect.isclass(thing)
]
FUNCTIONS = [one for one in PUBLIC if inspect.isfunction(one)]


@pytest.mark.parametrize("thing", PUBLIC, ids=lambda thing: thing.__name__)
def test_has_a_docstring(thing):
    first_line = (thing.__doc__ or "").strip().partition("\n")[0]
    assert first_line.endswith(".")


@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda function: function.__name__)
def test_names_every_argument(function):
    """Before a colon, alone or in a list that may go on in the next line."""
    listed = re.findall(r"^((?:\w+, )*\w+)(?: :|,$)", inspect.getdoc(function), re.MULTILINE)
    told = {name for names in listed for name in names.split(", ")}
    assert set(inspect.signature(function).parameters) <= told


def test_arrays_have_shape_and_unit():
    lines = [line.strip() for thing in PUBLIC for line in inspect.getdoc(thing).splitlines()]
    arrays = [line for line in lines if re.search(r"^\w+ : .*\barray\b", line)]
    assert len(arrays) > 10
    unit = r"(in its SI unit|(s|m|rad|N|N·m)\b)"
    assert [line for line in arrays if not re.search(rf"\(\w.*\) array,? {unit}", line)] == []

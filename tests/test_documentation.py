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
    text = inspect.getdoc(function) or ""
    missing = [
        name
        for name in inspect.signature(function).parameters
        if not re.search(rf"\b{name}\b", text)
    ]
    assert not missing


@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda function: function.__name__)
def test_arrays_have_shape_and_unit(function):
    for line in (inspect.getdoc(function) or "").splitlines():
        if " array" in line and ":" in line:
            assert re.search(r"\([nm].*\) array", line), line
            assert re.search(r"\b(s|rad|N·m|N|m)\b", line), line

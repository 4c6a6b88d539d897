"""What a refused call must look like, and which calls there are."""

import re
from ctypes import c_void_p

from elastic_tendon.native import compiler
from fmu_driver import ERROR

NOTHING = (c_void_p(),) * 12  # more arguments than any function has, all NULL or 0


def check_refused(instance, function, *arguments, telling=()):
    """Error with one message that names the function and more, and nothing has changed."""
    before, messages = instance.snapshot(), len(instance.log)
    assert instance.status(function, *arguments) == ERROR
    assert len(instance.log) == messages + 1
    message = instance.log[-1]
    assert (message.status, message.category) == (ERROR, "logStatusError")
    for part in (function, *telling):
        assert part in message.text
    assert instance.snapshot() == before


def check_forbidden(instance, function, phase):
    """A function is refused for the phase or the interface, not for arguments that are NULL."""
    check_refused(instance, function, *NOTHING)
    text = instance.log[-1].text
    assert f"not allowed {phase}" in text or "not a call for an instance for" in text


def check_set_refused(instance, name, value, *, suffix="", **expected):
    """Setting a variable to a value is refused."""
    check_refused(instance, *instance.setting([name], [value], suffix), **expected)


def functions_of_header(version):
    """Names of all functions that an FMU must have."""
    text = (compiler.fmi_headers() / f"fmi{version}Functions.h").read_text("utf-8")
    return re.findall(rf"\b(fmi{version}\w+);", text)

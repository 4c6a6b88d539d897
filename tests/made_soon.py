"""Binaries that are not optimised, for tests in which they run for moments or not at all."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from elastic_tendon.native import compiler
from elastic_tendon.native.library import load


@contextmanager
def not_optimised() -> Iterator[None]:
    """Compile in a fifth of the time what then takes four times as long to run.

    Clang alone is told: for a plain -O0, zig would first build its C library once more.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compiler, "_FLAGS", (*compiler._FLAGS, "-Xclang", "-O0"))
        load.cache_clear()  # an FMU is held against a library that is made alike
        yield
    load.cache_clear()


@pytest.fixture
def made_soon() -> Iterator[None]:
    """Binaries of a test are not optimised; not where it takes FMUs that others see too."""
    with not_optimised():
        yield


@pytest.fixture(scope="module")
def all_made_soon() -> Iterator[None]:
    """Binaries of a module are not optimised."""
    with not_optimised():
        yield

"""Recordings of the independent simulator, and searches, for all tests here."""

import pytest

from begun_search import MASS, begun, searched
from elastic_tendon.diagnosis.search import Search
from recorded_machines import frictionless, sticking, unloaded
from smooth_motion import typical_model

__all__ = ["frictionless", "sticking", "unloaded"]


@pytest.fixture(scope="module")
def ended(sticking) -> Search:
    return searched(sticking)


@pytest.fixture
def heavy() -> Search:
    """Springs with a mass, which shows in whole trajectories alone; refitted without."""
    return begun(typical_model(*MASS), *MASS)

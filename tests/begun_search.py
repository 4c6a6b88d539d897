"""Searches that have begun: the base is refitted, and a test goes on from there."""

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.diagnosis.data import data_of
from elastic_tendon.diagnosis.options import Options
from elastic_tendon.diagnosis.search import Search
from elastic_tendon.progress import silent
from smooth_motion import GIVEN, played

COULOMB, GRAVITY, DRAG = ("coulomb_friction",), ("gravity_load",), ("quadratic_drag",)
SHORT, NOISE = 3.0, 2e-4  # s, rad
BELIEVED = {"link.inertia": 0.033, "transmission.upper_spring.stiffness": 11000.0}  # 5 to 10 % off


def begun(truth: Model, *only: str) -> Search:
    """A search for some effects, with the base refitted; the given numbers are a little off."""
    recording = played(truth, SHORT).recording(NOISE)
    data = data_of(GIVEN.with_values(BELIEVED), [recording], [], Options(only=only))
    search = Search.of(data, silent)
    search.base()
    return search

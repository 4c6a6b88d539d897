"""Searches that have begun, the base is refitted and a test goes on from there, or have ended."""

from elastic_tendon.actuator.parameters import Model
from elastic_tendon.diagnosis.data import data_of
from elastic_tendon.diagnosis.options import Options
from elastic_tendon.diagnosis.search import Search
from elastic_tendon.progress import silent
from smooth_motion import GIVEN, played

COULOMB, GRAVITY, DRAG = ("coulomb_friction",), ("gravity_load",), ("quadratic_drag",)
MASS, ECCENTRICITY = ("spring_mass",), ("pulley_eccentricity",)
ECCENTRIC = {"amplitude": 0.03, "phase": 2.6}
FEW = Options(only=(*COULOMB, *GRAVITY, *DRAG))
SHORT, NOISE = 3.0, 2e-4  # s, rad
BELIEVED = {"link.inertia": 0.033, "transmission.upper_spring.stiffness": 11000.0}  # 5 to 10 % off


def begun(truth: Model, *only: str) -> Search:
    """A search for some effects, with the base refitted; the given numbers are a little off."""
    recording = played(truth, SHORT).recording(NOISE)
    data = data_of(GIVEN.with_values(BELIEVED), [recording], [], Options(only=only))
    search = Search.of(data, silent)
    search.base()
    return search


def searched(sticking, report=silent, options: Options = FEW) -> Search:
    """A search of the sticking machine that has come to its end."""
    known, recording, _ = sticking
    search = Search.of(data_of(known.model, [recording.window(None, SHORT)], [], options), report)
    search.base()
    run(search)
    return search


def run(search: Search) -> None:
    """From the base to an answer that no neighbour beats."""
    for _ in search.climb():
        pass
    search.settle()

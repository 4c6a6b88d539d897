"""FMUs of the tests, exported once."""

import pytest
from fmu_cases import MODELS

from elastic_tendon.fmu.export import export_fmu
from fmu_driver import Fmu


@pytest.fixture(scope="session", params=MODELS)
def name(request):
    """Name of each model in turn."""
    return request.param


@pytest.fixture(scope="session")
def fmus(tmp_path_factory):
    """FMU by name of its model, exported when first asked for."""
    made = {}

    def get(name):
        if name not in made:
            folder = tmp_path_factory.mktemp(name)
            made[name] = Fmu(export_fmu(MODELS[name], folder / "x.fmu"), folder / "unpacked")
        return made[name]

    return get


@pytest.fixture(scope="session")
def base(fmus):
    return fmus("base")


@pytest.fixture
def instances():
    """Frees the instances handed to it, also those of a failing test."""
    alive = []

    def keep(instance):
        alive.append(instance)
        return instance

    yield keep
    for instance in alive:
        instance.free()

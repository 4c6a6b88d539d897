"""FMUs of the tests, exported once.

Tests see FMI 2.0; where a module or a test is marked with `fmu_cases.BOTH` or `fmu_cases.FMI3`, the
same fixtures give the FMUs of these versions.
"""

import pytest
from fmu_cases import MODELS, PAPER_AND_EFFECTS

from elastic_tendon.fmu.export import export_fmu
from fmu_driver import Fmu


@pytest.fixture(scope="session", params=PAPER_AND_EFFECTS)
def name(request):
    """Name of each model in turn."""
    return request.param


@pytest.fixture
def version(request):
    """Version of FMI: what the test is marked with."""
    return getattr(request, "param", 2)


@pytest.fixture(scope="session")
def exported(tmp_path_factory):
    """FMU by name of its model and version, exported when first asked for."""
    made = {}

    def get(name, version):
        if (name, version) not in made:
            folder = tmp_path_factory.mktemp(name)
            path = export_fmu(MODELS[name], folder / "x.fmu", fmi_version=version)
            made[name, version] = Fmu(path, folder / "unpacked")
        return made[name, version]

    return get


@pytest.fixture
def fmus(exported, version):
    """FMU by name of its model."""
    return lambda name: exported(name, version)


@pytest.fixture
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

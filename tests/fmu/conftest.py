"""FMUs of the tests, exported once for all workers.

Tests see FMI 2.0; where a module or a test is marked with `fmu_cases.BOTH` or `fmu_cases.FMI3`, the
same fixtures give the FMUs of these versions.
"""

import pytest
from fmu_cases import MODELS, PAPER_AND_EFFECTS

from elastic_tendon.fmu.export import export_fmu
from fmu_driver import Fmu
from made_once import made_once


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
            folder = made_once(
                tmp_path_factory,
                f"{name}-fmi{version}",
                lambda folder: export_fmu(MODELS[name], folder / "x.fmu", fmi_version=version),
            )
            unpacked = tmp_path_factory.mktemp(name) / "unpacked"
            made[name, version] = Fmu(folder / "x.fmu", unpacked)
        return made[name, version]

    return get


@pytest.fixture(scope="session")
def complete(tmp_path_factory):
    """Path of the base model's FMU for all platforms and with its sources, by version of FMI."""

    def get(version):
        def make(folder):
            export_fmu(
                MODELS["base"],
                folder / "x.fmu",
                fmi_version=version,
                platforms="all",
                source=True,
            )

        return made_once(tmp_path_factory, f"complete-fmi{version}", make) / "x.fmu"

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

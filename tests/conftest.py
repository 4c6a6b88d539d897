"""Settings for all tests."""

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

# before numpy is imported: threads that wait for one another slow small matrices down, and most
# where several tests run at once
for variable in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

# tests start some hundred Python processes; each would compile all that it imports anew
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

# those that take longest begin first: else the last of them keeps one worker busy and the others
# wait; test_packing well after test_platforms, whose FMU it takes: side by side one waits for it
LONGEST_FIRST = (
    "app/test_app_walk.py",
    "fmu/test_platforms.py",
    "hidden_effect/test_hidden_effect.py",
    "app/test_app_whole_walk.py",
    "fmu/test_fmu_importers.py",
    "reports/html/test_html_report.py",
    "test_readme.py",
    "effects/test_truth_agreement.py",
    "misreadings/test_suspicion.py",
    "sweeps/test_dask.py",
    "diagnosis/test_sample_of_studies.py",
    "cli/test_cli_measurements.py",
    "test_examples.py",
    "diagnosis/test_interfaces_diagnosed.py",
    "test_real_data.py",
    "fmu/test_packing.py",
    "test_site.py",
    "comparison/test_in_words.py",
    "test_notebooks.py",
    "effects/test_contract_fmu.py",
    "fmu/test_fuzzing.py",
    "app/test_app_kill.py",
    "test_known_machines.py",
)

# recordings of the independent simulator, and binaries that are not optimised, for all tests
pytest_plugins = ["recorded_machines", "made_soon"]


@pytest.fixture(scope="module", autouse=True)
def _learned_effects_are_forgotten() -> Iterator[None]:
    """What one module's tests learned is not in the lists that others look at."""
    yield
    from elastic_tendon.effects import BY_ID

    for effect_id in [known for known in BY_ID if known.startswith("learned_")]:
        BY_ID.forget(effect_id)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Long files first, all else in the order in which it was collected."""
    folder = Path(__file__).parent
    place = {folder / name: index for index, name in enumerate(LONGEST_FIRST)}
    items.sort(key=lambda item: place.get(item.path, len(place)))

"""Settings for all tests."""

import os
from collections.abc import Generator, Iterator
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
    "app/test_app_every_step.py",
    "app/test_app_walk.py",
    "fmu/test_platforms.py",
    "hidden_effect/test_hidden_effect.py",
    "fmu/test_fmu_importers.py",
    "test_readme.py",
    "app/test_app_whole_walk.py",
    "diagnosis/test_interfaces_diagnosed.py",
    "diagnosis/test_sample_of_studies.py",
    "test_examples.py",
    "sweeps/test_dask.py",
    "effects/test_truth_agreement.py",
    "cli/test_cli_measurements.py",
    "reports/html/test_html_report.py",
    "fmu/test_fuzzing.py",
    "test_real_data.py",
    "test_known_machines.py",
    "diagnosis/test_diagnose.py",
    "fmu/test_packing.py",
    "test_site.py",
    "comparison/test_in_words.py",
    "test_every_interface.py",
    "test_notebooks.py",
    "app/test_app_kill.py",
    "cli/test_cli_sweep.py",
    "diagnosis/test_lack_of_fit.py",
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


@pytest.hookimpl(wrapper=True, optionalhook=True)
def pytest_xdist_auto_num_workers() -> Generator[None, int, int]:
    """One more than there are processors: tests wait for browsers, Wine and other processes."""
    return (yield) + 1


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Long files first, all else in the order in which it was collected."""
    folder = Path(__file__).parent
    place = {folder / name: index for index, name in enumerate(LONGEST_FIRST)}
    items.sort(key=lambda item: place.get(item.path, len(place)))

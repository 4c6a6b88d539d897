"""Settings for all tests."""

import os
from collections.abc import Iterator

import pytest

# before numpy is imported: threads that wait for one another slow small matrices down, and most
# where several tests run at once
for variable in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

pytest_plugins = ["recorded_machines"]  # recordings of the independent simulator, for all tests


@pytest.fixture(scope="module", autouse=True)
def _learned_effects_are_forgotten() -> Iterator[None]:
    """What one module's tests learned is not in the lists that others look at."""
    yield
    from elastic_tendon.effects import BY_ID

    for name in [one for one in BY_ID if one.startswith("learned_")]:
        del BY_ID[name]
        BY_ID._sources.pop(name)

"""How many samples there are, in words."""

import pytest

from elastic_tendon.measurement.recording import samples_text


@pytest.mark.parametrize(("count", "told"), [(0, "0 samples"), (1, "1 sample"), (7, "7 samples")])
def test_samples_are_counted_in_words(count: int, told: str) -> None:
    assert samples_text(count) == told

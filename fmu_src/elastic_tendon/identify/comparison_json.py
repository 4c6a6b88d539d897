"""The contract ``elastic-tendon/comparison/1``: a comparison as plain data."""

from typing import Any

from elastic_tendon.identify.compare import Comparison
from elastic_tendon.identify.locate import Location

SCHEMA = "elastic-tendon/comparison/1"


def comparison_json(comparison: Comparison, location: Location) -> dict[str, Any]:
    """Everything that was compared and located, for `json.dumps`; numbers are finite or None."""
    raise NotImplementedError

"""The torque on the joint that is missing in a model, reconstructed from a recording."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from elastic_tendon.identify.compare import FileComparison
from elastic_tendon.identify.residuals import Array
from elastic_tendon.parameters import Model

Report = Callable[[str, float], object]


@dataclass(frozen=True)
class TorqueCurve:
    """Mean of the missing torque over one variable, with the ends of its 95 % interval.

    `by` names the variable and `unit` is its unit; `centre` (k,), in it; `mean`, `low`, `high`
    (k,), N·m; `count` (k,) samples.
    """

    by: str
    unit: str
    centre: Array
    mean: Array
    low: Array
    high: Array
    count: Array


@dataclass(frozen=True)
class MissingTorque:
    """Load under which the model moves as the joint was measured to move.

    `torque` (n,), N·m on the joint, positive with its position; `sigma` (n,), what the noise of
    the joint position does to it; `notes` say where it could not be found as well as usual.
    """

    torque: Array
    sigma: Array
    curves: tuple[TorqueCurve, ...]
    notes: tuple[str, ...]


def missing_torque(
    model: Model, file: FileComparison, report: Report
) -> tuple[MissingTorque, Mapping[str, Array]]:
    raise NotImplementedError

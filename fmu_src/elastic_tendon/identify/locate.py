"""Where a model fails: by what the joint was doing, in bins and in words."""

from collections.abc import Mapping
from dataclasses import dataclass

from elastic_tendon.identify.bins import Bin
from elastic_tendon.identify.compare import Comparison
from elastic_tendon.identify.missing_torque import MissingTorque, Report
from elastic_tendon.identify.residuals import Array


@dataclass(frozen=True)
class FileLocation:
    """Where the model fails in one recording.

    `bins` and `in_words` by signal; `variables` are what the joint did, (n,) arrays by name:
    ``time`` (s), ``deflection`` (rad), ``joint_velocity`` (rad/s), ``joint_acceleration``
    (rad/s²), ``motor_position`` (rad), ``load_torque`` (N·m), ``slack_state``; of the model moved
    as measured, by the missing torque.
    """

    bins: Mapping[str, tuple[Bin, ...]]
    in_words: Mapping[str, str]
    missing_torque: MissingTorque
    variables: Mapping[str, Array]


@dataclass(frozen=True)
class Location:
    """Where a model fails, for each file of a comparison and in its order."""

    files: tuple[FileLocation, ...]


def locate(comparison: Comparison, report: Report = lambda _text, _share: None) -> Location:
    """Find where the error of a comparison lies.

    Parameters
    ----------
    comparison : Comparison
    report : told what is being done, and the share of all that is done

    Returns
    -------
    Location
    """
    raise NotImplementedError

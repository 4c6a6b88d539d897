"""The elastic tendon actuator: one model as simulator, FMU and fit.

Names are imported on first use, so that importing the package costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from elastic_tendon.compiled import (
        Many,
        Sensitivities,
        Trajectory,
        sensitivities,
        simulate,
        simulate_many,
    )
    from elastic_tendon.effects import load_effect
    from elastic_tendon.fmu.export import export_fmu
    from elastic_tendon.linear.fmu import linearise_fmu
    from elastic_tendon.linear.linearise import linearise
    from elastic_tendon.linear.result import Drive, LinearModel, OperatingPoint
    from elastic_tendon.parameters import Model, bundled_models, load_model
    from elastic_tendon.sweeps.sweep import sweep

_HOME = {
    "Drive": "linear.result",
    "LinearModel": "linear.result",
    "Many": "compiled",
    "Model": "parameters",
    "OperatingPoint": "linear.result",
    "Sensitivities": "compiled",
    "Trajectory": "compiled",
    "bundled_models": "parameters",
    "export_fmu": "fmu.export",
    "linearise": "linear.linearise",
    "linearise_fmu": "linear.fmu",
    "load_effect": "effects",
    "load_model": "parameters",
    "sensitivities": "compiled",
    "simulate": "compiled",
    "simulate_many": "compiled",
    "sweep": "sweeps.sweep",
}

__all__ = [
    "Drive",
    "LinearModel",
    "Many",
    "Model",
    "OperatingPoint",
    "Sensitivities",
    "Trajectory",
    "bundled_models",
    "export_fmu",
    "linearise",
    "linearise_fmu",
    "load_effect",
    "load_model",
    "sensitivities",
    "simulate",
    "simulate_many",
    "sweep",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return __all__

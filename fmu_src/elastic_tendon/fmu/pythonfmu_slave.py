"""The script inside a pythonfmu FMU: passes every call on to the compiled library beside it.

It knows no model. Variables and token come from description.xml, values from the library; both lie
in the FMU's resources. It needs nothing but Python's own modules and pythonfmu, which is packed
along.

Once it exists it raises nothing: pythonfmu 0.7 releases a slave that raises, and again when it is
freed, which breaks the memory of the importer. A call that fails is told to the logger as an error,
changes nothing, and from then on every step is discarded until the slave is reset.
"""

import ctypes
import math
import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from pythonfmu import Fmi2Slave
from pythonfmu.enums import Fmi2Status

CO_SIMULATION = 1
SUFFIXES = {"win32": ".dll", "darwin": ".dylib"}
_NO_VALUE: dict[type, Any] = {  # what an importer gets where the library refuses
    ctypes.c_double: math.nan,
    ctypes.c_int: 0,
    ctypes.c_char_p: "",
}

_Logger = ctypes.CFUNCTYPE(
    *(None, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p)
)


class _Callbacks(ctypes.Structure):
    """fmi2CallbackFunctions; the library does not ask for memory."""

    _fields_ = [
        ("logger", _Logger),
        ("allocate_memory", ctypes.c_void_p),
        ("free_memory", ctypes.c_void_p),
        ("step_finished", ctypes.c_void_p),
        ("environment", ctypes.c_void_p),
    ]


class ElasticTendonSlave(Fmi2Slave):  # type: ignore[misc]
    """An FMI 2.0 co-simulation slave that drives the compiled library's own FMI functions."""

    def __init__(self, **kwargs: str) -> None:
        super().__init__(**kwargs)
        resources = Path(self.resources)
        self._description = ElementTree.parse(resources / "description.xml").getroot()
        self.guid = self._description.attrib["guid"]
        self.modelName = self._description.findall("CoSimulation")[0].attrib["modelIdentifier"]
        suffix = SUFFIXES.get(sys.platform, ".so")
        self._library = ctypes.CDLL(str(resources / f"elastic_tendon_fmu{suffix}"))
        self._library.fmi2Instantiate.restype = ctypes.c_void_p
        self._failed = ""  # the first function that did
        self._callbacks = _Callbacks(logger=_Logger(self._log))
        self._instance = ctypes.c_void_p(
            self._library.fmi2Instantiate(
                *(self.instance_name.encode(), CO_SIMULATION, self.guid.encode(), b""),
                *(ctypes.byref(self._callbacks), 0, 0),
            )
        )
        if not self._instance:
            raise RuntimeError("the compiled library refuses to make an instance")

    def __del__(self) -> None:
        if getattr(self, "_instance", None):
            self._library.fmi2FreeInstance(self._instance)

    def to_xml(self, model_options: object = None) -> ElementTree.Element:  # noqa: ARG002
        """The description as elastic-tendon wrote it; pythonfmu's own knows no units or types."""
        return self._description

    def _log(
        self, _environment: int, _name: bytes, status: int, category: bytes, message: bytes
    ) -> None:
        text = message.decode().replace("%%", "%").replace("##", "#")
        self.log(text, Fmi2Status(status), category.decode())

    def _call(self, function: str, *arguments: object) -> int:
        """Status of a call of the library; an error is remembered."""
        status: int = self._library[function](self._instance, *arguments)
        if status > Fmi2Status.discard:
            self._failed = self._failed or function
        return status

    # ---- experiment ----

    def setup_experiment(
        self, start_time: float, stop_time: float | None = None, tolerance: float | None = None
    ) -> None:
        """See fmi2SetupExperiment."""
        number = ctypes.c_double
        self._call(
            "fmi2SetupExperiment",
            *(int(tolerance is not None), number(tolerance or 0.0), number(start_time)),
            *(int(stop_time is not None), number(stop_time or 0.0)),
        )

    def enter_initialization_mode(self) -> None:
        """See fmi2EnterInitializationMode."""
        self._call("fmi2EnterInitializationMode")

    def exit_initialization_mode(self) -> None:
        """See fmi2ExitInitializationMode."""
        self._call("fmi2ExitInitializationMode")

    def do_step(self, current_time: float, step_size: float) -> bool:
        """See fmi2DoStep; false where the step is discarded, also after any call that failed."""
        if self._failed:
            self.log(
                f"no step: {self._failed} failed before", Fmi2Status.discard, "logStatusDiscard"
            )
            return False
        times = (ctypes.c_double(current_time), ctypes.c_double(step_size))
        return bool(self._call("fmi2DoStep", *times, 1) <= Fmi2Status.warning)

    def terminate(self) -> None:
        """See fmi2Terminate."""
        self._call("fmi2Terminate")

    # ---- variables ----

    def _get(self, name: str, kind: type, references: list[int]) -> list[Any]:
        n = len(references)
        values = (kind * n)()  # type: ignore[operator]
        arguments = ((ctypes.c_uint * n)(*references), ctypes.c_size_t(n), values)
        refused = self._call(f"fmi2Get{name}", *arguments) > Fmi2Status.discard
        return [_NO_VALUE[kind]] * n if refused else list(values)

    def _set(self, name: str, kind: type, references: list[int], values: list[Any]) -> None:
        n = len(references)
        array = (kind * n)(*values)  # type: ignore[operator]
        self._call(f"fmi2Set{name}", (ctypes.c_uint * n)(*references), ctypes.c_size_t(n), array)

    def get_real(self, vrs: list[int]) -> list[float]:
        """See fmi2GetReal; the others likewise."""
        return self._get("Real", ctypes.c_double, vrs)

    def get_integer(self, vrs: list[int]) -> list[int]:
        return [int(value) for value in self._get("Integer", ctypes.c_int, vrs)]

    def get_boolean(self, vrs: list[int]) -> list[bool]:
        return [bool(value) for value in self._get("Boolean", ctypes.c_int, vrs)]

    def get_string(self, vrs: list[int]) -> list[str]:
        return self._get("String", ctypes.c_char_p, vrs)

    def set_real(self, vrs: list[int], values: list[float]) -> None:
        self._set("Real", ctypes.c_double, vrs, values)

    def set_integer(self, vrs: list[int], values: list[int]) -> None:
        self._set("Integer", ctypes.c_int, vrs, list(values))

    def set_boolean(self, vrs: list[int], values: list[bool]) -> None:
        self._set("Boolean", ctypes.c_int, vrs, [int(value) for value in values])

    def set_string(self, vrs: list[int], values: list[str]) -> None:
        self._set("String", ctypes.c_char_p, vrs, [value.encode() for value in values])

    # ---- state: the library's own bytes, which it checks ----

    def _get_fmu_state(self) -> bytes:
        state, size = ctypes.c_void_p(), ctypes.c_size_t()
        self._call("fmi2GetFMUstate", ctypes.byref(state))
        self._call("fmi2SerializedFMUstateSize", state, ctypes.byref(size))
        data = ctypes.create_string_buffer(size.value)
        self._call("fmi2SerializeFMUstate", state, data, size)
        self._call("fmi2FreeFMUstate", ctypes.byref(state))
        return data.raw

    def _set_fmu_state(self, state: bytes) -> None:
        kept = ctypes.c_void_p()
        size = ctypes.c_size_t(len(state))
        if (
            self._call("fmi2DeSerializeFMUstate", state, size, ctypes.byref(kept))
            <= Fmi2Status.warning
        ):
            self._call("fmi2SetFMUstate", kept)
            self._call("fmi2FreeFMUstate", ctypes.byref(kept))

    @staticmethod
    def _fmu_state_to_bytes(state: bytes) -> bytes:
        return state

    @staticmethod
    def _fmu_state_from_bytes(state: bytes) -> bytes:
        return state

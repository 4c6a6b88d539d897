"""Ctrl-C while the library computes, which Python by itself would hear of afterwards only."""

import ctypes
from signal import SIGINT, getsignal, signal
from threading import current_thread, main_thread
from types import FrameType
from typing import Any

from elastic_tendon.native.shared import OUTCOMES

_INTERRUPTED = list(OUTCOMES).index("INTERRUPTED")
_heard: list[FrameType | None] = []  # where Ctrl-C found Python, in the call that is under way
_asked = ctypes.CFUNCTYPE(ctypes.c_int)(lambda: len(_heard))  # python then runs its handlers
_ASKED = ctypes.cast(_asked, ctypes.c_void_p)


def call(function: Any, simulation: ctypes.Structure, *others: ctypes.Structure) -> int:
    """Outcome of a function of the library; in the main thread Ctrl-C ends it within two seconds.

    Where whoever answers Ctrl-C raises nothing, it begins again.

    Raises
    ------
    KeyboardInterrupt
        or what else the answer to Ctrl-C raises
    """
    arguments = [ctypes.byref(argument) for argument in (simulation, *others)]
    usual = getsignal(SIGINT)
    if current_thread() is not main_thread() or not callable(usual):
        outcome: int = function(*arguments)
        return outcome
    simulation.interrupted = _ASKED
    while True:
        signal(SIGINT, lambda _, frame: _heard.append(frame))
        try:
            outcome = function(*arguments)
        finally:
            signal(SIGINT, usual)
        if _heard:
            frame = _heard[0]
            _heard.clear()
            usual(SIGINT, frame)
        if outcome != _INTERRUPTED:
            return outcome

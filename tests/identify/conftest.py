"""Recordings of the independent simulator, for all tests here."""

from recorded_machines import frictionless, sticking, unloaded

__all__ = ["frictionless", "sticking", "unloaded"]

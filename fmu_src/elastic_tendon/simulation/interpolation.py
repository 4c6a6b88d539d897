"""How inputs run between samples; apart, so that the command line knows it without numpy."""

from typing import Literal

Interpolation = Literal["hold", "linear", "cubic"]

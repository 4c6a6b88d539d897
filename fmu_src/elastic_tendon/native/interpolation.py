"""How inputs run between samples; apart, so that the command line knows it without numpy."""

from typing import Literal, get_args

Interpolation = Literal["hold", "linear", "cubic"]
AskedInterpolation = Literal["auto", Interpolation]  # of recordings
INTERPOLATIONS: tuple[Interpolation, ...] = get_args(Interpolation)

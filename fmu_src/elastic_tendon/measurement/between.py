"""How inputs run between their samples, where nobody has said so."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.native.interpolation import Interpolation

FEWEST = 50  # samples that have a spectrum
LONGEST = 1 << 16  # changes of one spectrum; those of more are added up
HIGH = 0.8  # of the highest frequency: from here on
MOST = 5e-4  # share of a smooth input's power there, of its changes from sample to sample


def interpolation_of(inputs: Iterable[NDArray[np.float64]]) -> Interpolation:
    """Choose a cubic spline for inputs that are smooth, else straight lines.

    Steps, kinks and noise have power up to the highest frequency that samples can show; the spline
    would swing beside them. What has none there is given by its samples, and straight lines would
    cut its curves.

    Parameters
    ----------
    inputs : (n,) arrays, evenly sampled or nearly so; what stands still does not count
    """
    moving = [values for values in inputs if np.ptp(values) > 0.0]
    smooth = bool(moving) and all(map(_is_smooth, moving))
    return "cubic" if smooth else "linear"


def _is_smooth(values: NDArray[np.float64]) -> bool:
    if len(values) < FEWEST:
        return False
    changes = np.diff(values)
    length = min(len(changes), LONGEST)
    starts = np.linspace(0, len(changes) - length, -(-len(changes) // length)).astype(int)
    taper = np.hanning(length)
    spectra = (np.fft.rfft(changes[start : start + length] * taper) for start in starts)
    power = np.sum([np.abs(spectrum) ** 2 for spectrum in spectra], axis=0)
    return bool(power[int(HIGH * len(power)) :].sum() < MOST * power.sum())

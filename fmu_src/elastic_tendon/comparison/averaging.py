"""Long recordings as means over blocks of neighbouring samples, of which an analysis takes less.

Every block stands at the time of its middle sample and keeps what the model does there; the error
is the mean over the block, so that noise falls as it does in any mean.
"""

from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.comparison.comparison import FileComparison
from elastic_tendon.comparison.residuals import Array, residuals_of
from elastic_tendon.measurement import NoiseFloor

Value = TypeVar("Value", bound=np.generic)
# samples that are analysed one by one
LONG = 100_000


def stride_of(n: int) -> int:
    """Number of samples in a block of a recording of n samples; 1 up to `LONG`."""
    return -(-n // LONG)


def block_sizes(n: int, stride: int) -> NDArray[np.int_]:
    """Number of samples in each block, (m,); the last may hold fewer."""
    starts = np.arange(0, n, stride)
    return np.diff(np.append(starts, n))


def block_means(values: Array, stride: int) -> Array:
    """Means (m,) of (n,) values over blocks of `stride` samples, in their unit."""
    if stride == 1:
        return values
    sums = np.add.reduceat(values, np.arange(0, len(values), stride))
    return np.asarray(sums / block_sizes(len(values), stride))


def spread(values: NDArray[Value], stride: int, n: int) -> NDArray[Value]:
    """Values (m,) of blocks for each of n samples."""
    return values if stride == 1 else np.repeat(values, stride)[:n]


def averaged_file(file: FileComparison, stride: int) -> FileComparison:
    """A comparison with one sample for each block.

    Parameters
    ----------
    file : FileComparison of n samples
    stride : int, of `stride_of`

    Returns
    -------
    FileComparison; its figures of error are still those of all samples
    """
    if stride == 1:
        return file
    measurement, trajectory = file.measurement, file.trajectory
    sizes = block_sizes(len(measurement.time), stride)
    middle = stride * np.arange(len(sizes)) + sizes // 2
    shown = replace(
        trajectory,
        time=trajectory.time[middle],
        states=trajectory.states[middle],
        outputs=trajectory.outputs[middle],
    )
    load = measurement.load_torque
    short = replace(
        measurement,
        time=measurement.time[middle],
        motor_position=block_means(measurement.motor_position, stride),
        load_torque=None if load is None else block_means(load, stride),
        signals={
            name: shown[shown.measured(name)] - block_means(error, stride)
            for name, error in residuals_of(trajectory, measurement).items()
        },
        interpolation="linear",
    )
    return replace(file, measurement=short, trajectory=shown)


def averaged_noise(noise: NoiseFloor, stride: int) -> NoiseFloor:
    """Noise of means over blocks; noise with memory is taken as first-order autoregressive."""
    if stride == 1:
        return noise
    rho = noise.correlation
    lags = np.arange(1, stride)
    variance = (1.0 + 2.0 * float(np.sum((1.0 - lags / stride) * rho**lags))) / stride
    powers = float(np.sum(rho ** np.arange(stride)))
    neighbours = rho * powers**2 / stride**2
    sigma = noise.sigma * float(np.sqrt(variance))
    return replace(noise, sigma=sigma, correlation=neighbours / variance)

"""The torque balance of a recording in weak form: residuals without second derivatives.

The equation of motion ``J q'' = torque(q, q')`` is multiplied by test functions and integrated by
parts, so that only the test functions are differentiated (Messenger & Bortz, Weak SINDy,
Multiscale Modeling & Simulation 19(3), 2021). The noise of the encoder then shows in each residual
as a known sum, and neighbours are correlated in a known way, by which they are whitened.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.fft import dct, idct
from scipy.interpolate import BSpline, CubicSpline
from scipy.linalg import cholesky_banded
from scipy.linalg.lapack import dtbtrs

from elastic_tendon.actuator.variables import LINK, ROTOR
from elastic_tendon.comparison.residuals import Array, noise_floors
from elastic_tendon.diagnosis.torque_balance import Motion, Torques
from elastic_tendon.measurement import Measurement
from elastic_tendon.measurement.noise import noise_floors as measured_noise

Indices = NDArray[np.intp]

# s between the knots of the test functions, by the shortest period that the motion has; and, of
# these, between instants at which torques are evaluated
KNOTS_OF_PERIOD, KNOTS, INSTANTS = 0.2, (0.002, 0.010), 0.4
LIVELY = 0.9  # share of the squared acceleration that slower oscillations than that have
DEGREE = 5  # of these splines
EDGE = 0.06  # s at either end, where a smoothed motion is not to be trusted
SLOW = 2.5  # velocities below so many of their standard deviations have no sure sign ...
SLOWEST = 0.005  # ... nor those below this share of the largest
SMOOTHING = 10.0 ** np.arange(0.0, 14.0, 0.5)  # weights that cross-validation chooses from
ORDER = 3  # derivative that smoothing keeps small
# torques, and forces of tendons, that sensors may show
TORQUES = "joint_torque", "motor_torque", "upper_spring_force", "lower_spring_force"
JITTER = 1e-9  # relative; keeps covariances positive


@dataclass(frozen=True)
class Weak:
    """A recording as K residuals in torque of each body that is moved, and of each torque shown.

    `motion` : at the instants where torques are evaluated. `test` (K, n) sparse integrates over
    these. `bodies` : the link and the rotor, where they are moved. `noise` : sigma of the
    joint's position, rad. `shown` : by signal, torques that were measured, integrated (K,), and
    their sigma, N·m. The rest corrects for the noise in the smoothed motion.
    """

    motion: Motion
    test: sparse.csr_matrix
    bodies: tuple["Moved", ...]
    noise: float
    shown: Mapping[str, tuple[Array, float]]
    samples: tuple[sparse.csr_matrix, ...] = field(repr=False)  # φ, φ', φ'' at the raw samples
    rough: Array = field(repr=False)  # (N,) what smoothing took away, rad
    nearest: Indices = field(repr=False)  # (N,) instant of each raw sample

    def residuals(self, values: Mapping[str, float], torques: Torques) -> Array:
        """Residuals (count,) as the raw motion has them, N·m.

        Parameters
        ----------
        values : parameters by dotted path, the inertias among them
        torques : Torques
        """
        flat, first, _ = self.samples
        parts = []
        for body, torque in zip(self.bodies, torques.moved, strict=True):
            here, slope = torque.by_position[self.nearest], torque.by_velocity[self.nearest]
            shift = flat @ (here * self.rough) - first @ (slope * self.rough)
            inertia = values[body.inertia]
            parts.append(inertia * body.curvature[1] - self.test @ torque.value - shift)
        shown = [
            measured - self.test @ torques.shown[name].value
            for name, (measured, _) in self.shown.items()
        ]
        return np.concatenate([*parts, *shown])

    def jacobian(self, torques: Torques, paths: Sequence[str]) -> Array:
        """Derivatives of the residuals by the m parameters along the smoothed motion, (count, m).

        Parameters
        ----------
        torques : Torques
        paths : of the m parameters
        """
        parts = []
        for body, torque in zip(self.bodies, torques.moved, strict=True):
            own = -(self.test @ torque.by_parameter)
            if body.inertia in paths:
                own[:, paths.index(body.inertia)] += body.curvature[0]
            parts.append(own)
        shown = [-(self.test @ torques.shown[name].by_parameter) for name in self.shown]
        return np.vstack([*parts, *shown])

    def whitener(self, values: Mapping[str, float], torques: Torques) -> "Whitener":
        """What makes residuals independent and of variance one, if there is noise alone."""
        flat, first, second = self.samples
        parts = []
        for body, torque in zip(self.bodies, torques.moved, strict=True):
            here, slope = torque.by_position[self.nearest], torque.by_velocity[self.nearest]
            inertia = values[body.inertia]
            if body.is_joint:
                rows = self.noise * (inertia * second - flat.multiply(here) + first.multiply(slope))
            else:  # noise of the joint's position, of its own, and of what drives it
                of_joint = self.noise * (first.multiply(slope) - flat.multiply(here))
                of_own = body.noise * inertia * second
                rows = sparse.hstack([of_joint, of_own, body.drive_noise * flat])
            parts.append(_factor(sparse.csr_matrix(rows)))
        for name, (_, sigma) in self.shown.items():
            level = np.hypot(sigma, self.noise * torques.shown[name].by_position[self.nearest])
            parts.append(_factor(sparse.csr_matrix(flat.multiply(level))))
        return Whitener(tuple(parts))


@dataclass(frozen=True)
class Moved:
    """A body with the integrals (K,) of its acceleration, smoothed and raw.

    `inertia` : its dotted path. `noise` : sigma of its position, rad. `drive_noise` : sigma of the
    torque that drives it, N·m. `is_joint` : whether its position is that of the joint.
    """

    inertia: str
    curvature: tuple[Array, Array]
    noise: float
    drive_noise: float = 0.0
    is_joint: bool = True


@dataclass(frozen=True)
class Whitener:
    """Banded Cholesky factors (6, K) of the covariance of residuals, one for each signal."""

    factors: tuple[Array, ...]

    def __call__(self, rows: Array) -> Array:
        """Whitened residuals (N,) or their derivatives (N, m)."""
        columns = rows.reshape(len(rows), -1)
        parts = np.split(columns, np.cumsum([f.shape[1] for f in self.factors])[:-1])
        whitened = [
            dtbtrs(factor, np.asfortranarray(part), uplo="L")[0]
            for factor, part in zip(self.factors, parts, strict=True)
        ]
        return np.asarray(np.vstack(whitened).reshape(rows.shape))


def weak_form(measurement: Measurement) -> Weak:
    """Bring a recording into weak form.

    Parameters
    ----------
    measurement : Measurement with a joint position, signal or input; uneven samples are brought to
        even ones

    Returns
    -------
    Weak
    """
    sigmas = noise_floors(measurement)
    if measurement.static:
        return _static(measurement, sigmas)
    time = measurement.time
    n = len(time)
    step = float(time[-1] - time[0]) / (n - 1)
    even = time[0] + step * np.arange(n)
    position = np.interp(even, time, measurement.joint_position)
    smoothed, gain = smooth(position)
    velocity = np.gradient(smoothed, step)
    frequency = np.pi * np.arange(n) / (n * step)
    noise = _joint_noise(measurement, sigmas)
    doubt = noise * float(np.sqrt(np.mean((gain * frequency) ** 2)))
    knot = _knot(smoothed, step)
    every = max(round(INSTANTS * knot), 1)
    instants = np.arange(0, n, every)
    motor = np.interp(even, time, measurement.motor_position)
    turning = np.gradient(smooth(motor)[0], step)[instants]
    raw = [_test_functions(np.arange(n), n, step, knot, derivative) for derivative in range(3)]
    test = every * _test_functions(instants, n, step, knot, 0)
    return Weak(
        motion=Motion(
            step=every * step,
            position=smoothed[instants],
            velocity=velocity[instants],
            inputs_at=_inputs(even[instants], measurement),
            weights=np.hstack([_weights(velocity[instants], doubt), _weights(turning, 0.0)]),
        ),
        test=test.tocsr(),
        bodies=(
            *_link(measurement, noise, (raw[2] @ smoothed, raw[2] @ position)),
            *_rotor(measurement, sigmas, motor, raw[2]),
        ),
        noise=noise,
        shown={
            name: (raw[0] @ np.interp(even, time, measurement.signals[name]), sigmas[name])
            for name in TORQUES
            if name in measurement.signals
        },
        samples=tuple(raw),
        rough=position - smoothed,
        nearest=np.minimum(np.arange(n) // every, len(instants) - 1),
    )


def _joint_noise(measurement: Measurement, sigmas: Mapping[str, float]) -> float:
    """Sigma of the joint's position, rad, a signal or, where the joint is given, an input."""
    if "joint_position" in sigmas:
        return sigmas["joint_position"]
    return _sigma_of_input(measurement, "joint_position")


def _sigma_of_input(measurement: Measurement, name: str) -> float:
    values = {name: measurement.driving[name]}
    return measured_noise(measurement.time, {}, values)[name].sigma


def _link(
    measurement: Measurement, noise: float, curvature: tuple[Array, Array]
) -> Iterator[Moved]:
    """The link, where the interface moves it."""
    if measurement.kind.has_link:
        yield Moved(LINK.inertia, curvature, noise)


def _rotor(
    measurement: Measurement, sigmas: Mapping[str, float], motor: Array, second: sparse.csr_matrix
) -> Iterator[Moved]:
    """The rotor, where a measured torque drives it; its position (n,) at even times, rad."""
    if measurement.kind.has_rotor:
        curvature = second @ smooth(motor)[0], second @ motor
        drive_noise = _sigma_of_input(measurement, "motor_torque")
        yield Moved(ROTOR.inertia, curvature, sigmas["motor_position"], drive_noise, False)


def smooth(values: Array) -> tuple[Array, Array]:
    """Smoothing spline of even samples by cosine transform, its weight by cross-validation.

    Parameters
    ----------
    values : (n,) array, any unit

    Returns
    -------
    (n,) smoothed values, and (n,) gain of each frequency (Garcia, Computational Statistics & Data
    Analysis 54(4), 2010)
    """
    n = len(values)
    line = np.linspace(values[0], values[-1], n)  # or the even extension has a kink at both ends
    spectrum = dct(values - line, norm="ortho")
    bending = (2.0 * np.sin(np.pi * np.arange(n) / (2 * n))) ** (2 * ORDER)
    gains = 1.0 / (1.0 + SMOOTHING[:, np.newaxis] * bending)
    left = np.mean(((1.0 - gains) * spectrum) ** 2, axis=1)
    gain = gains[int(np.argmin(left / (1.0 - np.mean(gains, axis=1)) ** 2))]
    return idct(gain * spectrum, norm="ortho") + line, gain


def _knot(smoothed: Array, step: float) -> int:
    """Samples between knots: close enough for what a motion (n,) holds, and no closer."""
    n = len(smoothed)
    line = np.linspace(smoothed[0], smoothed[-1], n)
    frequency = np.arange(n) / (2 * n * step)
    energy = np.cumsum((dct(smoothed - line, norm="ortho") * frequency**2) ** 2)
    highest = max(frequency[np.searchsorted(energy, LIVELY * energy[-1])], 1e-9)
    return max(round(float(np.clip(KNOTS_OF_PERIOD / highest, *KNOTS)) / step), 1)


def _test_functions(
    at: Indices, n: int, step: float, knot: int, derivative: int
) -> sparse.csr_matrix:
    """B-splines (K, len(at)) or a derivative at some of n samples, times the sampling step."""
    edge = min(int(EDGE / step), max((n - (DEGREE + 2) * knot) // 4, 0))
    first = np.arange(edge, n - edge - (DEGREE + 1) * knot, knot)
    support = (DEGREE + 1) * knot
    basis = BSpline.basis_element(np.arange(DEGREE + 2) * knot * step, extrapolate=False)
    shape = basis.derivative(derivative) if derivative else basis
    stride = int(at[1] - at[0]) if len(at) > 1 else 1
    inside = support // stride + 1
    start = -(-first // stride)  # index in `at` of the first instant within
    columns = start[:, np.newaxis] + np.arange(inside)
    offset = columns * stride - first[:, np.newaxis]
    values = np.nan_to_num(shape(offset * step)) * step / (knot * step)
    keep = columns < len(at)
    rows = np.broadcast_to(np.arange(len(first))[:, np.newaxis], columns.shape)
    return sparse.csr_matrix(
        (values[keep], (rows[keep], columns[keep])), shape=(len(first), len(at))
    )


def _inputs(at: Array, measurement: Measurement) -> Callable[[float], tuple[Array, Array]]:
    """Function of a delay, see `Motion.inputs_at`."""
    time, none = measurement.time, np.zeros(len(measurement.time))
    load = measurement.load_torque
    turns = CubicSpline(time, measurement.motor_position)
    loads = CubicSpline(time, none if load is None else load)
    drives = CubicSpline(time, measurement.driving.get("motor_torque", none))

    def inputs_at(delay: float) -> tuple[Array, Array]:
        late = np.clip(at - delay, time[0], time[-1])
        rates = [turns(late, 1), turns(late, 2), loads(late, 1), drives(late, 1)]
        values = [turns(late), rates[0], loads(late), drives(late)]
        return np.column_stack(values), np.column_stack(rates)

    undelayed = inputs_at(0.0)
    return lambda delay: inputs_at(delay) if delay else undelayed


def _weights(velocity: Array, doubt: float) -> Array:
    """How far the joint counts as moving up, moving down and held, (n, 3)."""
    slow = max(SLOW * doubt, SLOWEST * float(np.max(np.abs(velocity))), 1e-300)
    moving = np.minimum(np.abs(velocity) / slow, 1.0) ** 4
    up = velocity > 0.0
    return np.column_stack([moving * up, moving * ~up, 1.0 - moving])


def _static(measurement: Measurement, sigmas: dict[str, float]) -> Weak:
    """Every row of a static curve is a balance of its own."""
    position = measurement.signals["joint_position"]
    n = len(position)
    step = float(measurement.time[-1] - measurement.time[0]) / (n - 1)
    velocity = np.gradient(position, step)
    identity, nothing = sparse.identity(n, format="csr"), sparse.csr_matrix((n, n))
    return Weak(
        motion=Motion(
            step=step,
            position=position,
            velocity=velocity,
            inputs_at=_inputs(measurement.time, measurement),
            weights=np.hstack([_weights(velocity, 0.0), np.zeros((n, 3))]),
        ),
        test=identity,
        bodies=(Moved(LINK.inertia, (np.zeros(n), np.zeros(n)), sigmas["joint_position"]),),
        noise=sigmas["joint_position"],
        shown={},
        samples=(identity, nothing, nothing),
        rough=np.zeros(n),
        nearest=np.arange(n),
    )


def _factor(rows: sparse.csr_matrix) -> Array:
    """Banded Cholesky factor (6, K) of rows times their transpose."""
    product = (rows @ rows.T).todia()
    size = rows.shape[0]
    bands = np.zeros((DEGREE + 1, size))
    for offset in range(min(DEGREE + 1, size)):
        bands[offset, : size - offset] = product.diagonal(-offset)
    bands[0] += JITTER * np.max(bands[0])
    return np.asarray(cholesky_banded(bands, lower=True))

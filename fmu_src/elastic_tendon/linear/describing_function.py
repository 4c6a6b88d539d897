"""The transmission as an oscillation sees it: equivalent stiffness over amplitude, limit cycles.

A linear model holds within one slack state. A deflection that swings across a slack boundary meets
a torque that is no sinusoid; its first harmonic is that of a linear spring and damper whose numbers
depend on the amplitude. With them a closed loop is linear at each amplitude, and a limit cycle is
where poles of this loop lie on the imaginary axis (harmonic balance).

A. Gelb, W. E. Vander Velde, Multiple-Input Describing Functions and Nonlinear System Design,
McGraw-Hill, 1968: chapter 2 (one sinusoid), chapter 6 (a sinusoid and a bias).
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import control
import numpy as np
from numpy.typing import ArrayLike

from elastic_tendon.compiled import simulate
from elastic_tendon.design import design
from elastic_tendon.effects import BY_ID
from elastic_tendon.effects.base import Slot
from elastic_tendon.errors import LinearisationError
from elastic_tendon.linear.result import Array
from elastic_tendon.parameters import Model
from elastic_tendon.transmission import deflection_limits, slack_boundaries

Report = Callable[[str, float], object]  # what is being done, and the share of it that is done
Loop = Callable[[float, float], control.StateSpace]  # stiffness, damping -> closed loop

SAMPLES = 4096  # of a cycle; its kinks then cost less than 1e-6 of the stiffness
PASSES = 12  # until the joint moves as it shall
HELD = 1e-8  # largest deviation from that, of the amplitude
CYCLES = 300  # until the torque repeats itself
SETTLED = 1e-6  # of the largest torque of a cycle
SOLVER = 1e-10  # tolerance of the simulations
HEAVY = {"link.inertia": 1e4, "link.damping": 1e4}  # kg·m², N·m·s/rad: hardly moved by tendons
ON_JOINT = (Slot.JOINT_TORQUE, Slot.DRY_FRICTION)  # what is no part of the transmission

GRID = 60  # default amplitudes, beside those on boundaries
REACH = 1.2  # the largest of them, of the farther deflection limit

ON_AXIS = 1e-7  # real part of a pole on the imaginary axis, of the largest pole
ROOT = 1e-12  # rad, to which the amplitude of a limit cycle is found
SAME = 1e-4  # relative, of amplitude and frequency of one limit cycle that was found twice


@dataclass(frozen=True)
class DescribingFunction:
    """First harmonic of the tendons' torque while the deflection is `deflection + A cos(ωt)`.

    Attributes
    ----------
    amplitudes : (n,) array, rad; A, increasing
    deflection : (n,) array, rad; mean deflection, the same for all amplitudes unless it was asked
        for by the load that it carries
    frequency : rad/s; ω
    mean_torque : (n,) array, N·m; of the tendons on the joint, negative for positive deflection
    stiffness : (n,) array, N·m/rad; equivalent stiffness, of the torque in phase
    damping : (n,) array, N·m·s/rad; equivalent damping, of the torque in quadrature
    """

    amplitudes: Array
    deflection: Array
    frequency: float
    mean_torque: Array
    stiffness: Array
    damping: Array

    @property
    def loss(self) -> Array:
        """Energy lost in a cycle, (n,) array, J; exact, since the deflection is one sinusoid."""
        return np.pi * self.frequency * self.damping * self.amplitudes**2


@dataclass(frozen=True)
class LimitCycle:
    """An oscillation that keeps itself up, to first harmonic.

    `amplitude` (rad) of the deflection around the mean `deflection` (rad), angular `frequency`
    (rad/s); `stiffness` (N·m/rad) and `damping` (N·m·s/rad) are the equivalent ones.
    `attracting`: neighbouring oscillations come closer; else it is the border between those that
    die out and those that grow.
    """

    amplitude: float
    deflection: float
    frequency: float
    stiffness: float
    damping: float
    attracting: bool


@dataclass(frozen=True)
class LimitCycles:
    """All `cycles` between the amplitudes looked at; where there is none, `reason` says why."""

    cycles: tuple[LimitCycle, ...]
    reason: str


# ---- the describing function ---------------------------------------------------------------


def default_amplitudes(model: Model, deflection: float = 0.0) -> Array:
    """Amplitudes that reach beyond all slack boundaries (14) and deflection limits (16).

    Parameters
    ----------
    model : Model
    deflection : mean deflection, rad

    Returns
    -------
    (n,) array, rad; those at which the swing touches a boundary or a limit are among them
    """
    marks = amplitude_marks(model, deflection)
    touched = [abs(one) for pair in marks for one in pair if one]
    largest = REACH * max(touched)
    return np.unique([*np.linspace(largest / GRID, largest, GRID), *touched])


def amplitude_marks(
    model: Model, deflection: float = 0.0
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Signed swings from a mean deflection to the slack boundaries (14) and the limits (16), rad.

    Effects do not shift them.
    """
    boundaries = slack_boundaries(model.transmission)
    limits = deflection_limits(model.transmission)
    return (
        (boundaries[0] - deflection, boundaries[1] - deflection),
        (limits[0] - deflection, limits[1] - deflection),
    )


def describing_function(
    model: Model,
    amplitudes: ArrayLike | None = None,
    *,
    deflection: float | None = None,
    load_torque: float | None = None,
    frequency: float | None = None,
    report: Report = lambda _text, _share: None,
) -> DescribingFunction:
    """Equivalent stiffness and damping of the transmission over the amplitude of its deflection.

    The model is simulated with all its effects: the motor is held at 0, the joint swings as
    ``deflection + A cos(ωt)``, and the first harmonic of `joint_torque`, that of the tendons on the
    joint, is taken when it repeats itself. Effects that act on the joint itself (gravity, stops,
    dry friction and drag of the joint) are no part of the transmission and are left out. The
    joint swings and not the motor, since tendon friction is that of a moving joint pulley.

    4096 samples of a cycle, between the turning points, leave an error of the kinks of 1e-6 of
    the stiffness at most; of transients less than 1e-6 of the largest torque of a cycle.

    Parameters
    ----------
    model : Model
    amplitudes : (n,) array, rad; positive, increasing; None: `default_amplitudes`
    deflection : rad; mean of the swing, 0 where nothing is given
    load_torque : N·m; instead of `deflection`: a constant load on the joint. The mean at each
        amplitude is then the one at which the mean torque of the tendons carries this load
    frequency : rad/s; None: the natural frequency with both tendons taut, where limit cycles live.
        Without damping, relaxation and spring mass it does not matter
    report : told what is being done, and the share that is done

    Returns
    -------
    DescribingFunction

    Raises
    ------
    LinearisationError
        for wrong arguments, and where the torque does not come to repeat itself
    SimulationError, BuildError
        where the swing cannot be simulated

    References
    ----------
    Gelb and Vander Velde, 1968, chapters 2 and 6
    """
    if deflection is not None and load_torque is not None:
        raise LinearisationError(
            "deflection and load_torque are both given, but one settles the other; give one"
        )
    omega = _positive("frequency", design(model).frequency_state_3 if frequency is None else frequency)
    mean = _finite("deflection", deflection or 0.0)
    load = None if load_torque is None else _finite("load_torque", load_torque)
    chosen = default_amplitudes(model, mean) if amplitudes is None else _increasing(amplitudes)
    transmission_alone = _without_joint(model)
    found = []
    for index, amplitude in enumerate(chosen):
        report("describing function", index / len(chosen))
        if load is not None:
            mean = _carrying(transmission_alone, load, float(amplitude), omega, mean)
        found.append((mean, *_first_harmonic(transmission_alone, mean, float(amplitude), omega)))
    means, torques, in_phase, quadrature = np.array(found).T
    return DescribingFunction(
        amplitudes=chosen,
        deflection=means,
        frequency=omega,
        mean_torque=torques,
        stiffness=-in_phase / chosen,
        damping=quadrature / (omega * chosen),
    )


def _finite(name: str, value: float) -> float:
    if not np.isfinite(value):
        raise LinearisationError(f"{name} is {value}, but a finite number is needed")
    return float(value)


def _positive(name: str, value: float) -> float:
    if not 0 < value < np.inf:
        raise LinearisationError(f"{name} is {value}, but a positive number is needed")
    return float(value)


def _increasing(amplitudes: ArrayLike) -> Array:
    values = np.array(amplitudes, dtype=np.float64)
    if values.ndim != 1 or values.size == 0:
        raise LinearisationError(
            f"amplitudes have the shape {values.shape}, but one row with one number at least "
            "is needed"
        )
    if not (np.isfinite(values).all() and values[0] > 0 and (np.diff(values) > 0).all()):
        raise LinearisationError("amplitudes must be finite, positive and increase")
    return values


def _without_joint(model: Model) -> Model:
    """The transmission at a joint that tendons hardly move, without effects on the joint."""
    for effect_id in model.effect_ids:
        if BY_ID[effect_id].slot in ON_JOINT:
            model = model.with_effect(effect_id, None)  # at its null values: nothing to compile
    return model.with_values(HEAVY)


def _carrying(model: Model, load: float, amplitude: float, omega: float, guess: float) -> float:
    """Mean deflection at which the mean torque of the tendons carries a load, rad."""
    from scipy.optimize import brentq

    def unbalanced(deflection: float) -> float:
        return _first_harmonic(model, deflection, amplitude, omega).mean + load

    step = max(abs(load) / design(model).stiffness_state_3, SETTLED * amplitude)
    low, high = guess - step, guess + step
    while unbalanced(low) < 0:
        low -= (step := 2 * step)
    while unbalanced(high) > 0:
        high += (step := 2 * step)
    return float(brentq(unbalanced, low, high, xtol=SETTLED * amplitude))


class _Harmonic(NamedTuple):
    """Torque over a cycle, N·m: ``mean + in_phase cos(ωt) + quadrature sin(ωt)``."""

    mean: float
    in_phase: float
    quadrature: float


def _first_harmonic(model: Model, deflection: float, amplitude: float, omega: float) -> _Harmonic:
    """First harmonic of the torque when it repeats itself; the motor is at 0."""
    state: dict[str, float] = {}
    previous, previous_change = np.full(3, np.inf), np.inf
    torque = np.zeros(SAMPLES + 2)
    for _ in range(CYCLES):
        torque, state = _cycle(model, deflection, amplitude, omega, state, torque)
        harmonic = _harmonic(torque)
        change = float(np.abs(np.array(harmonic) - previous).max())
        allowed = SETTLED * float(np.abs(torque).max())
        # what is still to come of a transient that dies out as it did in the last two cycles
        to_come = change / (1 - change / previous_change) if change < previous_change else np.inf
        if to_come <= allowed or change <= 0.01 * allowed:
            return harmonic
        previous, previous_change = np.array(harmonic), change
    raise LinearisationError(
        f"{model.name}: at an amplitude of {amplitude:g} rad and {omega:g} rad/s the torque does "
        f"not repeat itself after {CYCLES} cycles; choose a frequency that is not far above the "
        "slowest relaxation of the springs, and give spring masses damping"
    )


def _cycle(
    model: Model,
    deflection: float,
    amplitude: float,
    omega: float,
    state: dict[str, float],
    torque: Array,
) -> tuple[Array, dict[str, float]]:
    """Torque (SAMPLES + 2,) over a cycle, and the states after it.

    A cycle starts upwards through the mean, where a sliding joint is told from a sticking one.
    The load moves the heavy joint and carries the torque of the pass before; `torque` is the first
    guess of it.
    """
    phase = _phase()
    time = phase / omega
    swing = amplitude * np.cos(phase)
    velocity = -omega * amplitude * np.sin(phase)
    moving = HEAVY["link.inertia"] * -(omega**2) * swing + HEAVY["link.damping"] * velocity
    start = state | {"joint_position": deflection + swing[0], "joint_velocity": velocity[0]}
    for _ in range(PASSES):
        motion = simulate(
            *(model, time, np.zeros_like(time), moving - torque),
            initial_state=start,
            interpolation="cubic",
            tolerance=SOLVER,
        )
        torque = motion["joint_torque"]
        error = np.abs(motion["joint_position"] - deflection - swing).max()
        if error <= HELD * amplitude:
            return torque, dict(zip(motion.state_names, motion.states[-1], strict=True))
    raise LinearisationError(
        f"{model.name}: at an amplitude of {amplitude:g} rad and {omega:g} rad/s the joint cannot "
        "be moved against the tendons as exactly as needed; choose a higher frequency"
    )


def _phase() -> Array:
    """Ends of a cycle and the middles of its equal parts, rad.

    Kinks at the turning points and jumps of friction lie between two samples.
    """
    middles = (np.arange(SAMPLES) + 0.5) / SAMPLES
    return 2 * np.pi * np.concatenate(([0.0], middles, [1.0])) - 0.5 * np.pi


def _harmonic(torque: Array) -> _Harmonic:
    phase, inside = _phase()[1:-1], torque[1:-1]
    return _Harmonic(
        mean=float(inside.mean()),
        in_phase=float(2.0 * (inside * np.cos(phase)).mean()),
        quadrature=float(2.0 * (inside * np.sin(phase)).mean()),
    )


# ---- limit cycles --------------------------------------------------------------------------


def interpolated(
    first: control.StateSpace, second: control.StateSpace, stiffnesses: tuple[float, float]
) -> Callable[[float], control.StateSpace]:
    """Linear models of a plant between, and beyond, those of two slack states.

    The matrices of a plant are affine in the stiffness of its transmission. Damping of the springs
    goes along in proportion; a closed loop is not affine where a controller feeds a torque
    through at once, so close the loop around what this returns.

    Parameters
    ----------
    first, second : control.StateSpace of the same states, inputs and outputs, as from `linearise`
    stiffnesses : N·m/rad; those of the two, (19), (23), (25)

    Returns
    -------
    callable: stiffness, N·m/rad -> control.StateSpace with the names of `first`

    Raises
    ------
    LinearisationError
        where the two are not models of one plant, or their stiffnesses are equal
    """
    names = [(one.state_labels, one.input_labels, one.output_labels) for one in (first, second)]
    if names[0] != names[1]:
        raise LinearisationError(
            "the two models differ in the names of states, inputs or outputs; linearise one model "
            "with the same drive, inputs and outputs in both states"
        )
    if stiffnesses[0] == stiffnesses[1]:
        raise LinearisationError(
            f"both models have the stiffness {stiffnesses[0]:g} N·m/rad; take the states on both "
            "sides of a slack boundary"
        )
    states, inputs, outputs = names[0]

    def at(stiffness: float) -> control.StateSpace:
        share = (stiffness - stiffnesses[0]) / (stiffnesses[1] - stiffnesses[0])
        pairs = zip(_matrices(first), _matrices(second), strict=True)
        matrices = [one + share * (other - one) for one, other in pairs]
        return control.StateSpace(*matrices, states=states, inputs=inputs, outputs=outputs)

    return at


def _matrices(system: control.StateSpace) -> tuple[Array, Array, Array, Array]:
    return system.A, system.B, system.C, system.D


def limit_cycles(describing: DescribingFunction, closed_loop: Loop) -> LimitCycles:
    """Find the limit cycles of a closed loop by harmonic balance.

    At each amplitude the loop is closed with the equivalent stiffness and damping; a limit cycle is
    where a pair of its poles crosses the imaginary axis. It attracts where the pair moves to the
    left as the amplitude grows and no other pole lies to the right of the axis.

    The amplitude is that of the deflection, not of the joint, around the mean for which the
    describing function was made: where the loop carries a load, make it with `load_torque`. The
    answer is approximate: the loop must pass the first harmonic much better than the others. For
    a model whose describing function depends on frequency, make it again at the one found.

    Parameters
    ----------
    describing : DescribingFunction; between its amplitudes cubic interpolation that keeps the shape
    closed_loop : callable: stiffness (N·m/rad), damping (N·m·s/rad) -> control.StateSpace of the
        closed loop in continuous time, always with as many states; see `interpolated`

    Returns
    -------
    LimitCycles; by rising amplitude, between the smallest and the largest of `describing`

    Raises
    ------
    LinearisationError
        for fewer than two amplitudes, or a loop in discrete time

    References
    ----------
    Gelb and Vander Velde, 1968, chapter 3
    """
    if len(describing.amplitudes) < 2:
        raise LinearisationError(
            "limit cycles are sought between amplitudes, but the describing function has one; "
            "make it for two at least"
        )
    balance = _Balance.of(describing, closed_loop)
    largest_parts = np.array([balance.real_parts(one) for one in describing.amplitudes])
    crossings = balance.crossings(describing.amplitudes, largest_parts)
    cycles: list[LimitCycle] = []
    for amplitude, falling in crossings:
        cycle = balance.cycle(amplitude, falling)
        if cycle is not None and not any(_same(cycle, other) for other in cycles):
            cycles.append(cycle)
    reason = "" if cycles else _why_none(describing, largest_parts[:, 0], bool(crossings))
    return LimitCycles(tuple(sorted(cycles, key=lambda one: one.amplitude)), reason)


@dataclass(frozen=True)
class _Balance:
    """Poles of a closed loop over the amplitude."""

    at: Callable[[float], Array]  # amplitude -> mean deflection, stiffness, damping
    closed_loop: Loop
    on_axis: float  # real part, rad/s, up to which a pole lies on the imaginary axis

    @classmethod
    def of(cls, describing: DescribingFunction, closed_loop: Loop) -> "_Balance":
        from scipy.interpolate import PchipInterpolator

        columns = (describing.deflection, describing.stiffness, describing.damping)
        at = PchipInterpolator(describing.amplitudes, np.column_stack(columns))
        first = cls(at, closed_loop, 0.0)
        largest = max(np.abs(first.poles(one)).max() for one in describing.amplitudes)
        return cls(at, closed_loop, ON_AXIS * float(largest))

    def poles(self, amplitude: float) -> Array:
        """Poles, (n,) complex array, rad/s; by falling real part."""
        _, stiffness, damping = self.at(amplitude)
        loop = self.closed_loop(float(stiffness), float(damping))
        if loop.isdtime(strict=True):
            raise LinearisationError(
                "the closed loop is in discrete time; approximate the controller in continuous "
                "time, its delay by control.pade"
            )
        poles = np.asarray(loop.poles())
        return poles[np.argsort(-poles.real, kind="stable")]

    def real_parts(self, amplitude: float) -> Array:
        """Real parts of the poles beyond the axis, falling: each is continuous in the amplitude."""
        return self.poles(amplitude).real - self.on_axis

    def crossings(self, amplitudes: Array, parts: Array) -> list[tuple[float, bool]]:
        """Amplitudes at which a pole crosses the axis, and whether it does to the left."""
        from scipy.optimize import brentq

        found = []
        for step, rank in np.argwhere((parts[:-1] > 0) != (parts[1:] > 0)):
            ends = amplitudes[step : step + 2]
            root = brentq(lambda one, k=rank: self.real_parts(one)[k], *ends, xtol=ROOT)
            found.append((float(root), bool(parts[step, rank] > 0)))
        return found

    def cycle(self, amplitude: float, falling: bool) -> LimitCycle | None:
        """The limit cycle at a crossing; None where the pole is real, for it does not oscillate."""
        poles = self.poles(amplitude)
        near = 10.0 * self.on_axis
        pair = poles[(np.abs(poles.real) <= near) & (poles.imag > near)]
        if pair.size == 0:
            return None
        deflection, stiffness, damping = (float(one) for one in self.at(amplitude))
        return LimitCycle(
            amplitude=amplitude,
            deflection=deflection,
            frequency=float(pair[np.argmin(np.abs(pair.real - self.on_axis))].imag),
            stiffness=stiffness,
            damping=damping,
            attracting=falling and bool((poles.real <= near).all()),
        )


def _same(one: LimitCycle, other: LimitCycle) -> bool:
    """Whether two crossings are the two poles of one pair."""
    return bool(
        np.isclose(one.amplitude, other.amplitude, rtol=SAME, atol=0.0)
        and np.isclose(one.frequency, other.frequency, rtol=SAME, atol=0.0)
    )


def _why_none(describing: DescribingFunction, largest_parts: Array, crosses: bool) -> str:
    low, high = describing.amplitudes[[0, -1]]
    between = f"between {low:.4g} and {high:.4g} rad"
    if crosses:
        return f"a real pole crosses zero {between}: the loop drifts away without oscillating"
    if (largest_parts <= 0).all():
        return f"the loop is stable at every amplitude {between}"
    return f"the loop is unstable at every amplitude {between}"

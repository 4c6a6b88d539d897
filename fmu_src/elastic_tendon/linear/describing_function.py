"""The transmission as an oscillation sees it: equivalent stiffness and damping over amplitude.

A linear model holds within one slack state. A deflection that swings across a slack boundary meets
a torque that is no sinusoid; its first harmonic is that of a linear spring and damper whose numbers
depend on the amplitude. `limit_cycles` closes a loop with them.

A. Gelb, W. E. Vander Velde, Multiple-Input Describing Functions and Nonlinear System Design,
McGraw-Hill, 1968: chapter 2 (one sinusoid), chapter 6 (a sinusoid and a bias).
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from elastic_tendon.actuator.design import design
from elastic_tendon.actuator.interfaces import InterfaceKind
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.transmission import deflection_limits, slack_boundaries
from elastic_tendon.effects import BY_ID
from elastic_tendon.effects.base import Slot
from elastic_tendon.errors import LinearisationError
from elastic_tendon.linear.result import Array
from elastic_tendon.progress import Progress, silent
from elastic_tendon.result import Result, plain
from elastic_tendon.simulation.simulate import simulate

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

SAMPLES = 4096  # of a cycle; kinks then cost less than 1e-7 of the stiffness
PASSES = 25  # until the joint moves as it shall
HELD = 1e-7  # largest deviation from that, of the amplitude
CYCLES = 120  # until the torque repeats itself
AVERAGED = 80  # of these, where it never does
DRIFT = 0.5  # of the scatter: a larger one between two halves of them is no chance
SETTLED = 1e-6  # of the largest torque of a cycle
SOLVER = 1e-10  # tolerance of the simulations
HEAVY = {"link.inertia": 1e4, "link.damping": 1e4}  # kg·m², N·m·s/rad: hardly moved by tendons
ON_JOINT = (Slot.JOINT_TORQUE, Slot.DRY_FRICTION)  # what is no part of the transmission

GRID = 60  # default amplitudes, beside those on boundaries
SAME_AMPLITUDE = 1e-6  # of the largest; closer ones are one
REACH = 1.2  # the largest of them, of the farther deflection limit


@dataclass(frozen=True, repr=False)
class DescribingFunction(Result):
    """First harmonic of the tendons' torque while the deflection is `deflection + A cos(ωt)`.

    Attributes
    ----------
    model : of which it is
    amplitudes : (n,) array, rad; A, increasing
    deflection : (n,) array, rad; mean deflection, the same for all amplitudes unless it was asked
        for by the load that it carries
    frequency : rad/s; ω
    mean_torque : (n,) array, N·m; of the tendons on the joint, negative for positive deflection
    stiffness : (n,) array, N·m/rad; equivalent stiffness, of the torque in phase
    damping : (n,) array, N·m·s/rad; equivalent damping, of the torque in quadrature
    scatter : (n,) array, N·m/rad; standard deviation of the stiffness from cycle to cycle: 0 where
        the torque repeats itself, else stiffness and damping are means of 80 cycles
    """

    model: Model
    amplitudes: Array
    deflection: Array
    frequency: float
    mean_torque: Array
    stiffness: Array
    damping: Array
    scatter: Array

    @property
    def loss(self) -> Array:
        """Energy lost in a cycle, (n,) array, J; exact, since the deflection is one sinusoid."""
        return np.pi * self.frequency * self.damping * self.amplitudes**2

    def summary(self) -> str:
        """Amplitudes and mean, and how far stiffness and damping change over them."""
        lines = (
            f"  {len(self.amplitudes)} amplitudes  {_range(self.amplitudes)} rad",
            f"  mean deflection       {_range(self.deflection)} rad",
            f"  equivalent stiffness  {_range(self.stiffness)} N·m/rad",
            f"  equivalent damping    {_range(self.damping)} N·m·s/rad",
        )
        motion = self.model.motion
        at = f"{self.frequency:.4g} {motion.frequency_unit}"
        heading = f"Describing function of {self.model.name} at {at}"
        return "\n".join([heading, *map(motion.words, lines)])

    def to_dataframe(self) -> "pd.DataFrame":
        """A row for each amplitude, SI; the index is the amplitude, rad."""
        import pandas as pd

        names = ("deflection", "mean_torque", "stiffness", "damping", "scatter", "loss")
        index = pd.Index(self.amplitudes, name="amplitude")
        return pd.DataFrame({name: getattr(self, name) for name in names}, index=index)

    def to_dict(self) -> dict[str, Any]:
        """Name of the model, frequency, and a list of each figure over the amplitudes, SI."""
        columns = self.to_dataframe().reset_index().to_dict("list")
        content: dict[str, Any] = plain(columns)
        return {"model": self.model.name, "frequency": self.frequency} | content

    def plot(self) -> "Figure":
        """Draw equivalent stiffness over the amplitude; damping below, if there is any."""
        from elastic_tendon.reports.describing_function_figure import describing_function_figure
        from elastic_tendon.reports.worded import worded_figure

        return worded_figure(describing_function_figure(self), self.model.motion)


def _range(values: Array) -> str:
    low, high = f"{values.min():.4g}", f"{values.max():.4g}"
    return low if low == high else f"{low} to {high}"


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
    borders = (*slack_boundaries(model.transmission), *deflection_limits(model.transmission))
    touched = np.abs(np.array(borders) - deflection)
    largest = REACH * float(touched.max())
    every: Array = np.unique([*np.linspace(largest / GRID, largest, GRID), *touched])
    return every[np.diff(every, prepend=0.0) > SAME_AMPLITUDE * largest]


def describing_function(
    model: Model,
    amplitudes: ArrayLike | None = None,
    *,
    deflection: float | None = None,
    load_torque: float | None = None,
    frequency: float | None = None,
    progress: Progress = silent,
) -> DescribingFunction:
    """Equivalent stiffness and damping of the transmission over the amplitude of its deflection.

    The model is simulated with all its effects: the motor is held at 0, the joint swings as
    ``deflection + A cos(ωt)``, and the first harmonic of `joint_torque`, that of the tendons on the
    joint, is taken when it repeats itself. Effects that act on the joint itself (gravity, stops,
    dry friction and drag of the joint) are no part of the transmission and are left out. The
    joint swings and not the motor, since tendon friction is that of a moving joint pulley.

    Accuracy: kinks between samples cost less than 1e-7 of the stiffness, transients less than 1e-6
    of the largest torque of a cycle.

    Parameters
    ----------
    model : Model
    amplitudes : (n,) array, rad; positive, increasing; None: `default_amplitudes`
    deflection : rad; mean of the swing, 0 where nothing is given
    load_torque : N·m; instead of `deflection`: a constant load on the joint. The mean at each
        amplitude is then the one at which the mean torque of the tendons carries this load
    frequency : rad/s; None: the natural frequency with both tendons taut, where limit cycles live.
        Without damping, relaxation and spring mass it does not matter
    progress : told what is being done, and the share that is done

    Returns
    -------
    DescribingFunction

    Raises
    ------
    LinearisationError
        for wrong arguments, and where the torque still drifts after 120 cycles
    SimulationError, BuildError
        where the swing cannot be simulated

    References
    ----------
    Gelb and Vander Velde, 1968, chapters 2 and 6
    """
    model.check_interface("a describing function", (InterfaceKind.POSITION,))
    if deflection is not None and load_torque is not None:
        raise LinearisationError(
            "deflection and load_torque are both given, but one settles the other; give one"
        )
    omega = _positive(
        "frequency", design(model).frequency_state_3 if frequency is None else frequency
    )
    mean = _finite("deflection", deflection or 0.0)
    load = None if load_torque is None else _finite("load_torque", load_torque)
    chosen = default_amplitudes(model, mean) if amplitudes is None else _increasing(amplitudes)
    transmission_alone = _without_joint(model)
    results = []
    for index, amplitude in enumerate(chosen):
        progress("describing function", index / len(chosen))
        if load is not None:
            mean = _carrying(transmission_alone, load, float(amplitude), omega, mean)
        results.append((mean, *_first_harmonic(transmission_alone, mean, float(amplitude), omega)))
    means, torques, in_phase, quadrature, scatter = np.array(results).T
    return DescribingFunction(
        model=model,
        amplitudes=chosen,
        deflection=means,
        frequency=omega,
        mean_torque=torques,
        stiffness=-in_phase / chosen,
        damping=quadrature / (omega * chosen),
        scatter=scatter / chosen,
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
    """Torque over a cycle, N·m: ``mean + in_phase cos(ωt) + quadrature sin(ωt)``.

    `scatter` is the standard deviation of `in_phase` where several cycles were averaged.
    """

    mean: float
    in_phase: float
    quadrature: float
    scatter: float = 0.0


def _first_harmonic(model: Model, deflection: float, amplitude: float, omega: float) -> _Harmonic:
    """First harmonic of the torque when it repeats itself; the motor is at 0."""
    torque, state = _cycle(model, deflection, amplitude, omega, {}, np.zeros(SAMPLES + 2))
    harmonics = [_harmonic(torque)]
    previous_change = np.inf
    for _ in range(CYCLES - 1):
        torque, state = _cycle(model, deflection, amplitude, omega, state, torque)
        harmonics.append(_harmonic(torque))
        change = float(np.abs(np.subtract(harmonics[-1], harmonics[-2])).max())
        allowed = SETTLED * float(np.abs(torque).max())
        # what is still to come of a transient that dies out as it did in the last two cycles
        to_come = change / (1 - change / previous_change) if change < previous_change else np.inf
        if to_come <= allowed or change <= 0.01 * allowed:
            return harmonics[-1]
        previous_change = change
    averaged = _averaged(np.array(harmonics[-AVERAGED:]))
    if averaged is None:
        raise LinearisationError(
            f"{model.name}: {_where(model, amplitude, omega)} the {model.motion.words('torque')} "
            f"still drifts after {CYCLES} cycles; choose a frequency nearer to 1 / the time "
            "constant of what relaxes"
        )
    return averaged


def _averaged(harmonics: Array) -> _Harmonic | None:
    """Mean of torques that fluctuate (spring masses that bounce may), None where they drift.

    `harmonics` (n, 4), rows as `_Harmonic`.
    """
    first, second = np.split(harmonics, 2)
    scatter = harmonics.std(axis=0)
    if (np.abs(second.mean(axis=0) - first.mean(axis=0)) > DRIFT * scatter).any():
        return None
    mean, in_phase, quadrature, _ = harmonics.mean(axis=0)
    return _Harmonic(mean, in_phase, quadrature, scatter=scatter[1])


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
        f"{model.name}: {_where(model, amplitude, omega)} the joint cannot be "
        "moved against the tendons as exactly as needed; choose a higher frequency"
    )


def _where(model: Model, amplitude: float, omega: float) -> str:
    unit, per_time = model.motion.unit("rad"), model.motion.frequency_unit
    return f"at an amplitude of {amplitude:g} {unit} and {omega:g} {per_time}"


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

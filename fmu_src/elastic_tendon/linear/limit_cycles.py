"""Limit cycles of a closed loop around the transmission, by harmonic balance.

With equivalent stiffness and damping a loop is linear at each amplitude of the deflection. A limit
cycle is where poles of this linear loop lie on the imaginary axis.

A. Gelb, W. E. Vander Velde, Multiple-Input Describing Functions and Nonlinear System Design,
McGraw-Hill, 1968, chapter 3.
"""

from collections.abc import Callable
from dataclasses import asdict, dataclass, fields
from typing import TYPE_CHECKING, Any

import control
import numpy as np
from numpy.typing import NDArray

from elastic_tendon.errors import LinearisationError
from elastic_tendon.linear.describing_function import DescribingFunction
from elastic_tendon.linear.result import Array
from elastic_tendon.result import Result

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

Loop = Callable[[float, float], control.StateSpace]  # stiffness, damping -> closed loop

ON_AXIS = 1e-7  # real part of a pole on the imaginary axis, of the largest pole
ROOT = 1e-12  # rad, to which the amplitude of a limit cycle is found
SAME = 1e-4  # relative, of amplitude and frequency of one limit cycle that was found twice


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


@dataclass(frozen=True, repr=False)
class LimitCycles(Result):
    """All `cycles` between the amplitudes looked at; where there is none, `reason` says why.

    `describing` : the describing function with which they were found.
    """

    cycles: tuple[LimitCycle, ...]
    reason: str
    describing: DescribingFunction

    def summary(self) -> str:
        """Amplitude and frequency of each, and whether it attracts; else why there is none."""
        if not self.cycles:
            return f"no limit cycle: {self.reason}"
        return self.describing.model.motion.words(
            "\n".join(
                f"{'attracting' if cycle.attracting else 'repelling'} limit cycle: "
                f"amplitude {cycle.amplitude:.4g} rad, frequency {cycle.frequency:.4g} rad/s, "
                f"around {cycle.deflection:.4g} rad"
                for cycle in self.cycles
            )
        )

    def to_dataframe(self) -> "pd.DataFrame":
        """A row for each limit cycle, SI."""
        import pandas as pd

        columns = [figure.name for figure in fields(LimitCycle)]
        return pd.DataFrame([asdict(cycle) for cycle in self.cycles], columns=columns)

    def to_dict(self) -> dict[str, Any]:
        """Name of the model, all limit cycles, and the reason where there is none, SI."""
        cycles = [asdict(cycle) for cycle in self.cycles]
        return {"model": self.describing.model.name, "cycles": cycles, "reason": self.reason}

    def plot(self) -> "Figure":
        """Draw the describing function, with the limit cycles on its stiffness."""
        from elastic_tendon.reports.describing_function_figure import describing_function_figure
        from elastic_tendon.reports.worded import worded_figure

        figure = describing_function_figure(self.describing, self.cycles)
        return worded_figure(figure, self.describing.model.motion)


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
    names = [
        (system.state_labels, system.input_labels, system.output_labels)
        for system in (first, second)
    ]
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
        matrices = [at_first + share * (at_second - at_first) for at_first, at_second in pairs]
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
    describing function was made: where the loop carries a load make it with `load_torque`, which is
    0 for unlike springs without load. The answer is approximate: the loop must pass the first
    harmonic much better than the others. For a model whose describing function depends on
    frequency, make it again at the one found.

    Parameters
    ----------
    describing : DescribingFunction; between its amplitudes cubic interpolation that keeps the shape
    closed_loop : callable: stiffness (N·m/rad), damping (N·m·s/rad) -> control.StateSpace of the
        closed loop in continuous time, always with as many states; see `interpolated`
        (``lambda stiffness, _: control.feedback(plant(stiffness), controller)``)

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
    largest_parts = np.array([balance.real_parts(swing) for swing in describing.amplitudes])
    crossings = balance.crossings(describing.amplitudes, largest_parts)
    cycles: list[LimitCycle] = []
    for amplitude, falling in crossings:
        cycle = balance.cycle(amplitude, falling)
        if cycle is not None and not any(_same(cycle, known) for known in cycles):
            cycles.append(cycle)
    reason = "" if cycles else _why_none(describing, largest_parts[:, 0], bool(crossings))
    by_amplitude = tuple(sorted(cycles, key=lambda cycle: cycle.amplitude))
    return LimitCycles(by_amplitude, reason, describing)


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
        largest = max(np.abs(first.poles(amplitude)).max() for amplitude in describing.amplitudes)
        return cls(at, closed_loop, ON_AXIS * float(largest))

    def poles(self, amplitude: float) -> NDArray[np.complex128]:
        """Poles, (n,) array, rad/s; by falling real part."""
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

    def _real_part(self, amplitude: float, rank: int) -> float:
        return float(self.real_parts(amplitude)[rank])

    def crossings(self, amplitudes: Array, parts: Array) -> list[tuple[float, bool]]:
        """Amplitudes at which a pole crosses the axis, and whether it does to the left."""
        from scipy.optimize import brentq

        crossings = []
        for step, rank in np.argwhere((parts[:-1] > 0) != (parts[1:] > 0)):
            low, high = amplitudes[step : step + 2]
            root = brentq(self._real_part, low, high, args=(rank,), xtol=ROOT)
            crossings.append((float(root), bool(parts[step, rank] > 0)))
        return crossings

    def cycle(self, amplitude: float, falling: bool) -> LimitCycle | None:
        """The limit cycle at a crossing; None where the pole is real, for it does not oscillate."""
        poles = self.poles(amplitude)
        near = 10.0 * self.on_axis
        pair = poles[(np.abs(poles.real) <= near) & (poles.imag > near)]
        if pair.size == 0:
            return None
        deflection, stiffness, damping = (float(value) for value in self.at(amplitude))
        return LimitCycle(
            amplitude=amplitude,
            deflection=deflection,
            frequency=float(pair[np.argmin(np.abs(pair.real - self.on_axis))].imag),
            stiffness=stiffness,
            damping=damping,
            attracting=falling and bool((poles.real <= near).all()),
        )


def _same(first: LimitCycle, second: LimitCycle) -> bool:
    """Whether two crossings are the two poles of one pair."""
    return bool(
        np.isclose(first.amplitude, second.amplitude, rtol=SAME, atol=0.0)
        and np.isclose(first.frequency, second.frequency, rtol=SAME, atol=0.0)
    )


def _why_none(describing: DescribingFunction, largest_parts: Array, crosses: bool) -> str:
    low, high = describing.amplitudes[[0, -1]]
    between = describing.model.motion.words(f"between {low:.4g} and {high:.4g} rad")
    if crosses:
        return f"a real pole crosses zero {between}: the loop drifts away without oscillating"
    if (largest_parts <= 0).all():
        return f"the loop is stable at every amplitude {between}"
    return f"the loop is unstable at every amplitude {between}"

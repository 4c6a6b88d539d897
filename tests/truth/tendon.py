"""A tendon with its spring between two points: force, memory, slack.

The elongation e of the spring follows from the distance L between the points, over the length at
which everything is at rest:

* taut and stiff, e = L;
* taut with a compliance c in series, c F = L - e, solved for e; with a damper e is a state;
* slack, the spring is free: e is where its own law gives no force. Without memory and
  compliance that length matters to nothing, and L stands for it. A spring that its damper alone
  slackens still pulls by its own law; it spans its tendon, e = L, until that force ends.

A Maxwell branch is formulated by its force F_m (a state), friction inside the spring by
`hysteresis.Branch` (part of the mode).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from truth.hysteresis import Branch
from truth.spring import Spring

Vector = NDArray[np.float64]

# half-widths of the hysteresis; each shifts an event by less than 1e-11 s at ordinary rates
FORCE_HYSTERESIS = 1e-10  # N
LENGTH_HYSTERESIS = 1e-14  # m
RATE_HYSTERESIS = 1e-12  # m/s
NEVER = -1.0  # value of a threshold that this mode does not have
ELONGATION_ERROR = 1e-16  # m, of a root


@dataclass(frozen=True)
class TendonMode:
    """What is frozen between events."""

    taut: bool = True
    spans: bool = False  # a slack spring that still pulls by its own law
    engaged: bool = False  # exact overstretch kink
    branch: Branch | None = None  # of the hysteresis


@dataclass(frozen=True)
class Reach:
    """Distance between the ends of a tendon over that at rest, m, and its rate, m/s."""

    length: float
    rate: float


def relay(on: bool, value: float, hysteresis: float) -> bool:
    """State of a two-valued mode that is on above and off below zero, with hysteresis.

    It changes at half the hysteresis, for which the solver stops at the whole: so the mode whose
    event was located changes in spite of rounding, and with it any that coincides.
    """
    return value > -0.5 * hysteresis if on else value >= 0.5 * hysteresis


def leaving(on: bool, value: float, hysteresis: float) -> float:
    """Threshold of a `relay`: negative in its present state, zero where the solver stops."""
    return (-value if on else value) - hysteresis


def root(function: Callable[[float], float], guess: float) -> float:
    """Zero of a rising function of an elongation (m), searched for around `guess`."""
    width = 1e-3
    while function(guess - width) > 0.0:
        width *= 2.0
    lower, width = guess - width, 1e-3
    while function(guess + width) < 0.0:
        width *= 2.0
    return float(brentq(function, lower, guess + width, xtol=ELONGATION_ERROR))


@dataclass(frozen=True)
class Tendon:
    """Equations of one tendon; `state` is its part of the state: F_m (N), then e (m)."""

    spring: Spring

    # ---- states ----------------------------------------------------------------------------

    @property
    def has_elongation(self) -> bool:
        """Whether the elongation of the spring is a state of its own."""
        return self.spring.compliance > 0.0 and self.spring.damping > 0.0

    @property
    def can_span(self) -> bool:
        """Whether its damper alone can slacken the spring, and it remembers the length then."""
        return self.spring.remembers and self.spring.damping > 0.0 and not self.has_elongation

    @property
    def scales(self) -> list[float]:
        """Ordinary size of each state: N, m."""
        relaxing = [] if self.spring.relaxation is None else [1.0]
        return [*relaxing, 0.01] if self.has_elongation else relaxing

    def begin(self, reach: Reach) -> tuple[TendonMode, list[float]]:
        """Mode and state of a tendon that starts like this, the spring relaxed where it then is."""
        length = reach.length
        mode, state = TendonMode(), [0.0] * len(self.scales)
        if self.spring.overstretch is not None:
            mode = TendonMode(engaged=length > self.spring.overstretch.engagement)
        elongation = self._balanced(mode, length, np.zeros(2), remembered=False)
        force = self.spring.static_force(elongation, mode.engaged)
        if self.spring.compliance == 0.0:
            force += self.spring.damping * reach.rate
        if force < 0.0 and (self.spring.remembers or self.has_elongation):
            mode = replace(mode, taut=False, spans=self.can_span and length > 0.0)
            elongation = length if mode.spans else 0.0  # a free relaxed spring has no force
        if self.has_elongation:
            state[-1] = elongation
        if self.spring.hysteresis is not None:
            mode = replace(mode, branch=self.spring.hysteresis.begin(elongation))
        return mode, state

    # ---- forces ----------------------------------------------------------------------------

    def _branch_force(self, state: Vector) -> float:
        return 0.0 if self.spring.relaxation is None else float(state[0])

    def _friction(self, mode: TendonMode, elongation: float) -> float:
        hysteresis = self.spring.hysteresis
        if hysteresis is None or mode.branch is None:
            return 0.0
        return hysteresis.force(mode.branch, elongation)

    def _own_force(self, mode: TendonMode, elongation: float, state: Vector) -> float:
        """Force of the spring without its damper, N."""
        return (
            self.spring.static_force(elongation, mode.engaged)
            + self._friction(mode, elongation)
            + self._branch_force(state)
        )

    def _slope(self, mode: TendonMode, elongation: float) -> float:
        """Derivative of the force by a quick change of the elongation, N/m."""
        slope = self.spring.static_slope(elongation, mode.engaged)
        if self.spring.hysteresis is not None and mode.branch is not None:
            slope += self.spring.hysteresis.slope(mode.branch, elongation)
        if self.spring.relaxation is not None:
            slope += self.spring.relaxation.stiffness
        return slope

    def _fading(self, state: Vector) -> float:
        """Rate at which the force falls at constant elongation, N/s."""
        relaxation = self.spring.relaxation
        return 0.0 if relaxation is None else float(state[0]) / relaxation.time_constant

    def _balanced(
        self, mode: TendonMode, length: float, state: Vector, *, remembered: bool = True
    ) -> float:
        """Elongation at which spring and series compliance balance, m."""
        compliance = self.spring.compliance
        if compliance == 0.0:
            return length

        def excess(elongation: float) -> float:
            own = (
                self._own_force(mode, elongation, state)
                if remembered
                else self.spring.static_force(elongation, mode.engaged)
            )
            return compliance * own - (length - elongation)

        return root(excess, length)

    def elongation(self, mode: TendonMode, reach: Reach, state: Vector) -> float:
        """Elongation e of the spring from rest, m."""
        if self.has_elongation:
            return float(state[-1])
        if mode.taut:
            return self._balanced(mode, reach.length, state)
        if mode.spans or (not self.spring.remembers and self.spring.compliance == 0.0):
            return reach.length
        return root(lambda e: self._own_force(mode, e, state), 0.0)

    def elongation_rate(self, mode: TendonMode, reach: Reach, state: Vector) -> float:
        """Rate e', m/s."""
        spring, fading = self.spring, self._fading(state)
        if mode.spans:
            return reach.rate
        if not mode.taut and not self.has_elongation and spring.relaxation is None:
            return 0.0
        if mode.taut and spring.compliance == 0.0:
            return reach.rate
        elongation = self.elongation(mode, reach, state)
        if self.has_elongation:
            pull = (reach.length - elongation) / spring.compliance if mode.taut else 0.0
            return (pull - self._own_force(mode, elongation, state)) / spring.damping
        slope = self._slope(mode, elongation)
        if not mode.taut:
            return fading / slope
        return (reach.rate + spring.compliance * fading) / (1.0 + spring.compliance * slope)

    def pull(self, mode: TendonMode, reach: Reach, state: Vector, *, damped: bool = True) -> float:
        """Force of the tendon before it is cut off, N; slack, a force of the same sign.

        A slack spring with memory is judged by the force that it would bear, with its present
        memory, at the length that the kinematics ask of it.
        """
        spring = self.spring
        if spring.compliance > 0.0:
            return (reach.length - self.elongation(mode, reach, state)) / spring.compliance
        damping = spring.damping * reach.rate if damped else 0.0
        if mode.taut or not spring.remembers:
            return self._own_force(mode, reach.length, state) + damping
        return self._at_present_memory(mode, reach.length, state)(reach.length) + damping

    def _at_present_memory(
        self, mode: TendonMode, length: float, state: Vector
    ) -> Callable[[float], float]:
        """Force (N) at any elongation (m) with friction and creep as they now are."""
        elongation = self.elongation(mode, Reach(length, 0.0), state)
        friction, branch_force = self._friction(mode, elongation), self._branch_force(state)
        relaxation = self.spring.relaxation
        stiffness = 0.0 if relaxation is None else relaxation.stiffness

        def force(at: float) -> float:
            elastic = self.spring.static_force(at, mode.engaged)
            return elastic + friction + branch_force + stiffness * (at - elongation)

        return force

    def tension(self, mode: TendonMode, reach: Reach, state: Vector) -> float:
        """Force on both ends, N; 0 where slack."""
        return self.pull(mode, reach, state) if mode.taut else 0.0

    def response(self, mode: TendonMode, reach: Reach, state: Vector) -> tuple[float, float]:
        """S (N/m) and P (N/s) of the undamped tension's rate, F' = S L' - P."""
        if not mode.taut:
            return 0.0, 0.0
        compliance, elongation = self.spring.compliance, self.elongation(mode, reach, state)
        if self.has_elongation:
            return 1.0 / compliance, self.elongation_rate(mode, reach, state) / compliance
        slope = self._slope(mode, elongation)
        series = 1.0 + compliance * slope
        return slope / series, self._fading(state) / series

    def rates(self, mode: TendonMode, reach: Reach, state: Vector) -> list[float]:
        """Time derivative of the state: N/s, m/s."""
        relaxation = self.spring.relaxation
        if relaxation is None and not self.has_elongation:
            return []
        rate = self.elongation_rate(mode, reach, state)
        fading = [] if relaxation is None else [relaxation.stiffness * rate - self._fading(state)]
        return [*fading, rate] if self.has_elongation else fading

    # ---- events ----------------------------------------------------------------------------

    @property
    def kinked(self) -> bool:
        """Whether there is an exact overstretch kink."""
        return self.spring.overstretch is not None and self.spring.overstretch.rounding == 0.0

    def _excess(self, mode: TendonMode, reach: Reach, state: Vector) -> float:
        assert self.spring.overstretch is not None
        return self.elongation(mode, reach, state) - self.spring.overstretch.engagement

    def thresholds(self, mode: TendonMode, reach: Reach, state: Vector) -> list[float]:
        """Numbers that are negative in `mode` and leave it at zero, rising; as many in a mode."""
        found = [leaving(mode.taut, self.pull(mode, reach, state), FORCE_HYSTERESIS)]
        if self.can_span and not mode.taut:
            own = self.pull(mode, reach, state, damped=False)
            found.append(leaving(mode.spans, own, FORCE_HYSTERESIS))
        if self.kinked:
            excess = self._excess(mode, reach, state)
            found.append(leaving(mode.engaged, excess, LENGTH_HYSTERESIS))
        if mode.branch is not None:
            rate = self.elongation_rate(mode, reach, state)
            found.append(leaving(True, mode.branch.direction * rate, RATE_HYSTERESIS))
            found.append(self._beyond_branch(mode, mode.branch, reach, state))
        return found

    def _beyond_branch(
        self, mode: TendonMode, branch: Branch, reach: Reach, state: Vector
    ) -> float:
        if math.isinf(branch.end):
            return NEVER
        travel = branch.direction * (self.elongation(mode, reach, state) - branch.end)
        return travel - LENGTH_HYSTERESIS

    def updated(
        self, mode: TendonMode, reach: Reach, state: Vector, width: float
    ) -> tuple[TendonMode, Vector]:
        """Mode and state right after an event; `width` 0 where the mode's history counts not."""
        if self.kinked:
            excess = self._excess(mode, reach, state)
            engaged = relay(mode.engaged, excess, width * LENGTH_HYSTERESIS)
            mode = replace(mode, engaged=engaged)
        pull = self.pull(mode, reach, state)
        if relay(mode.taut, pull, width * FORCE_HYSTERESIS) != mode.taut:
            mode, state = self._slackened_or_tightened(mode, reach, state)
        if self.can_span and not mode.taut:
            own = self.pull(mode, reach, state, damped=False)
            mode = replace(mode, spans=relay(mode.spans, own, width * FORCE_HYSTERESIS))
        return self._turned(mode, reach, state), state

    def _slackened_or_tightened(
        self, mode: TendonMode, reach: Reach, state: Vector
    ) -> tuple[TendonMode, Vector]:
        """The other of taut and slack; where a damper carried force the elongation can jump.

        What the spring remembers does not jump: its friction, and the creep e - F_m / k_m.
        """
        after = replace(mode, taut=not mode.taut, spans=False)
        if not self.spring.remembers or self.spring.compliance > 0.0:
            return after, state
        before = self.elongation(mode, reach, state)
        force = self._at_present_memory(mode, reach.length, state)
        if self.can_span and not after.taut and force(before) > 0.0:
            return replace(after, spans=True), state
        elongation = reach.length if after.taut else root(force, before)
        if self.spring.relaxation is not None:
            state = state.copy()
            state[0] += self.spring.relaxation.stiffness * (elongation - before)
        if self.spring.hysteresis is not None and mode.branch is not None:
            branch = self.spring.hysteresis.continued(
                mode.branch, before, elongation, mode.branch.direction
            )
            after = replace(after, branch=branch)
        return after, state

    def _turned(self, mode: TendonMode, reach: Reach, state: Vector) -> TendonMode:
        """The branch of the hysteresis on which the spring now moves."""
        hysteresis, branch = self.spring.hysteresis, mode.branch
        if hysteresis is None or branch is None:
            return mode
        rate = self.elongation_rate(mode, reach, state)
        if branch.direction * rate < -0.5 * RATE_HYSTERESIS:
            elongation = self.elongation(mode, reach, state)
            turned = hysteresis.continued(branch, elongation, elongation, -branch.direction)
            return replace(mode, branch=turned)
        if self._beyond_branch(mode, branch, reach, state) > -0.5 * LENGTH_HYSTERESIS:
            return replace(mode, branch=hysteresis.passed(branch))
        return mode

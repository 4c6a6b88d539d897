"""One tendon: springs with their effects, what is in series with them, slack, and their mass.

A *strand* is a piece that pulls: the springs of a side together with what is in series. A tendon
is one strand, or two with the springs' mass between them. A strand is taut while its force at the
length that the kinematics ask for is positive, (6); it then has that length. A slack spring with
memory has the elongation at which it carries no force, and its memory follows that; while only its
damper's push slackens the tendon, that is less than the length, and the spring keeps the length.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import SimpleNamespace

import casadi as ca

from elastic_tendon.actuator import transmission
from elastic_tendon.actuator.system import Symbols, linear_root
from elastic_tendon.actuator.variables import motor_half, series_elongation
from elastic_tendon.effects.base import Contribution, Slot, Spring, SpringHalves, Tendon
from elastic_tendon.effects.symbolic import Symbol, both, where


@dataclass(frozen=True)
class TendonForces:
    """What a tendon does to its ends.

    `joint`, `motor`: tensions there, N. `unbounded`: force at the motor, before a slack tendon cuts
    it off and without dampers, N; with it the pulley finds where it has no torque. `largest`:
    F_max,i = l_max,i k_i, (32), N.
    """

    joint: Symbol
    motor: Symbol
    unbounded: Symbol
    largest: Symbol
    overstretched: Symbol


@dataclass(frozen=True)
class _Side:
    """Numbers of one side: `spring` of one of its springs, with `parallel` of them; `sign` is 1 of
    the upper.

    `compliance` in series, m/N; `rest` length of the tendon where the deflection is zero, m.
    """

    spring: SimpleNamespace
    sign: float
    in_series: bool
    compliance: Symbol
    rest: Symbol
    largest: Symbol


@dataclass(frozen=True)
class _Law:
    """Law of one spring in its own symbols `elongation` (m) and `rate` (m/s).

    `force`, N; `static`, the same without rate; `growth`, time derivative of `static`, N/s.
    """

    elongation: ca.SX
    rate: ca.SX
    force: ca.SX
    static: ca.SX
    growth: ca.SX
    effects: list[tuple[str, Contribution]]

    @property
    def remembers(self) -> bool:
        """Whether the force depends on more than elongation and rate."""
        return any(added.rates for _, added in self.effects)

    def at(self, expression: ca.SX, elongation: Symbol, rate: Symbol) -> ca.SX:
        """An expression of this law at an elongation and rate."""
        own = ca.vertcat(self.elongation, self.rate)
        return ca.substitute(expression, own, ca.vertcat(elongation, rate))

    def rate_from(self, residual: ca.SX, elongation: Symbol) -> ca.SX:
        """Rate at which an expression of this law vanishes at an elongation."""
        return linear_root(self.at(residual, elongation, self.rate), self.rate)


@dataclass(frozen=True)
class _Strand:
    """A strand's tension, N; `unbounded` as of `TendonForces`; elongation of one spring, m."""

    tension: Symbol
    unbounded: Symbol
    elongation: Symbol


@dataclass(frozen=True)
class _Stretch:
    """Elongation (m) and rate (m/s) of one spring; force of its strand with and without dampers.

    `own`: whether the elongation is a state, which a slack spring changes by its own law; `start`
    of that state in a taut spring.
    """

    elongation: Symbol
    rate: Symbol
    force: Symbol
    static: Symbol
    own: Symbol = 0
    start: Mapping[str, Symbol] = field(default_factory=dict)


def tendon(
    s: Symbols,
    name: str,
    motor_end: tuple[Symbol, Symbol],
    joint_end: tuple[Symbol, Symbol],
) -> TendonForces:
    """Tensions of one tendon, (3), (4) and (6).

    Parameters
    ----------
    s : Symbols; gets rates and relations of the springs and their effects
    name : upper_spring or lower_spring
    motor_end, joint_end : position (m) and rate (m/s) of the tendon's ends along it, towards the
        motor, from where the deflection is zero
    """
    side = _side(s, name)
    if any(s.in_slot(Slot.SPRING_MASS)):
        forces, elongation = _with_mass(s, name, side, motor_end, joint_end)
    else:
        length = side.rest + motor_end[0] - joint_end[0]
        whole = _strand(s, name, side, length, motor_end[1] - joint_end[1])
        forces = (whole.tension, whole.tension, whole.unbounded)
        elongation = whole.elongation
    stretched = f"{name}.overstretched"
    s.relations.threshold(stretched, elongation / side.spring.max_deflection - 1)
    return TendonForces(*forces, side.largest, s.mode[stretched])


def _side(s: Symbols, name: str) -> _Side:
    spring = s.parameters(f"transmission.{name}")
    combined = spring.parallel * spring.stiffness
    pretension = s.parameter["transmission.pretension_force"]
    elements = s.fill(Slot.SERIES_ELEMENT, Tendon(combined), name)
    compliance = sum((element.value for element in elements), ca.SX(0))
    return _Side(
        spring,
        1.0 if name == "upper_spring" else -1.0,
        bool(elements),
        compliance,
        rest=transmission.prestretched_length(pretension, combined) + compliance * pretension,
        largest=combined * spring.max_deflection,
    )


def _with_mass(
    s: Symbols,
    name: str,
    side: _Side,
    motor_end: tuple[Symbol, Symbol],
    joint_end: tuple[Symbol, Symbol],
) -> tuple[tuple[Symbol, Symbol, Symbol], Symbol]:
    """Forces as of `TendonForces`, and mean elongation, of springs with a mass in the middle.

    Each half is a strand that is stretched like a whole one of twice its length.
    """
    strands: dict[str, _Strand] = {}

    def half(strand: str, inner: tuple[Symbol, Symbol], outer: tuple[Symbol, Symbol]) -> Symbol:
        length = side.rest + 2 * (inner[0] - outer[0])
        strands[strand] = _strand(s, strand, side, length, 2 * (inner[1] - outer[1]))
        return strands[strand].tension

    at_motor = motor_half(name)
    (answer,) = s.fill(
        Slot.SPRING_MASS,
        SpringHalves(
            *motor_end,
            *joint_end,
            parallel=side.spring.parallel,
            motor_half=lambda *middle: half(at_motor, motor_end, middle),
            joint_half=lambda *middle: half(name, middle, joint_end),
        ),
        name,
    )
    elongation = 0.5 * (strands[at_motor].elongation + strands[name].elongation)
    return (answer.joint, answer.motor, strands[at_motor].unbounded), elongation


def _strand(s: Symbols, name: str, side: _Side, length: Symbol, rate: Symbol) -> _Strand:
    """A strand of a total length (m) that changes at a rate (m/s)."""
    law = _law(s, name, side)
    parallel = side.spring.parallel
    if side.in_series:
        stretch = _in_series(s, name, side, law, length, rate)
    else:
        force = parallel * law.at(law.force, length, rate)
        stretch = _Stretch(length, rate, force, parallel * law.at(law.static, length, 0))
    taut = s.mode[f"{name}.taut"]
    slackens = s.parameter["transmission.slack"] > 0
    s.relations.threshold(f"{name}.taut", where(slackens, stretch.force / side.largest, 1))
    driving = stretch.elongation, stretch.rate
    if law.remembers or side.in_series:
        # nothing is solved for a taut spring
        free = s.root(where(taut, law.elongation, law.static), law.elongation, 0.0)
        free_rate = law.rate_from(law.growth, free)
        known = ca.logic_or(taut, stretch.own)
        if law.remembers:
            known = ca.logic_or(known, _spans(s, name, side, law, stretch))
        driving = where(known, stretch.elongation, free), where(known, stretch.rate, free_rate)
        s.start |= {state: where(taut, at, free) for state, at in stretch.start.items()}
    for place, added in law.effects:
        s.take(place, _at(law, added, *driving))
    return _Strand(where(taut, stretch.force, 0), stretch.static, stretch.elongation)


def _spans(s: Symbols, name: str, side: _Side, law: _Law, stretch: _Stretch) -> Symbol:
    """Whether a slack spring keeps the length of its tendon, as one that still pulls does.

    It is slack by its damper alone. Were it as short as it is without force, its memory would fade
    faster than the tendon shortens, and tighten it at once.
    """
    damped = law.at(ca.jacobian(law.force, law.rate), stretch.elongation, 0) > 0
    pushed = both(damped, s.mode[f"{name}.taut"] == 0)
    s.relations.threshold(f"{name}.spans", where(pushed, stretch.static / side.largest, -1))
    return s.mode[f"{name}.spans"]


def _law(s: Symbols, name: str, side: _Side) -> _Law:
    """Law of one spring of a strand, (3), with its effects."""
    spring = side.spring
    elongation, rate = ca.SX.sym("elongation"), ca.SX.sym("rate")
    at = Spring(elongation, rate, spring.stiffness, spring.max_deflection, side.sign)
    effects = s.answers(Slot.SPRING_LAW, at, name)
    force = transmission.spring_force(spring.stiffness, elongation, spring.damping, rate)
    force += sum((added.value for _, added in effects), ca.SX(0))
    static = ca.substitute(force, rate, 0)
    moved = {
        f"{place}.{state}": by for place, answer in effects for state, by in answer.rates.items()
    }
    growth = ca.jtimes(
        static,
        ca.vertcat(elongation, *(s.state[state] for state in moved)),
        ca.vertcat(rate, *moved.values()),
    )
    return _Law(elongation, rate, force, static, growth, effects)


def _in_series(
    s: Symbols, name: str, side: _Side, law: _Law, length: Symbol, rate: Symbol
) -> _Stretch:
    """How far one spring is stretched where something yields in series with it.

    A spring without damping stretches at once; with damping its elongation is a state, which
    relaxes by its own law while the tendon is slack.
    """
    parallel = side.spring.parallel
    yielding = parallel * side.compliance  # m per force of one spring
    present = side.compliance > 0
    state = s.state[series_elongation(name)]
    damping = law.at(ca.jacobian(law.force, law.rate), state, 0)
    damped = both(present, damping > 0)

    guess = length / (1 + yielding * side.spring.stiffness)
    at_once = s.root(law.elongation + yielding * law.static - length, law.elongation, guess)
    at_once_rate = law.rate_from(law.rate + yielding * law.growth - rate, at_once)

    pull = (length - state) / where(present, yielding, 1)
    regular = where(damped, 0, law.rate)  # where there is no damping to divide by
    tension = where(s.mode[f"{name}.taut"], pull, 0)
    delayed_rate = law.rate_from(law.force + regular - tension, state)

    s.rate[series_elongation(name)] = where(damped, delayed_rate, 0)
    return _Stretch(
        where(damped, state, at_once),
        where(damped, delayed_rate, at_once_rate),
        parallel * where(damped, pull, law.at(law.force, at_once, at_once_rate)),
        parallel * where(damped, pull, law.at(law.static, at_once, 0)),
        own=damped,
        start={series_elongation(name): at_once},
    )


def _at(law: _Law, added: Contribution, elongation: Symbol, rate: Symbol) -> Contribution:
    """A spring effect's contribution at the elongation and rate that drive it."""

    def placed(quantities: Mapping[str, Symbol]) -> dict[str, ca.SX]:
        return {
            name: law.at(ca.SX(quantity), elongation, rate) for name, quantity in quantities.items()
        }

    return Contribution(
        added.value,
        rates=placed(added.rates),
        starts=placed(added.starts),
        thresholds=placed(added.thresholds),
    )

"""Base model plus effects as one hybrid system, in CasADi symbols.

Between events the modes `r` (slack, engaged, sliding...) are constants, so every function is
smooth there. At an event the new modes are ``r+ = next_modes(x, u, p, r)`` and the states
``x+ = reset(x, u, p, r, r+)``. The chain follows the slots of `effects.base`.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from types import SimpleNamespace

import casadi as ca

from elastic_tendon import transmission
from elastic_tendon.effects.base import (
    Contribution,
    Effect,
    FrictionBounds,
    Joint,
    MotorAngle,
    Slot,
    Spring,
)
from elastic_tendon.symbolic import Symbol, both, where
from elastic_tendon.variables import JOINT_MOTION, SPRINGS, Interface, interface, places

# Half-width of the dead band around each threshold, in the threshold's own scale: large against
# the rounding of a located event, small against anything a user can see.
HYSTERESIS = 1e-10
VELOCITY_SCALE = 1.0  # rad/s, by which the joint's velocity is judged to have crossed zero


@dataclass(frozen=True)
class HybridSystem:
    """Equations of one structure; all fields are CasADi SX columns.

    `x` states, `u` inputs, `p` parameters, `r` modes, `r_next` modes after an event (used by
    `reset` only), in the order of `interface`.
    """

    interface: Interface
    x: ca.SX
    u: ca.SX
    p: ca.SX
    r: ca.SX
    r_next: ca.SX
    rates: ca.SX
    outputs: ca.SX
    indicators: ca.SX
    next_modes: ca.SX
    reset: ca.SX


class _Relations:
    """Collects, mode by mode, event indicators and transitions in the interface's order."""

    def __init__(self, mode_symbols: dict[str, Symbol]) -> None:
        self._mode = mode_symbols
        self._indicators: dict[str, list[Symbol]] = {}
        self._next: dict[str, Symbol] = {}

    def threshold(self, name: str, quantity: Symbol) -> None:
        """Mode 1 while `quantity` (of order one) is positive, with a dead band."""
        mode = self._mode[name]
        self._indicators[name] = [quantity + HYSTERESIS * (2 * mode - 1)]
        self._next[name] = quantity > HYSTERESIS * (0.5 - mode)

    def motion(self, name: str, velocity: Symbol, push_up: Symbol, push_down: Symbol) -> None:
        """Stick or slide: -1, 0, 1; `push_up`, `push_down` > 0 where the bounds cannot hold."""
        mode = self._mode[name]
        band = HYSTERESIS
        up = where(mode > 0, velocity + band, where(mode < 0, -1, push_up - band))
        down = where(mode < 0, -velocity + band, where(mode > 0, -1, push_down - band))
        self._indicators[name] = [up, down]
        moving = mode * mode
        slack = 0.5 * band * (1 - moving)
        from_rest = where(push_up > slack, 1, where(push_down > slack, -1, 0))
        kept = where(mode * velocity > -0.5 * band, mode, from_rest)
        released = where(ca.fabs(velocity) > band, ca.sign(velocity), from_rest)
        self._next[name] = where(moving, kept, released)

    def in_order(self) -> tuple[ca.SX, ca.SX]:
        """Indicators and next modes in the interface's order of modes."""
        indicators = [z for name in self._mode for z in self._indicators[name]]
        return ca.vertcat(*indicators), ca.vertcat(*(self._next[name] for name in self._mode))


class _Symbols:
    """Named symbols of one structure and the view of them that each effect gets."""

    def __init__(self, variables: Interface) -> None:
        self.x = ca.SX.sym("x", len(variables.states))
        self.u = ca.SX.sym("u", len(variables.inputs))
        self.p = ca.SX.sym("p", len(variables.parameters))
        self.r = ca.SX.sym("r", len(variables.modes))
        self.r_next = ca.SX.sym("r_next", len(variables.modes))
        self.state = dict(zip(variables.state_names, ca.vertsplit(self.x), strict=True))
        self.input = dict(
            zip((i.name for i in variables.inputs), ca.vertsplit(self.u), strict=True)
        )
        self.parameter = dict(zip(variables.parameter_names, ca.vertsplit(self.p), strict=True))
        self.mode = dict(zip((m.name for m in variables.modes), ca.vertsplit(self.r), strict=True))
        self.mode_next = dict(zip(self.mode, ca.vertsplit(self.r_next), strict=True))
        self.rate: dict[str, Symbol] = {}
        self.relations = _Relations(self.mode)

    def parameters(self, prefix: str) -> SimpleNamespace:
        """Parameters directly below a dotted prefix, by their last name."""
        start = prefix + "."
        return SimpleNamespace(
            **{
                path[len(start) :]: symbol
                for path, symbol in self.parameter.items()
                if path.startswith(start) and "." not in path[len(start) :]
            }
        )

    def call(
        self, effect: Effect, place: str, at: MotorAngle | Spring | Joint
    ) -> Contribution | FrictionBounds:
        """Evaluate an effect at one place and take over its state rates and relations."""
        state = SimpleNamespace(**{s.name: self.state[f"{place}.{s.name}"] for s in effect.states})
        mode = SimpleNamespace(**{m.name: self.mode[f"{place}.{m.name}"] for m in effect.relations})
        added = effect.equations(at, self.parameters(f"effects.{effect.id}"), state, mode)
        if isinstance(added, Contribution):
            for name, rate in added.rates.items():
                self.rate[f"{place}.{name}"] = rate
            for name, quantity in added.thresholds.items():
                self.relations.threshold(f"{place}.{name}", quantity)
        return added


@dataclass(frozen=True)
class _Tendon:
    tension: Symbol
    max_force: Symbol
    overstretched: Symbol


def _contributions(
    s: _Symbols, effects: tuple[Effect, ...], slot: Slot, place: str, at: Spring | Joint
) -> Iterator[Contribution]:
    """Contributions of every effect in a slot, at the place whose name starts with `place`."""
    for effect in effects:
        if effect.slot is slot:
            (name,) = (name for name in places(effect) if name.startswith(place))
            added = s.call(effect, name, at)
            assert isinstance(added, Contribution)
            yield added


def _motor_pulley(s: _Symbols, effects: tuple[Effect, ...]) -> tuple[Symbol, Symbol]:
    """Angle (rad) and rate (rad/s) of the motor pulley after every angle map."""
    t = s.parameters("transmission")
    angle = s.input["motor_position"]
    joint = s.state["joint_position"] * t.joint_pulley_radius / t.motor_pulley_radius
    for effect in effects:
        if effect.slot is Slot.ANGLE_MAP:
            added = s.call(effect, effect.id, MotorAngle(angle, joint))
            assert isinstance(added, Contribution)
            angle = added.value
    along = ca.vertcat(s.input["motor_position"], s.state["joint_position"])
    rates = ca.vertcat(s.input["motor_velocity"], s.state["joint_velocity"])
    return angle, ca.jtimes(angle, along, rates)


def _tendon(
    s: _Symbols, effects: tuple[Effect, ...], name: str, displacement: Symbol, rate: Symbol
) -> _Tendon:
    """Tension of one tendon, (3), (4) and (6): parallel equal springs, each with its effects."""
    one = s.parameters(f"transmission.{name}")
    combined = one.parallel * one.stiffness
    rest = transmission.prestretched_length(s.parameter["transmission.pretension_force"], combined)
    spring = Spring(rest + displacement, rate, one.stiffness, one.max_deflection)
    force = transmission.spring_force(one.stiffness, spring.elongation, one.damping, rate)
    for added in _contributions(s, effects, Slot.SPRING_LAW, name, spring):
        force += added.value
    max_force = combined * one.max_deflection
    s.relations.threshold(f"{name}.taut", one.parallel * force / max_force)
    s.relations.threshold(f"{name}.overstretched", spring.elongation / one.max_deflection - 1)
    return _Tendon(
        tension=where(s.mode[f"{name}.taut"], one.parallel * force, 0),
        max_force=max_force,
        overstretched=s.mode[f"{name}.overstretched"],
    )


def _joint_motion(
    s: _Symbols, effects: tuple[Effect, ...], joint: Joint, torque: Symbol, torque_scale: Symbol
) -> Symbol:
    """Acceleration of the joint; sets its rates and, with dry friction, its one stick relation.

    Link: ``J q'' = torque + friction`` with the friction inside the summed bounds.
    """
    s.rate["joint_position"] = joint.velocity
    bounds = [
        s.call(effect, effect.id, joint) for effect in effects if effect.slot is Slot.DRY_FRICTION
    ]
    inertia = s.parameter["link.inertia"]
    if not bounds:
        return torque / inertia
    lower = sum(bound.lower for bound in bounds if isinstance(bound, FrictionBounds))
    upper = sum(bound.upper for bound in bounds if isinstance(bound, FrictionBounds))
    at_rest = ca.substitute(ca.vertcat(torque + lower, torque + upper), joint.velocity, 0)
    s.relations.motion(
        JOINT_MOTION.name,
        joint.velocity / VELOCITY_SCALE,
        push_up=at_rest[0] / torque_scale,
        push_down=-at_rest[1] / torque_scale,
    )
    mode = s.mode[JOINT_MOTION.name]
    s.rate["joint_position"] = where(mode, joint.velocity, 0)
    return where(mode, (torque + where(mode > 0, lower, upper)) / inertia, 0)


def _reset(s: _Symbols) -> ca.SX:
    """States after an event: a joint that now sticks has no velocity."""
    after = dict(s.state)
    if JOINT_MOTION.name in s.mode:
        after["joint_velocity"] = where(
            s.mode_next[JOINT_MOTION.name], s.state["joint_velocity"], 0
        )
    return ca.vertcat(*after.values())


def _slack_state(upper_taut: Symbol, lower_taut: Symbol) -> Symbol:
    """Fig. 4 by number: I lower slack, II upper slack, III none, 4 both."""
    states = transmission.SlackState
    return where(
        both(upper_taut, lower_taut),
        int(states.III),
        where(upper_taut, int(states.I), where(lower_taut, int(states.II), int(states.BOTH))),
    )


def build(effect_ids: tuple[str, ...]) -> HybridSystem:
    """Equations of the model with the given effects.

    Parameters
    ----------
    effect_ids : tuple of catalogue ids, in any order

    Returns
    -------
    HybridSystem
    """
    variables = interface(effect_ids)
    effects = variables.effects
    s = _Symbols(variables)
    t = s.parameters("transmission")
    joint = Joint(s.state["joint_position"], s.state["joint_velocity"])

    # motor pulley, reflected to the joint (10); displacements of the springs (11)
    radii = (t.joint_pulley_radius, t.motor_pulley_radius)
    angle, angle_rate = _motor_pulley(s, effects)
    reflected = transmission.reflected_motor_position(angle, *radii)
    reflected_rate = transmission.reflected_motor_position(angle_rate, *radii)
    x_1 = transmission.displacement(joint.position, reflected, t.joint_pulley_radius)
    v_1 = transmission.displacement(joint.velocity, reflected_rate, t.joint_pulley_radius)

    # tendons and torque on the joint (7)
    upper, lower = (
        _tendon(s, effects, name, sign * x_1, sign * v_1)
        for name, sign in zip(SPRINGS, (1, -1), strict=True)
    )
    tendon_torque = transmission.joint_torque(upper.tension, lower.tension, t.joint_pulley_radius)

    # link
    torque = tendon_torque + s.input["load_torque"] - s.parameter["link.damping"] * joint.velocity
    for added in _contributions(s, effects, Slot.JOINT_TORQUE, "", joint):
        torque += added.value
    torque_scale = t.joint_pulley_radius * upper.max_force
    s.rate["joint_velocity"] = _joint_motion(s, effects, joint, torque, torque_scale)

    outputs = {
        "joint_torque": tendon_torque,
        "slack_state": _slack_state(s.mode["upper_spring.taut"], s.mode["lower_spring.taut"]),
        "joint_position": joint.position,
        "joint_velocity": joint.velocity,
        "deflection": joint.position
        - transmission.reflected_motor_position(s.input["motor_position"], *radii),
        "motor_torque": transmission.motor_torque(tendon_torque, *radii),
        "upper_spring_force": upper.tension,
        "lower_spring_force": lower.tension,
        "overstretched": ca.logic_or(upper.overstretched, lower.overstretched),
    }
    indicators, next_modes = s.relations.in_order()
    return HybridSystem(
        interface=variables,
        x=s.x,
        u=s.u,
        p=s.p,
        r=s.r,
        r_next=s.r_next,
        rates=ca.vertcat(*(s.rate[name] for name in variables.state_names)),
        outputs=ca.vertcat(*(outputs[name] for name in variables.output_names)),
        indicators=indicators,
        next_modes=next_modes,
        reset=_reset(s),
    )

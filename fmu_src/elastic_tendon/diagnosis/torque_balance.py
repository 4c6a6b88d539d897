"""The torque balance of what moves along a measured motion, for any set of effects.

With the motion given, the model's own equations say which torque acts on the link and the rotor,
where these are moved, and which torques sensors show; nothing is integrated but the memory of
springs and bristles.
They are evaluated over all samples at once, with exact derivatives, and no library is compiled.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import casadi as ca
import numpy as np
from scipy.linalg.lapack import dtbtrs

from elastic_tendon.actuator.interfaces import InterfaceKind
from elastic_tendon.actuator.model import build
from elastic_tendon.actuator.system import (
    HybridSystem,
    derivative_of_unknowns,
    newton_step,
    total_jacobian,
)
from elastic_tendon.actuator.variables import (
    LINK,
    ROTOR,
    Body,
    catalogue_order,
    moved_states,
    reading_of,
)
from elastic_tendon.comparison.residuals import Array
from elastic_tendon.diagnosis.instants import AtInstants
from elastic_tendon.effects.base import Effect, Slot
from elastic_tendon.effects.symbolic import one_at_a_time

PASSES = 3  # after which the modes of a chain of thresholds have settled
NEWTON_STEPS = 6
NO_DECAY = 1e-6  # of a state in one step, below which its rate is constant
_INPUTS = 4  # motor position and velocity, load torque, motor torque


@dataclass(frozen=True)
class Motion:
    """A measured motion at n evenly spaced instants.

    `step` : s between them. `position`, `velocity` : of the joint as its encoder shows them, rad
    and rad/s. `inputs_at` : motor position and velocity, load and motor torque (0 where it drives
    nothing), (n, 4), and their rates of change, where the joint's signals are late by so many s.
    `weights` : (n, 6), with which the joint counts as moving up, moving down, and held by friction,
    and then the motor.
    """

    step: float
    position: Array
    velocity: Array
    inputs_at: Callable[[float], tuple[Array, Array]]
    weights: Array


@dataclass(frozen=True)
class Torque:
    """A torque along a motion of n instants, N·m.

    `value` (n,), `by_parameter` (n, m); `by_position`, `by_velocity` (n,) : its slopes, N·m/rad and
    N·m·s/rad.
    """

    value: Array
    by_parameter: Array
    by_position: Array
    by_velocity: Array


@dataclass(frozen=True)
class Torques:
    """Torques along a motion: on the link and on the rotor where these are moved, without their
    inertia, and those that sensors show, by name."""

    moved: tuple[Torque, ...]
    shown: Mapping[str, Torque]


@lru_cache(maxsize=1024)
@one_at_a_time
def _balance_of(
    effects_present: tuple[Effect, ...],
    kind: InterfaceKind,
    paths: tuple[str, ...],
    shown: tuple[str, ...],
) -> "Balance":
    return Balance(build(tuple(effect.id for effect in effects_present), kind), paths, shown)


def torque_balance(
    effect_ids: Sequence[str],
    paths: Sequence[str],
    shown: Sequence[str] = (),
    kind: InterfaceKind = InterfaceKind.POSITION,
) -> "Balance":
    """The balance of a model with some effects.

    Parameters
    ----------
    effect_ids : of the model
    paths : dotted paths of the m parameters by which derivatives are wanted
    shown : outputs of the model that are torques and measured
    kind : interface of the model
    """
    # by the effects themselves: a user's own file may bring another law under the same id
    return _balance_of(catalogue_order(tuple(effect_ids)), kind, tuple(paths), tuple(shown))


class Balance:
    """Functions of one structure; see `torque_balance`."""

    def __init__(
        self, system: HybridSystem, paths: tuple[str, ...], shown: tuple[str, ...]
    ) -> None:
        self.system = system
        self.paths = paths
        self.shown = shown
        names = system.interface.parameter_names
        self._wanted = ca.vertcat(ca.SX(0, 1), *(system.p[names.index(path)] for path in paths))
        self._seen = _Seen(system)
        self._delay = ca.Function("delay", [system.p], [system.delay])

    def torques(self, values: Mapping[str, float], motion: Motion) -> Torques:
        """Torques and their derivatives along a motion.

        Parameters
        ----------
        values : every parameter of the model by its dotted path
        motion : Motion of n samples
        """
        interface = self.system.interface
        column = [values[name] for name in interface.parameter_names]
        p = np.array(column + [1.0] * interface.reads_signals)  # as the encoders read
        delay = float(self._delay(p))
        n, m = len(motion.position), len(self.paths)
        own = motion.position, motion.velocity, np.full(n, delay)
        data = np.column_stack([*own, *motion.inputs_at(delay)])
        memory, carried = self._memory(data, motion.step, p)
        columns = self._torques_at(n, data, motion.weights, memory, p)
        bodies = len(self._seen.moved)
        found = [
            _torque(part, m, carried)
            for part in np.split(columns, bodies + len(self.shown), axis=1)
        ]
        shown = dict(zip(self.shown, found[bodies:], strict=True))
        return Torques(tuple(found[:bodies]), shown)

    @cached_property
    @one_at_a_time
    def resolved(self) -> bool:
        """Whether the memory of effects is slow enough for the instants to show it.

        States that drive each other may oscillate between them, and damped springs behind a
        compliance follow every noise of the encoder.
        """
        slots = {effect.slot for effect in self.system.interface.effects}
        rates = self._seen.seen(self._seen.remembered(self.system.rates))
        return _apart(rates, self._seen.memory) and Slot.SERIES_ELEMENT not in slots

    @lru_cache(maxsize=512)  # noqa: B019 - of all balances together, which a search meets by dozens
    @one_at_a_time
    def _memory_along(self, n: int) -> ca.Function:
        """`_step` for n instants, one after the other."""
        return self._step.mapaccum(n)

    @cached_property
    @one_at_a_time
    def _torques_at(self) -> AtInstants:
        """(data, weights, memory, p) -> torques and derivatives, one column; see `_torque`."""
        seen, system = self._seen, self.system
        weights = ca.SX.sym("weights", 6)
        rows = []
        moved = (seen.total(body, weights) for body in seen.moved)
        for torque in (*moved, *(seen.shown(name, weights) for name in self.shown)):
            rows += [torque, seen.slope(torque, seen.position), seen.slope(torque, seen.velocity)]
            rows += [seen.slope(torque, symbol).T for symbol in (self._wanted, seen.memory)]
        column = seen.at_modes(ca.vertcat(*rows))
        arguments = [seen.data, weights, seen.memory, system.p]
        inner = ca.Function("inner", [*arguments, system.w], [column])
        found = inner(*arguments, seen.unknowns)
        return AtInstants(ca.Function("torques", arguments, [ca.cse(ca.densify(found))]))

    # ---- memory ------------------------------------------------------------------------------

    def _memory(self, data: Array, step: float, p: Array) -> tuple[Array, Array]:
        """States of effects along the motion, (n, s), and their derivatives (n, m, s)."""
        n, s, m = len(data), self._seen.memory.numel(), len(self.paths)
        if not s:
            return np.zeros((n, 0)), np.zeros((n, m, 0))
        start = self._start(data[0], p).full().ravel()
        known = np.append(p, step)
        inputs = np.hstack([data[:-1], data[1:], np.broadcast_to(known, (n - 1, len(known)))])
        moved = _evaluated(self._memory_along(n - 1), start[:s], inputs).reshape(n - 1, s)
        memory = np.vstack([start[:s], moved])
        if not m:
            return memory, np.zeros((n, 0, s))
        slopes = self._step_slopes(n - 1, memory[:-1], data[:-1], data[1:], known)
        by_memory, by_parameter = np.split(slopes, [s * s], axis=1)
        first = start[s:].reshape(m, s).T
        carried = _carried(first, by_memory.reshape(-1, s, s), by_parameter.reshape(-1, s, m))
        return memory, carried.transpose(0, 2, 1)

    @cached_property
    @one_at_a_time
    def _start(self) -> ca.Function:
        """(data, p) -> states at the first sample with derivatives; calculated ones settle."""
        seen, system = self._seen, self.system
        states = system.interface.states[seen.first :]
        declared = ca.DM([0.0 if state.start is None else state.start for state in states])
        calculated = ca.DM([state.start is None for state in states])
        arguments = [seen.data, seen.memory, system.p, system.w]
        settled = ca.Function(
            "settled", arguments, [seen.at_modes(seen.seen(seen.remembered(system.starts)))]
        )
        value: Any = declared
        for _ in range(PASSES):
            answer = settled(seen.data, value, system.p, seen.unknowns_at(value))
            value = ca.if_else(calculated, answer, declared)
        column = ca.vertcat(value, ca.vec(ca.jacobian(value, self._wanted)))
        return ca.Function("start", [seen.data, system.p], [ca.densify(column)])

    @cached_property
    def _moved(self) -> tuple[list[ca.SX], ca.SX]:
        """Arguments (memory, data, following, p and h) and the memory one step later."""
        seen, system = self._seen, self.system
        h, following = ca.SX.sym("h"), ca.SX.sym("following", seen.data.numel())
        rates = seen.at_modes(seen.seen(seen.remembered(system.rates)))
        arguments = [seen.data, seen.memory, system.p]
        rate = ca.Function("rate", [*arguments, system.w], [rates])
        rate = ca.Function("rate", arguments, [rate(*arguments, seen.unknowns)])
        step = _exponential if _apart(rates, seen.memory) else _rosenbrock
        moved = step(rate, seen.data, following, seen.memory, system.p, h)
        return [seen.memory, seen.data, following, ca.vertcat(system.p, h)], moved

    @cached_property
    def _step(self) -> ca.Function:
        """(memory, all else) -> memory one step later."""
        (memory, *others), moved = self._moved
        return ca.Function("step", [memory, ca.vertcat(*others)], [ca.cse(ca.densify(moved))])

    @cached_property
    @one_at_a_time
    def _step_slopes(self) -> AtInstants:
        """Arguments of `_moved` -> its derivatives by the memory and by the parameters, row by
        row."""
        arguments, moved = self._moved
        slopes = [ca.vec(ca.jacobian(moved, by).T) for by in (self._seen.memory, self._wanted)]
        column = ca.cse(ca.densify(ca.vertcat(*slopes)))
        return AtInstants(ca.Function("slopes", arguments, [column]))


def _torque(columns: Array, m: int, carried: Array) -> Torque:
    """A torque from its value, slopes, and derivatives by m parameters and by s states of effects,
    (n, 3 + m + s); `carried` (n, m, s) : derivatives of these states by the parameters."""
    by_parameter, by_memory = np.split(columns[:, 3:], [m], axis=1)
    if by_memory.shape[1]:
        by_parameter = by_parameter + np.einsum("ns,nms->nm", by_memory, carried)
    return Torque(columns[:, 0], by_parameter, columns[:, 1], columns[:, 2])


def _carried(first: Array, by_memory: Array, by_parameter: Array) -> Array:
    """Derivatives D (n, s, m) with D[0] = first and D[k + 1] = by_memory[k] D[k] + by_parameter[k].

    All at once, as a system of equations with a band below its diagonal.
    """
    n, s = len(by_memory) + 1, len(first)
    band = np.zeros((2 * s, n * s))
    for row in range(s):
        for column in range(s):
            band[s + row - column, column : (n - 1) * s : s] = -by_memory[:, row, column]
    given = np.concatenate([first[np.newaxis], by_parameter])
    found, _ = dtbtrs(band, given.reshape(n * s, -1), uplo="L", diag="U")
    return np.asarray(found).reshape(given.shape)


def _apart(rates: ca.SX, states: ca.SX) -> bool:
    """Whether no state drives another."""
    return bool(ca.jacobian_sparsity(rates, states).is_diag())


def _exponential(
    rate: ca.Function, before: ca.SX, after: ca.SX, state: ca.SX, p: ca.SX, h: ca.SX
) -> ca.SX:
    """Step of states that are apart: exact for linear relaxation under linear inputs."""
    rates = rate(before, state, p)
    change = rate(after, state, p) - rates
    decay = h * ca.diag(ca.jacobian(rates, state))
    small = ca.fabs(decay) < NO_DECAY
    divisor = ca.if_else(small, 1, decay)
    first = ca.if_else(small, 1 + 0.5 * decay, ca.expm1(decay) / divisor)
    second = ca.if_else(small, 0.5, (first - 1) / divisor)
    return state + h * (first * rates + second * change)


def _rosenbrock(
    rate: ca.Function, before: ca.SX, after: ca.SX, state: ca.SX, p: ca.SX, h: ca.SX
) -> ca.SX:
    """Step of states that drive each other, second order and L-stable (Verwer et al., SIAM
    Journal on Scientific Computing 20(4), 1999)."""
    gamma = 1 - 0.5**0.5
    matrix = ca.SX.eye(state.numel()) - gamma * h * ca.jacobian(rate(before, state, p), state)
    first = ca.solve(matrix, rate(before, state, p))
    second = ca.solve(matrix, rate(after, state + h * first, p) - 2 * first)
    return state + h * (1.5 * first + 0.5 * second)


def _evaluated(function: ca.Function, *arguments: Array) -> Array:
    """Flat result of a dense function of arrays (n, k), which casadi reads as (k, n)."""
    buffer: Any
    buffer, evaluate = function.buffer()
    kept = [np.ascontiguousarray(argument, dtype=np.float64) for argument in arguments]
    found = np.empty(function.numel_out(0))
    for index, argument in enumerate(kept):
        if argument.size:
            buffer.set_arg(index, argument.data)
    buffer.set_res(0, found.data)
    evaluate()
    return found


def _weights_of(body: Body, weights: ca.SX) -> list[ca.SX]:
    """With which a body moves up, moves down, and rests, of those of `Motion`."""
    first = 0 if body is LINK else 3
    return ca.vertsplit(weights[first : first + 3])


class _Seen:
    """Expressions of a system in what a recording shows instead of its own states and inputs."""

    def __init__(self, system: HybridSystem) -> None:
        self.system = system
        interface = system.interface
        self.first = len(moved_states(interface.kind))  # states of effects come after these
        states = moved_states(interface.kind)
        self.moved = tuple(body for body in (LINK, ROTOR) if body.position in states)
        self.data = ca.SX.sym("data", 3 + 2 * _INPUTS)
        self.position, self.velocity = self.data[0], self.data[1]
        self.memory = ca.SX.sym("memory", len(interface.states) - self.first)
        late = system.delay - self.data[2]
        given = self.data[3 : 3 + _INPUTS] - self.data[3 + _INPUTS :] * late
        motor_position, motor_velocity, load, motor_torque = ca.vertsplit(given)
        joint, motor = (self.position, self.velocity), (motor_position, motor_velocity)
        known = {"load_torque": load, "motor_torque": motor_torque}
        for body, read in ((LINK, joint), (ROTOR, motor)):
            # the equations themselves tell the true angle of what is given
            own = self._true_motion(body, read, motor) if body in self.moved else read
            known |= dict(zip((body.position, body.velocity), own, strict=True))
        self._by = (
            ca.vertcat(*(known[name] for name in states), self.memory),
            ca.vertcat(*(known[name] for name in interface.input_names)),
        )

    def remembered(self, column: ca.SX) -> ca.SX:
        """The part of a column of all states that is of the memory of effects."""
        return column[self.first :]

    def _true_motion(
        self, body: Body, read: tuple[ca.SX, ca.SX], motor: tuple[ca.SX, ca.SX]
    ) -> tuple[ca.SX, ca.SX]:
        """Position and velocity of a body of which a sensor reads `read`, exact where its error is
        linear in that and in the motor's position; an acceleration stays as it was read."""
        system = self.system
        names, states = system.interface.output_names, system.interface.state_names
        if f"measured_{body.position}" not in names:
            return read
        shown = system.outputs[names.index(f"measured_{body.position}")]
        if system.interface.reads_signals:  # delays are exact: the inputs are shifted
            shown = ca.substitute(shown, system.p[-1], 1)
        own = system.x[states.index(body.position)]
        driving = self._motor_position()
        error = shown - own

        def seen(expression: ca.SX) -> ca.SX:
            moved = ca.substitute(expression, own, read[0])
            return moved if body is ROTOR else ca.substitute(moved, driving, motor[0])

        slope, slope_of_motor = seen(ca.jacobian(error, own)), seen(ca.jacobian(error, driving))
        drift = 0 if body is ROTOR else slope_of_motor * motor[1]
        return read[0] - seen(error) / (1 + slope), (read[1] - drift) / (1 + slope)

    def _motor_position(self) -> ca.SX:
        """The motor's position, a state or an input; without springs nothing depends on it."""
        interface = self.system.interface
        if not interface.kind.has_springs:
            return ca.SX.sym("no_motor")
        if ROTOR.position in interface.state_names:
            return self.system.x[interface.state_names.index(ROTOR.position)]
        return self.system.u[interface.input_names.index(ROTOR.position)]

    def seen(self, expression: ca.SX) -> ca.SX:
        """An expression of states and inputs at what is seen."""
        return ca.substitute([expression], [self.system.x, self.system.u], list(self._by))[0]

    @cached_property
    def modes(self) -> ca.SX:
        """Modes that belong to what is seen; that of dry friction is none of them."""
        found = ca.SX([mode.start for mode in self.system.interface.modes])
        nexts = self.seen(self.system.next_modes)
        for _ in range(PASSES):
            found = ca.substitute(nexts, self.system.r, found)
        return found

    def at_modes(self, expression: ca.SX) -> ca.SX:
        """An expression of modes at those that are seen."""
        return ca.substitute(expression, self.system.r, self.modes)

    @cached_property
    def unknowns(self) -> ca.SX:
        """Values of what is implicit, by Newton's method."""
        return self.unknowns_at(self.memory)

    def unknowns_at(self, memory: Any) -> ca.SX:
        """The same at other states of effects."""
        system = self.system
        if not system.w.numel():
            return ca.SX(0, 1)
        arguments = [self.data, self.memory, system.p, system.w]
        step = self.at_modes(newton_step(system.w, self.seen(system.residuals)))
        guess = self.at_modes(self.seen(system.guesses))
        improve = ca.Function("newton", arguments, [step])
        value = ca.Function("guess", arguments, [guess])(
            self.data, memory, system.p, ca.SX.zeros(system.w.numel())
        )
        for _ in range(NEWTON_STEPS):
            value = improve(self.data, memory, system.p, value)
        return value

    def slope(self, expression: ca.SX, symbol: ca.SX) -> ca.SX:
        """Derivative at constant modes, the unknowns following."""
        system = self.system
        unknowns_by_symbol = derivative_of_unknowns(self.seen(system.residuals), system.w, symbol)
        return total_jacobian(expression, symbol, system.w, unknowns_by_symbol)

    def _moving(self, body: Body, expression: ca.SX) -> tuple[ca.SX, ca.SX]:
        """An expression while the body moves up, and while it moves down."""
        names = [mode.name for mode in self.system.interface.modes]
        if body.motion not in names:
            value = self.seen(expression)
            return value, value
        mode = self.system.r[names.index(body.motion)]
        up, down = (self.seen(ca.substitute(expression, mode, sign)) for sign in (1, -1))
        return up, down

    def total(self, body: Body, weights: ca.SX) -> ca.SX:
        """Torque on a body; friction holds it as far as its bounds allow."""
        system = self.system
        inertia = system.p[system.interface.parameter_names.index(body.inertia)]
        rate = system.rates[system.interface.state_names.index(body.velocity)]
        up, down = self._moving(body, inertia * rate)
        if up is down:
            return up
        moves_up, moves_down, rests = _weights_of(body, weights)
        held = ca.fmax(up, 0) + ca.fmin(down, 0)
        return moves_up * up + moves_down * down + rests * held

    def shown(self, name: str, weights: ca.SX) -> ca.SX:
        """A torque, or the force of a tendon, as it is measured."""
        names = self.system.interface.output_names
        output = self.system.outputs[names.index(reading_of(name, names))]
        up, down = self._moving(LINK, output)
        if up is down:
            return up
        moves_up, moves_down, rests = _weights_of(LINK, weights)
        return moves_up * up + moves_down * down + rests * 0.5 * (up + down)

"""The plant of a model: its equations and their exact derivatives, evaluated by CasADi."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np

from elastic_tendon.actuator.interfaces import InterfaceKind
from elastic_tendon.actuator.model import build
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.system import derivative_of_unknowns, newton_step, total_jacobian
from elastic_tendon.actuator.transmission import SlackState
from elastic_tendon.actuator.variables import JOINT_MOTION, SPRINGS, interface
from elastic_tendon.effects.registry import kept_by_ids
from elastic_tendon.effects.symbolic import one_at_a_time
from elastic_tendon.errors import LinearisationError
from elastic_tendon.linear.plant import Jacobians, Regime
from elastic_tendon.linear.result import Array

_MOST_ITERATIONS = 100
_CLOSE = 1e-12  # relative change after which an iteration has converged
_TAUT = {
    SlackState.I: (1, 0),
    SlackState.II: (0, 1),
    SlackState.III: (1, 1),
    SlackState.BOTH: (0, 0),
}


class Equations:
    """`Plant` of a model."""

    def __init__(self, model: Model) -> None:
        self.name, self.motion = model.name, model.motion
        self.transmission = model.transmission
        self._interface = interface(*model.structure)
        self.states = self._interface.state_names
        self.inputs = self._interface.input_names
        # what is discrete has no derivative
        kept = [i for i, output in enumerate(self._interface.outputs) if not output.discrete]
        self.outputs = tuple(self._interface.output_names[i] for i in kept)
        self.nominal = np.array([state.nominal for state in self._interface.states])
        self.mode_names = tuple(mode.name for mode in self._interface.modes)
        self._kept = kept
        self._functions = _functions(*model.structure)
        setting = [0.0] if self._interface.reads_signals else []  # the true motor position is given
        self._p = np.array([*model.values().values(), *setting])

    def start(self, u: Array, joint_position: float) -> Array:
        """States at rest; the calculated ones as the solver would start them."""
        calculated = np.array([state.start is None for state in self._interface.states])
        x = np.array([state.start or 0.0 for state in self._interface.states])
        x[0] = joint_position
        for _ in range(_MOST_ITERATIONS if calculated.any() else 0):
            modes = self._vector(self.settle(x, u).modes)
            start, slope = (self._call(name, x, u, modes) for name in ("starts", "starts_by_state"))
            within = np.ix_(calculated, calculated)
            step = np.linalg.solve(
                np.eye(int(calculated.sum())) - slope[within], (start[:, 0] - x)[calculated]
            )
            x[calculated] += step
            if np.all(np.abs(step) <= _CLOSE * self.nominal[calculated]):
                break
        return x

    def settle(self, x: Array, u: Array) -> Regime:
        """The regime that is active at a point."""
        modes = np.array([mode.start for mode in self._interface.modes])
        settled = self._followed(x, u, modes)
        if JOINT_MOTION.name in self.mode_names:  # decided last, with the true forces of tendons
            settled[self.mode_names.index(JOINT_MOTION.name)] = 0.0
            settled = self._followed(x, u, settled)
        return self._regime(settled, x, u)

    def sliding(self, regime: Regime, direction: int) -> Regime:
        """The regime with dry friction of the joint sliding: 1 up, -1 down; 0: sticking."""
        if JOINT_MOTION.name not in regime.modes:
            return regime
        return replace(regime, modes={**regime.modes, JOINT_MOTION.name: direction})

    def chosen(self, state: SlackState, modes: Mapping[str, int]) -> dict[str, int]:
        """Modes by name that a slack state and a choice of other modes come to.

        Raises
        ------
        LinearisationError
            for a mode that the model does not have, or a value that it cannot take
        """
        allowed = {mode.name: mode.values for mode in self._interface.modes}
        for name, value in modes.items():
            if name not in allowed:
                raise LinearisationError(
                    f"{self.name}: there is no mode {name!r}; there are {', '.join(allowed)}"
                )
            if value not in allowed[name]:
                listed = ", ".join(map(str, allowed[name]))
                raise LinearisationError(
                    f"{self.name}: mode {name} is one of {listed}, not {value}"
                )
        taut = zip(SPRINGS, _TAUT[state], strict=True)  # with a spring's mass: at the joint pulley
        return {f"{spring}.taut": value for spring, value in taut} | dict(modes)

    def holding(self, regime: Regime, chosen: Mapping[str, int]) -> Regime:
        """The regime with some of its modes chosen."""
        modes = {**regime.modes, **chosen}
        return self._regime(self._vector(modes), *regime.reached_at)

    def holds(self, x: Array, u: Array, regime: Regime) -> bool:
        """Whether a regime, once entered, stays at a point."""
        modes = self._vector(regime.modes)
        return np.array_equal(self._call("next_modes", x, u, modes)[:, 0], modes)

    def rates(self, x: Array, u: Array, regime: Regime) -> Array:
        """Time derivatives (n,) of the states, the regime held."""
        return self._call("rates", x, u, self._vector(regime.modes))[:, 0]

    def output(self, x: Array, u: Array, regime: Regime) -> Array:
        """Outputs (m,), the regime held."""
        return self._call("outputs", x, u, self._vector(regime.modes))[self._kept, 0]

    def jacobians(self, x: Array, u: Array, regime: Regime) -> Jacobians:
        """Derivatives, the regime held."""
        modes = self._vector(regime.modes)
        n = len(self.states)
        rates = self._call("rates_jacobian", x, u, modes)
        outputs = self._call("outputs_jacobian", x, u, modes)[self._kept]
        return Jacobians(rates[:, :n], rates[:, n:], outputs[:, :n], outputs[:, n:])

    def _followed(self, x: Array, u: Array, modes: Array) -> Array:
        """Modes that come of others, until they stay."""
        for _ in range(_MOST_ITERATIONS):
            following = self._call("next_modes", x, u, modes)[:, 0]
            if np.array_equal(following, modes):
                break
            modes = following
        return modes

    def _vector(self, modes: Mapping[str, int]) -> Array:
        return np.array([float(modes[name]) for name in self.mode_names])

    def _regime(self, modes: Array, x: Array, u: Array) -> Regime:
        named = {name: int(mode) for name, mode in zip(self.mode_names, modes, strict=True)}
        outputs = self._call("outputs", x, u, modes)[:, 0]
        slack = outputs[self._interface.output_names.index("slack_state")]
        return Regime(SlackState(int(slack)), named, (x.copy(), u.copy()))

    def _call(self, name: str, x: Array, u: Array, modes: Array) -> Array:
        """A function at a point, with the unknowns of implicit equations found first."""
        at = [x, u, self._p, modes]
        w = np.zeros(self._functions["newton"].shape[0])
        if w.size:
            w = self._functions["guess"](*at, w)[:, 0]
        for _ in range(_MOST_ITERATIONS if w.size else 0):
            following = self._functions["newton"](*at, w)[:, 0]
            change = np.abs(following - w).max()
            w = following
            if change <= _CLOSE * np.abs(w).max():
                break
        return self._functions[name](*at, w)


class _Evaluated:
    """A CasADi function of columns, called on numpy's memory: ten times faster than on its own."""

    def __init__(self, function: ca.Function) -> None:
        self.shape: tuple[int, int] = function.size_out(0)
        self._function = function  # the buffer does not keep it alive
        buffer, self._evaluate = function.buffer()
        self._buffer: Any = buffer  # CasADi's own types know of pointers only

    def __call__(self, *arguments: Array) -> Array:
        result = np.zeros(self.shape, order="F")
        arguments = tuple(np.ascontiguousarray(values, dtype=float) for values in arguments)
        for i, argument in enumerate(arguments):
            self._buffer.set_arg(i, argument.data)
        self._buffer.set_res(0, result.T.data)
        self._evaluate()
        return result


@kept_by_ids
@one_at_a_time
def _functions(effect_ids: tuple[str, ...], kind: InterfaceKind) -> dict[str, _Evaluated]:
    system = build(effect_ids, kind)
    arguments = [system.x, system.u, system.p, system.r, system.w]
    n = system.x.numel()
    v = ca.vertcat(system.x, system.u)
    unknowns_by_v = derivative_of_unknowns(system.residuals, system.w, v)
    by_v = {
        name: total_jacobian(getattr(system, name), v, system.w, unknowns_by_v) for name in _DERIVED
    }
    expressions = {
        "guess": system.guesses,
        "newton": newton_step(system.w, system.residuals) if system.w.numel() else system.w,
        "rates": system.rates,
        "outputs": system.outputs,
        "next_modes": system.next_modes,
        "starts": system.starts,
        "starts_by_state": by_v["starts"][:, :n],
        "rates_jacobian": by_v["rates"],
        "outputs_jacobian": by_v["outputs"],
    }
    return {
        name: _Evaluated(ca.Function(name, arguments, [ca.densify(expression)]))
        for name, expression in expressions.items()
    }


_DERIVED = ("rates", "outputs", "starts")

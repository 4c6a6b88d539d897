"""What a hybrid system is, and the symbols from which one is put together.

Between events the modes `r` (slack, engaged, sliding...) are constants, so every function is
smooth there. At an event the new modes are ``r+ = next_modes(x, u, p, r)`` and the states
``x+ = reset(x, u, p, r, r+)``.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import casadi as ca

from elastic_tendon.actuator.variables import Interface, places
from elastic_tendon.effects.base import Answer, Effect, FrictionBounds, Slot
from elastic_tendon.effects.symbolic import Symbol, where

# Half-width of the dead band around each threshold, in the threshold's own scale: large against
# the rounding of a located event, small against anything a user can see.
HYSTERESIS = 1e-10


@dataclass(frozen=True)
class HybridSystem:
    """Equations of one structure; all fields are CasADi SX columns.

    `x` states, `u` inputs, `p` parameters, `r` modes, `r_next` modes after an event (used by
    `reset` only), in the order of `interface`. `w` are unknowns of implicit equations: everything
    is a function of them too, and `residuals` vanish at their values, found from `guesses`.
    `starts` holds the start of each calculated state, and the other states themselves; `delay`
    (s) that of the signals measured at the joint.
    """

    interface: Interface
    x: ca.SX
    u: ca.SX
    p: ca.SX
    r: ca.SX
    r_next: ca.SX
    w: ca.SX
    residuals: ca.SX
    guesses: ca.SX
    rates: ca.SX
    outputs: ca.SX
    indicators: ca.SX
    next_modes: ca.SX
    reset: ca.SX
    starts: ca.SX
    delay: ca.SX


@dataclass(frozen=True)
class Implicit:
    """Unknowns and the equations that decide them, which are not linear; columns of like size."""

    unknown: ca.SX
    residual: ca.SX
    guess: ca.SX


def linear_root(residual: ca.SX, unknown: ca.SX) -> ca.SX:
    """Value of `unknown` at which `residual` vanishes, which is linear in it; (n,) columns."""
    zero = ca.SX.zeros(unknown.numel())
    slope = ca.jacobian(residual, unknown)
    return -_solved(slope, ca.substitute(residual, unknown, zero))


def derivative_of_unknowns(residuals: ca.SX, w: ca.SX, v: ca.SX) -> ca.SX:
    """Derivative of the unknowns `w` by `v`, by the implicit function theorem."""
    return -_solved(ca.jacobian(residuals, w), ca.jacobian(residuals, v))


def total_jacobian(expression: ca.SX, v: ca.SX, w: ca.SX, w_by_v: ca.SX) -> ca.SX:
    """Derivative by `v` with the unknowns `w` following."""
    return ca.jacobian(expression, v) + ca.jacobian(expression, w) @ w_by_v


def newton_step(w: ca.SX, residuals: ca.SX) -> ca.SX:
    """Next approximation to the unknowns."""
    return w - _solved(ca.jacobian(residuals, w), residuals)


def _solved(matrix: ca.SX, right: ca.SX) -> ca.SX:
    """Solution of linear equations, block after block of the triangle of blocks that they make.

    CasADi's own way with a matrix that is no triangle writes out a QR factorisation of all of it.
    """
    solution = ca.SX(*right.shape)
    _, row_order, column_order, row_starts, column_starts, *_ = matrix.sparsity().btf()
    known: list[int] = []
    for k in reversed(range(len(row_starts) - 1)):
        rows = row_order[row_starts[k] : row_starts[k + 1]]
        columns = column_order[column_starts[k] : column_starts[k + 1]]
        block, wanted = matrix[rows, columns], right[rows, :]
        if known:
            wanted -= matrix[rows, known] @ solution[known, :]
        solution[columns, :] = wanted / block if block.is_scalar() else ca.solve(block, wanted)
        known += columns
    return solution


class Relations:
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


class Symbols:
    """Named symbols of one structure, the view of them that each effect gets, what it answers.

    `pulley_angle` (rad) and `pulley_rate` (rad/s) of the motor pulley stand for themselves until
    everything that decides them is known.
    """

    def __init__(self, variables: Interface) -> None:
        self.effects = variables.effects
        self.x = ca.SX.sym("x", len(variables.states))
        self.u = ca.SX.sym("u", len(variables.inputs))
        self.p = ca.SX.sym("p", len(variables.parameters) + int(variables.reads_signals))
        self.r = ca.SX.sym("r", len(variables.modes))
        self.r_next = ca.SX.sym("r_next", len(variables.modes))
        self.pulley_angle = ca.SX.sym("pulley_angle")
        self.pulley_rate = ca.SX.sym("pulley_rate")
        self.as_measured = self.p[-1] if variables.reads_signals else ca.SX(0)
        self.state = _named(variables.state_names, self.x)
        self.input = _named(variables.input_names, self.u)
        self.parameter = _named(variables.parameter_names, self.p[: len(variables.parameters)])
        self.mode = _named((mode.name for mode in variables.modes), self.r)
        self.mode_next = dict(zip(self.mode, ca.vertsplit(self.r_next), strict=True))
        self.implicit: list[Implicit] = []
        self.rate: dict[str, Symbol] = {}
        self.start: dict[str, Symbol] = {}
        self.relations = Relations(self.mode)

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

    def root(self, residual: ca.SX, unknown: ca.SX, guess: Symbol) -> ca.SX:
        """Value of `unknown` at which `residual` vanishes; (n,) columns.

        An expression where the residual is linear, else symbols of unknowns that are found at
        run time, from `guess`.
        """
        if not ca.depends_on(ca.jacobian(residual, unknown), unknown):
            return linear_root(residual, unknown)
        solution = ca.SX.sym("w", unknown.numel())
        residual = ca.substitute(residual, unknown, solution)
        self.implicit.append(Implicit(solution, residual, ca.SX(guess)))
        return solution

    @property
    def unknowns(self) -> ca.SX:
        """Unknowns of all implicit equations."""
        return ca.vertcat(ca.SX(0, 1), *(equation.unknown for equation in self.implicit))

    def implicit_columns(self) -> dict[str, ca.SX]:
        """Residuals and guesses of all implicit equations."""
        return {
            "residuals": ca.vertcat(
                ca.SX(0, 1), *(equation.residual for equation in self.implicit)
            ),
            "guesses": ca.vertcat(ca.SX(0, 1), *(equation.guess for equation in self.implicit)),
        }

    def in_slot(self, slot: Slot) -> Iterator[Effect]:
        """Effects of a slot in the catalogue's order."""
        return (effect for effect in self.effects if effect.slot is slot)

    def answers(self, slot: Slot, at: object, strand: str = "") -> list[tuple[str, Any]]:
        """What the effects of a slot answer, each with its place; nothing is taken over yet.

        Parameters
        ----------
        slot : Slot
        at : place in the chain, as `Slot` says
        strand : in a spring's slot the name of the strand
        """
        return [
            (place, self.answer(effect, place, at))
            for effect in self.in_slot(slot)
            for place in places(effect, self.effects)
            if place == (f"{strand}.{effect.id}" if strand else effect.id)
        ]

    def take(self, place: str, answer: Answer) -> None:
        """Take over rates, starts and relations of an answer."""
        if not isinstance(answer, FrictionBounds):
            self.rate |= {f"{place}.{name}": rate for name, rate in answer.rates.items()}
            self.start |= {f"{place}.{name}": start for name, start in answer.starts.items()}
        for name, quantity in getattr(answer, "thresholds", {}).items():
            self.relations.threshold(f"{place}.{name}", quantity)

    def fill(self, slot: Slot, at: object, strand: str = "") -> list[Any]:
        """Answers of the effects of a slot, taken over."""
        answers = self.answers(slot, at, strand)
        for place, answer in answers:
            self.take(place, answer)
        return [answer for _, answer in answers]

    def answer(self, effect: Effect, place: str, at: object) -> Any:
        """What one effect answers at one place; nothing is taken over yet."""
        state = SimpleNamespace(**{s.name: self.state[f"{place}.{s.name}"] for s in effect.states})
        mode = SimpleNamespace(**{m.name: self.mode[f"{place}.{m.name}"] for m in effect.relations})
        return effect.equations(at, self.parameters(f"effects.{effect.id}"), state, mode)


def _named(names: Any, column: ca.SX) -> dict[str, Symbol]:
    return dict(zip(names, ca.vertsplit(column), strict=True))

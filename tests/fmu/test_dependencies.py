"""Dependencies against numbers: what is said not to matter, or to enter by a factor, is tried."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from descriptions import STRUCTURES, structure_name

from elastic_tendon.actuator.model import build
from elastic_tendon.actuator.system import derivative_of_unknowns, newton_step, total_jacobian
from elastic_tendon.fmu.dependencies import Dependence, dependencies

TRIALS = 12
PARTS = ("x", "u", "r", "tunable", "fixed")
# what is drawn anew without a factor of this kind changing
FREE = {
    Dependence.CONSTANT: PARTS,
    Dependence.FIXED: PARTS[:4],
    Dependence.TUNABLE: PARTS[:3],
    Dependence.DISCRETE: PARTS[:2],
}


class Numbers:
    """A structure with numbers: points at random, values and derivatives there."""

    def __init__(self, effect_ids):
        self.system = system = build(effect_ids)
        self.interface = system.interface
        self._random = np.random.default_rng(3)
        self._tunable = np.array([one.tunable for one in self.interface.parameters])
        n = len(self.interface.parameters)
        given = [system.x, system.u, system.p[:n], system.r, system.w]
        everything = ca.vertcat(system.outputs, system.rates, system.indicators)
        v = ca.vertcat(*given[:3])
        unknowns_by_v = derivative_of_unknowns(system.residuals, system.w, v)
        found = {
            "values": everything,
            "jacobian": ca.densify(total_jacobian(everything, v, system.w, unknowns_by_v)),
            "next_modes": system.next_modes,
            "guesses": system.guesses,
            "newton": newton_step(system.w, system.residuals),
        }
        results = ca.substitute(list(found.values()), [system.p[n:]], [0 * system.p[n:]])
        self._functions = {
            name: ca.Function(name, given, [one]) for name, one in zip(found, results, strict=True)
        }

    def draw(self, point=None, parts=PARTS):
        """A point, the same as another but for these parts."""
        point = dict(point or {})
        for part in parts:
            point[part] = getattr(self, f"_draw_{part}")()
        return point

    def _draw_x(self):
        nominal = np.array([state.nominal for state in self.interface.states])
        return nominal * self._random.uniform(-1.0, 1.0, len(nominal))

    def _draw_u(self):
        return self._random.uniform(-0.1, 0.1, len(self.interface.inputs))

    def _draw_r(self):
        return np.array([float(self._random.choice(one.values)) for one in self.interface.modes])

    def _draw_parameters(self, chosen):
        nominal = np.array([one.nominal for one in self.interface.parameters])
        return np.where(chosen, nominal * self._random.uniform(0.7, 1.4, len(nominal)), 0.0)

    def _draw_tunable(self):
        return self._draw_parameters(self._tunable)

    def _draw_fixed(self):
        return self._draw_parameters(~self._tunable)

    def at(self, name, point):
        """Value of a function at a point, implicit unknowns found."""
        given = [point["x"], point["u"], point["tunable"] + point["fixed"], point["r"]]
        w = np.zeros(self.system.w.numel())
        w = self._functions["guesses"](*given, w).full().ravel()
        for _ in range(40):
            w = self._functions["newton"](*given, w).full().ravel() if len(w) else w
        return self._functions[name](*given, w).full()

    def settled(self, point):
        """The point with the modes that follow from it."""
        for _ in range(3):
            point = point | {"r": self.at("next_modes", point).ravel()}
        return point

    def moved(self, point, column):
        """The point with one of v = [x; u; p] drawn anew."""
        for parts, size in ((("x",), len(point["x"])), (("u",), len(point["u"]))):
            if column < size:
                return self._move(point, parts[0], column)
            column -= size
        return self._move(point, "tunable" if self._tunable[column] else "fixed", column)

    def known(self, column):
        """Name of one of v."""
        interface = self.interface
        listed = (interface.states, interface.inputs, interface.parameters)
        return [one.name for group in listed for one in group][column]

    def _move(self, point, part, index):
        values = point[part].copy()
        values[index] = self.draw(parts=(part,))[part][index]
        return point | {part: values}


@pytest.fixture(scope="module", params=STRUCTURES, ids=structure_name)
def numbers(request):
    return Numbers(request.param)


@pytest.fixture(scope="module")
def kinds(numbers):
    """Kind of dependence of all rows of `values` on v."""
    found = dependencies(numbers.system)
    return np.vstack([found.outputs, found.rates, found.indicators])[:, :-1]


def test_what_is_not_listed_does_not_matter(numbers, kinds):
    for _ in range(TRIALS):
        point = numbers.settled(numbers.draw())
        values = numbers.at("values", point)
        for column in range(kinds.shape[1]):
            moved = numbers.settled(numbers.moved(point, column))
            changed = (numbers.at("values", moved) != values).ravel()
            assert not changed[kinds[:, column] == Dependence.NONE].any(), column


@pytest.mark.parametrize("kind", FREE, ids=lambda kind: kind.name.lower())
def test_a_factor_changes_only_with_what_it_may(numbers, kinds, kind):
    for _ in range(TRIALS):
        point = numbers.draw()
        factors = [
            numbers.at("jacobian", one)[kinds == kind]
            for one in (point, numbers.draw(point, FREE[kind]))
        ]
        assert factors[1] == pytest.approx(factors[0], rel=1e-9, abs=0.0)


def test_what_is_listed_matters_somewhere():
    """A list of everything would pass the tests above."""
    numbers = Numbers(())
    found = dependencies(numbers.system)
    listed = np.vstack([found.outputs, found.rates])[:, :-1] > 0
    seen = np.zeros_like(listed)
    for _ in range(300):
        point = numbers.settled(numbers.draw())
        values = numbers.at("values", point)[: len(listed)]
        for column in range(listed.shape[1]):
            moved = numbers.settled(numbers.moved(point, column))
            seen[:, column] |= (numbers.at("values", moved)[: len(listed)] != values).ravel()
    # what moves only the border of slack, and its dead band, is not met at random
    unseen = {numbers.known(column) for column in np.flatnonzero((listed & ~seen).any(axis=0))}
    assert not (seen & ~listed).any()
    assert {name.rpartition(".")[2].rpartition("_")[2] for name in unseen} == {
        *("velocity", "damping", "deflection", "slack")
    }


def _with(system, **columns):
    """The system with other expressions in these columns."""
    return replace(system, **{name: ca.vertcat(*listed) for name, listed in columns.items()})


def _named(system, row):
    """Kinds by name of the known, without those on which nothing depends."""
    interface = system.interface
    listed = (interface.states, interface.inputs, interface.parameters)
    names = [*(one.name for group in listed for one in group), "connected"]
    return {name: Dependence(int(kind)).name for name, kind in zip(names, row, strict=True) if kind}


def test_each_kind():
    base = build(())
    x, u, p, r = base.x, base.u, base.p, base.r
    tunable = [one.tunable for one in base.interface.parameters].index(True)
    system = _with(
        base,
        outputs=[
            2 * x[0],
            p[0] * x[0],
            p[tunable] * x[0],
            r[0] * x[0],
            x[1] * x[0],
            u[1],
            x[1] > 0,
            2 * u[0] + r[0],
        ],
        next_modes=[u[0] > 0, r[1], r[2], r[3]],
    )
    rows = [_named(system, row) for row in dependencies(system).outputs]
    kinds = ("CONSTANT", "FIXED", "TUNABLE", "DISCRETE", "DEPENDENT")
    assert tuple(row["joint_position"] for row in rows[:5]) == kinds
    # the mode follows from the motor's position, and from nothing else
    assert rows[3] == {"joint_position": "DISCRETE", "motor_position": "DEPENDENT"}
    assert rows[5] == {"motor_velocity": "FIXED", "connected": "DEPENDENT"}
    assert rows[6] == {"joint_velocity": "DEPENDENT"}
    # by a constant factor, and at events
    assert rows[7] == {"motor_position": "DISCRETE"}


def test_through_implicit_unknowns():
    """Each by its own equation, and by those of others."""
    base = build(())
    x, u, r = base.x, base.u, base.r
    w = ca.SX.sym("w", 2)
    system = _with(
        base,
        w=[w],
        residuals=[w[0] ** 3 + w[1] - u[0], w[1] - u[2] - r[1]],
        outputs=[x[0] + w[0], x[0] + w[1], x[0]],
        next_modes=[r[0], x[1] > 0, r[2], r[3]],
    )
    through_second = {"load_torque": "DEPENDENT", "joint_velocity": "DEPENDENT"}
    rows = [_named(system, row) for row in dependencies(system).outputs]
    own = {"joint_position": "CONSTANT"}
    assert rows == [
        own | through_second | {"motor_position": "DEPENDENT"},
        own | through_second,
        own,
    ]


def test_calculated_starts_are_put_in_each_others_place():
    """A start that another is calculated from gives way to what it comes from itself."""
    base = build(("tendon_compliance",))
    x, u = base.x, base.u
    first, second = (
        base.interface.state_names.index(f"{side}_spring.elongation") for side in ("upper", "lower")
    )
    starts = ca.vertsplit(x)
    starts[first], starts[second] = x[0] + x[second], u[0] * x[1]
    system = _with(base, starts=starts)
    found = dependencies(system).starts
    assert _named(system, found[first]) == {
        "joint_position": "CONSTANT",
        "joint_velocity": "DEPENDENT",
        "motor_position": "DEPENDENT",
    }


def test_derivatives_that_vanish_are_told_from_factors():
    """Enumerations and Booleans depend by comparisons, whose derivative is zero."""
    numbers = Numbers(())
    rows = [numbers.interface.output_names.index(one) for one in ("slack_state", "overstretched")]
    found = dependencies(numbers.system).outputs[rows]
    assert set(np.unique(found)) == {Dependence.NONE, Dependence.DEPENDENT}

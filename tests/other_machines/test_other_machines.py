"""The diagnosis on machines of other kinds; build_scripts/study_other_machines.py runs them all."""

import pytest

import elastic_tendon as et
from other_machines.cases import Case, Order, made, orders

ORDERS = list(orders(reported=False))
SAMPLE = "laminate_spring_hardening"  # in CI


def named(case: Case) -> bool:
    """Whether what is named is right, and is called missing or left unexplained."""
    found = et.diagnose(case.given, case.recordings)
    return frozenset(found.added) in case.right and found.verdict != "adequate"


@pytest.mark.parametrize(
    "order",
    [order for order in ORDERS if order.name.startswith(SAMPLE)],
    ids=lambda order: order.name,
)
def test_hidden_effects_are_named(order: Order) -> None:
    assert named(made(order))


@pytest.mark.slow
@pytest.mark.parametrize("order", ORDERS, ids=lambda order: order.name)
def test_hidden_effects_of_all_kinds_are_named(order: Order) -> None:
    assert named(made(order))

"""Expressions are built by one thread at a time: two at once crashed the program now and then."""

from concurrent.futures import ThreadPoolExecutor
from threading import Barrier, BrokenBarrierError

import pytest

from elastic_tendon.actuator.model import build
from elastic_tendon.diagnosis.torque_balance import torque_balance
from elastic_tendon.effects.symbolic import one_at_a_time
from elastic_tendon.native.codegen import generate

SETS = (("coulomb_friction",), ("gear_backlash",), ("spring_relaxation", "gravity_load"))


def test_two_threads_never_build_at_once() -> None:
    together = Barrier(2)

    @one_at_a_time
    def meet() -> None:
        together.wait(timeout=0.2)  # breaks unless two threads are here

    with ThreadPoolExecutor(2) as pool:
        for attempt in [pool.submit(meet), pool.submit(meet)]:
            with pytest.raises(BrokenBarrierError):
                attempt.result()


def test_who_builds_may_build_more() -> None:
    inner = one_at_a_time(lambda: 1)
    assert one_at_a_time(lambda: inner() + 1)() == 2


def test_threads_build_what_one_thread_builds() -> None:
    alone = [generate(build(effect_ids)) for effect_ids in SETS]
    with ThreadPoolExecutor(3) as pool:
        assert list(pool.map(lambda ids: generate(build(ids)), SETS)) == alone
        balances = list(pool.map(lambda ids: torque_balance(ids, ()), SETS))
    assert [balance.system.interface.effects for balance in balances] == [
        build(ids).interface.effects for ids in SETS
    ]

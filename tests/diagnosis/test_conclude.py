"""Which numbers a diagnosis calls changed."""

from types import SimpleNamespace

import pytest

from elastic_tendon.diagnosis.conclude import _changed
from elastic_tendon.identify.determinability import Estimate


def answer_with(*estimates):
    return SimpleNamespace(result=SimpleNamespace(findings=SimpleNamespace(estimates=estimates)))


def estimate(path, fitted, half_width, *, determined=True):
    interval = (fitted - half_width, fitted + half_width)
    return Estimate(path, "1", 1.0, fitted, 0.1, interval, determined)


@pytest.mark.parametrize(
    ("half_width", "changed"),
    # one sigma is 0.1; of few stretches of time the interval is wider than the usual 0.2
    [(0.2, ("link.inertia",)), (0.39, ("link.inertia",)), (0.41, ())],
)
def test_a_number_has_changed_only_where_its_interval_excludes_what_was_given(half_width, changed):
    assert _changed(answer_with(estimate("link.inertia", 1.4, half_width))) == changed


def test_of_many_numbers_one_that_barely_moved_is_chance():
    steady = [estimate(f"link.number_{one}", 1.0, 0.2) for one in range(19)]
    assert _changed(answer_with(estimate("link.inertia", 1.21, 0.2))) == ("link.inertia",)
    assert _changed(answer_with(estimate("link.inertia", 1.21, 0.2), *steady)) == ()


def test_effects_and_numbers_that_the_data_leave_open_do_not_count():
    effect = estimate("effects.coulomb_friction.torque", 2.0, 0.2)
    left_open = estimate("link.inertia", 2.0, 0.2, determined=False)
    assert _changed(answer_with(effect, left_open)) == ()

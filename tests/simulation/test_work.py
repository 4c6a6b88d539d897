"""What is simulated is counted, each piece of work by itself."""

from dataclasses import replace

import numpy as np

from elastic_tendon.comparison.residuals import InitialState, sensitivity, simulate_measurement
from elastic_tendon.estimation.fit import QUICK, fit
from elastic_tendon.simulation import work
from smooth_motion import GIVEN, played

RECORDING = played(GIVEN, 1.0).recording(2e-4)
REST = InitialState(0.0, 0.0)


def test_simulations_count_by_their_evaluations_and_derivatives() -> None:
    own, rest = work.Work(), work.Work()
    with work.counted(own):
        rates = simulate_measurement(GIVEN, RECORDING, REST).statistics["rates"]
        assert work.worked() == own.multiplications == work.multiplications_of(rates)
        with work.counted(rest):
            sensitivity(GIVEN, RECORDING, REST, ["link.inertia"])
        assert own.multiplications == work.multiplications_of(rates) + rest.multiplications
    assert rest.multiplications > work.multiplications_of(rates)
    assert work.worked() == 0.0  # nobody counts


def test_the_long_steps_of_a_static_curve_count_for_more() -> None:
    counts = [work.Work(), work.Work()]
    for own, static in zip(counts, (False, True), strict=True):
        with work.counted(own):
            rates = simulate_measurement(GIVEN, replace(RECORDING, static=static), REST).statistics
    assert counts[0].multiplications == work.multiplications_of(rates["rates"])
    assert counts[1].multiplications > 2 * counts[0].multiplications


def test_a_fit_ends_with_the_best_so_far_when_its_work_is_done() -> None:
    off = GIVEN.with_values({"link.inertia": 0.04})
    whole, cut = work.Work(), work.Work()
    with work.counted(whole):
        best = fit(off, [RECORDING], effort=QUICK)
    with work.counted(cut):
        first = fit(off, [RECORDING], effort=replace(QUICK, most=0.0))
    assert cut.multiplications < 0.5 * whole.multiplications
    assert best.sigmas[0]["joint_position"] < first.sigmas[0]["joint_position"] < np.inf


def test_enough_is_asked_of_the_work_under_way() -> None:
    with work.counted(work.Work(2.0 * work.AFFORDABLE)):
        assert work.enough()
    assert not work.enough()

"""What stands below bins: edges where there are numbers, names elsewhere."""

from elastic_tendon.comparison.bins import Bin
from elastic_tendon.reports.bin_axis import axis_below, by_variable


def bin_of(by: str, words: str, lower: float | None = None, upper: float | None = None) -> Bin:
    return Bin(by, words, lower, upper, 100, 1.0, 0.0, 0.5, None, stands_out=False)


def test_edges_of_a_range_lie_between_its_bins() -> None:
    bins = [bin_of("deflection", "a", -0.15, 4e-6), bin_of("deflection", "b", 4e-6, 12.3)]
    axis = axis_below(bins)
    assert axis.places == (-0.5, 0.5, 1.5)
    assert axis.labels == ("-0.15", "0", "12")
    assert axis.title == "deflection (rad)"
    assert axis.edges


def test_names_lie_below_their_bins() -> None:
    axis = axis_below([bin_of("slack_state", "I: lower slack"), bin_of("slack_state", "III: taut")])
    assert axis.places == (0.0, 1.0)
    assert axis.labels == ("I", "III")
    assert not axis.edges


def test_a_variable_with_a_single_bin_splits_nothing() -> None:
    bins = [bin_of("time", "a", 0, 1), bin_of("slack_state", "III"), bin_of("time", "b", 1, 2)]
    assert by_variable(bins) == {"time": [bins[0], bins[2]]}

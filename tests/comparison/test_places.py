"""The variable that tells most comes first, in the sentence as in the table."""

from elastic_tendon.comparison.bins import Bin
from elastic_tendon.comparison.places import by_concentration, densest


def bins(by: str, unit: str, shares: list[float], *, out: bool = True) -> list[Bin]:
    """Bins of equal counts from -1 on, each one wide."""
    return [
        Bin(
            *(by, f"{index - 1} to {index} {unit}", index - 1.0, float(index), 100),
            *(share**0.5, 0.0, share, 9.0, out),
        )
        for index, share in enumerate(shares)
    ]


EVEN = bins("joint_velocity", "rad/s", [0.25, 0.25, 0.25, 0.25])
ENDS = bins("deflection", "rad", [0.4, 0.1, 0.1, 0.4])
LAST = bins("motor_position", "rad", [0.0, 0.0, 0.05, 0.95])
WHEN = bins("time", "s", [0.0, 0.0, 0.0, 1.0])
BAND = bins("frequency", "Hz", [1.0, 0.0, 0.0, 0.0])


def test_the_most_concentrated_variable_comes_first_and_frequency_last() -> None:
    order = by_concentration([*BAND, *EVEN, *ENDS, *LAST])
    assert order == ["motor_position", "deflection", "joint_velocity", "frequency"]


def test_time_must_concentrate_clearly_more() -> None:
    assert by_concentration([*WHEN, *LAST])[0] == "motor_position"
    assert by_concentration([*WHEN, *ENDS])[0] == "time"


def test_the_densest_place_is_told_in_plain_words() -> None:
    expected = "95 % of the squared error lies at motor positions between 2 and 3 rad"
    assert densest([*BAND, *EVEN, *LAST]) == expected
    assert densest([*BAND, *ENDS]).endswith("at deflections below 0 or above 2 rad")
    assert densest(WHEN).endswith("lies between 2 and 3 s")
    assert densest([*BAND, *EVEN]).endswith("at frequencies between -1 and 0 Hz")


def test_what_is_dense_nowhere_is_everywhere_alike() -> None:
    assert densest(EVEN) == "the error stands out above the noise, everywhere alike"


def test_what_does_not_stand_out_is_no_place() -> None:
    assert "motor" not in densest(bins("motor_position", "rad", [0.0, 0.05, 0.95], out=False))

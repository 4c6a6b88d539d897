"""What is left, in words."""

from dataclasses import replace

from elastic_tendon.diagnosis.lack_of_fit import LackOfFit
from elastic_tendon.diagnosis.remaining_text import remaining_sentences

FOUND = LackOfFit(0.004, True, ("joint_position", "velocity_sign"), 0.79)


def said(lack: LackOfFit) -> list[str]:
    return list(remaining_sentences({"joint_position": lack}))


def test_on_what_it_depends_is_told_with_the_share() -> None:
    assert said(FOUND) == [
        "Of what is left of joint position, 79 % of the squared error can be predicted from joint "
        "position and the direction of motion, on stretches of time that were left out."
    ]


def test_neither_chance_nor_time_is_something_it_depends_on() -> None:
    assert said(replace(FOUND, significant=False)) == []
    assert said(replace(FOUND, variables=("time",))) == []

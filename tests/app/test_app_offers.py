"""One button takes over what a sentence advises, or what names suggest; never more."""

from elastic_tendon.app.document import Source
from elastic_tendon.app.offers import advised, guessed, missing, missing_in_words, taken

SOURCE = Source(key="a", name="run.csv")
LABELS = ("zeit", "enc_M", "winkel gelenk", "motor_current")


def test_every_missing_signal_is_named_at_once() -> None:
    assert missing(SOURCE, LABELS) == ("time", "motor_position", "joint_position")
    assert missing_in_words(SOURCE, LABELS).startswith(
        "run.csv: no names tell which columns are the time, the motor position and the joint "
        "position; choose them below"
    )
    known = ("time_s", "motor_position_rad", "j")
    assert missing(SOURCE, known) == ("joint_position",)
    assert missing_in_words(SOURCE, known) == ""  # told with the name that is nearest
    assert missing(SOURCE, ("joint_deflection_rad", "joint_torque_Nm")) == ()


def test_telling_names_are_suggested_and_those_of_other_quantities_are_not() -> None:
    (offer,) = guessed(SOURCE, LABELS)
    assert offer.items == ("time=zeit", "motor_position=enc_M", "joint_position=winkel gelenk")
    assert offer.words.endswith("motor position from enc_M and joint position from winkel gelenk.")


def test_a_word_counts_before_a_letter_and_two_alike_suggest_nothing() -> None:
    (offer,) = guessed(SOURCE, ("t", "q_motor", "q_joint"))
    assert offer.items == ("time=t", "motor_position=q_motor", "joint_position=q_joint")
    assert guessed(SOURCE, ("a", "motor1", "motor2")) == ()


def test_nothing_is_suggested_where_nothing_is_missing() -> None:
    mapped = SOURCE.changed(mapping=("time=zeit", "motor_position=enc_M"))
    done = mapped.changed(mapping=(*mapped.options.mapping, "joint_position=x"))
    assert guessed(done, (*LABELS, "x")) == ()
    assert guessed(SOURCE.changed(mapping=("run.toml",)), LABELS) == ()


def test_each_way_that_a_sentence_advises_is_an_offer() -> None:
    told = (
        "a: as declared the model errs by 3 times the spread; read it with --map "
        "joint_position=winkel gelenk:deg --map motor_position=enc_M:deg; or there is a gear: then "
        "read it with --map motor_position=enc_M*0.02; if the file is right, add --as-declared"
    )
    both, gear = advised(told, LABELS)
    assert both.items == ("joint_position=winkel gelenk:deg", "motor_position=enc_M:deg")
    assert both.words == (
        "joint position from winkel gelenk in deg and motor position from enc_M in deg."
    )
    assert gear.items == ("motor_position=enc_M*0.02",)


def test_advice_that_leaves_something_open_is_no_offer() -> None:
    assert advised("choose with --map time=COLUMN", LABELS) == ()
    assert advised("say it with --map time=zeit:UNIT", LABELS) == ()
    assert advised("give another unit with --map", LABELS) == ()
    quoted = 'say it with --map joint_position="winkel gelenk:deg" or the like'
    assert advised(quoted, LABELS)[0].items == ("joint_position=winkel gelenk:deg",)


def test_what_is_taken_replaces_what_was_said_of_the_same_signals() -> None:
    source = SOURCE.changed(mapping=("time=t", "joint_position=q"))
    assert taken(source, ("joint_position=q:deg",)) == ("time=t", "joint_position=q:deg")

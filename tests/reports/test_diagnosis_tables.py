"""What a diagnosis says on the terminal: the answer before the evidence, at 80 columns."""

import io
import re
from dataclasses import replace

import pytest
from rich.console import Console

from elastic_tendon.diagnosis.result import Remaining
from elastic_tendon.reports.diagnosis_tables import (
    CANDIDATES,
    Call,
    candidates_table,
    doubt_sentences,
    meant,
    next_lines,
    none_of_them,
    round_title,
    size_sentences,
)
from elastic_tendon.reports.neighbours import neighbours_table, would_show_table
from elastic_tendon.reports.recordings import recording_sentences
from hand_made_diagnosis import (
    RECORDINGS,
    TORQUE,
    friction_found,
    something_unknown,
)

CALL = Call("m.toml", ("a b.csv[0:7]",), (), ("--resample", "0.01"), None, None, None)


def joined(sentences) -> str:
    return "\n".join(sentences)


def printed(renderable) -> str:
    stream = io.StringIO()
    Console(file=stream, width=80).print(renderable)
    return stream.getvalue()


def test_sizes_are_told_with_intervals() -> None:
    text = joined(size_sentences(friction_found()))
    assert re.match(r"Added: Coulomb friction, torque 0.3[45]\d* ± 0.00\d+ N·m\.", text)
    assert "Parameters that are off too: link.inertia by +13 %." in text


def test_a_size_that_the_data_leave_open_is_said_to_be_so() -> None:
    found = friction_found()
    estimates = tuple(
        replace(estimate, determined=estimate.path != TORQUE)
        for estimate in found.findings.estimates
    )
    unsure = replace(found, findings=replace(found.findings, estimates=estimates))
    text = joined(size_sentences(unsure))
    assert "torque about 0.35 N·m, which these data leave open" in text


def test_wrong_numbers_are_told_with_interval_and_what_was_given() -> None:
    wrong = replace(friction_found(), verdict="wrong_parameter", added=())
    text = joined(size_sentences(wrong))
    sizes = r"Wrong parameters: link.inertia is 0.03[34]\d* ± 0.00\d+ kg·m², not 0.03 \(\+13 %\)\."
    assert re.match(sizes, text)


def test_what_no_effect_explains_is_told_as_such() -> None:
    found = something_unknown()
    doubts = joined(doubt_sentences(found))
    assert "still depends on what the machine does (p = 1e-06)" in doubts
    assert found.location.files[0].in_words["joint_position"] in doubts
    still = replace(found, added=("coulomb_friction",), model=friction_found().model)
    assert "Added: Coulomb friction" in joined(size_sentences(still))


def test_what_the_data_cannot_tell_apart_is_said() -> None:
    text = joined(doubt_sentences(friction_found()))
    assert "These data cannot distinguish: Coulomb friction and LuGre friction." in text
    assert "Coulomb friction was added; the others would do as well." in text
    assert "No motion tells the two apart." in text
    assert "demo_fit.csv: its noise is known badly." in text
    assert "does not depend on what the machine does by more than chance" in text


def test_remaining_error_of_each_signal_is_told() -> None:
    both = {
        "joint_position": Remaining(1.0, 0.0, False, False, 0.5),
        "joint_torque": Remaining(3.0, 0.001, True, False, 1e-3),
    }
    text = joined(doubt_sentences(friction_found(remaining=both)))
    assert "as given, too little to matter." in text
    assert "What remains of the joint torque error, 3.00 times the noise, still depends" in text
    assert "it is <1 % of the squared error" in text


def test_sets_that_cannot_be_told_apart_are_told_by_their_titles() -> None:
    alike = (("coulomb_friction", "gear_backlash+spring_mass"),)
    found = friction_found(indistinguishable=alike)
    text = joined(doubt_sentences(found))
    assert "distinguish: Coulomb friction and Gear backlash + Spring mass." in text
    assert meant(found) == ("coulomb_friction", "gear_backlash", "spring_mass")


def test_recordings_that_do_not_fit_in_are_named_once() -> None:
    text = joined(doubt_sentences(friction_found()))
    assert "the zero of the joint's encoder is 3 mrad off" in text
    assert "demo_validate.csv contradicts demo_fit.csv: no parameters" in text
    both = [
        replace(summary, contradicts=(recording.file,))
        for summary, recording in zip(RECORDINGS, RECORDINGS[::-1], strict=True)
    ]
    assert sum("contradicts" in sentence for sentence in recording_sentences(both)) == 1


def test_neighbours_are_told_in_words_and_fit_the_terminal() -> None:
    found = friction_found()
    table = neighbours_table(found)
    assert table is not None
    text = " ".join(printed(table).split())
    assert text.startswith("Nothing in the catalogue does better; nearest:")
    for words in (
        "LuGre friction instead 5 0.230 mrad a refit of Coulomb friction",
        "with Gear backlash 10 - the screen alone",
        "with Spring mass - - it cannot be simulated",
        "without Coulomb friction 12346 2.10 mrad",
        "1 more, see --all-candidates",
    ):
        assert words in text
    every = neighbours_table(found, every=True)
    assert every is not None
    assert every.row_count == len(found.neighbours)
    assert neighbours_table(replace(found, neighbours=())) is None
    stopped = neighbours_table(replace(found, complete=False))
    assert stopped is not None
    assert "does better" not in printed(stopped)
    for evidence, title in ((-3.0, "does clearly better"), (-20.0, "not all of those that may")):
        better = replace(found.neighbours[0], evidence=evidence)
        table = neighbours_table(replace(found, neighbours=(better, *found.neighbours)))
        assert table is not None
        assert title in printed(table)


def test_what_would_have_shown_is_told_with_its_size() -> None:
    table = would_show_table(friction_found().would_show)
    assert table is not None
    text = " ".join(printed(table).split())
    assert "Gravity load torque above 0.0123 N·m" in text
    assert "Spring mass at no plausible size" in text
    assert would_show_table(()) is None


def test_next_commands_can_be_typed() -> None:
    saved = replace(CALL, saved="my model.toml", experiment="next.csv")
    lines = next_lines(friction_found(), saved)
    commands = [line.strip() for line in lines if line.startswith("  ")]
    assert commands == [
        "elastic-tendon diagnose m.toml 'a b.csv[0:7]' new_recording.csv --resample 0.01",
        "elastic-tendon simulate 'my model.toml' next.csv -o predicted.csv",
        "elastic-tendon effects coulomb_friction",
        "elastic-tendon effects lugre_friction",
        "elastic-tendon export 'my model.toml' -o 'my model.fmu'",
    ]
    unsaved = joined(next_lines(friction_found(), CALL))
    assert "--save-model improved.toml" in unsaved
    assert "--next-experiment experiment.csv" in unsaved


def test_a_learned_term_is_offered_with_the_command_that_adds_it() -> None:
    text = joined(next_lines(something_unknown(), CALL))
    assert "A smooth function of joint velocity explains 83 % of what remains" in text
    written = replace(CALL, saved="m2.toml", learned="m2_learned.py")
    assert (
        "  elastic-tendon add m2.toml learned_torque 'a b.csv[0:7]' --resample 0.01 "
        "-o with_learned.toml --effect m2_learned.py"
    ) in next_lines(something_unknown(), written)


def test_own_effects_are_named_again() -> None:
    own = replace(CALL, effects=("--effect", "mine.py"))
    assert "  elastic-tendon effects coulomb_friction --effect mine.py" in next_lines(
        friction_found(), own
    )


@pytest.mark.parametrize("every", [False, True])
def test_candidates_come_with_the_evidence_and_fit_the_terminal(every: bool) -> None:
    found = friction_found().rounds[0]
    table = candidates_table(found, every=every)
    assert table is not None
    text = printed(table)
    assert table.row_count == 1 + (len(found.candidates) if every else CANDIDATES)
    assert ("3 more, see --all-candidates" in text) is not every
    assert "…" not in text
    words = " ".join(text.split())
    for word in ("93 %", "-12346", "98 %", "torque 0.3", "more numbers", "0.0311"):
        assert word in words
    for word in ("Quadratic drag +", "Spring mass"):
        assert word in text


def test_what_speaks_for_none_of_the_candidates_is_shown() -> None:
    first = friction_found().rounds[0]
    assert none_of_them(first) == pytest.approx(0.0)
    unlikely = [replace(candidate, probability=0.01) for candidate in first.candidates]
    undecided = replace(first, candidates=tuple(unlikely), chosen=())
    table = candidates_table(undecided)
    assert table is not None
    assert f"none of them {100 - len(unlikely)} %" in " ".join(printed(table).split())


def test_a_round_without_candidates_has_no_table() -> None:
    empty = friction_found().rounds[1]
    assert candidates_table(empty) is None
    assert round_title(2, empty) == "Round 2: nothing is left but noise. Nothing was added."

"""What is told of the candidates of a round."""

import pytest

from elastic_tendon.diagnosis.result import Candidate
from elastic_tendon.diagnosis.rounds import ENDED, _reason


def candidate(evidence: float) -> Candidate:
    """One that was not refitted, of which the screen expects so much."""
    ids = ("coulomb_friction",)
    return Candidate(
        ids=ids,
        probability=0.0,
        expected_parameters={},
        equivalence_class=(ids,),
        evidence=evidence,
    )


@pytest.mark.parametrize(("expected", "ended"), [(-400.0, True), (0.0, False)])
def test_a_round_without_refits_says_whether_any_promised_more(expected, ended):
    assert (_reason([candidate(expected)], ()) == ENDED) == ended

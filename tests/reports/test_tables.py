"""Tables of a fit show every figure whole at 80 columns, whatever the numbers are called."""

import io

from rich.console import Console

from elastic_tendon.estimation.determinability import Estimate, Findings, Ratio
from elastic_tendon.reports.tables import estimates_table, ratios_table, with_interval

LONG = "effects.tendon_guide_friction.wrap_friction_coefficient"
FINDINGS = Findings(
    3.0,
    (
        Estimate(LONG, "N.m.s/rad", 1.2345e-5, 3.72e-13, 1e-3, (0.0, 0.41234), True),
        Estimate(
            "transmission.upper_spring.stiffness", "N/m", 14400.0, 20970.0, 1.0, (0, 0), False
        ),
    ),
    (Ratio(f"{LONG} / J", "1/(m2.s)", 1.234e-6, (1.0e-7, 2.345e-6)),),
    (),
)


def printed(renderable) -> str:
    stream = io.StringIO()
    Console(file=stream, width=80).print(renderable)
    return stream.getvalue()


def test_estimates_are_whole() -> None:
    text = printed(estimates_table(FINDINGS))
    for figure in ("1.234e-05", "3.72e-13 (0 to 0.412)", "N·m·s/rad", "20970 (open)"):
        assert figure in text
    assert "…" not in text
    # the name is broken, not cut: what stands in the first column is all of it
    name = "".join(line[:32].strip().partition(" ")[0] for line in text.splitlines()[4:6])
    assert name == LONG.removeprefix("effects.")


def test_ratios_are_whole() -> None:
    text = printed(ratios_table(FINDINGS))
    for figure in ("1.23e-06 (1e-07 to 2.34e-06)", "1/(m²·s)"):
        assert figure in text
    assert "…" not in text


def test_a_number_without_noise_is_told_to_six_digits() -> None:
    surely = 0.312659999999
    assert with_interval(surely, (surely - 1.2e-11, surely + 1.2e-11)) == "0.312660 ± <1e-06"
    assert with_interval(12158.4, (12158.4 - 1e-5, 12158.4 + 1e-5)) == "12158.4 ± <0.1"
    assert with_interval(0.35, (0.3497, 0.3503)) == "0.35000 ± 0.00030"

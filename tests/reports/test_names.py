"""Names of recordings and models are drawn letter by letter."""

from matplotlib.cbook import is_math_text

from elastic_tendon.reports.names import LONGEST, shortened, verbatim


def test_dollars_are_no_formula() -> None:
    for name in ("a$b$c", "$", "$$", r"\\$x$", "plain"):
        assert not is_math_text(verbatim(name))
        assert verbatim(name).replace(r"\$", "$") == name


def test_a_long_name_keeps_its_ends() -> None:
    name = "$start" + 80 * "x" + "end$.csv"
    assert shortened("run.csv") == "run.csv"
    assert shortened(name).startswith(r"\$start")
    assert shortened(name).endswith(r"end\$.csv")
    assert len(shortened(name)) <= LONGEST + 2

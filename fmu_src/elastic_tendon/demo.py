"""The whole loop on bundled data: compare, refit, add what is missing."""

from pathlib import Path

from elastic_tendon.identify.add import Addition, Report, add
from elastic_tendon.measurement import read_measurement
from elastic_tendon.parameters import load_model
from elastic_tendon.report.comparison_figures import save, story

DATA = Path(__file__).parent / "data"
EFFECT = "coulomb_friction"
PICTURE = "elastic_tendon_demo.png"


def run(report: Report) -> Addition:
    """Add Coulomb friction to the bundled model, fitted to the first recording.

    Parameters
    ----------
    report : called with words and the share of the work done, 0 to 1

    Returns
    -------
    Addition
    """
    return add(
        load_model(DATA / "demo_model.toml"),
        EFFECT,
        [read_measurement(str(DATA / "demo_fit.csv"))],
        [read_measurement(str(DATA / "demo_validate.csv"))],
        report,
    )


def draw(addition: Addition, path: Path) -> None:
    """Write the picture of the way to the improved model."""
    save(story(addition.steps, addition.ladder), path)

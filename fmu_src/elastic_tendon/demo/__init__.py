"""The whole loop on bundled data: compare, refit, find out what is missing, add it."""

from pathlib import Path
from typing import NamedTuple

from elastic_tendon.actuator.parameters import Model, load_model
from elastic_tendon.diagnosis.diagnose import diagnose
from elastic_tendon.diagnosis.result import Diagnosis
from elastic_tendon.measurement import Measurement, read_measurement
from elastic_tendon.progress import Progress
from elastic_tendon.reports.comparison_figures import save, story

DATA = Path(__file__).parent
PICTURE = "elastic_tendon_demo.png"


class Demo(NamedTuple):
    """A model that lacks an effect, a recording to fit and one that no fit sees."""

    model: Model
    recording: Measurement
    validation: Measurement


def load_demo() -> Demo:
    """Load the bundled model and its two recordings, to try things on.

    Returns
    -------
    Demo; `model`, `recording` and `validation`
    """
    return Demo(
        load_model(DATA / "demo_model.toml"),
        read_measurement(str(DATA / "demo_fit.csv")),
        read_measurement(str(DATA / "demo_validate.csv")),
    )


def run(progress: Progress) -> Diagnosis:
    """Diagnose the bundled model, fitted to the first recording and judged by the second.

    Parameters
    ----------
    progress : called with words and the share of the work at hand that is done

    Returns
    -------
    Diagnosis
    """
    return diagnose(*load_demo(), progress=progress)


def draw(diagnosis: Diagnosis, path: Path) -> None:
    """Write the picture of the way to the improved model."""
    save(story(diagnosis.steps, diagnosis.ladder), path)

"""Add an effect that is suspected, in Python, and see how far it gets: `elastic-tendon add`.

    python examples/missing_friction/run.py [FOLDER]

A joint was recorded twice. Its model (a text file with the numbers its builders believe) misses
the recordings. The script compares, adds Coulomb friction, refits what is uncertain, prints how
the error falls, and draws ladder.png in FOLDER (default: here).
"""

import sys
from pathlib import Path

from elastic_tendon import demo, load_model
from elastic_tendon.comparison.compare import compare
from elastic_tendon.estimation.add import add
from elastic_tendon.measurement import read_measurement
from elastic_tendon.reports.comparison_figures import save, story


def main(folder: Path) -> None:
    model = load_model(demo.DATA / "demo_model.toml")
    recording = read_measurement(str(demo.DATA / "demo_fit.csv"))
    kept_apart = read_measurement(str(demo.DATA / "demo_validate.csv"))

    # how far is the model off?
    error = compare(model, [recording]).files[0].signals["joint_position"]
    print(f"as given: {1e3 * error.rmse:.3g} mrad RMS, {error.noise_ratio:.3g} times the noise")

    # what if there is friction? the second recording is never fitted, it only judges
    addition = add(model, "coulomb_friction", [recording], [kept_apart])
    for rung in addition.ladder:
        fitted, judged = rung.rmse["joint_position"], rung.heldout_rmse["joint_position"]
        print(f"{rung.title}: {1e3 * fitted:.3g} mrad fitted, {1e3 * judged:.3g} mrad held out")
    for one in addition.findings.estimates:
        low, high = one.interval
        print(f"{one.path}: {one.given:g} -> {one.fitted:.4g} ({low:.4g} to {high:.4g}) {one.unit}")

    save(story(addition.steps, addition.ladder), folder / "ladder.png")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)

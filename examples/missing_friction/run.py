"""Add an effect that is suspected, in Python, and see how far it gets: `elastic-tendon add`.

    python examples/missing_friction/run.py [FOLDER]

A joint was recorded twice. Its model (a text file with the numbers its builders believe) misses
the recordings. The script compares, adds Coulomb friction, refits what is uncertain, prints how
the error falls, and draws ladder.png in FOLDER (default: here).
"""

import sys
from pathlib import Path

import elastic_tendon as et


def main(folder: Path) -> None:
    demo = et.load_demo()

    # how far is the model off, and where?
    comparison = et.compare(demo.model, demo.recording)
    print(comparison)
    print(et.locate(comparison))

    # what if there is friction? no fit sees the second recording: it only judges
    addition = et.add(demo.model, "coulomb_friction", demo.recording, validate=demo.validation)
    for step in addition.ladder:
        fitted, heldout = step.rmse["joint_position"], step.heldout_rmse["joint_position"]
        print(f"{step.title}: {1e3 * fitted:.3g} mrad fitted, {1e3 * heldout:.3g} mrad held out")
    print(addition.to_dataframe().to_string(index=False))

    addition.plot().savefig(folder / "ladder.png")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)

"""Export every bundled model as an FMU.

    python build_scripts/build_fmus.py [--output FOLDER]

Writes FOLDER/<model>.fmu (default: build/fmus), replacing what is there.
"""

import argparse
import sys
from pathlib import Path

from elastic_tendon.errors import ElasticTendonError
from elastic_tendon.fmu.export import export_fmu
from elastic_tendon.parameters import bundled_models, load_model


def main() -> int:
    """Exit status: 0 done, 1 not possible."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--output", type=Path, default=Path("build/fmus"), metavar="FOLDER")
    folder: Path = parser.parse_args().output
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name in bundled_models():
            path = export_fmu(load_model(name), folder / f"{name}.fmu", overwrite=True)
            print(f"{path}  {path.stat().st_size / 1024:.0f} kB")
    except (ElasticTendonError, OSError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())

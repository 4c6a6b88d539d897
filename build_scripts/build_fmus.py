"""Export every bundled model as an FMU, for FMI 2.0 and 3.0.

    python build_scripts/build_fmus.py [--output FOLDER] [--platform NAME ...] [--source]

Writes FOLDER/fmi2/<model>.fmu and FOLDER/fmi3/<model>.fmu (default: build/fmus), replacing what is
there. A platform is one that `elastic-tendon export --platform` knows, or all; default: this one.
The first time, libraries for Windows are built, which takes minutes.
"""

import argparse
import sys
from pathlib import Path
from typing import get_args

from elastic_tendon.actuator.parameters import load_model, models
from elastic_tendon.errors import ElasticTendonError
from elastic_tendon.fmu.export import FmiVersion, export_fmu
from elastic_tendon.native.compiler import ALL, PLATFORMS


def main() -> int:
    """Exit status: 0 done, 1 not possible."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument(
        "--output",
        type=Path,
        default=Path("build/fmus"),
        metavar="FOLDER",
        help="where the folders fmi2 and fmi3 go (default: %(default)s)",
    )
    parser.add_argument(
        "--platform",
        action="append",
        metavar="NAME",
        help=f"{', '.join(PLATFORMS)}, or {ALL}; repeatable (default: this one)",
    )
    parser.add_argument("--source", action="store_true", help="pack the C code too (default: no)")
    chosen = parser.parse_args()
    try:
        for fmi_version in get_args(FmiVersion):
            folder = chosen.output / f"fmi{fmi_version}"
            folder.mkdir(parents=True, exist_ok=True)
            for name in models:
                path = export_fmu(
                    *(load_model(name), folder / f"{name}.fmu"),
                    fmi_version=fmi_version,
                    platforms=chosen.platform,
                    source=chosen.source,
                    overwrite=True,
                )
                print(f"{path}  {path.stat().st_size / 1024:.0f} kB", flush=True)
    except (ElasticTendonError, OSError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())

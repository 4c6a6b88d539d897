"""Export a model as a pythonfmu FMU: FMI 2.0, co-simulation, run by Python.

    python build_scripts/build_pythonfmu.py MODEL [-o X.fmu] [--force]

MODEL is a model.toml or the name of a bundled model; the file is named after the model unless
told otherwise. What the FMU needs where it runs is printed, and stands in its description.
"""

import argparse
import sys
from pathlib import Path

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.errors import ElasticTendonError
from elastic_tendon.fmu.export import model_identifier
from elastic_tendon.fmu.pythonfmu_flavour import export_pythonfmu, needs


def main() -> int:
    """Exit status: 0 done, 1 not possible."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument(
        "model", metavar="MODEL", help="a model.toml, or the name of a bundled model"
    )
    parser.add_argument(
        *("-o", "--output"),
        type=Path,
        metavar="X.fmu",
        help="FMU to write (default: <name of the model>_pythonfmu.fmu)",
    )
    parser.add_argument(
        "--force", action="store_true", help="replace a file that exists (default: no)"
    )
    arguments = parser.parse_args()
    try:
        model = load_model(arguments.model)
        path = arguments.output or Path(f"{model_identifier(model.name)}_pythonfmu.fmu")
        print(f"{export_pythonfmu(model, path, overwrite=arguments.force)} {needs()}")
    except ElasticTendonError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""Write the report of a result: one page that needs no network and prints well."""

from pathlib import Path

from elastic_tendon.comparison.comparison import Comparison
from elastic_tendon.comparison.locate import locate
from elastic_tendon.diagnosis.result import Diagnosis
from elastic_tendon.output import write_text
from elastic_tendon.reports.html.document import comparison_document, diagnosis_document
from elastic_tendon.reports.html.origin import origin_of


def report(result: Diagnosis | Comparison, path: str | Path, *, force: bool = False) -> None:
    """Write the report of a diagnosis or a comparison.

    Parameters
    ----------
    result : Diagnosis or Comparison
    path : of the page, whose name ends in .html; it is written whole or not at all
    force : whether a file that exists is replaced

    Raises
    ------
    OutputError : the file exists or cannot be written
    """
    first = result.steps[0].comparison if isinstance(result, Diagnosis) else result
    files = [file.measurement.source for file in first.files]
    origin = origin_of(
        "elastic_tendon.report(...)", [("data", Path(file)) for file in files if file]
    )
    where = locate(first)
    if isinstance(result, Diagnosis):
        text = diagnosis_document(result, where, origin)
    else:
        text = comparison_document(result, where, origin)
    write_text(Path(path), text, force=force)

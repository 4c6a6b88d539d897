"""Every notebook runs and shows what it speaks of; what it shows is not committed."""

from pathlib import Path

import pytest

NOTEBOOKS = sorted((Path(__file__).parents[1] / "examples" / "notebooks").glob("*.ipynb"))
PATIENCE = 300  # s for a cell, where compilers and other tests run beside it
SHOWN = {
    "first_steps": ("missing_effect: Coulomb friction is surely missing", "[effects.coulomb"),
    "your_own_recording": ("joint_position was read from enc2 in deg, times -1", "+ Coulomb"),
    "your_own_effect": ("missing_effect: Cable harness is surely missing", "actuator.fmu"),
    "controller_from_linear_models": ("to state II: +0.115 rad, +4.80 N·m", "no limit cycle: "),
}


def _text(output: dict) -> str:
    return output.get("text") or output.get("data", {}).get("text/plain", "")


def test_all_notebooks_are_here():
    assert {path.stem for path in NOTEBOOKS} == set(SHOWN)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_outputs_are_not_committed(path):
    import nbformat  # here: it takes a second, which every worker would spend on collecting tests

    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    for cell in notebook.cells:
        if cell.cell_type == "code":
            assert (cell.outputs, cell.execution_count, cell.metadata) == ([], None, {})


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_runs(path, tmp_path):
    import nbformat
    from nbclient import NotebookClient

    notebook = nbformat.read(path, as_version=4)
    folder = {"metadata": {"path": str(tmp_path)}}
    NotebookClient(notebook, timeout=PATIENCE, resources=folder).execute()
    outputs = [one for cell in notebook.cells for one in cell.get("outputs", [])]
    assert not [_text(one) for one in outputs if one.get("name") == "stderr"]
    shown = "\n".join(map(_text, outputs))
    assert all(text in shown for text in SHOWN[path.stem]), shown

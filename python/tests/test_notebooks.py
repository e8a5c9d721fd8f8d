"""The notebooks run from top to bottom, with the assertions in them."""

import pathlib

import pytest

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")
pytest.importorskip("ipykernel")

NOTEBOOKS = sorted((pathlib.Path(__file__).resolve().parents[1] / "notebooks").glob("*.ipynb"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(path):
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    assert not any(cell.get("outputs") for cell in notebook.cells), "commit it without outputs"
    nbclient.NotebookClient(notebook, timeout=120, kernel_name="python3").execute()
    shown = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    text = "".join(output.get("text", "") for output in shown)
    pages = [output["data"]["text/html"] for output in shown if "text/html" in output.get("data", {})]
    check_output[path.stem](text, pages)


def of_error_chart(text, pages):
    assert "Average NEES" in text
    assert len(pages) == 1 and "<iframe srcdoc=" in pages[0]


def of_first_steps(text, pages):
    assert "% of the position errors are within 3 sigma" in text and "window ATE 0.0" in text
    drawn = [page for page in pages if "<svg" in page]
    assert len(drawn) == 1 and "ATE" in drawn[0] and "<iframe" not in "".join(pages)


check_output = {"error_chart": of_error_chart, "first_steps": of_first_steps}

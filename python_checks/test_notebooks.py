"""The notebooks of the manual run, and print what stands in them. Skipped where nbclient is not installed
(python_checks/requirements-ci.txt)."""

import pytest
from support import ROOT

nbclient = pytest.importorskip("nbclient", reason="nbclient is not installed: python_checks/requirements-ci.txt has it")
nbformat = pytest.importorskip("nbformat")
pytest.importorskip("ipykernel")

NOTEBOOKS = sorted((ROOT / "tools/manual/notebooks").glob("*.ipynb"))


def printed(cell):
    """Texts, and kinds of pictures. A slow cell's text comes in several parts."""
    found = [""]
    for output in cell.outputs:
        if output.output_type == "stream":
            if output.name == "stdout":
                found[0] += output.text
        else:
            found += [sorted(output.data)] if "image/png" in output.data else [output.data["text/plain"]]
    return found


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_prints_what_stands_in_it(path, tmp_path, monkeypatch):
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path))
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setenv("PYDEVD_DISABLE_FILE_VALIDATION", "1")
    written = nbformat.read(path, as_version=4)
    run = nbformat.read(path, as_version=4)
    for cell in run.cells:
        if cell.cell_type == "code":
            cell.outputs = []
    nbclient.NotebookClient(run, timeout=300, kernel_name="python3", resources={"metadata": {"path": path.parent}}).execute()
    for before, after in zip(written.cells, run.cells):
        if before.cell_type == "code":
            assert printed(after) == printed(before), before.source


def test_there_are_six():
    assert [path.stem for path in NOTEBOOKS] == ["apophis", "satellite", "spice-and-astropy", "toutatis-1992-magnitudes", "toutatis-fit", "toutatis"]
    for path in NOTEBOOKS:
        kinds = [cell.cell_type for cell in nbformat.read(path, as_version=4).cells]
        assert kinds[0] == "markdown" and kinds.count("markdown") >= 3
        assert path.stat().st_size < 400_000

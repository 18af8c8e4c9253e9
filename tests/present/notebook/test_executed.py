# SPDX-License-Identifier: BSD-3-Clause
"""The notebook among the examples runs, and each cell shows what it is about."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import Any

import pytest

from tests.peer import require

NOTEBOOK = Path(__file__).parents[3] / "examples" / "double_pendulum.ipynb"
SHOWN = {
    "kn.sketch": ("image/svg+xml", "<svg"),
    "kn.derive": ("text/html", r"\dot{u}_{1} ="),
    "eom.accelerations": ("text/latex", r"\dot{u}_{2} ="),
    "kn.plot": ("image/png", ""),
    "kn.animate": ("text/html", "<iframe"),
    "kn.linearize": ("text/html", "<table"),
}
"""What each cell calls, and a form of what it shows with what is in it."""


@pytest.fixture(scope="module")
def cells(tmp_path_factory: pytest.TempPathFactory) -> list[Any]:
    client, formats = require("nbclient"), require("nbformat")
    require("ipykernel")
    folder = tmp_path_factory.mktemp("jupyter")
    with pytest.MonkeyPatch.context() as patch:
        for name in ("IPYTHONDIR", "JUPYTER_RUNTIME_DIR", "JUPYTER_DATA_DIR"):
            patch.setenv(name, str(folder / name.lower()))
        notebook = formats.read(NOTEBOOK, as_version=4)
        client.NotebookClient(notebook, timeout=120, kernel_name="python3").execute()
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


@pytest.mark.slow
def test_each_cell_shows_its_result(cells: list[Any]) -> None:
    assert len(cells) == len(SHOWN)
    for cell, (call, (form, part)) in zip(cells, SHOWN.items(), strict=True):
        assert call in cell.source
        (output,) = cell.outputs  # neither warnings nor anything printed
        assert part in output.data[form], call
        if form == "image/png":
            assert base64.b64decode(output.data[form]).startswith(b"\x89PNG")


@pytest.mark.slow
def test_what_is_kept_has_no_outputs() -> None:
    """Outputs grow old in a repository; whoever runs it makes them anew."""
    notebook = require("nbformat").read(NOTEBOOK, as_version=4)
    assert all(not cell.outputs and cell.execution_count is None for cell in notebook.cells if cell.cell_type == "code")

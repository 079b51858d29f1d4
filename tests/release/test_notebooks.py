"""The notebooks of the docs run in a kernel of Jupyter, and show mathematics and pictures."""

from __future__ import annotations

import base64
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from ..support.checkout import CHECKOUT

pytestmark = [pytest.mark.slow, pytest.mark.peers]
FOLDER = CHECKOUT / "docs" / "notebooks"
NAMES = sorted(p.stem for p in FOLDER.glob("*.md") if p.stem != "index")
#: For each of the ten; together they have five minutes on two cores.
MOST_SECONDS = 60
#: Notebooks about multivectors, which show them.
WITH_MATHEMATICS = {"multivectors", "kernels", "algorithms", "objects", "curves", "poses"}


def executed(name: str, folder: Path) -> Any:
    jupytext, nbclient = pytest.importorskip("jupytext"), pytest.importorskip("nbclient")
    book = jupytext.read(FOLDER / f"{name}.md", fmt="md:myst")
    client = nbclient.NotebookClient(
        book, timeout=MOST_SECONDS, kernel_name="python3", resources={"metadata": {"path": str(folder)}}
    )
    return client.execute()


def bundles(book: Any) -> Iterator[dict[str, str]]:
    for cell in book.cells:
        yield from (output["data"] for output in cell.get("outputs", ()) if "data" in output)


@pytest.mark.parametrize("name", NAMES)
def test_notebooks_run_and_show_what_they_are_about(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("MPLBACKEND", raising=False)  # pyplot's pictures go to the notebook
    book = executed(name, tmp_path)  # an error in a cell is raised
    assert not [o for cell in book.cells for o in cell.get("outputs", ()) if o.get("name") == "stderr"]
    shown = list(bundles(book))
    pictures = [base64.b64decode(data["image/png"]) for data in shown if "image/png" in data]
    assert pictures and all(p.startswith(b"\x89PNG") and len(p) > 3000 for p in pictures)
    if name in WITH_MATHEMATICS:
        assert any(data.get("text/latex", "").startswith("$") for data in shown)
    both = [data for data in shown if "text/markdown" in data]
    assert all(data["image/png"].strip() in data["text/markdown"] for data in both)


def test_ten_short_ones_without_results() -> None:
    assert len(NAMES) == 10
    for name in NAMES:
        text = (FOLDER / f"{name}.md").read_text(encoding="utf-8")
        body = text.split("---\n", 2)[2]
        assert 30 <= len(body.splitlines()) <= 85 and "```{code-cell}" in "\n".join(body.splitlines()[:10])
        assert "base64" not in text and f"\n{name}\n" in (FOLDER / "index.md").read_text(encoding="utf-8")

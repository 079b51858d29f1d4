"""Every Python example of README.md and docs/ runs, in order, one namespace per page; specs are read as specs."""

from __future__ import annotations

import linecache
import re
from pathlib import Path

import pytest

from ..support.checkout import CHECKOUT

PAGES = sorted([CHECKOUT / "README.md", *(CHECKOUT / "docs").rglob("*.md")])
_BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)
#: Packages of the extra `ci` that pages show.
_NEEDS = {"arrays.md": "jax", "clifford.md": "clifford", "kingdon.md": "kingdon", "interactive.md": "anywidget"}
_LINK = re.compile(r"\]\((?!https?:)([^)#]+)\)")


def blocks(page: Path, language: str) -> list[str]:
    return [text for name, text in _BLOCK.findall(page.read_text(encoding="utf-8")) if name == language]


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(p, marks=() if p.name == "README.md" else pytest.mark.slow, id=p.name)
        for p in PAGES
        if blocks(p, "python")
    ],
)
def test_examples_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if page.name in _NEEDS:
        pytest.importorskip(_NEEDS[page.name])
    monkeypatch.chdir(tmp_path)
    namespace: dict[str, object] = {"__name__": "example"}
    for number, text in enumerate(blocks(page, "python")):
        name = f"{page.name}, example {number + 1}"
        linecache.cache[name] = (len(text), None, text.splitlines(keepends=True), name)  # algorithms read their text
        exec(compile(text, name, "exec"), namespace)


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_links_lead_somewhere(page: Path) -> None:
    missing = [link for link in _LINK.findall(page.read_text(encoding="utf-8")) if not (page.parent / link).exists()]
    assert not missing


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_links_say_the_title_and_not_the_file(page: Path) -> None:
    assert not re.findall(r"\[[^\]\n]*\.md`?\]\([^)]*\)", page.read_text(encoding="utf-8"))


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_no_formula_reads_as_a_tag(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    plain = re.split(r"^```.*?^```|`[^`\n]*`|<!--.*?-->", text, flags=re.MULTILINE | re.DOTALL)
    assert not re.findall(r"<[A-Za-z~/][^\n]*", "".join(plain))


def test_the_spec_of_the_docs_generates() -> None:
    from bladesmith.codegen.algebra.schema import SpecFile
    from bladesmith.codegen.documents.document import Document
    from bladesmith.codegen.generator import generate

    (text,) = blocks(CHECKOUT / "docs" / "algebra" / "specs.md", "toml")
    files = generate(Document("specs.md", text, SpecFile).contents.model_dump(exclude_none=True))
    assert "pga2d_geometric_motor_motor" in files["kernels/products.c"]

"""The gallery of the documentation."""

from __future__ import annotations

import builtins
import re
import symtable
from pathlib import Path

import numpy as np
import pytest

from ..support.checkout import CHECKOUT

#: Pictures stay small enough for a page of many.
MOST_BYTES = 120 * 1024


GALLERY = (CHECKOUT / "docs" / "geometry" / "gallery.md").read_text(encoding="utf-8")


def names(text: str) -> tuple[set[str], set[str]]:
    """Names that a block of Python gives, and those that it takes from elsewhere."""
    module = symtable.symtable(text, "block", "exec")
    given = {s.get_name() for s in module.get_symbols() if s.is_assigned() or s.is_imported()}
    waiting, used = [module], set()
    while waiting:
        table = waiting.pop()
        waiting += table.get_children()
        used |= {s.get_name() for s in table.get_symbols() if s.is_referenced() and (table is module or s.is_global())}
    return given, used - given - set(dir(builtins))


def test_each_picture_needs_the_first_lines_and_its_own_alone() -> None:
    first, *blocks = re.findall(r"^```python\n(.*?)^```", GALLERY, re.MULTILINE | re.DOTALL)
    given, missing = names(first)
    assert not missing and len(blocks) >= 15
    assert not [wanted - given for _, wanted in map(names, blocks) if wanted - given]


def test_the_gallery_begins_with_a_thumbnail_of_each_picture() -> None:
    grid, sections = GALLERY.split("\n## ", 1)
    cards = re.findall(r'grid-item-card\} (.+)\n:img-top: \.\./images/gallery/(\w+)\.png\n:link: "#(.+)"\n', grid)
    section = r"^(?:## )?(\S.*)\n\n(?:(?!## ).*\n)*?!\[.+\]\(\.\./images/gallery/(\w+)\.png\)"
    shown = re.findall(section, sections, re.MULTILINE)
    assert [card[:2] for card in cards] == shown
    assert [card[2] for card in cards] == [title.lower().replace(",", "").replace(" ", "-") for title, _ in shown]


def test_pictures_of_the_tracer_link_to_their_scenes() -> None:
    text = (CHECKOUT / "docs" / "geometry" / "tracing.md").read_text(encoding="utf-8")
    linked = re.findall(r"\[!\[[^\]]+\]\(\.\./images/tracing/(\w+)\.png\)\]\(\.\./\.\./(\S+)\)", text)
    assert len(linked) == text.count("![")
    folder = CHECKOUT / "examples" / "tracing"
    for name, source in linked:
        assert (CHECKOUT / source).stem == (name if (folder / f"{name}.toml").exists() else "render")


def test_the_gallery_shows_what_its_examples_save() -> None:
    shown = re.findall(r"!\[[^\]]+\]\(\.\./images/gallery/(\w+\.png)\)", GALLERY)
    saved = re.findall(r'^plot\.save\("(\w+\.png)"', GALLERY, re.MULTILINE)
    kept = sorted(path.name for path in (CHECKOUT / "docs" / "images" / "gallery").iterdir())
    assert shown == saved and sorted(shown) == kept


@pytest.mark.parametrize("path", sorted((CHECKOUT / "docs" / "images" / "gallery").glob("*.png")), ids=lambda p: p.stem)
def test_pictures_of_the_gallery_are_small_and_not_empty(path: Path) -> None:
    image = pytest.importorskip("PIL.Image").open(path)
    assert path.stat().st_size <= MOST_BYTES and 800 <= image.width <= 960
    ink = (np.asarray(image.convert("L")) < 200).mean()
    assert 0.005 < ink < 0.7
    assert not (np.asarray(image.convert("L"))[[0, -1]] < 200).any()  # nothing is cut off above or below
    assert not (np.asarray(image.convert("L"))[:, [0, -1]] < 200).any()

"""The gallery of the documentation."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from ..support.checkout import CHECKOUT

#: Pictures stay small enough for a page of many.
MOST_BYTES = 120 * 1024


def test_the_gallery_shows_what_its_examples_save() -> None:
    text = (CHECKOUT / "docs" / "geometry" / "gallery.md").read_text(encoding="utf-8")
    shown = re.findall(r"!\[[^\]]+\]\(\.\./images/gallery/(\w+\.png)\)", text)
    saved = re.findall(r'^plot\.save\("(\w+\.png)"', text, re.MULTILINE)
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

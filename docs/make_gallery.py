"""Makes the pictures of gallery.md: runs its examples in a temporary folder and keeps what they save.

python docs/make_gallery.py [--only NAME ...]
"""

from __future__ import annotations

import argparse
import os
import re
import tempfile
from pathlib import Path

from PIL import Image

PAGE = Path(__file__).resolve().parent / "gallery.md"
FOLDER = PAGE.parent / "images" / "gallery"
#: A page of many pictures should load quickly.
MOST_BYTES = 120 * 1024
COLORS = 256
_BLOCK = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)


def examples() -> list[str]:
    """The page's blocks of Python."""
    return _BLOCK.findall(PAGE.read_text(encoding="utf-8"))


def run(folder: Path) -> list[Path]:
    """Run all blocks, which share their names, in ``folder``; returns the pictures in it."""
    before = Path.cwd()
    namespace: dict[str, object] = {"__name__": "gallery"}
    os.chdir(folder)
    try:
        for number, text in enumerate(examples(), 1):
            exec(compile(text, f"gallery.md, example {number}", "exec"), namespace)
    finally:
        os.chdir(before)
    return sorted(folder.glob("*.png"))


def shrunk(picture: Path) -> Image.Image:
    """With a palette of its own, which takes a third of the room."""
    return Image.open(picture).convert("RGB").quantize(COLORS, dither=Image.Dither.NONE)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", nargs="*", metavar="NAME", help="keep these pictures only")
    only = parser.parse_args().only
    FOLDER.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        for picture in run(Path(folder)):
            if only and picture.stem not in only:
                continue
            target = FOLDER / picture.name
            shrunk(picture).save(target, optimize=True)
            size = target.stat().st_size
            print(f"{target.name}: {size // 1024} KB")
            if size > MOST_BYTES:
                raise SystemExit(f"{target.name} has {size} bytes; at most {MOST_BYTES} are allowed.")


if __name__ == "__main__":
    main()

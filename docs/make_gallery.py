"""Makes the pictures of gallery.md and of the tutorials (from their examples), and of chapters 4 to 7, shrunk.

python docs/make_gallery.py [--only NAME ...]
"""

from __future__ import annotations

import argparse
import linecache
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

DOCS = Path(__file__).resolve().parent
PAGE = DOCS / "geometry" / "gallery.md"
FOLDER = DOCS / "images" / "gallery"
TUTORIALS = DOCS / "images" / "tutorials"
TRACING = DOCS / "images" / "tracing"
REGISTRATION = DOCS / "images" / "registration"
DYNAMICS = DOCS / "images" / "dynamics"
KINEMATICS = DOCS / "images" / "kinematics"
SCENES = DOCS.parent / "examples" / "tracing" / "render.py"
FIGURES = DOCS.parent / "examples" / "registration" / "figures.py"
MOTIONS = DOCS.parent / "examples" / "dynamics" / "figures.py"
ROBOTS = DOCS.parent / "examples" / "kinematics" / "figures.py"
#: A page of many pictures should load quickly.
MOST_BYTES = 120 * 1024
COLORS = 256
_BLOCK = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)


def run(page: Path, folder: Path) -> list[Path]:
    """Run all blocks of Python of a page, which share their names, in ``folder``; returns the pictures in it."""
    before = Path.cwd()
    namespace: dict[str, object] = {"__name__": page.stem}
    folder.mkdir()
    os.chdir(folder)
    try:
        for number, text in enumerate(_BLOCK.findall(page.read_text(encoding="utf-8")), 1):
            name = f"{page.name}, example {number}"
            linecache.cache[name] = (len(text), None, text.splitlines(keepends=True), name)  # for algorithms
            exec(compile(text, name, "exec"), namespace)
    finally:
        os.chdir(before)
    return sorted(folder.glob("*.png"))


def shrunk(picture: Path) -> Image.Image:
    """With a palette of its own, which takes a third of the room."""
    return Image.open(picture).convert("RGB").quantize(COLORS, dither=Image.Dither.NONE)


def keep(picture: Path, folder: Path) -> None:
    """A picture shrunk into a folder of the docs."""
    folder.mkdir(parents=True, exist_ok=True)
    target = folder / picture.name
    shrunk(picture).save(target, optimize=True)
    size = target.stat().st_size
    print(f"{target.name}: {size // 1024} KB")
    if size > MOST_BYTES:
        raise SystemExit(f"{target.name} has {size} bytes; at most {MOST_BYTES} are allowed.")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", nargs="*", metavar="NAME", help="keep these pictures only")
    only = parser.parse_args().only
    with tempfile.TemporaryDirectory() as folder:
        places = {}
        for script, target in ((SCENES, TRACING), (FIGURES, REGISTRATION), (MOTIONS, DYNAMICS), (ROBOTS, KINEMATICS)):
            made = Path(folder, target.name)
            subprocess.run([sys.executable, str(script), "--out", str(made)], check=True)
            places[target] = sorted(made.glob("*.png"))
        places[FOLDER] = run(PAGE, Path(folder, "gallery"))
        places[TUTORIALS] = [x for p in sorted(DOCS.glob("*/tutorial.md")) for x in run(p, Path(folder, p.parent.name))]
        for target, pictures in places.items():
            for picture in pictures:
                if not only or picture.stem in only:
                    keep(picture, target)


if __name__ == "__main__":
    main()

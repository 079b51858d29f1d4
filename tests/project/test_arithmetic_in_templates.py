"""Mathematics belongs to formulas and algorithms: what arithmetic templates still have may only become less."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from ..support.checkout import CHECKOUT

TEMPLATES = CHECKOUT / "templates"
#: Lines of arithmetic of numbers that a folder may have, its own subfolders apart. What is about the machine (rows of
#: vectors, blocks, launchers) stays; lower a number where lines went, and never raise one.
MOST = {
    "c/kernels": 22,
    "c/lib": 64,
    "c/programs/tracer": 6,
    "c/programs/tracer/acceleration": 50,
    "cuda": 12,
    "export": 52,
    "jax": 12,
    "numba": 2,
}
#: Generated from algorithms.
GENERATED = ("elementary.h",)
_COMMENT = re.compile(r"/\*.*?\*/|\{#.*?#\}", re.DOTALL)
_TAG = re.compile(r"\{%.*?%\}", re.DOTALL)
_INDEX = re.compile(r"\[[^\[\]]*\]")
_OPERATION = re.compile(r"[\w).}] [*/+-] [\w(.{-]|[*/+-]= ")
_INTEGER = re.compile(r"(static )?(const )?(int|ptrdiff_t|u?int\d+_t|size_t|unsigned)\b")


def arithmetic(path: Path) -> list[str]:
    """Lines of code that add or multiply, indices and declarations of integers apart."""
    text = _COMMENT.sub(lambda found: "\n" * found.group().count("\n"), path.read_text(encoding="utf-8"))
    lines = []
    for line in _TAG.sub(" ", text).splitlines():
        code = line.split("//")[0].strip()
        if code.startswith("#") and not code.startswith("#define"):
            continue
        while _INDEX.search(code):
            code = _INDEX.sub("", code)
        code = re.sub(r"^for \([^)]*\)", "", code)
        if _OPERATION.search(code) and not _INTEGER.match(code):
            lines.append(code)
    return lines


def folders() -> dict[str, int]:
    found: dict[str, int] = {}
    for path in sorted(TEMPLATES.rglob("*")):
        folder = path.parent.relative_to(TEMPLATES).as_posix()
        if path.suffix in (".h", ".j2", ".py") and path.name not in GENERATED and folder not in ("pages", "report"):
            count = len(arithmetic(path))
            if count:
                found[folder] = found.get(folder, 0) + count
    return found


def test_templates_have_no_more_arithmetic() -> None:
    found = folders()
    more = {folder: (count, MOST.get(folder, 0)) for folder, count in found.items() if count > MOST.get(folder, 0)}
    assert not more, f"more lines of arithmetic than before (now, at most): {more}; write a formula or an algorithm."
    less = {folder: (found.get(folder, 0), most) for folder, most in MOST.items() if found.get(folder, 0) < 0.8 * most}
    assert not less, f"lower the numbers of this test (now, at most): {less}"


@pytest.mark.parametrize(
    ("code", "count"),
    [
        ("x = a * b;", 1), ("x[i + 1] = a[2 * i];", 0), ("x += a;", 1), ("/* a + b */", 0), ("const int n = 2 * m;", 0),
        ("for (int i = 0; i < n - 1; i++) y -= 2;", 1), ("const double *const p = q;", 0), ("#include <a + b>", 0),
        ("{% if a + b %}", 0),
    ],
)  # fmt: skip
def test_arithmetic_is_recognised(code: str, count: int, tmp_path: Path) -> None:
    (tmp_path / "text.h").write_text(code, encoding="utf-8")
    assert len(arithmetic(tmp_path / "text.h")) == count

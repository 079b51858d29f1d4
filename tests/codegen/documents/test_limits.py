"""Files that would take hours, or all memory, are refused at once."""

from __future__ import annotations

import contextlib
import os
import threading
import time
import tracemalloc
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path

import pytest

from bladesmith.codegen.algebra.algebra import orthonormal
from bladesmith.codegen.algebra.multivector import from_values
from bladesmith.codegen.algebra.spec_language import evaluate
from bladesmith.codegen.documents import document
from bladesmith.codegen.documents.document import Document, Table, read_document
from bladesmith.codegen.documents.text import read_bytes, read_text
from bladesmith.codegen.rings.protocol import NumericRing
from bladesmith.errors import CompileError, InputError, SpecError


class Shape(Table):
    """A schema."""

    radius: float = 1.0


@pytest.fixture(autouse=True)
def short() -> Iterator[None]:
    start = time.process_time()
    yield
    assert time.process_time() - start < 2


def read(text: str) -> Document[Shape]:
    return Document("shape.toml", text, Shape)


PARTS = 50_000


@pytest.mark.parametrize(
    "text",
    [
        ".".join(["a"] * PARTS) + " = 1",
        f"[{'.'.join(['a'] * PARTS)}]\nx = 1",
        f"[[ {' . '.join(['a', chr(34) + 'b c' + chr(34)] * PARTS)} ]]",
        "x = {" + ".".join(["'a'"] * PARTS) + " = 1}",
        "x = " + "[" * PARTS,
        "x = " + "{y = " * PARTS,
    ],
    ids=["key", "header", "quoted", "inline", "arrays", "tables"],
)
def test_nesting_has_a_limit(text: str) -> None:
    with pytest.raises(InputError, match="nested too deeply"):
        read(text)


def test_the_limit_is_on_keys_alone() -> None:
    long = "a" * 200_000
    for text in (f'"{long}" = 1', f"{long} = 1", f'x = "{"a" * 900} {"..." * 900}"', "a . b . c = 1"):
        with pytest.raises(InputError, match="not a known key"):
            read(text)
    parts = ".".join(["a"] * document.MOST_PARTS)
    with pytest.raises(InputError, match="not a known key"):
        read(f"{parts} = 1")


def test_of_many_faults_some_are_explained() -> None:
    text = "".join(f"a{i} = {i}\n" for i in range(5000))
    with pytest.raises(InputError, match=r"line 1: a0 is not a known key; .* \(4999 more faults\.\)"):
        read(text)


def test_a_message_is_one_line_of_bounded_length() -> None:
    for key in ('"ra\\ndius"', f'"{"a" * 10_000}"'):
        with pytest.raises(InputError) as caught:
            read(f"{key} = 1")
        assert "\n" not in str(caught.value) and len(str(caught.value)) < 2100


def test_what_the_machine_lacks_is_no_fault_of_the_file() -> None:
    def no_room() -> None:
        raise CompileError("no space left")

    with pytest.raises(CompileError, match="^no space left$"):
        read("radius = 1.0").build((), no_room)


def test_of_a_large_file_no_more_is_read_than_its_limit(tmp_path: Path) -> None:
    path = tmp_path / "large.toml"
    with path.open("wb") as file:
        file.truncate(10**12)
    tracemalloc.start()
    try:
        with pytest.raises(InputError, match="larger than 16 MB"):
            read_document(path, Shape)
        assert tracemalloc.get_traced_memory()[1] < 100_000_000
    finally:
        tracemalloc.stop()


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes")
def test_pipes_are_read_to_their_end_or_limit(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    for size in (10, 100_000):
        writer = threading.Thread(target=write_to, args=(tmp_path / "pipe", b"x" * size))
        writer.start()
        if size == 10:
            assert read_text(tmp_path / "pipe") == "x" * 10
        else:
            with pytest.raises(InputError, match="larger than"):
                read_bytes(tmp_path / "pipe", max_size=1000)
        writer.join()


def write_to(pipe: Path, content: bytes) -> None:
    with contextlib.suppress(BrokenPipeError):
        pipe.write_bytes(content)


def test_numbers_of_specs_have_a_limit() -> None:
    algebra = orthonormal(2)
    like = from_values(algebra, NumericRing(float), [1], [1.0])
    assert evaluate("a = 3\na = a * a\na * 2", like, {}, "here").scalar() == Fraction(18)
    for step in ("a * a", "1 / a / a", "a * 2 * a"):
        with pytest.raises(SpecError, match="here: a number has more than 20000 binary digits"):
            evaluate("a = 3\n" + f"a = {step}\n" * 38 + "a", like, {}, "here")

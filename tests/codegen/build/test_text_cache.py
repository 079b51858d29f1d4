"""Printed kernels that are kept: good for the sources that they were made of, for no others, and whatever happens to
their files."""

from __future__ import annotations

import ast
import hashlib
import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from bladesmith.codegen.build import cache, kernel_cache, source_digest, text_cache
from bladesmith.codegen.formulas.curves import ribbons, surface_points
from bladesmith.codegen.formulas.rays import boxes, facets, rays
from bladesmith.codegen.optimise.variants import as_written
from bladesmith.codegen.programs import KernelSpec, kernel_spec
from bladesmith.codegen.programs.tracer.surface_kinds import PLAIN
from bladesmith.codegen.targets.c.printer import c_function
from bladesmith.codegen.targets.templates import render
from bladesmith.errors import TraceError

PATIENCE = 60.0  # seconds a child process may take on a busy machine
FACING = KernelSpec(rays.facing, ("unit", "position"))
PLANE = PLAIN["plane"].kernels[0]


@pytest.fixture
def cache_dir(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    root = tmp_path / "cache"
    monkeypatch.setenv(cache.DIRECTORY_VARIABLE, str(root))
    return root


def forget() -> None:
    for known in (kernel_spec._read_or_print, kernel_cache._shipped_texts, kernel_cache._touch, kernel_cache.group_of):
        known.cache_clear()


@pytest.fixture
def alone(cache_dir: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[], list[str]]]:
    """A process that knows nothing, and a package that carries nothing; gives what was traced since the last call."""
    made: list[str] = []
    printed = kernel_spec._print

    def noted(declared: KernelSpec) -> dict[str, str]:
        made.append(declared.name)
        return printed(declared)

    monkeypatch.setattr(kernel_spec, "_print", noted)
    monkeypatch.setattr(kernel_cache, "resources", Carrying(tmp_path / "generated"))
    (tmp_path / "generated").mkdir()
    forget()

    def since() -> list[str]:
        names, made[:] = made[:], []
        return names

    yield since
    forget()


class Carrying:
    """In place of importlib.resources: a package whose generated folder is somewhere else."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def files(self, name: str) -> Path:
        assert name == "bladesmith.generated"
        return self.folder


def kernel_files(root: Path) -> list[Path]:
    return [path for path in root.glob("text_*/*.json") if path.name != cache.RECORD]


# -- what a text depends on ----------------------------------------------------------------------------------


def imported(path: Path) -> set[Path]:
    """By Python's own parser: files of the package that a file imports."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            assert not any(alias.name.startswith("bladesmith") for alias in node.names)
        if isinstance(node, ast.ImportFrom) and node.level:
            base = path.parents[node.level - 1].joinpath(*(node.module or "").split("."))
            for place in (base, *(base / alias.name for alias in node.names)):
                found |= {file for file in (place.with_suffix(".py"), place / "__init__.py") if file.is_file()}
    return {file for file in found if file.is_relative_to(source_digest.ROOT)}


@pytest.mark.parametrize("module", [rays, boxes, facets, ribbons, surface_points], ids=lambda m: m.__name__)
def test_every_import_is_followed(module):
    start = Path(module.__file__).resolve()
    found, waiting = set(), [start]
    while waiting:
        file = waiting.pop()
        if file not in found:
            found.add(file)
            waiting += imported(file)
    expected = {file.relative_to(source_digest.ROOT).as_posix() for file in found}
    assert source_digest.closure([start.relative_to(source_digest.ROOT).as_posix()]) == expected
    assert "algebra/multivector.py" in expected and "build/extension.py" not in expected


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A package of five files, older than this process."""
    root = tmp_path / "package"
    (root / "rooms").mkdir(parents=True)
    files = {
        "__init__.py": "",
        "rooms/__init__.py": "NAME = 1\n",
        "rooms/first.py": "from . import (\n    second,  # one (more)\n)\nfrom ..base import x as y\n",
        "rooms/second.py": "def f():\n    from .. import lazy\n    return lazy\n",
        "base.py": "x = 1\n",
        "lazy.py": "",
        "unrelated.py": "",
        "data.toml": "a = 1\n",
    }
    for name, text in files.items():
        (root / name).write_text(text)
        os.utime(root / name, (1, 1))
    monkeypatch.setattr(source_digest, "ROOT", root)
    yield root
    forget_sources()


def forget_sources() -> None:
    cached = (source_digest._digest_of, source_digest._direct_imports, source_digest._all_files)
    for function in (source_digest.text_of, *cached):
        function.cache_clear()


def digest_now() -> str | None:
    forget_sources()
    return source_digest.digest(["rooms/first.py", "data.toml"])


def test_a_digest_follows_every_file_behind_a_formula(package):
    before = digest_now()
    assert before is not None and digest_now() == before
    for name in ("rooms/first.py", "rooms/second.py", "base.py", "lazy.py", "data.toml"):
        old = (package / name).read_text()
        (package / name).write_text(old + "# more\n")
        os.utime(package / name, (1, 1))
        assert digest_now() not in (before, None), name
        (package / name).write_text(old)
        os.utime(package / name, (1, 1))
    (package / "unrelated.py").write_text("changed = 1\n")
    assert digest_now() == before


def test_files_that_changed_since_they_were_loaded_say_nothing(package):
    assert digest_now() is not None
    os.utime(package / "lazy.py", (time.time() + 5, time.time() + 5))
    assert digest_now() is None


def test_without_sources_there_is_no_digest(package):
    (package / "data.toml").unlink()
    assert digest_now() is None


def test_groups_follow_the_module_and_the_algebra(monkeypatch):
    kernel_cache.group_of.cache_clear()
    groups = {kernel_cache.group_of(m.__name__, "cga3d") for m in (rays, boxes, facets)} | {
        kernel_cache.group_of(rays.__name__, "pga3d")
    }
    assert len(groups) == 4 and None not in groups
    assert kernel_cache.group_of(__name__, "cga3d") is None and kernel_cache.group_of("somewhere.else", "cga3d") is None
    forget()


# -- texts in the cache --------------------------------------------------------------------------------------


def test_texts_are_what_was_written(cache_dir):
    assert text_cache.read("group", "a.json") is None
    text_cache.write("group", {"a.json": "one\ntwo \N{GREEK SMALL LETTER ALPHA}\n", "b.json": ""})
    assert text_cache.read("group", "a.json") == "one\ntwo \N{GREEK SMALL LETTER ALPHA}\n"
    assert text_cache.read("group", "b.json") == "" and text_cache.read("group", "c.json") is None
    text_cache.write("group", {"a.json": "three"})
    assert text_cache.read("group", "a.json") == "three"
    assert not [path for path in (cache_dir / "text_group").iterdir() if path.name.startswith(".")]


def test_texts_are_made_once(cache_dir):
    sources = ("formulas/rays/rays.py",)
    assert not text_cache.is_made("made", sources, "a.json")
    assert [text_cache.made_once("made", sources, "a.json", lambda text=text: text) for text in "ab"] == ["a", "a"]
    assert text_cache.is_made("made", sources, "a.json") and not text_cache.is_made("made", sources, "b.json")


DAMAGES = [
    lambda content: b"",
    lambda content: content[:-1],
    lambda content: content[:30],
    lambda content: content.replace(b"V", b"W", 1),
    lambda content: b"\xff" + content,
    lambda content: content + b"\n",
    lambda content: b"\n" + content,
]


@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_texts_are_made_again(alone, cache_dir, damage):
    expected = kernel_spec.print_spec(PLANE)
    assert alone() == ["plane_hit"]
    (path,) = kernel_files(cache_dir)
    good = path.read_bytes()
    path.write_bytes(damage(good))
    forget()
    assert kernel_spec.print_spec(PLANE) == expected and alone() == ["plane_hit"]
    assert path.read_bytes() == good
    forget()
    assert kernel_spec.print_spec(PLANE) == expected and alone() == []


def test_a_text_that_is_whole_and_no_kernel_is_made_again(alone, cache_dir):
    expected = kernel_spec.print_spec(PLANE)
    (path,) = kernel_files(cache_dir)
    for body in (b"{}", b"[1]", b'{"key": "another", "texts": {}}', b'{"key": 1}'):
        path.write_bytes(hashlib.sha256(body).hexdigest().encode() + b"\n" + body)
        alone()
        forget()
        assert kernel_spec.print_spec(PLANE) == expected and alone() == ["plane_hit"]


def test_a_kernel_is_traced_once_for_all_processes(alone, cache_dir):
    first = kernel_spec.print_specs([PLANE, FACING])
    assert alone() == ["plane_hit", "facing"] and len(kernel_files(cache_dir)) == 2
    forget()
    assert kernel_spec.print_specs([PLANE, FACING]) == first and alone() == []
    with kernel_spec.without_kernel_cache():
        assert kernel_spec.print_specs([PLANE, FACING]) == first and alone() == ["plane_hit", "facing"]


def test_other_sources_other_texts(alone, cache_dir, monkeypatch):
    kernel_spec.print_spec(PLANE)
    group = kernel_cache.group_of(rays.__name__, "cga3d")
    forget()
    monkeypatch.setattr(source_digest, "digest", lambda files: hashlib.sha256(b"edited").hexdigest())
    assert kernel_cache.group_of(rays.__name__, "cga3d") != group
    kernel_spec.print_spec(PLANE)
    assert alone() == ["plane_hit", "plane_hit"] and len(kernel_files(cache_dir)) == 2


def test_nothing_is_kept_of_sources_that_cannot_be_told(alone, cache_dir, monkeypatch):
    monkeypatch.setattr(source_digest, "digest", lambda files: None)
    kernel_spec.print_spec(PLANE)
    assert alone() == ["plane_hit"] and not cache_dir.exists()


@pytest.mark.parametrize("kinds", [("position", "position", "unit", "number"), ("unit", "position", "unit", "number")])
def test_other_kinds_or_another_name_are_other_kernels(alone, kinds):
    kernel_spec.print_spec(PLANE)
    renamed = KernelSpec(rays.plane_hit, kinds, "renamed")
    assert list(kernel_spec.print_spec(renamed)) == ["cga3d_renamed"]
    assert alone() == ["plane_hit", "renamed"]
    with pytest.raises(TraceError, match="two different kernels are called 'plane_hit'"):
        kernel_spec.print_specs([PLANE, KernelSpec(rays.sphere_hit, PLAIN["sphere"].kernels[0].kinds, "plane_hit")])


def test_a_cache_that_cannot_be_written_is_done_without(alone, tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv(cache.DIRECTORY_VARIABLE, str(tmp_path / "file" / "cache"))
    expected = kernel_spec.print_spec(PLANE)
    forget()
    assert kernel_spec.print_spec(PLANE) == expected and alone() == ["plane_hit"] * 2


def test_groups_are_entries_of_the_cache(alone, cache_dir):
    kernel_spec.print_spec(PLANE)
    (entry,) = cache.entries()
    assert entry.stem.startswith("text_rays_") and entry.size > 100
    record = cache_dir / entry.stem / cache.RECORD
    os.utime(record, (1, 1))
    forget()
    kernel_spec.print_spec(PLANE)
    assert record.stat().st_mtime > 1, "used just now"
    assert cache.clear()[0] == 1 and not cache.entries()
    forget()
    alone()
    kernel_spec.print_spec(PLANE)
    assert alone() == ["plane_hit"]


WRITER = """
import sys
from bladesmith.codegen.build import text_cache as texts
text = sys.argv[1] * 20000
for i in range(150):
    texts.write("group", {"a.json": text})
    assert texts.read("group", "a.json")[0] in "xy"
"""


def test_processes_that_write_at_once_leave_a_whole_text(cache_dir):
    writers = [
        subprocess.Popen([sys.executable, "-c", WRITER, letter], stderr=subprocess.PIPE, text=True) for letter in "xy"
    ]
    seen = set()
    while any(writer.poll() is None for writer in writers):
        seen.add(text_cache.read("group", "a.json"))
    assert [writer.communicate(timeout=PATIENCE)[1] for writer in writers] == ["", ""]
    assert seen - {None} <= {"x" * 20000, "y" * 20000} and text_cache.read("group", "a.json") in seen | {
        letter * 20000 for letter in "xy"
    }


def test_clearing_while_texts_are_written_does_no_harm(cache_dir):
    stop = threading.Event()

    def clear() -> None:
        while not stop.is_set():
            cache.clear()

    thread = threading.Thread(target=clear)
    thread.start()
    try:
        for i in range(200):
            text_cache.write("group", {"a.json": str(i)})
            assert text_cache.read("group", "a.json") in (None, str(i))
    finally:
        stop.set()
        thread.join()


# -- what the package carries --------------------------------------------------------------------------------


def carry(folder: Path, declared: list[KernelSpec]) -> Path:
    """A generated folder with these kernels."""
    with kernel_spec.without_kernel_cache():
        made = {d: kernel_spec.print_spec(d) for d in declared}
    header = render("kernels.h.j2", functions=[]) + "".join(text for d in declared for text in made[d].values())
    listed = {(str(kernel_cache.group_of(d.formula.__module__, d.algebra)), d.key): list(made[d]) for d in declared}
    folder.mkdir()
    (folder / "kernels.h").write_text(header)
    (folder / kernel_cache.INDEX).write_text(kernel_cache.index(header, listed))
    return folder


def test_what_the_package_carries_is_not_traced(alone, tmp_path, cache_dir):
    expected = kernel_spec.print_specs([PLANE, FACING])
    carry(tmp_path / "generated" / "some", [PLANE])
    carry(tmp_path / "generated" / "more", [FACING])
    cache.clear()
    forget()
    alone()
    assert kernel_spec.print_specs([PLANE, FACING]) == expected
    assert alone() == [] and not kernel_files(cache_dir)


@pytest.mark.parametrize("stale", ["header", "sources", "index", "format", "symbol"])
def test_what_it_carries_of_other_sources_is_not_used(alone, tmp_path, stale):
    folder = carry(tmp_path / "generated" / "some", [PLANE])
    expected = kernel_spec.print_spec(PLANE)
    index = json.loads((folder / kernel_cache.INDEX).read_text())
    if stale == "header":
        text = (folder / "kernels.h").read_text()
        (folder / "kernels.h").write_text(text.replace(" - ", " + ", 1))
    elif stale == "sources":
        index["groups"] = {group[:-1] + "x": kernels for group, kernels in index["groups"].items()}
    elif stale == "format":
        index["format"] += 1
    elif stale == "symbol":
        index["groups"] = {g: {key: ["cga3d_nothing"] for key in kernels} for g, kernels in index["groups"].items()}
    (folder / kernel_cache.INDEX).write_text("[" if stale == "index" else json.dumps(index))
    cache.clear()
    forget()
    alone()
    assert kernel_spec.print_spec(PLANE) == expected
    assert alone() == ["plane_hit"]


def test_kernels_one_by_one_are_the_header_of_all():
    declared = [PLANE, FACING, PLAIN["sphere"].kernels[0]]
    functions = [c_function(as_written(kernel_spec.trace_spec(d))) for d in declared]
    whole = render("kernels.h.j2", functions=functions)
    assert whole == render("kernels.h.j2", functions=[]) + "".join(kernel_spec.print_specs(declared).values())


def test_what_the_package_carries_is_of_its_own_sources():
    """The installed index, where its sources are these: every kernel is the text that its formula gives."""
    forget()
    for (group, key), carried in list(kernel_cache._shipped_texts().items())[::29]:
        module = key.split(" = ")[1].split(".")[0]
        assert group.startswith(f"{module}_") and all(f"FN({symbol})(" in text for symbol, text in carried.items())

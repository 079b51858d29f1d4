"""Parts of extensions: compiled once for all that have them, made again when anything changes or is damaged."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from bladesmith.codegen.build import cache, extension, translation_units
from bladesmith.codegen.build.extension import load
from bladesmith.codegen.build.translation_units import Compilation
from bladesmith.codegen.targets.c.source import Unit
from bladesmith.errors import CompileError, SpecError

from ...support.build import extension_parts
from ...support.build.extension_parts import OTHER, PART, WHOLE

PATIENCE = 60.0  # seconds a child process may take on a busy machine
pytestmark = [
    pytest.mark.skipif(extension.compiler() is None, reason="no C compiler"),
    pytest.mark.skipif(os.name != "posix", reason="shell scripts"),
]

CHILD = """
import runpy, sys
from bladesmith.codegen.build.extension import load
print(load(runpy.run_path(sys.argv[1])[sys.argv[2]]).lib.twice(1.0))
"""


@pytest.fixture
def compiled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[], list[str]]:
    """A compiler that notes what it compiles; gives the names since the last call, without their keys."""
    script, notes, real = tmp_path / "cc", tmp_path / "notes", extension.compiler()
    assert real is not None
    script.write_text(
        f'#!/bin/sh\ncase "$*" in *--version*) exec {real.command[0]} --version;; esac\n'
        f'for word in "$@"; do case "$word" in *.c) echo "$word" >> "{notes}";; esac; done\n'
        f'exec {real.command[0]} "$@"\n'
    )
    script.chmod(0o755)
    monkeypatch.setenv("CC", str(script))

    def since() -> list[str]:
        names = notes.read_text().splitlines() if notes.exists() else []
        notes.write_text("")
        return sorted(Path(n).stem.removeprefix("bs_").rsplit("_", 1)[0] if "_" in n else Path(n).stem for n in names)

    return since


def entry_of(root: Path, name: str) -> Path:
    (folder,) = [path for path in root.iterdir() if path.name.rsplit("_", 1)[0] == f"bs_{name}"]
    return folder


def test_a_part_is_compiled_once_for_all_extensions_that_have_it(cache_dir, compiled):
    assert load(WHOLE).lib.twice(1.0) == 6.0
    assert compiled() == ["part", "whole", "whole_module"]
    assert load(OTHER).lib.twice(1.0) == 30.0
    assert compiled() == ["whole"]
    assert load(WHOLE).lib.twice(1.0) == 6.0 and load(WHOLE).lib.size(b"\x07") == 7
    assert compiled() == []
    assert not list(entry_of_whole(cache_dir).glob("*.o")), "the library has what the objects had"


def entry_of_whole(root: Path) -> Path:
    return next(path for path in root.iterdir() if path.name.startswith("bs_whole_") and "module" not in path.name)


@pytest.mark.parametrize(
    "other",
    [
        replace(PART, name="part2"),
        replace(PART, source=PART.source + "\n"),
        replace(PART, headers={"part.h": "#define FACTOR 4\n"}),
        replace(PART, headers={**PART.headers, "more.h": ""}),
        replace(PART, options=("-DX",)),
        replace(PART, declarations="double part(double);"),
    ],
    ids=["name", "source", "header text", "header", "options", "declarations"],
)
def test_keys_follow_every_part_of_a_unit(other):
    how = Compilation(("cc", "-O1"), "module", ("1",))
    assert how.stem(other) != how.stem(PART)
    assert extension.extension_key(replace(WHOLE, units=(other,))) != extension.extension_key(WHOLE)


def test_keys_follow_how_units_are_compiled():
    how = Compilation(("cc", "-O1"), "module", ("1",))
    others = [replace(how, command=("cc", "-O2")), replace(how, module="other"), replace(how, identity=("2",))]
    assert len({each.stem(PART) for each in (how, *others)}) == 4


def test_another_compiler_makes_everything_again(cache_dir, compiled, monkeypatch):
    load(WHOLE)
    compiled()
    monkeypatch.setenv("CC", os.environ["CC"] + " -DANOTHER")
    load(WHOLE)
    assert compiled() == ["part", "whole", "whole_module"]


@pytest.mark.parametrize("damage", ["flip", "truncate", "remove", "record"])
def test_a_damaged_part_is_made_again(cache_dir, compiled, damage, caplog):
    load(WHOLE)
    compiled()
    folder = entry_of(cache_dir, "part")
    target = next(folder.glob("*.o"))
    content = bytearray(target.read_bytes())
    if damage == "flip":
        content[len(content) // 2] ^= 0xFF
        target.write_bytes(content)
    elif damage == "truncate":
        target.write_bytes(content[:100])
    elif damage == "remove":
        target.unlink()
    else:
        (folder / cache.RECORD).write_text("[]")
    assert load(OTHER).lib.twice(1.0) == 30.0
    assert compiled() == ["part", "whole"]
    assert any("damaged" in record.message for record in caplog.records)


def test_a_part_that_is_removed_before_it_is_linked_is_made_again(cache_dir, monkeypatch):
    fetch, lost = cache.fetch, []

    def losing(stem, make, suffix=cache.LIBRARY_SUFFIX):
        path = fetch(stem, make, suffix)
        if "part" in stem and not lost:
            lost.append(path)
            path.unlink()
        return path

    monkeypatch.setattr(cache, "fetch", losing)
    assert load(WHOLE).lib.twice(1.0) == 6.0 and lost


def test_processes_that_race_make_each_part_once(cache_dir, compiled):
    racers = [
        subprocess.Popen(
            [sys.executable, "-c", CHILD, extension_parts.__file__, which],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        for which in ("WHOLE", "OTHER", "WHOLE")
    ]
    answers = [racer.communicate(timeout=PATIENCE) for racer in racers]
    assert answers == [("6.0\n", ""), ("30.0\n", ""), ("6.0\n", "")]
    assert compiled() == ["part", "whole", "whole", "whole_module"]


def test_errors_name_the_part(cache_dir):
    broken = replace(PART, name="broken", source="double part(double x) { return x + y; }")
    with pytest.raises(CompileError, match="broken.*undeclared") as caught:
        load(replace(WHOLE, units=(broken,)))
    assert caught.value.source.is_file()
    assert not [path for path in cache_dir.glob("bs_whole_*") if "module" not in path.name]


def test_names_that_are_no_identifiers_are_refused():
    with pytest.raises(SpecError, match="cannot name an extension"):
        Unit("a b", "")
    with pytest.raises(SpecError, match="cannot name a header"):
        Unit("a", "", {"../x.h": ""})


def test_without_python_headers_parts_are_linked_all_the_same(cache_dir, monkeypatch):
    monkeypatch.setattr(extension, "_include", lambda: "/nonexistent")
    assert load(WHOLE).lib.twice(1.0) == 6.0
    assert not list(cache_dir.glob("bs_whole_module_*"))


def test_parts_are_listed_and_cleared(cache_dir):
    load(WHOLE)
    names = sorted(entry.stem.rsplit("_", 1)[0] for entry in cache.entries())
    assert names == ["bs_part", "bs_whole", "bs_whole_module"]
    record = json.loads((entry_of(cache_dir, "part") / cache.RECORD).read_text())
    assert record["name"] == "part" and record["seconds"] >= 0
    assert cache.clear()[0] == 3 and not cache.entries()


def test_one_processor_is_enough(cache_dir, monkeypatch):
    monkeypatch.setattr(translation_units.os, "sched_getaffinity", lambda _: {0}, raising=False)
    assert load(WHOLE).lib.twice(1.0) == 6.0

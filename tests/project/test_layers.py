"""Imports go down in layers and make no cycles, also those of functions and of types; folders are small."""

from __future__ import annotations

import ast
import tomllib
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from typing import Any

import pytest

CHECKOUT = Path(__file__).resolve().parents[2]
#: Folder -> its package.
PACKAGES = {"codegen": ("bladesmith", "codegen"), "runtime": ("bladesmith",)}
MOST_MODULES = 14

Name = tuple[str, ...]


def modules() -> dict[Name, Path]:
    found = {}
    for folder, package in PACKAGES.items():
        for path in (CHECKOUT / folder).rglob("*.py"):
            inside = path.relative_to(CHECKOUT / folder).with_suffix("").parts
            found[(*package, *(inside[:-1] if inside[-1] == "__init__" else inside))] = path
    return found


def imports(name: Name, path: Path, known: dict[Name, Path]) -> Iterator[Name]:
    """Modules of the project that a module imports, wherever in its text."""
    package = name if path.name == "__init__.py" else name[:-1]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = (
                (*package[: len(package) - node.level + 1], *(node.module or "").split("."))
                if node.module
                else (package[: len(package) - node.level + 1])
            )
        elif isinstance(node, ast.ImportFrom):
            base = tuple((node.module or "").split("."))
        elif isinstance(node, ast.Import):
            yield from (part for alias in node.names if (part := tuple(alias.name.split("."))) in known)
            continue
        else:
            continue
        for alias in node.names:
            inner = (*base, alias.name)
            if inner in known:
                yield inner
            elif base in known:
                yield base


def edges() -> list[tuple[Name, Name]]:
    known = modules()
    return [(name, other) for name, path in known.items() for other in set(imports(name, path, known)) - {name}]


def contracts() -> list[dict[str, Any]]:
    """Layers as pyproject.toml states them for import-linter, which needs an install that is not editable."""
    tool = tomllib.loads((CHECKOUT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]
    return [contract for contract in tool["importlinter"]["contracts"] if contract["type"] == "layers"]


@pytest.mark.parametrize("contract", contracts(), ids=lambda contract: contract["name"])
def test_imports_go_down(contract):
    level, independent = {}, set()
    for i, layer in enumerate(contract["layers"]):
        names = [name.strip() for name in layer.replace("|", ":").split(":")]
        level.update(dict.fromkeys(names, i))
        independent |= {i} if "|" in layer else set()
    wrong = []
    for container in contract["containers"]:
        home = tuple(container.split("."))
        inside = [(a, b, a[len(home)], b[len(home)]) for a, b in edges() if is_inside(a, home) and is_inside(b, home)]
        for a, b, upper, lower in inside:
            if level[upper] > level[lower] or (
                upper != lower and level[upper] == level[lower] and level[upper] in independent
            ):
                wrong.append(f"{'.'.join(a)} imports {'.'.join(b)}")
    assert not wrong


def is_inside(name: Name, home: Name) -> bool:
    return len(name) > len(home) and name[: len(home)] == home


def test_no_module_is_imported_by_what_it_imports():
    graph: dict[Name, set[Name]] = {}
    for name, other in edges():
        graph.setdefault(name, set()).add(other)
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail("a cycle of imports: " + " <- ".join(".".join(name) for name in error.args[1]))


@pytest.mark.parametrize("folder", [*PACKAGES, "tests"])
def test_folders_are_small(folder):
    folders = [CHECKOUT / folder, *(path for path in (CHECKOUT / folder).rglob("*") if path.is_dir())]
    sizes = {folder: len([p for p in folder.glob("*.py") if p.name != "__init__.py"]) for folder in folders}
    assert not _larger(sizes)


def test_folders_of_templates_are_small():
    folders = [path for path in (CHECKOUT / "templates").rglob("*") if path.is_dir() and path.name != "__pycache__"]
    assert not _larger({folder: len([p for p in folder.iterdir() if p.is_file()]) for folder in folders})


def _larger(sizes: dict[Path, int]) -> dict[str, int]:
    return {str(folder.relative_to(CHECKOUT)): size for folder, size in sizes.items() if size > MOST_MODULES}

"""Static types for users: mypy knows a type for each public name and attribute, and for what each function returns."""

from __future__ import annotations

import ast
import dataclasses
import importlib
import inspect
import pkgutil
import re
import subprocess
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import bladesmith
from bladesmith.common.deprecation import renamed_attribute

from ..support.checkout import public_modules

#: Names that have no static type, by the reason.
UNTYPED = {
    "the package has no types": r"to_clifford",
    "Axes3D of matplotlib has no types": (
        r"(plot|registration|reform)\.(axes|draw|draw_model|orbit|paths|screw|twist_field)|picture"
    ),
    "sparse matrices of scipy": r"constraint_matrix|joint_jacobian|body_jacobian|Loops\.matrix|Tree\.solver",
    "what a user's function takes and gives": (
        r"(KernelFunction|Kernel|(Sized)?Algorithm(Function|Derivative|Pullback|Text)?)\.(\w+)"
        r"|(Event|PinLinear)\.function|KernelSignature\.kernel"
    ),
    "whatever was interrupted": r"(Interrupted|ExecutorError)\.partial|Progress\.detail",
    "what widgets of Jupyter inherit": r"InteractiveFigure\.\w+",
    "a point, or its position": r"Revolute\.point",
    "SymPy has no types": r"SymbolicMultivector\.(coefficient|norm|scalar)",
    "a place, weights, or a callee, by the operation": r"Node\.data",
    "coefficients of any ring": r"codegen\.(Multivector\.scalar|rings\..*)",
}
#: What generic classes of the package are made for.
MULTIVECTOR = "bladesmith.core.multivector.Multivector"
#: A line of mypy's answer.
REVEALED = re.compile(r'use\.py:(\d+): note: Revealed type is "(.*)"$', re.M)


def attributes(kind: type) -> list[str]:
    """Public attributes: of the class, annotated, or set in its methods; old names and mere arguments are left out."""
    names = {n for n in dir(kind) if not isinstance(inspect.getattr_static(kind, n), renamed_attribute)}
    for base in kind.__mro__:
        if base.__module__.startswith("bladesmith."):
            names |= set(vars(base).get("__annotations__", ()))
            for node in ast.walk(ast.parse(textwrap.dedent(inspect.getsource(base)))):
                if (
                    isinstance(node, ast.Attribute)
                    and isinstance(node.ctx, ast.Store)
                    and ast.unparse(node.value) == "self"
                ):
                    names.add(node.attr)
    arguments = {n for n, field in getattr(kind, "__dataclass_fields__", {}).items() if is_argument(field)}
    return sorted(n for n in names - arguments if not n.startswith("_"))


def is_argument(field: dataclasses.Field[Any]) -> bool:
    """Return whether a field of a dataclass is an `InitVar`."""
    return field._field_type is dataclasses._FIELD_INITVAR  # type: ignore[attr-defined]


def results(type_: str) -> Iterator[str]:
    """The type itself, or those that a function returns, one for each overload."""
    if type_.startswith("Overload("):
        for each in re.split(r", (?=def )", type_[len("Overload(") : -1]):
            yield from results(each)
    elif type_.startswith("def "):
        depth = 0
        for at, letter in enumerate(type_):
            depth += (letter in "([") - (letter in ")]")
            if letter == ")" and not depth:
                yield type_[at + 1 :].removeprefix(" -> ")
                break
    else:
        yield type_


def annotation(owner: str) -> str:
    """A class as an annotation: generic ones with arguments."""
    value = pkgutil.resolve_name(owner)
    count = len(getattr(value, "__parameters__", ()))
    return f"{owner}[{', '.join([MULTIVECTOR] * count)}]" if count else owner


class User:
    """A user's file that asks mypy for types."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        package = folder / "site" / "bladesmith"
        package.mkdir(parents=True)
        folders = [Path(p) for p in bladesmith.__path__]
        packages = [
            Path(importlib.import_module(f"bladesmith.{n}").__path__[0]) for n in ("codegen", "templates", "generated")
        ]
        for path in [*(x for f in folders for x in f.iterdir()), *packages]:
            if not (package / path.name).exists():
                (package / path.name).symlink_to(path)  # mypy does not follow the import hook of an editable install

    def types(self, expressions: dict[str, list[str]], imports: set[str]) -> dict[str, str]:
        """Types of names, and of attributes of classes (under the class's name; expressions without one under "")."""
        lines = [f"import {name}" for name in sorted(imports)]
        asked = {}
        for owner, names in expressions.items():
            if owner and names:
                lines.append(f"def use_{len(lines)}(x: {annotation(owner)}) -> None:")
            for name in names:
                lines.append(f"    reveal_type(x.{name})" if owner else f"reveal_type({name})")
                asked[len(lines)] = f"{owner}.{name}" if owner else name
        (self.folder / "use.py").write_text("\n".join(lines) + "\n")
        command = [
            sys.executable,
            "-m",
            "mypy",
            "--strict",
            "--cache-dir",
            "cache",
            "--no-error-summary",
            "--follow-imports",
            "silent",
            "use.py",
        ]
        done = subprocess.run(
            command, cwd=self.folder, env={"MYPYPATH": "site", "PATH": ""}, capture_output=True, text=True, check=False
        )
        errors = [line for line in done.stdout.splitlines() if ": error: " in line]
        assert not errors and not done.stderr, "\n".join([*errors, done.stderr])
        return {asked[int(line)]: type_ for line, type_ in REVEALED.findall(done.stdout)}


@pytest.mark.slow
@pytest.mark.peers
def test_every_public_name_has_a_type(tmp_path: Path) -> None:
    """Also attributes of public classes, and of classes whose instances public functions and attributes give."""
    user, modules = User(tmp_path), public_modules()
    assert {"bladesmith", "bladesmith.dynamics", "bladesmith.objects", "bladesmith.tracer"} <= modules.keys()
    expressions = {"": [f"{module}.{name}" for module, names in modules.items() for name in names]}
    classes = {}
    for module, names in modules.items():
        for name in names:
            kind = getattr(importlib.import_module(module), name)
            if isinstance(kind, type) and kind not in classes.values():
                classes[f"{module}.{name}"] = kind
    found: dict[str, str] = {}
    for _ in range(2):
        expressions |= {name: attributes(kind) for name, kind in classes.items()}
        found |= user.types(expressions, set(modules) | {name.rpartition(".")[0] for name in classes})
        known, expressions = set(classes.values()), {}
        classes = {name: kind for name, kind in returned_classes(found) if kind not in known}
    untyped = [
        f"{name}: {type_}"
        for name, type_ in found.items()
        if any(re.fullmatch(r"Any|builtins\.object", each) for each in results(type_))
        and not any(re.search(rf"\.({names})$", name) for names in UNTYPED.values())
    ]
    assert not untyped, "\n".join(untyped)


def returned_classes(found: dict[str, str]) -> Iterator[tuple[str, type]]:
    """Classes of the package in types of attributes and in what functions return."""
    for type_ in found.values():
        for name in {n for each in results(type_) for n in re.findall(r"bladesmith(?:\.\w+)+", each)}:
            module, _, last = name.rpartition(".")
            kind = getattr(sys.modules.get(module), last, None)  # a member of an enumeration is no class
            if isinstance(kind, type) and not last.startswith("_"):
                yield name, kind


def test_the_package_says_that_it_is_typed() -> None:
    assert any((Path(folder) / "py.typed").is_file() for folder in bladesmith.__path__)

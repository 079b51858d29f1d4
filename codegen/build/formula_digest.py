"""The functions of `codegen.formulas` that a formula reaches, as one digest: when it changes, so may the kernel's text.

Sources are read, not imported: a check costs a parse of the modules concerned, and sees files younger than this
process. Comments and line breaks do not count; docstrings do, since their first lines stand in generated text.
"""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache

from ..errors import SpecError
from .source_digest import ROOT, affects_text, closure, text_of

_FORMULAS = "formulas"
_DIGITS = 16


@dataclass(frozen=True)
class Definition:
    """A statement of a module: its text without layout, and the names that it mentions."""

    text: str
    names: frozenset[str]


@dataclass(frozen=True)
class Module:
    """A module of formulas, by name: what it defines, what it takes from other modules of formulas, and the rest."""

    definitions: dict[str, Definition] = field(default_factory=dict)
    imported: dict[str, tuple[str, str]] = field(default_factory=dict)
    modules: dict[str, str] = field(default_factory=dict)
    others: list[Definition] = field(default_factory=list)


def formula_digest(name: str) -> str:
    """Digest of a formula, ``module.function``, and of every function, class and constant that it reaches.

    Raises
    ------
    SpecError
        If there is no such formula.
    """
    module, _, function = name.rpartition(".")
    if function not in _module(module).definitions:
        raise SpecError(f"{module} has no formula {function!r}.")
    reached = _reachable_texts(module, function)
    parts = [f"{home}.{own}\0{text}" for (home, own), text in sorted(reached.items())]
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:_DIGITS]


@cache
def machinery_digest(*files: str) -> str:
    """Digest of files of this package and of all that they and formulas import: no formulas, programs, build stages."""
    formulas = [path.relative_to(ROOT).as_posix() for path in sorted((ROOT / _FORMULAS).rglob("*.py"))]
    followed = closure([*files, *formulas], lambda name: name.startswith("programs/") or not affects_text(name))
    found = followed - set(formulas)
    parts = [f"{name}\0{_canonical(ast.parse(text_of(name)))}" for name in sorted(found)]
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:_DIGITS]


def file_digest(name: str) -> str:
    """Digest of a file of this package, without comments and layout."""
    return hashlib.sha256(_canonical(ast.parse(text_of(name))).encode()).hexdigest()[:_DIGITS]


def _canonical(node: object) -> str:
    """The text of a node: as `ast.dump`, in a form that all versions of Python share.

    They differ in fields that are empty, and in whether these are written.
    """
    if isinstance(node, ast.AST):
        fields = [(name, getattr(node, name, None)) for name in node._fields]
        inside = ", ".join(f"{name}={_canonical(value)}" for name, value in fields if value not in (None, []))
        return f"{type(node).__name__}({inside})"
    return f"[{', '.join(map(_canonical, node))}]" if isinstance(node, list) else repr(node)


def _reachable_texts(module: str, name: str) -> dict[tuple[str, str], str]:
    """Texts by module and name. What stands outside of definitions counts for every module that is reached."""
    found: dict[tuple[str, str], str] = {}
    waiting = [(module, name)]
    while waiting:
        home, own = waiting.pop()
        definition = _module(home).definitions.get(own)
        if (home, own) in found or definition is None:
            continue
        found[home, own] = definition.text
        waiting += _references(home, definition)
        for i, other in enumerate(_module(home).others):
            if (home, f"statement {i}") not in found:
                found[home, f"statement {i}"] = other.text
                waiting += _references(home, other)
    return found


def _references(home: str, definition: Definition) -> Iterator[tuple[str, str]]:
    """Definitions of formulas behind the names of a definition; of a module that is named, all names at hand."""
    module = _module(home)
    for name in definition.names:
        if name in module.definitions:
            yield home, name
        elif name in module.imported:
            yield module.imported[name]
        elif name in module.modules:
            whole = module.modules[name]
            yield from ((whole, other) for other in definition.names & _module(whole).definitions.keys())


@cache
def _module(name: str) -> Module:
    found = Module()
    path = next((ROOT / _FORMULAS).glob(f"*/{name}.py"), None)
    if path is None:
        raise SpecError(f"there is no module of formulas {name!r}.")
    try:
        tree = ast.parse(text_of(path.relative_to(ROOT).as_posix()))
    except SyntaxError as error:
        raise SpecError(f"codegen/{path.relative_to(ROOT).as_posix()}, line {error.lineno}: {error.msg}.") from None
    for statement in tree.body:
        _add(found, statement)
    return found


def _add(module: Module, statement: ast.stmt) -> None:
    match statement:
        case ast.ImportFrom(module=source, names=names, level=1 | 2 as level):
            for each in names:
                if (source or "").count(".") == level - 1 and source:  # `from .module` or `from ..folder.module`
                    module.imported[each.asname or each.name] = (source.rpartition(".")[2], each.name)
                else:
                    module.modules[each.asname or each.name] = each.name
        case ast.Import() | ast.ImportFrom():
            pass  # machinery or a library: the same for all formulas
        case ast.FunctionDef(name=name) | ast.ClassDef(name=name):
            module.definitions[name] = _definition(statement)
        case ast.Assign() | ast.AnnAssign():
            targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
            for target in targets:
                for node in ast.walk(target):
                    if isinstance(node, ast.Name):
                        module.definitions[node.id] = _definition(statement)
        case ast.Expr(value=ast.Constant()):
            pass  # a docstring
        case _:
            module.others.append(_definition(statement))


def _definition(statement: ast.stmt) -> Definition:
    names = {n.id for n in ast.walk(statement) if isinstance(n, ast.Name)}
    attributes = {n.attr for n in ast.walk(statement) if isinstance(n, ast.Attribute)}
    return Definition(_canonical(statement), frozenset(names | attributes))

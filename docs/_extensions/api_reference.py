"""Pages of the API reference: one for each public module, and one for each of its classes.

The pages are written when a build begins, into `reference/api/`, which git ignores: what is public is said once, by
the stubs and ``__all__`` of the package.
"""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Iterator
from functools import reduce
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

import bladesmith
from bladesmith.common.deprecation import renamed_attribute

FOLDER = Path("reference") / "api"
#: Second names of modules.
ALIASES = {"bladesmith.registration": "bladesmith.reform"}

#: Bases whose own members the reference leaves out.
FOREIGN = ("int", "tuple", "dict", "list", "str", "Enum", "IntEnum", "NamedTuple")


def public_modules() -> list[str]:
    """The package, and the modules that are public names of it."""
    values = {name: getattr(bladesmith, name) for name in bladesmith.__all__}
    modules = sorted({x.__name__ for x in values.values() if inspect.ismodule(x)})
    return ["bladesmith", *(m for m in modules if m not in ALIASES), "bladesmith.codegen.ga", "bladesmith.plot.palette"]


def public_names(module: str) -> list[str]:
    """Public names of a module, without its modules."""
    found = _module(module)
    listed = getattr(found, "__all__", None)
    names = listed or [n for n, x in vars(found).items() if _is_own(n, x)]
    return sorted(n for n in names if not inspect.ismodule(getattr(found, n)) and not _stands_elsewhere(module, n))


def _stands_elsewhere(module: str, name: str) -> bool:
    """Whether a name is an error that a module has beside `bladesmith.errors`."""
    return module != "bladesmith.errors" and hasattr(bladesmith.errors, name) and name.endswith("Error")


def _module(name: str) -> Any:
    """A module by its public name, which need not be where its file is."""
    package, *path = name.split(".")
    return reduce(getattr, path, importlib.import_module(package))


def _is_own(name: str, value: Any) -> bool:
    return not name.startswith("_") and str(getattr(value, "__module__", "")).startswith("bladesmith.")


def pages() -> Iterator[tuple[str, str]]:
    """Names of pages and their text, in reStructuredText as the docstrings are."""
    yield "index", _index()
    for module in public_modules():
        yield module, _module_page(module)
        for name in public_names(module):
            if _has_page(getattr(_module(module), name)):
                yield f"{module}.{name}", _class_page(module, name)


def _has_page(value: Any) -> bool:
    return inspect.isclass(value) and not issubclass(value, BaseException)


def _index() -> str:
    modules = "\n".join(f"   {module}" for module in public_modules())
    said = {module: (inspect.getdoc(_module(module)) or "").partition("\n\n")[0] for module in public_modules()}
    listed = "\n".join(f":doc:`{module}`\n   {' '.join(text.split())}\n" for module, text in said.items())
    return f"{_title('Names')}\n{listed}\n.. toctree::\n   :hidden:\n\n{modules}\n"


def _module_page(module: str) -> str:
    found = _module(module)
    by_kind: dict[str, list[str]] = {"class": [], "exception": [], "function": [], "data": []}
    for name in public_names(module):
        value = getattr(found, name)
        kind = "data"
        if inspect.isclass(value):
            kind = "exception" if issubclass(value, BaseException) else "class"
        elif callable(value) and not hasattr(value, "dimension"):
            kind = "function"
        by_kind[kind].append(name)
    text = [_title(module), f".. py:module:: {module}\n\n{inspect.getdoc(found) or ''}\n"]
    pages = [f"{module}.{name}" for name in by_kind["class"]]
    if pages:
        listed = "\n".join(f"   {name}" for name in by_kind["class"])
        hidden = "\n".join(f"   {page}" for page in pages)
        text += [_title("Classes", "-"), f".. autosummary::\n   :nosignatures:\n\n{listed}\n"]
        text += [f".. toctree::\n   :hidden:\n\n{hidden}\n"]
    for kind, heading in (("function", "Functions"), ("exception", "Exceptions"), ("data", "Objects")):
        if by_kind[kind]:
            text.append(_title(heading, "-"))
            text += [_described(kind, module, name) for name in by_kind[kind]]
    return "\n".join(text)


def _described(kind: str, module: str, name: str) -> str:
    if kind == "data":
        value = getattr(_module(module), name)
        said = next(iter((inspect.getdoc(type(value)) or "").splitlines()), "") if not isinstance(value, str) else ""
        return f".. py:data:: {name}\n   :type: {type(value).__name__}\n\n   {said}\n"
    return f".. auto{kind}:: {module}.{name}\n"


def _class_page(module: str, name: str) -> str:
    value = getattr(_module(module), name)
    old = [n for n in dir(value) if isinstance(inspect.getattr_static(value, n), renamed_attribute)]
    return "\n".join(
        [
            _title(name),
            f".. currentmodule:: {module}\n",
            f".. autoclass:: {module}.{name}",
            "   :members:",
            f"   :inherited-members: {', '.join(FOREIGN)}",
            f"   :exclude-members: {', '.join(['__init__', '__new__', *old])}\n",
        ]
    )


def _title(text: str, line: str = "=") -> str:
    return f"{text}\n{line * len(text)}\n"


def write_pages(app: Sphinx) -> None:
    """Write what has changed, and delete what is no page any more."""
    folder = Path(app.srcdir) / FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    wanted = {folder / f"{name}.rst": text for name, text in pages()}
    for path in folder.glob("*.rst"):
        if path not in wanted:
            path.unlink()
    for path, text in wanted.items():
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def setup(app: Sphinx) -> dict[str, bool]:
    """Hook the pages into a build."""
    app.connect("builder-inited", write_pages)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

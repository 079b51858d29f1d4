"""Where algebras come from: a signature, the package's generated folders, a user's folder, or plain data.

Each is made once in a process, so that multivectors of one algebra always meet.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from functools import cache
from importlib import import_module, resources
from pathlib import Path
from typing import Any
from weakref import WeakValueDictionary

from . import stock
from .algebras import Algebra
from .codegen import algebra as mathematics
from .codegen.catalogue import STOCK, data_from_algebra
from .codegen.errors import InputError, SpecError
from .codegen.kinds import add_plain_kinds
from .stock import StockKernels


def algebra(p: int, q: int = 0, r: int = 0) -> Algebra:
    """Cl(p, q, r), to 15 dimensions: e1 .. ep square to +1, the next q to -1, the last r to 0.

    With r = 1 the null vector is e0 and comes first. ``algebra(3, 0, 1)`` is the stock ``pga3d``.

    Raises
    ------
    SignatureError
        If a number is not a non-negative integer, or there are more than 15 vectors.
    """
    plain = mathematics.orthonormal(p, q, r)  # checks the numbers
    return _plain_algebra(p, q, r) if plain.signature != (3, 0, 1) else stock_algebra("pga3d")


@cache
def _plain_algebra(p: int, q: int, r: int) -> Algebra:
    plain = mathematics.orthonormal(p, q, r)
    new = Algebra(plain.name, plain.vectors, plain.metric)
    add_plain_kinds(new)
    new.remember(algebra, p, q, r)
    return new


def plain_algebra(like: Algebra) -> Algebra:
    """The one algebra of a name, vectors and metric, with the kinds that every algebra has."""
    return from_hashable(hashable({**data_from_algebra(like), "kinds": {}}))


#: Classes of the algebras that stand for a geometry, by name.
CLASSES = {
    "cga3d": ("conformal", "ConformalAlgebra"),
    "cga2d": ("conformal", "ConformalPlane"),
    "pga3d": ("projective", "ProjectiveAlgebra"),
}


def is_generated(name: str) -> bool:
    """Whether the package's `generated` folder holds an algebra of this name."""
    return name.isidentifier() and (stock.bundled(name) / "manifest.json").is_file()


@cache
def stock_algebra(name: str) -> Algebra:
    """An algebra of the package's `generated` folder, by name.

    Raises
    ------
    SpecError
        If there is none of this name.
    """
    mathematics.validated_identifier(name, "the algebra's name")
    if is_generated(name):
        return _loaded(stock.bundled(name), stock_algebra, name)
    if name in STOCK:  # its sources are not generated yet: everything works, by the general product
        text = resources.files(f"{__package__}.codegen").joinpath("specs", f"{name}.toml").read_text(encoding="utf-8")
        new = _class_of(name).from_data(tomllib.loads(text))
        new.remember(stock_algebra, name)
        return new
    raise SpecError(f"there is no generated algebra {name!r}.", remedy="Run: bladesmith generate")


def load_algebra(folder: str | Path) -> Algebra:
    """The algebra of a folder that ``bladesmith generate`` wrote; its kernels are compiled once, into the cache.

    Raises
    ------
    SpecError
        If the folder holds no manifest.
    """
    return _load_folder(str(Path(folder).absolute()))


@cache
def _load_folder(path: str) -> Algebra:
    return _loaded(Path(path), load_algebra, path)


def _loaded(folder: Path, origin: Callable[..., Algebra], key: str) -> Algebra:
    manifest = stock.read_manifest(folder)
    new = _class_of(manifest["algebra"]["name"]).from_data(manifest["algebra"])
    new.stock = StockKernels(new, folder, manifest)
    new.remember(origin, key)
    return new


def _class_of(name: str) -> type[Algebra]:
    if name not in CLASSES:
        return Algebra
    module, found = CLASSES[name]
    return getattr(import_module(f".{module}", __package__), found)  # type: ignore[no-any-return]


def hashable(data: Any) -> Any:
    """Plain data as nested tuples, so that the same data gives the same algebra in one process."""
    if isinstance(data, Mapping):
        return ("map", *((key, hashable(value)) for key, value in data.items()))
    return ("list", *map(hashable, data)) if isinstance(data, list | tuple) else data


#: Algebras made from data, by that data: unpickling gives back the one that was pickled in this process.
KNOWN: WeakValueDictionary[Any, Algebra] = WeakValueDictionary()


def from_hashable(data: Any) -> Algebra:
    """The algebra of such data; what pickle calls."""
    known = KNOWN.get(data)
    if known is None:
        plain = _plain_data(data)
        if not isinstance(plain, dict):
            raise InputError("the pickled data is no algebra.")
        known = KNOWN[data] = _class_of(plain["name"]).from_data(plain)
    return known


def _plain_data(data: Any) -> Any:
    if not isinstance(data, tuple):
        return data
    if data[0] == "map":
        return {key: _plain_data(value) for key, value in data[1:]}
    return [_plain_data(value) for value in data[1:]]

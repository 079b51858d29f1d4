"""Algebras by signature, from the package's generated folders, from a user's folder, and from plain data.

Each is made once in a process, so that multivectors of one algebra always meet.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from functools import cache
from importlib import resources
from pathlib import Path

from ..codegen.algebra import algebra as mathematics
from ..codegen.algebra.algebra import add_plain_kinds
from ..codegen.algebra.blades import validated_identifier
from ..codegen.algebra.loader import STOCK, data_from_algebra
from ..codegen.errors import BladesmithError, SpecError, one_line
from ..common.files import as_path
from ..dispatch import stock_kernels
from ..dispatch.stock_kernels import StockKernels
from .multivector import Algebra


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
    return _class_of(like.name).intern({**data_from_algebra(like), "kinds": {}})


def is_generated(name: str) -> bool:
    """Test whether the package's `generated` folder holds an algebra of this name."""
    return name.isidentifier() and (stock_kernels.bundled_folder(name) / "manifest.json").is_file()


@cache
def stock_algebra(name: str) -> Algebra:
    """An algebra of the package's `generated` folder, by name.

    Raises
    ------
    SpecError
        If there is no algebra of this name.
    """
    validated_identifier(name, "the algebra's name")
    if is_generated(name):
        return _load_generated(stock_kernels.bundled_folder(name), stock_algebra, name)
    if name in STOCK:  # its sources are not generated yet: everything works, by the general product
        text = (
            resources.files(f"{__package__.partition('.')[0]}.codegen")
            .joinpath("specs", f"{name}.toml")
            .read_text(encoding="utf-8")
        )
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
    return _load_folder(str(as_path(folder, "an algebra is loaded from").absolute()))


@cache
def _load_folder(path: str) -> Algebra:
    return _load_generated(Path(path), load_algebra, path)


def _load_generated(folder: Path, origin: Callable[..., Algebra], key: str) -> Algebra:
    manifest = stock_kernels.read_manifest(folder)
    try:
        new = _class_of(manifest["algebra"]["name"]).from_data(manifest["algebra"])
        new.stock = StockKernels(new, folder, manifest)
    except (BladesmithError, ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        what = f"an entry is missing or wrong ({one_line(error)})"
        raise SpecError(what, where=str(folder / "manifest.json"), remedy="Run: bladesmith generate") from None
    new.remember(origin, key)
    return new


def _class_of(name: str) -> type[Algebra]:
    """The class of an algebra: those of a geometry are imported when one of their name is first used."""
    if name in ("cga3d", "cga2d"):
        from .geometry.conformal import ConformalAlgebra, ConformalPlane

        return ConformalAlgebra if name == "cga3d" else ConformalPlane
    if name == "pga3d":
        from .geometry.projective import ProjectiveAlgebra

        return ProjectiveAlgebra
    return Algebra


Algebra._by_signature = staticmethod(algebra)

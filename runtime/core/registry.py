"""Algebras by signature, from the package's generated folders, from a user's folder, and from plain data.

Each is made once in a process, so that multivectors of one algebra always meet.
"""

from __future__ import annotations

import hashlib
import keyword
import tomllib
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from ..codegen.algebra import algebra as mathematics
from ..codegen.algebra import metrics
from ..codegen.algebra.algebra import add_plain_kinds
from ..codegen.algebra.blades import DIGITS, validated_identifier
from ..codegen.algebra.loader import PRESETS, STOCK, data_from_algebra
from ..codegen.errors import BladesmithError, SignatureError, SpecError, one_line
from ..common.files import as_path
from ..dispatch import stock_kernels
from ..dispatch.stock_kernels import StockKernels
from .multivector import Algebra


def algebra(
    p: int | None = None,
    q: int = 0,
    r: int = 0,
    *,
    signature: Iterable[int] | None = None,
    metric: Any = None,
    vectors: str | Iterable[str] | None = None,
) -> Algebra:
    """A geometric algebra, by numbers of vectors, by their squares, or by any metric; to 24 dimensions.

    Parameters
    ----------
    p, q, r : int
        Cl(p, q, r): e1 .. ep square to +1, the next q to -1, the last r to 0. With r = 1 the null vector is e0 and
        comes first. ``algebra(3, 0, 1)`` is the stock ``pga3d``.
    signature : sequence of int, optional
        In place of them, the square of each vector: 1, -1 or 0. A single null vector that comes first is e0.
    metric : matrix or dict, optional
        In place of them, the inner products of the vectors: a symmetric matrix (nested lists, an array, a SymPy
        matrix), or products by names, ``{"no|ni": -1, "e1": 2}``; a vector that no key names squares to 1. Metrics
        are exact: whole numbers, fractions, their text ("1/3"), or floats that are binary fractions.
    vectors : str or sequence of str, optional
        Names of the vectors, "e1 e2 no ni". No name begins with another.

    Raises
    ------
    SignatureError
        If a number is not a non-negative integer, there are more than 24 vectors, the metric is not symmetric or not
        exact, or the names are not those of as many vectors.

    Examples
    --------
    >>> import bladesmith as bs
    >>> bs.algebra(signature=[0, 1, 1]) is bs.algebra(2, 0, 1)
    True
    >>> cga = bs.algebra(metric={"no|ni": -1}, vectors="e1 e2 e3 no ni")
    >>> cga.no * cga.ni
    1_noni of cl4_1_0_981e7d19: -1 + 1 noni
    """
    ways = [p is not None, signature is not None, metric is not None]
    if sum(ways) != 1 or (p is None and (q != 0 or r != 0)):
        raise SignatureError(
            "an algebra is made by one of: algebra(p, q, r), algebra(signature=[...]), algebra(metric=...)."
        )
    names = None if vectors is None else metrics.read_labels(vectors)
    if p is not None:
        plain = mathematics.orthonormal(p, q, r)  # checks the numbers
        if names is None:
            return _plain_algebra(p, q, r) if plain.signature != (3, 0, 1) else stock_algebra("pga3d")
        products = [list(row) for row in plain.metric]
    elif signature is not None:
        products = metrics.from_squares(signature)
    elif isinstance(metric, Mapping):
        if names is None:
            raise SignatureError("a metric by names needs those of all vectors.", remedy='Add vectors="e1 e2 no ni"')
        products = metrics.from_products(metric, names)
    else:
        products = metrics.from_matrix(metric)
    if names is None:
        names = metrics.usual_labels(products)
    return _algebra_of(names, products)


def _algebra_of(labels: list[str], metric: metrics.Metric) -> Algebra:
    """The one algebra on these vectors: the usual one of its signature, where it is that."""
    if len(labels) != len(metric):
        raise SignatureError(f"there are {len(labels)} names of vectors and {len(metric)} vectors.")
    new = mathematics.Algebra("new", labels, metric)
    p, q, r = new.signature
    usual = algebra(p, q, r)
    if (usual.vectors, usual.metric) == (new.vectors, new.metric):
        return usual
    reserved = next((label for label in new.vectors if is_reserved(label) or label in vars(usual)), None)
    if reserved is not None:
        why = "it is a word of Python" if keyword.iskeyword(reserved) else "algebras have an attribute of it"
        raise SignatureError(f"{reserved} cannot be the name of a basis vector: {why}.")
    data = {**data_from_algebra(new), "kinds": {}}
    digest = hashlib.sha256(repr((data["vectors"], data["metric"])).encode()).hexdigest()[:DIGITS]
    return Algebra.intern({**data, "name": f"cl{p}_{q}_{r}_{digest}"})


def is_reserved(name: str) -> bool:
    """Test whether a basis vector of this name could not be written: a word of Python, or an attribute of algebras."""
    return keyword.iskeyword(name) or hasattr(Algebra, name)


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
    if name in (*STOCK, *PRESETS):  # its sources are not generated: everything works, by the general product
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
    if name in ("pga3d", "pga2d"):
        from .geometry.projective import ProjectiveAlgebra, ProjectivePlane

        return ProjectiveAlgebra if name == "pga3d" else ProjectivePlane
    if name in PRESETS:
        from .geometry.presets import CLASSES

        return CLASSES[name]
    return Algebra


Algebra._by_signature = staticmethod(algebra)

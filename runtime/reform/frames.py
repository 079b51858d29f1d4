"""Models in frames of their own: near an origin, of about unit size, so that no digit is lost and tolerances mean one
thing. A motor between two frames is taken back to the world.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..algebras import Algebra
from ..codegen.formulas.subspaces import length_powers
from ..multivector import Multivector
from ..objects.local import Frame
from .engine import Driver
from .sides import Closeness, Side

Array = NDArray[Any]
#: Directions in which the objects say less than this, relative to the most, do not place a model's centre.
LOOSE = 1e-6
#: A size below this share of how far the objects are from the world's origin is rounding.
ROUNDING = 1e-12
#: A model is as large as this quantile of its objects' distances from the centre: a few far ones do not count.
SIZE_QUANTILE = 0.75
#: Objects more than so many times as far from the centre as that do not place it; rounds of leaving them out, at most.
FAR, ROUNDS = 3.0, 8


@dataclass(frozen=True)
class Local:
    """A model in its frame.

    Attributes
    ----------
    center : array (3,)
        The frame's origin, in the world.
    unit : float
        The frame's unit of length, a power of two: scaling by it is exact.
    objects : mapping of kind to Multivector (n,)
        In the frame.
    side : Side
        The same for the driver.
    """

    center: Array
    unit: float
    objects: Mapping[str, Multivector]
    side: Side

    @property
    def count(self) -> int:
        """Objects of all kinds."""
        return sum(x.shape[0] for x in self.objects.values())


def middle(elements: Mapping[str, Array]) -> Array:
    """The point (3,) nearest to all objects together but for a few far ones, in the sense of least squares."""
    places = np.concatenate([e[:, :3] for e in elements.values()])
    weights = np.concatenate([_across(kind, e[:, 3:6]) for kind, e in elements.items()])
    near, least = np.ones(len(places), bool), ROUNDING * float(np.abs(places).max(initial=0.0))
    for _ in range(ROUNDS):
        found = _nearest_point(places[near], weights[near])
        apart = places - found
        squares = np.einsum("ni,nij,nj->n", apart, weights, apart)
        before, near = near, squares <= FAR * FAR * max(_quantile(squares, SIZE_QUANTILE), least * least)
        if np.array_equal(near, before):
            break
    return found


def _across(kind: str, along: Array) -> Array:
    """Projectors (n, 3, 3) to the directions in which objects place a point."""
    if kind not in ("line", "plane"):
        return np.tile(np.eye(3), (len(along), 1, 1))
    own: Array = np.einsum("ni,nj->nij", along, along)
    return own if kind == "plane" else np.eye(3) - own


def _nearest_point(places: Array, weights: Array) -> Array:
    about = places.mean(0)
    moment = np.einsum("nij,nj->i", weights, places - about)
    values, vectors = np.linalg.eigh(weights.sum(0))
    told = values > LOOSE * values[-1]
    found: Array = about + (vectors[:, told] / values[told]) @ (vectors[:, told].T @ moment)
    return found


def size_of(elements: Mapping[str, Array]) -> float:
    """How far objects are from the origin, or how large, whichever is more; zero for flats all through it."""
    reach = np.concatenate([np.linalg.norm(e[:, :3], axis=-1) for e in elements.values()])
    radii = np.concatenate([e[:, 6] for e in elements.values()])
    return float(max(_quantile(reach, SIZE_QUANTILE), _quantile(radii, 0.5)))


def _quantile(values: Array, share: float) -> float:
    return float(np.sort(values)[round(share * (len(values) - 1))])


def local_pair(
    driver: Driver, query: Mapping[str, Multivector], reference: Mapping[str, Multivector]
) -> tuple[Local, Local]:
    """Both models in frames about their own centres, with one unit of length."""
    centers = [middle(_elements(driver, objects)) for objects in (query, reference)]
    algebra = next(iter(query.values())).algebra
    translators = algebra.translator(np.array(centers))
    moved = [
        (center, {kind: Frame(center, translator).inward(x) for kind, x in objects.items()})
        for center, translator, objects in zip(centers, translators, (query, reference), strict=True)
    ]
    size = max(size_of(_elements(driver, objects)) for _, objects in moved)
    far = max(float(np.abs(center).max()) for center, _ in moved)
    unit = 2.0 ** round(math.log2(size)) if size > ROUNDING * far else 1.0
    first, second = (_scaled(driver, center, objects, unit) for center, objects in moved)
    return first, second


def closeness_within(reach: float, least: float = 0.0, align: bool = True, length: float = 1.0) -> Closeness:
    """When a motor lays one object on another: within a reach, by (angle^2 length^2 + 3 distance^2)/4, as of rotors."""
    return Closeness((0.75, 0.25 * length * length, 0.75), reach * reach, least, align)


def _elements(driver: Driver, objects: Mapping[str, Multivector]) -> dict[str, Array]:
    return {kind: driver.elements(kind, x._data) for kind, x in objects.items()}


def _scaled(driver: Driver, center: Array, objects: Mapping[str, Multivector], unit: float) -> Local:
    inside = {kind: scaled(x, 1 / unit) for kind, x in objects.items()}
    rows = {kind: np.ascontiguousarray(x._data, np.float64) for kind, x in inside.items()}
    return Local(center, unit, inside, Side(rows, _elements(driver, inside)))


def scaled(x: Multivector, scale: float) -> Multivector:
    """Unit objects, motors or twists, scaled about the origin; exact for powers of two."""
    powers = np.array(length_powers(x.algebra, x._type.blades)) + (1 if x.grades == (1,) else 0)
    return x._make(x._type, x._data * scale ** powers.astype(np.float64), x.shape, x._status)


def outward(motors: Array, query: Local, reference: Local, algebra: Algebra) -> Multivector:
    """World motors (n,), with <R>_0 >= 0, of motors (n, 8) from the query's frame to the reference's."""
    inside = algebra.wrap(algebra.kind("motor"), motors)
    to, back = algebra.translator(np.stack([reference.center, -query.center]))
    found: Multivector = (to * scaled(inside, query.unit) * back).as_kind("motor", check=False)
    first = (found._data != 0).argmax(-1)[..., None]  # where <R>_0 is 0, the next coefficient decides
    signs = np.where(np.take_along_axis(found._data, first, -1) < 0, -1.0, 1.0)
    return found._make(found._type, signs * found._data, found.shape, found._status)

"""Models of points, point pairs, lines, circles, planes and spheres: what registration lays over each other.

A model keeps the parameters of its objects, which hold their digits far from the origin and in files; the objects of
the algebra are made from them.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import cached_property
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError
from ..multivector import Multivector
from ..objects.inputs import number
from .parameters import KINDS, PLURALS, SIZES, Rows, checked, made_objects, moved
from .repeats import SAME, first_of_each
from .similarities import similarity

Indices = NDArray[np.int64]


class Model:
    """Objects of several kinds. Not changed once it is made: `subset` and `transformed` give another.

    Objects are numbered over all kinds, in the order of the parameters here.

    Parameters
    ----------
    points, point_pairs, lines, circles, planes, spheres : Multivector, list of Multivector, or array, optional
        Unit objects of `bladesmith.cga3d` (n,), a list of them, or their parameters: points (n, 3); point_pairs
        (n, 2, 3), the ends; lines (n, 2, 3), a point and a direction; circles (n, 7), centre, normal and radius;
        planes (n, 4), normal and offset (normal . x = offset); spheres (n, 4), centre and radius. Directions and
        normals may have any length but zero, lengths any unit.
    name, unit, origin : str
        What it is, its unit of length, and where it comes from: for readers, no more.

    Raises
    ------
    InputError
        If an object is of another kind, not finite, no blade, not of unit size, or of another algebra; if a direction
        is zero, a radius not positive, an array of another shape or no array of real numbers. It names list and item.

    Notes
    -----
    A model may be empty, and may hold an object twice: `duplicates` finds those. Spheres are outward; one that is
    given inside out is the same sphere.
    """

    points = property(lambda self: self._objects.get("point"), doc="Points (n,), or None.")
    point_pairs = property(lambda self: self._objects.get("point_pair"), doc="Unit point pairs (n,), or None.")
    lines = property(lambda self: self._objects.get("line"), doc="Unit lines (n,), or None.")
    circles = property(lambda self: self._objects.get("circle"), doc="Unit circles (n,), or None.")
    planes = property(lambda self: self._objects.get("plane"), doc="Unit planes (n,), or None.")
    spheres = property(lambda self: self._objects.get("sphere"), doc="Outward unit spheres (n,), or None.")

    name: str
    unit: str
    origin: str
    _rows: dict[str, Rows]

    def __init__(
        self, points: Any = None, point_pairs: Any = None, lines: Any = None, circles: Any = None, planes: Any = None,
        spheres: Any = None, *, name: str = "", unit: str = "", origin: str = "",
    ) -> None:  # fmt: skip
        given = (points, point_pairs, lines, circles, planes, spheres)
        rows = {kind: checked(x, kind) for kind, x in zip(KINDS, given, strict=True) if x is not None}
        texts = {key: _text(value, key) for key, value in (("name", name), ("unit", unit), ("origin", origin))}
        self._fill(rows, texts)
        _ = self._objects  # what has no coefficients is told here

    def _fill(self, rows: Mapping[str, Rows], texts: Mapping[str, str]) -> None:
        self.__dict__["_rows"] = {kind: rows[kind] for kind in KINDS if kind in rows and len(rows[kind])}
        self.__dict__.update(texts)

    @classmethod
    def _of(cls, rows: Mapping[str, Rows], texts: Mapping[str, str]) -> Model:
        """A model of rows that are known to be good."""
        new = cls.__new__(cls)
        for part in rows.values():
            part.setflags(write=False)
        new._fill(rows, texts)
        return new

    # -- what it holds -------------------------------------------------------------------------------------

    @cached_property
    def _objects(self) -> dict[str, Multivector]:
        return {kind: made_objects(rows, kind) for kind, rows in self._rows.items()}

    @property
    def objects(self) -> dict[str, Multivector]:
        """Unit objects (n,) by kind: point, point_pair, line, circle, plane, sphere; kinds without one are left out."""
        return dict(self._objects)

    @property
    def parameters(self) -> dict[str, Rows]:
        """Parameters by kind, rows (n, k) in the order of the constructor's arguments; directions have length 1."""
        return dict(self._rows)

    @property
    def counts(self) -> dict[str, int]:
        """Objects of each kind that there is."""
        return {kind: len(rows) for kind, rows in self._rows.items()}

    @property
    def slices(self) -> dict[str, slice]:
        """Numbers of each kind's objects among all."""
        ends = np.cumsum([0, *self.counts.values()]).tolist()
        return {kind: slice(a, b) for kind, a, b in zip(self._rows, ends, ends[1:], strict=False)}

    def __len__(self) -> int:
        return sum(self.counts.values())

    def __bool__(self) -> bool:
        return True  # an empty model is a model

    def __repr__(self) -> str:
        shown = ", ".join(f"{n} {PLURALS[k] if n > 1 else k}".replace("_", " ") for k, n in self.counts.items())
        return f"<Model{f' {self.name!r}' if self.name else ''}: {shown or 'empty'}>"

    def __setattr__(self, name: str, *_: Any) -> NoReturn:
        raise AttributeError(f"a model is not changed once it is made ({name}); make another, or use .subset(..).")

    __delattr__ = __setattr__

    def __reduce__(self) -> tuple[Any, ...]:
        return Model._of, (self._rows, self._texts)

    @property
    def _texts(self) -> dict[str, str]:
        return {"name": self.name, "unit": self.unit, "origin": self.origin}

    # -- other models --------------------------------------------------------------------------------------

    def transformed(self, R: Multivector) -> Model:
        """This moved by a motor, or moved and scaled by the rotor of a similarity: R x ~R for each object.

        Raises
        ------
        InputError
            If R is no single versor that keeps flats flat: a motor, a dilator, or a product of them.

        Notes
        -----
        Parameters are moved, not coefficients, whose digits rounds far from the origin would lose.
        """
        scale, rotation, translation = similarity(R)
        return self._remade({k: moved(r, k, scale, rotation, translation) for k, r in self._rows.items()})

    def in_frame(self, center: Any, unit: float = 1.0) -> Model:
        """This as seen from a point, in another unit of length: (x - center) / unit. Exact to rounding of the result.

        Raises
        ------
        InputError
            If the centre is no position or the unit not positive.
        """
        place = checked([center], "point")[0]
        size = number(unit, "unit")
        if not 0 < size < np.inf:
            raise InputError(f"unit is {size:g}; a positive length is needed.")
        shifted = {k: moved(r, k, 1.0, np.eye(3), -place) for k, r in self._rows.items()}
        return self._remade({k: moved(r, k, 1 / size, np.eye(3), np.zeros(3)) for k, r in shifted.items()})

    def subset(self, chosen: Any) -> Model:
        """Some of the objects.

        Parameters
        ----------
        chosen : bool array (len(self),), int array, or mapping
            A mask or numbers over all objects; or for some kinds ("lines" or "line") a mask, numbers or a slice of
            theirs. Within a kind the order is that of the numbers; kinds that the mapping has not are left out.

        Raises
        ------
        InputError
            If there is no such object or kind.
        """
        if isinstance(chosen, Mapping):
            return self._remade({(k := self._kind(key)): self._taken(k, part) for key, part in chosen.items()})
        numbers = _numbers(chosen, len(self), "the model")
        parts = {k: numbers[(numbers >= s.start) & (numbers < s.stop)] - s.start for k, s in self.slices.items()}
        return self._remade({kind: self._rows[kind][part] for kind, part in parts.items()})

    def _taken(self, kind: str, part: Any) -> Rows:
        rows = self._rows.get(kind, np.empty((0, SIZES[kind])))
        return rows[part if isinstance(part, slice) else _numbers(part, len(rows), PLURALS[kind])].copy()

    @staticmethod
    def _kind(name: Any) -> str:
        found = {**{kind: kind for kind in KINDS}, **{plural: kind for kind, plural in PLURALS.items()}}.get(name)
        if found is None:
            raise InputError(f"{name!r} is no kind of object; they are {', '.join(PLURALS.values())}.")
        return found

    def _remade(self, rows: Mapping[str, Rows]) -> Model:
        new = Model._of(rows, self._texts)
        _ = new._objects
        return new

    # -- what is in it twice -------------------------------------------------------------------------------

    def duplicates(self, tolerance: float = SAME) -> Indices:
        """For each object the number of the first object that it repeats, its own where it repeats none.

        x and -x are one object, and so are lines through other points of theirs. Where
        ``m.duplicates() != np.arange(len(m))``, objects are repeats; their numbers leave `subset` a model without.

        Parameters
        ----------
        tolerance : float
            Greatest difference of directions, and of positions and radii relative to the model's size. Never less
            than rounding of its coordinates.
        """
        found = np.arange(len(self))
        limit = number(tolerance, "tolerance")
        if not limit >= 0:
            raise InputError(f"tolerance is {limit}; it is not negative.")
        repeats = first_of_each(self._rows, limit)
        for kind, place in self.slices.items():
            found[place] = place.start + repeats[kind]
        return found

    # -- files ---------------------------------------------------------------------------------------------

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a JSON file (docs/models.md), whole or not at all; `load` gives the same model to the last bit.

        Raises
        ------
        InputError
            If it cannot be written.
        """
        from .schema import save_model

        save_model(path, self._rows, self._texts)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Model:
        """Read a JSON file (docs/models.md).

        Raises
        ------
        InputError
            If it cannot be read, is no JSON or no model: with path and key, as ``m.json: lines[3].direction is ..``.
        """
        from .schema import load_model

        rows, texts, file = load_model(path)
        given: dict[str, Any] = {PLURALS[kind]: _shaped(part, kind) for kind, part in rows.items()}
        try:
            return cls(**given, **texts)
        except InputError as error:
            raise InputError(error.what, where=file, remedy=error.remedy) from None


def _shaped(rows: list[list[float]], kind: str) -> Rows:
    """Rows of numbers as arrays of a kind are taken."""
    array = np.array(rows, np.float64)
    return array.reshape(-1, 2, 3) if kind in ("line", "point_pair") else array


def _text(value: Any, name: str) -> str:
    if not isinstance(value, str):
        raise InputError(f"{name} is a {type(value).__name__}; a text is needed.")
    try:
        value.encode()
    except UnicodeEncodeError:
        raise InputError(f"{name} is {value!r}, which no file can hold.") from None
    return value


def _numbers(chosen: Any, count: int, what: str) -> Indices:
    """A mask or numbers as numbers of objects that are there."""
    array = np.asarray(chosen)
    if array.dtype == bool and array.shape == (count,):
        return np.flatnonzero(array)
    if array.ndim != 1 or (array.size and array.dtype.kind not in "iu"):
        what = f"{what}: the choice has shape {array.shape} and holds {array.dtype}"
        raise InputError(f"{what}; a mask of {count}, or whole numbers, are needed.")
    found = array.astype(np.int64)
    bad = (found < -count) | (found >= count)
    if bad.any():
        raise InputError(f"{what}: there is no object {int(found[bad.argmax()])} among {count}.")
    return np.where(found < 0, found + count, found)


__all__ = ["Model"]

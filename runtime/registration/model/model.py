"""Models for registration: sets of points, point pairs, lines, segments, circles, planes and spheres.

A model stores the parameters of its objects, which keep their digits far from the origin and in files; the objects of
the algebra are built from them.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import cached_property
from typing import Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...codegen.errors import InputError
from ...common.deprecation import renamed_keywords
from ...common.rich_display import Displayed
from ...common.validation import as_float, as_text, positive_float
from ...core.multivector import Multivector
from .duplicates import TOLERANCE, first_occurrences
from .parameters import KINDS, PLURALS, SIZES, Rows, build_objects, rows_in_frame, transform_rows, validated_rows
from .similarity import similarity
from .uncertainty import Uncertainty, validated_uncertainty

Indices = NDArray[np.int64]


class Model(Displayed):
    """An immutable set of objects of several kinds; `subset` and `transformed` return new models.

    Indices of objects run over all kinds: points, point pairs, lines, segments, circles, planes, spheres.

    Parameters
    ----------
    points, point_pairs, lines, circles, planes, spheres : Multivector, list of Multivector, or array, optional
        Unit objects of `bladesmith.cga3d` (n,), a list of them, or their parameters: points (n, 3); point_pairs
        (n, 2, 3), the ends; lines (n, 2, 3), a point and a direction; circles (n, 7), center, normal and radius;
        planes (n, 4), normal and offset (normal . x = offset); spheres (n, 4), center and radius. Directions and
        normals may have any length but zero, lengths any unit.
    segments : array (n, 2, 3), optional
        Both end points of stretches of lines, in any order. Their ends may be cut: a segment matches any stretch of the
        same line.
    weights : array (len(self),), or mapping of kind to array (n,) or number, optional
        How much each object counts: inverse variances, but for a common factor. Zero: it is matched, and does not
        count. Kinds that are left out have the weight 1.
    covariances : mapping of kind to array (n, k, k), optional
        Covariances of the parameters of each object, or (k, k) for all, in the order of `parameters`, directions having
        length 1, in squares of the model's unit of length; for segments and point pairs also (n, 2, 3, 3), one for
        each end. Of all kinds; of a single kind also the array itself.
    name, unit, origin : str
        Name, unit of length and source of the model: texts for readers only.

    Raises
    ------
    InputError
        If an object is of another kind or algebra, not finite, not a blade, or not of unit size; if a direction
        is zero, a radius not positive, an array of another shape or not of real numbers, a weight negative, or a
        covariance not one. The error names the item. Also if lines look like segments, or segments like lines.

    Notes
    -----
    A model may be empty, and may contain an object twice: see `duplicates`. Spheres are outward; one that is
    given inside out is the same sphere.

    Of two models that are registered, one without weights or covariances is exact beside one that has some. Models
    without either are equally uncertain.
    """

    @property
    def points(self) -> Multivector | None:
        """Points (n,), or None."""
        return self._objects.get("point")

    @property
    def point_pairs(self) -> Multivector | None:
        """Unit point pairs (n,), or None."""
        return self._objects.get("point_pair")

    @property
    def lines(self) -> Multivector | None:
        """Unit lines (n,), or None."""
        return self._objects.get("line")

    @property
    def segments(self) -> Rows | None:
        """End points (n, 2, 3), or None; ``objects["segment"]`` are the lines from the first to the second."""
        rows = self._rows.get("segment")
        return None if rows is None else rows.reshape(-1, 2, 3)

    @property
    def circles(self) -> Multivector | None:
        """Unit circles (n,), or None."""
        return self._objects.get("circle")

    @property
    def planes(self) -> Multivector | None:
        """Unit planes (n,), or None."""
        return self._objects.get("plane")

    @property
    def spheres(self) -> Multivector | None:
        """Outward unit spheres (n,), or None."""
        return self._objects.get("sphere")

    name: str
    unit: str
    origin: str
    _rows: dict[str, Rows]
    _uncertainty: Uncertainty

    def __init__(
        self, points: Any = None, point_pairs: Any = None, lines: Any = None, circles: Any = None, planes: Any = None,
        spheres: Any = None, *, segments: Any = None, weights: Any = None, covariances: Any = None, name: str = "",
        unit: str = "", origin: str = "",
    ) -> None:  # fmt: skip
        given = (points, point_pairs, lines, segments, circles, planes, spheres)
        rows = {kind: validated_rows(x, kind) for kind, x in zip(KINDS, given, strict=True) if x is not None}
        texts = {key: _text(value, key) for key, value in (("name", name), ("unit", unit), ("origin", origin))}
        self._fill(rows, texts, Uncertainty())
        _ = self._objects  # raises for objects without coefficients
        self.__dict__["_uncertainty"] = validated_uncertainty(weights, covariances, self.counts)

    def _fill(self, rows: Mapping[str, Rows], texts: Mapping[str, str], uncertainty: Uncertainty) -> None:
        self.__dict__["_rows"] = {kind: rows[kind] for kind in KINDS if kind in rows and len(rows[kind])}
        self.__dict__.update(texts, _uncertainty=uncertainty)

    @classmethod
    def _of(cls, rows: Mapping[str, Rows], texts: Mapping[str, str], uncertainty: Uncertainty) -> Model:
        """Model of validated rows."""
        new = cls.__new__(cls)
        for part in rows.values():
            part.setflags(write=False)
        new._fill(rows, texts, uncertainty)
        return new

    # -- what it holds -------------------------------------------------------------------------------------

    @cached_property
    def _objects(self) -> dict[str, Multivector]:
        return {kind: build_objects(rows, kind) for kind, rows in self._rows.items()}

    @property
    def objects(self) -> dict[str, Multivector]:
        """Unit objects (n,) by kind: point, point_pair, line, segment (the line through its ends), circle, plane,
        sphere; kinds without one are left out.
        """
        return dict(self._objects)

    @property
    def parameters(self) -> dict[str, Rows]:
        """Parameters by kind, rows (n, k) in the order of the constructor's arguments; directions have length 1."""
        return dict(self._rows)

    @property
    def weights(self) -> dict[str, Rows] | None:
        """Weights (n,) by kind, or None."""
        return dict(self._uncertainty.weights) or None

    @property
    def covariances(self) -> dict[str, Rows] | None:
        """Covariances (n, k, k) by kind, of the rows of `parameters`, or None."""
        return dict(self._uncertainty.covariances) or None

    @property
    def counts(self) -> dict[str, int]:
        """Number of objects of each kind that the model contains."""
        return {kind: len(rows) for kind, rows in self._rows.items()}

    @property
    def slices(self) -> dict[str, slice]:
        """Indices of each kind's objects among all."""
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
        raise AttributeError(f"a model cannot be changed ({name}); make another one, or use .subset(..).")

    __delattr__ = __setattr__

    def __reduce__(self) -> tuple[Any, ...]:
        return Model._of, (self._rows, self._texts, self._uncertainty)

    @property
    def _texts(self) -> dict[str, str]:
        return {"name": self.name, "unit": self.unit, "origin": self.origin}

    # -- other models --------------------------------------------------------------------------------------

    def transformed(self, R: Multivector | ArrayLike) -> Model:
        """Move the model by a motor, or move and scale it by the rotor of a similarity: R x ~R for each object.

        Parameters
        ----------
        R : Multivector or array (4, 4)
            A motor of cga3d or pga3d (a pose), a matrix of a rigid motion; of cga3d also a dilator, or a product of it
            and motors.

        Raises
        ------
        InputError, ShapeError, AlgebraMismatchError, GradeError, KindError
            If R is not a single versor that keeps flats flat: a motor, a dilator, or a product of them.

        Notes
        -----
        Parameters are moved, not coefficients, which lose digits for rounds far from the origin.
        """
        scale, rotation, translation = similarity(R)
        rows = {k: transform_rows(r, k, scale, rotation, translation) for k, r in self._rows.items()}
        return self._with_rows(rows, self._uncertainty.transformed(scale, rotation, translation))

    def in_frame(self, center: Any, unit: float = 1.0) -> Model:
        """Express the model in a frame at a point with another unit of length: (x - center) / unit.

        Raises
        ------
        InputError
            If the center is not a position or the unit not positive.
        """
        place = validated_rows([center], "point")[0]
        size = positive_float(unit, "unit")
        rows = {k: rows_in_frame(r, k, place, size) for k, r in self._rows.items()}
        return self._with_rows(rows, self._uncertainty.transformed(1 / size, np.eye(3), -place / size))

    @renamed_keywords(chosen="selection")
    def subset(self, selection: Any) -> Model:
        """Select some of the objects.

        Parameters
        ----------
        selection : bool array (len(self),), int array, or mapping
            A mask or indices over all objects; or for some kinds ("lines" or "line") a mask, indices or a slice of
            theirs. Within a kind the order is that of the indices; kinds that are not in the mapping are left out.

        Raises
        ------
        InputError
            If there is no such object or kind.
        """
        if isinstance(selection, Mapping):
            parts = {(k := self._kind(key)): self._select(k, part) for key, part in selection.items()}
        else:
            numbers = _numbers(selection, len(self), "the model")
            parts = {k: numbers[(numbers >= s.start) & (numbers < s.stop)] - s.start for k, s in self.slices.items()}
        rows = {k: self._rows.get(k, np.empty((0, SIZES[k])))[part].copy() for k, part in parts.items()}
        return self._with_rows(rows, self._uncertainty.select(parts))

    def _select(self, kind: str, part: Any) -> Any:
        return part if isinstance(part, slice) else _numbers(part, self.counts.get(kind, 0), PLURALS[kind])

    @staticmethod
    def _kind(name: Any) -> str:
        found = {**{kind: kind for kind in KINDS}, **{plural: kind for kind, plural in PLURALS.items()}}.get(name)
        if found is None:
            raise InputError(f"{name!r} is not a kind of object; there are: {', '.join(PLURALS.values())}.")
        return found

    def _with_rows(self, rows: Mapping[str, Rows], uncertainty: Uncertainty) -> Model:
        new = Model._of(rows, self._texts, uncertainty)
        _ = new._objects
        return new

    # -- what is in it twice -------------------------------------------------------------------------------

    def duplicates(self, tolerance: float = TOLERANCE) -> Indices:
        """Index of the first equal object, for each object; its own index if it is the first one.

        x and -x are equal, and so are lines given by other points of theirs. Objects are duplicates where
        ``m.duplicates() != np.arange(len(m))``; `subset` of the unique indices is a model without them.

        Parameters
        ----------
        tolerance : float
            Largest difference of directions, and of positions and radii relative to the model's size. At least the
            rounding of its coordinates.
        """
        found = np.arange(len(self))
        repeats = first_occurrences(self._rows, as_float(tolerance, "tolerance", 0, np.inf))
        for kind, place in self.slices.items():
            found[place] = place.start + repeats[kind]
        return found

    # -- files ---------------------------------------------------------------------------------------------

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a JSON file, whole or not at all (:doc:`/registration/models`); `load` gives the same model again.

        Raises
        ------
        InputError
            If the file cannot be written.
        """
        from ..io.model_file import save_model

        save_model(path, self._rows, self._texts, self._uncertainty)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Model:
        """Read a JSON file (:doc:`/registration/models`).

        Raises
        ------
        InputError
            If the file cannot be read or is not a model: as ``m.json, line 9: lines[3].direction is ...``.
        """
        from ..io.model_file import load_model

        return load_model(path, cls)


def _text(value: Any, name: str) -> str:
    try:
        as_text(value, name).encode()
    except UnicodeEncodeError:
        raise InputError(f"{name} is {value!r}, which cannot be encoded in a file.") from None
    return str(value)


def _numbers(selection: Any, count: int, what: str) -> Indices:
    """Convert a mask or indices to indices of existing objects."""
    array = np.asarray(selection)
    if array.dtype == bool and array.shape == (count,):
        return np.flatnonzero(array)
    if array.ndim != 1 or (array.size and array.dtype.kind not in "iu"):
        what = f"{what}: the selection has shape {array.shape} and holds {array.dtype}"
        raise InputError(f"{what}; a mask of {count}, or indices, are needed.")
    indices = array.astype(np.int64)
    bad = (indices < -count) | (indices >= count)
    if bad.any():
        raise InputError(f"{what}: there is no object {int(indices[bad.argmax()])} among {count}.")
    return np.where(indices < 0, indices + count, indices)

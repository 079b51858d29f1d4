"""Models of point clouds: planes, spheres, lines and circles fitted to the points, one object after the other.

RANSAC is that of scikit-image (extra `clouds`), on patches of neighboring points; the fits are `bladesmith.objects`.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any, Literal, overload

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError, Interrupted, MissingExtraError
from ...codegen.interrupts import keep_partial
from ...common.deprecation import renamed_keywords
from ...common.progress import ProgressOption, Report, open_progress
from ...common.validation import as_bool, as_choice, as_int, as_tuple, positive_float
from ..model.model import Model
from ..model.parameters import PLURALS, SIZES, validated_rows
from .ransac_primitives import SHAPES, Shape

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
#: Default of the smallest fraction of the cloud of an object.
MIN_FRACTION = 0.01
#: Default of the smallest number of points of an object.
MIN_POINTS = 20
#: Number of patches that are tried for an object.
PATCHES = 6
#: Numbers of points of patches, in turn.
PATCH_SIZES = (48, 192, 768)
#: Number of RANSAC trials in each patch.
TRIALS = 48
#: Rounds without an object that end the search.
PATIENCE = 3
#: Largest number of fits to the points near an object, which depend on the last fit.
MAX_REFITS = 3
#: Size of cells, in tolerances, to which points are thinned before their local dimension is estimated.
CELL_SIZE = 4.0
#: Number of neighbors for this estimate.
N_NEIGHBORS = 8
#: Largest ratio of the second extent of the neighbors to the first one along a curve.
MAX_CURVE_RATIO = 0.25
#: Smallest size of a cell, in sizes of the cloud: rounding.
ROUNDING = 1e-12


@dataclass(frozen=True)
class CloudFit:
    """Result of `model_from_points`.

    Attributes
    ----------
    model : Model
    labels : array (n,)
        Index of each point's object, over all kinds; -1 for none.
    rms : array (len(model),)
        Root mean squared distance of each object's points.
    complete : bool
        False after an interrupt.
    """

    model: Model
    labels: Indices
    rms: Array
    complete: bool = field(default=True)


class CloudInterrupted(Interrupted):
    """An interrupt of `model_from_points`; ``partial`` is the `CloudFit` of the objects so far."""

    partial: CloudFit


@overload
def model_from_points(
    cloud: Any, tolerance: float, kinds: Sequence[str] = ..., seed: int = ..., min_points: int | None = ...,
    max_objects: int | None = ...,
    details: Literal[False] = ..., progress: ProgressOption = ..., *, unit: str = ..., origin: str = ...,
) -> Model: ...  # fmt: skip
@overload
def model_from_points(
    cloud: Any, tolerance: float, kinds: Sequence[str] = ..., seed: int = ..., min_points: int | None = ...,
    max_objects: int | None = ..., *,
    details: Literal[True], progress: ProgressOption = ..., unit: str = ..., origin: str = ...,
) -> CloudFit: ...  # fmt: skip
@renamed_keywords(least="min_points", most="max_objects")
def model_from_points(
    cloud: Any,
    tolerance: float,
    kinds: Sequence[str] = ("plane", "sphere", "line", "circle"),
    seed: int = 0,
    min_points: int | None = None,
    max_objects: int | None = None,
    details: bool = False,
    progress: ProgressOption = False,
    *,
    unit: str = "",
    origin: str = "",
) -> Model | CloudFit:
    """Fit planes, spheres, lines and circles to a point cloud.

    Parameters
    ----------
    cloud : array (n, 3), or Multivector (n,)
        Positions, or points of CGA.
    tolerance : float
        Largest distance of an object's points, in the cloud's unit: about three standard deviations of the noise.
    kinds : sequence of str
        Kinds of objects: some of "plane", "sphere", "line", "circle".
    seed : int
        Seed of the random choices; the result depends on the arguments only.
    min_points, max_objects : int, optional
        Smallest number of points of an object (default: the larger of 20 and 1 % of the cloud), and largest number of
        objects (default: no limit).
    details : bool
        Return a `CloudFit` with the points of each object.
    progress : bool or callable
        True: a bar on standard error. A callable gets a `bladesmith.Progress` of points used.
    unit, origin : str
        Unit and origin of the model.

    Returns
    -------
    Model or CloudFit
        Objects of each kind in the order of their detection, about largest first. The model may be empty.

    Raises
    ------
    MissingExtraError
        If `scikit-image` is not installed.
    InputError
        If a point is not finite, or an option is out of its range.
    CloudInterrupted
        On an interrupt; an `errors.Interrupted` whose ``partial`` contains the objects so far.

    Notes
    -----
    Planes and spheres are fitted to points whose neighbors spread in two dimensions, then lines and circles to points
    whose neighbors are on a curve: otherwise every circle would be a plane. Each round samples patches of neighbors at
    several scales, counts the points of the whole cloud near each patch's object, fits it to them again, and selects
    the object with the most points; a sphere or circle needs 1.2 times as many as a plane or line. Its points are
    removed.
    """
    xyz, with_details = validated_rows(cloud, "point"), as_bool(details, "details")
    shapes = _kinds(kinds)
    limit = positive_float(tolerance, "tolerance")
    default = max(MIN_POINTS, int(MIN_FRACTION * len(xyz)))
    min_points = _int_option(min_points, "min_points", default, max(s.n_points for s in shapes) + 1)
    max_objects = _int_option(max_objects, "max_objects", len(xyz), 0)
    center = (xyz.min(0) + xyz.max(0)) / 2 if len(xyz) else np.zeros(3)
    size = float(np.abs(xyz - center).max(initial=0.0)) or 1.0
    random = np.random.default_rng(_int_option(seed, "seed", 0, 0))
    search = _Search((xyz - center) / size, limit / size, min_points, max_objects, random)

    def result(complete: bool) -> CloudFit:
        return search.result(center, size, {"unit": unit, "origin": origin}, complete)

    with (
        open_progress(progress, "objects", "points", len(xyz)) as report,
        keep_partial(lambda: result(False), CloudInterrupted),
    ):
        for surfaces in (True, False):
            search.run([s for s in shapes if s.is_surface == surfaces], surfaces, report)
    fit = result(True)
    return fit if with_details else fit.model


class _Search:
    """Search for objects in a cloud of size one, and the objects so far."""

    def __init__(
        self, xyz: Array, tolerance: float, min_points: int, max_objects: int, rng: np.random.Generator
    ) -> None:
        try:
            self.ransac = import_module("skimage.measure").ransac
        except ImportError:
            raise MissingExtraError("clouds", "Fitting objects to points") from None
        self.tree_of = import_module("scipy.spatial").cKDTree
        self.xyz, self.tolerance, self.random = xyz, tolerance, rng
        self.min_points, self.max_objects = min_points, max_objects
        self.labels = np.full(len(xyz), -1)
        self.fits: list[tuple[Shape, float]] = []
        self.is_surface = self._surfaces()

    def run(self, shapes: Sequence[type[Shape]], surfaces: bool, report: Report) -> None:
        """Fit shapes to the points of their local dimension, until there are no more."""
        misses = 0
        while shapes and misses < PATIENCE and len(self.fits) < self.max_objects:
            rest = np.flatnonzero((self.labels < 0) & (self.is_surface == surfaces))
            if len(rest) < self.min_points:
                break
            best, inside = self._best(shapes, rest)
            if best is None:
                misses += 1
                continue
            misses = 0
            distance = best.residuals(self.xyz[rest[inside]])
            self.labels[rest[inside]] = len(self.fits)
            self.fits.append((best, float(np.sqrt(np.mean(distance**2)))))
            report(int(np.count_nonzero(self.labels >= 0)))

    def _best(self, shapes: Sequence[type[Shape]], rest: Indices) -> tuple[Shape | None, NDArray[np.bool_]]:
        """Shape with the most points of all patches, and the mask of these points."""
        xyz = self.xyz[rest]
        tree = self.tree_of(xyz)
        best, inside, highest = None, np.zeros(len(rest), bool), float(self.min_points) - 0.5
        for patch in range(PATCHES):
            size = min(len(rest), PATCH_SIZES[patch % len(PATCH_SIZES)])
            _, near = tree.query(xyz[self.random.integers(len(rest))], k=size)
            for kind in shapes:
                shape = self._sample_shape(kind, xyz[np.atleast_1d(near)])
                if shape is None:
                    continue
                shape, mine = self._refit(shape, xyz)
                count = np.count_nonzero(mine) / (kind.point_factor if len(shapes) > 1 else 1.0)
                if shape is not None and count > highest:
                    best, inside, highest = shape, mine, count
        return best, inside

    def _sample_shape(self, kind: type[Shape], patch: Array) -> Shape | None:
        """RANSAC shape of a patch."""
        if len(patch) <= kind.n_points:
            return None
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # None means that no shape fits
            shape, _ = self.ransac(patch, kind, kind.n_points, self.tolerance, max_trials=TRIALS, rng=self.random)
        return shape if isinstance(shape, kind) else None

    def _refit(self, shape: Shape, xyz: Array) -> tuple[Shape | None, NDArray[np.bool_]]:
        """Shape fitted to all points near it, and the mask of these points."""
        inside = shape.residuals(xyz) <= self.tolerance
        for _ in range(MAX_REFITS):
            if np.count_nonzero(inside) <= shape.n_points:
                return None, inside
            again = type(shape).from_estimate(xyz[inside])
            if again is None:
                return None, inside
            near = again.residuals(xyz) <= self.tolerance
            shape, changed, inside = again, bool((near != inside).any()), near
            if not changed:
                break
        return shape, inside

    def _surfaces(self) -> NDArray[np.bool_]:
        """Mask of the points around which the others spread in two dimensions, not along a curve."""
        if not len(self.xyz):
            return np.zeros(0, bool)
        cells = np.floor(self.xyz / (CELL_SIZE * max(self.tolerance, ROUNDING)))
        _, cell = np.unique(cells, axis=0, return_inverse=True)
        cell = cell.ravel()
        count = np.bincount(cell)
        centers = np.stack([np.bincount(cell, self.xyz[:, i]) for i in range(3)], 1) / count[:, None]
        k = min(N_NEIGHBORS + 1, len(centers))
        _, near = self.tree_of(centers).query(centers, k=k)
        around = centers[near.reshape(len(centers), k)]
        spread = np.linalg.svd(around - around.mean(1, keepdims=True), compute_uv=False)
        second = spread[:, 1] if spread.shape[1] > 1 else np.zeros(len(spread))
        return np.asarray((second > MAX_CURVE_RATIO * spread[:, 0])[cell])

    def result(self, center: Array, size: float, texts: dict[str, str], complete: bool) -> CloudFit:
        """Objects in the coordinates of the cloud, with the indices of the model."""
        rows: dict[str, Any] = {}
        order = []
        for kind in sorted(SHAPES, key=list(PLURALS).index):
            mine = [i for i, (shape, _) in enumerate(self.fits) if shape.kind == kind]
            part = np.array([self.fits[i][0].row for i in mine]).reshape(-1, SIZES[kind])
            rows[PLURALS[kind]] = part.reshape(-1, 2, 3) if kind == "line" else part
            order += mine
        number_of = np.full(len(order) + 1, -1)  # the last entry is for points of no object
        number_of[order] = np.arange(len(order))
        model = Model(**rows, **texts).in_frame(-center / size, 1 / size)
        return CloudFit(model, number_of[self.labels], np.array([self.fits[i][1] for i in order]) * size, complete)


def _kinds(kinds: Any) -> list[type[Shape]]:
    names = as_tuple(kinds, "kinds", str)
    for name in names:
        as_choice(name, "an entry of kinds", SHAPES)
    if not names:
        raise InputError("kinds is empty.", remedy=f"Name some of {', '.join(SHAPES)}")
    return [SHAPES[name] for name in SHAPES if name in names]


def _int_option(value: Any, name: str, default: int, low: int) -> int:
    return max(default, low) if value is None else as_int(value, name, low)

"""Models of point clouds: planes, spheres, lines and circles fitted to the points, one object after the other.

The RANSAC is scikit-image's (the extra `clouds`), on patches of neighbouring points; the fits are `bladesmith.objects`.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import truth
from ..codegen.errors import InputError, MissingExtraError
from ..objects.inputs import number
from .model import Model
from .parameters import PLURALS, SIZES, checked
from .shapes import SHAPES, Shape

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Progress = bool | Callable[[int, int], None]
#: Objects hold this share of the cloud at least, and this many points, where the caller says nothing.
LEAST_SHARE, LEAST_POINTS = 0.01, 20
#: Patches tried for an object, numbers of their points, samples in each, and rounds without an object before the end.
PATCHES, PATCH_SIZES, TRIALS, PATIENCE = 6, (48, 192, 768), 48, 3
#: Fits to the points near an object, which change which points are near.
REFITS = 3
#: Points are thinned to cells of so many tolerances before looking how many dimensions they fill around each; with so
#: many neighbours, among which the second extent of a curve is at most this share of the first.
CELL, NEIGHBOURS, THIN = 4.0, 8, 0.25
#: Smaller cells than this, in sizes of the cloud, would be cells of rounding.
ROUNDING = 1e-12


@dataclass(frozen=True)
class CloudFit:
    """What `model_from_points` found.

    Attributes
    ----------
    model : Model
    labels : array (n,)
        For each point the number of its object, over all kinds; -1 for none.
    rms : array (len(model),)
        Root of the mean squared distance of each object's points.
    complete : bool
        False after an interrupt.
    """

    model: Model
    labels: Indices
    rms: Array
    complete: bool = field(default=True)


class CloudInterrupted(KeyboardInterrupt):
    """An interrupt; what was found until then is in ``partial``, a `CloudFit`."""

    def __init__(self, partial: CloudFit) -> None:
        super().__init__(f"interrupted with {len(partial.model)} objects found")
        self.partial = partial


def model_from_points(
    cloud: Any,
    tolerance: float,
    kinds: Sequence[str] = ("plane", "sphere", "line", "circle"),
    seed: int = 0,
    least: int | None = None,
    most: int | None = None,
    details: bool = False,
    progress: Progress = False,
    *,
    unit: str = "",
    origin: str = "",
) -> Any:
    """Planes, spheres, lines and circles among points.

    Parameters
    ----------
    cloud : array (n, 3), or Multivector (n,)
        Positions, or points of CGA.
    tolerance : float
        Points this near to an object belong to it, in the cloud's unit: about three standard deviations of the noise.
    kinds : sequence of str
        What is looked for: of "plane", "sphere", "line", "circle".
    seed : int
        The result depends on the arguments only.
    least, most : int, optional
        Points of an object at least (default: 20 and 1 % of the cloud), and objects at most (default: no limit).
    details : bool
        Return a `CloudFit` with the points of each object.
    progress : bool or callable
        True: a bar on standard error. A callable gets (points used, points in all).
    unit, origin : str
        Of the model.

    Returns
    -------
    Model or CloudFit
        Possibly empty. Of each kind the objects are in the order in which they were found, about largest first.

    Raises
    ------
    MissingExtraError
        If `scikit-image` is not installed.
    InputError
        If a point is not finite, or an option is out of its range.
    CloudInterrupted
        On an interrupt; a KeyboardInterrupt whose ``partial`` holds what was found.

    Notes
    -----
    Planes and spheres are looked for among points whose neighbours spread in two dimensions, then lines and circles
    among those whose neighbours are in a row: else every circle would be a plane. Each round samples patches of
    neighbours at several scales, counts the points of the whole cloud near each patch's object, fits it to them again,
    and takes the object with the most; a sphere or circle needs 1.2 times as many as a plane or line. Its points are
    removed.
    """
    xyz, whole = checked(cloud, "point"), truth(details, "details")
    wanted = _kinds(kinds)
    limit = number(tolerance, "tolerance")
    if not (limit > 0 and np.isfinite(limit)):
        raise InputError(f"tolerance is {limit:g}; a positive length is needed.")
    few = _count(least, "least", max(LEAST_POINTS, int(LEAST_SHARE * len(xyz))), max(s.needs for s in wanted) + 1)
    many = _count(most, "most", len(xyz), 0)
    center = (xyz.min(0) + xyz.max(0)) / 2 if len(xyz) else np.zeros(3)
    size = float(np.abs(xyz - center).max(initial=0.0)) or 1.0
    search = _Search((xyz - center) / size, limit / size, few, many, np.random.default_rng(_count(seed, "seed", 0, 0)))

    def result(complete: bool) -> CloudFit:
        return search.result(center, size, {"unit": unit, "origin": origin}, complete)

    with ExitStack() as stack:
        tell = _teller(progress, len(xyz), stack)
        try:
            for surfaces in (True, False):
                search.run([s for s in wanted if s.is_surface == surfaces], surfaces, tell)
        except KeyboardInterrupt:
            raise CloudInterrupted(result(False)) from None
    found = result(True)
    return found if whole else found.model


class _Search:
    """A cloud of size one, and the objects found in it so far."""

    def __init__(self, xyz: Array, tolerance: float, least: int, most: int, random: np.random.Generator) -> None:
        self.ransac = _module("skimage.measure").ransac
        self.tree_of = _module("scipy.spatial").cKDTree
        self.xyz, self.tolerance, self.least, self.most, self.random = xyz, tolerance, least, most, random
        self.labels = np.full(len(xyz), -1)
        self.found: list[tuple[Shape, float]] = []
        self.is_surface = self._surfaces()

    def run(self, shapes: Sequence[type[Shape]], surfaces: bool, tell: Callable[[int], None]) -> None:
        """Look for shapes among the points that fill as many dimensions, until there are no more."""
        misses = 0
        while shapes and misses < PATIENCE and len(self.found) < self.most:
            rest = np.flatnonzero((self.labels < 0) & (self.is_surface == surfaces))
            if len(rest) < self.least:
                break
            best, inside = self._best(shapes, rest)
            if best is None:
                misses += 1
                continue
            misses = 0
            distance = best.residuals(self.xyz[rest[inside]])
            self.labels[rest[inside]] = len(self.found)
            self.found.append((best, float(np.sqrt(np.mean(distance**2)))))
            tell(int(np.count_nonzero(inside)))

    def _best(self, shapes: Sequence[type[Shape]], rest: Indices) -> tuple[Shape | None, NDArray[np.bool_]]:
        """The shape with the most points of all patches, and which points these are."""
        xyz = self.xyz[rest]
        tree = self.tree_of(xyz)
        best, inside, most = None, np.zeros(len(rest), bool), float(self.least) - 0.5
        for patch in range(PATCHES):
            size = min(len(rest), PATCH_SIZES[patch % len(PATCH_SIZES)])
            _, near = tree.query(xyz[self.random.integers(len(rest))], k=size)
            for kind in shapes:
                shape = self._sampled(kind, xyz[np.atleast_1d(near)])
                if shape is None:
                    continue
                shape, mine = self._refitted(shape, xyz)
                count = np.count_nonzero(mine) / (kind.handicap if len(shapes) > 1 else 1.0)
                if shape is not None and count > most:
                    best, inside, most = shape, mine, count
        return best, inside

    def _sampled(self, kind: type[Shape], patch: Array) -> Shape | None:
        """The shape that most points of a patch agree on."""
        if len(patch) <= kind.needs:
            return None
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that there is none is told by None
            found, _ = self.ransac(patch, kind, kind.needs, self.tolerance, max_trials=TRIALS, rng=self.random)
        return found if isinstance(found, kind) else None

    def _refitted(self, shape: Shape, xyz: Array) -> tuple[Shape | None, NDArray[np.bool_]]:
        """A shape fitted to all points near it, and which these are."""
        inside = shape.residuals(xyz) <= self.tolerance
        for _ in range(REFITS):
            if np.count_nonzero(inside) <= shape.needs:
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
        """Points around which the others spread in two dimensions, not along a curve."""
        if not len(self.xyz):
            return np.zeros(0, bool)
        cells = np.floor(self.xyz / (CELL * max(self.tolerance, ROUNDING)))
        _, cell = np.unique(cells, axis=0, return_inverse=True)
        cell = cell.ravel()
        count = np.bincount(cell)
        middles = np.stack([np.bincount(cell, self.xyz[:, i]) for i in range(3)], 1) / count[:, None]
        k = min(NEIGHBOURS + 1, len(middles))
        _, near = self.tree_of(middles).query(middles, k=k)
        around = middles[near.reshape(len(middles), k)]
        spread = np.linalg.svd(around - around.mean(1, keepdims=True), compute_uv=False)
        second = spread[:, 1] if spread.shape[1] > 1 else np.zeros(len(spread))
        return np.asarray((second > THIN * spread[:, 0])[cell])

    def result(self, center: Array, size: float, texts: dict[str, str], complete: bool) -> CloudFit:
        """The objects in the cloud's own coordinates, numbered as models number them."""
        rows: dict[str, Any] = {}
        order = []
        for kind in sorted(SHAPES, key=list(PLURALS).index):
            mine = [i for i, (shape, _) in enumerate(self.found) if shape.kind == kind]
            part = np.array([self.found[i][0].row for i in mine]).reshape(-1, SIZES[kind])
            rows[PLURALS[kind]] = part.reshape(-1, 2, 3) if kind == "line" else part
            order += mine
        number_of = np.full(len(order) + 1, -1)  # the last for points of no object
        number_of[order] = np.arange(len(order))
        model = Model(**rows, **texts).in_frame(-center / size, 1 / size)
        return CloudFit(model, number_of[self.labels], np.array([self.found[i][1] for i in order]) * size, complete)


def _kinds(kinds: Any) -> list[type[Shape]]:
    names = (kinds,) if isinstance(kinds, str) else tuple(kinds)
    for name in names:
        if name not in SHAPES:
            raise InputError(f"kinds holds {name!r}; objects are fitted of the kinds {', '.join(SHAPES)}.")
    if not names:
        raise InputError("kinds is empty.", remedy=f"Name some of {', '.join(SHAPES)}")
    return [SHAPES[name] for name in SHAPES if name in names]


def _count(value: Any, name: str, default: int, low: int) -> int:
    if value is None:
        return max(default, low)
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < low:
        raise InputError(f"{name} is {value!r}; a whole number of at least {low} is needed.")
    return int(value)


def _teller(progress: Progress, total: int, stack: ExitStack) -> Callable[[int], None]:
    if callable(progress):
        used = [0]

        def tell(count: int) -> None:
            used[0] += count
            progress(used[0], total)

        return tell
    if not truth(progress, "progress"):
        return lambda count: None
    from tqdm import tqdm

    bar = stack.enter_context(tqdm(total=total, desc="objects", unit="point", unit_scale=True))
    return lambda count: bar.update(count) and None


def _module(name: str) -> Any:
    try:
        return import_module(name)
    except ImportError:
        raise MissingExtraError("clouds", "Fitting objects to points") from None


__all__ = ["CloudFit", "CloudInterrupted", "model_from_points"]

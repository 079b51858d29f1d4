"""Surfaces of scenes: their parameters, checked once, and the points of rays on one of them.

A kind is a class with a name that the scene compiler knows and a row of parameters; geometry is compiled.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..codegen.programs.scene import SURFACES, needs
from ..curves import Bezier, Curve
from ..errors import SceneError
from . import values
from .bounds import evolved_bound
from .engine import MATERIAL_SIZE, BoundScene, Engine, engine_for

Array = NDArray[Any]
#: Fewer samples along a curve show no change of sign on either side of the middle.
LEAST_SAMPLES = 3
_log = logging.getLogger("bladesmith")


@dataclass(frozen=True, eq=False)
class Material:
    """How a surface looks: the Blinn-Phong model with a mirror.

    Attributes
    ----------
    color : (3,) array
        Linear red, green, blue.
    ambient, diffuse, specular : float
        Shares of the color that is always seen, of Lambert's law, and of the highlight (which is white).
    shininess : float
        Exponent of the highlight.
    reflectivity : float
        Share of what is seen that comes from the mirror image, 0 to 1.
    checker : (3,) array or None
        Second color of a pattern of squares, on planes and discs.
    checker_size : float
        Side of a square.
    """

    color: Any = (0.8, 0.8, 0.8)
    ambient: float = 0.1
    diffuse: float = 0.8
    specular: float = 0.3
    shininess: float = 32.0
    reflectivity: float = 0.0
    checker: Any = None
    checker_size: float = 1.0

    def __post_init__(self) -> None:
        for name in ("color", "checker"):
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, values.color(value, f"material.{name}"))
        for name in ("ambient", "diffuse", "specular"):
            object.__setattr__(self, name, values.between(getattr(self, name), f"material.{name}", 0.0, np.inf))
        object.__setattr__(self, "shininess", values.positive(self.shininess, "material.shininess"))
        object.__setattr__(self, "checker_size", values.positive(self.checker_size, "material.checker_size"))
        mirror = values.between(self.reflectivity, "material.reflectivity", 0.0, 1.0)
        object.__setattr__(self, "reflectivity", mirror)

    def row(self, normal: Array | None) -> Array:
        """What the driver reads; squares lie in the plane of the normal."""
        row = np.zeros(MATERIAL_SIZE)
        row[:3] = row[8:11] = self.color
        row[3:8] = self.ambient, self.diffuse, self.specular, self.shininess, self.reflectivity
        if self.checker is not None:
            if normal is None:
                raise SceneError("material.checker is for planes and discs.")
            row[8:11] = self.checker
            row[11:17] = np.concatenate(_across(normal)) / self.checker_size
        return row


def _across(normal: Array) -> tuple[Array, Array]:
    """Two unit vectors across a normal; e1 and e2 for the normal e3."""
    first = np.eye(3)[1 if abs(normal[1]) < 0.9 else 2]
    u = np.cross(first, normal)
    u = u / np.linalg.norm(u)
    return u, np.cross(normal, u)


@dataclass(frozen=True, eq=False)
class Intersections:
    """All points of lines on a surface, each line's in the order of t; NaN fills up to the most there are.

    Attributes
    ----------
    alpha : (..., roots) array
        Parameter t of the surface's curve, 0 at its first object; NaN for surfaces without one.
    count : (...) array of int
    t : (..., roots) array
        Distance along the ray; negative behind its origin.
    point, normal : (..., roots, 3) arrays
        The normal has length 1 and looks to where the ray comes from.
    status : (...) array of `bladesmith.Status`
    """

    alpha: Array
    count: Array
    t: Array
    point: Array
    normal: Array
    status: Array


class Surface:
    """Base of all surfaces."""

    kind: ClassVar[str]
    material: Material

    def __init__(self, material: Material | Mapping[str, Any] | None) -> None:
        self.material = _material(material)
        if self.material.checker is not None and self.flat_normal is None:
            raise SceneError("material.checker is for planes and discs.")

    @property
    def parameters(self) -> Array:
        """The row of numbers that the program's `prepare` takes."""
        raise NotImplementedError

    @property
    def flat_normal(self) -> Array | None:
        """The normal of a flat surface."""
        return None

    def __getstate__(self) -> dict[str, Any]:
        """Without what is bound to compiled code, so that surfaces can be pickled and copied."""
        return {name: value for name, value in self.__dict__.items() if name != "_scenes"}

    def constants(self, engine: Engine) -> Array:
        """The row that the driver reads; the same from every program, so made once."""
        kept = self.__dict__.get("_constants")
        if kept is None:
            kept = self.__dict__["_constants"] = self._prepared(engine)
        row: Array = kept
        return row

    def _prepared(self, engine: Engine) -> Array:
        return engine.prepare(self.kind, self.parameters)

    def _bound(self, method: str, samples: int, single: bool) -> BoundScene:
        """A scene of this surface alone, compiled for nothing else; kept for the next call."""
        key = (method, samples, single)
        kept: dict[Any, BoundScene] = self.__dict__.setdefault("_scenes", {})
        if key not in kept:
            engine = engine_for(needs([self.kind], [method], pictures=False, single=single))
            dtype = np.float32 if single else np.float64
            rows = {self.kind: [(0, self.constants(engine))]}
            kept[key] = engine.scene(rows, dtype, method=method, samples=samples)
        return kept[key]

    def intersect(
        self, origins: Any, directions: Any, method: str = "isolate", samples: int = 64, threads: int | None = None
    ) -> Intersections:
        """All points of rays' lines on this surface.

        Parameters
        ----------
        origins, directions : (..., 3) arrays
            They broadcast. Directions may have any length. If both are float32, so is the computation.
        method : {"isolate", "companion", "sampled"}
            How roots on evolved surfaces are found: certain isolation on the polynomial of degree 8; the
            printed companion matrix of degree 12; sign changes between samples.
        samples : int
            For "sampled": values along the curve, at least 3.
        threads : int, optional

        Returns
        -------
        Intersections
        """
        samples = values.whole(samples, "samples", LEAST_SAMPLES)
        start, direction = ray_arrays(origins, directions)
        single = start.dtype == np.float32
        found = self._bound(method, samples, single).all(start, direction, SURFACES[self.kind].roots, threads)
        return Intersections(**found)


def ray_arrays(origins: Any, directions: Any) -> tuple[Array, Array]:
    """Origins and directions of one floating type, shapes checked."""
    arrays = []
    for name, value in (("origins", origins), ("directions", directions)):
        found = values.reals(value)
        if found is None:
            raise SceneError(f"{name} are no real numbers.")
        array = found if found.dtype in (np.float32, np.float64) else found.astype(np.float64)
        if array.ndim == 0 or array.shape[-1] != 3:
            raise SceneError(f"{name} have shape {array.shape}; the last axis holds 3 coordinates.")
        arrays.append(array)
    try:
        np.broadcast_shapes(arrays[0].shape, arrays[1].shape)
    except ValueError:
        raise SceneError(f"origins {arrays[0].shape} and directions {arrays[1].shape} do not broadcast.") from None
    if arrays[0].dtype != arrays[1].dtype:
        arrays = [a.astype(np.float64) for a in arrays]
    return arrays[0], arrays[1]


def _material(value: Material | Mapping[str, Any] | None) -> Material:
    if value is None or isinstance(value, Material):
        return value or Material()
    try:
        return Material(**value)
    except TypeError as error:
        raise SceneError(f"material: {error}.") from None


class Plane(Surface):
    """The plane normal . x = offset, or a plane of the algebra."""

    kind = "plane"

    def __init__(self, normal: Any, offset: float | None = None, *, material: Any = None) -> None:
        given = values.coefficients(normal, "plane") if offset is None else None
        if given is not None:
            self.normal, self.offset = values.read_plane(given)
        else:
            raw = values.finite(normal, "plane.normal", 3)
            self.normal = values.unit(raw, "plane.normal")
            length = float(raw @ self.normal)  # scaling the normal scales the offset
            self.offset = values.number(0.0 if offset is None else offset, "plane.offset") / length
        super().__init__(material)

    @property
    def parameters(self) -> Array:
        return np.array([*self.normal, self.offset])

    @property
    def flat_normal(self) -> Array:
        return self.normal


class Sphere(Surface):
    """A sphere by centre and radius, or a sphere of the algebra."""

    kind = "sphere"

    def __init__(self, center: Any, radius: float | None = None, *, material: Any = None) -> None:
        if radius is None:
            given = values.coefficients(center, "sphere")
            if given is None:
                raise SceneError("sphere has no radius.")
            self.center, self.radius = values.read_sphere(given)
        else:
            self.center = values.finite(center, "sphere.center", 3)
            self.radius = values.positive(radius, "sphere.radius")
        super().__init__(material)

    @property
    def parameters(self) -> Array:
        return np.array([*self.center, self.radius])


class Disc(Surface):
    """The flat inside of a circle, by centre, normal and radius, or of a circle of the algebra."""

    kind = "disc"

    def __init__(self, center: Any, normal: Any = None, radius: float | None = None, *, material: Any = None) -> None:
        value = center if normal is None and radius is None else (center, normal, radius)
        self.center, self.normal, self.radius = values.circle(value, "disc")
        super().__init__(material)

    @property
    def parameters(self) -> Array:
        return np.array([*self.center, *self.normal, self.radius])

    @property
    def flat_normal(self) -> Array:
        return self.normal


class EvolvedCircles(Surface):
    """The surface swept by a circle that evolves linearly between two (thesis 4.5).

    Parameters
    ----------
    curve : Bezier of first degree, or two circles
        Circles as (center, normal, radius), mappings of these, or coefficients, ``(2, 10)`` as one array.
    align : bool
        Turn the second circle over where the two oppose each other (<C1 C2>_0 < 0): between such circles the
        interpolant may become imaginary. The turn is logged, and `flipped` says so.
    material : Material, optional

    Attributes
    ----------
    flipped : bool
        The second circle was turned over.
    """

    kind = "evolved_circles"

    def __init__(self, curve: Any, *, align: bool = True, material: Any = None) -> None:
        controls = _linear_controls(curve)
        try:
            count = len(controls)
        except TypeError:
            raise SceneError("curve is no curve of circles.") from None
        if count != 2:
            raise SceneError(f"an evolved surface runs between 2 circles; this curve has {count}.")
        first, second = (values.circle(c, f"controls[{i}]") for i, c in enumerate(controls))
        self.flipped = align and _opposed(first, second)
        if self.flipped:
            second = second._replace(normal=-second.normal)
            _log.warning("evolved_circles: the circles oppose each other; the second was turned over (align)")
        self.circles = (first, second)
        super().__init__(material)

    @cached_property
    def frame(self) -> tuple[Array, float]:
        """Centre and unit of length of the surface's own frame: the mean of the circles, and their size."""
        first, second = self.circles
        center = (first.center + second.center) / 2
        apart = float(np.max(np.abs(first.center - second.center)))
        return center, max(first.radius, second.radius, apart)

    @property
    def parameters(self) -> Array:
        center, size = self.frame
        local = [((c.center - center) / size, c.normal, c.radius / size) for c in self.circles]
        return np.array([*center, size, 1 / size, *(x for c, n, r in local for x in (*c, *n, r))])

    def _prepared(self, engine: Engine) -> Array:
        row = engine.prepare(self.kind, self.parameters)
        kind = SURFACES[self.kind]
        bound, scalars, circles = (kind.slice(name) for name in ("bound", "scalars", "circles"))
        center, radius = evolved_bound(row[scalars], row[circles].reshape(4, 10))
        if np.isfinite(radius):
            row[bound] = [*center, radius]
        return row


def _linear_controls(curve: Any) -> Any:
    """Controls of a Bezier curve between unit objects, as they were given; what is no curve is taken for controls."""
    if isinstance(curve, Curve) and not (isinstance(curve, Bezier) and curve.kind.constraints):
        raise SceneError(f"an evolved surface follows a Bezier curve of unit circles, not a {type(curve).__name__}.")
    return curve.given if isinstance(curve, Bezier) else curve


def _opposed(first: values.Circle, second: values.Circle) -> bool:
    """Whether <C1 C2>_0 < 0, from the circles' own vectors.

    <C1 C2>_0 of dual circles S1* ^ P1*, S2* ^ P2* is (S1.P2)(P1.S2) - (S1.S2)(P1.P2) up to the sign of I5^2.
    """
    apart = second.center - first.center
    r1, r2 = first.radius, second.radius
    spheres = (r1 * r1 + r2 * r2 - apart @ apart) / (2 * r1 * r2)
    crossed = (second.normal @ apart / r1) * (first.normal @ apart / r2)
    return bool(spheres * (first.normal @ second.normal) + crossed < 0)

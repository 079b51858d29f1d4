"""What all surfaces share: rows of parameters, checked once, and all points of lines on one of them.

A kind is a class whose program kind the scene compiler knows; geometry is compiled.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from ...codegen.programs.scene import needs
from ...errors import SceneError
from .. import values
from ..driver import BoundScene
from ..engine import engine_for
from ..fixed import Fixed
from ..rows import gathered
from ..single import rounded_points, serves_kinds, serves_rays, serves_surfaces
from .material import Material, as_material

if TYPE_CHECKING:
    from ..meshing import TriangleMesh

Array = NDArray[Any]
#: Fewer samples along a curve show no change of sign on either side of the middle.
LEAST_SAMPLES = 3
#: More take minutes for each thousand rays.
MOST_SAMPLES = 1_000_000


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
    row : (..., roots) array of int
        The piece of the curve, or the facet, that each point lies on; -1 where there is none.
    status : (...) array of `bladesmith.Status`
    """

    alpha: Array
    count: Array
    t: Array
    point: Array
    normal: Array
    row: Array
    status: Array


class Surface(Fixed):
    """Base of all surfaces.

    Attributes
    ----------
    material : Material
    name : str or None
        What messages and pages call it; scene files give it with ``name``.
    """

    _instead = "Make a new one; surface.with_material(...) has another look"
    _free = ("name",)
    kind: ClassVar[str]
    material: Material
    name: str | None = None

    def __init__(self, material: Material | Mapping[str, Any] | None) -> None:
        if not hasattr(type(self), "kind"):
            raise SceneError("a Surface has no shape.", remedy="Make a Plane, a Sphere, or another of its kinds")
        self.material = self._fitting(material)
        self._made = True

    def _fitting(self, material: Material | Mapping[str, Any] | None) -> Material:
        """A material that this surface can have."""
        found = as_material(material)
        if found.checker is not None and self.flat_normal is None:
            raise SceneError("material.checker is for planes and discs.")
        return found

    def with_material(self, material: Material | Mapping[str, Any] | None) -> Self:
        """The same surface with another look; it shares the numbers of this one."""
        other = copy(self)
        other.__dict__["material"] = self._fitting(material)
        return other

    def called(self, place: int) -> str:
        """Its name; without one its kind and its place among a scene's surfaces: ``sphere [2]``."""
        return str(self.name) if self.name else f"{self.kind.replace('_', ' ')} [{place}]"

    @property
    def program_kind(self) -> str:
        """Name of the kind in programs: that of scene files, or a member of a family."""
        return self.kind

    @property
    def parameters(self) -> Array:
        """Rows of numbers (n, parameters) that the program's `prepare` takes; most surfaces are one row."""
        raise NotImplementedError

    @property
    def flat_normal(self) -> Array | None:
        """The normal of a flat surface."""
        return None

    def __getstate__(self) -> dict[str, Any]:
        """Without what is bound to compiled code, so that surfaces can be pickled and copied."""
        return {name: value for name, value in self.__dict__.items() if name != "_scenes"}

    def _bound(self, method: str, samples: int, single: bool) -> tuple[BoundScene, bool]:
        """A scene of this surface alone, compiled for nothing else, and whether single precision serves it."""
        key = (method, samples, single)
        kept: dict[Any, tuple[BoundScene, bool]] = self.__dict__.setdefault("_scenes", {})
        if key not in kept:
            count = len(self.parameters)
            engine = engine_for(needs([self.program_kind], [method], pictures=False, single=single, rows=count))
            dtype = np.float32 if single else np.float64
            rows = gathered(engine, [self])
            kept[key] = BoundScene(engine, rows, dtype, method=method, samples=samples), serves_surfaces(rows)
        return kept[key]

    def intersect(
        self, origins: Any, directions: Any, method: str = "isolate", samples: int = 64, threads: int | None = None
    ) -> Intersections:
        """All points of rays' lines on this surface.

        Parameters
        ----------
        origins, directions : (..., 3) arrays
            They broadcast. Directions may have any length. If both are float32, so is the answer; the computation is
            too where that keeps the digits of surface and origins: not for evolved surfaces, for others from sizes of
            1e-9 on and up to places of 1e12.
        method : {"isolate", "companion", "sampled"}
            How roots on evolved surfaces are found: certain isolation on the polynomial of both branches; the
            companion matrix of the printed one; sign changes between samples.
        samples : int
            For "sampled": values along the curve, at least 3, a million at most.
        threads : int, optional

        Returns
        -------
        Intersections
        """
        method = values.text(method, "method")
        samples = values.whole(samples, "samples", LEAST_SAMPLES, MOST_SAMPLES)
        start, direction = ray_arrays(origins, directions)
        single = start.dtype == np.float32
        if single and serves_kinds([self.program_kind]) and serves_rays(start):
            bound, served = self._bound(method, samples, single=True)
            if served:
                return Intersections(**bound.all(start, direction, threads))
        wide, _ = self._bound(method, samples, single=False)
        if not single:
            return Intersections(**wide.all(start, direction, threads))
        return Intersections(**rounded_points(wide.all(start.astype(np.float64), direction, threads)))

    def mesh(
        self,
        rings: int = 64,
        segments: int = 64,
        *,
        caps: bool = False,
        extent: float | None = None,
        center: Any = None,
    ) -> TriangleMesh:
        """The surface as a triangle mesh, with its own normals: see `tracer.meshing.mesh_of`."""
        from ..meshing import mesh_of

        return mesh_of(self, rings, segments, caps=caps, extent=extent, center=center)


def names_at(surfaces: Sequence[Surface], places: Any = None) -> NDArray[np.str_]:
    """Names of surfaces by their places in a list, empty for -1; see `Scene.names`."""
    found = np.arange(len(surfaces)) if places is None else np.asarray(places)
    if found.dtype.kind not in "iu" and found.size:
        raise SceneError(f"places are {values.shown(places)}; whole numbers are needed.")
    found = found.astype(np.intp)
    if found.size and not -1 <= found.min() <= found.max() < len(surfaces):
        raise SceneError(f"places are {values.shown(places)}; they run from -1, for none, to {len(surfaces) - 1}.")
    return np.array([*(surface.called(i) for i, surface in enumerate(surfaces)), ""])[found]


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

"""Base class of surfaces: rows of checked parameters, and all intersections of lines with one surface.

Each subclass names a kind of surface that the scene compiler knows; the geometry is compiled.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from ...codegen.programs.tracer.scene import needs
from ...common.validation import real_array, short_repr
from ...errors import SceneError
from ..rendering.driver import BoundScene
from ..rendering.precision import (
    points_to_single,
    single_suffices_for_kinds,
    single_suffices_for_rays,
    single_suffices_for_surfaces,
)
from ..rendering.program import engine_for
from ..rendering.surface_tables import build_surface_tables
from ..scene import values
from ..scene.immutable import Immutable
from .material import Material, as_material

if TYPE_CHECKING:
    from ..meshing import TriangleMesh

Array = NDArray[Any]
#: Smallest number of samples along a curve: fewer show no change of sign on either side of the middle.
LEAST_SAMPLES = 3
#: Largest number of samples: more take minutes for each thousand rays.
MOST_SAMPLES = 1_000_000


@dataclass(frozen=True, eq=False)
class Intersections:
    """All points of lines on a surface, for each line in the order of t; padded with NaN.

    Attributes
    ----------
    alpha : (..., roots) array
        Parameter t of the surface's curve, 0 at its first object; NaN for surfaces without one.
    count : (...) array of int
    t : (..., roots) array
        Distance along the ray; negative behind its origin.
    point, normal : (..., roots, 3) arrays
        The normal has length 1 and faces the ray's origin.
    row : (..., roots) array of int
        Index of the piece of the curve, or of the facet, that each point lies on; -1 for padding.
    status : (...) array of `bladesmith.Status`
    """

    alpha: Array
    count: Array
    t: Array
    point: Array
    normal: Array
    row: Array
    status: Array


class Surface(Immutable):
    """Base of all surfaces.

    Attributes
    ----------
    material : Material
    name : str or None
        Name in messages and pages; the key ``name`` of scene files.
    """

    _replacement_hint = "Make a new one; surface.with_material(...) gives a copy with another material"
    _mutable_fields = ("name",)
    kind: ClassVar[str]
    material: Material
    name: str | None = None

    def __init__(self, material: Material | Mapping[str, Any] | None) -> None:
        if not hasattr(type(self), "kind"):
            raise SceneError("a Surface has no shape.", remedy="Make a Plane, a Sphere, or another of its kinds")
        self.material = self._check_material(material)
        self._frozen = True

    def _check_material(self, material: Material | Mapping[str, Any] | None) -> Material:
        """Check that this surface can have the material."""
        checked = as_material(material)
        if checked.checker is not None and self.flat_normal is None:
            raise SceneError("material.checker is for planes and discs.")
        return checked

    def with_material(self, material: Material | Mapping[str, Any] | None) -> Self:
        """Copy of the surface with another material; it shares the arrays of this one."""
        other = copy(self)
        other.__dict__["material"] = self._check_material(material)
        return other

    def display_name(self, index: int) -> str:
        """Name of the surface; without one its kind and its index among a scene's surfaces: ``sphere [2]``."""
        return str(self.name) if self.name else f"{self.kind.replace('_', ' ')} [{index}]"

    @property
    def program_kind(self) -> str:
        """Name of the kind in programs: the kind of scene files, or a member of a family."""
        return self.kind

    @property
    def parameters(self) -> Array:
        """Rows of parameters (n, parameters) for the program's `prepare`; one row for most surfaces."""
        raise NotImplementedError

    @property
    def flat_normal(self) -> Array | None:
        """Normal of a flat surface, else None."""
        return None

    def __getstate__(self) -> dict[str, Any]:
        """State without objects bound to compiled code, so that surfaces can be pickled and copied."""
        return {name: value for name, value in self.__dict__.items() if name != "_scenes"}

    def _bind(self, method: str, samples: int, single: bool) -> tuple[BoundScene, bool]:
        """Bind this surface alone to a driver; also return whether single precision suffices for it."""
        key = (method, samples, single)
        bound_scenes: dict[Any, tuple[BoundScene, bool]] = self.__dict__.setdefault("_scenes", {})
        if key not in bound_scenes:
            count = len(self.parameters)
            engine = engine_for(needs([self.program_kind], [method], pictures=False, single=single, rows=count))
            dtype = np.float32 if single else np.float64
            rows = build_surface_tables(engine, [self])
            bound_scenes[key] = (
                BoundScene(engine, rows, dtype, method=method, samples=samples),
                single_suffices_for_surfaces(rows) and engine.is_c,
            )
        return bound_scenes[key]

    def intersect(
        self, origins: Any, directions: Any, method: str = "isolate", samples: int = 64, threads: int | None = None
    ) -> Intersections:
        """Intersect the lines of rays with this surface.

        Parameters
        ----------
        origins, directions : (..., 3) arrays
            They broadcast. Directions may have any length. If both are float32, so is the result; the computation is
            too where that keeps the digits of surface and origins: not for evolved surfaces; for others with sizes from
            1e-9 and coordinates up to 1e12.
        method : {"isolate", "companion", "sampled"}
            Method for roots on evolved surfaces: rigorous isolation on the polynomial of both branches; the
            companion matrix of the polynomial in the thesis; sign changes between samples.
        samples : int
            Number of samples along the curve for "sampled", from 3 to a million.
        threads : int, optional
            Default: the package's (`bladesmith.set_threads`).

        Returns
        -------
        Intersections
        """
        method = values.text(method, "method")
        samples = values.whole(samples, "samples", LEAST_SAMPLES, MOST_SAMPLES)
        start, direction = ray_arrays(origins, directions)
        single = start.dtype == np.float32
        if single and single_suffices_for_kinds([self.program_kind]) and single_suffices_for_rays(start):
            bound, suffices = self._bind(method, samples, single=True)
            if suffices:
                return Intersections(**bound.all(start, direction, threads))
        wide, _ = self._bind(method, samples, single=False)
        if not single:
            return Intersections(**wide.all(start, direction, threads))
        return Intersections(**points_to_single(wide.all(start.astype(np.float64), direction, threads)))

    def mesh(
        self,
        rings: int = 64,
        segments: int = 64,
        *,
        caps: bool = False,
        extent: float | None = None,
        center: Any = None,
    ) -> TriangleMesh:
        """Triangle mesh of the surface, with its own normals: see `tracer.meshing.mesh_of`."""
        from ..meshing import mesh_of

        return mesh_of(self, rings, segments, caps=caps, extent=extent, center=center)


def names_at(surfaces: Sequence[Surface], indices: Any = None) -> NDArray[np.str_]:
    """Names of surfaces by their indices in a list, empty for -1; see `Scene.names`."""
    rows = np.arange(len(surfaces)) if indices is None else np.asarray(indices)
    if rows.dtype.kind not in "iu" and rows.size:
        raise SceneError(f"indices are {short_repr(rows)}; whole numbers are needed.")
    rows = rows.astype(np.intp)
    if rows.size and not -1 <= rows.min() <= rows.max() < len(surfaces):
        raise SceneError(f"indices are {short_repr(rows)}; they run from -1, for none, to {len(surfaces) - 1}.")
    return np.array([*(surface.display_name(i) for i, surface in enumerate(surfaces)), ""])[rows]


def ray_arrays(origins: Any, directions: Any) -> tuple[Array, Array]:
    """Origins and directions of one floating type, shapes checked."""
    arrays = []
    for name, value in (("origins", origins), ("directions", directions)):
        arrays.append(real_array(value, name, (..., 3), SceneError))
    try:
        np.broadcast_shapes(arrays[0].shape, arrays[1].shape)
    except ValueError:
        raise SceneError(f"origins {arrays[0].shape} and directions {arrays[1].shape} do not broadcast.") from None
    if arrays[0].dtype != arrays[1].dtype:
        arrays = [a.astype(np.float64) for a in arrays]
    return arrays[0], arrays[1]

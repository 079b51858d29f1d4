"""Reflection of lines in surfaces, as objects of the algebra (thesis 4.7, 4.8)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..errors import SceneError
from .surfaces import Surface

if TYPE_CHECKING:
    from ..multivector import Multivector


def reflect(line: Multivector, hit: Multivector, surface: Surface) -> Multivector:
    """The reflection of a line at a point where it meets a surface: Phi L Phi for the tangent plane Phi.

    Parameters
    ----------
    line : line, shapes broadcasting with the points
    hit : point
        Where the line meets the surface; of several meeting points the nearest to it counts.
    surface : Surface

    Returns
    -------
    line
        Through the point, correctly oriented. NaN where the line does not meet the surface.
    """
    if not isinstance(surface, Surface):
        raise SceneError(f"surface is {type(surface).__name__}, which is no Surface.")
    for name, value in (("line", line), ("point", hit)):
        kind = getattr(getattr(value, "kind", None), "name", type(value).__name__)
        if kind != name:
            raise SceneError(f"a {name} is needed, not {kind}.")
    position, direction = hit.parameters().xyz, line.parameters().direction
    found = surface.intersect(position, direction)
    nearest = np.argmin(np.where(np.isnan(found.t), np.inf, np.abs(found.t)), axis=-1)
    normal = np.take_along_axis(found.normal, nearest[..., None, None], axis=-2)[..., 0, :]
    plane = line.algebra.plane(normal, np.einsum("...i,...i->...", normal, position))
    reflected: Multivector = plane >> line
    return reflected

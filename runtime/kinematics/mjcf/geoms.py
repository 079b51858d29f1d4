"""Inertias of MJCF: as bodies have them, or of their primitive geoms."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..robots.description import LinkInertia, homogeneous
from ..robots.frames import rotation_to
from ..robots.xml_text import Element
from .text import MjcfText

Array = NDArray[Any]
#: Types of geoms and the numbers of their size, at least.
SIZES = {"sphere": 1, "capsule": 2, "ellipsoid": 3, "cylinder": 2, "box": 3}
#: Types that two ends can place.
OF_ENDS = ("capsule", "cylinder", "ellipsoid", "box")
#: Geoms without mass.
MASSLESS = ("plane",)
#: Geoms whose inertia is that of a file.
UNKNOWN = ("mesh", "sdf", "hfield")
DENSITY = "1000"


def inertial_of(text: MjcfText, element: Element, frame: Array) -> LinkInertia:
    """The inertia of an <inertial>, in the frame of its body."""
    values = dict(element.attrib)
    if "mass" not in values or "pos" not in values:
        raise text.error(element, "there is no mass or no pos in")
    if ("diaginertia" in values) == ("fullinertia" in values):
        raise text.error(element, "one of diaginertia and fullinertia is needed in")
    mass = float(text.vector(element, values, "mass", "", 1)[0])
    if "diaginertia" in values:
        tensor = np.diag(text.vector(element, values, "diaginertia", "", 3))
    else:
        xx, yy, zz, xy, xz, yz = text.vector(element, values, "fullinertia", "", 6)
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return LinkInertia(mass, tensor, frame @ text.frame(element, values))


def frame_of_shape(text: MjcfText, element: Element, values: dict[str, str], kind: str) -> tuple[Array, float | None]:
    """Frame (4, 4) of a geom or a site; and its length, if two ends place it: z goes from the second to the first.

    Raises
    ------
    InputError
    """
    if "fromto" not in values:
        return text.frame(element, values), None
    ends = text.vector(element, values, "fromto", "", 6).reshape(2, 3)
    along = ends[0] - ends[1]
    length = float(np.linalg.norm(along))
    if kind not in OF_ENDS or not length > 0:
        raise text.error(
            element, f"fromto={values['fromto']!r} has no length, or is of a {kind}, in",
            f"Two ends that differ place one of: {', '.join(OF_ENDS)}",
        )  # fmt: skip
    return homogeneous(rotation_to(along), ends.mean(0)), length


def is_massless(text: MjcfText, element: Element, values: dict[str, str]) -> bool:
    """Whether a geom adds nothing to its body's inertia, whatever its shape."""
    name = "mass" if "mass" in values else "density"
    return float(text.vector(element, values, name, DENSITY, 1)[0]) == 0


def geom_inertia(text: MjcfText, element: Element, values: dict[str, str], frame: Array) -> LinkInertia | None:
    """The inertia of a primitive geom, in the frame of its body; None if it has none.

    Raises
    ------
    InputError
    """
    kind = text.choice(element, "type", values.get("type", "sphere"), (*SIZES, *MASSLESS, *UNKNOWN))
    if kind in MASSLESS or kind in UNKNOWN:
        return None
    at, length = frame_of_shape(text, element, values, kind)
    size = text.vector(element, values, "size", "", None)
    if length is not None:
        size = np.array([size[0], length / 2] if kind in ("capsule", "cylinder") else [size[0], size[0], length / 2])
    if len(size) < SIZES[kind] or not (size[: SIZES[kind]] > 0).all():
        raise text.error(
            element, f"size={values.get('size', '')!r}, where {SIZES[kind]} positive numbers are needed, in"
        )
    volume, moments = _volume_and_moments(kind, size)
    if "mass" in values:
        mass = float(text.vector(element, values, "mass", "", 1)[0])
    else:
        mass = float(text.vector(element, values, "density", DENSITY, 1)[0]) * volume
    return LinkInertia(mass, np.diag(mass * moments), frame @ at)


def _volume_and_moments(kind: str, size: Array) -> tuple[float, Array]:
    """Volume, and moments (3,) for a unit of mass, of a solid of a size."""
    if kind == "capsule":
        r, h = size[:2]
        ball, tube = 4 / 3 * np.pi * r**3, 2 * np.pi * r**2 * h
        share = ball / (ball + tube)
        across = share * (0.4 * r**2 + h**2 + 0.75 * r * h) + (1 - share) * (r**2 / 4 + h**2 / 3)
        return float(ball + tube), np.array([across, across, share * 0.4 * r**2 + (1 - share) * r**2 / 2])
    if kind == "cylinder":
        r, h = size[:2]
        across = r**2 / 4 + h**2 / 3
        return float(2 * np.pi * r**2 * h), np.array([across, across, r**2 / 2])
    axes = np.repeat(size[:1], 3) if kind == "sphere" else size[:3]
    squares = axes**2
    volume = 8 * axes.prod() if kind == "box" else 4 / 3 * np.pi * axes.prod()
    return float(volume), (squares.sum() - squares) / (3 if kind == "box" else 5)

"""Inertias of bodies of MJCF: their own or those of their geoms, within the bounds of the compiler."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..robots.description import LinkInertia
from ..robots.lumps import compose_inertias
from ..robots.xml_text import Element
from .geoms import UNKNOWN, geom_inertia, is_massless
from .text import MjcfText

Array = NDArray[Any]
#: A geom: its attributes with those of its class, and the frame that it is in.
Geom = tuple[Element, dict[str, str], Array]


class BodyInertias:
    """The inertias of a text's bodies.

    Attributes
    ----------
    of : dict of str to LinkInertia
        By the names of links.
    """

    def __init__(self, text: MjcfText) -> None:
        self.of: dict[str, LinkInertia] = {}
        self._text = text
        self._unknown: list[str] = []

    def read(self, body: Element, name: str, inertial: LinkInertia | None, geoms: list[Geom]) -> None:
        """Read the inertia of a body, by its own, if it has one, and its geoms.

        Raises
        ------
        InputError
        """
        text = self._text
        choice = text.settings.get("inertiafromgeom", "auto")
        if choice == "true" or (choice == "auto" and inertial is None):
            low, high = np.array(text.settings.get("inertiagrouprange", "0 5").split(), float)
            parts = []
            for element, values, frame in geoms:
                if not low <= float(text.vector(element, values, "group", "0", 1)[0]) <= high:
                    continue
                if is_massless(text, element, values):
                    continue
                if values.get("type", "sphere") in UNKNOWN or "mesh" in values or values.get("shellinertia") == "true":
                    self._unknown.append(repr(name))
                    return
                part = geom_inertia(text, element, values, frame)
                if part is not None:
                    parts.append(part)
            inertial = compose_inertias(parts) if parts else inertial
        if inertial is None and any(self._bounds()):
            inertial = LinkInertia(0.0, np.zeros((3, 3)), np.eye(4))
        if inertial is not None:
            if not np.isfinite(inertial.tensor).all():
                raise text.error(body, "the inertia overflows: masses or sizes are too large in")
            self.of[name] = self._bounded(inertial)

    def finish(self, stacklevel: int) -> None:
        """Scale masses to their total, and warn of bodies without inertia."""
        if self._unknown:
            shown = ", ".join(self._unknown[:5]) + (" ..." if len(self._unknown) > 5 else "")
            warnings.warn(
                f"{self._text.path}: the inertia of meshes, height fields and shells is not computed: {shown} are "
                "without; give them an <inertial>.",
                stacklevel=stacklevel + 1,
            )
        total = float(self._text.settings.get("settotalmass", "-1"))
        own = sum(inertia.mass for inertia in self.of.values())
        if total > 0 and own > 0:
            self.of = {
                name: LinkInertia(x.mass * total / own, x.tensor * (total / own), x.origin)
                for name, x in self.of.items()
            }

    def _bounds(self) -> tuple[float, float]:
        """Mass and moments at least."""
        mass, moment = (float(self._text.settings.get(name, "0")) for name in ("boundmass", "boundinertia"))
        return mass, moment

    def _bounded(self, inertia: LinkInertia) -> LinkInertia:
        """An inertia within the bounds of the compiler."""
        mass, least = self._bounds()
        moments, axes = np.linalg.eigh(inertia.tensor)
        bounded = np.maximum(moments, least)
        if self._text.settings.get("balanceinertia") == "true" and 2 * bounded.max() > bounded.sum():
            bounded = np.full(3, bounded.mean())
        tensor = inertia.tensor if np.array_equal(bounded, moments) else (axes * bounded) @ axes.T
        return LinkInertia(max(inertia.mass, mass), tensor, inertia.origin)

"""Tables of scene files for surfaces along curves: controls, and the further keys of each kind of curve."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from ...common.documents import Positive, Table, Vector3
from ...curves import Curve, Hermite, Interpolating, KochanekBartels, RationalBezier
from ...errors import SceneError
from ..surfaces import EvolvedCircles, EvolvedPointPairs, Surface
from ..sweeps.local_segments import Segments, bezier_segments
from .tables import SurfaceTable

#: Further keys of each kind of curve: the required ones, and the optional ones.
CURVE_KEYS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "bezier": ((), ()),
    "rational_bezier": (("weights",), ()),
    "hermite": (("tangents",), ()),
    "kochanek_bartels": ((), ("tension", "bias", "continuity", "closed")),
    "interpolating": ((), ("knots", "degree", "ends")),
}
#: Largest number of controls of a curve.
MOST_CONTROLS = 100_000
Numbers = Annotated[list[float], Field(max_length=MOST_CONTROLS)]
#: One number for all controls, or one for each.
PerControl = float | Numbers


class CircleTable(Table):
    """A circle, counter-clockwise about its normal."""

    center: Vector3
    normal: Vector3
    radius: Positive

    def parameters(self) -> tuple[Any, ...]:
        """Parameters in the form of `Curve` controls."""
        return self.center, self.normal, self.radius


class PointPairTable(Table):
    """A point pair, from a to b."""

    a: Vector3
    b: Vector3

    def parameters(self) -> tuple[Any, ...]:
        """Parameters in the form of `Curve` controls."""
        return self.a, self.b


class CurveTable(SurfaceTable):
    """A surface along a curve."""

    curve: Literal["bezier", "rational_bezier", "hermite", "kochanek_bartels", "interpolating"] = "bezier"
    align: bool = True  # unlike in Python: the side of a normal in a file is an accident more often than not
    gaps: bool = False
    weights: Annotated[list[Positive], Field(max_length=MOST_CONTROLS)] | None = None
    tension: PerControl = 0.0
    bias: PerControl = 0.0
    continuity: PerControl = 0.0
    closed: bool = False
    knots: Numbers | None = None
    degree: Annotated[int, Field(ge=1, le=3)] = 3
    ends: Literal["not-a-knot", "natural"] = "not-a-knot"

    def curve_or_controls(
        self, controls: Sequence[Any], tangents: Sequence[Any] | None
    ) -> Curve | list[tuple[Any, ...]]:
        """Make the curve; a Bezier curve stays a list of controls.

        Raises
        ------
        BladesmithError
            With a text that begins with the invalid key.
        """
        required, optional = CURVE_KEYS[self.curve]
        for curve, keys in CURVE_KEYS.items():
            for key in (*keys[0], *keys[1]):
                if key in self.model_fields_set and key not in (*required, *optional):
                    raise SceneError(f"{key} is a key of curve = {curve!r}; this curve is {self.curve!r}.")
        for key in required:
            if key not in self.model_fields_set:
                raise SceneError(f"{key} is missing; curve = {self.curve!r} needs it.")
        parameters = [control.parameters() for control in controls]
        if self.curve == "rational_bezier":
            return RationalBezier(parameters, self.weights)
        if self.curve == "kochanek_bartels":
            return KochanekBartels(parameters, self.tension, self.bias, self.continuity, self.closed)
        if self.curve == "interpolating":
            return Interpolating(parameters, self.knots, self.degree, ends=self.ends)
        if self.curve == "hermite":
            return _hermite(parameters, tangents or ())
        return parameters


def _hermite(controls: list[tuple[Any, ...]], tangents: Sequence[Any]) -> Hermite:
    for name, rows in (("controls", controls), ("tangents", tangents)):
        if len(rows) != 2:
            raise SceneError(f"{name} are {len(rows)}; a Hermite curve has 2.")
    v0, v1 = ({"from": t.start.parameters(), "to": t.end.parameters(), "scale": t.scale} for t in tangents)
    return Hermite(controls[0], v0, controls[1], v1)


class CircleDifference(Table):
    """A tangent: scale (to - from)."""

    start: Annotated[CircleTable, Field(alias="from")]
    end: Annotated[CircleTable, Field(alias="to")]
    scale: float = 1.0


class PointPairDifference(Table):
    """A tangent: scale (to - from)."""

    start: Annotated[PointPairTable, Field(alias="from")]
    end: Annotated[PointPairTable, Field(alias="to")]
    scale: float = 1.0


class EvolvedCirclesTable(CurveTable):
    """The surface swept by a circle."""

    kind: Literal["evolved_circles"]
    controls: Annotated[list[CircleTable], Field(min_length=2, max_length=MOST_CONTROLS)]
    tangents: list[CircleDifference] | None = None

    def surface(self, folder: Path, segments: Segments | None = None) -> Surface:
        curve = self.curve_or_controls(self.controls, self.tangents)
        return EvolvedCircles(segments or curve, align=self.align, gaps=self.gaps, material=self.material())


class EvolvedPointPairsTable(CurveTable):
    """The surface swept by the segment between two points."""

    kind: Literal["evolved_point_pairs"]
    controls: Annotated[list[PointPairTable], Field(min_length=2, max_length=MOST_CONTROLS)]
    tangents: list[PointPairDifference] | None = None

    def surface(self, folder: Path, segments: Segments | None = None) -> Surface:
        curve = self.curve_or_controls(self.controls, self.tangents)
        return EvolvedPointPairs(segments or curve, align=self.align, gaps=self.gaps, material=self.material())


def read_beziers(tables: Sequence[Any]) -> dict[int, Segments]:
    """Split the Bezier curves of a file, all of one kind and number of controls together; the result is by index.

    Groups with an invalid curve are omitted: the error is raised when their surfaces are made.
    """
    groups: dict[tuple[str, int], list[int]] = {}
    for i, table in enumerate(tables):
        if isinstance(table, EvolvedCirclesTable | EvolvedPointPairsTable) and table.curve == "bezier":
            swept = "circle" if isinstance(table, EvolvedCirclesTable) else "point_pair"
            groups.setdefault((swept, len(table.controls)), []).append(i)
    curves: dict[int, Segments] = {}
    for (swept, _), indices in groups.items():
        controls = [[control.parameters() for control in tables[i].controls] for i in indices]
        segments = bezier_segments(controls, swept, np.array([tables[i].align for i in indices]))
        curves.update(zip(indices, segments or (), strict=False))
    return curves

"""The figure of the interactive page: plotly's traces and layout, as dicts ready for JSON. Texts are escaped here."""

from __future__ import annotations

import base64
import html
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .view_parts import Box, Eye, Part, Shown, merged

Array = NDArray[Any]
#: Surfaces that get a line of the legend each; more are joined by kind.
MOST_TRACES = 48
#: A scene this many of its sizes from the origin is shown relative to its middle: the page's numbers have 24 bits.
FAR = 100.0
#: Part of the range that is left free around everything.
MARGIN = 0.04
#: plotly's light: some of it from everywhere, so that nothing is black.
LIGHTING = {"ambient": 0.36, "diffuse": 0.62, "roughness": 0.4, "fresnel": 0.05}
#: plotly drops normals of faces that are smaller than this: ours are small, and none is a point.
NORMAL_NOISE = 1e-15
#: Its lamp: how far away in units of the longest side, its least part in front, the shape of most screens, the depths
#: that plotly sees, and the least that numbers are good for.
LAMP_AWAY, FRONTAL, SCREEN, DEPTHS, NEAREST = 3.0, 1.0, 1.6, (0.01, 1000.0), 1e-3
RED, INK, GLASS = "rgb(200, 40, 30)", "rgb(34, 48, 60)", "rgba(34, 48, 60, 0.25)"
#: The overview: where the eye is, to the right, ahead and above as the scene's camera sees it.
OVERVIEW = (-1.6, -1.1, 0.9)
#: The sphere around everything is larger than what is in it; and no eye is so far away as through a telescope.
CLOSE, NARROWEST = 0.8, 0.2
#: Letters of a name that are shown.
MOST_LETTERS = 48


def figure(what: Shown, title: str, background: str) -> dict[str, Any]:
    """The whole figure, and under "views" what the page's buttons need."""
    origin = np.round(what.box.center) if np.linalg.norm(what.box.center) > FAR * what.box.radius else np.zeros(3)
    parts = what.parts if len(what.parts) <= MOST_TRACES else merged(what.parts)
    side = float((what.box.high - what.box.low).max()) * (1 + 2 * MARGIN) or 1.0
    views = _views(what, side)
    lamp = _lightposition(what, views, side)
    traces = [_mesh(part, origin, lamp) for part in parts]
    if what.controls:
        traces.append(_lines(what.controls, origin, "control objects", RED, 5))
    if what.frustum is not None:
        traces.append(_camera(what.eye, what.frustum, origin))
    if what.lights:
        traces.append(_lights(what, origin))
    return {"data": traces, "layout": _layout(what.box, origin, side, views, title, background), "views": views}


def _mesh(part: Part, origin: Array, lamp: dict[str, float]) -> dict[str, Any]:
    colors = part.vertex_colors
    single = colors is None
    lines = ["<b>%{meta}</b>", html.escape(part.kind)] if single else ["<b>%{meta}</b>", "surfaces[%{customdata[0]}]"]
    lines.append(_position(origin))
    if np.isfinite(part.alpha).any():
        lines.append("alpha = %{customdata[1]:.4f}" if not single else "alpha = %{customdata:.4f}")
    x, y, z = (part.vertices - origin).T
    i, j, k = part.faces.T
    trace: dict[str, Any] = {
        "type": "mesh3d",
        "name": _text(part.label),
        "meta": _text(part.label),
        **{name: _packed(row, np.float32) for name, row in zip("xyz", (x, y, z), strict=True)},
        **{name: _packed(row, _index_type(len(x))) for name, row in zip("ijk", (i, j, k), strict=True)},
        "color": _rgb(part.color),
        "showlegend": True,
        "hovertemplate": "<br>".join(lines) + "<extra></extra>",
        "lighting": {
            **LIGHTING,
            "specular": _specular(part),
            "vertexnormalsepsilon": NORMAL_NOISE,
            "facenormalsepsilon": NORMAL_NOISE,
        },
        "lightposition": lamp,
        "flatshading": part.face_colors is not None,
    }
    if part.face_colors is not None:
        trace["facecolor"] = [_rgb(row) for row in part.face_colors.tolist()]
    if colors is not None:
        trace["vertexcolor"] = _packed(colors, np.uint8)
        trace["customdata"] = _packed(np.stack([part.owner, part.alpha], 1), np.float32)
    elif np.isfinite(part.alpha).any():
        trace["customdata"] = _packed(part.alpha, np.float32)
    return trace


def _specular(part: Part) -> float:
    return min(1.0, 0.5 * float(part.material.specular)) if part.material is not None else 0.1


def _lines(lines: Sequence[Array], origin: Array, name: str, color: str, width: float) -> dict[str, Any]:
    gap = np.full((1, 3), np.nan)
    points = np.concatenate([row for line in lines for row in (line - origin, gap)])
    ends = {"marker": {"size": 3, "color": color}} if all(len(line) == 2 for line in lines) else {}
    return {
        "type": "scatter3d",
        "mode": "lines+markers" if ends else "lines",
        "name": name,
        **_columns(points),
        "line": {"color": color, "width": width},
        "hovertemplate": f"<b>{name}</b><br>{_position(origin)}<extra></extra>",
        "connectgaps": False,
        **ends,
    }


def _camera(eye: Eye, frustum: Array, origin: Array) -> dict[str, Any]:
    place = ", ".join(f"{x:.6g}" for x in eye.position)
    return {
        **_lines([frustum], origin, "camera", INK, 3),
        "hovertemplate": f"<b>camera</b><br>at {place}<extra></extra>",
    }


def _lights(what: Shown, origin: Array) -> dict[str, Any]:
    drawn = np.array([place for place, _, _ in what.lights]) - origin
    texts = []
    for i, (place, position, _) in enumerate(what.lights):
        moved = "" if np.array_equal(place, position) else "<br>(drawn nearer)"
        texts.append(f"light [{i}]<br>at {', '.join(f'{x:.6g}' for x in position)}{moved}")
    return {
        "type": "scatter3d",
        "mode": "markers",
        "name": "lights",
        **_columns(drawn),
        "text": texts,
        "marker": {
            "symbol": "circle",
            "size": 7,
            "color": [_rgb(color) for _, _, color in what.lights],
            "line": {"color": INK, "width": 1},
        },
        "hovertemplate": "%{text}<extra></extra>",
    }


def _layout(box: Box, origin: Array, side: float, views: dict[str, Any], title: str, background: str) -> dict[str, Any]:
    margin = side * MARGIN / (1 + 2 * MARGIN)
    low, high = box.low - origin - margin, box.high - origin + margin
    axes = {}
    for i, name in enumerate("xyz"):
        axes[f"{name}axis"] = {
            "visible": False,
            "range": [float(low[i]), float(high[i])],
            "title": {"text": f"{name} - {origin[i]:.17g}" if origin.any() else name},
            "showspikes": False,
            "showbackground": False,
            "gridcolor": GLASS,
            "zerolinecolor": GLASS,
        }
    return {
        "title": {"text": _text(title), "x": 0.01, "xanchor": "left", "y": 0.985, "yanchor": "top"},
        "margin": {"l": 0, "r": 0, "t": 0, "b": 0},
        "paper_bgcolor": background,
        "font": {"family": "system-ui, sans-serif", "color": INK},
        "hoverlabel": {"align": "left", "bgcolor": "white", "font": {"color": INK}},
        "legend": {
            "x": 0.99, "xanchor": "right", "y": 0.94, "yanchor": "top",
            "bgcolor": "rgba(255, 255, 255, 0.75)", "bordercolor": GLASS, "borderwidth": 1,
            "itemsizing": "constant",
        },
        "scene": {
            **axes,
            "aspectmode": "manual",
            "aspectratio": {name: float((high[i] - low[i]) / side) for i, name in enumerate("xyz")},
            "camera": views["camera"],
            "dragmode": "turntable" if views["camera"]["up"] == {"x": 0, "y": 0, "z": 1} else "orbit",
        },
        "uirevision": "kept",
    }  # fmt: skip


def _views(what: Shown, side: float) -> dict[str, Any]:
    """plotly's cameras, in units of the longest side about the box's middle."""
    eye, box, main = what.eye, what.box, what.main
    upright = abs(eye.right[2]) < 1e-9 and eye.up[2] > 0  # no roll: the turntable shows the same picture
    up = np.array([0.0, 0.0, 1.0]) if upright else eye.up
    ahead = max(float((main.center - eye.position) @ eye.forward), 0.05 * side)
    target = eye.position + ahead * eye.forward

    def seen(position: Array, center: Array) -> dict[str, Any]:
        return {
            "eye": _xyz((position - box.center) / side),
            "center": _xyz((center - box.center) / side),
            "up": {"x": 0, "y": 0, "z": 1} if upright else _xyz(up),
            "projection": {"type": "perspective"},
        }

    across, back, above = OVERVIEW
    direction = across * eye.right + back * eye.forward + above * up
    far = CLOSE * main.radius / max(math.sin(math.atan(eye.high)), NARROWEST)
    overview = main.center + far * direction / np.linalg.norm(direction)
    return {
        "camera": seen(eye.position, target),
        "overview": seen(overview, main.center),
        "angle": 2 * math.atan(eye.high),
    }


def _lightposition(what: Shown, views: dict[str, Any], side: float) -> dict[str, float]:
    """plotly's one lamp, which goes with the eye: as the scene's first lamp stands for the scene's camera.

    plotly wants it where it is on the screen, in units of half the screen, and in depth. It is kept in front, so that
    nothing that is seen lies in the dark.
    """
    eye = what.eye
    toward = what.lights[0][1] - what.box.center if what.lights else eye.up - eye.right - eye.forward
    axes = np.stack([eye.right, eye.up, -eye.forward])
    lamp = axes @ toward / (float(np.linalg.norm(toward)) or 1.0)
    lamp[2] = max(lamp[2], FRONTAL)
    x, y, z = axes @ (what.box.center - eye.position) / side + LAMP_AWAY * lamp / np.linalg.norm(lamp)
    depth = -z if abs(z) > NEAREST else NEAREST
    tangent = math.tan(views["angle"] / 2)
    near, far = DEPTHS
    z = ((far + near) * depth - 2 * far * near) / (far - near)
    return _xyz(np.array([x / (SCREEN * tangent), y / tangent, z]) / depth)


def _position(origin: Array) -> str:
    """x, y, z under the mouse; of a scene far away, what is added to them."""
    shift = [f"{o:.17g} + " if origin.any() else "" for o in origin]
    return "<br>".join(f"{name} = {s}%{{{name}:.5g}}" for name, s in zip("xyz", shift, strict=True))


def _columns(points: Array) -> dict[str, Any]:
    return {name: _packed(row, np.float32) for name, row in zip("xyz", points.T, strict=True)}


def _packed(values: Array, dtype: Any) -> dict[str, Any]:
    """An array as plotly reads it from text: base64 of its bytes, the lowest first."""
    array = np.ascontiguousarray(values, np.dtype(dtype).newbyteorder("<"))
    name = {"f": "f", "u": "u"}[array.dtype.kind] + str(array.dtype.itemsize)
    packed: dict[str, Any] = {"dtype": name, "bdata": base64.b64encode(array.tobytes()).decode("ascii")}
    if array.ndim > 1:
        packed["shape"] = ", ".join(str(n) for n in array.shape)
    return packed


def _index_type(count: int) -> Any:
    return np.uint16 if count <= np.iinfo(np.uint16).max else np.uint32


def _text(text: str) -> str:
    """A name as plotly shows it letter by letter: it knows a few elements of HTML."""
    short = text if len(text) <= MOST_LETTERS else text[: MOST_LETTERS - 1] + "\u2026"
    return html.escape(short, quote=False)  # quotation marks it shows as they are, and their names letter by letter


def _rgb(color: Any) -> str:
    return "rgb({}, {}, {})".format(*(int(c) for c in color))


def _xyz(v: Array) -> dict[str, float]:
    return {name: float(c) for name, c in zip("xyz", v, strict=True)}

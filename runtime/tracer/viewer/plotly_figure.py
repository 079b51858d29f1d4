"""Figure of the interactive page: plotly's traces and layout, as dicts for JSON. Texts are escaped here."""

from __future__ import annotations

import html
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common.html_page import encode_array, index_type
from .geometry import Box, MeshGroup, ViewerCamera, ViewerScene, merge_by_kind

Array = NDArray[Any]
#: Largest number of surfaces with a line of the legend each; more are merged by kind.
MOST_TRACES = 48
#: Distance from the origin, in radii of the scene, beyond which positions are relative to its center: the page's
#: numbers have 24 bits.
FAR = 100.0
#: Free margin around everything, as a fraction of the range.
MARGIN = 0.04
#: Lighting model of plotly: some ambient light, so that nothing is black.
LIGHTING = {"ambient": 0.36, "diffuse": 0.62, "roughness": 0.4, "fresnel": 0.05}
#: Smallest area of faces whose normals plotly uses: ours are small, but none is a point.
NORMAL_NOISE = 1e-15
#: Distance of plotly's light in units of the longest side.
LAMP_AWAY = 3.0
#: Smallest component of the light's direction towards the viewer.
FRONTAL = 1.0
#: Aspect ratio of most screens.
SCREEN = 1.6
#: Near and far clipping planes of plotly.
DEPTHS = (0.01, 1000.0)
#: Smallest depth of the light, to avoid a division by zero.
NEAREST = 1e-3
#: Color of control objects.
RED = "rgb(200, 40, 30)"
#: Color of texts, the camera and the lights.
INK = "rgb(34, 48, 60)"
#: Color of grid lines.
GLASS = "rgba(34, 48, 60, 0.25)"
#: Direction of the overview, to the right, ahead and above in the axes of the scene's camera.
OVERVIEW = (-1.6, -1.1, 0.9)
#: Distance of the overview, relative to that of the bounding sphere, which is larger than its contents.
CLOSE = 0.8
#: Smallest sine of half the field of view of the overview.
NARROWEST = 0.2
#: Largest number of letters of a name in the legend.
MOST_LETTERS = 48


def figure(viewed: ViewerScene, title: str, background: str) -> dict[str, Any]:
    """The whole figure, with the cameras of the page's buttons under "views"."""
    origin = np.round(viewed.box.center) if np.linalg.norm(viewed.box.center) > FAR * viewed.box.radius else np.zeros(3)
    groups = viewed.groups if len(viewed.groups) <= MOST_TRACES else merge_by_kind(viewed.groups)
    side = float((viewed.box.high - viewed.box.low).max()) * (1 + 2 * MARGIN) or 1.0
    views = _views(viewed, side)
    lamp = _lightposition(viewed, views, side)
    traces = [_mesh(group, origin, lamp) for group in groups]
    if viewed.controls:
        traces.append(_lines(viewed.controls, origin, "control objects", RED, 5))
    if viewed.frustum is not None:
        traces.append(_camera(viewed.camera, viewed.frustum, origin))
    if viewed.lights:
        traces.append(_lights(viewed, origin))
    return {"data": traces, "layout": _layout(viewed.box, origin, side, views, title, background), "views": views}


def _mesh(group: MeshGroup, origin: Array, lamp: dict[str, float]) -> dict[str, Any]:
    colors = group.vertex_colors
    single = colors is None
    lines = ["<b>%{meta}</b>", html.escape(group.kind)] if single else ["<b>%{meta}</b>", "surfaces[%{customdata[0]}]"]
    lines.append(_position(origin))
    if np.isfinite(group.alpha).any():
        lines.append("alpha = %{customdata[1]:.4f}" if not single else "alpha = %{customdata:.4f}")
    x, y, z = (group.vertices - origin).T
    i, j, k = group.faces.T
    trace: dict[str, Any] = {
        "type": "mesh3d",
        "name": _text(group.label),
        "meta": _text(group.label),
        **{name: encode_array(row, np.float32) for name, row in zip("xyz", (x, y, z), strict=True)},
        **{name: encode_array(row, index_type(len(x))) for name, row in zip("ijk", (i, j, k), strict=True)},
        "color": _rgb(group.color),
        "showlegend": True,
        "hovertemplate": "<br>".join(lines) + "<extra></extra>",
        "lighting": {
            **LIGHTING,
            "specular": _specular(group),
            "vertexnormalsepsilon": NORMAL_NOISE,
            "facenormalsepsilon": NORMAL_NOISE,
        },
        "lightposition": lamp,
        "flatshading": group.face_colors is not None,
    }
    if group.face_colors is not None:
        trace["facecolor"] = [_rgb(row) for row in group.face_colors.tolist()]
    if colors is not None:
        trace["vertexcolor"] = _encode_rows(colors, np.uint8)
        trace["customdata"] = _encode_rows(np.stack([group.owner, group.alpha], 1), np.float32)
    elif np.isfinite(group.alpha).any():
        trace["customdata"] = encode_array(group.alpha, np.float32)
    return trace


def _specular(group: MeshGroup) -> float:
    return min(1.0, 0.5 * float(group.material.specular)) if group.material is not None else 0.1


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


def _camera(camera: ViewerCamera, frustum: Array, origin: Array) -> dict[str, Any]:
    position = ", ".join(f"{x:.6g}" for x in camera.position)
    return {
        **_lines([frustum], origin, "camera", INK, 3),
        "hovertemplate": f"<b>camera</b><br>at {position}<extra></extra>",
    }


def _lights(viewed: ViewerScene, origin: Array) -> dict[str, Any]:
    drawn = np.array([shown for shown, _, _ in viewed.lights]) - origin
    texts = []
    for i, (shown, position, _) in enumerate(viewed.lights):
        moved = "" if np.array_equal(shown, position) else "<br>(drawn nearer)"
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
            "color": [_rgb(color) for _, _, color in viewed.lights],
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


def _views(viewed: ViewerScene, side: float) -> dict[str, Any]:
    """Cameras of plotly, in units of the longest side about the center of the box."""
    camera, box, main = viewed.camera, viewed.box, viewed.main
    upright = abs(camera.right[2]) < 1e-9 and camera.up[2] > 0  # no roll: the turntable shows the same picture
    up = np.array([0.0, 0.0, 1.0]) if upright else camera.up
    ahead = max(float((main.center - camera.position) @ camera.forward), 0.05 * side)
    target = camera.position + ahead * camera.forward

    def plotly_camera(position: Array, center: Array) -> dict[str, Any]:
        return {
            "eye": _xyz((position - box.center) / side),
            "center": _xyz((center - box.center) / side),
            "up": {"x": 0, "y": 0, "z": 1} if upright else _xyz(up),
            "projection": {"type": "perspective"},
        }

    across, back, above = OVERVIEW
    direction = across * camera.right + back * camera.forward + above * up
    far = CLOSE * main.radius / max(math.sin(math.atan(camera.high)), NARROWEST)
    overview = main.center + far * direction / np.linalg.norm(direction)
    return {
        "camera": plotly_camera(camera.position, target),
        "overview": plotly_camera(overview, main.center),
        "angle": 2 * math.atan(camera.high),
    }


def _lightposition(viewed: ViewerScene, views: dict[str, Any], side: float) -> dict[str, float]:
    """Position of plotly's only light, which moves with the view: like the scene's first light from its camera.

    plotly expects screen coordinates, in units of half the screen, and a depth. The light stays in front, so that no
    visible surface is dark.
    """
    camera = viewed.camera
    toward = viewed.lights[0][1] - viewed.box.center if viewed.lights else camera.up - camera.right - camera.forward
    axes = np.stack([camera.right, camera.up, -camera.forward])
    lamp = axes @ toward / (float(np.linalg.norm(toward)) or 1.0)
    lamp[2] = max(lamp[2], FRONTAL)
    x, y, z = axes @ (viewed.box.center - camera.position) / side + LAMP_AWAY * lamp / np.linalg.norm(lamp)
    depth = -z if abs(z) > NEAREST else NEAREST
    tangent = math.tan(views["angle"] / 2)
    near, far = DEPTHS
    z = ((far + near) * depth - 2 * far * near) / (far - near)
    return _xyz(np.array([x / (SCREEN * tangent), y / tangent, z]) / depth)


def _position(origin: Array) -> str:
    """Template for x, y, z under the mouse, with the origin of a distant scene."""
    shift = [f"{o:.17g} + " if origin.any() else "" for o in origin]
    return "<br>".join(f"{name} = {s}%{{{name}:.5g}}" for name, s in zip("xyz", shift, strict=True))


def _columns(points: Array) -> dict[str, Any]:
    return {name: encode_array(row, np.float32) for name, row in zip("xyz", points.T, strict=True)}


def _encode_rows(values: Array, dtype: Any) -> dict[str, str]:
    """Encode an array of several columns, whose shape plotly needs."""
    return {**encode_array(values, dtype), "shape": ", ".join(map(str, values.shape))}


def _text(text: str) -> str:
    """Escape a name, since plotly interprets some HTML, and shorten it."""
    short = text if len(text) <= MOST_LETTERS else text[: MOST_LETTERS - 1] + "\u2026"
    return html.escape(short, quote=False)  # plotly shows quotation marks as they are, but not their entities


def _rgb(color: Any) -> str:
    return "rgb({}, {}, {})".format(*(int(c) for c in color))


def _xyz(v: Array) -> dict[str, float]:
    return {name: float(c) for name, c in zip("xyz", v, strict=True)}

"""Interactive HTML page of a scene: a single file with the surfaces in 3D, which needs no network.

plotly (extra ``view``) draws; its JavaScript is part of the page, so that every page has at least 5 MB.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...common.files import output_path, write_file
from ...common.html_page import page_json, render_page
from ...common.validation import as_instance, short_repr
from ...errors import MissingExtraError, SceneError
from ..output.image import encode
from ..scene import values
from ..scene.scene import Scene

#: Names of pages end so.
FORMATS = (".html", ".htm")
#: Default number of vertices of all meshes of a page: some 8 MB.
VERTICES = 200_000
#: Largest number of vertices: browsers do not show more.
MOST_VERTICES = 50_000_000


@dataclass(frozen=True, eq=False)
class Page:
    """An interactive page.

    Attributes
    ----------
    html : str
        The whole file.
    library, data : int
        Bytes of plotly's JavaScript, and of the scene's meshes and texts.
    surfaces, traces, vertices, triangles : int
        Numbers of what it shows; surfaces are merged by kind where there are many.
    missing : tuple of str
        Surfaces without a mesh, and the reason: evolved circles that become a line, for example.
    """

    html: str
    library: int
    data: int
    surfaces: int
    traces: int
    vertices: int
    triangles: int
    missing: tuple[str, ...] = ()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the file atomically.

        Raises
        ------
        InputError
            If the path is not writable, or no name of a page.
        """
        write_file(output_path(path, "a page", "pages", FORMATS), self.html)

    def __str__(self) -> str:
        size = len(self.html.encode())
        return (
            f"{size / 1e6:.1f} MB: {self.library / 1e6:.1f} MB of plotly, {self.data / 1e6:.1f} MB of "
            f"{_count(self.surfaces, 'surface')} with {_count(self.vertices, 'vertex')} and "
            f"{_count(self.triangles, 'triangle')}"
        )


def view(
    scene: Scene,
    path: str | os.PathLike[str] | None = None,
    *,
    title: str | None = None,
    names: Sequence[str | None] | None = None,
    vertices: int = VERTICES,
) -> Page:
    """Make an interactive page of a scene: one self-contained HTML file.

    Parameters
    ----------
    scene : Scene
    path : path, optional
        File to write.
    title : str, optional
    names : sequence of str or None, optional
        Names of the surfaces in the legend; default: their own names, else kind and index.
    vertices : int
        Approximate number of vertices of all meshes. Surfaces get equal parts of it, between 30 and 9300 each; meshes
        of triangles are shown as they are.

    Returns
    -------
    Page
        ``print(page)`` lists its contents.

    Raises
    ------
    MissingExtraError
        If plotly is not installed.
    SceneError, InputError
        If an argument is not valid, or the file cannot be written.
    """
    as_instance(scene, "scene", Scene, error=SceneError)
    budget = values.whole(vertices, "vertices", 1, MOST_VERTICES)
    if names is not None and (not isinstance(names, Sequence) or isinstance(names, str | bytes)):
        raise SceneError(f"names is {short_repr(names)}; a list is needed.")
    if names is not None and len(names) != len(scene.surfaces):
        raise SceneError(f"names are {len(names)}; one for each of {len(scene.surfaces)} surfaces is needed.")
    if path is not None:
        output_path(path, "a page", "pages", FORMATS)
    library = _library()
    from .geometry import build_viewer_scene
    from .plotly_figure import figure

    viewed = build_viewer_scene(scene, names, budget)
    heading = "A scene" if title is None else str(title)
    horizon = np.minimum(1.0, 0.35 * scene.sky[:3] + 0.65)  # pale, so that text can be read on it
    plotly_figure = figure(viewed, heading, "rgb({}, {}, {})".format(*encode(horizon)))
    data = page_json(plotly_figure)
    count = sum(len(group.vertices) for group in viewed.groups), sum(len(group.faces) for group in viewed.groups)
    note = [f"{_count(len(scene.surfaces), 'surface')}, {_count(count[0], 'vertex')}; drag to turn, scroll to zoom"]
    text = render_page("view", heading, " \u00b7 ".join([*note, *viewed.missing]), data, library)
    sizes = len(library.encode()), len(data)
    page = Page(text, *sizes, len(scene.surfaces), len(plotly_figure["data"]), *count, tuple(viewed.missing))
    if path is not None:
        page.save(path)
    return page


def _library() -> str:
    """JavaScript of plotly."""
    try:
        from plotly.offline import get_plotlyjs
    except ImportError:
        raise MissingExtraError("view", "An interactive page") from None
    text: str = get_plotlyjs()
    return text.replace("</script", "<\\/script")  # nothing in it ends the element that holds it


def _count(number: int, what: str) -> str:
    plural = {"vertex": "vertices"}.get(what, f"{what}s")
    return f"{number} {what if number == 1 else plural}"

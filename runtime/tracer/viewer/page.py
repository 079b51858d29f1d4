"""A scene as one HTML page that opens anywhere: the surfaces in 3D, to turn and to touch, and no network at all.

plotly (extra ``view``) draws; its JavaScript is part of the page, which is why no page is smaller than 5 MB.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import InputError, MissingExtraError, SceneError
from ..files import write_atomically
from ..webpages import filled, page_json
from . import values
from .image import encode, file_named
from .scene import Scene

#: Vertices that the meshes of a page may have together: some 8 MB.
VERTICES = 200_000
#: More than browsers show.
MOST_VERTICES = 50_000_000


@dataclass(frozen=True, eq=False)
class Page:
    """An interactive page.

    Attributes
    ----------
    html : str
        The whole file.
    library, data : int
        Bytes of it that are plotly's JavaScript, and the scene's meshes and texts.
    surfaces, traces, vertices, triangles : int
        What it shows; surfaces are joined by kind where there are many.
    missing : tuple of str
        Surfaces that have no mesh, and why: evolved circles that become a line, for example.
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
        """Write the file, in one step.

        Raises
        ------
        InputError
            If it cannot be written there.
        """
        try:
            write_atomically(file_named(path), self.html)
        except OSError as error:
            raise InputError(f"it cannot be written: {error.strerror}.", where=str(path)) from None

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
    """An interactive page of a scene: one HTML file with everything in it.

    Parameters
    ----------
    scene : Scene
    path : path, optional
        Where to write it.
    title : str, optional
    names : sequence of str or None, optional
        What the legend calls each surface; default: its own name, else its kind and place.
    vertices : int
        About how many the meshes may have together. Surfaces have the same share each, of 30 at least and 9300 at
        most; meshes of triangles are shown as they are.

    Returns
    -------
    Page
        ``print(page)`` says what it is made of.

    Raises
    ------
    MissingExtraError
        If plotly is not installed.
    SceneError, InputError
        If an argument is none, or the file cannot be written.
    """
    if not isinstance(scene, Scene):
        raise SceneError(f"scene is {type(scene).__name__}, which is no Scene.")
    budget = values.whole(vertices, "vertices", 1, MOST_VERTICES)
    if names is not None and (not isinstance(names, Sequence) or isinstance(names, str | bytes)):
        raise SceneError(f"names is {values.shown(names)}; a list is needed.")
    if names is not None and len(names) != len(scene.surfaces):
        raise SceneError(f"names are {len(names)}; one for each of {len(scene.surfaces)} surfaces is needed.")
    if path is not None:
        file_named(path)
    library = _library()
    from .view_figure import figure
    from .view_parts import shown

    what = shown(scene, names, budget)
    heading = "A scene" if title is None else str(title)
    horizon = np.minimum(1.0, 0.35 * scene.sky[:3] + 0.65)  # pale, so that text can be read on it
    made = figure(what, heading, "rgb({}, {}, {})".format(*encode(horizon)))
    data = page_json(made)
    count = sum(len(part.vertices) for part in what.parts), sum(len(part.faces) for part in what.parts)
    note = [f"{_count(len(scene.surfaces), 'surface')}, {_count(count[0], 'vertex')}; drag to turn, scroll to zoom"]
    text = filled(f"{__package__}.data", "view", heading, " \u00b7 ".join([*note, *what.missing]), data, library)
    sizes = len(library.encode()), len(data)
    page = Page(text, *sizes, len(scene.surfaces), len(made["data"]), *count, tuple(what.missing))
    if path is not None:
        page.save(path)
    return page


def _library() -> str:
    """plotly's JavaScript."""
    try:
        from plotly.offline import get_plotlyjs
    except ImportError:
        raise MissingExtraError("view", "An interactive page") from None
    text: str = get_plotlyjs()
    return text.replace("</script", "<\\/script")  # nothing in it ends the element that holds it


def _count(number: int, what: str) -> str:
    plural = {"vertex": "vertices"}.get(what, f"{what}s")
    return f"{number} {what if number == 1 else plural}"


__all__ = ["Page", "view"]

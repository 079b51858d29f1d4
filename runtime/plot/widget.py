"""The widget of `plot.show`; imported by the first of them, since it needs anywidget."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import anywidget
import traitlets

from ..codegen.targets.templates import template_text


class InteractiveFigure(anywidget.AnyWidget):
    """A figure whose sliders and points call a function; made by `show`.

    Attributes
    ----------
    inputs : dict
        Values of the ``sliders`` and positions of the ``points``, by name, and the number of the last question.
    """

    _esm = template_text("stage.js") + template_text("interactive.js")
    setup = traitlets.Dict().tag(sync=True)
    inputs = traitlets.Dict().tag(sync=True)
    frame = traitlets.Dict().tag(sync=True)

    def __init__(
        self,
        setup: Mapping[str, Any],
        inputs: Mapping[str, Any],
        answer: Callable[[Mapping[str, Any]], dict[str, Any]],
    ) -> None:
        super().__init__(setup=dict(setup), inputs=dict(inputs), frame=answer(inputs))
        self.observe(lambda change: setattr(self, "frame", answer(change["new"])), "inputs")

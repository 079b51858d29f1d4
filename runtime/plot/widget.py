"""The widget of `plot.show`; imported by the first of them, since it needs anywidget."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import anywidget
import traitlets

from ..codegen.targets.templates import template_text

#: From inputs to the frame, and the parts of each object.
Answer = Callable[[Mapping[str, Any]], tuple[dict[str, Any], list[list[dict[str, Any]]]]]


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

    def __init__(self, setup: Mapping[str, Any], inputs: Mapping[str, Any], answer: Answer) -> None:
        super().__init__(setup=dict(setup), inputs=dict(inputs))
        self._answer = answer
        self._show(inputs)
        self.observe(lambda change: self._show(change["new"]), "inputs")

    def _show(self, inputs: Mapping[str, Any]) -> None:
        """Answer: each object is a trait ``object<i>``, so that one that is as it was is not sent again."""
        frame, objects = self._answer(inputs)
        with self.hold_sync():
            parts = {f"object{i}": inside for i, inside in enumerate(objects)}
            parts.update((f"object{i}", []) for i in range(len(objects), self.frame.get("objects", 0)))
            if new := {name: traitlets.Any(()).tag(sync=True) for name in parts if not self.has_trait(name)}:
                self.add_traits(**new)  # a class of its own: never without need
            for name, value in parts.items():
                if getattr(self, name) is not value:
                    setattr(self, name, value)
            self.frame = frame

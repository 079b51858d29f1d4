"""Base of objects that cannot be changed after construction, because compiled drivers hold copies of their numbers."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from ...errors import SceneError


class Immutable:
    """Base of cameras, lights, surfaces and scenes: public attributes are set during construction only.

    A constructor ends with ``self._frozen = True``.
    """

    #: Remedy of the error for a changed attribute.
    _replacement_hint: ClassVar[str] = "Make a new one"
    #: Attributes that no driver holds, and that may be changed.
    _mutable_fields: ClassVar[tuple[str, ...]] = ()
    #: Attributes that its text shows: numbers, rows of them, or others.
    _shown: ClassVar[tuple[str, ...]] = ()
    _frozen: bool = False

    def __setattr__(self, name: str, value: Any) -> None:
        if self._frozen and not name.startswith("_") and name not in self._mutable_fields:
            what = f"{type(self).__name__}.{name} cannot be changed after construction."
            raise SceneError(what, remedy=self._replacement_hint)
        super().__setattr__(name, value)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{name}={_text(getattr(self, name))}' for name in self._shown)})"


def _text(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return f"({', '.join(f'{x + 0.0:.6g}' for x in value)})"
    return f"{value + 0.0:.6g}" if isinstance(value, float) else repr(value)

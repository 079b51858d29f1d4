"""Things that are not changed once they are made, because compiled drivers hold their numbers."""

from __future__ import annotations

from typing import Any, ClassVar

from ..errors import SceneError


class Fixed:
    """Base of cameras, lights, surfaces and scenes: public attributes are set while they are made, and never again.

    Each class says that it is made with ``self._made = True``.
    """

    #: What else than a new one helps, if anything.
    _instead: ClassVar[str] = "Make a new one"
    #: Attributes that no driver holds.
    _free: ClassVar[tuple[str, ...]] = ()
    _made: bool = False

    def __setattr__(self, name: str, value: Any) -> None:
        if self._made and not name.startswith("_") and name not in self._free:
            what = f"{type(self).__name__}.{name} is not changed once it is made."
            raise SceneError(what, remedy=self._instead)
        super().__setattr__(name, value)

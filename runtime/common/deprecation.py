"""Old public names: they work for one more release and warn once per process, each at the user's line.

While new names are used, nothing here is called but the wrapper of a function whose arguments changed: 0.2 us a call.
A function that itself takes a few microseconds names the old keyword in its signature and calls `warn_renamed`.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar

_Function = TypeVar("_Function", bound=Callable[..., Any])
_warned: set[str] = set()


def warn_renamed(old: str, new: str) -> None:
    """Warn, the first time in this process, that a name is old.

    Parameters
    ----------
    old, new : str
        As the user would write them, such as ``"module.function(keyword=)"``.
    """
    if old in _warned:
        return
    _warned.add(old)
    frame, level = sys._getframe(1), 2
    while (name := f"{frame.f_globals.get('__name__')}.").startswith(("bladesmith.", "importlib.")) and frame.f_back:
        frame = frame.f_back
        level += not name.startswith("importlib._bootstrap")  # `warnings` does not count these
    warnings.warn(f"{old} is now {new}; the old name goes with the next release.", FutureWarning, stacklevel=level)


def renamed_keywords(**names: str) -> Callable[[_Function], _Function]:
    """Decorator of a function, a method or a class that accepts old keywords: ``@renamed_keywords(old="new")``."""

    old_names = frozenset(names)

    def decorate(function: _Function) -> _Function:
        def translate(keywords: dict[str, Any]) -> dict[str, Any]:
            for old in old_names.intersection(keywords):
                new = names[old]
                if new in keywords:
                    raise TypeError(f"{function.__qualname__}() got {new!r} twice: also as {old!r}, its old name")
                warn_renamed(f"{function.__qualname__}({old}=)", f"{new}=")
                keywords[new] = keywords.pop(old)
            return keywords

        def call(*arguments: Any, **keywords: Any) -> Any:
            if not old_names.isdisjoint(keywords):
                keywords = translate(keywords)
            return body(*arguments, **keywords)

        body: Callable[..., Any] = function
        if not isinstance(function, type):
            return wraps(function)(call)  # type: ignore[return-value]
        body = function.__init__  # type: ignore[misc]
        function.__init__ = wraps(body)(call)  # type: ignore[misc]
        return function

    return decorate


def reordered(*old: str, when: Callable[..., bool]) -> Callable[[_Function], _Function]:
    """Decorator of a function whose positional arguments stand in another order, or are keywords, now.

    Parameters
    ----------
    *old : str
        Their names in the old order, ``self`` of a method included.
    when : callable
        Whether positional arguments, as they were passed, are in the old order.
    """

    def decorate(function: _Function) -> _Function:
        @wraps(function)
        def call(*arguments: Any, **keywords: Any) -> Any:
            if when(*arguments):
                named = dict(zip(old, arguments, strict=False))
                changed = ", ".join(f"{name}=" for name in named if name != "self")
                warn_renamed(f"{function.__qualname__}() with its arguments in this order", f"called with {changed}")
                return function(**named, **keywords)
            return function(*arguments, **keywords)

        return call  # type: ignore[return-value]

    return decorate


def renamed_names(module: str, find: Callable[[str], Any] | None = None, **names: str) -> Callable[[str], Any]:
    """``__getattr__`` of a module that has old names: ``__getattr__ = renamed_names(__name__, old="new")``.

    Parameters
    ----------
    module : str
        Its ``__name__``.
    find : callable, optional
        The ``__getattr__`` that it has so far. Without one and without a stub, hide the assignment from type checkers
        (``if not TYPE_CHECKING``): a module with ``__getattr__`` has every name for them.
    **names : str
        New names by old ones.
    """

    def get(name: str) -> Any:
        if name in names:
            warn_renamed(f"{module}.{name}", f"{module}.{names[name]}")
            return getattr(sys.modules[module], names[name])
        if find is not None:
            return find(name)
        raise AttributeError(f"module {module!r} has no attribute {name!r}")

    return get


class renamed_attribute:
    """The old name of a method, property or field in the body of its class: ``old = renamed_attribute("new")``."""

    def __init__(self, new: str) -> None:
        self.new = new

    def __get__(self, instance: object, owner: type) -> Any:
        old = next(name for base in owner.__mro__ for name, value in vars(base).items() if value is self)
        warn_renamed(f"{owner.__name__}.{old}", f"{owner.__name__}.{self.new}")
        return getattr(owner if instance is None else instance, self.new)

"""`bladesmith.registration` by the name that the thesis gave its method (chapter 5)."""

from __future__ import annotations

from typing import Any

from . import registration
from .registration import __all__ as __all__


def __getattr__(name: str) -> Any:
    return getattr(registration, name)


def __dir__() -> list[str]:
    return __all__

"""The folder of the checkout, from which tests make every path, and the names that the package gives to users."""

from __future__ import annotations

import inspect
from pathlib import Path

import bladesmith

CHECKOUT = Path(__file__).resolve().parents[2]


def public_modules() -> dict[str, list[str]]:
    """Names of the package and of the modules that are public names of it."""
    modules = [bladesmith, *(x for x in map(bladesmith.__getattr__, bladesmith.__all__) if inspect.ismodule(x))]
    return {
        m.__name__: sorted(getattr(m, "__all__", None) or [n for n, x in vars(m).items() if defined_here(n, x)])
        for m in modules
    }


def defined_here(name: str, value: object) -> bool:
    return not name.startswith("_") and str(getattr(value, "__module__", "")).startswith("bladesmith.")

"""The folder of the checkout, from which tests make every path, that of what they compile, and the names that the
package gives to users."""

from __future__ import annotations

import inspect
import os
from pathlib import Path

from platformdirs import user_cache_dir

import bladesmith

CHECKOUT = Path(__file__).resolve().parents[2]
#: The user's, kept between sessions: the second one compiles nothing. Not inside the cache that programs use.
TEST_CACHE = os.environ.get("BLADESMITH_TEST_CACHE_DIR") or user_cache_dir("bladesmith-tests", appauthor=False)


def public_modules() -> dict[str, list[str]]:
    """Names of the package and of the modules that are public names of it."""
    modules = [bladesmith, *(x for x in map(bladesmith.__getattr__, bladesmith.__all__) if inspect.ismodule(x))]
    return {
        m.__name__: sorted(getattr(m, "__all__", None) or [n for n, x in vars(m).items() if defined_here(n, x)])
        for m in modules
    }


def defined_here(name: str, value: object) -> bool:
    return not name.startswith("_") and str(getattr(value, "__module__", "")).startswith("bladesmith.")

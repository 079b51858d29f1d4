"""What every test runs under: one cache of compiled kernels, no display, repeatable examples."""

import os
import shutil
import tempfile

import pytest
from hypothesis import settings

CACHE_VARIABLE = "BLADESMITH_CACHE_DIR"
KEPT_CACHE = os.environ.get("BLADESMITH_TEST_CACHE_DIR")  # a developer's: kept between sessions

settings.register_profile("ci", deadline=None, derandomize=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "ci"))


def pytest_configure(config: pytest.Config) -> None:
    """Before collection, since modules declare kernels when they are imported.

    The workers of pytest-xdist inherit the variable from their controller, and so share the cache.
    """
    os.environ["MPLBACKEND"] = "Agg"
    if not hasattr(config, "workerinput"):
        os.environ[CACHE_VARIABLE] = KEPT_CACHE or tempfile.mkdtemp(prefix="bladesmith-tests-")


def pytest_unconfigure(config: pytest.Config) -> None:
    if not hasattr(config, "workerinput") and not KEPT_CACHE:
        shutil.rmtree(os.environ[CACHE_VARIABLE], ignore_errors=True)

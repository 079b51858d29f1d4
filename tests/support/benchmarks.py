"""The scripts of benchmarks/, imported as modules."""

import importlib.util
import sys
from contextlib import contextmanager

import pytest

from .checkout import CHECKOUT


@contextmanager
def benchmark_module(name):
    """A script of benchmarks/, which imports its neighbours; tests are skipped where the folder is missing."""
    folder = CHECKOUT / "benchmarks"
    if not folder.is_dir():
        pytest.skip("no benchmarks here")
    sys.path.insert(0, str(folder))
    try:
        spec = importlib.util.spec_from_file_location(name, folder / f"{name}.py")
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        yield module
    finally:
        sys.path.remove(str(folder))

"""Scripts of folders that are no packages, imported as modules."""

import importlib.util
import sys
from contextlib import contextmanager

import pytest

from .checkout import CHECKOUT


@contextmanager
def script(folder, name):
    """A script of a folder, which imports its neighbours; tests are skipped where the folder is missing."""
    folder = CHECKOUT / folder
    if not folder.is_dir():
        pytest.skip(f"no {folder.name} here")
    sys.path.insert(0, str(folder))
    try:
        spec = importlib.util.spec_from_file_location(name, folder / f"{name}.py")
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module  # where dataclasses look for their annotations
        spec.loader.exec_module(module)
        yield module
    finally:
        sys.path.remove(str(folder))
        sys.modules.pop(name, None)

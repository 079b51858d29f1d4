"""Caches of compiled extensions for tests."""

import pytest

from bladesmith.codegen.build import cache

from ...support.build.extension_parts import forget


@pytest.fixture
def cache_dir(tmp_path, monkeypatch):
    """An empty cache and a process that has loaded nothing."""
    root = tmp_path / "cache"
    monkeypatch.setenv(cache.DIRECTORY_VARIABLE, str(root))
    monkeypatch.setattr(cache, "_private", [])
    forget(monkeypatch)
    return root

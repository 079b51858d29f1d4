"""The small scene that several tests of pictures render, and what is wanted of it."""

import pytest

from bladesmith import tracer
from bladesmith.tracer.rendering import row_bands

from ..support.tracer.rendering import all_layers, written


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return written(tmp_path_factory.mktemp("scene"))


@pytest.fixture(scope="module")
def scene(path):
    return tracer.Scene.load(path)


@pytest.fixture(scope="module")
def expected(scene):
    return all_layers(scene)


@pytest.fixture
def small_bands(monkeypatch):
    monkeypatch.setattr(row_bands, "RAYS_PER_BAND", 200)

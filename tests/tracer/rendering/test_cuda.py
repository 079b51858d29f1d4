"""Scenes on a GPU: the bits of C, in pictures and in what rays meet, with a tree and without, in both precisions."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bladesmith import tracer
from bladesmith.errors import DeviceError
from bladesmith.tracer.rendering import cuda_engine

from ...support import cuda
from .test_numba import CAMERA, LIGHTS, few, many, rays, same, swept

pytestmark = [pytest.mark.gpu, pytest.mark.slow, pytest.mark.compiles]
LAYERS = ("color", "normal", "depth", "alpha", "cost")


@pytest.mark.parametrize("surfaces", [few, many, swept])
@cuda.each_device
def test_pictures_and_hits_have_the_bits_of_c(surfaces: Any, where: str) -> None:
    scene = tracer.Scene(CAMERA, LIGHTS, surfaces(), reflections=4)
    origins, directions = rays(np.random.default_rng(4), 3000)
    cuda_engine.cuda_engine.cache_clear()
    with cuda.devices(where) as used:
        for dtype in (np.float64, np.float32):
            found = scene.layers(48, 36, LAYERS, antialias=2, target="cuda", dtype=dtype)
            expected = scene.layers(48, 36, LAYERS, antialias=2, dtype=dtype)
            for name in LAYERS:
                same(found[name], expected[name])
            with np.errstate(all="ignore"):
                start, direction = origins.astype(dtype), directions.astype(dtype)
                ours, theirs = (scene.intersect(start, direction, target=target) for target in ("cuda", "c"))
            for name in ("t", "surface", "status", "point", "normal", "alpha", "hit"):
                same(getattr(ours, name), getattr(theirs, name))
            assert theirs.hit.sum() > 100
        assert not len(scene.intersect(origins[:0], directions[:0], target="cuda").t)
    assert used
    cuda_engine.cuda_engine.cache_clear()


@pytest.mark.parametrize("band", [7, 100])
def test_bands_of_a_picture_are_copied_where_they_belong(band: int, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = tracer.Scene(CAMERA, LIGHTS, few())
    monkeypatch.setattr(cuda_engine.CudaEngine, "chunk", band)
    cuda_engine.cuda_engine.cache_clear()
    with cuda.devices(cuda.STAND_IN):
        same(scene.render(31, 17, threads=2, target="cuda"), scene.render(31, 17))
    cuda_engine.cuda_engine.cache_clear()


@pytest.mark.skipif(not cuda.unavailable(), reason="there is a GPU")
def test_without_a_gpu_the_error_says_so() -> None:
    with pytest.raises(DeviceError, match="is not there"):
        tracer.Scene(CAMERA, LIGHTS, few()).render(4, 3, target="cuda")

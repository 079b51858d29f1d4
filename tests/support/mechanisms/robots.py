"""Inertias for chains of tests, and URDF files of real robots where they are installed."""

from __future__ import annotations

from importlib import util
from pathlib import Path

import numpy as np
import pytest


def random_inertias(rng, count, scale=1.0, center=0.0):
    """Masses, centers around a place, and tensors that bodies may have."""
    masses = rng.uniform(0.5, 3.0, count)
    centers = center + scale * rng.normal(size=(count, 3))
    points = scale * rng.normal(size=(count, 6, 3))
    squares = np.einsum("nki,nkj->nij", points, points) / 6
    tensors = masses[:, None, None] * (np.trace(squares, axis1=1, axis2=2)[:, None, None] * np.eye(3) - squares)
    return masses, centers, tensors


def real_robots():
    """URDF files of the package example-robot-data, by short names."""
    spec = util.find_spec("cmeel")
    if spec is None or not spec.submodule_search_locations:
        return {}
    folder = Path(next(iter(spec.submodule_search_locations))).parent
    robots = folder / "cmeel.prefix" / "share" / "example-robot-data" / "robots"
    return {f"{p.parts[-3].removesuffix('_description')}/{p.stem}": p for p in sorted(robots.rglob("*.urdf"))}


ABSENT = "no package example-robot-data"
#: A mark of tests that read some of these files.
needs_robots = pytest.mark.skipif(not real_robots(), reason=ABSENT)


def each_robot(start=""):
    """A mark by which a test runs with the name of each robot; where there are none it is skipped, and says why."""
    absent = pytest.param("", marks=pytest.mark.skip(reason=ABSENT))
    return pytest.mark.parametrize("name", [name for name in real_robots() if name.startswith(start)] or [absent])

"""Defaults and limits of scenes and their pictures, for scenes made in Python and for scene files."""

from __future__ import annotations

#: Size of a picture in pixels where neither the caller nor the scene gives one.
WIDTH = 640
HEIGHT = 480
#: Reflections that are followed along one ray.
REFLECTIONS = 4
#: Linear color of the sky at and below the horizon.
HORIZON = (0.75, 0.82, 0.9)
#: Linear color of the sky straight up.
ZENITH = (0.2, 0.35, 0.65)
#: Largest number of pixels along a side: more is a mistake.
MAX_SIDE = 65536
#: Largest number of rays along a side of a pixel.
MAX_GRID = 64
#: Largest number of reflections along one ray.
MAX_REFLECTIONS = 1000
#: Largest value of each setting that a scene may hold for its pictures.
SETTINGS = {"width": MAX_SIDE, "height": MAX_SIDE, "antialias": MAX_GRID}

"""Geometric objects: rotors between them, blends, averages, costs, clusters, screws, fits (thesis chapters 2 and 3).

Functions take batches of objects of `bladesmith.cga3d` and give batches; each is loaded when it is first used.
"""

from __future__ import annotations

from ..codegen.lazy_names import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)

"""Ray tracing of planes, spheres, discs, triangles and surfaces evolved along curves (thesis chapter 4).

Each name is loaded when it is first used.
"""

from __future__ import annotations

from ..codegen.lazy_names import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)

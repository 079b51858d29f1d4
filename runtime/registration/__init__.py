"""Registration of models made of points, point pairs, lines, circles, planes and spheres (thesis chapter 5).

Each name is loaded when it is first used.
"""

from __future__ import annotations

from ..codegen.lazy_names import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)

"""Pictures of geometric objects, curves, motions and fields, with matplotlib in 3D; no window is needed.

`draw` takes any object of `cga3d` and `pga3d`, batches, lists and curves; `orbit`, `screw` and `twist_field` show what
bivectors do. matplotlib is imported by the first picture, and no global state of it is touched.
"""

from __future__ import annotations

from ..codegen.lazy_names import lazy_names
from ..common.deprecation import renamed_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
__getattr__ = renamed_names(__name__, __getattr__, skipped="count_skipped")

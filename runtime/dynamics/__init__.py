"""Statics, screws and rigid-body dynamics in CGA and PGA (thesis chapter 6).

Twists and wrenches are bivectors of `bladesmith.cga3d` or `pga3d`; each name is loaded when it is first used.
"""

from __future__ import annotations

from ..codegen.lazy_names import lazy_names
from ..common.deprecation import renamed_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
__getattr__ = renamed_names(__name__, __getattr__, recorded="as_record")

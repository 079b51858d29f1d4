"""Rigid poses: quaternions, matrices, rotation vectors and Euler angles to motors and back, and what poses do.

A pose is a motor of `bladesmith.pga3d`, or a batch of them. It takes the coordinates of a body's points to those of the
world. Twists are rows (w, v), angular first, as of `dynamics.twist`. Nothing here asks for geometric algebra.
"""

from __future__ import annotations

from ..codegen.lazy_names import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)

"""Frames of Jacobians of chains."""

from __future__ import annotations

from enum import IntEnum


class JacobianFrame(IntEnum):
    """Axes along which rotation and velocity are given, and the point whose velocity it is."""

    #: The world's axes, the point of the tool that is at the origin.
    ORIGIN = 0
    #: The world's axes, a point of the tool.
    POINT = 1
    #: The axes of the tool's frame, a point of the tool.
    TOOL = 2

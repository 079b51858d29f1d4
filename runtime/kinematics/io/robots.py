"""Robots from files by their suffix, and as models for reports: the chain to a tip, or the mechanism alone."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from ...codegen.errors import InputError
from ..task.mechanism_model import MechanismModel
from ..task.robot_model import ChainModel

if TYPE_CHECKING:
    from ..robots.robot import Robot

#: Suffixes of robots' files: URDF, SDF, MJCF.
SUFFIXES = (".urdf", ".sdf", ".xml", ".mjcf")


def load_robot(file: Path, mimic: str = "follow", ignore: Iterable[str] = ()) -> Robot:
    """A robot from a file; an .xml says by its root whether it is a URDF, an SDF or an MJCF."""
    from ..mjcf.reader import load_mjcf
    from ..robots.xml_text import XmlText, bytes_of
    from ..sdf.reader import load_sdf
    from ..urdf.reader import load_urdf

    kind = file.suffix.lower()
    if kind == ".xml":
        root = XmlText(str(file), bytes_of(file, "a robot")).document.tag
        kind = {"robot": ".urdf", "sdf": ".sdf"}.get(root, kind)
    load = {".urdf": load_urdf, ".sdf": load_sdf}.get(kind, load_mjcf)
    return load(file, mimic=mimic, ignore=ignore)


def robot_model(robot: Robot, tip: str | None = None, root: str | None = None) -> ChainModel | MechanismModel:
    """A robot and the chain to its tip, or its mechanism where no chain goes there.

    By default the root is that of the file, or of the largest part that floats, if the file's root holds nothing; the
    tip is the link with the most moving joints above it.
    """
    start = robot.largest_part if root is None else root
    try:
        end = robot.most_moved(start) if tip is None else tip
        return ChainModel(robot, robot.chain(end, start), end, start)
    except InputError:
        if tip is not None:
            raise
    return MechanismModel(robot.mechanism(root=start), ())

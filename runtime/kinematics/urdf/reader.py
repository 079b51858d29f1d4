"""Robots from URDF files."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from ...common.files import as_path
from ...common.validation import as_bool, as_choice
from ...mechanics.screws import geometry
from ..robots.description import on_base
from ..robots.robot import Robot
from ..robots.xml_text import bytes_of, ignored_names
from .elements import description_of
from .parser import MIMIC, Text

if TYPE_CHECKING:
    from ...core.multivector import Algebra


def load_urdf(
    path: str | os.PathLike[str],
    algebra: Algebra | None = None,
    *,
    mimic: str = "follow",
    ignore: Iterable[str] = (),
    strict: bool = False,
    impossible: str = "error",
    base: str = "fixed",
) -> Robot:
    """A robot from a URDF file.

    Parameters
    ----------
    path : str or path
    algebra : Algebra, optional
        `bladesmith.cga3d` (default) or `pga3d`.
    mimic : {"follow", "free", "error"}
        Joints that follow others: their coordinates are computed, they are independent joints, or they are refused.
    ignore : list of str
        Unknown tags and attributes that may be left out.
    strict : bool
        Refuse unknown attributes of limits, too, which are left out with a warning otherwise.
    impossible : {"error", "keep", "nearest"}
        Inertias that no body can have are an error where torques, accelerations or a system need them; or torques and
        accelerations are computed with them as they are; or the nearest possible ones are taken, with a warning.
    base : {"fixed", "floating"}
        Whether the root link is fixed, or moves: a joint "root_joint" that floats, whose coordinates come first, holds
        it to a link "world".

    Raises
    ------
    InputError
        With file, line and tag: no such file, not XML, a document type (entities are neither expanded nor fetched),
        elements nested too deep, duplicate names, missing parents or children, links that are not connected, loops,
        axes of length zero, numbers that are not finite, unknown types of joints and tags, joints that follow none or
        each other. Visuals, contacts, transmissions and tags for simulators are left out.
    """
    names, home = ignored_names(ignore), geometry(algebra)
    choice, refuses = as_choice(mimic, "mimic", MIMIC), as_bool(strict, "strict")
    file = as_path(path, "a URDF is loaded from")
    text = Text(str(file), bytes_of(file, "a URDF"), choice, names, refuses)
    return Robot(on_base(description_of(text), base), home, impossible)


def urdf_example(name: str) -> Path:
    """The path of a robot that comes with the package: "arm" (six axes) or "scara" (four)."""
    folder = Path(__file__).parent / "data"
    names = sorted(x.stem for x in folder.glob("*.urdf"))
    return folder / f"{as_choice(name, 'the robot', names)}.urdf"

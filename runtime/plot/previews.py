"""Small pictures beside the mathematics of objects in notebooks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..core.multivector import Multivector
from . import axes_setup, drawing
from .input_groups import group_items

if TYPE_CHECKING:
    from .matplotlib_import import Axes3D

#: Width and height in inches.
SIZE = (5.0, 3.75)
#: Most items of a batch that are drawn; of more, some at equal distances.
MOST_ITEMS = 200


def preview(thing: Any) -> Axes3D | None:
    """A small picture of an object, a batch or a curve; None where no item has one.

    Raises
    ------
    InputError
        If it is of an algebra, or of a kind, without pictures.
    MissingExtraError
        If matplotlib is not installed.
    """
    if isinstance(thing, Multivector):
        thing = thing.reshape(-1)
        thing = thing[:: -(-thing.size // MOST_ITEMS)] if thing.size > MOST_ITEMS else thing
        if not group_items(thing).groups:
            return None
    return drawing.draw(thing, ax=axes_setup.axes(size=SIZE))

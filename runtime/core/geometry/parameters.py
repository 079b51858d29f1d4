"""Parameters of geometric objects: named tuples with an orientation and a status."""

from __future__ import annotations

import sys
from collections import namedtuple
from typing import TYPE_CHECKING, Any, TypeVar

from numpy.typing import NDArray

from ...dispatch.multivector_data import Statuses


class Parameters(tuple[Any, ...]):
    """Named fields that a constructor takes, with ``orientation`` (+1 or -1) and ``status`` beside them."""

    orientation: NDArray[Any]
    status: Statuses

    if TYPE_CHECKING:  # names of fields depend on the kind of the object

        def __getattr__(self, field: str) -> NDArray[Any]: ...


#: Names of fields of all classes that were made.
FIELDS: set[str] = set()
P = TypeVar("P", bound=Parameters)


def parameters_class(name: str, *fields: str) -> type[Parameters]:
    """A named tuple that can carry attributes besides its fields."""
    FIELDS.update(fields)
    base = namedtuple(name, fields)  # type: ignore[misc]
    home = sys._getframe(1).f_globals["__name__"]  # where its name is: it can be pickled
    return type(name, (base, Parameters), {"__doc__": f"{name}: {', '.join(fields)}.", "__module__": home})


__all__ = ["FIELDS", "P", "Parameters", "parameters_class"]

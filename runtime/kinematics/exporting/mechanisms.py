"""A mechanism as a source file: poses of its bodies for coordinates of its driven joints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import prod
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ...codegen.export.bound import ExportedAlgorithm


def mechanism_items(
    algebra: str, room: int, given: Mapping[str, Any], work: Mapping[str, tuple[int, ...]], driven: Sequence[str],
    bodies: Sequence[str], name: str,
) -> list[ExportedAlgorithm]:  # fmt: skip
    """The function ``poses`` of a mechanism.

    Parameters
    ----------
    algebra, room
        As for `mechanism_matrices`.
    given : mapping
        Its tables.
    work : mapping
        Shapes of arrays to work in.
    driven, bodies : sequence of str
        Names of the driven joints in the order of their coordinates, and of the bodies that move.
    name : str
        Of the file.
    """
    from ...codegen.export.bound import Binding, bound_algorithms
    from ...codegen.library.kernels import stock_variant
    from ...codegen.programs.exported_robots import mechanism_matrices

    count = len(bodies)
    shapes = {"wanted": [len(driven)], "start": [count, 8], "motors": [count, 8], "matrices": [count, 16]}
    sizes = {("own" if key == "motors" else key): prod(shape) for key, shape in work.items()}
    listed = ", ".join(f"{k}: {body}" for k, body in enumerate(bodies))
    note = (
        f"wanted: coordinates of {', '.join(driven)}. start: motors of a pose near, 1 0 0 0 0 0 0 0 for each body "
        "where the mechanism stands as it was described. motors: those of the pose that was found, to start from next. "
        f"matrices: for each body ({listed}) 4 rows of 4, from where it stood to where it is, in the world. Returns 0 "
        "where the pose was found, 1 where it is not reached, 2 after too many steps, 3 where a number is not finite."
    )
    kernels = (stock_variant(algebra, name) for name in ("motor_to_matrix_motor", "sandwich_motor_motor"))
    function = mechanism_matrices(algebra, room, *kernels)
    return bound_algorithms(name, [Binding("poses", function, {**given, "goals": [0.0]}, shapes, sizes, (note,))])

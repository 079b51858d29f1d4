"""A serial chain as a source file: the pose of its tool, as a motor and as a matrix, and its Jacobian."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.algorithms.chain_frames import JacobianFrame

if TYPE_CHECKING:
    from ...codegen.export.bound import ExportedAlgorithm
    from ..serial.driver import ChainParameters

Array = NDArray[Any]


def chain_items(
    algebra: str, parameters: ChainParameters, names: Sequence[str], limits: Array, name: str
) -> list[ExportedAlgorithm]:
    """Functions ``motor``, ``matrix`` and ``jacobian`` of a chain.

    Parameters
    ----------
    algebra : str
    parameters : ChainParameters
    names : sequence of str
        Of the joints.
    limits : array (n, 2)
    name : str
        Of the file.
    """
    from ...codegen.export.bound import Binding, bound_algorithms
    from ...codegen.library.kernels import stock_variant
    from ...codegen.programs.chains import chain_function, class_of
    from ...codegen.programs.exported_robots import chain_matrix

    count = len(parameters.joints)
    room = class_of(count)
    given = {"joints": parameters.joints, "base": parameters.base, "frame": JacobianFrame.POINT, "point": np.zeros(3)}
    tool = {"frames": parameters.tool, "tool": parameters.tool}
    joints = "; ".join(
        f"{k}: {each}" + ("" if np.isinf([low, high]).all() else f" from {low:.6g} to {high:.6g}")
        for k, (each, (low, high)) in enumerate(zip(names, limits.tolist(), strict=True))
    )
    shapes = {"x": [count], "q": [count], "motors": [8], "matrix": [6, count]}
    pose = f"x: coordinates of the joints ({joints}). motors: the motor of the tool's frame in the world."
    matrix = "q: coordinates of the joints. matrix: 4 rows of 4, the tool's frame in the world."
    columns = (
        f"x: coordinates of the joints. matrix: 6 rows of {count}: angular velocity, then velocity of the tool's "
        "origin, along the world's axes, for a unit of each joint's speed."
    )
    functions = [
        ("motor", chain_function(algebra, room, "forward"), pose),
        ("matrix", chain_matrix(algebra, room, stock_variant(algebra, "motor_to_matrix_motor")), matrix),
        ("jacobian", chain_function(algebra, room, "jacobian"), columns),
    ]
    return bound_algorithms(
        name, [Binding(each, function, {**given, **tool}, shapes, notes=(note,)) for each, function, note in functions]
    )

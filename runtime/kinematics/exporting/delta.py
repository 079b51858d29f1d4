"""A Delta robot as a source file: kinematics both ways, and the Jacobians."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

if TYPE_CHECKING:
    from ...codegen.export.bound import ExportedAlgorithm, Table
    from ...codegen.ir.loops.nodes import Function
    from ...codegen.trace.kernel import Kernel

Array = NDArray[Any]
#: Functions of the file, and the kernel of each.
_KERNELS = {
    "inverse": "delta_inverse_numbers", "forward": "delta_forward_numbers",
    "inverse_jacobian": "delta_inverse_jacobian", "forward_jacobian": "delta_forward_jacobian",
}  # fmt: skip


def delta_items(parameters: Array, sides: Array, weights: Array, name: str) -> list[ExportedAlgorithm]:
    """Functions ``inverse``, ``forward``, ``inverse_jacobian`` and ``forward_jacobian`` of a Delta robot.

    Parameters
    ----------
    parameters : array (6,)
        Row of the robot's lengths.
    sides : array (3,)
        Signs of the elbows.
    weights : array (2,)
        The root.
    name : str
        Of the file.
    """
    from ...codegen.algebra.schema import load_spec, stock_spec_path
    from ...codegen.export.bound import bound_algorithm
    from ...codegen.export.kernel_functions import kernel_function
    from ...codegen.export.unit import kernel_notes
    from ...codegen.library.kernels import library_variants

    variants = library_variants(load_spec(stock_spec_path("cga3d")), [f"{start}*" for start in _KERNELS.values()])
    functions: dict[Kernel, Function] = {}
    tables: dict[str, Table] = {}
    items = []
    for function, start in _KERNELS.items():
        variant = next(v for v in variants if v.kernel.name.startswith(start))
        made = kernel_function(variant, functions)
        _, lengths, choice = (i.name for i in variant.kernel.inputs)
        given = {lengths: parameters, choice: weights if function.startswith("forward") else sides}
        notes = kernel_notes(variant)[1:]
        items.append(bound_algorithm(name, function, made, given, {}, notes=notes, tables_before=tables))
    return items

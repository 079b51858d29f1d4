"""A Delta robot as a source file: kinematics both ways, and the Jacobians."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from ...codegen.export.options import ExportOptions, describes_options
from ..delta.geometry import DeltaGeometry
from ..delta.solutions import elbow_signs, root_weights

if TYPE_CHECKING:
    from ...codegen.export.bound import ExportedAlgorithm
    from ...codegen.ir.loops.nodes import Function
    from ...codegen.trace.kernel import Kernel

Array = NDArray[Any]
#: Functions of the file, and the kernel of each.
_KERNELS = {
    "inverse": "delta_inverse_numbers", "forward": "delta_forward_numbers",
    "inverse_jacobian": "delta_inverse_jacobian", "forward_jacobian": "delta_forward_jacobian",
}  # fmt: skip


class ExportedDeltaRobot(DeltaGeometry):
    """The lengths of a Delta robot, which can be written as a source file."""

    @describes_options
    def export(
        self, language: str, folder: str | Path, name: str = "delta", *, elbow: Any = "outer", root: str = "far",
        dtype: str = "", split: bool = False, overwrite: bool = False,
    ) -> list[Path]:  # fmt: skip
        """Write the robot as a source file that needs nothing of this package; see :doc:`/algebra/export`.

        It has the functions ``inverse``, ``forward``, ``inverse_jacobian`` and ``forward_jacobian``, each with the code
        of a status, with the same bits as the methods.

        Parameters
        ----------
        {language}
        {folder}
        {name}
        elbow, root
            As in `inverse` and `forward`: the file has one posture.
        {dtype}
        {split}
        {overwrite}

        {files}

        Raises
        ------
        InputError
            If a choice is unknown.
            {refusals}
        """
        from ...codegen.export.export import export

        options = ExportOptions(language, name, dtype, split, overwrite, "a Delta robot")
        items = delta_items(self.parameters, elbow_signs(elbow), root_weights(root), name)
        return export(items, folder, options)


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
    from ...codegen.export.bound import Binding, bound_algorithms
    from ...codegen.export.kernel_functions import kernel_function
    from ...codegen.export.notes import kernel_notes
    from ...codegen.library.kernels import library_variants

    variants = library_variants(load_spec(stock_spec_path("cga3d")), [f"{start}*" for start in _KERNELS.values()])
    functions: dict[Kernel, Function] = {}
    bindings = []
    for function, start in _KERNELS.items():
        variant = next(v for v in variants if v.kernel.name.startswith(start))
        made = kernel_function(variant, functions)
        _, lengths, choice = (i.name for i in variant.kernel.inputs)
        given = {lengths: parameters, choice: weights if function.startswith("forward") else sides}
        notes = kernel_notes(variant)[1:]
        bindings.append(Binding(function, made, given, notes=notes))
    return bound_algorithms(name, bindings)

"""Kernels on other packages' arrays: those that serve NumPy arrays, as functions with derivatives.

A kernel of the package is called as it is; what its derivatives need is traced and compiled when they are asked for.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from ...codegen.algebra.algebra import Kind, numbers, scalar_argument
from ...codegen.api import KernelFunction
from ...codegen.declarations import formula_by_name
from ...codegen.errors import SignatureError
from ...codegen.trace.kernel import Output
from ..coefficients import broadcast, embed
from ..formulas import ArrayOperand, FormulaResult, ResolvedKernel, TieredKernel, resolve_kernel
from ..kernel_entries import Key, Result
from ..multivector_data import MultivectorData
from ..types import TypedAlgebra
from .backends import Backend
from .types import common_backend, rows_on, wrap

#: Products of more pairs of blades are not compiled: their code would be larger than the processor's cache.
MOST_PAIRS = 2048


def declared_kernel(algebra: TypedAlgebra, formula: str, found: ResolvedKernel) -> KernelFunction:
    """The kernel that evaluates a formula as a declared one; cached."""
    if isinstance(found.run, TieredKernel):
        kernel: KernelFunction = found.run.kernel
        return kernel
    key = "declared", formula, found.inputs
    if key not in algebra.targets:
        kinds = [key if isinstance(key, Kind) else _numbers(algebra, key) for key in found.inputs]
        name = formula.rpartition(".")[2]
        made = KernelFunction(formula_by_name(formula), kinds, None, name, algebra)
        made.adopt(found.run, [_output(algebra, o) for o in found.outputs])
        algebra.targets[key] = made
    kernel = algebra.targets[key]
    return kernel


def _numbers(algebra: TypedAlgebra, count: int) -> Kind:
    return numbers(algebra, count) if count else scalar_argument(algebra)


def _output(algebra: TypedAlgebra, result: Result) -> Output:
    kind = result.kind or numbers(algebra, result.size)
    return Output(result.name, kind, (), "status" if result.is_status else "value")


class ArrayBackend(Backend):
    """Formulas and products on the arrays of a package."""

    def evaluate(
        self, algebra: TypedAlgebra, formula: str, operands: Sequence[MultivectorData | ArrayOperand]
    ) -> FormulaResult:
        """`formulas.evaluate` where an operand holds an array of the package; items without an answer are NaN."""
        keys: tuple[Key, ...] = tuple(x.key if isinstance(x, ArrayOperand) else x.kind for x in operands)
        found = resolve_kernel(algebra, formula, keys)
        given = [
            self.floating(x.value, x.name)
            if isinstance(x, ArrayOperand)
            else rows_on(x, key if isinstance(key, Kind) else x.kind, self)
            for x, key in zip(operands, found.inputs, strict=True)
        ]
        results = self.function(declared_kernel(algebra, formula, found))(*given)
        items = results if isinstance(results, tuple) else (results,)
        return FormulaResult(
            tuple(
                value if output.kind is None else wrap(algebra, output.kind, value, self)
                for value, output in zip(items, found.outputs, strict=True)
                if not output.is_status
            ),
            None,
        )

    def product(self, formula: str, kind: Kind, a: Any, b: Any) -> Callable[[Any, Any], Any]:
        """The plan of a product of two multivectors, whose result has a kind.

        Raises
        ------
        InputError, SignatureError
            If the operands hold arrays of two packages, or have too many blades.
        """
        common_backend(a._type, b._type)
        if a._type.size * b._type.size > MOST_PAIRS:
            raise SignatureError(
                f"a product of {a._type.size} by {b._type.size} blades is too large for a kernel.",
                remedy="Use sparser multivectors: grades, or kinds",
            )

        def product(x: Any, y: Any) -> Any:
            broadcast(x, y)
            value = self.evaluate(x.algebra, formula, (x, y)).value
            return value if value.kind == kind else wrap(x.algebra, kind, embed(value, kind), self)

        return product

"""Declared formulas: their arguments are of known kinds, they are traced once, and algorithms can call them."""

from __future__ import annotations

from collections.abc import Sequence
from threading import RLock
from typing import Any

from ..algebra.algebra import Algebra, Kind, scalar_argument
from ..algebra.algebra import numbers as numbers_kind
from ..algebra.blades import shortened_identifier, validated_identifier
from ..errors import InputError, KindError, SignatureError, TraceError
from ..ir.loops.nodes import KernelSignature
from .derivatives import tangent_formula
from .kernel import Formula, Kernel, argument_names
from .reached_code import algebra_parts
from .rows import annotation
from .trace import trace

#: Longest row of plain numbers: each is a variable of the generated code.
MAX_ROW = 1024


class ScalarArgument:
    """Marks a plain number per item; the algebra comes from the kernel's other arguments."""


class RowArgument:
    """Marks a row of plain numbers per item."""

    def __init__(self, count: int) -> None:
        self.count = count


#: Declares an argument that is a plain number: an array of shape (...).
scalar = ScalarArgument()
Declared = Kind | ScalarArgument | RowArgument


def numbers(count: int) -> RowArgument:
    """Declare an argument that is a row of ``count`` numbers: an array of shape (..., count)."""
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= MAX_ROW:
        raise InputError(f"numbers({count!r}): a row has from 1 to {MAX_ROW} entries.")
    return RowArgument(count)


class DeclaredFormula:
    """A formula with the kinds of its arguments: traced once, and called by algorithms.

    Parameters
    ----------
    formula, declared, returns, name, algebra
        As for `kernel`.
    arguments : sequence of str, optional
        Names of the arguments; default: the formula's.
    like : Kernel, optional
        The kernel that this one is the derivative of: results have its layouts, where they suffice.
    """

    def __init__(
        self,
        formula: Formula,
        declared: Sequence[Declared],
        returns: Kind | None,
        name: str,
        algebra: Algebra | None,
        arguments: Sequence[str] | None = None,
        like: Kernel | None = None,
    ) -> None:
        home = algebra or next((k.algebra for k in declared if isinstance(k, Kind)), None)
        if home is None:
            raise TraceError(
                f"{name} has no multivector argument; say which algebra it belongs to, for example "
                "algebra=bladesmith.cga3d."
            )
        self.formula = formula
        self.kinds = tuple(_kind(k, home, name) for k in declared)
        self.returns = returns
        self.like = like
        self.name = name
        self.algebra = home
        self.arguments = list(arguments or argument_names(formula))
        try:
            validated_identifier(name, "a kernel's name")
        except SignatureError as error:
            raise TraceError(error.what, remedy="Give it one, name=...") from None
        if len(self.arguments) != len(self.kinds):
            raise TraceError(
                f"{name} takes {len(self.arguments)} arguments ({', '.join(self.arguments) or 'none'}), but "
                f"{len(self.kinds)} kinds were declared."
            )
        if not self.arguments:
            raise TraceError(f"{name} has no arguments: it is a constant and needs no kernel.")
        self.__doc__ = formula.__doc__
        self.__name__ = name
        self._tangents: dict[tuple[str, ...], DeclaredFormula] = {}
        self._lock = RLock()
        self._traced: Kernel | None = None

    @property
    def traced(self) -> Kernel:
        """The kernel's expression graph, made once."""
        if self._traced is None:
            with self._lock:
                if self._traced is None:
                    self._traced = trace(
                        self.formula,
                        self.kinds,
                        self.name,
                        self.returns,
                        self.algebra,
                        arguments=self.arguments,
                        like=self.like,
                    )
        return self._traced

    def declared_parts(self) -> list[Any]:
        """What it is traced from: see `reached_text`."""
        is_row = any(kind.form == "numbers" for kind in self.kinds)
        hints = [annotation(self.formula, name) for name in self.arguments] if is_row else None
        like = self.like and [(o.kind, o.role) for o in self.like.outputs]
        home = algebra_parts(self.algebra)
        return [self.formula, self.kinds, self.returns, self.name, home, self.arguments, like, hints]

    # -- in algorithms -------------------------------------------------------------------------------------

    is_callable_in_algorithms = True

    @property
    def kernel_signature(self) -> KernelSignature:
        """What algorithms call."""
        return self.traced.signature(self)

    def tangent_signature(self, varying: tuple[str, ...]) -> KernelSignature:
        """What derivatives of algorithms call: the tangents of the results, from the inputs and directions of some."""
        found = self._tangents.get(varying)
        if found is None:
            found = self._tangents[varying] = self._tangent_kernel(varying)
        return found.kernel_signature

    def _tangent_kernel(self, varying: tuple[str, ...]) -> DeclaredFormula:
        constant = [name for name in self.arguments if name not in varying]
        whole = tangent_formula(self.formula, self.formula.__module__, constant)

        def tangents(*arguments: Any) -> Any:
            results = whole(*arguments)
            return tuple(results[len(results) // 2 :])

        tangents.__doc__ = f"Tangents of {self.name}."
        order = [name for name in self.arguments if name in varying]
        by_name = dict(zip(self.arguments, self.kinds, strict=True))
        free = {n: k if k.form == "numbers" or k.is_scalar_argument else k.layout for n, k in by_name.items()}
        kinds = [free[n] if n in varying else k for n, k in by_name.items()]
        names = [*self.arguments, *(f"d_{n}" for n in order)]
        name = shortened_identifier(f"{self.name}_along_{'_'.join(order)}")
        declared = [*kinds, *(free[n] for n in order)]
        return type(self)(tangents, declared, None, name, self.algebra, names, self.traced)


def _kind(declared: Declared, algebra: Algebra, name: str) -> Kind:
    if isinstance(declared, Kind):
        return declared
    if isinstance(declared, ScalarArgument):
        return scalar_argument(algebra)
    if isinstance(declared, RowArgument):
        return numbers_kind(algebra, declared.count)
    raise KindError(f"{name}: {declared!r} is not a kind; use algebra.kind(), algebra.layout() or codegen.scalar.")

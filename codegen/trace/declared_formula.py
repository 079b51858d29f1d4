"""Declared formulas: their arguments are of known kinds, they are traced once, and algorithms can call them."""

from __future__ import annotations

from collections.abc import Sequence
from threading import RLock
from typing import Any, Self

from ..algebra.algebra import Algebra, Kind, scalar_argument
from ..algebra.algebra import numbers as numbers_kind
from ..algebra.blades import shortened_identifier, validated_identifier
from ..errors import InputError, KindError, SignatureError, TraceError, one_line
from ..ir.graph import Node
from ..ir.loops.nodes import KernelSignature
from .derivatives import directions_of, restricted, tangent_formula, unused
from .kernel import Formula, Kernel, Output, argument_names, value_layouts
from .pullbacks import inlined, pullback_formula, roots_like
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
    layouts : sequence of Kind, optional
        Of the results of a derivative, where they suffice.
    """

    def __init__(
        self,
        formula: Formula,
        declared: Sequence[Declared],
        returns: Kind | None,
        name: str,
        algebra: Algebra | None,
        arguments: Sequence[str] | None = None,
        layouts: Sequence[Kind] = (),
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
        self.layouts = tuple(layouts)
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
        self.__module__ = formula.__module__
        self._derived: dict[tuple[str, ...], Self] = {}
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
                        layouts=self.layouts,
                    )
        return self._traced

    def __reduce__(self) -> str:
        """Pickled as functions are: by module and name."""
        return str(getattr(self.formula, "__qualname__", self.name))

    def declared_parts(self) -> list[Any]:
        """What it is traced from: see `reached_text`."""
        is_row = any(kind.form == "numbers" for kind in self.kinds)
        hints = [annotation(self.formula, name) for name in self.arguments] if is_row else None
        home = algebra_parts(self.algebra)
        return [self.formula, self.kinds, self.returns, self.name, home, self.arguments, self.layouts, hints]

    # -- in algorithms -------------------------------------------------------------------------------------

    is_callable_in_algorithms = True

    @property
    def kernel_signature(self) -> KernelSignature:
        """What algorithms call."""
        return self.traced.signature(self)

    def tangent_signature(self, varying: tuple[str, ...]) -> KernelSignature:
        """What derivatives of algorithms call: the tangents of the results, from the inputs and directions of some."""
        return self.along(varying).kernel_signature

    def pullback_signature(self, varying: tuple[str, ...]) -> KernelSignature:
        """What reverse derivatives of algorithms call: cotangents of some inputs, from those of the values."""
        return self.pullback(*varying).kernel_signature

    # -- derivatives ---------------------------------------------------------------------------------------

    @property
    def outputs(self) -> tuple[Output, ...]:
        """What it returns."""
        return self.traced.outputs

    @property
    def forms(self) -> tuple[Node, ...]:
        """Nodes of the outputs, in the form that is printed."""
        return self.traced.roots

    def along(self, varying: Sequence[str], within: bool = False) -> Self:
        """The tangents of the values: the same arguments, then a direction of each that varies.

        ``within``: on the blades of the values alone. A direction that breaks a kind's constraints may lead to others.
        """
        key = "within" if within else "along", *varying
        if key not in self._derived:
            self._derived[key] = self._tangent_kernel(varying, within)
        return self._derived[key]

    def pullback(self, *wrt: str) -> Self:
        """Reverse derivative: a kernel of the same arguments, then of a cotangent of each value.

        Parameters
        ----------
        *wrt : str
            Arguments whose cotangents it returns; default: all.

        Returns
        -------
        KernelFunction
            Its results have the blades of the arguments. Cotangents are ordinary arguments, called
            ``<output>_bar``: it has derivatives of its own.

        Raises
        ------
        TraceError
            If there is no such argument.
        """
        wrt = wrt or tuple(self.arguments)
        for name in wrt:
            if name not in self.arguments:
                raise TraceError(f"{self.name} has no argument {one_line(name)}; it has: {', '.join(self.arguments)}.")
        key = "pullback", *wrt
        if key not in self._derived:
            self._derived[key] = self._pullback_kernel(wrt)
        return self._derived[key]

    def _pullback_kernel(self, wrt: Sequence[str]) -> Self:
        layouts = value_layouts(self.outputs)
        free = [_free(kind) for kind in self.kinds]
        forward = type(self)(
            inlined(self.formula), free, None, self.name, self.algebra, self.arguments, layouts
        )  # fmt: skip

        def roots() -> Sequence[Sequence[Node | None]]:
            return roots_like(forward.traced, forward.forms, layouts)

        places = [self.arguments.index(name) for name in wrt]
        formula = pullback_formula(roots, self.kinds, layouts, places)
        formula.__doc__ = f"Reverse derivative of {self.name}."
        names = list(self.arguments)
        for output in self.outputs:
            if output.role != "status":
                names.append(unused(f"{output.name}_bar", names))
        suffix = "" if len(wrt) == len(self.arguments) else f"_{'_'.join(wrt)}"
        name = shortened_identifier(f"{self.name}_vjp{suffix}")
        return type(self)(
            formula, [*self.kinds, *layouts], None, name, self.algebra, names, [free[i] for i in places]
        )  # fmt: skip

    def _tangent_kernel(self, varying: Sequence[str], within: bool) -> Self:
        constant = [name for name in self.arguments if name not in varying]
        layouts = value_layouts(self.outputs)
        whole = tangent_formula(self.formula, self.formula.__module__, constant, self.arguments)

        def tangents(*arguments: Any) -> Any:
            results = whole(*arguments)
            found = tuple(results[len(results) // 2 :])
            return tuple(map(restricted, found, layouts)) if within else found

        tangents.__doc__ = f"Tangents of {self.name}."
        tangents.__annotations__ = whole.__annotations__
        order = [name for name in self.arguments if name in varying]
        by_name = dict(zip(self.arguments, self.kinds, strict=True))
        kinds = [_free(k) if n in varying else k for n, k in by_name.items()]
        names = [*self.arguments, *directions_of(order, self.arguments)]
        name = shortened_identifier(f"{self.name}_{'within' if within else 'along'}_{'_'.join(order)}")
        declared = [*kinds, *(_free(by_name[n]) for n in order)]
        return type(self)(tangents, declared, None, name, self.algebra, names, layouts)


def _free(kind: Kind) -> Kind:
    """The kind with nothing known of its coefficients."""
    return kind.layout if kind.form == "multivector" else kind


def _kind(declared: Declared, algebra: Algebra, name: str) -> Kind:
    if isinstance(declared, Kind):
        return declared
    if isinstance(declared, ScalarArgument):
        return scalar_argument(algebra)
    if isinstance(declared, RowArgument):
        return numbers_kind(algebra, declared.count)
    raise KindError(f"{name}: {declared!r} is not a kind; use algebra.kind(), algebra.layout() or codegen.scalar.")

"""A declared formula that runs: its stages, each made on first use, and its calls on arrays and multivectors."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from numbers import Integral
from typing import Any, Literal

import numpy as np

from ..algebra.algebra import Algebra, Kind
from ..algebra.multivector import Multivector
from ..autodiff.calls import check_count, coefficients, rows_of
from ..compiler import as_written, bind_kernel, compile_declared, optimise_quickly, print_source
from ..errors import CompilerMissingError, InputError, ShapeError, TraceError, one_line
from ..execute.arrays import native_array
from ..execute.bound_kernels import BoundKernel
from ..execute.reductions.sums import run_sums, sum_items
from ..ir.graph import Graph, Node
from ..ir.loops.language import runs_as_python
from ..ir.loops.nodes import KernelSignature
from ..optimise.variants import Operations, Variant
from ..rings.protocol import NumericRing, PrecisionRing
from ..trace.calls import call_in_graph
from ..trace.declared_formula import Declared, DeclaredFormula
from ..trace.kernel import Formula, Output, coefficient_name
from ..trace.outputs import as_outputs

#: Where a kernel can run: compiled C, numba, a CUDA device, or the numba text on NumPy columns.
TARGETS = ("c", "numba", "cuda", "numpy")
#: The precision to which references are computed at most.
MOST_DIGITS = 10_000
_log = logging.getLogger("bladesmith")


class CompiledKernel(DeclaredFormula):
    """A declared formula that is compiled when it is first called.

    Parameters
    ----------
    formula, declared, returns, name, algebra, arguments, layouts
        As for `DeclaredFormula`.
    search : bool
        False: the kernel is printed as its formula is written, and nothing is searched.
    reduce : {"sum"}, optional
        What a call does with the results of all items.
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
        search: bool = True,
        reduce: Literal["sum"] | None = None,
    ) -> None:
        super().__init__(formula, declared, returns, name, algebra, arguments, layouts)
        self.search = search
        self.reduce = reduce
        self._bound: dict[tuple[str, str], Any] = {}
        self._variant: Variant | None = None
        self._pair: Callable[[Any, Any], Any] | None = None
        self._outputs: tuple[Output, ...] = ()  # known without tracing, where the kernel was in the cache

    def declared_parts(self) -> list[Any]:
        """What it is traced and selected from."""
        return [*super().declared_parts(), self.search]

    # -- stages --------------------------------------------------------------------------------------------

    @property
    def variant(self) -> Variant:
        """The variant that is printed: selected by a quick search, once."""
        if self._variant is None:
            with self._lock:
                if self._variant is None:
                    kernel = self.traced
                    self._variant = optimise_quickly(kernel) if self.search else as_written(kernel)
        return self._variant

    @property
    def outputs(self) -> tuple[Output, ...]:
        """What it returns; not traced, where it was compiled before."""
        return self._outputs or super().outputs

    @property
    def forms(self) -> tuple[Node, ...]:
        """Nodes of the outputs, in the form that is printed."""
        return self.variant.roots

    @property
    def operations(self) -> Operations:
        """Operation counts of the selected variant."""
        return self.variant.operations

    @property
    def expr(self) -> list[Any]:
        """The outputs' coefficients as SymPy expressions in symbols like ``m_e12``, unexpanded; one list per output."""
        import sympy

        from ..rings.sympy_ring import SymbolicRing

        kernel = self.traced
        names = [coefficient_name(i, j) for i in kernel.inputs for j in range(i.kind.size)]
        return kernel.evaluate_flat([sympy.Symbol(name, real=True) for name in names], SymbolicRing())

    def source(self, target: str = "c") -> str:
        """Source text for "c", "numba" or "cuda"."""
        return print_source([self.variant], target)

    def adopt(self, compiled: Any, outputs: Sequence[Output]) -> None:
        """Run by what was compiled of this formula before, with these outputs: nothing is traced for a call."""
        self._bound = {("c", "f64"): compiled, ("c", "f32"): compiled}
        self._outputs = tuple(outputs)

    # -- calls ---------------------------------------------------------------------------------------------

    def __call__(self, *arguments: Any, **by_name: Any) -> Any:
        if by_name:
            arguments = self._positional(arguments, by_name)
        if self._pair is not None and len(arguments) == 2:
            result = self._pair(arguments[0], arguments[1])
            if result is not None:
                return result
        if any(isinstance(a, Multivector) for a in arguments):
            return self._in_formula(arguments)
        if runs_as_python():
            return self.traced.on_numbers_in_use(arguments)
        return self._run("c", arguments)

    def _run(self, target: str, arguments: Sequence[Any]) -> Any:
        arrays, owner = self._arrays(arguments)
        bound = self.bound(target, arrays)
        if self.reduce:
            return self._wrap(_as_returned(run_sums(bound, arrays)[0], self.outputs), owner, is_proved=False)
        try:
            results = bound(*arrays)
        except ShapeError:
            self._check_axes(arrays)
            raise
        return self._wrap(results, owner, self._is_proved(arguments))

    def _check_axes(self, arrays: Sequence[Any]) -> None:
        """Raise if an array has not the coefficients of its kind, with what makes one."""
        rows_of(self, [np.asarray(a) for a in arrays])

    def _positional(self, arguments: Sequence[Any], by_name: Mapping[str, Any]) -> tuple[Any, ...]:
        rest = self.arguments[len(arguments) :]
        if set(by_name) != set(rest):
            raise InputError(f"{self.name} takes the arguments {', '.join(self.arguments)}, each once.")
        return (*arguments, *(by_name[name] for name in rest))

    def on(self, target: str) -> Callable[..., Any]:
        """The kernel on one target: "c", "numba", "cuda", or "numpy" (the same text on columns, not compiled)."""

        if target not in TARGETS:
            raise InputError(f"there is no target {target!r}; choose one of {', '.join(TARGETS)}.")

        def call(*arguments: Any) -> Any:
            return self._run(target, arguments)

        return call

    def plan(self, *arguments: Any) -> Any:
        """A call with its arrays bound: ``p = k.plan(a, b); p(); p.results``."""
        self._check_items("a plan's result")
        arrays, _ = self._arrays(arguments)
        kernel = self.bound("c", arrays)
        if not isinstance(kernel, BoundKernel):
            from ..build.toolchain import REMEDY, missing_compiler

            raise missing_compiler("a plan calls compiled C", f"{REMEDY}, or call the kernel itself")
        return kernel.plan(*arrays)

    def reference(self, *arguments: Any, digits: int | None = None) -> Any:
        """The formula itself on numbers, never a compiled kernel.

        With ``digits`` given, one item, or the sum of all, is computed with mpmath numbers of that precision and
        returned as lists.
        """
        arrays, owner = self._arrays(arguments)
        lead = np.broadcast_shapes(*(self._lead(a, k) for a, k in zip(arrays, self.kinds, strict=True)))
        if digits is not None:
            if not isinstance(digits, Integral) or isinstance(digits, bool) or not 1 <= digits <= MOST_DIGITS:
                raise InputError(f"digits is {one_line(digits)}; a whole number from 1 to {MOST_DIGITS} is needed.")
            values = self._precise_items(arrays, lead if self.reduce else (), digits)
            return values[0] if len(values) == 1 else values
        columns = [
            [a] if k.is_scalar_argument else [a[..., j] for j in range(k.size)]
            for a, k in zip(arrays, self.kinds, strict=True)
        ]
        results = self.traced.reference(NumericRing(arrays[0].dtype), columns)
        stacked = tuple(np.stack([np.broadcast_to(v, lead) for v in r], -1) for r in results)
        if self.reduce:
            stacked = tuple(sum_items(rows.reshape(-1, rows.shape[-1])) for rows in stacked)
        is_proved = not self.reduce and self._is_proved(arguments)
        return self._wrap(stacked[0] if len(stacked) == 1 else stacked, owner, is_proved)

    def _precise_items(self, arrays: Sequence[Any], lead: tuple[int, ...], digits: int) -> list[list[Any]]:
        """The sum over the items of a leading shape, with mpmath numbers; of one item where there is none."""
        precise = PrecisionRing(digits)
        sizes = [k.size for k in self.kinds]
        rows = [
            np.broadcast_to(np.reshape(a, (*(self._lead(a, k) if lead else ()), k.size)), (*lead, k.size))
            for a, k in zip(arrays, self.kinds, strict=True)
        ]
        items = zip(*(row.reshape(-1, size) for row, size in zip(rows, sizes, strict=True)), strict=True)
        totals = [[precise.context.mpf(0)] * len(o.nodes) for o in self.traced.outputs]
        for item in items:
            found = self.traced.reference(precise, [[precise.context.mpf(float(v)) for v in row] for row in item])
            totals = [[a + b for a, b in zip(*pair, strict=True)] for pair in zip(totals, found, strict=True)]
        return totals

    def _lead(self, array: Any, kind: Kind) -> tuple[int, ...]:
        return tuple(array.shape if kind.is_scalar_argument else array.shape[:-1])

    def bound(self, target: str, arrays: Sequence[Any]) -> Any:
        """The compiled function for the precision of ``arrays``, made on first use."""
        single = all(getattr(a, "dtype", None) == np.float32 for a in arrays)
        key = (target, "f32" if single else "f64")
        with self._lock:
            if key in self._bound:
                return self._bound[key]
            self._bound[key] = made = self._compile(target, key[1])
            if key == ("c", "f64") and not self.reduce and isinstance(made, BoundKernel) and made.is_pair:
                self._pair = made.pair
        return self._bound[key]

    def _compile(self, target: str, precision: str) -> Any:
        if target == "c":
            try:
                made, self._outputs = compile_declared(self, lambda: self.variant, precision)
                return made
            except CompilerMissingError as error:
                target = "numba" if _has_numba() else "numpy"
                _log.warning("%s runs by %s: %s.", self.name, target, error.what)
        return bind_kernel(self.variant, target)

    def _check_items(self, where: str) -> None:
        """Refuse a kernel whose result is a sum where one result of each item is needed."""
        if self.reduce:
            raise TraceError(
                f"{self.name} sums over all items, and {where} is that of single ones.",
                remedy="Declare the same formula once more, without reduce",
            )

    @property
    def kernel_signature(self) -> KernelSignature:
        """What algorithms call."""
        self._check_items("what an algorithm calls")
        return super().kernel_signature

    def _in_formula(self, arguments: Sequence[Any]) -> Any:
        self._check_items("what a formula calls")
        first = next(a for a in arguments if isinstance(a, Multivector))
        if not isinstance(first.ring, Graph):
            results = [r.values if r.is_row else r.value for r in as_outputs(self.formula(*arguments))]
            return results[0] if len(results) == 1 else tuple(results)
        return call_in_graph(self.traced, first.ring, arguments)

    def _arrays(self, arguments: Sequence[Any]) -> tuple[list[Any], Any]:
        """Arrays of coefficients in the declared order, and the algebra that wraps the results (or None)."""
        check_count(self, arguments)
        owner, arrays = None, []
        for value, kind, argument in zip(arguments, self.kinds, self.arguments, strict=True):
            if hasattr(value, "as_kind"):
                arrays.append(coefficients(self.name, value, kind, argument))
                owner = owner or value.algebra
            else:
                arrays.append(native_array(value, argument))
        dtypes = {a.dtype for a in arrays}
        if dtypes != {np.dtype(np.float32)}:  # numbers of any type become double, unless everything is single
            floats = {a.dtype for a, k in zip(arrays, self.kinds, strict=True) if not k.is_scalar_argument}
            if floats == {np.dtype(np.float32)}:
                arrays = [a.astype(np.float32) for a in arrays]
        return arrays, owner

    def _is_proved(self, arguments: Sequence[Any]) -> bool:
        """Return whether the arguments are known to be of their kinds: arrays of coefficients are not."""
        return all(k.is_layout or hasattr(a, "as_kind") for a, k in zip(arguments, self.kinds, strict=True))

    def _wrap(self, results: Any, owner: Any, is_proved: bool) -> Any:
        if owner is None:
            return results
        items = results if isinstance(results, tuple) else (results,)
        outputs = self.outputs
        codes = next((v for v, o in zip(items, outputs, strict=True) if o.role == "status"), None)
        values = [
            v if o.kind.form != "multivector" else owner.wrap(o.kind if is_proved else o.kind.layout, v, codes)
            for v, o in zip(items, outputs, strict=True)
            if o.role != "status"
        ]
        return values[0] if len(values) == 1 else tuple(values)

    def __repr__(self) -> str:
        kinds = ", ".join(f"{n}: {k.name}" for n, k in zip(self.arguments, self.kinds, strict=True))
        return f"<kernel {self.name}({kinds})>"


def _as_returned(results: Sequence[Any], outputs: Sequence[Output]) -> Any:
    """One value, or several and statuses."""
    return results[0] if len(results) == 1 and outputs[0].role != "status" else tuple(results)


def _has_numba() -> bool:
    from importlib.util import find_spec

    return find_spec("numba") is not None

"""Derivatives of kernels, which are kernels: forward, along directions; reverse, from cotangents; all partial ones."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Self

import numpy as np

from ..algebra.blades import shortened_identifier
from ..autodiff.calls import check_count
from ..autodiff.cotangents import cotangent_rows, run_summed
from ..errors import InputError
from ..execute.arrays import broadcast_leads
from ..trace.derivatives import derivative_formula, derivative_kinds, jacobian_formula
from ..trace.kernel import value_layouts
from .compiled import CompiledKernel


class DifferentiableKernel(CompiledKernel):
    """A kernel with its derivatives; `pullback` is that of every declared formula."""

    def derivative(self, wrt: str) -> Self:
        """Forward derivative with respect to one argument.

        For a number: the same arguments. For a multivector: the derivative along one more argument, ``d_<wrt>``
        (same blades). The result has the blades of the value, where they suffice. It is traced without the
        constraints of ``wrt``, so any direction is good.
        """
        names, kinds = derivative_kinds(self.arguments, self.kinds, wrt)
        is_scalar = self.kinds[self.arguments.index(wrt)].is_scalar_argument
        formula = derivative_formula(self.formula, self.arguments, wrt, is_scalar)
        formula.__doc__ = f"Derivative of {self.name} with respect to {wrt}."
        name = shortened_identifier(f"{self.name}_d_{wrt}")
        layouts = value_layouts(self.outputs)
        return type(self)(formula, kinds, None, name, self.algebra, names, layouts, reduce=self.reduce)

    def vjp(self, *inputs: Any) -> Callable[..., tuple[Any, ...]]:
        """Reverse derivative at some inputs.

        Parameters
        ----------
        *inputs
            As for a call.

        Returns
        -------
        callable
            Takes a cotangent of each value (statuses have none), of its shape or one that broadcasts to it (of values
            of one number also of the items' shape, or a number), and returns a tuple with one of each input, of its
            shape: what was broadcast has the sum over the items that share it.
            It reads the inputs when it is called: an array that has changed since then is another input.
            Cotangents are coefficients beside coefficients, in the kinds' order: the change of the paired sum when a
            coefficient changes, the others kept, whatever a kind's constraints say. NaN where there is no value.
        """
        check_count(self, inputs)
        return partial(self._pulled_back, inputs)

    def _pulled_back(self, inputs: Sequence[Any], *cotangents: Any) -> tuple[Any, ...]:
        pullback, count = self.pullback(), len(self.kinds)
        wanted = len(pullback.kinds) - count
        if len(cotangents) != wanted:
            raise InputError(f"the reverse derivative of {self.name} takes {wanted} cotangents, one of each value.")
        single = all(getattr(x, "dtype", None) == np.float32 for x in inputs)
        given = [np.float32(c) if single and isinstance(c, int | float) else c for c in cotangents]
        arrays, owner = pullback._arrays((*inputs, *given))
        self._check_axes(arrays[:count])
        leads = [self._lead(a, k) for a, k in zip(arrays[:count], self.kinds, strict=True)]
        lead = () if self.reduce else broadcast_leads(leads, self.name)
        values = [o for o in self.outputs if o.role != "status"]
        arrays[count:] = [
            cotangent_rows(a, o.kind, lead, f"{self.name}: the cotangent of {o.name if wanted > 1 else 'the result'}")
            for a, o in zip(arrays[count:], values, strict=True)
        ]
        results = run_summed(pullback.bound("c", arrays), arrays, leads)
        return tuple(
            r[..., 0] if k.is_scalar_argument else owner.wrap(k.layout, r) if owner and k.form == "multivector" else r
            for r, k in zip(results, self.kinds, strict=True)
        )

    def jacobian(self, wrt: str) -> Self:
        """All partial derivatives with respect to the coefficients of one argument.

        The same arguments; the result is a row of numbers for each result that is no status, the derivatives of one of
        its coefficients beside each other: ``k.jacobian("x")(x).reshape(..., outputs, inputs)``. It is traced without
        the constraints of ``wrt``.
        """
        names, kinds = derivative_kinds(self.arguments, self.kinds, wrt, rows=True)
        kind = self.kinds[self.arguments.index(wrt)]
        blades = [None if o.kind.form == "numbers" else o.kind.blades for o in self.outputs if o.role != "status"]
        formula = jacobian_formula(self.formula, self.arguments, wrt, kind, blades)
        formula.__doc__ = f"Derivatives of {self.name} with respect to the coefficients of {wrt}."
        count = len(self.arguments)
        name = shortened_identifier(f"{self.name}_jacobian_{wrt}")
        return type(self)(formula, kinds[:count], None, name, self.algebra, names[:count], reduce=self.reduce)

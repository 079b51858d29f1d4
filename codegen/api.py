"""`@kernel`: a formula becomes a function that is compiled when it is first called.

Called with arrays or runtime multivectors it runs compiled code; inside another formula it becomes a call
of the kernel; on numeric or exact multivectors it is the formula itself. How it runs and its derivatives are in
`kernels`; here it is declared, and handed on to other languages and packages.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Literal

from .algebra.algebra import Algebra, Kind
from .errors import InputError, TraceError, needed
from .export.options import ExportOptions, describes_options, source_of
from .kernels.compiled import TARGETS as TARGETS
from .kernels.differentiable import DifferentiableKernel
from .trace.declared_formula import Declared
from .trace.kernel import Formula

#: Where a package for gradients is not installed.
_WITH_NUMPY = "The kernel's vjp gives reverse derivatives with NumPy alone: kernel.vjp(x)(cotangent)"


def kernel(
    *kinds: Declared,
    returns: Kind | None = None,
    name: str | None = None,
    algebra: Algebra | None = None,
    reduce: Literal["sum"] | None = None,
) -> Callable[[Formula], KernelFunction]:
    """Declare a kernel: a decorator for a formula in GA notation.

    Parameters
    ----------
    *kinds : Kind, `scalar` or `numbers(n)`
        One for each argument of the formula. ``algebra.kind("circle")`` knows the constraints of a unit circle,
        ``algebra.layout("circle")`` only its blades.
    returns : Kind, optional
        Kind of the result, proved when the kernel is traced. Default: the narrowest kind that is proved.
    name : str, optional
        Name in generated code; default: the function's.
    algebra : Algebra, optional
        Needed only where no argument is a multivector.
    reduce : {"sum"}, optional
        The results are summed over all items of a call: a loss. See `execute.reductions.sums` for the error.

    Raises
    ------
    InputError
        If ``reduce`` is something else, or ``returns`` is promised of a sum.
    TraceError
        When the kernel is first used, if the formula cannot be traced or ``returns`` does not hold.

    Examples
    --------
    >>> from bladesmith import codegen, cga3d as cga
    >>> @codegen.kernel(cga.kind("motor"), cga.kind("point"))
    ... def move(m, x):
    ...     return m * x * ~m
    """

    if len(kinds) == 1 and callable(kinds[0]):
        raise TraceError("write @codegen.kernel(kind, ...) with the kind of each argument, not @codegen.kernel alone.")

    def decorate(formula: Formula) -> KernelFunction:
        return KernelFunction(formula, kinds, returns, name or formula.__name__, algebra, reduce=reduce)

    if reduce not in (None, "sum"):
        raise InputError(f'reduce is {reduce!r}; it is "sum", or left out.')
    if reduce and returns is not None and not returns.is_layout:
        raise InputError(f"a sum of {returns.name}s is none; leave out returns, or reduce.")
    return decorate


class KernelFunction(DifferentiableKernel):
    """A declared kernel; see `kernel`."""

    _jax: Callable[..., Any] | None = None
    _torch: Callable[..., Any] | None = None

    @describes_options
    def export(
        self, language: str, folder: str | Path, *, name: str = "", dtype: str = "", derivatives: Sequence[str] = (),
        jacobians: Sequence[str] = (), split: bool = False, overwrite: bool = False,
    ) -> list[Path]:  # fmt: skip
        """Write the kernel as a source file that needs nothing of this package; see :doc:`/algebra/export`.

        Parameters
        ----------
        {language}
        {folder}
        {name}
            Default: the kernel's.
        {dtype}
        derivatives, jacobians : sequence of str, optional
            Arguments with respect to which the forward derivative, or all partial derivatives are exported, too.
        {split}
        {overwrite}

        {files}

        Raises
        ------
        InputError
            {refusals}
        TraceError
            If the kernel sums over items, has no such argument, or cannot be traced.
        """
        from .export.export import export

        source = source_of(self.formula, self.name)
        options = ExportOptions(language, name or self.name, dtype, split, overwrite, source)
        self._check_items("what is exported")
        for option, given in (("derivatives", derivatives), ("jacobians", jacobians)):
            if isinstance(given, str) or not isinstance(given, Sequence):
                raise InputError(f"{option} is a list of arguments, such as {option}={[str(given)]}.")
        along, partial = dict.fromkeys(derivatives), dict.fromkeys(jacobians)
        functions = [self, *map(self.derivative, along), *map(self.jacobian, partial)]
        return export([f.variant for f in functions], folder, options)

    def jax(self) -> Callable[..., Any]:
        """The kernel as a function of JAX arrays, for `jit`, `vmap` and derivatives of any order, forward and reverse.

        It takes arrays as a call does, of float32 or float64, and returns arrays: one, or a tuple with those of
        statuses. A call of compiled code on the host: XLA calls it directly, without copies and without Python.

        Raises
        ------
        MissingExtraError
            If JAX is not installed.
        """
        if self._jax is None:
            with needed("jax", "A function of JAX arrays", _WITH_NUMPY):
                from .autodiff.jax_kernels import jax_function
            self._jax = jax_function(self)
        return self._jax

    def torch(self) -> Callable[..., Any]:
        """The kernel as a function of PyTorch tensors, for gradients of any order: a custom operator.

        It takes tensors on the host as a call does, of float32 or float64, and returns tensors: one, or a tuple with
        those of statuses. Tensors are passed without copies where they are contiguous.

        Raises
        ------
        MissingExtraError
            If PyTorch is not installed.
        """
        if self._torch is None:
            with needed("torch", "A function of PyTorch tensors", _WITH_NUMPY):
                from .autodiff.torch_kernels import torch_function
            self._torch = torch_function(self)
        return self._torch

"""The kernels of a spec, compiled for the targets of this machine, against exact evaluation of their formulas."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..algebra.kind_checks import check_kind
from ..algebra.loader import algebra_from_data
from ..compiler import bind_kernel, optimise_quickly, trace_kernel
from ..declarations import Declaration, declared_kernels
from ..errors import InputError, MissingExtraError, suggest
from ..optimise.accuracy import error_bound
from .errors import CONSTANT, compare, exact_rows
from .operands import operand_cases

#: Precisions that are tested, by the types of operands.
PRECISIONS = {"float64": ("f64", np.float64), "float32": ("f32", np.float32)}


@dataclass(frozen=True)
class KernelCheck:
    """What was found of one kernel.

    Attributes
    ----------
    name : str
    operations : int
        Of the variant that is printed.
    bound : float
        Its error bound, in units of roundoff of the result's largest coefficient, the median over ordinary operands.
    errors : dict of str to float
        By precision, the largest error in the same units, over all cases and targets; where terms cancel it exceeds
        the bound.
    fraction : float
        The largest error in units of what rounding does to the formula as written at these operands, to first order:
        more than `CONSTANT` is a fault.
    targets : tuple of str
        Where it ran.
    fault : str
        Target, precision, operands and result of the first fault; empty if there is none.
    """

    name: str
    operations: int
    bound: float
    errors: Mapping[str, float]
    fraction: float
    targets: tuple[str, ...]
    fault: str


def available_targets() -> dict[str, str]:
    """Targets by name, with why one does not run on this machine; empty where it does."""
    return {"c": _why_no_c(), "numba": _why_no_numba(), "numpy": "", "cuda": _why_no_cuda()}


def _why_no_c() -> str:
    from ..build.toolchain import compiler

    return "" if compiler() else "no C compiler"


def _why_no_numba() -> str:
    from ..execute.numba_jit import numba

    try:
        numba()
    except MissingExtraError as error:
        return str(error)
    return ""


def _why_no_cuda() -> str:
    from ..execute import nvrtc
    from ..execute.cuda_driver import unavailable

    try:
        nvrtc.version()
    except MissingExtraError as error:
        return str(error)
    return unavailable()


def selected_kernels(spec: Mapping[str, Any], names: Sequence[str] = ()) -> list[Declaration]:
    """Declarations of the kernels of a spec that are to be tested; the members of its kinds are proved to be such.

    Parameters
    ----------
    spec : mapping
        See `load_spec`.
    names : sequence of str
        Kernels, as in OPERATIONS.md, or formulas, ``module.function``; none: all.

    Raises
    ------
    SpecError, SignatureError, KindError
        If the spec is not valid, or a kind's member breaks its constraints.
    InputError
        If there is no kernel of such a name, or none at all.
    """
    algebra = algebra_from_data(spec)
    declared = declared_kernels(algebra, spec.get("kernels", []))
    known = [name for d in declared for name in (d.name, d.formula_name)]
    for name in names:
        if name not in known:
            raise InputError(f"{algebra.name} has no kernel {name!r}{suggest(name, known)}.")
    if not declared:
        raise InputError(f"the spec of {algebra.name} has no kernels.", remedy="Declare some under [[kernels]]")
    for kind in algebra.kinds.values():
        check_kind(kind)
    return [d for d in declared if not names or d.name in names or d.formula_name in names]


def check_kernel(declaration: Declaration, targets: Sequence[str], items: int = 12, seed: int = 0) -> KernelCheck:
    """Test one kernel on operands of `operand_cases`, in double and single precision.

    Parameters
    ----------
    declaration : Declaration
    targets : sequence of str
        Some of `codegen.kernels.compiled.TARGETS`, which run here.
    items : int
        Items of each case.
    seed : int
        Of the operands.

    Raises
    ------
    TraceError
        If the formula cannot be traced on these kinds.
    """
    algebra = declaration.kinds[0].algebra
    kernel = trace_kernel(declaration.formula, declaration.kinds, declaration.name, algebra=algebra)
    variant = optimise_quickly(kernel)
    errors, fraction, fault = {}, 0.0, ""
    for name, (precision, dtype) in PRECISIONS.items():
        calls = {target: bind_kernel(variant, target, precision) for target in targets}
        worst = 0.0
        for case, arrays in operand_cases(kernel, dtype, items, seed):
            exact = exact_rows(kernel, arrays)
            for target, call in calls.items():
                found = compare(kernel, arrays, call(*arrays), exact, variant.name.startswith("reduced"))
                worst, fraction = max(worst, found.units), max(fraction, CONSTANT * found.fraction)
                if found.fault and not fault:
                    fault = f"{declaration.name} on {target} in {name}, {case}, {found.fault}"
        errors[name] = worst
    bound = error_bound(kernel, variant.roots)
    return KernelCheck(declaration.name, variant.operations.total, bound, errors, fraction, tuple(targets), fault)

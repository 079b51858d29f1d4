"""Kernels of an algebra as a library to export: those of its spec, or what every algebra has."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from fnmatch import fnmatch
from functools import cache
from importlib import resources
from typing import Any

from ..algebra.algebra import Algebra
from ..algebra.loader import algebra_from_data
from ..algebra.schema import load_spec, stock_spec_path
from ..declarations import declared_kernels, plain_kernels
from ..errors import InputError
from ..formulas.products.invariant import decomposes_in
from ..generator import selected_variants
from ..optimise.variants import Variant
from ..progress import ProgressOption, open_progress

#: Kinds that move others, and kinds that are none to be moved.
_MOTIONS = ("motor", "rotor", "translator", "even")
_NEITHER = (*_MOTIONS, "scalar", "odd", "multivector", "euclidean")


def library_variants(
    spec: Mapping[str, Any], only: Sequence[str] = (), progress: ProgressOption = False
) -> list[Variant]:
    """The kernels of a spec with the variants that are printed.

    Parameters
    ----------
    spec : mapping
        Contents of a spec file. Without kernels of its own: products, motions of its objects, exp and log.
    only : sequence of str, optional
        Names of kernels, which may hold * and ?. Default: all.
    progress : bool or callable
        True: a bar on standard error. A callable gets a `Progress` of kernels.

    Raises
    ------
    InputError
        If there is no kernel of such a name.
    SpecError, KindError, TraceError
        If the spec is not valid.
    """
    algebra = algebra_from_data(spec)
    declared = declared_kernels(algebra, spec.get("kernels") or library_kernels(algebra))
    chosen = [d for d in declared if not only or any(fnmatch(d.name, pattern) for pattern in only)]
    for pattern in only:
        if not any(fnmatch(d.name, pattern) for d in declared):
            raise InputError(
                f"{algebra.name} has no kernel {pattern!r}.",
                remedy=f"There are {len(declared)}, such as {', '.join(d.name for d in declared[:8])}.",
            )
    found = []
    with open_progress(progress, f"export {algebra.name}", "kernels", len(chosen)) as report:
        selected = selected_variants(algebra, chosen, _choices(algebra.name), quick=True)
        for done, (each, variant) in enumerate(selected, 1):
            found.append(variant)
            report(done, each.name)
    return found


@cache
def stock_variant(algebra: str, name: str) -> Variant:
    """The kernel of a stock algebra, in the form that the package's own library has."""
    (found,) = library_variants(load_spec(stock_spec_path(algebra)), [name])
    return found


def library_kernels(algebra: Algebra) -> list[dict[str, Any]]:
    """Entries of kernels, as a spec has them, for an algebra that declares none."""
    kinds = algebra.kinds
    motions = [k for k in _MOTIONS if k in kinds and k != "even"]
    objects = [k for k in kinds if k not in _NEITHER and not (k == "bivector" and "line" in kinds)]
    entries = plain_kernels(len(algebra.vectors))
    entries.append({"formula": "products.geometric", "operands": [[k, k] for k in motions]})
    entries.append({"formula": "products.sandwich", "operands": [[m, x] for m in motions[:1] for x in objects]})
    if decomposes_in(algebra):  # else there is no closed form
        entries.append({"formula": "ga.exp", "operands": [["twist" if "twist" in kinds else "bivector"]]})
        entries.append({"formula": "ga.log", "operands": [[k] for k in motions[:1]]})
    return [entry for entry in entries if entry["operands"]]


def _choices(name: str) -> Mapping[str, Any]:
    """The record of what was selected, of an algebra that is generated here."""
    path = resources.files(f"{__package__.partition('.')[0]}.generated").joinpath(name, "variants.json")
    choices: Mapping[str, Any] = json.loads(path.read_text("utf-8")) if path.is_file() else {}
    return choices

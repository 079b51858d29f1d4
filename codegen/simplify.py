"""Forms of a kernel: as written, factored, reduced modulo the kinds' constraints; the cheapest that is as accurate.

A form is a list of nodes that compute the kernel's outputs. Forms differ in rounding and cost, never in exact
value on the declared kinds. The choice depends on counts and bounds only, so every machine emits the same text.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from .bounds import BoundRing
from .errors import SpecError, TraceError
from .factor import Poly, factor
from .graph import Node, evaluate, reachable
from .kinds import Kind, NumericSource
from .polynomials import Regions, TooManyTerms, constraint_polynomials, rebuild, regions, same_values
from .trace import Kernel

#: A form whose error bound exceeds this multiple of the written formula's is not admitted.
ADMITTED_RATIO = 4.0
#: Sampled inputs per case.
SAMPLES = 64
#: Systems with more terms in all are left as they were written.
MAX_SYSTEM_TERMS = 1200


@dataclass(frozen=True)
class Operations:
    """Operation counts of straight-line code."""

    multiplications: int
    additions: int
    others: int

    @property
    def total(self) -> int:
        """All of them, equally weighted: contraction is off, so multiplications and additions cost the same."""
        return self.multiplications + self.additions + self.others

    def text(self) -> str:
        """For headers and reports."""
        other = f", {self.others} other" if self.others else ""
        return f"{self.multiplications} mul, {self.additions} add{other}."


@dataclass(frozen=True, eq=False)
class Form:
    """One way to compute a kernel."""

    kernel: Kernel
    name: str
    roots: tuple[Node, ...]

    @cached_property
    def operations(self) -> Operations:
        """Counts of this form, the kernels that it calls included."""
        return count(self.roots)


def count(roots: tuple[Node, ...]) -> Operations:
    """Operations of the nodes that the roots need."""
    multiplications = additions = others = 0
    called: set[tuple[str, tuple[int, ...]]] = set()
    for node in reachable(roots):
        if node.op == "sum":
            additions += len(node.args) - 1
            multiplications += sum(
                abs(w) != 1 and a.op != "const" for a, w in zip(node.args, node.data, strict=True)
            )
        elif node.op == "mul":
            multiplications += 1
        elif node.op == "call":
            kernel = node.data[0]
            key = (kernel.name, tuple(a.id for a in node.args))
            if key not in called:
                called.add(key)
                inner = chosen_form(kernel).operations
                multiplications += inner.multiplications
                additions += inner.additions
                others += inner.others
        elif node.op not in ("var", "const"):
            others += 1
    return Operations(multiplications, additions, others)


def staged(kernel: Kernel) -> Form:
    """The kernel as its formula was written, dead code removed."""
    return Form(kernel, "staged", kernel.roots)


def forms(kernel: Kernel) -> Iterator[Form]:
    """All forms worth counting, the formula as written first; each proved equal at the graph's exact points."""
    yield staged(kernel)
    for name, keep_shared in (("local", True), ("greedy", False)):
        try:
            parts = regions(kernel, keep_shared)
        except TooManyTerms:
            continue
        yield from _factored(kernel, name, parts, parts.polynomials)
    try:
        parts = regions(kernel, keep_shared=False)
    except TooManyTerms:
        return
    for i, polynomials in enumerate(reduced_polynomials(kernel, parts)):
        yield from _factored(kernel, f"reduced{i}", parts, polynomials)


def form_named(kernel: Kernel, name: str) -> Form:
    """One form by name, without making the others.

    Raises
    ------
    SpecError
        If the kernel has no such form.
    """
    if name == "staged":
        return staged(kernel)
    try:
        parts = regions(kernel, keep_shared=name == "local")
        if name in ("local", "greedy"):
            return next(_factored(kernel, name, parts, parts.polynomials))
        number = int(name.removeprefix("reduced"))
        polynomials = next(islice(reduced_polynomials(kernel, parts), number, None))
        return next(_factored(kernel, name, parts, polynomials))
    except (TooManyTerms, StopIteration, ValueError):
        raise SpecError(f"kernel {kernel.name!r} has no form {name!r}; regenerate without the old choices.") from None


def _factored(kernel: Kernel, name: str, parts: Regions, polynomials: Sequence[Poly]) -> Iterator[Form]:
    if sum(len(p) for p in polynomials) > MAX_SYSTEM_TERMS:
        return
    expressions = factor(polynomials, len(parts.atoms))
    roots = rebuild(kernel.graph, parts, expressions, len(kernel.roots))
    if not same_values(kernel.graph, kernel.roots, roots):
        raise TraceError(f"{kernel.name}: form {name} does not equal the formula; a constraint of a kind is wrong.")
    yield Form(kernel, name, roots)


def reduced_polynomials(kernel: Kernel, parts: Regions) -> Iterator[list[Poly]]:
    """Shorter polynomials with the same values on the inputs' kinds."""
    constraints = [poly for _, polys in constraint_polynomials(kernel, parts.atoms) for poly in polys]
    if not constraints:
        return
    from .groebner import reduced_variants

    yield from reduced_variants(list(parts.polynomials), constraints, len(parts.atoms))


def error_ratio(form: Form) -> float:
    """Largest ratio of the form's error bound to that of the formula as written, over sampled inputs."""
    kernel = form.kernel
    ring = BoundRing()
    worst = 0.0
    for values in samples(kernel):
        bounded = {place: (v, 0.0) for place, v in values.items()}
        own = evaluate(form.roots, bounded, ring)
        written = evaluate(kernel.roots, bounded, ring)
        start = 0
        for output in kernel.outputs:
            size = len(output.nodes)
            bounds = [
                np.max([np.broadcast_to(b, SAMPLES) for _, b in part[start : start + size]], axis=0)
                for part in (own, written)
            ]
            start += size
            finite = np.isfinite(bounds[1]) & (bounds[1] > 0)
            if np.any(finite):
                ratio = bounds[0][finite] / bounds[1][finite]
                worst = max(worst, float(np.max(np.where(np.isfinite(ratio), ratio, np.inf))))
    return worst


def samples(kernel: Kernel) -> Iterator[dict[tuple[int, int], Any]]:
    """Inputs for error bounds: ordinary members, large ones, and near-coincident ones."""
    for scale, separation in ((1.0, None), (100.0, None), (1.0, 1e-6)):
        values: dict[tuple[int, int], Any] = {}
        first: dict[Kind, list[Any]] = {}
        source = NumericSource(SAMPLES, seed=7, scale=scale)
        for i, item in enumerate(kernel.inputs):
            if item.kind.form == "numbers":
                row = [source.scalar() for _ in range(item.kind.size)]
            elif separation and item.kind in first:
                row = [v * (1 + separation * source.scalar()) for v in first[item.kind]]
            else:
                row = item.kind.values(item.kind.sample(source))
                first[item.kind] = row
            values.update({(i, j): v for j, v in enumerate(row)})
        yield values


_chosen: WeakKeyDictionary[Kernel, Form] = WeakKeyDictionary()


def chosen_form(kernel: Kernel) -> Form:
    """The form that is printed; searched on first use."""
    if kernel not in _chosen:
        choose(kernel)
    return _chosen[kernel]


def choose(kernel: Kernel, name: str | None = None) -> Form:
    """Choose the form of this name, or search for the cheapest that is as accurate as the formula as written."""
    if name is not None:
        _chosen[kernel] = form_named(kernel, name)
        return _chosen[kernel]
    best = staged(kernel)
    for form in forms(kernel):
        if form.operations.total < best.operations.total and error_ratio(form) <= ADMITTED_RATIO:
            best = form
    _chosen[kernel] = best
    return best

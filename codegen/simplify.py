"""Forms of a kernel: as written, factored, reduced modulo the kinds' constraints; the cheapest that is as accurate.

A form is a list of nodes that compute the kernel's outputs. Forms differ in rounding and cost, never in exact
value on the declared kinds. The choice depends on counts and bounds only, so every machine emits the same text.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from threading import RLock
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from .bounds import BoundRing
from .errors import SpecError, TraceError
from .factor import Expr, Poly, factor
from .factor_record import Record, decode, encode
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
#: The same, and the work of one factoring, for kernels made at run time: about 0.1 s each.
QUICK_SYSTEM_TERMS, QUICK_BUDGET = 400, 40_000


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
    called: set[tuple[Kernel, tuple[int, ...]]] = set()
    for node in reachable(roots):
        if node.op == "sum":
            additions += len(node.args) - 1
            multiplications += sum(abs(w) != 1 and a.op != "const" for a, w in zip(node.args, node.data, strict=True))
        elif node.op == "mul":
            multiplications += 1
        elif node.op == "call":
            kernel = node.data[0]
            key = (kernel, tuple(a.id for a in node.args))
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


@dataclass(frozen=True, eq=False)
class Candidate:
    """A form that is not built yet: its name, and the factored expressions of the kernel's regions."""

    name: str
    parts: Regions
    expressions: tuple[Expr, ...]

    def build(self, kernel: Kernel) -> Form:
        """Nodes of this form, proved equal to the formula at the graph's exact points.

        Raises
        ------
        TraceError
            If they are not: then a constraint of a kind is wrong.
        """
        roots = rebuild(kernel.graph, self.parts, self.expressions, len(kernel.roots))
        if not same_values(kernel.graph, kernel.roots, roots):
            raise TraceError(f"{kernel.name}: form {self.name} does not equal the formula; is a constraint wrong?")
        return Form(kernel, self.name, roots)


def candidates(kernel: Kernel, quick: bool = False) -> Iterator[Candidate]:
    """Forms worth counting: "local" (sums that are shared stay), "greedy" (all expanded), "reduced0", ...

    ``quick`` searches less: for kernels that somebody waits for.
    """
    for name, keep_shared in (("local", True), ("greedy", False)):
        with suppress(TooManyTerms):
            parts = regions(kernel, keep_shared)
            yield from _factored(name, parts, parts.polynomials, quick)
    with suppress(TooManyTerms):
        parts = regions(kernel, keep_shared=False)
        for i, polynomials in enumerate(islice(reduced_polynomials(kernel, parts), 1 if quick else None)):
            yield from _factored(f"reduced{i}", parts, polynomials, quick)


def _factored(name: str, parts: Regions, polynomials: Sequence[Poly], quick: bool) -> Iterator[Candidate]:
    terms = sum(len(p) for p in polynomials)
    if terms <= (QUICK_SYSTEM_TERMS if quick else MAX_SYSTEM_TERMS):
        budget = QUICK_BUDGET if quick else None
        yield Candidate(name, parts, tuple(factor(polynomials, len(parts.atoms), budget)))


def forms(kernel: Kernel) -> Iterator[Form]:
    """All forms, the formula as written first. Each is valid until the next one is taken."""
    yield staged(kernel)
    mark = kernel.graph.mark()
    for candidate in candidates(kernel):
        yield candidate.build(kernel)
        kernel.graph.rollback(mark)


def reduced_polynomials(kernel: Kernel, parts: Regions) -> Iterator[list[Poly]]:
    """Shorter polynomials with the same values on the inputs' kinds."""
    constraints = [poly for _, polys in constraint_polynomials(kernel, parts.atoms) for poly in polys]
    if not constraints:
        return
    from .groebner import reduced_variants

    yield from reduced_variants(list(parts.polynomials), constraints, len(parts.atoms))


def error_ratio(form: Form) -> float:
    """Largest ratio of a coefficient's error bound to that of the formula as written, over sampled inputs.

    One rounding of the coefficient itself is always allowed for: the written formula may copy what it returns.
    """
    kernel = form.kernel
    ring = BoundRing()
    worst = 0.0
    for values in samples(kernel):
        bounded = {place: (v, 0.0) for place, v in values.items()}
        own = evaluate(form.roots, bounded, ring)
        written = evaluate(kernel.roots, bounded, ring)
        with np.errstate(all="ignore"):
            for (_, mine), (value, theirs) in zip(own, written, strict=True):
                allowed = np.maximum(theirs, np.abs(value))
                ratio = np.where(np.isfinite(allowed) & (mine > 0), mine / allowed, 0.0)
                worst = max(worst, float(np.max(np.where(np.isnan(ratio), np.inf, ratio))))
    return worst


def samples(kernel: Kernel) -> Iterator[dict[tuple[int, int], Any]]:
    """Inputs for error bounds: ordinary members, large ones, near-coincident ones, versors near 1 and -1, and with
    them plain numbers near 1 and near 0.
    """
    near = 1e-6
    for scale, separation, unit in ((1, 0, 0), (100, 0, 0), (1, near, 0), (1, 0, 1), (1, 0, -1)):
        values: dict[tuple[int, int], Any] = {}
        first: dict[Kind, list[Any]] = {}
        source = NumericSource(SAMPLES, seed=7, scale=scale)
        for i, item in enumerate(kernel.inputs):
            if item.kind.form != "multivector":
                row = [source.scalar() for _ in range(item.kind.size)]
                if unit:
                    row = [near * v + max(unit, 0) for v in row]
            elif separation and item.kind in first:
                row = [v * (1 + separation * source.scalar()) for v in first[item.kind]]
            else:
                row = item.kind.values(item.kind.sample(source))
                if unit and item.kind.blades[0] == 0 and item.kind.form == "multivector":
                    row = [near * v for v in row]
                    row[0] = row[0] + unit
                first[item.kind] = row
            values.update({(i, j): v for j, v in enumerate(row)})
        yield values


#: Searching builds nodes in the kernel's graph and takes them back: one thread at a time.
_lock = RLock()
_chosen: WeakKeyDictionary[Kernel, tuple[Form, Candidate | None]] = WeakKeyDictionary()


def chosen_form(kernel: Kernel) -> Form:
    """The form that is printed; on first use it is searched quickly."""
    with _lock:
        if kernel not in _chosen:
            choose(kernel, quick=True)
        return _chosen[kernel][0]


def choose(kernel: Kernel, record: Record | None = None, quick: bool = False) -> Form:
    """Take the form of an earlier record, or search for the cheapest that is as accurate as the formula as written.

    Raises
    ------
    SpecError
        If the record does not fit the kernel.
    """
    with _lock:
        return _choose(kernel, record, quick)


def _choose(kernel: Kernel, record: Record | None, quick: bool) -> Form:
    if record is None:
        best = _search(kernel, quick)
    elif record["form"] == "staged":
        best = None
    else:
        best = _recorded(kernel, record)
    try:
        form = best.build(kernel) if best else staged(kernel)
    except (TraceError, IndexError, ValueError, RecursionError) as error:  # of another formula it may go in circles
        raise SpecError(
            f"the recorded form of {kernel.name!r} does not fit ({error}); generate with --search."
        ) from None
    _chosen[kernel] = form, best
    return form


def record_of(kernel: Kernel) -> Record:
    """The chosen form as plain data, so that it need not be searched again (and no factoring code is needed)."""
    form, candidate = _chosen[kernel]
    if candidate is None:
        return {"form": "staged"}
    return {"form": form.name, **encode(candidate.expressions)}


def _recorded(kernel: Kernel, record: Record) -> Candidate:
    try:
        parts = regions(kernel, keep_shared=record["form"] == "local")
        expressions = decode(record)
    except (TooManyTerms, KeyError, IndexError, ValueError, TypeError) as error:
        raise SpecError(f"the recorded form of {kernel.name!r} is damaged ({error}); generate with --search.") from None
    if len(expressions) != len(parts.targets):
        raise SpecError(f"the recorded form of {kernel.name!r} is of another formula; generate with --search.")
    return Candidate(record["form"], parts, tuple(expressions))


def _search(kernel: Kernel, quick: bool) -> Candidate | None:
    mark = kernel.graph.mark()
    best, least = None, staged(kernel).operations.total
    for candidate in candidates(kernel, quick):
        form = candidate.build(kernel)
        if form.operations.total < least and error_ratio(form) <= ADMITTED_RATIO:
            best, least = candidate, form.operations.total
        kernel.graph.rollback(mark)
    return best

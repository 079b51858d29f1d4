"""Variants of a kernel: as written, factored, reduced modulo the kinds' constraints; the cheapest that is as accurate.

A variant is a list of nodes that compute the kernel's outputs. Variants differ in rounding and cost, never in exact
value on the declared kinds. The selection depends on counts and bounds only, so every machine prints the same text.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, MutableMapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import islice
from threading import RLock
from typing import Any

from ..errors import SpecError, TraceError
from ..ir.graph import Node, reachable
from ..ir.loops.nodes import KernelSignature
from ..trace.kernel import Kernel
from .accuracy import error_ratio
from .factor.factor import Expr, Poly, factor
from .factor.packed import System
from .factor.record import Record, decode, encode
from .polynomial_view import (
    PolynomialView,
    TooManyTerms,
    constraint_polynomials,
    extract_polynomials,
    rebuild,
    same_values,
)
from .reduction import reduced_variants

#: Name of the formula as written among variants; it stands in the records of generated folders.
AS_WRITTEN = "as_written"
#: A variant whose error bound exceeds this multiple of the written formula's is not admitted.
ADMITTED_RATIO = 4.0
#: Systems with more terms in all are left as they were written.
MAX_SYSTEM_TERMS = 1500
#: A system of more terms is factored quickly first, as a probe.
PROBED_TERMS = 150
#: Where the probe's error bound exceeds this multiple of the written formula's, the long search is left out.
HOPELESS_RATIO = 1000 * ADMITTED_RATIO
#: Most terms of a system for kernels made at run time.
QUICK_SYSTEM_TERMS = 400
#: Work of one factoring for kernels made at run time, and of a probe: at most about 0.1 s.
QUICK_BUDGET = 40_000
#: The same where sums that are shared stay: a long search finds little there.
QUICK_LOCAL_BUDGET = 10_000
#: Kernels made at run time get so much work for each pair of terms, and this at least.
QUICK_PAIRS_TO_WORK, QUICK_LEAST = 20, 20_000


@dataclass(frozen=True)
class Operations:
    """Operation counts of straight-line code; ``divisions`` and square ``roots`` are among the ``others``, too."""

    multiplications: int
    additions: int
    others: int
    divisions: int = 0
    roots: int = 0

    @property
    def total(self) -> int:
        """All of them, equally weighted: contraction is off, so multiplications and additions cost the same."""
        return self.multiplications + self.additions + self.others

    def text(self) -> str:
        """For headers and reports."""
        other = f", {self.others} other" if self.others else ""
        return f"{self.multiplications} mul, {self.additions} add{other}."


@dataclass(frozen=True, eq=False)
class Variant:
    """Straight-line code that computes a kernel.

    Attributes
    ----------
    kernel : Kernel
    name : str
        `AS_WRITTEN`, "local", "greedy", "reduced0", ...
    roots : tuple of Node
        The kernel's outputs.
    callees : mapping of Kernel to Variant
        Variants of the kernels that it calls directly.
    expressions : tuple of Expr, optional
        Factored expressions that the roots were built from; None for the formula as written.
    """

    kernel: Kernel
    name: str
    roots: tuple[Node, ...]
    callees: Mapping[Kernel, Variant] = field(default_factory=dict)
    expressions: tuple[Expr, ...] | None = None

    is_callable_in_algorithms = True

    @property
    def kernel_signature(self) -> KernelSignature:
        """What algorithms call."""
        return self.kernel.signature(self)

    @property
    def variant(self) -> Variant:
        """What is printed for an algorithm that calls it."""
        return self

    def __call__(self, *arguments: Any) -> Any:
        """The formula on numbers, where an algorithm runs as Python."""
        return self.kernel.on_numbers_in_use(arguments)

    @cached_property
    def operations(self) -> Operations:
        """Operation counts, those of called kernels included."""
        return count(self.roots, self.callees)

    def record(self) -> Record:
        """The variant as plain data, so that it need not be searched again (and no factoring code is needed)."""
        return {"variant": self.name, **(encode(self.expressions) if self.expressions is not None else {})}


def count(roots: Sequence[Node], callees: Mapping[Kernel, Variant]) -> Operations:
    """Count the operations of the nodes that the roots need."""
    multiplications = additions = others = divisions = square_roots = 0
    calls: set[tuple[Kernel, tuple[int, ...]]] = set()
    for node in reachable(roots):
        if node.op == "sum":
            additions += len(node.args) - 1
            multiplications += sum(abs(w) != 1 and a.op != "const" for a, w in zip(node.args, node.data, strict=True))
        elif node.op == "mul":
            multiplications += 1
        elif node.op == "call":
            kernel = node.data[0]
            call = (kernel, tuple(a.id for a in node.args))
            if call not in calls:
                calls.add(call)
                inner = callees[kernel].operations
                multiplications += inner.multiplications
                additions += inner.additions
                others += inner.others
                divisions += inner.divisions
                square_roots += inner.roots
        elif node.op not in ("var", "const"):
            others += 1
            divisions += node.op == "reciprocal"
            square_roots += node.op == "sqrt"
    return Operations(multiplications, additions, others, divisions, square_roots)


def as_written(kernel: Kernel) -> Variant:
    """The kernel, and those that it calls, as their formulas were written, dead code removed."""
    return Variant(kernel, AS_WRITTEN, kernel.roots, {callee: as_written(callee) for callee in kernel.callees})


@dataclass(frozen=True, eq=False)
class Candidate:
    """A variant before it is built: its name, and the factored expressions of the kernel's polynomials."""

    name: str
    parts: PolynomialView
    expressions: tuple[Expr, ...]

    def build(self, kernel: Kernel, callees: Mapping[Kernel, Variant]) -> Variant:
        """Build the nodes of the variant, and prove them equal to the formula at the graph's sample points.

        Raises
        ------
        TraceError
            If they are not: then a constraint of a kind is wrong.
        """
        roots = rebuild(kernel.graph, self.parts, self.expressions, len(kernel.roots))
        if not same_values(kernel.graph, kernel.roots, roots):
            raise TraceError(f"{kernel.name}: variant {self.name} does not equal the formula; is a constraint wrong?")
        return Variant(kernel, self.name, roots, callees, self.expressions)


def candidates(kernel: Kernel, quick: bool = False) -> Iterator[Candidate]:
    """Forms worth counting: "local" (sums that are shared stay), "greedy" (all expanded), "reduced0", ...

    ``quick`` searches less, for kernels that somebody waits for: of what is expanded one form, reduced where it can be.
    """
    with suppress(TooManyTerms):
        parts = extract_polynomials(kernel, keep_shared=True)
        yield from _factor_candidates(kernel, "local", parts, parts.polynomials, QUICK_LOCAL_BUDGET if quick else 0)
    with suppress(TooManyTerms):
        parts = extract_polynomials(kernel, keep_shared=False)
        forms = _expanded_forms(kernel, parts)
        if quick:
            name, polynomials = list(islice(forms, 2))[-1]
            yield from _factor_candidates(kernel, name, parts, polynomials, _quick_budget(polynomials, parts))
            return
        for name, polynomials in forms:
            yield from _factor_candidates(kernel, name, parts, polynomials)


def _expanded_forms(kernel: Kernel, parts: PolynomialView) -> Iterator[tuple[str, Sequence[Poly]]]:
    """What is expanded, by name: as it is, then shorter with the same values."""
    yield "greedy", parts.polynomials
    for i, polynomials in enumerate(reduced_polynomials(kernel, parts)):
        yield f"reduced{i}", polynomials


def _quick_budget(polynomials: Sequence[Poly], parts: PolynomialView) -> int:
    pairs = System.load(polynomials, len(parts.atoms)).pair_count()
    return min(QUICK_BUDGET, max(QUICK_LEAST, QUICK_PAIRS_TO_WORK * pairs))


def _factor_candidates(
    kernel: Kernel, name: str, parts: PolynomialView, polynomials: Sequence[Poly], quick: int = 0
) -> Iterator[Candidate]:
    """The form factored, with all the work that it is worth or, of somebody who waits, with this much."""
    terms = sum(len(p) for p in polynomials)
    if terms > (QUICK_SYSTEM_TERMS if quick else MAX_SYSTEM_TERMS):
        return
    if quick:
        yield Candidate(name, parts, tuple(factor(polynomials, len(parts.atoms), quick)))
        return
    if terms > PROBED_TERMS:
        probe = Candidate(name, parts, tuple(factor(polynomials, len(parts.atoms), QUICK_BUDGET)))
        if _is_hopeless(kernel, probe):
            return
    yield Candidate(name, parts, tuple(factor(polynomials, len(parts.atoms))))


def _is_hopeless(kernel: Kernel, candidate: Candidate) -> bool:
    """Return whether expanding alone makes a variant's error so large that no factoring reduces it."""
    mark = kernel.graph.mark()
    ratio = error_ratio(kernel, candidate.build(kernel, {}).roots)
    kernel.graph.rollback(mark)
    return ratio > HOPELESS_RATIO


def variants(kernel: Kernel) -> Iterator[Variant]:
    """All variants, the formula as written first. Each is valid until the next one is requested."""
    kernel = kernel.buildable()
    first = as_written(kernel)
    yield first
    mark = kernel.graph.mark()
    for candidate in candidates(kernel):
        yield candidate.build(kernel, first.callees)
        kernel.graph.rollback(mark)


def reduced_polynomials(kernel: Kernel, parts: PolynomialView) -> Iterator[list[Poly]]:
    """Shorter polynomials with the same values on the inputs' kinds."""
    constraints = [poly for _, polys in constraint_polynomials(kernel, parts.atoms) for poly in polys]
    if not constraints:
        return
    yield from reduced_variants(list(parts.polynomials), constraints, len(parts.atoms))


#: Searching builds nodes in the kernel's graph and removes them again: one thread at a time.
_lock = RLock()


def select_variant(
    kernel: Kernel,
    record: Record | None = None,
    quick: bool = False,
    selected: MutableMapping[Kernel, Variant] | None = None,
) -> Variant:
    """Select the cheapest variant that is as accurate as the formula as written, or that of an earlier record.

    Parameters
    ----------
    kernel : Kernel
    record : mapping, optional
        What `Variant.record` returned: nothing is searched.
    quick : bool
        Search less: for kernels that a user waits for.
    selected : mapping, optional
        Variants of kernels that others call; those that are missing are searched quickly and added.

    Raises
    ------
    SpecError
        If the record does not fit the kernel.
    """
    with _lock:
        return _select(kernel, record, quick, {} if selected is None else selected)


def _select(kernel: Kernel, record: Record | None, quick: bool, selected: MutableMapping[Kernel, Variant]) -> Variant:
    source = kernel.buildable()
    callees = {}
    for callee in dict.fromkeys((*kernel.callees, *source.callees)):
        if callee not in selected:
            selected[callee] = _select(callee, None, True, selected)
        callees[callee] = selected[callee]
    if record is None:
        best = _search(source, quick, callees)
    elif record["variant"] == AS_WRITTEN:
        best = None
    else:
        best = _candidate_from_record(source, record)
    try:
        variant = best.build(source, callees) if best else Variant(kernel, AS_WRITTEN, kernel.roots, callees)
    except (TraceError, IndexError, ValueError, RecursionError) as error:  # of another formula it may go in circles
        raise SpecError(
            f"the recorded form of {kernel.name!r} does not fit ({error}); generate with --search."
        ) from None
    source.release(*variant.roots)
    return replace(variant, kernel=kernel)


def _candidate_from_record(kernel: Kernel, record: Record) -> Candidate:
    try:
        parts = extract_polynomials(kernel, keep_shared=record["variant"] == "local")
        expressions = decode(record)
    except (TooManyTerms, KeyError, IndexError, ValueError, TypeError) as error:
        raise SpecError(f"the recorded form of {kernel.name!r} is damaged ({error}); generate with --search.") from None
    if len(expressions) != len(parts.targets):
        raise SpecError(f"the recorded form of {kernel.name!r} is of another formula; generate with --search.")
    return Candidate(record["variant"], parts, tuple(expressions))


def _search(kernel: Kernel, quick: bool, callees: Mapping[Kernel, Variant]) -> Candidate | None:
    """The cheapest candidate that is as accurate; of equal ones the first. None: the formula as written is cheaper."""
    mark = kernel.graph.mark()
    least, found = count(kernel.roots, callees).total, []
    for candidate in candidates(kernel, quick):
        total = candidate.build(kernel, callees).operations.total
        kernel.graph.rollback(mark)
        if total < least:
            found.append((total, candidate))
    for _, candidate in sorted(found, key=lambda pair: pair[0]):  # bounds take longer than building once more
        ratio = error_ratio(kernel, candidate.build(kernel, callees).roots)
        kernel.graph.rollback(mark)
        if ratio <= ADMITTED_RATIO:
            return candidate
    return None

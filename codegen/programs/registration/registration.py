"""Kinds of objects that are registered: how each moves, and what a pair of it says."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import combinations, combinations_with_replacement
from typing import NamedTuple

from ...errors import InputError
from ...formulas.registration import estimation, registration
from .. import KernelSpec, cga3d

#: Kinds of object, in the order that algorithms number them.
KINDS = ("point", "point_pair", "line", "segment", "circle", "plane", "sphere")
#: Those that point somewhere.
DIRECTED = frozenset(("point_pair", "line", "segment", "circle", "plane"))
#: Kinds that are matched as objects of another kind: a segment as the line through its ends.
_MATCHED_AS = {"segment": "line"}
#: How far points are off flats; off other kinds it is the distance of their positions.
_OFF = {"line": registration.off_line, "plane": registration.off_plane}
#: The name of the set of all kinds.
ALL = "all"


class RegisteredKind(NamedTuple):
    """A kind of object as algorithms see it: its number, coefficients of a row, whether it is directed, its kernels."""

    number: int
    length: int
    directed: bool
    element: KernelSpec
    in_frame: KernelSpec
    moved: KernelSpec
    form: KernelSpec
    rates: KernelSpec
    off: KernelSpec
    half_step: KernelSpec
    half_step_of_two: KernelSpec


class PairOfKinds(NamedTuple):
    """Two kinds, in order, and the kernel of the invariants of a pair of them."""

    first: RegisteredKind
    second: RegisteredKind
    invariants: KernelSpec


def matched_as(kind: str) -> str:
    """The kind of the algebra's objects that stand for objects of a kind."""
    return _MATCHED_AS.get(kind, kind)


def _registered_kind(name: str) -> RegisteredKind:
    kind = matched_as(name)
    return RegisteredKind(
        KINDS.index(name),
        cga3d().kind(kind).size,
        kind in DIRECTED,
        KernelSpec(registration.element, (kind,), f"element_{kind}"),
        KernelSpec(registration.coefficients_at, (kind, "position"), f"seen_{kind}"),
        KernelSpec(registration.moved_element, ("motor", kind), f"moved_{kind}"),
        KernelSpec(registration.motor_form, (kind, kind, "number"), f"form_{kind}"),
        KernelSpec(registration.moved_rates, ("motor", kind, kind), f"rates_{kind}"),
        KernelSpec(_OFF.get(kind, registration.off_position), ("position", "numbers7")),
        KernelSpec(estimation.half_step, ("motor", kind, kind, "number"), f"half_{kind}"),
        KernelSpec(estimation.half_step_of_two, ("motor", kind, kind, kind, kind), f"half_two_{kind}"),
    )


def _subsets() -> dict[str, tuple[str, ...]]:
    """Sets of kinds by their names."""
    sets = (each for n in range(1, len(KINDS)) for each in combinations(KINDS, n))
    return {ALL: KINDS, **{"_".join(each): each for each in sets}}


_SUBSETS = _subsets()


class _KindSets(dict[str, tuple[RegisteredKind, ...]]):
    """Kinds of a set by its name, made when they are needed."""

    def __missing__(self, name: str) -> tuple[RegisteredKind, ...]:
        return self.setdefault(name, tuple(map(_registered_kind, _SUBSETS[name])))


class _PairSets(dict[str, tuple[PairOfKinds, ...]]):
    """Pairs of kinds of a set by its name, made when they are needed."""

    def __missing__(self, name: str) -> tuple[PairOfKinds, ...]:
        kinds = dict(zip(_SUBSETS[name], KIND_SETS[name], strict=True))
        found = []
        for pair in combinations_with_replacement(kinds, 2):
            objects = (matched_as(pair[0]), matched_as(pair[1]))
            kernel = KernelSpec(registration.pair_invariants, objects, f"invariants_{'_'.join(objects)}")
            found.append(PairOfKinds(kinds[pair[0]], kinds[pair[1]], kernel))
        return self.setdefault(name, tuple(found))


KIND_SETS = _KindSets()
PAIR_SETS = _PairSets()


def set_name(kinds: Iterable[str]) -> str:
    """Name of a set of kinds in programs."""
    wanted = in_order(kinds)
    return ALL if wanted == KINDS else "_".join(wanted)


def in_order(kinds: Iterable[str]) -> tuple[str, ...]:
    """Each kind once, in the order of `KINDS`.

    Raises
    ------
    InputError
        If there is no such kind, or none at all.
    """
    names = set(kinds)
    if unknown := sorted(names - set(KINDS)):
        raise InputError(f"{unknown[0]} is not a kind of object for registration; there are: {', '.join(KINDS)}.")
    if not names:
        raise InputError("a registration needs at least one kind of object.")
    return tuple(k for k in KINDS if k in names)

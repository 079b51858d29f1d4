"""The registration driver: for each kind of object that both models have, how it moves and what a pair of it says."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from itertools import combinations_with_replacement

from ...errors import InputError
from ...formulas.registration import estimation, registration
from .. import KernelSpec, Program, cga3d, program

#: Kinds of object, in the order that drivers number them.
KINDS = ("point", "point_pair", "line", "circle", "plane", "sphere")
#: Those that point somewhere.
DIRECTED = frozenset(("point_pair", "line", "circle", "plane"))
#: How far points are off flats; off other kinds it is the distance of their positions.
_OFF = {"line": registration.off_line, "plane": registration.off_plane}


@dataclass(frozen=True)
class RegisteredKind:
    """A kind of object as the driver's template sees it."""

    name: str
    number: int
    size: int
    directed: bool
    off: str


def _registered_kind(kind: str) -> RegisteredKind:
    off = _OFF.get(kind, registration.off_position).__name__
    return RegisteredKind(kind, KINDS.index(kind), cga3d().kind(kind).size, kind in DIRECTED, off)


def _kernel_specs(kind: str) -> list[KernelSpec]:
    return [
        KernelSpec(registration.element, (kind,), f"element_{kind}"),
        KernelSpec(registration.coefficients_at, (kind, "position"), f"seen_{kind}"),
        KernelSpec(registration.moved_rates, ("motor", kind, kind), f"rates_{kind}"),
        KernelSpec(registration.moved_element, ("motor", kind), f"moved_{kind}"),
        KernelSpec(registration.motor_form, (kind, kind, "number"), f"form_{kind}"),
    ]


def _half_step_specs(kinds: tuple[str, ...]) -> list[KernelSpec]:
    """Kernels of Algorithm 1, which only the compiled driver has."""
    steps = [KernelSpec(estimation.change, ("motor", "motor"), "change")]
    for kind in kinds:
        steps.append(KernelSpec(estimation.half_step, ("motor", kind, kind, "number"), f"half_{kind}"))
        if kind not in DIRECTED:
            steps.append(KernelSpec(estimation.half_step_of_two, ("motor", kind, kind, kind, kind), f"half_two_{kind}"))
    return steps


@dataclass(frozen=True)
class DriverSpec:
    """Kernels of a driver, and the values that its template is filled with."""

    specs: tuple[KernelSpec, ...]
    values: Mapping[str, object]


def driver_spec(wanted: tuple[str, ...]) -> DriverSpec:
    """The kernels that every driver of some kinds, in order, needs, and what its template says of them."""
    blades = cga3d().kind("motor").blades
    pairs = list(combinations_with_replacement(wanted, 2))
    values: dict[str, object] = {
        "title": f"Registration of models of {', '.join(wanted)}",
        "kinds": [_registered_kind(kind) for kind in wanted],
        "motor_order": [blades.index(b) for b in registration.motor_blades(cga3d())],
        "pairs": [(KINDS.index(a), KINDS.index(b), a, b) for a, b in pairs],
    }
    specs = [KernelSpec(registration.near_motor, ("layout motor",), "near_motor")]
    specs.append(KernelSpec(registration.step_motor, ("motor", "twist"), "stepped"))
    specs.append(KernelSpec(registration.apart, ("numbers7", "numbers7", "numbers3", "number", "number"), "apart"))
    specs.append(KernelSpec(registration.unseen, ("motor", "position", "position"), "unseen"))
    specs.append(KernelSpec(registration.unseen_twist, ("twist", "position"), "unseen_twist"))
    offs = dict.fromkeys(_OFF.get(kind, registration.off_position) for kind in wanted)
    specs += [KernelSpec(formula, ("position", "numbers7")) for formula in offs]
    specs += [d for kind in wanted for d in _kernel_specs(kind)]
    specs += [KernelSpec(registration.pair_invariants, pair, f"invariants_{'_'.join(pair)}") for pair in pairs]
    return DriverSpec(tuple(specs), values)


@cache
def reform_program(kinds: tuple[str, ...] = KINDS) -> Program:
    """The program that registers models of these kinds, and has nothing for others.

    Raises
    ------
    InputError
        If there is no such kind, or none at all.
    """
    wanted = in_order(kinds)
    made = driver_spec(wanted)
    name = "reform" if wanted == KINDS else "reform_" + "_".join(wanted)
    specs = (*made.specs, *_half_step_specs(wanted))
    return program(name, specs, "reform.c.j2", "reform_types.h", made.values)


def in_order(kinds: Iterable[str]) -> tuple[str, ...]:
    """Each kind once, in the order of `KINDS`."""
    names = set(kinds)
    if unknown := sorted(names - set(KINDS)):
        raise InputError(f"{unknown[0]} is not a kind of object for registration; there are: {', '.join(KINDS)}.")
    if not names:
        raise InputError("a registration needs at least one kind of object.")
    return tuple(k for k in KINDS if k in names)

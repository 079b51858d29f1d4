"""Layout of a mechanism's driver: offsets of its numbers, and the order in which unknown speeds are eliminated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from .config import Cut, Link, MechanismConfig


@dataclass(frozen=True)
class SharedObject:
    """An object of a joint: its layout, and the offsets of it and of its part of each row."""

    layout: str
    size: int
    x: int
    g: int


@dataclass(frozen=True)
class JointLayout:
    """Offsets of a link, cut or target in the numbers, and in the rows and columns of the loops.

    Attributes
    ----------
    free, rows, back : int
        Where the twists left (6, f), the rows (m, 6) and, of links, their inverse (6, m) stand in the numbers.
    h : int
        What the shared objects give (m) when the joint is closed.
    first : int
        Of a link, its first column; of a cut or target, its first row.
    around : tuple of (int, int)
        Of a cut or target: links on the way from one body to the other, with signs.
    """

    what: Any
    shared: tuple[SharedObject, ...]
    free: int
    rows: int
    back: int
    h: int
    first: int
    around: tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class MechanismLayout:
    """Offsets and counts of a mechanism's numbers.

    Attributes
    ----------
    size : int
        Numbers in all.
    columns, rows : int
        Coordinates of links, and rows of cuts and targets.
    driven : tuple of int
        Columns that are given.
    targets_size : int
        Numbers of all targets of an item: a motor, or a point.
    inputs : int
        Columns of inputs: those driven, then those of targets.
    right : int
        Where the targets' right sides (rows, columns) for inputs stand in the numbers.
    """

    links: tuple[JointLayout, ...]
    cuts: tuple[JointLayout, ...]
    targets: tuple[JointLayout, ...]
    size: int
    columns: int
    rows: int
    driven: tuple[int, ...]
    targets_size: int
    inputs: int
    right: int


def path_to_ground(links: tuple[Link, ...], body: int) -> list[int]:
    """Links from a body to the fixed one."""
    bodies = []
    while body >= 0:
        bodies.append(body)
        body = links[body].parent
    return bodies


def signed_loop_path(links: tuple[Link, ...], a: int, b: int) -> tuple[tuple[int, int], ...]:
    """Links whose twists, with signs, are the twist of b against a."""
    paths = path_to_ground(links, a), path_to_ground(links, b)
    common = set(paths[0]) & set(paths[1])
    signed = [*((x, -1) for x in paths[0]), *((x, 1) for x in paths[1])]
    return tuple((x, sign) for x, sign in signed if x not in common)


def assign_offsets(needs: MechanismConfig, sizes: Mapping[str, int]) -> MechanismLayout:
    """Assign offsets to all numbers, rows and columns."""
    at = 0

    def take(count: int) -> int:
        nonlocal at
        at += count
        return at - count

    def shared(x: Link | Cut) -> tuple[SharedObject, ...]:
        return tuple(SharedObject(n, sizes[n], take(sizes[n]), take(x.rows * sizes[n])) for n in x.layouts)

    links, column = [], 0
    for link in needs.links:
        objects, free, back = shared(link), take(6 * link.free), take(6 * link.rows)
        links.append(JointLayout(link, objects, free, -1, back, take(link.rows), column, ()))
        column += link.free
    cuts, row = [], 0
    for cut in needs.cuts:
        objects = shared(cut)
        path = signed_loop_path(needs.links, cut.a, cut.b)
        cuts.append(JointLayout(cut, objects, -1, take(6 * cut.rows), -1, take(cut.rows), row, path))
        row += cut.rows
    targets = []
    for target in needs.targets:
        path = signed_loop_path(needs.links, -1, target.body)
        targets.append(JointLayout(target, (), take(3), -1, -1, -1, row, path))
        row += target.rows
    driven = tuple(
        p.first + k for p, link in zip(links, needs.links, strict=True) if link.driven for k in range(link.free)
    )
    right = take(sum(t.rows for t in needs.targets) * needs.columns)
    each = sum(8 if t.rows == 6 else 3 for t in needs.targets)
    return MechanismLayout(
        tuple(links), tuple(cuts), tuple(targets), at, column, row, driven, each, len(driven) + needs.columns, right
    )


@dataclass(frozen=True)
class Step:
    """Columns of a link are eliminated from some rows, which have some other columns too."""

    first: int
    free: int
    rows: tuple[int, ...]
    columns: tuple[int, ...]


def elimination(needs: MechanismConfig, places: MechanismLayout) -> tuple[Step, ...]:
    """Order of elimination of the unknown columns that are not requested: fewest rows first."""
    wanted = {x for body in needs.outputs for x in path_to_ground(needs.links, body)} | set(needs.coordinates)
    open_ = [b for b, link in enumerate(needs.links) if not link.driven and link.free and b not in wanted]
    rows: dict[int, set[int]] = {b: set() for b in range(len(needs.links))}
    for each in (*places.cuts, *places.targets):
        count = each.what.rows
        for b, _ in each.around:
            rows[b] |= set(range(each.first, each.first + count))
    steps = []
    while open_:
        best = min(open_, key=lambda b: (len(rows[b]), b))
        open_.remove(best)
        taken = rows.pop(best)
        for other in rows.values():  # rows that are combined have what any of them had
            if other & taken:
                other |= taken
        if taken:
            columns = [j for b in rows if rows[b] & taken for j in _columns(needs, places, b)]
            own = _columns(needs, places, best)
            steps.append(Step(own[0], len(own), tuple(sorted(taken)), tuple(sorted(set(columns) - set(places.driven)))))
    return tuple(steps)


def _columns(needs: MechanismConfig, places: MechanismLayout, body: int) -> list[int]:
    first = places.links[body].first
    return list(range(first, first + needs.links[body].free))

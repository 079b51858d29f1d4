"""The plan of a mechanism's driver: where its numbers stand, and in what order unknown speeds are eliminated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .mechanism import Cut, Link, Needs


@dataclass(frozen=True)
class Shared:
    """An object of a joint: its layout, and where it and its share of each row stand."""

    layout: str
    size: int
    x: int
    g: int


@dataclass(frozen=True)
class Placed:
    """A link or cut with places in the numbers, and in the rows and columns of the loops.

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
    shared: tuple[Shared, ...]
    free: int
    rows: int
    back: int
    h: int
    first: int
    around: tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class Numbered:
    """A mechanism's needs, numbered.

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

    links: tuple[Placed, ...]
    cuts: tuple[Placed, ...]
    targets: tuple[Placed, ...]
    size: int
    columns: int
    rows: int
    driven: tuple[int, ...]
    targets_size: int
    inputs: int
    right: int


def path(links: tuple[Link, ...], body: int) -> list[int]:
    """Links from a body to the fixed one."""
    found = []
    while body >= 0:
        found.append(body)
        body = links[body].parent
    return found


def around(links: tuple[Link, ...], a: int, b: int) -> tuple[tuple[int, int], ...]:
    """Links whose twists, with signs, are the twist of b against a."""
    ways = path(links, a), path(links, b)
    common = set(ways[0]) & set(ways[1])
    signed = [*((x, -1) for x in ways[0]), *((x, 1) for x in ways[1])]
    return tuple((x, sign) for x, sign in signed if x not in common)


def numbered(needs: Needs, sizes: Mapping[str, int]) -> Numbered:
    """Places for everything."""
    at = 0

    def take(count: int) -> int:
        nonlocal at
        at += count
        return at - count

    def shared(x: Link | Cut) -> tuple[Shared, ...]:
        return tuple(Shared(n, sizes[n], take(sizes[n]), take(x.rows * sizes[n])) for n in x.layouts)

    links, column = [], 0
    for link in needs.links:
        objects = shared(link)
        links.append(Placed(link, objects, take(6 * link.free), -1, take(6 * link.rows), take(link.rows), column, ()))
        column += link.free
    cuts, row = [], 0
    for cut in needs.cuts:
        objects = shared(cut)
        ways = around(needs.links, cut.a, cut.b)
        cuts.append(Placed(cut, objects, -1, take(6 * cut.rows), -1, take(cut.rows), row, ways))
        row += cut.rows
    targets = []
    for target in needs.targets:
        targets.append(Placed(target, (), take(3), -1, -1, -1, row, around(needs.links, -1, target.body)))
        row += target.rows
    driven = tuple(
        p.first + k for p, link in zip(links, needs.links, strict=True) if link.driven for k in range(link.free)
    )
    right = take(sum(t.rows for t in needs.targets) * needs.columns)
    each = sum(8 if t.rows == 6 else 3 for t in needs.targets)
    return Numbered(
        tuple(links), tuple(cuts), tuple(targets), at, column, row, driven, each, len(driven) + needs.columns, right
    )


@dataclass(frozen=True)
class Step:
    """Columns of a link are eliminated from some rows, which have some other columns too."""

    first: int
    free: int
    rows: tuple[int, ...]
    columns: tuple[int, ...]


def elimination(needs: Needs, places: Numbered) -> tuple[Step, ...]:
    """Unknown columns that are not asked for, the ones that the fewest rows have first."""
    wanted = {x for body in needs.outputs for x in path(needs.links, body)} | set(needs.coordinates)
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


def _columns(needs: Needs, places: Numbered, body: int) -> list[int]:
    first = places.links[body].first
    return list(range(first, first + needs.links[body].free))

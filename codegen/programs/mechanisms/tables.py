"""Tables of a mechanism's algorithms, offsets in its numbers, and the order in which unknown speeds are eliminated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...ir.loops.records import Record
from . import records
from .config import Cut, Link, MechanismConfig
from .program import class_of, layouts_of

Array = Any


@dataclass(frozen=True, eq=False)
class MechanismTables:
    """What the algorithms take beside numbers of the mechanism and of items.

    Attributes
    ----------
    arguments : dict of str to array
        Tables by the names that the algorithms have for them, those of records.py with fields.
    size : int
        Numbers of the mechanism.
    goals : int
        Numbers of all targets of an item.
    inputs, outputs : int
        Columns and rows of Jacobians.
    room : int
        Class of the algorithms.
    """

    arguments: dict[str, Array]
    size: int
    goals: int
    inputs: int
    outputs: int
    room: int

    def work(self) -> dict[str, tuple[int, ...]]:
        """Shapes of the arrays that a thread brings along; nothing is kept there between calls."""
        sizes, bodies = self.arguments["sizes"], len(self.arguments["links"])
        rows, columns = int(sizes.rows), int(sizes.columns)
        return {
            "relative": (bodies, 8), "motors": (bodies, 8), "carry": (bodies, 36), "free": (columns, 6),
            "rows": (rows, 6), "errors": (rows,), "off": (6 * bodies,), "table": (rows * (columns + self.inputs),),
            "maps": (len(self.arguments["outputs"]), 36), "line": (columns + self.inputs,),
            "used": (rows,), "pivot": (columns,),
        }  # fmt: skip


def path_to_ground(links: tuple[Link, ...], body: int) -> list[int]:
    """Links from a body to the fixed one."""
    bodies = []
    while body >= 0:
        bodies.append(body)
        body = links[body].parent
    return bodies


def signed_loop_path(links: tuple[Link, ...], a: int, b: int) -> list[tuple[int, int]]:
    """Links whose twists, with signs, are the twist of b against a."""
    paths = path_to_ground(links, a), path_to_ground(links, b)
    common = set(paths[0]) & set(paths[1])
    signed = [*((x, -1) for x in paths[0]), *((x, 1) for x in paths[1])]
    return [(x, sign) for x, sign in signed if x not in common]


class _Rows:
    """Rows of a record, one after the other."""

    def __init__(self, layout: Record) -> None:
        self.layout, self.rows = layout, []  # type: ignore[var-annotated]

    def add(self, **fields: int) -> None:
        self.rows.append([fields[name] for name in self.layout.offsets])

    def array(self) -> Array:
        return self.layout.view(np.array(self.rows, np.int64).reshape(-1, self.layout.size))


def mechanism_tables(needs: MechanismConfig) -> MechanismTables:
    """Assign offsets to all numbers, rows and columns."""
    at = 0
    layouts = {name: (index, size) for index, (name, size) in enumerate(layouts_of(needs.algebra))}
    shared, path = _Rows(records.Shared), _Rows(records.PathStep)
    links, cuts, targets = _Rows(records.Link), _Rows(records.Cut), _Rows(records.Target)
    driven = _Rows(records.Driven)
    loops, outputs = _Rows(records.Loop), _Rows(records.Output)

    def take(count: int) -> int:
        nonlocal at
        at += count
        return at - count

    def add_objects(x: Link | Cut) -> dict[str, int]:
        first = len(shared.rows)
        for name in x.layouts:
            index, size = layouts[name]
            shared.add(layout=index, length=size, offset=take(size), part=take(x.rows * size))
        return {"object": first, "objects": len(x.layouts)}

    def add_path(steps: Sequence[tuple[int, int]]) -> dict[str, int]:
        first = len(path.rows)
        for link, sign in steps:
            path.add(link=link, sign=sign)
        return {"step": first, "steps": len(steps)}

    column = row = goals = 0
    bearers = {link.parent for link in needs.links}
    for b, link in enumerate(needs.links):
        links.add(
            body=link.body, parent=link.parent, first=column, count=link.free, free=take(6 * link.free), rows=link.rows,
            inverse=take(6 * link.rows), values=take(link.rows), bears=int(b in bearers), **add_objects(link),
        )  # fmt: skip
        for k, turns in enumerate(link.driven):
            measure = take(6) if link.measured else -1
            place = needs.inputs[len(driven.rows)] if needs.inputs else len(driven.rows)
            driven.add(column=column + k, link=b, measure=measure, turns=int(turns), place=place, unit=take(1))
        column += link.free
    for cut in needs.cuts:
        matrix = take(6 * cut.rows)
        cuts.add(
            a=cut.a, b=cut.b, first=row, rows=cut.rows, matrix=-1 if cut.varying else matrix, values=take(cut.rows),
            **add_objects(cut),
        )  # fmt: skip
        loops.add(first=row, rows=cut.rows, **add_path(signed_loop_path(needs.links, cut.a, cut.b)))
        row += cut.rows
    of_cuts = row
    for target in needs.targets:
        targets.add(body=target.body, first=row, rows=target.rows, point=take(3), goal=goals)
        loops.add(first=row, rows=target.rows, **add_path(signed_loop_path(needs.links, -1, target.body)))
        row += target.rows
        goals += 8 if target.rows == 6 else 3
    link_table = links.array()
    count = points = 0
    for output in needs.outputs:
        if output.rows:
            steps = add_path([(x, 1) for x in path_to_ground(needs.links, output.body)])
            offset = take(36) if output.rows == 6 else points
            points += 4 * (output.rows == 3)
            outputs.add(row=count, rows=output.rows, column=-1, body=output.body, map=offset, **steps)
            count += output.rows
            continue
        for j in _columns(link_table, output.body):
            outputs.add(row=count, rows=1, column=j, body=output.body, map=take(1), step=0, steps=0)
            count += 1
    sizes = _Rows(records.Sizes)
    sizes.add(
        rows=row, columns=column, cuts=of_cuts, goals=goals, speeds=needs.columns,
        right=take((row - of_cuts) * needs.columns), outputs=count,
    )  # fmt: skip
    plan, entries, kept = _elimination(needs, link_table, loops.array(), path.array(), driven.array(), column)
    arguments = {
        "links": link_table, "shared": shared.array(), "cuts": cuts.array(), "targets": targets.array(),
        "loops": loops.array(), "path": path.array(), "driven": driven.array(), "sizes": sizes.array()[0],
        "outputs": outputs.array(), "plan": plan, "entries": entries, "kept": kept,
    }  # fmt: skip
    return MechanismTables(arguments, at, goals, len(driven.rows) + needs.columns, count, class_of(max(row, column)))


def _columns(links: Array, body: int) -> range:
    first = int(links[body].first)
    return range(first, first + int(links[body].count))


def _elimination(
    needs: MechanismConfig, links: Array, loops: Array, path: Array, driven: Array, columns: int
) -> tuple[Array, Array, Array]:
    """Order of elimination of the unknown columns that are not requested, fewest rows first.

    The table, its lists of rows and columns, and the columns that are left.
    """
    given = {int(each.column) for each in driven}
    wanted: set[int] = set()
    for output in needs.outputs:
        wanted.update(path_to_ground(needs.links, output.body) if output.rows else [output.body])
    open_ = [b for b, link in enumerate(needs.links) if not link.driven and link.free and b not in wanted]
    rows: dict[int, set[int]] = {b: set() for b in range(len(needs.links))}
    for loop in loops:
        for step in path[loop.step : loop.step + loop.steps]:
            rows[int(step.link)] |= set(range(int(loop.first), int(loop.first + loop.rows)))
    plan, gone = _Rows(records.Elimination), set(given)
    entries: list[int] = []
    while open_:
        best = min(open_, key=lambda b: (len(rows[b]), b))
        open_.remove(best)
        taken = rows.pop(best)
        for other in rows.values():  # rows that are combined have what any of them had
            if other & taken:
                other |= taken
        if taken:
            own = _columns(links, best)
            others = {j for b in rows if rows[b] & taken for j in _columns(links, b)} - given
            plan.add(
                first=own.start, count=len(own), row=len(entries), rows=len(taken),
                other=len(entries) + len(taken), others=len(others),
            )  # fmt: skip
            entries += [*sorted(taken), *sorted(others)]
            gone.update(own)
    kept = [j for j in range(columns) if j not in gone]
    return plan.array(), np.array(entries, np.int64), np.array(kept, np.int64)

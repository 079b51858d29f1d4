"""Where the numbers of an algorithm are assigned and used: C declares each as far inside its blocks as that allows."""

from __future__ import annotations

from collections.abc import Sequence

from ..ir.loops.nodes import Statement, assigned_variables, blocks, expressions, names_in, walk


def uses(body: Sequence[Statement], name: str) -> bool:
    """Whether some statements read or assign to a number."""
    for statement in walk(tuple(body)):
        if any(v.name == name for v in assigned_variables((statement,), deep=False)):
            return True
        if any(name in names_in(e) for e in expressions(statement)):
            return True
    return False


def is_inside_one_block(statement: Statement, name: str) -> bool:
    """Whether one block of a statement has all that is about a number."""
    if any(name in names_in(e) for e in expressions(statement)):
        return False
    return sum(uses(block, name) for block in blocks(statement)) == 1

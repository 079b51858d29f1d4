"""Where the numbers of an algorithm are assigned and used: C declares each as far inside its blocks as that allows."""

from __future__ import annotations

from collections.abc import Sequence

from ..ir.loops.nodes import Assign, Call, Expression, Statement, Variable, blocks, expressions, parts, walk


def assigned_variables(body: Sequence[Statement], deep: bool = True) -> list[Variable]:
    """Numbers that some statements assign to, each once; what counts a loop belongs to the loop."""
    found: dict[Variable, None] = {}
    for statement in walk(tuple(body)) if deep else body:
        if isinstance(statement, Assign):
            found[statement.target] = None
        elif isinstance(statement, Call):
            found.update(dict.fromkeys(statement.results))
    return list(found)


def names_in(expression: Expression) -> set[str]:
    """Numbers and arrays of an expression."""
    found = set()
    for part in parts(expression):
        if isinstance(part, Variable):
            found.add(part.name)
        if hasattr(part, "array"):
            found.add(part.array.name)
    return found


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

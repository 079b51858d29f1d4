"""Steps of loops, forward and backward."""

from __future__ import annotations

from ..loops.nodes import (
    Binary,
    Break,
    Expression,
    For,
    If,
    Statement,
    Variable,
    While,
    integer,
    plus,
)  # fmt: skip
from ..loops.scope import fresh_name
from ..loops.types import INT


def end_of_steps(body: tuple[Statement, ...]) -> tuple[tuple[Statement, ...], tuple[Statement, ...]]:
    """The jump at the end of a loop, and what stands before."""
    last = body[-1] if body else None
    is_end = isinstance(last, If) and last.yes == (Break(),)
    return (body[-1:], body[:-1]) if is_end else ((), body)


def backward_loop(s: For | While, count: Variable | None, body: tuple[Statement, ...], taken: set[str]) -> Statement:
    """The loop of the reverse sweep: the steps in the other direction.

    Parameters
    ----------
    s : For or While
    count : Variable, optional
        How many steps were taken, where that is not known before.
    body : tuple of statements
        One step of the reverse sweep.
    taken : set of str
        All names.
    """
    if isinstance(s, While):
        assert count is not None
        k = Variable(fresh_name("step", taken), INT)
        return For(k, integer(0), count, 1, body)
    steps: Expression
    if count is not None:
        steps = count
    elif abs(s.step) == 1:
        return For(s.variable, _less(s.stop, s.step), _less(s.start, s.step), -s.step, body)
    else:
        high, low = (s.stop, s.start) if s.step > 0 else (s.start, s.stop)
        length = plus(Binary("-", high, low, INT), integer(abs(s.step) - 1))
        steps = Binary("//", length, integer(abs(s.step)), INT)
    last = plus(s.start, Binary("*", _less(steps, 1), integer(s.step), INT))
    return For(s.variable, last, _less(s.start, s.step), -s.step, body)


def _less(value: Expression, by: int) -> Expression:
    return plus(value, integer(-by))

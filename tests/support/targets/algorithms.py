"""Results of algorithms beside those of their text run as Python."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bladesmith.codegen.build import extension

needs_compiler = pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")


def as_tuple(found: Any) -> tuple[Any, ...]:
    return found if isinstance(found, tuple) else (found,)


def references(function: Any, arguments: tuple[Any, ...], static: tuple[Any, ...], numbers: Any) -> list[Any]:
    """Results of the text, item by item; arguments that all items share have fewer axes."""
    rows = []
    for i in range(len(arguments[0])):
        own = [a if a.ndim == 2 and a.shape[1] == 1 and a.dtype.kind == "i" else a[i] for a in arguments]
        rows.append(as_tuple(function.reference(*own, *static, numbers=numbers)))
    return [np.array([np.asarray(row[k]) for row in rows]) for k in range(len(rows[0]))]


def same(found: Any, expected: list[Any]) -> None:
    for a, b in zip(as_tuple(found), expected, strict=True):
        assert np.array_equal(np.asarray(a), b.astype(np.asarray(a).dtype), equal_nan=np.asarray(a).dtype.kind == "f")
        if np.asarray(a).dtype.kind == "f":
            known = ~np.isnan(b)
            assert np.array_equal(np.signbit(a)[known], np.signbit(b)[known])

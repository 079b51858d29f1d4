"""The JSON files of the package `clifford` (format 0.0.1), without the package: batches of dense multivectors.

A file holds a metric, names of basis vectors, and rows of 2^n coefficients in the order of `clifford`'s layouts: by
grade, then by the vectors' places.
"""

from __future__ import annotations

import json
import os
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.documents.text import read_text
from ..codegen.errors import BladesmithError, InputError, SignatureError
from ..common.files import as_path, write_file
from ..common.validation import as_instance, check_shape
from ..core.conversion import basis_change
from ..core.conversion.clifford_layouts import blade_table
from ..core.multivector import Algebra, Multivector
from ..core.registry import algebra as algebra_by_signature

VERSION = "0.0.1"
#: 2^n coefficients per multivector: larger algebras do not fit such files.
MOST_VECTORS = 12


def save_json(path: str | os.PathLike[str], x: Multivector) -> None:
    """Write multivectors as `clifford.io.read_json_file` reads them; null bases become orthonormal.

    Parameters
    ----------
    path : path
    x : Multivector
        One, or a batch (n,).

    Raises
    ------
    InputError
        If the batch has more dimensions, the algebra is too large, or the file cannot be written.
    """
    if as_instance(x, "x", Multivector).ndim > 1:
        check_shape(x, "x", ("n",), remedy="Reshape it first")
    file = as_path(path, "multivectors are written to")
    own = x.to_basis("orthonormal")
    algebra = own.algebra
    squares = _checked_squares(tuple(int(algebra.metric[i][i]) for i in range(algebra.dimension)))
    columns, signs = blade_table(algebra, squares, _blades(len(squares)))
    rows = np.atleast_2d(basis_change.dense(own, algebra)[..., columns] * signs)
    if not np.isfinite(rows).all():
        raise InputError("some items are not finite, which JSON cannot say; leave them out.")
    document = {
        "version": VERSION,
        "dataset": {"data": rows.tolist(), "transpose": False, "sparse": False, "support": []},
        "metric": np.diag(squares).tolist(),
        "basis_names": [f"e{v}" for v in algebra.vectors],
    }
    write_file(file, json.dumps(document))


def load_json(path: str | os.PathLike[str], algebra: Algebra | None = None) -> Multivector:
    """Multivectors (n,) of a file that `clifford.io.write_json_file` wrote.

    Parameters
    ----------
    path : path
    algebra : Algebra, optional
        Where they shall go, for example ``bs.cga3d``. Default: ``bs.algebra(p, q, r)`` of the file's metric.

    Raises
    ------
    InputError
        If the file is missing, damaged, sparse or not of this format.
    SignatureError
        If its metric is not orthonormal.
    AlgebraMismatchError
        If it is not that of ``algebra``.
    """
    file = as_path(path, "multivectors are read from")
    if algebra is not None:
        as_instance(algebra, "algebra", Algebra, "one such as bladesmith.cga3d")
    try:
        rows, squares = _contents(json.loads(read_text(file)))
    except BladesmithError as error:
        raise type(error)(error.what, where=str(path), remedy=error.remedy) from None
    except (ValueError, KeyError, TypeError, OverflowError, RecursionError) as error:
        raise InputError(f"not a JSON file of clifford ({error})", where=str(path)) from None
    made = _multivectors(rows, squares)
    return made if algebra is None else algebra.multivector(made)


def _contents(document: Any) -> tuple[NDArray[np.float64], tuple[int, ...]]:
    """Rows of coefficients and the squares of the basis vectors."""
    if document["version"] != VERSION:
        raise ValueError(f"its version is {document['version']!r}, not {VERSION}")
    data = document["dataset"]
    if data["sparse"]:
        raise ValueError("its coefficients are sparse; write it with sparse=False")
    rows = np.array(data["data"], float)
    rows = np.atleast_2d(rows.T if data["transpose"] else rows)
    metric = np.array(document["metric"], float)
    if metric.ndim == 1:
        metric = np.diag(metric)
    if metric.ndim != 2 or metric.shape[0] != metric.shape[1] or (metric != np.diag(np.diag(metric))).any():
        raise SignatureError("its metric is not diagonal.")
    squares = _checked_squares(tuple(np.diag(metric)))
    if not len(data["data"]):
        rows = np.empty((0, 2 ** len(squares)))  # a batch of no items
    if rows.ndim != 2 or rows.shape[1] != 2 ** len(squares):
        raise ValueError(f"rows of {rows.shape[-1]} coefficients do not fit {len(squares)} basis vectors")
    if not np.isfinite(rows).all():
        raise ValueError("some coefficients are not finite")
    return rows, squares


def _multivectors(rows: NDArray[np.float64], squares: tuple[int, ...]) -> Multivector:
    home = algebra_by_signature(*(squares.count(s) for s in (1, -1, 0)))
    columns, signs = blade_table(home, squares, _blades(len(squares)))
    dense = np.zeros_like(rows)
    dense[:, columns] = rows * signs
    present = [i for i in range(len(home.blades)) if dense[:, i].any()] or [0]
    return home.multivector(np.ascontiguousarray(dense[:, present]), blades=[home.blades[i] for i in present])


def _checked_squares(squares: tuple[float, ...]) -> tuple[int, ...]:
    if len(squares) > MOST_VECTORS:
        raise InputError(f"{len(squares)} basis vectors have 2^{len(squares)} coefficients each; too many for a file.")
    if any(s not in (1, -1, 0) for s in squares):
        raise SignatureError(f"the basis vectors have the squares {squares}; they are 1, -1 or 0 here.")
    return tuple(int(s) for s in squares)


def _blades(n: int) -> tuple[tuple[int, ...], ...]:
    """Blades of a layout by the places of their vectors: by grade, then in order."""
    return tuple(blade for grade in range(n + 1) for blade in combinations(range(n), grade))

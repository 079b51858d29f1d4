"""The registration driver for numba: the loops of the C driver in Python, and its kernels on rows of flat arrays."""

from __future__ import annotations

from functools import cache

from ...build import source_digest, text_cache
from ...optimise.variants import as_written
from ...targets.numba.rows import row_function
from ...targets.templates import render
from ..kernel_spec import trace_spec
from .registration import driver_spec, in_order

_TEMPLATE = "reform.py.j2"
#: What it includes.
_PARTS = tuple(f"reform_{part}.py.j2" for part in ("solve", "loops", "frames", "stages"))
#: What the text depends on, from the package's folder.
_SOURCES = (
    "programs/registration/registration_numba.py", "formulas/registration/registration.py", "specs/cga3d.toml",
    *(f"../templates/numba/{name}" for name in (_TEMPLATE, *_PARTS)),
)  # fmt: skip
#: Of float64.
EPSILON = 2.0**-52
_DIGITS = 24


@cache
def reform_numba(kinds: tuple[str, ...]) -> str:
    """The text of the driver of these kinds: made once for each state of the sources, and kept in the cache.

    Raises
    ------
    InputError
        If there is no such kind, or none at all.
    """
    wanted = in_order(kinds)
    digest, name = source_digest.digest(_SOURCES), f"{'_'.join(wanted)}.py"
    group = digest and f"reform_numba_{digest[:_DIGITS]}"
    found = text_cache.read(group, name) if group else None
    if found is None:
        found = _text(wanted)
        if group:
            text_cache.write(group, {name: found})
    elif group:
        text_cache.touch(group)
    return found


def _text(wanted: tuple[str, ...]) -> str:
    made = driver_spec(wanted)
    functions = [row_function(as_written(trace_spec(each))) for each in made.specs]
    return render(_TEMPLATE, **made.values, functions=functions, epsilon=repr(EPSILON))

"""The numba target: its text run as plain Python, on columns and compiled gives the bits of the C target."""

from __future__ import annotations

import linecache
import re
import sys
import traceback
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from bladesmith.codegen.compiler import bind_numba
from bladesmith.codegen.errors import InputError, MissingExtraError, ShapeError
from bladesmith.codegen.execute import numba_jit, ranges
from bladesmith.codegen.execute.bound_kernels import BoundKernel
from bladesmith.codegen.execute.numba_jit import NumbaKernel, load
from bladesmith.codegen.optimise.variants import as_written
from bladesmith.codegen.status import Status
from bladesmith.codegen.targets.c.printer import symbol
from bladesmith.codegen.targets.numba.printer import numba_source
from bladesmith.codegen.trace.kernel import interface
from bladesmith.codegen.trace.trace import trace
from bladesmith.templates.numba.rows import BLOCK

from ...support.specimens import KERNELS, VARIANTS, arguments, as_tuple, assert_same_bits

DTYPES = [np.float64, np.float32]
COUNT = 131  # two full blocks of the compiled loop and a rest
#: Only some are compiled, because that takes seconds; they hold all that compiling could change.
COMPILED = [f"cga3d_{name}" for name in ("blend_by_call", "normalized", "rows", "masks", "elementary")]
each_kernel = pytest.mark.parametrize("name", KERNELS)
each_dtype = pytest.mark.parametrize("dtype", DTYPES, ids=["f64", "f32"])


def plain(name: str) -> NumbaKernel:
    return bind_numba(VARIANTS[name], compiled=False)


def shared_last(operands: list[Any]) -> list[Any]:
    """The last of several operands has one row for all items."""
    return [*operands[:-1], operands[-1][:1]] if len(operands) > 1 else operands


@pytest.mark.compiles
@each_kernel
@each_dtype
def test_columns_give_the_bits_of_c(name: str, dtype: Any, compiled_c: Callable[[str], BoundKernel]) -> None:
    operands = arguments(KERNELS[name], COUNT, dtype=dtype)
    expected = compiled_c(name)(*operands)
    assert as_tuple(expected)[0].dtype == dtype
    assert_same_bits(plain(name)(*operands), expected, name)


@pytest.mark.slow
@each_kernel
@each_dtype
def test_the_printed_loop_as_plain_python(name: str, dtype: Any, compiled_c: Callable[[str], BoundKernel]) -> None:
    operands = shared_last(arguments(KERNELS[name], BLOCK + 3, dtype=dtype))
    expected = as_tuple(compiled_c(name)(*operands))
    results = [np.empty_like(e) for e in expected]
    module = load(numba_source([VARIANTS[name]]), dtype, compiled=False)
    rows: list[Any] = [result.reshape(BLOCK + 3, -1) for result in results]
    for operand in operands:
        rows += [operand.reshape(len(operand), -1), int(len(operand) > 1)]
    with np.errstate(all="ignore"):
        getattr(module, f"{name}_batch")(0, BLOCK + 3, *rows)
    assert_same_bits(tuple(results), expected, name)


@pytest.mark.slow
@pytest.mark.parametrize("name", COMPILED)
@each_dtype
def test_compiled_gives_the_bits_of_c(name: str, dtype: Any, compiled_c: Callable[[str], BoundKernel]) -> None:
    fast = bind_numba(VARIANTS[name])
    operands = arguments(KERNELS[name], COUNT, dtype=dtype)
    expected = compiled_c(name)(*operands)
    assert_same_bits(fast(*operands), expected, name)
    for operand in operands:
        operand.setflags(write=False)
    assert_same_bits(fast(*operands), expected, name)  # and nothing is compiled again
    assert len(fast._batches[np.dtype(dtype)].signatures) == 1
    again = NumbaKernel(fast.library, name, *interface(KERNELS[name]))
    assert again(*operands) is not None and len(fast._batches[np.dtype(dtype)].signatures) == 1
    shared = shared_last(operands)
    assert_same_bits(fast(*shared), compiled_c(name)(*shared), name)


def test_singular_items_have_a_status_and_nan() -> None:
    rotor = np.array([[1.0, 0, 0, 0], [0, 0, 0, 0], [0, np.inf, 0, 0]])
    value, status = plain("cga3d_normalized")(rotor)
    assert status.tolist() == [Status.OK, Status.SINGULAR, Status.INVALID] and status.dtype == np.uint8
    assert np.isnan(value[1:]).all() and value[0].tolist() == [1, 0, 0, 0]


@pytest.mark.slow
@pytest.mark.parametrize("compiled", [False, True])
def test_shapes_broadcast_and_are_checked(compiled: bool) -> None:
    move = bind_numba(VARIANTS["cga3d_move_point"], compiled)
    motor, point = arguments(KERNELS["cga3d_move_point"], 6)
    grid = move(motor.reshape(2, 3, 8), point[0])
    assert grid.shape == (2, 3, 5)
    assert np.array_equal(grid[1, 2], move(motor[5], point[0]))
    assert move(motor[:0], point[0]).shape == (0, 5)
    shifted = np.frombuffer(b"." + point.tobytes(), np.float64, offset=1).reshape(6, 5)
    assert np.array_equal(move(motor, shifted), move(motor, point), equal_nan=True)
    with pytest.raises(ShapeError, match="last axis must have 8"):
        move(motor[:, :7], point)
    with pytest.raises(InputError, match="takes 2 arrays"):
        move(motor)


def test_ranges_may_be_shared_out(splitter: list[tuple[int, int]]) -> None:
    name = "cga3d_compose"
    operands = arguments(KERNELS[name], 1000)
    shared_out = plain(name)(*operands)
    assert len(splitter) == 3
    ranges.install_splitter(None)
    assert_same_bits(shared_out, plain(name)(*operands), name)


@pytest.fixture
def splitter() -> Iterator[list[tuple[int, int]]]:
    parts: list[tuple[int, int]] = []

    def split(run: Callable[[int, int], None], n: int, first: int | None = None, unit: int = 1) -> None:
        edges = [0, n // 3, n // 2, n]
        for begin, end in zip(edges, edges[1:], strict=False):
            parts.append((begin, end))
            run(begin, end)

    before = ranges.splitter
    ranges.install_splitter(split)
    yield parts
    ranges.install_splitter(before)


def test_constants_have_the_type_of_the_precision() -> None:
    text = numba_source(list(VARIANTS.values()))
    code = "\n".join(line.split("#")[0] for line in text.splitlines())
    assert "K(0.5)" in code
    assert not re.findall(r"(?<![\w.])[\d.]+\.\d+", re.sub(r"K\([-+.\de]+\)", "", code))


def test_the_same_text_every_time() -> None:
    assert numba_source(list(VARIANTS.values())) == numba_source(list(VARIANTS.values()))


def test_tracebacks_show_the_generated_lines() -> None:
    module = load(numba_source([VARIANTS["cga3d_compose"]]), compiled=False)
    with pytest.raises(TypeError) as caught:
        module.cga3d_compose(*["text"] * 16)
    shown = "".join(traceback.format_exception(caught.value))
    assert " * y_e" in shown
    line = module.cga3d_compose.__code__.co_firstlineno
    assert "def cga3d_compose(" in linecache.getline(module.cga3d_compose.__code__.co_filename, line)


def test_a_note_cannot_leave_its_comment() -> None:
    kind = KERNELS["cga3d_compose"].inputs[0].kind
    note = 'ends a comment */ or a string """\nimport nothing /* \\'
    kernel = trace(lambda m: ~m, [kind], "reverse", note=note)
    variant = as_written(kernel)
    load(numba_source([variant]), compiled=False)
    from bladesmith.codegen.targets.c.extension import bodies_text

    comment = next(t for t in bodies_text([variant]).splitlines() if "cga3d_reverse:" in t)
    assert comment.count("*/") == 1 and comment.count("/*") == 1


def test_without_numba_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "numba", None)
    numba_jit.numba.cache_clear()
    try:
        with pytest.raises(MissingExtraError, match=r"bladesmith\[numba\]"):
            bind_numba(VARIANTS["cga3d_compose"])
        assert plain("cga3d_compose")(*arguments(KERNELS["cga3d_compose"], 2)).shape == (2, 8)
    finally:
        numba_jit.numba.cache_clear()


def test_symbols_are_the_names_of_c() -> None:
    module = load(numba_source(list(VARIANTS.values())), compiled=False)
    assert all(callable(getattr(module, f"{symbol(kernel)}_batch")) for kernel in KERNELS.values())

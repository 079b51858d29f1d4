"""Arrays in and out of multivectors without copies: `__array__`, DLPack, and views with ``copy=False``."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import pga3d as pga
from bladesmith.errors import InputError, KindError

MOTOR = pga.layout("motor")


class Exported:
    """An array of a package that NumPy knows by DLPack alone."""

    def __init__(self, array: np.ndarray, device: tuple[int, int] = (1, 0)) -> None:
        self.array, self.device = array, device

    def __dlpack__(self, **options: Any) -> Any:
        if self.device[0] != 1:
            raise BufferError("on a GPU")
        return self.array.__dlpack__(**options)

    def __dlpack_device__(self) -> tuple[int, int]:
        return self.device


def test_values_go_out_without_copies_and_read_only() -> None:
    x = pga.point(np.arange(6.0).reshape(2, 3))
    for array in (np.asarray(x), np.from_dlpack(x)):  # type: ignore[arg-type]
        assert np.shares_memory(array, x.values) and not array.flags.writeable
        np.testing.assert_array_equal(array, x.values)
    assert np.array(x).flags.writeable and not np.shares_memory(np.array(x), x.values)
    assert np.asarray(x, np.float32).dtype == np.float32
    writable = np.from_dlpack(x.copy())  # type: ignore[arg-type]
    assert writable.flags.writeable
    with pytest.raises(ValueError, match="copy"):
        np.array(x, np.float32, copy=False)


@pytest.mark.parametrize("export", [lambda a: a, Exported, memoryview])
def test_a_view_sees_what_is_written(export: Any) -> None:
    array = np.arange(16.0).reshape(2, 8)
    view = pga.multivector(export(array), kind=MOTOR, copy=False)
    copy = pga.multivector(export(array), kind=MOTOR)
    assert np.shares_memory(view.values, array) and view.kind == MOTOR
    before = (view * view).values.copy()
    assert view.isclose(copy).all()
    array *= 2
    np.testing.assert_array_equal((view * view).values, 4 * before)
    np.testing.assert_array_equal((copy * copy).values, before)
    view.values[0, 0] = 100.0
    assert array[0, 0] == 100.0


def test_a_view_of_a_read_only_array_is_read_only() -> None:
    array = np.ones((2, 8))
    array.flags.writeable = False
    view = pga.multivector(array, kind=MOTOR, copy=False)
    assert np.shares_memory(view.values, array) and not view.values.flags.writeable


@pytest.mark.parametrize(
    ("values", "options", "error", "message"),
    [
        (np.ones(8), {"kind": "motor"}, KindError, "others may write to"),
        (np.ones((8, 8)).T, {"kind": MOTOR}, InputError, "not contiguous"),
        (np.ones(8, int), {"kind": MOTOR}, InputError, "its type is int64"),
        (np.ones(8, ">f8"), {"kind": MOTOR}, InputError, "its type is >f8"),
        ([1.0] * 8, {"kind": MOTOR}, InputError, "no array"),
        (np.ones(2), {"blades": ["e1", "e2"]}, InputError, "columns have names"),
        (np.ones(8), {"kind": MOTOR, "dtype": np.float32}, InputError, "need a copy"),
        (np.ones(7), {"kind": MOTOR}, InputError, "shape"),
    ],
)
def test_what_cannot_be_shared_is_refused(values: Any, options: Any, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        pga.multivector(values, copy=False, **options)


def test_arrays_on_other_devices_are_refused() -> None:
    with pytest.raises(InputError, match="Copy it to the host"):
        pga.multivector(Exported(np.ones(8), (2, 0)), kind=MOTOR)
    np.testing.assert_array_equal(cga.point(Exported(np.ones(3))).values, cga.point(np.ones(3)).values)


def test_multivectors_are_still_no_coordinates() -> None:
    x = pga.point(np.ones((2, 3)))
    for wrong in (lambda: pga.point(x), lambda: x + [x], lambda: pga.point([[x, x]]), lambda: pga.scalar(x)):  # type: ignore[operator]
        with pytest.raises(InputError, match="a multivector is not an array"):
            wrong()

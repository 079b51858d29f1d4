"""Arrays of users in any layout: at odd bytes, with gaps, read-only, of the other order of bytes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import codegen, objects, poses
from bladesmith.codegen.execute import arrays
from bladesmith.codegen.execute.bound_kernels import BoundKernel


def at_an_odd_byte(x: Any) -> Any:
    place = np.frombuffer(bytearray(x.nbytes + 1), np.uint8, offset=1).view(x.dtype).reshape(x.shape)
    place[...] = x
    assert not place.flags.aligned
    return place


def with_gaps(x: Any) -> Any:
    return np.repeat(x, 2, axis=-1)[..., ::2]


def backwards(x: Any) -> Any:
    return x[::-1].copy()[::-1]


def read_only(x: Any) -> Any:
    x = x.copy()
    x.flags.writeable = False
    return x


def of_the_other_order(x: Any) -> Any:
    return x.astype(x.dtype.newbyteorder())


LAYOUTS = [at_an_odd_byte, with_gaps, backwards, read_only, np.asfortranarray, of_the_other_order]


@codegen.kernel(cga.kind("point"), cga.kind("point"))
def product(x: Any, y: Any) -> Any:
    return x | y


RANDOM = np.random.default_rng(8)
XYZ, AXES, NUMBERS = RANDOM.normal(size=(2, 6, 3)).tolist() + [RANDOM.uniform(0.2, 0.8, 6).tolist()]
CALLS: dict[str, Callable[[Callable[[Any], Any]], Any]] = {
    "circle": lambda of: cga.circle(of(XYZ), of(AXES), of(NUMBERS)),
    "coefficients": lambda of: cga.multivector({"e1": of(NUMBERS), "e12": of(NUMBERS)}),
    "rows": lambda of: cga.multivector(of(XYZ), blades=["e1", "e2", "e3"]),
    "times numbers": lambda of: cga.point(of(XYZ)) * of(NUMBERS),
    "fit": lambda of: objects.fit_plane(of(XYZ), of(NUMBERS)),
    "interpolate": lambda of: objects.interpolate(cga.point(of(XYZ)), cga.point(of(AXES)), alpha=of(NUMBERS)),
    "exp": lambda of: poses.exp(np.concatenate([of(XYZ), of(AXES)], -1)),
    "kernel": lambda of: product(*(of(cga.point(XYZ).values.tolist()) for _ in range(2))),
    "kernel, one item": lambda of: product(*(of(cga.point(XYZ[0]).values.tolist()) for _ in range(2))),
}


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
def test_a_layout_changes_no_bit_and_no_precision(
    call: Callable[..., Any], layout: Callable[[Any], Any], dtype: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = call(lambda x: np.array(x, dtype))
    checked = []
    for name in ("run", "pair"):
        whole = getattr(BoundKernel, name)

        def watched(self: Any, *given: Any, whole: Any = whole, name: str = name) -> Any:
            result = whole(self, *given)
            reached = given[0] if name == "run" else given if result is not None else ()
            checked.extend(x.flags.aligned and x.dtype.isnative for x in reached)
            return result

        monkeypatch.setattr(BoundKernel, name, watched)
    found = call(lambda x: layout(np.array(x, dtype)))
    assert all(checked)
    one, other = (x.values if hasattr(x, "values") else x for x in (found, expected))
    assert one.dtype == other.dtype and np.array_equal(one, other)


def test_bound_calls_copy_what_c_cannot_read() -> None:
    given = at_an_odd_byte(cga.point(XYZ).values)
    plan = product.plan(given, given) if hasattr(product, "plan") else None
    assert plan is None or all(x.flags.aligned for x in plan.arrays)
    assert arrays.floating(given, "x").flags.aligned

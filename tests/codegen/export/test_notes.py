"""What files say of the rounding of kernels is true: exact results, results without a bound, and bounds."""

from __future__ import annotations

import pytest

from bladesmith import codegen, pga3d
from bladesmith.codegen.export.notes import kernel_notes

MOTOR, POINT = pga3d.kind("motor"), pga3d.kind("point")
KERNELS = {
    "Rounding: none": codegen.kernel(POINT, name="same")(lambda x: x),
    "Rounding: only by underflow": codegen.kernel(pga3d.layout("motor"), name="half")(lambda m: m * 0.5),
    "Rounding: no bound, since": codegen.kernel(pga3d.layout("motor"), name="logarithm")(lambda m: codegen.ga.log(m)),
    "Rounding: at most about": codegen.kernel(MOTOR, POINT, name="moved")(lambda m, x: m >> x),
    "Rounding: only where numbers are compared": codegen.kernel(
        codegen.scalar, codegen.scalar, algebra=pga3d, name="larger"
    )(lambda x, y: codegen.select(x > y, x.constant(1), x.constant(2))),
}


@pytest.mark.parametrize("says", list(KERNELS))
def test_rounding(says: str) -> None:
    assert says in kernel_notes(KERNELS[says].variant)[-1]

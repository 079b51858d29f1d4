"""Controls of evolved surfaces: what is no row of circles is refused."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import tracer
from bladesmith.errors import SceneError

from ...support.tracer.scenes import TUBE

RING, OTHER = TUBE


@pytest.mark.parametrize(
    ("controls", "message"),
    [
        ({RING, OTHER}, "curve is a set"),
        ([({0, 1, 2}, (0, 0, 1), 1.0), OTHER], r"controls\[0\].center is {0, 1, 2}"),
        ([((0, 0, 0), (0, 0, 1), True), OTHER], r"controls\[0\].radius is True"),
        ([RING, ((0, 0, 0), (0, 0, 1), np.True_)], r"controls\[1\].radius"),
        ([(np.array([0, 0, 0], object), (0, 0, 1), 1.0), OTHER], r"controls\[0\].center"),
        ([(np.ma.array([0.0, 0, 0], mask=[0, 1, 0]), (0, 0, 1), 1.0), OTHER], r"controls\[0\].center"),
        (np.array([[np.zeros(3), np.ones(3), 1.0]] * 2, object), "array of type object"),
        (np.ma.array(np.ones((2, 10))), "masked numbers"),
        (np.ones((2, 10)) * 1j, "array of type complex128"),
        ([dict(zip(("center", "normal", "radius", "colour"), (*RING, 3), strict=True)), OTHER], "has 'colour'"),
        ([cga.point_pair((0, 0, 0), (1, 0, 0)), cga.point_pair((0, 0, 0), (1, 1, 0))], "is a point pair, not a circle"),
        (cga.circle(np.zeros((2, 2, 3)), (0, 0, 1), 1.0), r"batch of shape \(2,\)"),
    ],
)
def test_what_is_no_row_of_circles_is_refused(controls: object, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        tracer.EvolvedCircles(controls)

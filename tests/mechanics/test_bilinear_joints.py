"""Joints of any bilinear map of two objects, against the rows that it forbids."""

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import kinematics as kin
from bladesmith import pga3d as pga

from ..support.kinematics import columns, slide, turn
from ..support.mechanisms.joints import P, Q, U, W

pytestmark = pytest.mark.filterwarnings("error")


def on_plane(p, n):
    """A point stays in a plane: all twists that do not move it along the normal."""
    return np.concatenate([np.cross(p, n), n])[None]


#: x, y, product, H, the rows that it forbids on the twist of y's body against x's.
BILINEAR = {
    "a point on a plane": (cga.plane(U, P @ U), cga.point(P), "outer", 0, on_plane(P, U)),
    "a point on a plane, pga": (pga.plane(U, P @ U), pga.point(P), "outer", 0, on_plane(P, U)),
    "a point at a height": (cga.plane(U, 0), cga.point(P), lambda x, y: x ^ y, None, on_plane(P, U)),
    "a plane on a point": (cga.point(P), cga.plane(U, P @ U), "outer", 0, on_plane(P, U)),
    "a point on a line": (
        cga.line(P - 2 * U, U),
        cga.point(P),
        "outer",
        0,
        np.concatenate([on_plane(P, W), on_plane(P, np.cross(U, W))]),
    ),
    "a rod": (cga.point(Q), cga.point(P), "inner", None, on_plane(P, P - Q)),
    "a point on a sphere": (cga.sphere(Q, np.linalg.norm(P - Q)), cga.point(P), "outer", 0, on_plane(P, P - Q)),
    "an angle of planes": (
        cga.plane(U, 0.2),
        cga.plane(W + 0.3 * U, 1.0),
        "inner",
        None,
        np.concatenate([np.cross(U, W), np.zeros(3)])[None],
    ),
    "an angle of planes, pga": (
        pga.plane(U, 0.2),
        pga.plane(W + 0.3 * U, 1.0),
        "inner",
        None,
        np.concatenate([np.cross(U, W), np.zeros(3)])[None],
    ),
    "centres and right angles": (
        cga.circle(P, U, 1),
        cga.circle(P, W, 1),
        "anticommutator",
        0,
        on_plane(P, np.cross(U, W)),
    ),
}


@pytest.mark.parametrize("name", BILINEAR)
def test_bilinear_joints(name):
    x, y, product, h, rows = BILINEAR[name]
    joint = kin.Bilinear("g", "x", x, y, product, H=h)
    m = kin.Mechanism(["g", "x"], "g", joint)
    forbidden = m.constraint_matrix().toarray() @ columns(m.algebra)
    if name == "centres and right angles":  # the thesis's universal joint: one sphere and no more than a right angle
        assert m.mobility() == 4
        return
    assert m.mobility() == 6 - len(rows)
    left = np.linalg.svd(rows)[2][len(rows) :]
    assert np.abs(forbidden @ left.T).max() < 1e-12
    assert np.linalg.matrix_rank(forbidden) == len(rows)


def test_products_by_name_are_functions():
    line, point, circle = cga.line(Q, U), cga.point(P), cga.circle(P, W, 0.7)
    names = {
        "outer": (lambda x, y: x ^ y, line, point),
        "inner": (lambda x, y: x | y, circle, cga.circle(Q, U, 0.4)),
        "anticommutator": (lambda x, y: (x * y + y * x) / 2, circle, cga.plane(U, 0.3)),
        "meet": (lambda x, y: x.meet(y), cga.plane(W, 0.1), cga.plane(U, 0.3)),
    }
    for name, (function, x, y) in names.items():
        own = [
            kin.Mechanism(["g", "x"], "g", kin.Bilinear("g", "x", x, y, product, H=None))
            for product in (name, function)
        ]
        assert own[0].mobility() == own[1].mobility() < 6
        spaces = [np.linalg.pinv(c) @ c for c in (m.constraint_matrix().toarray() for m in own)]
        np.testing.assert_allclose(*spaces, atol=1e-10)


def test_meet_of_a_sphere_and_a_plane():
    sphere, plane = cga.sphere(Q, 2.0), cga.plane(U, Q @ U + 0.5)
    m = kin.Mechanism(["g", "x"], "g", kin.Bilinear("g", "x", sphere, plane, "meet", H=None))
    rows = m.constraint_matrix().toarray() @ columns(cga)
    free = [turn(U, Q), slide(W), slide(np.cross(U, W))]  # of the plane: in itself; the circle stays in the first body
    assert m.mobility() == 3 and np.abs(rows @ np.array(free).T).max() < 1e-12

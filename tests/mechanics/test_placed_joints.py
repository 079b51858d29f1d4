"""Joints by a position and directions: their free motions are those of textbooks, in both algebras."""

import pickle

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import kinematics as kin
from bladesmith import pga3d as pga
from bladesmith.errors import GradeError, InputError

from ..support.kinematics import shift, six, slide, turn

PLACE, AXIS = np.array([1.0, -2.0, 0.5]), np.array([0.3, 0.4, -1.2])
ACROSS = np.array([4.0, -3.0, 0.0])
UNIT = AXIS / np.linalg.norm(AXIS)
JOINTS = {
    "Spherical": ({"point": PLACE}, turn(np.eye(3), PLACE)),
    "Revolute": ({"point": PLACE, "axis": AXIS}, turn(UNIT, PLACE)[None]),
    "Cylindrical": ({"point": PLACE, "axis": AXIS}, np.stack([turn(UNIT, PLACE), slide(UNIT)])),
    "Screw": ({"point": PLACE, "axis": AXIS, "pitch": 0.2}, (turn(UNIT, PLACE) + 0.2 * slide(UNIT))[None]),
    "Prismatic": ({"axis": AXIS}, slide(UNIT)[None]),
    "Planar": (
        {"point": PLACE, "normal": AXIS}, np.stack([turn(UNIT, PLACE), slide(ACROSS), slide(np.cross(UNIT, ACROSS))]),
    ),
    "Universal": (
        {"point": PLACE, "axis_a": AXIS, "axis_b": ACROSS}, np.stack([turn(UNIT, PLACE), turn(ACROSS, PLACE)]),
    ),
}  # fmt: skip


@pytest.mark.parametrize("algebra", [cga, pga])
@pytest.mark.parametrize("name", JOINTS)
def test_free_motions(name, algebra):
    given, expected = JOINTS[name]
    if name == "Universal" and algebra is pga:
        with pytest.raises(InputError, match="a universal joint is not of pga3d"):
            kin.Universal("a", "b", algebra=algebra, **given)
        return
    joint = pickle.loads(pickle.dumps(getattr(kin, name)("a", "b", algebra=algebra, **given)))
    m = kin.Mechanism(["a", "b"], "a", joints=[joint])
    assert m.algebra.name == algebra.name and m.mobility() == len(expected)
    rows = six(m.allowed_twists("b")) @ shift(PLACE).T
    both = np.concatenate([rows, expected @ shift(PLACE).T])
    assert np.linalg.matrix_rank(both, tol=1e-9) == len(expected)
    if len(expected) == 1:  # positive along the axis
        np.testing.assert_allclose(six(m.solve({joint: 1.0})["b"]), expected[0], atol=1e-12)


@pytest.mark.parametrize("size", [1e-320, 1e-200, 1e200, 1e308])
def test_directions_have_any_length(size):
    for name in ("Revolute", "Prismatic", "Planar"):
        wanted, given = (
            getattr(kin, name)("a", "b", point=PLACE, **{"normal" if name == "Planar" else "axis": direction})
            for direction in ((0, 0.5, 0.5), (0, size, size))
        )
        for one, other in zip(wanted.conditions(), given.conditions(), strict=True):
            found, expected = (c.x.values / np.abs(c.x.values).max() for c in (other, one))
            np.testing.assert_allclose(found, expected, atol=1e-4 if size < 1e-300 else 1e-12)


def test_a_prismatic_joint_is_drawn_where_it_is():
    joint = kin.Prismatic("a", "b", axis=AXIS, point=PLACE)
    line = joint.first.parameters()
    np.testing.assert_allclose(np.cross(PLACE - line.point, UNIT), 0, atol=1e-12)


@pytest.mark.parametrize(
    "make, error, says",
    [
        (lambda: kin.Revolute("a", "b"), InputError, "has no point. Give point= and axis=, or the objects that"),
        (lambda: kin.Revolute("a", "b", point=PLACE), InputError, r"Revolute\('a', 'b'\) has no axis"),
        (lambda: kin.Revolute("a", "b", cga.circle(PLACE, AXIS, 1), axis=AXIS), InputError, "Give one of them"),
        (lambda: kin.Cylindrical("a", "b", cga.line(PLACE, AXIS), point=PLACE), InputError, "by point= and axis= too"),
        (lambda: kin.Planar("a", "b", cga.plane(UNIT, 0), algebra=cga), InputError, "Give one of them"),
        (lambda: kin.Revolute("a", "b", point=PLACE, axis=(0, 0, 0)), InputError, "its axis is zero"),
        (lambda: kin.Screw("a", "b", point=(0, np.nan, 0), axis=AXIS, pitch=1), InputError, r"its point\[1\] is nan"),
        (lambda: kin.Spherical("a", "b", point=(0, 1)), InputError, "its point has shape"),
        (lambda: kin.Spherical("a", "b", point=PLACE, algebra="pga"), InputError, "its algebra is 'pga'"),
        (lambda: kin.Spherical("a", "b", point=PLACE, algebra=__import__("bladesmith").vga3d), GradeError, "no screws"),
        (lambda: kin.Prismatic("a", "b", cga.line(PLACE, AXIS)), InputError, "has one object; it is of two. Give two"),
        (lambda: kin.Universal("a", "b", point=PLACE, axis_a=AXIS, axis_b=AXIS), InputError, "not at right angles"),
    ],
)
def test_what_is_missing_or_wrong(make, error, says):
    with pytest.raises(error, match=says):
        make()

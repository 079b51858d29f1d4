"""Attributes that multivectors do not have: what has them."""

import pickle

import pytest

import bladesmith as bs
from bladesmith import cga3d, objects, pga3d, poses
from bladesmith.core.attribute_names import INTERNAL
from bladesmith.errors import GradeError, InputError


def test_parameters_are_no_attributes() -> None:
    circle = cga3d.circle([1, 2, 3], [0, 0, 1], 2.0)
    for name in ("center", "radius", "normal"):
        with pytest.raises(AttributeError, match=rf"no attribute '{name}'; .*\.parameters\(\)\.{name}$"):
            getattr(circle, name)
        getattr(circle.parameters(), name)
    with pytest.raises(AttributeError, match="no attribute 'radiance'$"):
        circle.radiance  # noqa: B018
    assert not hasattr(circle, "center") and pickle.loads(pickle.dumps(circle)).isclose(circle)


def test_objects_and_poses_are_interpolated_by_their_own_functions() -> None:
    circle, pose = cga3d.circle([0, 0, 0], [0, 0, 1], 1.0), pga3d.translator([1, 2, 3])
    for pair in ((circle, circle), (pose, circle)):
        with pytest.raises(InputError, match=r"is a circle, and no pose\. Between objects use objects\.interpolate"):
            poses.interpolate(*pair, 0.5)
    for motor in (pose, cga3d.translator([1, 2, 3])):
        with pytest.raises(GradeError, match=r"is no object\. Between poses use poses\.interpolate"):
            objects.interpolate(motor, motor, alpha=0.5)


@pytest.mark.parametrize("name", ["cga3d", "pga3d", "sta", "vga2d"])
def test_dir_lists_what_users_need(name: str) -> None:
    algebra = getattr(bs, name)
    listed = set(dir(algebra))
    assert {"multivector", "blades", "kinds", "random", "e12"} <= listed
    assert not listed & INTERNAL
    with pytest.raises(AttributeError, match="has no 'remembr', and"):  # nothing internal is suggested
        algebra.remembr  # noqa: B018


def test_what_dir_leaves_out_is_there() -> None:
    assert all(hasattr(cga3d, name) for name in INTERNAL)

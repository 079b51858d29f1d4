"""Arguments that are no multivectors, kinds, axes or numbers: an error of the package that names them."""

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith import curves, dynamics, objects, registration, tracer
from bladesmith.errors import BladesmithError, KindError
from bladesmith.status import Status

ROTOR = cga.rotor((0, 0, 1), 0.3)
SPHERES = cga.sphere(np.eye(3), 1.0)
CIRCLES = cga.circle((0, 0, 0), (0, 0, 1), 1.0), cga.circle((0, 1, 2), (0, 0.5, 1), 0.6)


@pytest.mark.parametrize("axis", [None, "x", True, 1.5, [0], np.zeros(2), ROTOR, 5, -5])
@pytest.mark.parametrize(
    "sum_along",
    [
        lambda axis: objects.average(SPHERES, axis=axis),
        lambda axis: objects.enclosing_sphere(SPHERES, axis=axis),
        lambda axis: objects.sphere_weights(SPHERES, axis=axis),
        lambda axis: dynamics.resultant(dynamics.wrench(np.eye(3), algebra=cga), axis=axis),
    ],
    ids=["average", "enclosing_sphere", "sphere_weights", "resultant"],
)
def test_axes_are_whole_numbers(sum_along, axis):
    with pytest.raises(BladesmithError, match="axis"):
        sum_along(axis)


@pytest.mark.parametrize("tolerance", ["x", [0.1], np.ones(2), -1.0, float("nan"), ROTOR])
def test_tolerances_are_numbers(tolerance):
    with pytest.raises(BladesmithError, match="tolerance"):
        objects.is_blade(CIRCLES[0], tolerance=tolerance)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: cga.circle(np.zeros((2, 3)), np.ones((4, 3)), 1.0),
            r"cga3d, circle: the shapes .* broadcast: center \(2, 3\), normal \(4, 3\), radius \(\)\. Insert axes",
        ),
        (lambda: cga.rotor((0, 0, 1), [1.0, 2.0], np.zeros((3, 3))), r"axis \(3,\), angle \(2,\), point \(3, 3\)"),
        (lambda: cga.kind([1]), r"no kind \[1\]"),
        (lambda: cga.multivector([1.0], blades=3), "blades are 3"),
        (lambda: cga.multivector([1.0], grades=ROTOR), "grades are a Multivector"),
        (lambda: cga.multivector({"e1": 1.0}, kind=3), "kind is 3"),
        (lambda: cga.symbols(kind=3), "kind is 3"),
        (lambda: cga.on_basis(np.eye(3)), "basis is array"),
        (lambda: ROTOR.reflect(3), "the mirror is 3"),
        (lambda: ROTOR.as_kind(None), "kind is None"),
        (lambda: cga.matrix(3), "x is 3"),
        (lambda: cga.parameters(None), "x is None"),
        (lambda: cga.motor_parameters(np.eye(4)), "x is array"),
        (lambda: cga.classify(cga.kind("circle")), "a Kind"),
        (lambda: ROTOR.outer([[1], [1, 2]]), "ragged"),
        (lambda: ROTOR.outer("x"), "the other operand is 'x'; a multivector or a number is needed"),
        (lambda: ROTOR.meet(None), "the other operand is None"),
        (lambda: ROTOR.left_contraction(np.array(["x"])), "real numbers"),
        (lambda: ROTOR + [ROTOR], "a multivector is not an array"),
        (lambda: ROTOR.astype(np), "dtype is <module"),
        (lambda: dynamics.equilibrium(dynamics.wrench(np.eye(3), algebra=cga), rtol=[1]), "rtol"),
    ],
)
def test_what_is_needed_is_said(call, message):
    with pytest.raises(BladesmithError, match=message):
        call()


@pytest.mark.parametrize("value", [[[1, 2], [3]], [ROTOR], ROTOR, np.array(1.0), "x"], ids=str)
@pytest.mark.parametrize(
    "call",
    [
        lambda x: tracer.Facets(np.eye(3), x),
        lambda x: tracer.save_image("none.png", x),
        lambda x: tracer.save_image("none.png", np.zeros((4, 4, 3)), x),
        lambda x: curves.Bezier(x),
        lambda x: curves.Interpolating(SPHERES, degree=x),
        lambda x: registration.model_from_points(np.eye(3), 0.1, kinds=x),
    ],
    ids=["faces", "image", "done", "controls", "degree", "kinds"],
)
def test_ragged_lists_and_multivectors_are_no_arrays(tmp_path, monkeypatch, call, value):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(BladesmithError) as error:
        call(value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("call", [lambda x: ROTOR.astype(x), lambda x: bs.algebra(x, 0, 0)], ids=["dtype", "signature"])
def test_messages_have_one_line(call):
    with pytest.raises(BladesmithError) as error:
        call(np.ones((5, 3)))
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("size", [1e100, 1e160, 1e200, 1e300])
def test_scaled_rotors_are_invalid_though_their_squares_overflow(size):
    scaled = ROTOR * size
    for answer in (scaled.log(), scaled.sqrt()):
        assert answer.status == Status.INVALID
        assert np.isnan(answer.values).all()
    with pytest.raises(KindError, match="must vanish"):
        scaled.to_matrix()


@pytest.mark.parametrize("alpha", [1e5, 1e300, np.inf, np.nan])
def test_blends_by_rotors_that_overflow_are_invalid(alpha):
    blend = objects.interpolate(*CIRCLES, alpha=[0.5, alpha], method="rotor")
    assert list(blend.status) == [Status.OK, Status.INVALID]
    assert np.isnan(blend.values[1]).all()


def test_weights_of_spheres_that_sum_to_zero_have_no_fractions():
    assert np.isnan(objects.sphere_weights(SPHERES, [1.0, -1.0, 0.0])).all()
    with pytest.raises(BladesmithError, match="weights"):
        objects.sphere_weights(SPHERES, np.nan)

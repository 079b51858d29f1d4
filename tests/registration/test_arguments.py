"""Objects and arguments of registration: kinds in plain lists, backends, lengths, seeds and starts."""

import numpy as np
import pytest

from bladesmith import cga3d, registration
from bladesmith.errors import BladesmithError, InputError

from ..support.registration import POSE, apart, lines_and_planes


@pytest.mark.parametrize("method", ["direct", "optimize", "linear"])
def test_objects_of_several_kinds_in_one_list(method):
    reference = lines_and_planes()
    query = reference.transformed(~POSE)
    mixed = [[m.planes[0], m.lines[0], m.planes[1], m.lines[1], m.lines[2]] for m in (query, reference)]
    assert apart(registration.estimate_rotor(*mixed, method=method), POSE) < 1e-9
    batches = [[m.lines, m.planes] for m in (query, reference)]
    assert apart(registration.estimate_rotor(*batches, method=method), POSE) < 1e-9
    assert apart(registration.estimate_rotor(list(query.lines), list(reference.lines), method=method), POSE) < 1e-9


@pytest.mark.parametrize("method", ["direct", "optimize", "linear"])
@pytest.mark.parametrize("kind", ["lines", "circles", "point_pairs"])
def test_holes_of_a_plate_turn_about_the_axis_that_they_share(kind, method):
    places = [(0, 0, 0), (1, 0, 0), (0, 2, 0), (3, 1, 0), (-1, -1, 0)]
    rows = {
        "lines": [[place, (0, 0, 1)] for place in places],
        "circles": [(*place, 0, 0, 1, 0.5) for place in places],
        "point_pairs": [[place, (place[0], place[1], 1)] for place in places],
    }
    plate = registration.Model(**{kind: rows[kind]})
    found = registration.estimate_rotor(plate.transformed(~POSE), plate, method=method, details=True)
    assert found.cost < 1e-20 and len(found.undetermined) == (kind == "lines")
    assert kind == "lines" or apart(found.motor, POSE) < 1e-9


def test_lines_and_circles_in_one_list_stay_what_they_are():
    line, circle = cga3d.line((0, 0, 0), (1, 0, 0)), cga3d.circle((1, 2, 3), (0, 1, 1), 0.5)
    matching = registration.match([circle, line, line], [line, circle])
    assert matching.indices["circles"].tolist() == [0] and matching.indices["lines"].tolist() == [0, 0]
    with pytest.raises(InputError, match="the query's objects.* a multivector is needed"):
        registration.match([line, circle, 3], [line])
    with pytest.raises(BladesmithError, match=r"the query's objects\[1\] are a motor"):
        registration.match([line, POSE], [line])


@pytest.mark.parametrize("length", [1e-320, 1e-13, 1e13, 1e300])
def test_lengths_that_leave_nothing(length):
    for run in (registration.register, registration.estimate_rotor, registration.iterate):
        with pytest.raises(InputError, match="length is .* times the models' size; 1e-12 to 1e.12 is possible"):
            run(lines_and_planes(), lines_and_planes(), length=length)


@pytest.mark.parametrize("backend", [["c"], {}, np.array([1, 2]), None, b"c", "C", 3])
def test_backends_that_are_none(backend):
    with pytest.raises(InputError, match="backend is .*; there are: c, numba, cuda"):
        registration.register(lines_and_planes(), lines_and_planes(), backend=backend)


@pytest.mark.parametrize("length", [np.inf, np.nan, 0, -1.0, True, np.True_, "1", b"1"])
def test_lengths_that_are_none(length):
    for run in (registration.register, registration.estimate_rotor, registration.iterate):
        with pytest.raises(InputError, match="length is .*; a (finite )?positive number is needed"):
            run(lines_and_planes(), lines_and_planes(), length=length)


@pytest.mark.parametrize("seed", [-1, 1.5, "x", None, True, np.nan, {}])
def test_seeds_that_are_none(seed):
    for run in (registration.register, registration.estimate_rotor):
        with pytest.raises(InputError, match="seed is .*; a whole number of at least 0 is needed"):
            run(lines_and_planes(), lines_and_planes(), seed=seed)


def test_a_start_that_is_not_finite_is_refused():
    for run in (registration.register, registration.estimate_rotor, registration.iterate):
        with pytest.raises(InputError, match="start is not finite"):
            run(lines_and_planes(), lines_and_planes(), start=POSE * np.nan)

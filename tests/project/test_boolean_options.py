"""Options that are True or False take nothing else, wherever they are read."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import cga3d, curves, objects, registration
from bladesmith.common.validation import as_bool
from bladesmith.errors import InputError, SceneError
from bladesmith.tracer.scene import values

LINES = cga3d.line([(0, 0, 0), (1, 0, 0), (0, 2, 0)], [(1, 0, 1), (0, 1, 0), (0, 1, 3)])
POINTS = cga3d.point([(0, 0, 0), (1, 0, 0), (0, 2, 1), (3, 1, 1)])
MODEL = registration.Model(lines=LINES)
CIRCLES = cga3d.circle([(0, 0, 0), (1, 0, 0)], [(1, 0, 1), (0, 1, 0)], 1.0)


@pytest.mark.parametrize("value", [True, False, np.True_, np.bool_(False), np.array(True)])
def test_truth_values_are_taken(value):
    assert as_bool(value, "option") is bool(value)
    assert values.flag(value, "option") is bool(value)


@pytest.mark.parametrize("value", [1, 0, 1.0, "yes", "", None, [], [True], np.array([True]), np.array(1), {}])
def test_nothing_else_is(value):
    with pytest.raises(InputError, match="^option is .*; True or False is needed"):
        as_bool(value, "option")
    with pytest.raises(SceneError, match="option is .*; True or False is needed"):
        values.flag(value, "option")


def test_a_long_value_is_told_on_one_short_line():
    with pytest.raises(InputError) as caught:
        as_bool(np.arange(10_000.0).reshape(100, 100), "option")
    assert len(str(caught.value)) < 120 and "\n" not in str(caught.value)


CALLS = {
    "normalized strict": lambda x: LINES.normalized(strict=x),
    "inverse strict": lambda x: LINES.inverse(strict=x),
    "reflect strict": lambda x: LINES.reflect(LINES[0], strict=x),
    "line strict": lambda x: cga3d.line((0, 0, 0), (1, 0, 0), strict=x),
    "translator strict": lambda x: cga3d.translator((1, 0, 0), strict=x),
    "log strict": lambda x: cga3d.rotor((0, 0, 1), 1.0).log(strict=x),
    "sqrt strict": lambda x: cga3d.rotor((0, 0, 1), 1.0).sqrt(strict=x),
    "rotor_between strict": lambda x: objects.rotor_between(LINES[0], LINES[1], strict=x),
    "join strict": lambda x: objects.join(LINES[0], POINTS[0], strict=x),
    "screw_of_lines strict": lambda x: objects.screw_of_lines(LINES[0], LINES[1], strict=x),
    "fit_plane strict": lambda x: objects.fit_plane(POINTS, strict=x),
    "fit_plane rms": lambda x: objects.fit_plane(POINTS, rms=x),
    "fit_line rms": lambda x: objects.fit_line(POINTS, rms=x),
    "average align": lambda x: objects.average(LINES, weights=(1, 2, 3), align=x),
    "average strict": lambda x: objects.average(LINES, strict=x),
    "interpolate align": lambda x: objects.interpolate(CIRCLES[0], CIRCLES[1], alpha=0.5, align=x),
    "cost_matrix align": lambda x: objects.cost_matrix(LINES, LINES, align=x),
    "Bezier align": lambda x: curves.Bezier(CIRCLES, align=x),
    "Bezier raw": lambda x: curves.Bezier(CIRCLES, raw=x),
    "Bezier value strict": lambda x: curves.Bezier(CIRCLES)(0.5, strict=x),
    "register align": lambda x: registration.register(MODEL, MODEL, align=x),
    "register similarity": lambda x: registration.register(MODEL, MODEL, similarity=x),
    "match align": lambda x: registration.match(MODEL, MODEL, align=x),
    "iterate robust": lambda x: registration.iterate(MODEL, MODEL, robust=x),
    "estimate_rotor details": lambda x: registration.estimate_rotor(MODEL, MODEL, details=x),
    "estimate_rotor strict": lambda x: registration.estimate_rotor(MODEL, MODEL, strict=x),
}


@pytest.mark.parametrize("name", CALLS)
def test_every_option_is_checked_by_its_name(name):
    CALLS[name](False)
    for wrong in ("no", 2, None):
        with pytest.raises(InputError, match=f"{name.split()[-1]} is .*; True or False is needed"):
            CALLS[name](wrong)

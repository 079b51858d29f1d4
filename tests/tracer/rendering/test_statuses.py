"""What a ray is told when one surface cannot tell: only where nothing was hit before that surface begins."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from bladesmith import Status, tracer

CAMERA = tracer.Camera.look_at((0, -8, 2), (0, 0, 0))
#: Turns that take y to each axis.
TURNS = [np.roll(np.eye(3), shift, axis=0) for shift in range(3)]


def ring(turn):
    """Circles of one plane, from -1 to 1 along the turned y: a ray in that plane meets all of them."""
    axis = turn @ (0, 0, 1)
    return tracer.EvolvedCircles([((0, 0, 0), axis, 1.0), (turn @ (0.2, 0, 0), axis, 0.5)])


def rod(turn, place):
    """A short and thin tube across that plane."""
    axis = turn @ (0, 0, 1)
    return tracer.EvolvedCircles([(turn @ (0.0, place, z), axis, 0.1) for z in (-0.01, 0.01)])


@pytest.mark.parametrize(("turn", "sign"), [*product(range(3), (-1, 1))])
def test_a_surface_that_cannot_tell_counts_from_where_its_box_begins(turn, sign):
    """The ring is asked first; the rod is hit before the ring begins, inside it, or behind it."""
    to = TURNS[turn]
    origin, direction = to @ (0, -5.0 * sign, 0), to @ (0, float(sign), 0)
    for place, status in ((-2, Status.OK), (0, Status.SINGULAR), (2, Status.SINGULAR)):
        scene = tracer.Scene(CAMERA, [], [ring(to), rod(to, sign * place)])
        hits = scene.intersect(origin, direction)
        assert not scene.needs.tree and hits.surface == 1
        np.testing.assert_allclose(hits.t, 5 + place - 0.1, atol=0.01)
        assert hits.status == status, place

"""Single calls of arms, of the Delta robot and of formulas: bits and errors of batches, in any thread."""

from __future__ import annotations

import pickle
import signal
import threading
from typing import Any

import numpy as np
import pytest

from bladesmith import Status, cga3d, kinematics, objects
from bladesmith.errors import ShapeError

WAYS = [(0, 0, 1.0), (0, 1.0, 0), (1.0, 0, 0)]
AXES = [kinematics.revolute_axis((i, 0.1 * i, 0.2 * (i % 2)), WAYS[i % 3]) for i in range(6)]
CHAIN = kinematics.Chain(AXES, tool=cga3d.translator((6.5, 0, 0)))
DELTA = kinematics.DeltaRobot(base_radius=0.2, effector_radius=0.05, upper_arm=0.3, forearm=0.8)
ROWS = np.random.default_rng(0).uniform(-1, 1, (50, 6))
ANGLES = np.random.default_rng(1).uniform(0.1, 0.6, (50, 3))
ARMS = {"forward": lambda q: CHAIN.forward(q).values, "jacobian": lambda q: CHAIN.jacobian(q)}
POSITIONS = DELTA.forward(ANGLES)
DELTAS = {
    "forward": (DELTA.forward, ANGLES), "inverse": (DELTA.inverse, POSITIONS),
    "forward_jacobian": (DELTA.forward_jacobian, ANGLES), "inverse_jacobian": (DELTA.inverse_jacobian, POSITIONS),
}  # fmt: skip


@pytest.mark.parametrize("name", ARMS)
def test_a_row_has_the_bits_that_it_has_in_a_batch(name: str) -> None:
    whole = ARMS[name](ROWS)
    for q, expected in zip(ROWS, whole, strict=True):
        for row in (q, q.tolist(), q[::-1].copy()[::-1], q.astype(">f8")):
            assert np.array_equal(ARMS[name](row), expected)
    lost = ROWS[0].copy()
    lost[2] = np.nan
    assert np.isnan(ARMS[name](lost)).any() and np.isnan(ARMS[name](lost[None])).any()
    with pytest.raises(ShapeError):
        ARMS[name](ROWS[0, :5].copy())
    assert CHAIN.forward(lost).status == Status.INVALID


@pytest.mark.parametrize("name", DELTAS)
def test_a_pose_of_the_delta_robot_has_the_bits_that_it_has_in_a_batch(name: str) -> None:
    function, rows = DELTAS[name]
    whole, far = function(rows), np.full(3, 50.0)
    for row, expected in zip(rows, whole, strict=True):
        assert np.array_equal(function(row), expected) and np.array_equal(function(row.tolist()), expected)
    for choice in ("near", "positive") if "forward" in name else ("inner",):
        where = {"root" if "forward" in name else "elbow": choice}
        assert np.array_equal(function(rows[0], **where), function(rows, **where)[0], equal_nan=True)
    if "inverse" in name:
        assert np.isnan(function(far)).all() and np.isnan(function(far[None])).all()
    again = getattr(pickle.loads(pickle.dumps(DELTA)), name)(rows[0])
    assert np.array_equal(again, whole[0])


def test_calls_in_threads_and_in_handlers_of_signals_do_not_disturb_each_other() -> None:
    expected = CHAIN.forward(ROWS).values
    wrong: list[int] = []

    def work(start: int) -> None:
        for i in [*range(start, 50), *range(start)] * 40:
            if not np.array_equal(CHAIN.forward(ROWS[i]).values, expected[i]):
                wrong.append(i)

    def handler(*_: Any) -> None:
        CHAIN.forward(ROWS[7])

    before = signal.signal(signal.SIGALRM, handler)
    signal.setitimer(signal.ITIMER_REAL, 1e-4, 1e-4)
    threads = [threading.Thread(target=work, args=(10 * k,)) for k in range(3)]
    try:
        for thread in threads:
            thread.start()
        work(5)
        for thread in threads:
            thread.join()
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert not wrong


def test_single_objects_have_the_bits_and_statuses_of_batches() -> None:
    rng = np.random.default_rng(2)
    points = [cga3d.point(rng.normal(size=(20, 3))) for _ in range(3)]
    triples = points[0] ^ points[1] ^ points[2]
    circles, motors = triples.normalized(), cga3d.translator(rng.normal(size=(20, 3))) * cga3d.rotor((0, 0, 1.0), 0.3)
    assert circles.kind.name == "circle"
    for i in range(20):
        one = triples[i].normalized()
        assert one.kind == circles.kind and np.array_equal(one.values, circles.values[i])
        assert np.array_equal(motors[i].log().values, motors.log().values[i])
        assert np.array_equal(motors[i].log().exp().values, motors.log().exp().values[i])
        for field in ("center", "normal", "radius"):
            assert np.array_equal(getattr(one.parameters(), field), getattr(circles.parameters(), field)[i])
        assert one.parameters().status == Status.OK and one.parameters().orientation == 1
        assert objects.rotor_between(circles[i], circles[0]).isclose(objects.rotor_between(circles, circles[0])[i])
    same = cga3d.point((1.0, 2, 3))
    assert (same ^ same ^ points[0][0]).normalized().status == Status.SINGULAR
    assert cga3d.point((np.inf, 0, 0)).status == Status.INVALID
    assert cga3d.line((0, 0, 0.0), (0, 0, 0.0)).status == Status.INVALID
    apart = (circles[0] + circles[1]).normalized()  # no blade
    assert apart.kind.name == "trivector" or apart.status != Status.OK

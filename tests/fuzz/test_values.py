"""Functions of objects and motions on good items among bad ones: no item changes another, and none that is not finite
has the status OK.

`BLADESMITH_FUZZ=5000 python -m pytest tests/fuzz` tries so many batches of each function.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from bladesmith import Status, objects, poses
from bladesmith import cga3d as cga
from bladesmith import pga3d as pga

pytestmark = pytest.mark.slow
#: Batches of each function and family.
COUNT = max(1, int(os.environ.get("BLADESMITH_FUZZ", "1")) // 5)
#: Of each batch: large ones make numbers, small ones more batches.
ITEMS = int(os.environ.get("BLADESMITH_FUZZ_ITEMS", "24"))
#: What coefficients of bad items are, and what all of an item are multiplied by.
SPECIAL = (np.nan, np.inf, -np.inf, 0.0, 1e308, -1e308, 5e-324, 1e-200, 1e160, 1e-160)
FACTORS = (1e300, 1e-300, 1e155, 1e-155, 0.0)
#: Sizes of objects, and how far they are from the origin; None: small integers, so that many touch, meet or coincide.
FAMILIES: dict[str, tuple[float, float] | None] = {
    "ordinary": (1.0, 0.0), "integers": None, "tiny": (1e-8, 0.0), "huge": (1e8, 0.0), "far": (1.0, 1e6),
}  # fmt: skip
OBJECTS = ("point", "line", "plane", "circle", "sphere", "point_pair")
MOTIONS = ("motor", "rotor", "twist")
FLAT = ("point", "line", "plane", *MOTIONS)


class Source:
    """Random objects of one family, from one seed."""

    def __init__(self, family: str, seed: int) -> None:
        self.random = np.random.default_rng(seed)
        self.size = FAMILIES[family]

    def vectors(self, width: int = 3) -> Any:
        if self.size is None:
            return self.random.integers(-2, 3, (ITEMS, width)).astype(float)
        size, distance = self.size
        return size * self.random.normal(size=(ITEMS, width)) + distance * self.random.normal(size=width)

    def directions(self) -> Any:
        if self.size is not None:
            return self.random.normal(size=(ITEMS, 3))
        v = self.random.integers(-1, 2, (ITEMS, 3)).astype(float)
        return np.where(v.any(1)[:, None], v, (0.0, 0.0, 1.0))

    def radii(self) -> Any:
        if self.size is None:
            return self.random.integers(1, 4, ITEMS).astype(float)
        return self.size[0] * np.exp(0.3 * self.random.normal(size=ITEMS))

    def make(self, algebra: Any, kind: str) -> Any:
        """Items of a kind."""
        place, direction = self.vectors(), self.directions()
        if kind == "point":
            return algebra.point(place)
        if kind == "line":
            return algebra.line(place, direction)
        if kind == "plane":
            return algebra.plane(direction, place[:, 0])
        if kind == "circle":
            return algebra.circle(place, direction, self.radii())
        if kind == "sphere":
            return algebra.sphere(place, self.radii())
        if kind == "point_pair":
            other = self.vectors()
            return algebra.point_pair(place, np.where((other == place).all(1)[:, None], other + 1, other))
        turn = algebra.rotor(direction, self.random.uniform(-3, 3, ITEMS))
        if kind == "rotor":
            return turn
        if kind == "motor":
            return (algebra.translator(place) * turn).as_kind("motor")
        return algebra.wrap(algebra.kind("twist"), np.hstack([direction, place]))

    def spoilt(self, x: Any) -> tuple[Any, Any]:
        """The same with a third of the items bad, and a mask of these."""
        values, bad = np.array(x.values), np.arange(ITEMS) % 3 == 0
        for i in np.flatnonzero(bad):
            way = self.random.integers(3)
            if way == 0:
                values[i] = self.random.choice(SPECIAL)
            elif way == 1:
                values[i, self.random.integers(values.shape[1])] = self.random.choice(SPECIAL)
            else:
                with np.errstate(all="ignore"):
                    values[i] *= self.random.choice(FACTORS)
        return x.algebra.wrap(x.kind, values), bad


#: What has statuses that say where there is no answer; of other operations non-finite items are the caller's.
UNARY: dict[str, tuple[Callable[[Any], Any], tuple[str, ...]]] = {
    "normalized": (lambda x: x.normalized(), (*OBJECTS, *MOTIONS)),
    "inverse": (lambda x: x.inverse(), (*OBJECTS, "motor", "rotor")),
    "norm": (lambda x: x.norm(status=True), (*OBJECTS, *MOTIONS)),
    "log": (lambda x: x.log(), ("motor", "rotor")),
    "sqrt": (lambda x: x.sqrt(), ("motor", "rotor")),
    "exp": (lambda x: x.exp(), ("twist",)),
    "parameters": (lambda x: x.parameters(), (*OBJECTS, "motor", "rotor")),
    "dual": (lambda x: x.dual(), (*OBJECTS, *MOTIONS)),
    "square": (lambda x: x * x, (*OBJECTS, *MOTIONS)),
}
BINARY: dict[str, Callable[[Any, Any], Any]] = {
    "product": lambda x, y: x * y,
    "outer": lambda x, y: x ^ y,
    "inner": lambda x, y: x | y,
    "regressive": lambda x, y: x & y,
    "commutator": lambda x, y: x.commutator(y),
    "join": objects.join,
    "meet": objects.meet,
}
OF_ONE_KIND: dict[str, Callable[[Any, Any], Any]] = {
    "rotor_between": objects.rotor_between,
    "trs_rotor": objects.trs_rotor,
    "interpolate": lambda x, y: objects.interpolate(x, y, alpha=0.3),
    "interpolate, align": lambda x, y: objects.interpolate(x, y, alpha=0.3, align=True),
    "interpolate by rotors": lambda x, y: objects.interpolate(x, y, alpha=0.3, method="rotor"),
    "rate": lambda x, y: objects.interpolate_derivative(x, y, alpha=0.3),
    "sum": lambda x, y: objects.project_to_blade(x + 2 * y),
    "align": lambda x, y: objects.align(y, x),
    "cost": lambda x, y: objects.rotor_cost(objects.rotor_between(x, y), status=True),
}
POSES = (
    "to_quaternion",
    "to_matrix",
    "to_rotation_vector",
    "to_dual_quaternion",
    "log",
    "adjoint",
    "inverse",
    "position",
)
#: The same with options; where there are statuses, they are asked for.
POSES_WITH_OPTIONS: dict[str, Callable[[Any], Any]] = {
    **{
        f"to_euler {sequence}": lambda x, sequence=sequence: poses.to_euler(x, sequence, status=True)
        for sequence in ("xyz", "ZYX", "zxz", "YXY")
    },
    "to_euler in degrees": lambda x: poses.to_euler(x, "zyx", degrees=True, status=True),
    "to_quaternion, canonical": lambda x: poses.to_quaternion(x, "xyzw", canonical=True, status=True),
    "to_rotation_vector, with status": lambda x: poses.to_rotation_vector(x, status=True),
    "to_matrix, with status": lambda x: poses.to_matrix(x, status=True),
    "position, with status": lambda x: poses.position(x, status=True),
    "log, shortest": lambda x: poses.log(x, shortest=True, status=True),
    "act": lambda x: poses.act(x, (1.0, 2.0, 3.0), status=True),
    "rotate": lambda x: poses.rotate(x, (1.0, 2.0, 3.0), status=True),
}
JACOBIANS = ("exp", "left_jacobian", "right_jacobian", "inverse_left_jacobian", "inverse_right_jacobian")


def cases() -> Iterator[tuple[str, Any, tuple[str, ...], Callable[..., Any]]]:
    """Names, algebras, kinds of operands, functions."""
    for name, (function, kinds) in UNARY.items():
        for kind in kinds:
            for algebra in (cga, pga):
                if algebra is cga or kind in FLAT:
                    yield f"{name} of {kind} of {algebra.name}", algebra, (kind,), function
    for name, both in BINARY.items():
        for first in OBJECTS:
            for second in OBJECTS:
                yield f"{name} of {first} and {second}", cga, (first, second), both
    for name, both in OF_ONE_KIND.items():
        for kind in OBJECTS:
            yield f"{name} of {kind}", cga, (kind, kind), both
    for algebra, kinds in ((cga, OBJECTS), (pga, OBJECTS[:3])):
        for kind in kinds:
            yield f"motor on {kind} of {algebra.name}", algebra, ("motor", kind), lambda m, x: m >> x
    for name in POSES:
        yield f"poses.{name}", pga, ("motor",), getattr(poses, name)
    for name in JACOBIANS:
        yield f"poses.{name}", pga, ("twist",), getattr(poses, name)
    for name, of_pose in POSES_WITH_OPTIONS.items():
        yield f"poses.{name}", pga, ("motor",), of_pose
    for path in ("screw", "straight"):
        yield f"poses.interpolate, {path}", pga, ("motor",) * 2, lambda a, b, p=path: poses.interpolate(a, b, 0.3, p)
    yield "poses.compose", pga, ("motor", "motor"), poses.compose
    yield "closest_point", cga, ("line", "line"), objects.closest_point
    for kind in ("circle", "line", "point_pair"):
        yield f"common_sphere of {kind}", cga, (kind, kind), objects.common_sphere


CASES = {name: rest for name, *rest in cases()}
DROPS_STATUS = (
    "dual", "square", "product", "outer", "inner", "regressive", "commutator", "motor on", "poses.compose",
)  # fmt: skip


def parts(result: Any) -> list[tuple[Any, Any]]:
    """Arrays of a result, on all blades, and statuses of their items, None where there are none."""
    if hasattr(result, "_fields"):
        status = getattr(result, "status", None)
        return [(np.asarray(getattr(result, f)), status) for f in result._fields if f != "status"]
    if isinstance(result, tuple):
        values, status = result
        if np.asarray(status).dtype == bool:
            return [*parts(values), (np.asarray(status), None)]
        return [(np.asarray(values), status)]
    if not hasattr(result, "algebra"):
        return [(np.asarray(result), None)]
    values = np.zeros((*result.shape, 2**result.algebra.dimension), result.dtype)
    values[..., list(result._type.blades)] = result.values
    return [(values, result.status)]


def ok(status: Any) -> Any:
    return np.broadcast_to([int(code) == Status.OK for code in np.ravel(status)], ITEMS)


@pytest.mark.parametrize("family", FAMILIES)
def test_bad_items_are_told_and_change_no_other(family: str) -> None:
    for name, (algebra, kinds, function) in CASES.items():
        for seed in range(COUNT):
            source = Source(family, seed)
            good = [source.make(algebra, kind) for kind in kinds]
            mixed = [source.spoilt(x) for x in good]
            bad = np.any([mask for _, mask in mixed], axis=0)
            where = f"{name}, seed {seed}"
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", RuntimeWarning)
                expected, found = parts(function(*good)), parts(function(*(x for x, _ in mixed)))
            for (values, status), (others, code) in zip(expected, found, strict=True):
                assert np.array_equal(values[~bad], others[~bad], equal_nan=values.dtype.kind == "f"), where
                for array, reason in ((values, status), (others, code)):
                    if reason is not None and not name.startswith(DROPS_STATUS):
                        assert np.isfinite(array.reshape(ITEMS, -1)[ok(reason)]).all(), where


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("dtype", [np.float64, np.float32], ids=["float64", "float32"])
def test_an_item_alone_has_the_bits_that_it_has_in_a_batch(family: str, dtype: Any) -> None:
    for name, (algebra, kinds, function) in CASES.items():
        for seed in range(COUNT):
            source = Source(family, seed)
            operands = [source.make(algebra, kind).astype(dtype) for kind in kinds]
            batch = parts(function(*operands))
            for i in (0, ITEMS // 2, ITEMS - 1):
                alone = parts(function(*(x[i] for x in operands)))
                for (values, _), (one, _) in zip(batch, alone, strict=True):
                    lost = np.isnan(values[i]).any() and np.isnan(one).any()  # on the blades of the kinds of both
                    assert lost or np.array_equal(values[i], one), f"{name}, seed {seed}"


def laid_out(values: Any) -> Iterator[Any]:
    """The same numbers elsewhere in memory."""
    spread = np.empty((2 * len(values), values.shape[1]), values.dtype)
    spread[::2] = values
    yield spread[::2]
    yield values[::-1].copy()[::-1]
    yield np.asfortranarray(values)
    yield values.astype(values.dtype.newbyteorder())
    room = bytearray(values.nbytes + 1)
    odd = np.frombuffer(room, values.dtype, values.size, offset=1).reshape(values.shape)
    odd[...] = values
    yield odd
    fixed = values.copy()
    fixed.flags.writeable = False
    yield fixed


def test_what_no_number_holds_is_told() -> None:
    """Found by the above: NaN with the status OK, an error of NumPy's, and another item's digits."""
    circle = cga.wrap(cga.kind("circle"), np.full(10, 1e308))
    found = circle.parameters()
    assert found.status == Status.INVALID and np.isnan(found.center).all() and np.isnan(found.radius)
    motor = cga.wrap(cga.kind("motor"), np.array([0.8, 0.6, 0, 0, -1e308, 0, 0, 0]))
    assert motor.log().status == motor.sqrt().status == Status.INVALID
    point, huge = cga.point((1.0, 2.0, 3.0)), cga.wrap(cga.kind("sphere"), 1e300 * cga.sphere((1, 2, 3), 2.0).values)
    assert objects.join(point, huge).status in (Status.OK, Status.INVALID)
    swapped = cga.point((1.0, 2.0, 3.0)).values.astype(">f8")
    assert (cga.wrap(cga.kind("point"), swapped) - point).norm() == 0


def test_bits_do_not_depend_on_where_numbers_are() -> None:
    for name, (algebra, kinds, function) in CASES.items():
        source = Source("ordinary", 0)
        operands = [source.make(algebra, kind) for kind in kinds]
        expected = parts(function(*operands))
        for layouts in zip(*(laid_out(x.values) for x in operands), strict=True):
            given = [algebra.wrap(x.kind, values) for x, values in zip(operands, layouts, strict=True)]
            for (values, _), (others, _) in zip(expected, parts(function(*given)), strict=True):
                assert values.tobytes() == others.tobytes(), name

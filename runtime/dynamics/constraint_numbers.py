"""Numbers of constraints as the compiled driver reads them: each is A[~S V S] = H."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError
from ..multivector import Multivector
from .assembly import Assembly, Row, frame_of, of_item
from .body_numbers import one_state
from .constraints import Constraint, Incidence, Pin, PinLinear, PinPath, VirtualPower
from .functions import Differences, arity
from .given import coefficients, finite, of_algebra
from .layouts import basis, carried, layout_of, matrix_of, on_layout

if TYPE_CHECKING:
    from ..algebras import Algebra

Array = NDArray[Any]
#: Objects closer than this, as a share of their size, are one.
SAME = 1e-9


def store_constraint(made: Assembly, c: Constraint, duration: float) -> None:
    body, other = made.which(c.body, c.label), made.which(c.other, c.label)
    if body < 0 or body == other:
        raise InputError(f"{c.label} is between {c.body!r} and {c.other!r}; it takes a body and something else.")
    match c:
        case Pin():
            _store_pin(made, c, body, other)
        case PinPath():
            _store_linear(made, c, body, other, None, c.world_object, c.body_object, duration)
        case PinLinear():
            _store_linear(made, c, body, other, c.function, c.world_object, c.target, duration)
        case Incidence():
            point = _single(of_algebra(c.body_point, made.algebra, "the body's point"), "the body's point")
            product = (lambda x: point ^ x) if not made.algebra.is_degenerate else (lambda x: point & x)
            _store_linear(made, c, body, other, product, c.world_object, 0, duration)
        case VirtualPower():
            _store_power(made, c, body, other, duration)
        case _:
            raise InputError(f"{c!r} is no constraint; there are Pin, PinPath, PinLinear, Incidence, VirtualPower.")


def relative_pose(made: Assembly, body: int, other: int) -> Multivector:
    """Motor of a body's driver frame, as another's sees it, at the start."""
    pose = made.frames[body].pose
    return pose if other < 0 else ~made.frames[other].pose * pose


def _store_pin(made: Assembly, c: Pin, body: int, other: int) -> None:
    own = _single(of_algebra(c.body_object, made.algebra, "the body's object"), "the body's object")
    own = ~frame_of(made, body) >> own
    layout = layout_of([own], c.label)
    there = relative_pose(made, body, other) >> own
    if c.world_object is not None:
        given = _single(of_algebra(c.world_object, made.algebra, "the world's object"), "the world's object", made.size)
        there = moved_near(~frame_of(made, other) >> given, there)
    row = Row(c, layout, body, other, made.algebra.kind(layout).size)
    row.v, row.h = made.store(on_layout(there, layout)), made.store(on_layout(own, layout))
    made.rows.append(row)


def moved_near(given: Multivector, exact: Multivector) -> Multivector:
    """An object as given, or where it is expected if it differs from there by rounding: far from the origin the
    coefficients of what users give have lost the digits of the place."""
    difference = (given - exact).values
    size = np.abs(given.values).max()
    return exact if np.abs(difference).max(initial=0) <= SAME * size else given


def _single(x: Multivector, what: str, size: int = 1) -> Multivector:
    """One object that all simulations share, or one for each of them."""
    if x.shape not in ((), (size,)):
        raise InputError(f"{what} has shape {x.shape}; one object is needed, or one for each of {size} simulations.")
    return x


def _kept(x: Multivector, layout: str, t: float, what: str) -> Array:
    """Coefficients on a layout; nothing but rounding may be beyond it."""
    blades = x.algebra.kind(layout).blades
    sizes = np.abs(x.values)
    for b, size in zip(x.kind.blades, sizes, strict=True):
        if b not in blades and size > SAME * sizes.max():
            raise InputError(
                f"{what} has {x.algebra.blade_name(b)} at time {t:.6g}, which it has not at the start and the end: it "
                "becomes another kind of object."
            )
    return on_layout(x, layout)


def _path(
    value: Any, made: Assembly, what: str, frame: Multivector, blades: bool = False
) -> Callable[[float], list[Multivector]]:
    """A function of time, moved to a frame: the object, if asked for a blade still, or it and its derivatives."""

    def at(t: float) -> list[Multivector]:
        given = value(t) if callable(value) else value
        parts = given if isinstance(given, tuple) else (given,)
        moved = [~frame >> _single(of_algebra(x, made.algebra, what), what, made.size) for x in parts]
        return [_blade(moved[0]), *moved[1:]] if blades else moved

    return at


def _blade(x: Multivector) -> Multivector:
    """A line or a circle anew from its parameters: moved from far away it is none by the rounding of its distance, and
    that a point lies on it would take a row more than it should."""
    if x.kind.name not in ("line", "circle"):
        return x
    anew: Multivector = getattr(x.algebra, x.kind.name)(*x.parameters()).as_kind(x.kind.name)
    weight = (anew.values * x.values).sum(-1) / (anew.values**2).sum(-1)
    return anew * weight if np.isfinite(weight).all() and (weight != 0).all() else x


def _derivatives(
    path: Callable[[float], list[Multivector]], layout: str, duration: float, what: str
) -> Callable[[float], Any]:
    """Rows (3, k) of a path's values and derivatives."""
    if len(path(0.0)) == 3:
        return lambda t: np.stack([_kept(x, layout, t, what) for x in path(t)])
    return Differences(lambda t: _kept(path(t)[0], layout, t, what), (0.0, duration))


def _store_linear(
    made: Assembly, c: Constraint, body: int, other: int, function: Any, world: Any, target: Any, duration: float,
) -> None:  # fmt: skip
    """A[~S V S] = H; without a function A is one, and H an object of the body."""
    if made.size > 1 and (callable(world) or callable(target)):
        raise InputError(
            f"{c.label} has functions of time; those are for one simulation, not for a batch of {made.size}."
        )
    there = frame_of(made, other, 0) if callable(world) else frame_of(made, other)
    path = _path(world, made, "the world's object", there, blades=isinstance(c, Incidence))
    layout = layout_of([path(0.0)[0], path(duration)[0]], c.label)
    algebra = made.algebra
    if function is None:
        aims = _path(
            target, made, "the body's object", frame_of(made, body, 0) if callable(target) else frame_of(made, body)
        )
        layout = layout_of([path(0.0)[0], path(duration)[0], aims(0.0)[0]], c.label)
        rows, matrix = algebra.kind(layout).size, None

        def goal(t: float) -> list[Array]:
            return [_kept(x, layout, t, "the body's object") for x in aims(t)]
    else:
        matrix = matrix_of(function, algebra, layout, f"the function of {c.label}")
        keep = _blades_of(function, algebra, layout)
        rows = len(matrix)
        matrix = matrix @ carried(frame_of(made, body), layout)  # of a batch each body has a frame of its own

        def goal(t: float) -> list[Array]:
            given = target(t) if callable(target) else target
            return [_on_blades(x, keep, algebra) for x in (given if isinstance(given, tuple) else (given,))]

    row = Row(c, layout, body, other, rows)
    if callable(world) or callable(target):
        v = (
            _derivatives(path, layout, duration, "the world's object")
            if callable(world)
            else _constant(on_layout(path(0.0)[0], layout))
        )
        h = _with_derivatives(goal, duration) if callable(target) else _constant(goal(0.0)[0])
        row.user = made.called.add(
            lambda item, t, state: np.concatenate([*v(t), *h(t)], axis=None),
            c.label,
            3 * (algebra.kind(layout).size + rows),
        )
    else:
        row.v, row.h = made.store(on_layout(path(0.0)[0], layout)), made.store(goal(0.0)[0])
    if matrix is not None:
        row.a = made.store(matrix.reshape(*matrix.shape[:-2], -1))
    made.rows.append(row)


def _constant(values: Array) -> Callable[[float], Any]:
    fixed = np.stack([values, 0 * values, 0 * values])
    return lambda t: fixed


def _with_derivatives(goal: Callable[[float], list[Array]], duration: float) -> Callable[[float], Any]:
    if len(goal(0.0)) == 3:
        return lambda t: np.stack(goal(t))
    return Differences(lambda t: goal(t)[0], (0.0, duration))


def _blades_of(function: Any, algebra: Algebra, layout: str) -> list[int]:
    """Blades on which a linear function has values, in order."""
    y = function(basis(algebra, layout))
    used = [b for b, v in zip(y.kind.blades, np.moveaxis(y.values, -1, 0), strict=True) if np.any(v)]
    return sorted(used)


def _on_blades(x: Any, blades: list[int], algebra: Algebra) -> Array:
    if not isinstance(x, Multivector):
        x = algebra.scalar(float(finite(x, "the target")))
    x = _single(of_algebra(x, algebra, "the target"), "the target")
    found = np.zeros(len(blades))
    for b, v in zip(x.kind.blades, x.values, strict=True):
        if b in blades:
            found[blades.index(b)] = v
        elif v:
            raise InputError(f"the target has {algebra.blade_name(b)}, which the linear function never gives.")
    return found


def _store_power(made: Assembly, c: VirtualPower, body: int, other: int, duration: float) -> None:
    algebra, frame = made.algebra, frame_of(made, other)
    if not callable(c.wrenches):
        given = list(c.wrenches) if c.wrenches.__class__ in (list, tuple) or c.wrenches.shape else [c.wrenches]
        for wrench in given:
            moved = ~frame >> of_algebra(wrench, algebra, "a wrench")
            row = Row(c, "twist", body, other, 1, power=True)
            row.v, row.h = made.store(coefficients(moved, "twist", "a wrench")), made.store([0.0])
            made.rows.append(row)
        return
    if made.size > 1:
        raise InputError(f"{c.label} has a function; that is for one simulation, not for a batch of {made.size}.")
    count = arity(c.wrenches, "the wrenches")

    def rows(wrenches: Any) -> Array:
        local = ~of_item(frame, 0) >> of_algebra(wrenches, algebra, "the wrenches")
        return np.atleast_2d(coefficients(local, "twist", "the wrenches"))

    def parts(t: float, state: Array) -> tuple[Array, Array]:
        key = (t, state.tobytes())
        found = last.get(key)  # the driver asks for each wrench by itself
        if found is None:
            found = asked(t, state)
            last.clear()  # another thread may do so too
            last[key] = found
        return found

    def asked(t: float, state: Array) -> tuple[Array, Array]:
        value = c.wrenches(t) if count == 1 else c.wrenches(t, *one_state(made, body, 0, state))
        if isinstance(value, tuple) and len(value) == 2:
            return rows(value[0]), rows(value[1])
        if count != 1:
            raise InputError("wrenches that depend on the state come with their rates: return (T, dT).")
        if not differences:
            differences.append(Differences(lambda t: rows(c.wrenches(t)), (0.0, duration)))
        return rows(value), differences[0](t)[1]

    last: dict[tuple[float, bytes], tuple[Array, Array]] = {}
    differences: list[Differences] = []
    state = np.concatenate([np.ravel(made.frames[body].pose.values)[:8], np.zeros(6)])
    for i in range(len(parts(0.0, state)[0])):
        row = Row(c, "twist", body, other, 1, power=True)

        def one(item: int, t: float, state: Array, i: int = i) -> Array:
            values, rates = parts(t, state)
            return np.concatenate([values[i], rates[i], np.zeros(6 + 3)])

        row.user = made.called.add(one, c.label, 3 * 6 + 3)
        made.rows.append(row)

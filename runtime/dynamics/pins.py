"""Frames of bodies for the driver, and the motions that pins leave: a group, fixed in the body."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..calls import call
from ..codegen.errors import InputError
from ..lengths import in_units, length_of
from ..multivector import Multivector
from .assembly import Frame
from .bodies import RigidBody
from .body_numbers import mass_matrix
from .constraints import Constraint, Pin
from .given import of_algebra
from .layouts import layout_of, on_layout

if TYPE_CHECKING:
    from ..algebras import Algebra

Array = NDArray[Any]
#: Shares of what pins take away that count as rounding.
NOISE = 1e-9


def principal_frame(body: RigidBody, origin: Array) -> Frame:
    """At the centre of mass, along the principal axes."""
    own = body.algebra.motor_from_matrix(body.axes)
    return Frame(own, _pose(body, origin, own), body.moments)


def _pose(body: RigidBody, origin: Array, own: Multivector) -> Multivector:
    """Of the driver's frame, in a world with this origin: the place is subtracted before it is squared."""
    algebra = body.algebra
    turn = algebra.motor_from_matrix(body.rotation)
    pose: Multivector = algebra.translator(body.position - origin) * turn * own
    return pose.as_kind("motor", check=False)


def rates_of(x: Multivector, layout: str) -> Array:
    """X x E (..., k, 6) for the unit twists E."""
    algebra = x.algebra
    on = algebra.wrap(algebra.kind(layout).layout, on_layout(x, layout))
    row: Array = call(algebra, "pins.moved_rates", on).value
    size = algebra.kind(layout).size
    return np.swapaxes(row.reshape(*row.shape[:-1], 6, size), -1, -2)


def twists_left(objects: Sequence[Multivector]) -> Array:
    """A basis (m, 6) of the twists that move none of these: orthonormal rows of coefficients."""
    rows = []
    for x in objects:
        matrix = rates_of(x, layout_of([x], "the object"))
        norms = np.linalg.norm(matrix, axis=-1, keepdims=True)
        rows.append(np.divide(matrix, norms, out=np.zeros_like(matrix), where=norms > 0))
    _, values, basis = np.linalg.svd(np.concatenate(rows))
    rank = int((values > NOISE * max(values.max(initial=0), 1)).sum())
    return basis[rank:]


def pin_frame(body: RigidBody, constraints: Sequence[Constraint]) -> tuple[list[Frame], Array]:
    """The frame of a body whose pins never move, at the pins and along what they leave; and the world's origin there.

    Of a batch the pins are the same in all bodies: so is the frame, but for a body that turns about a point, whose
    axes are its own principal ones.
    """
    algebra = body.algebra
    objects = [of_algebra(c.body_object, algebra, "the body's object") for c in constraints if isinstance(c, Pin)]
    if any(x.shape for x in objects):
        raise InputError("a pinned object is one object; a batch of simulations shares it.")
    unit = float(length_of(objects))
    objects = [in_units(x, unit) for x in objects]
    near = _center(algebra, twists_left(objects))
    middle, objects = unit * near, [~algebra.translator(near) >> x for x in objects]
    at = algebra.translator(middle)
    basis = twists_left(objects)
    turns, ways = _vectors(algebra, basis)
    axes = _axes(turns, ways)
    along = algebra.motor_from_matrix(axes)
    own = (at * along).as_kind("motor", check=False)
    inner = (~own * algebra.motor_from_matrix(body.axes)).as_kind("motor", check=False)
    matrix = mass_matrix(algebra, body.mass, body.moments, inner)
    if len(basis) == 3 and np.linalg.matrix_rank(turns, tol=1e-6) == 3:
        turn = _principal_axes(algebra, matrix)
        own = (own * algebra.motor_from_matrix(turn)).as_kind("motor", check=False)
        inner = (~own * algebra.motor_from_matrix(body.axes)).as_kind("motor", check=False)
        matrix = mass_matrix(algebra, body.mass, body.moments, inner)
        allowed = is_turn(algebra)
    else:
        allowed = np.abs(twists_left([~along >> x for x in objects])).max(0, initial=0) > 1e-6
        if allowed.sum() != len(basis):
            raise InputError("these pins leave no group of motions along axes; give stabilization='projection'.")
    moments = _moments(algebra, matrix)
    place = np.einsum("...ij,...j->...i", body.rotation, middle)
    origin = body.position + place
    pose = (
        algebra.motor_from_matrix(body.rotation) * algebra.motor_from_matrix(algebra.matrix(own)[..., :3, :3])
    ).as_kind("motor", check=False)
    return [Frame(own, pose, moments, allowed)], origin


def _vectors(algebra: Algebra, rows: Array) -> tuple[Array, Array]:
    """w and v (m, 3) of twists w I3 + v n."""
    found = call(algebra, "mechanics.screw_vectors", algebra.wrap(algebra.kind("twist"), np.ascontiguousarray(rows)))
    first, second = (v.values for v in found.values)
    return first, second


def is_turn(algebra: Algebra) -> Array:
    """Which coefficients of a twist are turns."""
    turns, _ = _vectors(algebra, np.eye(6))
    return np.asarray(np.abs(turns).max(-1) > 0)


def _center(algebra: Algebra, basis: Array) -> Array:
    """A point about which the turning that is left carries no shift, but for shifts that are free anyway."""
    turns, ways = _vectors(algebra, basis)
    values = np.linalg.svd(turns.T @ turns)[1] if len(turns) else np.zeros(3)
    if not len(turns) or values.max() < NOISE:
        return np.zeros(3)
    free = _free_ways(turns, ways)
    # v - c x w, less its part along free ways, is least
    rows, right = [], []
    across = np.eye(3) - free.T @ free
    for w, v in zip(turns, ways, strict=True):
        rows.append(across @ _cross(w))
        right.append(across @ v)
    left, sizes, basis = np.linalg.svd(np.concatenate(rows), full_matrices=False)
    inverse = np.divide(1, sizes, out=np.zeros(3), where=sizes > NOISE * np.sqrt(values.max()))
    found: Array = basis.T @ (inverse * (left.T @ np.concatenate(right)))
    return found


def _cross(w: Array) -> Array:
    """Matrix of c -> c x w."""
    return np.array([[0, w[2], -w[1]], [-w[2], 0, w[0]], [w[1], -w[0], 0]])


def _free_ways(turns: Array, ways: Array) -> Array:
    """Directions (k, 3) of translations among the motions."""
    _, values, mix = np.linalg.svd(turns.T)
    rank = int((values > 1e-6 * max(values.max(initial=0), 1e-300)).sum())
    pure = mix[rank:] @ ways
    if not len(pure):
        return np.zeros((0, 3))
    _, values, basis = np.linalg.svd(pure)
    return basis[: int((values > 1e-6).sum())]


def _axes(turns: Array, ways: Array) -> Array:
    """Axes (columns): the third along the axis of turning, or the first ones along free ways."""
    _, values, basis = np.linalg.svd(turns) if len(turns) else (None, np.zeros(0), np.eye(3))
    rank = int((values > 1e-6).sum())
    if rank == 1:
        third = basis[0]
        first = basis[1]
    elif rank == 0 and len(ways):
        _, _, basis = np.linalg.svd(ways)
        first, third = basis[0], basis[2]
    else:
        return np.eye(3)
    return np.stack([first, np.cross(third, first), third], 1)


def _tensor(algebra: Algebra, matrix: Array) -> Array:
    """Inertia (..., 3, 3) about the frame's origin, of a mass matrix."""
    turns, _ = _vectors(algebra, np.eye(6))
    return np.asarray(np.einsum("ia,...ij,jb->...ab", turns, matrix, turns))


def _principal_axes(algebra: Algebra, matrix: Array) -> Array:
    tensor = _tensor(algebra, matrix)
    off = np.abs(tensor * (1 - np.eye(3))).max((-1, -2), keepdims=True)
    _, axes = np.linalg.eigh(tensor)
    axes = axes * np.sign(np.linalg.det(axes))[..., None, None]
    found: Array = np.where(off <= 1e-15 * np.abs(tensor).max((-1, -2), keepdims=True), np.eye(3), axes)
    return found


def _moments(algebra: Algebra, matrix: Array) -> Array:
    moments: Array = _tensor(algebra, matrix).diagonal(axis1=-2, axis2=-1).copy()
    return moments

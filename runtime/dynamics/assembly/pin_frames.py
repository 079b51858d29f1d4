"""Frames of bodies for the driver, and the group of motions that fixed pins allow, expressed in the body's frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...core.geometry.scaling import in_units, length_of
from ...core.multivector import Multivector
from ...mechanics.arguments import multivector_of
from ...mechanics.motion_closed_kinds import layout_of
from ...mechanics.rigid_body import RigidBody
from ...mechanics.twists import commutator_matrix, rotational_mask, screw_vectors
from ..model.constraints import Constraint, Pin
from .body_parameters import mass_matrix
from .data import BodyFrame

if TYPE_CHECKING:
    from ...core.multivector import Algebra

Array = NDArray[Any]
#: Relative size of singular values of constraints that count as zero.
RANK_RTOL = 1e-9
#: Size of the parts of unit twists that count as zero.
TWIST_TOLERANCE = 1e-6
#: Products of inertia below this fraction of the tensor are zero: its axes are then principal as they are.
PRODUCTS_RTOL = 1e-15
#: Least divisor of a relative size: keeps zero over zero a number.
TINY = 1e-300


def principal_frame(body: RigidBody, origin: Array) -> BodyFrame:
    """Frame at the center of mass, along the principal axes."""
    to_body = body.algebra.motor_from_matrix(body.axes)
    return BodyFrame(to_body, _pose(body, origin, to_body), body.moments)


def _pose(body: RigidBody, origin: Array, to_body: Multivector) -> Multivector:
    """Pose of the driver's frame, in a world with this origin, which is subtracted before positions are squared."""
    algebra = body.algebra
    rotation = algebra.motor_from_matrix(body.rotation)
    pose: Multivector = algebra.translator(body.position - origin) * rotation * to_body
    return pose.as_kind("motor", check=False)


def admissible_twists(objects: Sequence[Multivector]) -> Array:
    """Basis (m, 6) of the twists that move none of the objects: orthonormal rows of coefficients."""
    rows = []
    for x in objects:
        matrix = commutator_matrix(x, layout_of([x], "the object"))
        norms = np.linalg.norm(matrix, axis=-1, keepdims=True)
        rows.append(np.divide(matrix, norms, out=np.zeros_like(matrix), where=norms > 0))
    _, values, basis = np.linalg.svd(np.concatenate(rows))
    rank = int((values > RANK_RTOL * max(values.max(initial=0), 1)).sum())
    return basis[rank:]


def pin_frame(body: RigidBody, constraints: Sequence[Constraint]) -> tuple[list[BodyFrame], Array]:
    """Frame of a body with fixed pins, at the pins and along its admissible motions; and the world's origin there.

    The pins of a batch are the same in all bodies, and so is the frame, except for a body that rotates about a point:
    the axes are then the principal ones of each body.

    Raises
    ------
    InputError
        If objects are batches, or the admissible motions are not along axes.
    """
    algebra = body.algebra
    objects = [multivector_of(c.body_object, algebra, "the body's object") for c in constraints if isinstance(c, Pin)]
    if any(x.shape for x in objects):
        raise InputError("a pinned object is one object; a batch of simulations shares it.")
    unit = float(length_of(objects))
    objects = [in_units(x, unit) for x in objects]
    center = _center(algebra, admissible_twists(objects))
    origin_in_body, objects = unit * center, [~algebra.translator(center) >> x for x in objects]
    basis = admissible_twists(objects)
    rotations, translations = screw_vectors(algebra, basis)
    rotation = algebra.motor_from_matrix(_axes(rotations, translations))
    to_body = (algebra.translator(origin_in_body) * rotation).as_kind("motor", check=False)
    matrix = _mass_matrix_in(body, to_body)
    if len(basis) == 3 and np.linalg.matrix_rank(rotations, tol=TWIST_TOLERANCE) == 3:
        principal = _principal_axes(algebra, matrix)
        to_body = (to_body * algebra.motor_from_matrix(principal)).as_kind("motor", check=False)
        matrix = _mass_matrix_in(body, to_body)
        allowed = rotational_mask(algebra)
    else:
        local = admissible_twists([~rotation >> x for x in objects])
        allowed = np.abs(local).max(0, initial=0) > TWIST_TOLERANCE
        if allowed.sum() != len(basis):
            raise InputError(
                "the null-space method needs pins whose admissible motions are rotations and translations along axes; "
                "give stabilization='projection'."
            )
    moments = _moments(algebra, matrix)
    origin = body.position + np.einsum("...ij,...j->...i", body.rotation, origin_in_body)
    pose = (
        algebra.motor_from_matrix(body.rotation) * algebra.motor_from_matrix(algebra.matrix(to_body)[..., :3, :3])
    ).as_kind("motor", check=False)
    return [BodyFrame(to_body, pose, moments, allowed)], origin


def _mass_matrix_in(body: RigidBody, to_body: Multivector) -> Array:
    """Mass matrix of a body in the driver's frame."""
    algebra = body.algebra
    principal = (~to_body * algebra.motor_from_matrix(body.axes)).as_kind("motor", check=False)
    return mass_matrix(algebra, body.mass, body.moments, principal)


def _center(algebra: Algebra, basis: Array) -> Array:
    """Point about which the admissible rotations have no translation, except for admissible ones."""
    rotations, translations = screw_vectors(algebra, basis)
    values = np.linalg.svd(rotations.T @ rotations)[1] if len(rotations) else np.zeros(3)
    if not len(rotations) or values.max() < RANK_RTOL:
        return np.zeros(3)
    pure = _pure_translations(rotations, translations)
    # least squares of v - c x w, without its part along admissible translations
    rows, right = [], []
    across = np.eye(3) - pure.T @ pure
    for w, v in zip(rotations, translations, strict=True):
        rows.append(across @ _cross(w))
        right.append(across @ v)
    left, sizes, basis = np.linalg.svd(np.concatenate(rows), full_matrices=False)
    inverse = np.divide(1, sizes, out=np.zeros(3), where=sizes > RANK_RTOL * np.sqrt(values.max()))
    center: Array = basis.T @ (inverse * (left.T @ np.concatenate(right)))
    return center


def _cross(w: Array) -> Array:
    """Matrix of c -> c x w."""
    return np.array([[0, w[2], -w[1]], [-w[2], 0, w[0]], [w[1], -w[0], 0]])


def _pure_translations(rotations: Array, translations: Array) -> Array:
    """Directions (k, 3) of the translations in the span of some twists."""
    _, values, mix = np.linalg.svd(rotations.T)
    rank = int((values > TWIST_TOLERANCE * max(values.max(initial=0), TINY)).sum())
    pure = mix[rank:] @ translations
    if not len(pure):
        return np.zeros((0, 3))
    _, values, basis = np.linalg.svd(pure)
    return basis[: int((values > TWIST_TOLERANCE).sum())]


def _axes(rotations: Array, translations: Array) -> Array:
    """Axes (columns): the third along the axis of rotation, or the first ones along translations."""
    _, values, basis = np.linalg.svd(rotations) if len(rotations) else (None, np.zeros(0), np.eye(3))
    rank = int((values > TWIST_TOLERANCE).sum())
    if rank == 1:
        third = basis[0]
        first = basis[1]
    elif rank == 0 and len(translations):
        _, _, basis = np.linalg.svd(translations)
        first, third = basis[0], basis[2]
    else:
        return np.eye(3)
    return np.stack([first, np.cross(third, first), third], 1)


def _tensor(algebra: Algebra, matrix: Array) -> Array:
    """Inertia (..., 3, 3) about the frame's origin, of a mass matrix."""
    rotations, _ = screw_vectors(algebra, np.eye(6))
    return np.asarray(np.einsum("ia,...ij,jb->...ab", rotations, matrix, rotations))


def _principal_axes(algebra: Algebra, matrix: Array) -> Array:
    """Principal axes (..., 3, 3) about the frame's origin, of a mass matrix."""
    tensor = _tensor(algebra, matrix)
    products = np.abs(tensor * (1 - np.eye(3))).max((-1, -2), keepdims=True)
    _, axes = np.linalg.eigh(tensor)
    axes = axes * np.sign(np.linalg.det(axes))[..., None, None]
    size = np.abs(tensor).max((-1, -2), keepdims=True)
    principal: Array = np.where(products <= PRODUCTS_RTOL * size, np.eye(3), axes)
    return principal


def _moments(algebra: Algebra, matrix: Array) -> Array:
    """Moments of inertia (..., 3) about the frame's axes, of a mass matrix."""
    moments: Array = _tensor(algebra, matrix).diagonal(axis1=-2, axis2=-1).copy()
    return moments


__all__ = ["admissible_twists", "pin_frame", "principal_frame"]

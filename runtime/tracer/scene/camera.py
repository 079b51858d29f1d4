"""Pinhole camera of thesis 4.3: a motor, a focal length, and the size of the image plane."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.algebra.multivector import Multivector, from_values
from ...codegen.formulas.rays import shading
from ...codegen.programs import cga3d
from ...codegen.rings.protocol import NumericRing
from ...common import memory
from ...common.validation import check_shape
from ...errors import SceneError
from .immutable import Immutable
from .values import finite, number, positive, unit, whole

Array = NDArray[np.float64]
#: Default vertical field of view in radians.
FIELD_OF_VIEW = math.radians(45.0)
#: Largest |M ~M - 1| of a motor that counts as normalized.
UNIT_TOLERANCE = 1e-6
#: Bytes of each ray: origin, direction, and as much again while they are computed.
RAY_BYTES = 96
#: Largest number of rays along a side; beyond it the message does not even tell the memory.
MOST_RAYS = 10**9


class Camera(Immutable):
    """Camera that looks along e2 from the origin, with e1 to the right and e3 up, displaced by a motor.

    Parameters
    ----------
    motor : (8,) array or multivector
        A motor, rotor or translator.
    focal_length : float
    x_max : float or None
        Width of the image plane; None: by the aspect ratio of the image.
    y_max : float
        Height of the image plane.
    """

    _shown = ("position", "focal_length", "y_max")

    def __init__(self, motor: Any, focal_length: float, x_max: float | None, y_max: float) -> None:
        self.motor = _motor_row(motor)
        displacement = _motor(self.motor)
        error = np.abs((displacement * ~displacement - 1).grade(0, 4).coefficients()[0].scalar())
        if error > UNIT_TOLERANCE:
            raise SceneError(f"camera.motor is not normalized: |M ~M - 1| is {error:.1e}.")
        self.focal_length = positive(focal_length, "camera.focal_length")
        self.x_max = None if x_max is None else positive(x_max, "camera.x_max")
        self.y_max = positive(y_max, "camera.y_max")
        self._frozen = True

    @classmethod
    def look_at(
        cls, position: Any, target: Any, up: Any = (0.0, 0.0, 1.0), field_of_view: float = FIELD_OF_VIEW
    ) -> Camera:
        """Camera at a position, with the target at the center of the picture.

        Parameters
        ----------
        position, target, up : (3,) arrays
            The vertical of the picture is the part of ``up`` perpendicular to the viewing direction.
        field_of_view : float
            Vertical angle, radians.
        """
        eye, towards = finite(position, "camera.position", 3), finite(target, "camera.look_at", 3)
        angle = number(field_of_view, "camera.field_of_view")
        if not 0 < angle < math.pi:
            raise SceneError(f"camera.field_of_view is {angle:g} rad; it lies between 0 and pi.")
        if np.array_equal(eye, towards):
            raise SceneError("camera.look_at is the camera's own position.")
        forward = unit(towards - eye, "camera.look_at")
        right = np.cross(forward, unit(up, "camera.up"))
        if np.linalg.norm(right) < 1e-9:  # of unit vectors: the rest is rounding
            raise SceneError("camera.up is parallel to the viewing direction; choose another.")
        right = unit(right, "camera.up")
        motor = _motor_of(eye, np.stack([right, forward, np.cross(right, forward)], axis=1))
        return cls(motor, 1.0, None, 2.0 * math.tan(angle / 2))

    @property
    def position(self) -> Array:
        """Position of the pinhole."""
        origin = shading.camera_position(_motor(self.motor))
        return np.array([origin[name].scalar() for name in ("e1", "e2", "e3")], np.float64)

    def constants(self, width: int, height: int) -> Array:
        """Row of constants for the driver: motor, focal length, width and height of the image plane."""
        return np.array([*self.motor, *self._lens(width, height)])

    def _lens(self, width: int, height: int) -> tuple[float, float, float]:
        x_max = self.y_max * width / height if self.x_max is None else self.x_max
        return self.focal_length, x_max, self.y_max

    def rays(self, width: int, height: int) -> tuple[Array, Array]:
        """Origins and unit directions (height, width, 3) through the centers of the pixels; row 0 is the top.

        Raises
        ------
        SceneError
            If a size is not a positive whole number, or the rays need more than the available memory.
        """
        width, height = whole(width, "width", 1, MOST_RAYS), whole(height, "height", 1, MOST_RAYS)
        free, needed = memory.available(), RAY_BYTES * width * height
        if free is not None and needed > free:
            raise SceneError(
                f"{width} x {height} rays take {memory.readable(needed)} of memory; {memory.readable(free)} are free.",
                remedy="Compute them in parts, or render the picture, which needs no rays",
            )
        ring, algebra = NumericRing(), cga3d()

        def scalar(x: Any) -> Multivector:
            return from_values(algebra, ring, (0,), [np.asarray(x, np.float64)])

        right = 2 * (np.arange(width) + 0.5) / width - 1
        up = 1 - 2 * (np.arange(height) + 0.5) / height
        lens = shading.Lens(*map(scalar, self._lens(width, height)))
        pixel = shading.Pixel(scalar(right[None, :]), scalar(up[:, None]))
        direction = shading.camera_direction(_motor(self.motor), lens, pixel)
        parts = [np.broadcast_to(direction[name].scalar(), (height, width)) for name in ("e1", "e2", "e3")]
        return np.broadcast_to(self.position, (height, width, 3)).copy(), np.stack(parts, axis=-1)


def _motor_row(motor: Any) -> Array:
    """Coefficients on a motor's blades; those that a rotor or a translator lacks are zero."""
    kind = cga3d().kind("motor")
    terms = getattr(motor, "terms", None)
    if terms is None:
        return finite(motor, "camera.motor", kind.size)
    algebra = getattr(motor, "algebra", None)
    if getattr(algebra, "name", None) != cga3d().name:
        raise SceneError(f"camera.motor belongs to {algebra}; a motor of {cga3d().name} is needed.")
    if not set(terms) <= set(kind.blades):
        raise SceneError("camera.motor has blades that are not those of a motor.")
    check_shape(motor, "camera.motor", (), SceneError)
    return finite([terms.get(blade, 0.0) for blade in kind.blades], "camera.motor", kind.size)


def _motor(values: Array) -> Multivector:
    return from_values(cga3d(), NumericRing(), cga3d().kind("motor").blades, list(values))


def _motor_of(position: Array, axes: Array) -> Array:
    """Motor that maps e1, e2, e3 at the origin to the columns of ``axes`` at a position."""
    w, x, y, z = _quaternion(axes)
    like = from_values(cga3d(), NumericRing(), (0,), [1.0])
    e1, e2, e3, ni = (like.basis(name) for name in ("e1", "e2", "e3", "ni"))

    def scalar(value: float) -> Multivector:
        return from_values(cga3d(), NumericRing(), (0,), [value])

    # cos(th/2) - sin(th/2) a I3, with e23 = e1 I3 and so on
    rotor = scalar(w) - scalar(x) * (e2 * e3) - scalar(y) * (e3 * e1) - scalar(z) * (e1 * e2)
    translation = scalar(position[0]) * e1 + scalar(position[1]) * e2 + scalar(position[2]) * e3
    motor = (1 - translation * ni / 2) * rotor
    return np.array(cga3d().kind("motor").values(motor), np.float64)


def _quaternion(m: Array) -> tuple[float, float, float, float]:
    """Cosine, and axis times sine, of half the angle; from the largest of the four, without cancellation."""
    four = np.array([1 + np.trace(m), *(1 + 2 * m[i, i] - np.trace(m) for i in range(3))])
    k = int(np.argmax(four))
    q = np.empty(4)
    if k == 0:
        q[:] = [four[0], m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]]
    else:
        i, j, n = k - 1, k % 3, (k + 1) % 3
        q[0] = m[n, j] - m[j, n]
        q[1 + i], q[1 + j], q[1 + n] = four[k], m[j, i] + m[i, j], m[n, i] + m[i, n]
    q = q / np.sqrt(q @ q)
    q = -q if q[0] < 0 else q
    return float(q[0]), float(q[1]), float(q[2]), float(q[3])

"""Parameters of constraints as the compiled driver reads them: each is A[~S V S] = H."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...common.finite_differences import Differences
from ...common.validation import finite_array
from ...core.multivector import Multivector
from ...mechanics.arguments import multivector_of
from ...mechanics.motion_closed_kinds import basis, layout_of, matrix_of, on_layout, sandwich_matrix
from ..model.constraints import Constraint, Incidence, Pin, PinLinear, PinPath, VirtualPower
from .data import Assembly, DriverConstraint, item_of
from .far_spheres import far_sphere, unknown_of
from .power_parameters import pack_power, pack_power_function

if TYPE_CHECKING:
    from ...core.multivector import Algebra

Array = NDArray[Any]
#: Function of time that gives an object, or the object and its two derivatives.
Path = Callable[[float], list[Multivector]]
#: Relative difference below which two objects are the same.
SAME = 1e-9


def pack_constraint(assembly: Assembly, constraint: Constraint, duration: float) -> None:
    """Add a constraint to the assembly.

    Raises
    ------
    InputError, GradeError, ShapeError, KindError, AlgebraMismatchError
        If its objects, paths or bodies are not valid in this simulation.
    """
    label = constraint.label
    body, other = assembly.body_index(constraint.body, label), assembly.body_index(constraint.other, label)
    if body < 0 or body == other:
        raise InputError(
            f"{label} is between {constraint.body!r} and {constraint.other!r}; it takes a body and something else."
        )
    match constraint:
        case Pin():
            _pack_pin(assembly, constraint, body, other)
        case PinPath():
            _pack_linear(
                assembly, constraint, body, other, None, constraint.world_object, constraint.body_object, duration
            )
        case PinLinear():
            _pack_linear(
                assembly, constraint, body, other, constraint.function, constraint.world_object, constraint.H,
                duration,
            )  # fmt: skip
        case Incidence():
            point = multivector_of(constraint.body_point, assembly.algebra, "the body's point")
            point = _check_shape(point, "the body's point")
            product = (lambda x: point ^ x) if not assembly.algebra.is_degenerate else (lambda x: point & x)
            _pack_linear(assembly, constraint, body, other, product, constraint.world_object, 0, duration)
        case VirtualPower() if callable(constraint.wrenches):
            pack_power_function(assembly, constraint, body, other, duration)
        case VirtualPower():
            pack_power(assembly, constraint, body, other)
        case _:
            raise InputError(
                f"{constraint!r} is not a constraint; there are Pin, PinPath, PinLinear, Incidence, VirtualPower."
            )


def relative_pose(assembly: Assembly, body: int, other: int) -> Multivector:
    """Motor of a body's driver frame, expressed in that of another, at the start."""
    pose = assembly.frames[body].pose
    return pose if other < 0 else ~assembly.frames[other].pose * pose


def moved_near(object_: Multivector, exact: Multivector) -> Multivector:
    """The exact object if the given one equals it up to rounding, else the given one.

    Far from the origin the coefficients of what users give have lost digits of the position.
    """
    difference = (object_ - exact).values
    size = np.abs(object_.values).max()
    return exact if np.abs(difference).max(initial=0) <= SAME * size else object_


def _check_shape(x: Multivector, what: str, size: int = 1) -> Multivector:
    """One object that all simulations share, or one for each of them."""
    if x.shape not in ((), (size,)):
        raise InputError(f"{what} has shape {x.shape}; one object is needed, or one for each of {size} simulations.")
    return x


# -- pins and linear functions -----------------------------------------------------------------------------------


def _pack_pin(assembly: Assembly, pin: Pin, body: int, other: int) -> None:
    local = _check_shape(multivector_of(pin.body_object, assembly.algebra, "the body's object"), "the body's object")
    local = ~assembly.frame_motor(body) >> local
    layout = layout_of([local], pin.label)
    pinned = relative_pose(assembly, body, other) >> local
    if pin.world_object is not None:
        world_object = multivector_of(pin.world_object, assembly.algebra, "the world's object")
        world_object = _check_shape(world_object, "the world's object", assembly.size)
        pinned = moved_near(~assembly.frame_motor(other) >> world_object, pinned)
    packed = DriverConstraint(pin, layout, body, other, assembly.algebra.kind(layout).size)
    packed.object_offset = assembly.append(on_layout(pinned, layout))
    packed.target_offset = assembly.append(on_layout(local, layout))
    assembly.driver_constraints.append(packed)


def _pack_linear(
    assembly: Assembly, constraint: Constraint, body: int, other: int, function: Any, world: Any, target: Any,
    duration: float,
) -> None:  # fmt: skip
    """Add A[~S V S] = H; without a function A is the identity, and H an object of the body."""
    varies = callable(world) or callable(target)
    if assembly.size > 1 and varies:
        raise InputError(
            f"{constraint.label} has functions of time; those are for one simulation, not for a batch of "
            f"{assembly.size}."
        )
    algebra = assembly.algebra
    frame = _frame(assembly, other, callable(world))
    path = _path(world, assembly, "the world's object", frame, blades=isinstance(constraint, Incidence))
    if function is None:
        local = _path(target, assembly, "the body's object", _frame(assembly, body, callable(target)))
        layout = layout_of([path(0.0)[0], path(duration)[0], local(0.0)[0]], constraint.label)
        equations, matrix = algebra.kind(layout).size, None

        def goal(t: float) -> list[Array]:
            return [_coefficients_on(x, layout, t, "the body's object") for x in local(t)]
    else:
        layout = layout_of([path(0.0)[0], path(duration)[0]], constraint.label)
        matrix = matrix_of(function, algebra, layout, f"the function of {constraint.label}")
        blades = _blades_of(function, algebra, layout)
        equations = len(matrix)
        matrix = matrix @ sandwich_matrix(assembly.frame_motor(body), layout)  # bodies of a batch have different frames

        def goal(t: float) -> list[Array]:
            value = target(t) if callable(target) else target
            return [_on_blades(x, blades, algebra) for x in (value if isinstance(value, tuple) else (value,))]

    packed = DriverConstraint(constraint, layout, body, other, equations)
    if varies:
        objects = (
            _object_derivatives(path, layout, duration, "the world's object")
            if callable(world)
            else _constant(on_layout(path(0.0)[0], layout))
        )
        targets = _target_derivatives(goal, duration) if callable(target) else _constant(goal(0.0)[0])

        def error_of_radius(t: float) -> float:
            value = world(t) if isinstance(constraint, Incidence) and callable(world) else ()
            return max((unknown_of(x) for x in (value if isinstance(value, tuple) else (value,))[:1]), default=0.0)

        packed.callback = assembly.callbacks.add(
            lambda item, t, state: np.concatenate([*objects(t), *targets(t), error_of_radius(t)], axis=None),
            constraint.label,
            3 * (algebra.kind(layout).size + equations) + 1,
        )
    else:
        far = _far_sphere(assembly, constraint, world, frame, body, other)
        fixed, radius_error = (path(0.0)[0], 0.0) if far is None else far
        if radius_error:
            packed.error_offset = assembly.append([radius_error])
        packed.object_offset = assembly.append(on_layout(fixed, layout))
        packed.target_offset = assembly.append(goal(0.0)[0])
    if matrix is not None:
        packed.matrix_offset = assembly.append(matrix.reshape(*matrix.shape[:-2], -1))
    assembly.driver_constraints.append(packed)


def _frame(assembly: Assembly, body: int, single: bool) -> Multivector:
    """Motor of a driver's frame to the user's; of the first simulation, where there is only one."""
    motor = assembly.frame_motor(body)
    return item_of(motor, 0) if single else motor


def _far_sphere(
    assembly: Assembly, constraint: Constraint, world: Multivector, frame: Multivector, body: int, other: int
) -> tuple[Multivector, float] | None:
    """Sphere of an incidence that is far from the origin, and the error of its radius."""
    if not isinstance(constraint, Incidence):
        return None
    point = relative_pose(assembly, body, other) >> (~assembly.frame_motor(body) >> constraint.body_point)
    return far_sphere(world, frame, point)


# -- paths -------------------------------------------------------------------------------------------------------


def _path(value: Any, assembly: Assembly, what: str, frame: Multivector, blades: bool = False) -> Path:
    """Function of time that expresses an object and its derivatives in a frame; ``blades`` rebuilds the object."""

    def at(t: float) -> list[Multivector]:
        values = value(t) if callable(value) else value
        parts = values if isinstance(values, tuple) else (values,)
        local = [~frame >> _check_shape(multivector_of(x, assembly.algebra, what), what, assembly.size) for x in parts]
        return [_rebuilt_blade(local[0]), *local[1:]] if blades else local

    return at


def _rebuilt_blade(x: Multivector) -> Multivector:
    """Line or circle built again from its parameters; others as they are.

    After a long translation rounding makes it no longer an exact blade, and the incidence would have one equation too
    many.
    """
    if x.kind.name not in ("line", "circle"):
        return x
    unit: Multivector = getattr(x.algebra, x.kind.name)(*x.parameters()).as_kind(x.kind.name)
    weight = (unit.values * x.values).sum(-1) / (unit.values**2).sum(-1)
    return unit * weight if np.isfinite(weight).all() and (weight != 0).all() else x


def _coefficients_on(x: Multivector, layout: str, t: float, what: str) -> Array:
    """Coefficients on a layout; others must be rounding."""
    blades = x.algebra.kind(layout).blades
    sizes = np.abs(x.values)
    for b, size in zip(x.kind.blades, sizes, strict=True):
        if b not in blades and size > SAME * sizes.max():
            raise InputError(
                f"{what} changes its type at time {t:.6g}: it has {x.algebra.blade_name(b)}, which it has not at the "
                "start and the end."
            )
    return on_layout(x, layout)


def _object_derivatives(path: Path, layout: str, duration: float, what: str) -> Callable[[float], Any]:
    """Function of time that gives coefficients (3, k) of a path and its two derivatives."""
    if len(path(0.0)) == 3:
        return lambda t: np.stack([_coefficients_on(x, layout, t, what) for x in path(t)])
    return Differences(lambda t: _coefficients_on(path(t)[0], layout, t, what), (0.0, duration))


def _target_derivatives(goal: Callable[[float], list[Array]], duration: float) -> Callable[[float], Any]:
    """Function of time that gives values (3, k) of a target and its two derivatives."""
    if len(goal(0.0)) == 3:
        return lambda t: np.stack(goal(t))
    return Differences(lambda t: goal(t)[0], (0.0, duration))


def _constant(values: Array) -> Callable[[float], Any]:
    """Function of time whose derivatives are zero."""
    fixed = np.stack([values, 0 * values, 0 * values])
    return lambda t: fixed


def _blades_of(function: Any, algebra: Algebra, layout: str) -> list[int]:
    """Blades on which a linear function has values, in order."""
    y = function(basis(algebra, layout))
    used = [b for b, v in zip(y.kind.blades, np.moveaxis(y.values, -1, 0), strict=True) if np.any(v)]
    return sorted(used)


def _on_blades(x: Any, blades: list[int], algebra: Algebra) -> Array:
    """Coefficients of a target on the blades of its linear function."""
    if not isinstance(x, Multivector):
        x = algebra.scalar(float(finite_array(x, "the target")))
    x = _check_shape(multivector_of(x, algebra, "the target"), "the target")
    values = np.zeros(len(blades))
    for b, v in zip(x.kind.blades, x.values, strict=True):
        if b in blades:
            values[blades.index(b)] = v
        elif v:
            raise InputError(f"the target has {algebra.blade_name(b)}, which the linear function never gives.")
    return values


__all__ = ["moved_near", "pack_constraint", "relative_pose"]

"""Links of a tree of joints: motion from link to link, momenta, and inertias as they add up towards the root.

All is in the frame of a link, with its origin on the joint's axis; where all joints are at zero frames are parallel. A
motor M = T_d q takes the frame of a link to that of its parent: d is the displacement of the origin, and the rotor q is
here as the matrix of x -> q x ~q, row by row, for it is applied to many vectors. Twists V = w I3 + v n and wrenches
F = f I3 + tau n as in `mechanics`; a joint has the unit twist S = k a I3 + l a n, for its axis a is through the origin.

A rigid link has a mass m, the first moment h = m c of its center, and the tensor J about the frame's origin (xx, xy,
xz, yy, yz, zz): Q(V) = (m v + w x h) I3 + (J w + h x v) n. An articulated inertia has three matrices, f = P v + H w and
tau = H^T v + J w: six numbers of P, nine of H row by row, six of J. One text for CGA and PGA.
"""

from __future__ import annotations

from collections.abc import Sequence

from ...algebra.multivector import Multivector, cos, sin
from ...trace.outputs import Result, named, row
from ..motions.screws import direction_part
from ..objects.euclidean import attached_part, axes, coordinates, cross, dot, null_vector, vector
from ..products.frames import matrix_of
from .mechanics import bracket, coefficient, power, screw_of, twist_blades

#: Matrices by rows.
Matrix = list[list[Multivector]]


# -- matrices ----------------------------------------------------------------------------------------------


def _square(numbers: Sequence[Multivector]) -> Matrix:
    return [list(numbers[3 * i : 3 * i + 3]) for i in range(3)]


def _symmetric(numbers: Sequence[Multivector]) -> Matrix:
    xx, xy, xz, yy, yz, zz = numbers
    return [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]


def _upper(matrix: Matrix) -> list[Multivector]:
    """The six numbers of a symmetric matrix."""
    return [matrix[i][j] for i in range(3) for j in range(i, 3)]


def _transposed(matrix: Matrix) -> Matrix:
    return [[matrix[j][i] for j in range(3)] for i in range(3)]


def _sum(terms: Sequence[Multivector]) -> Multivector:
    return terms[0].sum(terms)


def _product(a: Matrix, b: Matrix) -> Matrix:
    return [[_sum([a[i][k] * b[k][j] for k in range(3)]) for j in range(3)] for i in range(3)]


def _turned_symmetric(rotation: Matrix, matrix: Matrix) -> Matrix:
    """R A R^T of a symmetric A."""
    half = _product(rotation, matrix)
    upper = [_sum([half[i][k] * rotation[j][k] for k in range(3)]) for i in range(3) for j in range(i, 3)]
    return _symmetric(upper)


def _apply(matrix: Matrix, x: Multivector) -> Multivector:
    c = coordinates(x)
    return vector(tuple(_sum([matrix[i][k] * c[k] for k in range(3)]) for i in range(3)))


def _crossing(d: Multivector) -> Matrix:
    """The matrix of x -> d x x."""
    return _columns([cross(d, e) for e in axes(d)])


def _columns(vectors: Sequence[Multivector]) -> Matrix:
    return _transposed([coordinates(v) for v in vectors])


def _outer(a: Multivector, b: Multivector) -> Matrix:
    return [[x * y for y in coordinates(b)] for x in coordinates(a)]


def _add(a: Matrix, b: Matrix, sign: int = 1) -> Matrix:
    return [[x + y if sign > 0 else x - y for x, y in zip(p, q, strict=True)] for p, q in zip(a, b, strict=True)]


# -- from link to link -------------------------------------------------------------------------------------


def joint_rotation(axis: Multivector, angle: Multivector) -> Result:
    """The matrix of x -> q x ~q with q = exp(-angle a I3/2): c x + s a x x + (1 - c) (a . x) a, row by row."""
    c, s = cos(angle), sin(angle)
    rest = (1 - c) * axis
    matrix = matrix_of(lambda x: c * x + s * cross(axis, x) + dot(rest, x) * axis, axes(axis), axes(axis))
    return row([m for entries in matrix for m in entries], "rotation")


def frame_rotation(q: Multivector) -> Result:
    """The matrix of x -> q x q^-1 of a rotor whose norm is 1 but for rounding, row by row."""
    scale = 1 / q.scalar_product(~q)
    matrix = matrix_of(lambda x: scale * (q * x * ~q), axes(q), axes(q))
    return row([m for entries in matrix for m in entries], "rotation")


def joint_displacement(offset: Multivector, axis: Multivector, advance: Multivector) -> Multivector:
    """The origin of a link's frame in that of its parent."""
    return offset + advance * axis


def _joint(axis: Multivector, rotation: Multivector, advance: Multivector) -> Multivector:
    return screw_of(rotation * axis, advance * axis)


def to_child(turn: Sequence[Multivector], displacement: Multivector, twist: Multivector) -> Multivector:
    """Twist of a link's parent in the frame of the link."""
    return _to_child(turn, displacement, twist)


def _to_child(turn: Sequence[Multivector], displacement: Multivector, twist: Multivector) -> Multivector:
    """~M V M."""
    back = _transposed(_square(turn))
    w, v = direction_part(twist), attached_part(twist)
    return screw_of(_apply(back, w), _apply(back, v + cross(w, displacement)))


def _to_parent(turn: Sequence[Multivector], displacement: Multivector, wrench: Multivector) -> Multivector:
    """M F ~M."""
    matrix = _square(turn)
    f, tau = _apply(matrix, direction_part(wrench)), _apply(matrix, attached_part(wrench))
    return screw_of(f, tau + cross(displacement, f))


def link_motion(
    turn: Sequence[Multivector], displacement: Multivector, axis: Multivector, rotation: Multivector,
    advance: Multivector, speed: Multivector, acceleration: Multivector, omega: Multivector, rate: Multivector,
) -> tuple[Result, Result]:  # fmt: skip
    """Twist of a link and its rate from those of its parent: V + S dx, and dV + S ddx + dx S x V (7.13, 7.14)."""
    joint = _joint(axis, rotation, advance)
    own = _to_child(turn, displacement, omega) + speed * joint
    carried = _to_child(turn, displacement, rate)
    return named("own_omega", own), named("own_rate", carried + acceleration * joint + speed * bracket(joint, own))


def link_velocity(
    turn: Sequence[Multivector], displacement: Multivector, axis: Multivector, rotation: Multivector,
    advance: Multivector, speed: Multivector, omega: Multivector,
) -> tuple[Result, Result]:  # fmt: skip
    """Twist of a link from that of its parent, and what its rate is besides: dx S x V."""
    joint = _joint(axis, rotation, advance)
    own = _to_child(turn, displacement, omega) + speed * joint
    return named("own_omega", own), named("drift", speed * bracket(joint, own))


def add_motion(
    axis: Multivector, rotation: Multivector, advance: Multivector, speed: Multivector, acceleration: Multivector,
    before: Multivector, omega: Multivector, rate: Multivector,
) -> tuple[Result, Result]:  # fmt: skip
    """Twist and rate of a link with one of the freedoms of its joint more; ``before``: the twist without any."""
    joint = _joint(axis, rotation, advance)
    own_rate = rate + acceleration * joint + speed * bracket(joint, before)
    return named("own_omega", omega + speed * joint), named("own_rate", own_rate)


def add_velocity(
    axis: Multivector, rotation: Multivector, advance: Multivector, speed: Multivector, before: Multivector,
    omega: Multivector,
) -> tuple[Result, Result]:  # fmt: skip
    """Twist of a link with one of the freedoms of its joint more, and that freedom's part of the drift."""
    joint = _joint(axis, rotation, advance)
    return named("own_omega", omega + speed * joint), named("drift", speed * bracket(joint, before))


def add_to_parent(
    turn: Sequence[Multivector], displacement: Multivector, wrench: Multivector, total: Multivector
) -> Multivector:
    """Wrench on a link's parent, with that on the link."""
    return total + _to_parent(turn, displacement, wrench)


def joint_force(axis: Multivector, rotation: Multivector, advance: Multivector, wrench: Multivector) -> Multivector:
    """Power of a wrench on the unit twist of a joint."""
    return rotation * dot(axis, attached_part(wrench)) + advance * dot(axis, direction_part(wrench))


# -- rigid links -------------------------------------------------------------------------------------------


def _momentum(mass: Multivector, moment: Multivector, tensor: Sequence[Multivector], twist: Multivector) -> Multivector:
    w, v = direction_part(twist), attached_part(twist)
    return screw_of(mass * v + cross(w, moment), _apply(_symmetric(tensor), w) + cross(moment, v))


def link_wrench(
    mass: Multivector, moment: Multivector, tensor: Sequence[Multivector], omega: Multivector, rate: Multivector
) -> Multivector:
    """The wrench that the motion of a link takes: Q(dV) - V x Q(V)."""
    return _momentum(mass, moment, tensor, rate) - bracket(omega, _momentum(mass, moment, tensor, omega))


def link_bias(mass: Multivector, moment: Multivector, tensor: Sequence[Multivector], omega: Multivector) -> Multivector:
    """The part of `link_wrench` from the velocity: -V x Q(V)."""
    return -bracket(omega, _momentum(mass, moment, tensor, omega))


def joint_momentum(
    mass: Multivector, moment: Multivector, tensor: Sequence[Multivector], axis: Multivector, rotation: Multivector,
    advance: Multivector,
) -> Multivector:  # fmt: skip
    """Q(S) of a joint's unit twist."""
    return _momentum(mass, moment, tensor, _joint(axis, rotation, advance))


def add_link(
    turn: Sequence[Multivector], displacement: Multivector, mass: Multivector, moment: Multivector,
    tensor: Sequence[Multivector], total_moment: Multivector, total_tensor: Sequence[Multivector],
) -> tuple[Result, Result]:  # fmt: skip
    """First moment and tensor of a link's parent, with those of the link (its mass is added by itself).

    About the parent's origin: J' = R J R^T - [d][R h] - [R h][d] - m [d][d], of which the last three are a symmetric
    matrix of d and e = R h + m d/2, which is 2 (d . e) - d e^T - e d^T.
    """
    matrix, like = _square(turn), mass
    h = _apply(matrix, moment)
    e = h + mass * displacement / 2
    shift = _outer(displacement, e)
    both, own = 2 * dot(displacement, e), _turned_symmetric(matrix, _symmetric(tensor))
    upper = [
        own[i][j] + total - (shift[i][j] + shift[j][i]) + (both if i == j else like.constant(0))
        for (i, j), total in zip([(i, j) for i in range(3) for j in range(i, 3)], total_tensor, strict=True)
    ]
    return named("new_moment", total_moment + h + mass * displacement), row(upper, "new_tensor")


# -- articulated inertias ----------------------------------------------------------------------------------


def _blocks(inertia: Sequence[Multivector]) -> tuple[Matrix, Matrix, Matrix]:
    return _symmetric(inertia[:6]), _square(inertia[6:15]), _symmetric(inertia[15:])


def _row_of_blocks(p: Matrix, h: Matrix, j: Matrix) -> Result:
    return row([*_upper(p), *(x for entries in h for x in entries), *_upper(j)], "inertia")


def _articulated_wrench(inertia: Sequence[Multivector], twist: Multivector) -> Multivector:
    p, h, j = _blocks(inertia)
    w, v = direction_part(twist), attached_part(twist)
    return screw_of(_apply(p, v) + _apply(h, w), _apply(_transposed(h), v) + _apply(j, w))


def rigid_inertia(mass: Multivector, moment: Multivector, tensor: Sequence[Multivector]) -> Result:
    """A link's own inertia in the form of articulated ones: P = m, H w = w x h."""
    zero = mass.constant(0)
    p = [[mass if i == j else zero for j in range(3)] for i in range(3)]
    return _row_of_blocks(p, _columns([cross(e, moment) for e in axes(moment)]), _symmetric(tensor))


def articulated_momentum(
    inertia: Sequence[Multivector], axis: Multivector, rotation: Multivector, advance: Multivector
) -> tuple[Result, Result]:
    """U = I(S) of a joint's unit twist, and its power on S: the inertia that the joint feels."""
    joint = _joint(axis, rotation, advance)
    u = _articulated_wrench(inertia, joint)
    return named("u", u), named("felt", joint_force(axis, rotation, advance, u))


def release(
    inertia: Sequence[Multivector], bias: Multivector, drift: Multivector, u: Multivector, compliance: Multivector,
    force: Multivector,
) -> tuple[Result, Result]:  # fmt: skip
    """Inertia and bias of a link behind its joint as seen from before: I - U U^T/D, p + I'(c) + U f/D.

    ``compliance`` is 1/D, ``force`` what is left for the joint to accelerate.
    """
    p, h, j = _blocks(inertia)
    f, tau = direction_part(u), attached_part(u)
    f_scaled, tau_scaled = compliance * f, compliance * tau
    p = _symmetric(_upper(_add(p, _outer(f_scaled, f), -1)))
    h = _add(h, _outer(f_scaled, tau), -1)
    j = _symmetric(_upper(_add(j, _outer(tau_scaled, tau), -1)))
    reduced = _row_of_blocks(p, h, j)
    moved = _articulated_wrench([*_upper(p), *(x for entries in h for x in entries), *_upper(j)], drift)
    return reduced, named("new_bias", bias + moved + (compliance * force) * u)


def add_articulated(
    turn: Sequence[Multivector], displacement: Multivector, inertia: Sequence[Multivector], total: Sequence[Multivector]
) -> Result:
    """Inertia of a link's parent, with that of the link.

    With D = [d] and the matrices turned: H' = H - P D, J' = J - H^T D + D H'.
    """
    matrix, d = _square(turn), _crossing(displacement)
    p, h, j = _blocks(inertia)
    p, j = _turned_symmetric(matrix, p), _turned_symmetric(matrix, j)
    h = _product(_product(matrix, h), _transposed(matrix))
    moved = _add(h, _product(p, d), -1)
    shift = _add(_product(d, moved), _product(_transposed(h), d), -1)
    own = [*_upper(p), *(x for entries in moved for x in entries), *_upper(_add(j, shift))]
    return row([a + b for a, b in zip(own, total, strict=True)], "new_inertia")


def joint_acceleration(
    turn: Sequence[Multivector], displacement: Multivector, axis: Multivector, rotation: Multivector,
    advance: Multivector, drift: Multivector, u: Multivector, compliance: Multivector, force: Multivector,
    rate: Multivector,
) -> tuple[Result, Result]:  # fmt: skip
    """Acceleration of a joint, and the rate of its link's twist, from that of its parent."""
    carried = _to_child(turn, displacement, rate) + drift
    acceleration = compliance * (force - power(carried, u))
    return (
        named("acceleration", acceleration),
        named("own_rate", carried + acceleration * _joint(axis, rotation, advance)),
    )


def rest_rate(gravity: Multivector) -> Result:
    """Rate of the twist of a root that does not fall, on all blades of twists: -g n."""
    rate = -gravity * null_vector(gravity)
    return row([coefficient(rate, b) for b in twist_blades(rate.algebra)], "rate")


def pass_wrench(
    turn: Sequence[Multivector], displacement: Multivector, bias: Multivector, u: Multivector, compliance: Multivector,
    force: Multivector, total: Multivector,
) -> Multivector:  # fmt: skip
    """Bias of a link's parent with that of the link, which gives way along its joint: p + U f/D."""
    return total + _to_parent(turn, displacement, bias + (compliance * force) * u)

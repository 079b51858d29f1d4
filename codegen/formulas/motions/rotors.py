"""Rotors and mirrors that take one object to another (thesis chapter 2), and how to compose them.

Objects are unit blades of one grade, rounds and flats alike; what is singular is measured by `margin`, in units of the
rounding error's scale. Where digits are lost, or no unique rotor exists, a first rotor (`unit_rotor`, or one of
`placement.turns`) leads x1 elsewhere, a second one from there to x2, and both are `composed`.
"""

from __future__ import annotations

from ...algebra.multivector import Mask, Multivector, absolute, select, sqrt
from ...algebra.product_terms import keep_scalar
from ...status import Status
from ...trace.outputs import Result, row
from ..objects.blades import Checked, principal_root, project_sum, written_size
from ..objects.conformal import normalise_point
from ..objects.euclidean import canonical_sign, euclidean_part
from ..products.outcome import NOISE, as_computed, epsilon, outcome, size
from ..products.products import absolute_product
from .motions import translator
from .placement import is_hyper, is_round


def gamma(x: Multivector) -> int:
    """x^2 of a unit object, for which x ~x = -1: +1 for point pairs, lines, circles, -1 for planes and spheres."""
    (k,) = x.grades
    return 1 if k * (k - 1) // 2 % 2 else -1


def plain_rotor(x1: Multivector, x2: Multivector) -> Multivector:
    """R = S (1 + gamma x2 x1)/sqrt(mu), with R x1 ~R = x2 and R = 1 for x1 = x2 (2.4, 2.6; printed S gives -R).

    With gamma x2 x1 = p0 + p2 + p4, K/2 = h = (1 + p0) + p4 commutes with everything here and 1 + gamma x2 x1 is
    h + p2; so R is (sqrt(h) + sqrt(h*) p2/[[h]])/sqrt(2), whose scalar part is not negative. Where p4 vanishes by
    the blades (planes, spheres) and h < 0, R takes x1 to -x2 (2.7). No statuses: NaN, or digits lost, where
    `margin` is small.
    """
    p0, p2, p4 = _parts(x1, x2)
    h0 = 1 + p0
    if not p4.terms:
        return _hyper_rotor(p0, p2, h0 < 0)
    if not (p4 * p4).terms:
        root = sqrt(h0 / 2)
        slope = 1 / (4 * root)
        return root + slope * p4 + ((2 * slope) * p2 - (slope / h0) * (p4 * p2).grade(2))
    norm = sqrt(h0 * h0 - (p4 * p4).grade(0))
    g4 = p4 / 2
    a, b = principal_root(h0 / 2, g4, norm / 2)
    quad, inverse = b * g4, 1 / norm
    return a + quad + ((a * inverse) * p2 - inverse * (quad * p2).grade(2))


def _parts(x1: Multivector, x2: Multivector) -> tuple[Multivector, Multivector, Multivector]:
    """Grades 0, 2 and 4 of gamma x2 x1."""
    product = gamma(x1) * (x2 * x1)
    return product.grade(0), product.grade(2), product.grade(4)


def _hyper_rotor(p0: Multivector, p2: Multivector, flipped: Mask) -> Multivector:
    """(1 + p0 + p2)/sqrt(2 + 2 p0), of p0 and p2 with the other sign where x1 is to go to -x2."""
    sign = select(flipped, p0.constant(-1), p0.constant(1))
    root = sqrt((1 + sign * p0) / 2)
    return root + (sign / (2 * root)) * p2


def margin(x1: Multivector, x2: Multivector) -> tuple[Multivector, Multivector]:
    """Distance of x1, x2 from pairs without a unique rotor, and the scale of its rounding errors.

    It is that of the eigenvalues of h (complex, or real where linked) from zero and from the negative axis.
    `plain_rotor` loses its inverse in digits, once or twice; near the rounding unit of the scale no rotor is left.
    """
    p0, _, p4 = _parts(x1, x2)
    h0, scale = 1 + p0, 1 + absolute_product(x2, x1, keep_scalar)
    square = (p4 * p4).grade(0)
    if not square.terms:
        return h0, scale
    root = sqrt(absolute(square))
    return select(h0 < 0, root, (h0 * h0 - square) / (h0 + root)), scale


def rotor_between(x1: Multivector, x2: Multivector) -> tuple[Multivector, Result, Result]:
    """`plain_rotor` and what tells its rounding errors: a row of `margin` and the product of the objects' sizes.

    SINGULAR: the margin is zero to rounding (the value is of no use). NOT_UNIQUE: K0 <= 0 to rounding for spheres,
    unless both are flat: x1 goes to -x2.
    """
    p0, p2, _ = _parts(x1, x2)
    room, scale = margin(x1, x2)
    lost = ~(room > NOISE * epsilon(x1) * scale)
    rotor, written = plain_rotor(x1, x2), size(x1) * size(x2)
    if not is_hyper(x1):
        return rotor, row([room, written], "quality"), outcome(x1, (lost, Status.SINGULAR))
    lost = lost & (p0 < 0)  # for p0 > 0 the rotor is less than half a turn, however far away
    flipped = lost & (is_round(x1) | is_round(x2))
    rotor = _hyper_rotor(p0, p2, flipped)
    code = outcome(x1, (flipped, Status.NOT_UNIQUE), (lost, Status.SINGULAR))
    return rotor, row([select(flipped, 1 - p0, room), written], "quality"), code


def flat_rotor(x1: Multivector, x2: Multivector) -> tuple[Multivector, Result]:
    """The rotor between lines or planes so near a half turn that `rotor_between` finds them singular.

    They have p0^2 - p2^2 = 1 and p2^2 <= 0, with no difference in it: where 1 + p0 is rounding, -p2^2/(1 - p0) still
    has the digits of p2. SINGULAR: p2 is rounding too, or the rotor's axis so far away that R x1 ~R would be.
    """
    p0, p2, p4 = _parts(x1, x2)
    square = -(p2 * p2).grade(0)
    noise = NOISE * epsilon(x1) * (1 + absolute_product(x2, x1, keep_scalar))
    h0 = square / (1 - p0)
    root = sqrt(h0 / 2)
    slope = 1 / (4 * root)
    rotor = root + (2 * slope) * p2
    if p4.terms:
        rotor = rotor + slope * p4 - (slope / h0) * (p4 * p2).grade(2)
    known = (square > noise * noise) & (NOISE * epsilon(x1) * size(rotor) * size(rotor) < 1)
    return rotor, outcome(x1, (~known, Status.SINGULAR))


def translation_between(x1: Multivector, x2: Multivector) -> Checked:
    """The translator from one point to another. SINGULAR: one is at infinity."""
    (a, first), (b, second) = normalise_point(x1), normalise_point(x2)
    code = select(first.value > 0, first.value, second.value)
    return translator(euclidean_part(b - a)), Result((code,), "status", "status")


def mirror_between(x1: Multivector, x2: Multivector) -> Checked:
    """S (x1 + x2)/sqrt(mu): the object M with M x1 M = gamma x2, the blade nearest the sum (2.4; 2.1 for gamma = 1).

    IMAGINARY, SINGULAR: as of `blades.project_sum`. Sigma comes from the computed sum, not from K = 2 + ..., which
    would lose twice as many digits near x2 = -x1.
    """
    return project_sum(as_computed(x1 + x2), written_size(x1, x2))


# -- one after the other -------------------------------------------------------------------------------------


def unit_rotor(r: Multivector) -> Multivector:
    """(r ~r)^(-1/2) r, the root on the principal branch: the unit rotor at r, for r ~r near 1.

    In this order: the grade 4 in r ~r does not commute with r in five dimensions.
    """
    square = r * ~r
    s0, s4 = square.grade(0), square.grade(4)
    if not s4.terms:
        return r / sqrt(s0)
    if not (s4 * s4).terms:
        return (1 - s4 / (2 * s0)) * r / sqrt(s0)
    norm = sqrt(s0 * s0 - (s4 * s4).grade(0))
    p, q = principal_root(s0, s4, norm)
    return (p - q * s4) * r / norm


def transform_object(r: Multivector, x: Multivector) -> Multivector:
    """r x ~r on the blades of objects: by its own blades alone r could be more than a rotor."""
    return (r >> x).grade(*x.grades)


def canonicalize_sign(r: Multivector) -> Multivector:
    """r or -r: <r>_0 >= 0, or the first coefficient that is not zero is positive."""
    return r * canonical_sign(r)

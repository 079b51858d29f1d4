"""Bodies that turn about a point, to 30 digits: power series in integers, with plain quaternions and vectors.

The body starts with its axes along the world's. ``STORED`` holds what `turned` gives for each of ``TOPS``; a test
recomputes them under BLADESMITH_FULL_BARS=1. Pendulums about an axis have elliptic functions instead.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import mpmath
import numpy as np

#: Numbers are integers over 2^BITS; so many terms; the largest turn of a step, in radians.
BITS, TERMS, TURN = 240, 56, 0.4


@dataclass(frozen=True)
class Top:
    """A body that is free, or pinned at the world's origin.

    Attributes
    ----------
    moments : floats
        About the centre of mass, along the body's axes.
    arm : floats
        From the pin to the centre of mass, at the start.
    spin : floats
        Along the body's axes.
    time : float
    gravity : floats
    mass : float
    """

    moments: tuple
    spin: tuple
    time: float
    arm: tuple = (0.0, 0.0, 0.0)
    gravity: tuple = (0.0, 0.0, 0.0)
    mass: float = 1.0

    @property
    def tensor(self):
        """About the pin, exactly."""
        m, r = Fraction(self.mass), [Fraction(x) for x in self.arm]
        square = sum(x * x for x in r)
        return [
            [(Fraction(self.moments[i]) + m * square if i == j else 0) - m * r[i] * r[j] for j in range(3)]
            for i in range(3)
        ]


TOPS = {
    "cuboid": Top((1.0, 2.0, 2.5), (0.1, 2.0, 0.1), 30.0),
    "heavy top": Top((0.2, 0.2, 0.1), (0.5, 0.2, 30.0), 10.0, (0.0, 0.0, 0.5), (0.0, 3.0, -9.5), 1.5),
    "lopsided top": Top((0.3, 0.5, 0.6), (1.0, 2.0, 3.0), 5.0, (0.1, -0.2, 0.4), (1.0, 3.0, -9.0), 2.0),
    "spherical pendulum": Top((0.02, 0.03, 0.04), (2.0, 1.0, 0.0), 10.0, (0.0, 0.0, -0.7), (5.0, 0.0, -8.0), 0.5),
    "fast cone": Top((2e-3, 2e-3, 1e-3), (0.0, 3.0, 1e4), 0.1, (0.0, 0.0, 0.08), (0.0, 3.0, -9.5), 0.2),
    "fast body": Top((2e-3, 2.4e-3, 1e-3), (0.0, 3.0, 1e4), 0.1, (0.0, 0.0, 0.08), (0.0, 3.0, -9.5), 0.2),
    "needle": Top((1e-6, 1.0, 1.0000005), (3.0, 1.0, 0.5), 30.0),
    "needle on a pin": Top((1e-6, 1.0, 1.0000005), (3.0, 1.0, 0.5), 30.0, (0.5, 0.0, 0.0), (-1.0, 0.0, -9.0)),
}  # fmt: skip

#: Three rows of the turn, and the spin.
STORED = {
    "cuboid": """
        0.3981396158748304671395117 -0.6299567918223170539472096 -0.6668127823519704671032208
        -0.2046354134823663210697707 -0.7695855186331708125741841 0.6048656686066869741603299
        -0.8942086970164981635089852 -0.1043674755230162371766615 -0.43531395134202762537286
        -1.002279866596106788641898 -1.583714811297834509965487 0.8975811633424175735380134
    """,
    "heavy top": """
        0.9272568752137139480497927 -0.3134992601333261250242868 -0.2047264058805215205838819
        -0.07655715469224002950169049 0.3764813903920448422428163 -0.9232555251683583377158218
        0.3665156059901506433574016 0.8717683044159897893512439 0.3250943462771120038167417
        2.950512635155706748669314 1.041594877784769421442136 30.0
    """,
    "lopsided top": """
        0.8716489347214649607139764 0.3180148184414793742906982 0.3729540318196978892978908
        0.278849219701353672850165 -0.9475389726061781047619855 0.1562466257695655001961162
        0.4030772224659705406114264 -0.03219426414846857834396469 -0.9145995200551206961364827
        2.045380926088327313590035 6.988157350258479387309739 -0.9750309128229651523496403
    """,
    "spherical pendulum": """
        -0.08578446685812892083102564 -0.9956209744814716860514166 -0.03714701089497358906764285
        0.9518328216944378058581658 -0.09291372973155638857273094 0.2922008185693117824678337
        -0.2943727310588926608058584 -0.01029145276119946639150698 0.9556352762476868989187546
        -0.1702978404176145451137263 -2.09423728423431148436396 0.2637958705969976471469479
    """,
    "fast cone": """
        0.5622569661122825624560749 -0.8269623438881265189042843 -0.0006211676645757480719026766
        0.8269615984532573769867164 0.5622549864029249080045868 0.001960854069081393272973673
        -0.001272297860190145484963532 -0.001616185664675665752094491 0.9999978845987886650842973
        -2.224352757930577102466676 -2.027274456176248082286961 10000.0
    """,
    "fast body": """
        0.5622407648511786225833854 -0.8269729234694153778797018 -0.001051754729070251906388532
        0.8269734496995014576448252 0.5622409600436362503345976 0.000127833158288187528118672
        0.0004856250279769820051341763 -0.0009416462492262830879713654 0.9999994387351792511145957
        3.437438609401675329215928 0.2097856523988129630242557 9999.999710702874810703388
    """,
    "needle": """
        -0.5263412962557023283057287 0.5183539962396431798031337 -0.6739984973560838573197001
        0.3802576500334461513652369 -0.5654958245700322353694162 -0.7318596805296084327671263
        -0.7605057261105324408435764 -0.641501057657936609729524 0.1005357328358455099063671
        3.017827859609628075464463 -0.88624495871227625820579 -0.681593470176509397700302
    """,
    "needle on a pin": """
        0.3401159260812210501810571 0.8553080572021313346040006 -0.3908571146992581116991124
        -0.8160245105400810987708586 0.06187097778755235212326216 -0.5746964244759430162758595
        -0.4673597704378656191935828 0.514412392339772308767108 0.7189956436471209339046864
        3.142138414201496045292658 -1.265564305847399090470415 1.881818954928598723608782
    """,
}


def inverse(m):
    """Of a matrix of fractions (3, 3)."""
    ahead, behind = (1, 2, 0), (2, 0, 1)
    cofactors = [
        [m[a][c] * m[b][d] - m[a][d] * m[b][c] for c, d in zip(ahead, behind, strict=True)]
        for a, b in zip(ahead, behind, strict=True)
    ]
    determinant = sum(m[0][j] * cofactors[0][j] for j in range(3))
    return [[cofactors[j][i] / determinant for j in range(3)] for i in range(3)]


def fixed(x):
    return int(round(Fraction(x) * 2**BITS))


def convolved(a, b, k):
    """Term k of a product of series."""
    return sum(x * y for x, y in zip(a[: k + 1], reversed(b[: k + 1]), strict=True)) >> BITS


def crossed(a, b, k):
    return [convolved(a[i - 2], b[i - 1], k) - convolved(a[i - 1], b[i - 2], k) for i in range(3)]


def applied(matrix, x):
    return [sum(m * y for m, y in zip(row, x, strict=True)) >> BITS for row in matrix]


def turned(top, parts=1):
    """Turn (3, 3) and spin (3,) at the end, of mpf; `parts` times as many steps."""
    tensor = top.tensor
    j, back = ([[fixed(x) for x in row] for row in m] for m in (tensor, inverse(tensor)))
    largest = sum(x * x for x in top.spin) ** 0.5 + (sum(x * x for x in top.gravity) ** 0.5 * top.mass) ** 0.5 * 4
    steps = parts * (int(top.time * largest / TURN) + 1)
    h = Fraction(top.time) / steps
    pull = [fixed(Fraction(top.mass) * Fraction(x)) for x in top.arm]
    q = [fixed(x) for x in (1, 0, 0, 0)]
    w = [fixed(Fraction(x) * h) for x in top.spin]
    g = [fixed(Fraction(x) * h * h) for x in top.gravity]  # along the body's axes
    for _ in range(steps):
        q, w, g = step(j, back, pull, q, w, g)
    with mpmath.workdps(40):
        q, w = ([mpmath.mpf(x) / 2**BITS for x in y] for y in (q, w))
        return rotation(q), [x / (mpmath.mpf(h.numerator) / h.denominator) for x in w]


def step(j, back, pull, q, w, g):
    """Turn, spin and gravity along the body's axes after one step, which is the unit of time."""
    q, w, g = ([[x] for x in y] for y in (q, w, g))
    momentum = [[] for _ in range(3)]
    for k in range(TERMS):
        for own, x in zip(momentum, applied(j, [x[k] for x in w]), strict=True):
            own.append(x)
        turning = crossed(momentum, w, k)
        arm = [pull[i - 2] * g[i - 1][k] - pull[i - 1] * g[i - 2][k] >> BITS for i in range(3)]
        rate = applied(back, [a + b for a, b in zip(turning, arm, strict=True)])
        fall = crossed(g, w, k)
        parts = [[convolved(q[a], w[b], k) for b in range(3)] for a in range(4)]
        bend = [
            -parts[1][0] - parts[2][1] - parts[3][2],
            parts[0][0] + parts[2][2] - parts[3][1],
            parts[0][1] + parts[3][0] - parts[1][2],
            parts[0][2] + parts[1][1] - parts[2][0],
        ]
        for series, rates, share in ((q, bend, 2), (w, rate, 1), (g, fall, 1)):
            for own, x in zip(series, rates, strict=True):
                own.append(x // (share * (k + 1)))
    return ([sum(x) for x in y] for y in (q, w, g))


def rotation(q):
    a, x, y, z = q
    return [
        [a * a + x * x - y * y - z * z, 2 * (x * y - a * z), 2 * (x * z + a * y)],
        [2 * (x * y + a * z), a * a - x * x + y * y - z * z, 2 * (y * z - a * x)],
        [2 * (x * z - a * y), 2 * (y * z + a * x), a * a - x * x - y * y + z * z],
    ]


def told(top):
    """A line of ``STORED``: nine numbers of the turn, three of the spin, 25 digits each."""
    turn, spin = turned(top)
    return " ".join(mpmath.nstr(x, 25) for x in [*turn[0], *turn[1], *turn[2], *spin])


def stored(name):
    """Turn (3, 3) and spin (3,) of a top at its end."""
    numbers = np.array([float(x) for x in STORED[name].split()])
    return numbers[:9].reshape(3, 3), numbers[9:]


def pendulum(strength, angle, t):
    """Angle and rate at a time t of theta'' = -strength sin theta, let go at rest."""
    with mpmath.workdps(40):
        strength, angle, t = (mpmath.mpf(float(x)) for x in (strength, angle, t))
        k, rate = mpmath.sin(angle / 2), mpmath.sqrt(strength)
        u = mpmath.ellipk(k * k) - rate * t  # sin(theta/2) = k sn(u) falls from k
        sn, cn = (mpmath.ellipfun(name, u, m=k * k) for name in ("sn", "cn"))
        return float(2 * mpmath.asin(k * sn)), float(-2 * rate * k * cn)

"""Coefficients of integrators: explicit Runge-Kutta schemes with their error estimates and interpolants, compositions.

Prince and Dormand's scheme of order 8 with Hairer's two error estimates and interpolant of order 7: Hairer, Norsett,
Wanner, Solving Ordinary Differential Equations I, DOP853. Compositions: Blanes and Moan 2002 (S6, order 4); Yoshida
1990 (order 6, solution A).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Scheme:
    """An explicit Runge-Kutta scheme.

    Attributes
    ----------
    a, b, c : array
        (all stages, all stages), (stages,), (all stages,); stages beyond those of b are for the interpolant.
    errors : array (2, stages + 1)
        Two error estimates on the stages and the rates at the end; empty for none.
    dense : array (rows, all stages)
        The interpolant's terms beyond the cubic one.
    order : int
        That of a scheme with a fixed step; else one more than that of the error estimate: the step goes by its root.
    about : str
        For the docs.
    fractions : tuple of list
        a and b exactly; empty where they are not known as fractions.
    """

    a: Array
    b: Array
    c: Array
    errors: Array
    dense: Array
    order: int
    about: str = ""
    fractions: tuple[list[Any], ...] = ()

    @property
    def stages(self) -> int:
        """Stages of a step."""
        return len(self.b)

    @property
    def all_stages(self) -> int:
        """The same with those of the interpolant."""
        return len(self.c)

    @property
    def dense_rows(self) -> int:
        """Terms of the interpolant beyond the cubic one."""
        return len(self.dense)

    @property
    def kept_rows(self) -> int:
        """States that a simulation keeps: stages, the change and the start of the last step, and its interpolant."""
        return self.all_stages + 4 + self.dense_rows

    @property
    def numbers(self) -> Array:
        """All of it in a row, as algorithms read it."""
        return np.concatenate([x.ravel() for x in (self.a, self.c, self.b, self.errors, self.dense)])


def explicit(rows: Sequence[str], weights: str, order: int, about: str) -> Scheme:
    """A scheme with a fixed step from the rows of its matrix and its weights, as fractions."""
    b = [Fraction(x) for x in weights.split()]
    a = [[Fraction(x) for x in row.split()] for row in rows]
    matrix = np.array([[float(x) for x in row] + [0.0] * (len(b) - len(row)) for row in a])
    c = np.array([float(sum(row, Fraction(0))) for row in a])
    none = np.zeros((2, len(b) + 1)), np.zeros((0, len(b)))
    return Scheme(matrix, np.array([float(x) for x in b]), c, *none, order, about, (a, b))


#: Schemes with a fixed step in the chart of the motor, by the names of their integrators: whatever asks for an
#: integrator by its name, gradients, files and the table of docs/motion/integrators.md follow from here.
FIXED_SCHEMES = {
    "rkmk4": explicit(
        ("", "1/2", "0 1/2", "0 0 1"), "1/6 1/3 1/3 1/6", 4,
        "the classical steps in the chart of the motor (Runge-Kutta-Munthe-Kaas)",
    ),
    "rkmk5": explicit(
        (
            "", "1/5", "3/40 9/40", "44/45 -56/15 32/9", "19372/6561 -25360/2187 64448/6561 -212/729",
            "9017/3168 -355/33 46732/5247 49/176 -5103/18656",
        ),
        "35/384 0 500/1113 125/192 -2187/6784 11/84", 5,
        "the steps of order 5 of Dormand and Prince (1980) there: six stages",
    ),
}  # fmt: skip
CLASSICAL = FIXED_SCHEMES["rkmk4"]


def scheme_table() -> str:
    """The table of docs/motion/integrators.md."""
    rows = ["| integrator | order | |", "| --- | --- | --- |"]
    rows += [f"| `{name}` | {scheme.order} | {scheme.about} |" for name, scheme in FIXED_SCHEMES.items()]
    return "".join(f"{row}\n" for row in rows)


#: Rows by number, columns by number: what is left out is zero.
_A = {
    1: {0: 0.05260015195876773},
    2: {0: 0.0197250569845379, 1: 0.0591751709536137},
    3: {0: 0.02958758547680685, 2: 0.08876275643042054},
    4: {0: 0.2413651341592667, 2: -0.8845494793282861, 3: 0.924834003261792},
    5: {0: 0.037037037037037035, 3: 0.17082860872947386, 4: 0.12546768756682242},
    6: {0: 0.037109375, 3: 0.17025221101954405, 4: 0.06021653898045596, 5: -0.017578125},
    7: {
        0: 0.03709200011850479,
        3: 0.17038392571223998,
        4: 0.10726203044637328,
        5: -0.015319437748624402,
        6: 0.008273789163814023,
    },
    8: {
        0: 0.6241109587160757,
        3: -3.3608926294469414,
        4: -0.868219346841726,
        5: 27.59209969944671,
        6: 20.154067550477894,
        7: -43.48988418106996,
    },
    9: {
        0: 0.47766253643826434,
        3: -2.4881146199716677,
        4: -0.590290826836843,
        5: 21.230051448181193,
        6: 15.279233632882423,
        7: -33.28821096898486,
        8: -0.020331201708508627,
    },
    10: {
        0: -0.9371424300859873,
        3: 5.186372428844064,
        4: 1.0914373489967295,
        5: -8.149787010746927,
        6: -18.52006565999696,
        7: 22.739487099350505,
        8: 2.4936055526796523,
        9: -3.0467644718982196,
    },
    11: {
        0: 2.273310147516538,
        3: -10.53449546673725,
        4: -2.0008720582248625,
        5: -17.9589318631188,
        6: 27.94888452941996,
        7: -2.8589982771350235,
        8: -8.87285693353063,
        9: 12.360567175794303,
        10: 0.6433927460157636,
    },
    12: {
        0: 0.054293734116568765,
        5: 4.450312892752409,
        6: 1.8915178993145003,
        7: -5.801203960010585,
        8: 0.3111643669578199,
        9: -0.1521609496625161,
        10: 0.20136540080403034,
        11: 0.04471061572777259,
    },
    13: {
        0: 0.056167502283047954,
        6: 0.25350021021662483,
        7: -0.2462390374708025,
        8: -0.12419142326381637,
        9: 0.15329179827876568,
        10: 0.00820105229563469,
        11: 0.007567897660545699,
        12: -0.008298,
    },
    14: {
        0: 0.03183464816350214,
        5: 0.028300909672366776,
        6: 0.053541988307438566,
        7: -0.05492374857139099,
        10: -0.00010834732869724932,
        11: 0.0003825710908356584,
        12: -0.00034046500868740456,
        13: 0.1413124436746325,
    },
    15: {
        0: -0.42889630158379194,
        5: -4.697621415361164,
        6: 7.683421196062599,
        7: 4.06898981839711,
        8: 0.3567271874552811,
        12: -0.0013990241651590145,
        13: 2.9475147891527724,
        14: -9.15095847217987,
    },
}
_C = {
    0: {
        1: 0.05260015195876773,
        2: 0.0789002279381516,
        3: 0.1183503419072274,
        4: 0.2816496580927726,
        5: 0.3333333333333333,
        6: 0.25,
        7: 0.3076923076923077,
        8: 0.6512820512820513,
        9: 0.6,
        10: 0.8571428571428571,
        11: 1.0,
        12: 1.0,
        13: 0.1,
        14: 0.2,
        15: 0.7777777777777778,
    },
}
_ERRORS = {
    0: {
        0: 0.01312004499419488,
        5: -1.2251564463762044,
        6: -0.4957589496572502,
        7: 1.6643771824549864,
        8: -0.35032884874997366,
        9: 0.3341791187130175,
        10: 0.08192320648511571,
        11: -0.022355307863886294,
    },
    1: {
        0: -0.18980075407240762,
        5: 4.450312892752409,
        6: 1.8915178993145003,
        7: -5.801203960010585,
        8: -0.4226823213237919,
        9: -0.1521609496625161,
        10: 0.20136540080403034,
        11: 0.02265179219836082,
    },
}
_DENSE = {
    0: {
        0: -8.428938276109013,
        5: 0.5667149535193777,
        6: -3.0689499459498917,
        7: 2.38466765651207,
        8: 2.117034582445028,
        9: -0.871391583777973,
        10: 2.2404374302607883,
        11: 0.6315787787694688,
        12: -0.08899033645133331,
        13: 18.148505520854727,
        14: -9.194632392478356,
        15: -4.436036387594894,
    },
    1: {
        0: 10.427508642579134,
        5: 242.28349177525817,
        6: 165.20045171727028,
        7: -374.5467547226902,
        8: -22.113666853125306,
        9: 7.733432668472264,
        10: -30.674084731089398,
        11: -9.332130526430229,
        12: 15.697238121770845,
        13: -31.139403219565178,
        14: -9.35292435884448,
        15: 35.81684148639408,
    },
    2: {
        0: 19.985053242002433,
        5: -387.0373087493518,
        6: -189.17813819516758,
        7: 527.8081592054236,
        8: -11.57390253995963,
        9: 6.8812326946963,
        10: -1.0006050966910838,
        11: 0.7777137798053443,
        12: -2.778205752353508,
        13: -60.19669523126412,
        14: 84.32040550667716,
        15: 11.99229113618279,
    },
    3: {
        0: -25.69393346270375,
        5: -154.18974869023643,
        6: -231.5293791760455,
        7: 357.6391179106141,
        8: 93.40532418362432,
        9: -37.45832313645163,
        10: 104.0996495089623,
        11: 29.8402934266605,
        12: -43.53345659001114,
        13: 96.32455395918828,
        14: -39.17726167561544,
        15: -149.72683625798564,
    },
}


def _full(rows: dict[int, dict[int, float]], shape: tuple[int, int]) -> Array:
    found = np.zeros(shape)
    for i, row in rows.items():
        for j, value in row.items():
            found[i, j] = value
    return found


_STAGES, _ALL = 12, 16
_TABLE = _full(_A, (_ALL, _ALL))
#: The weights of the step are the row of the stage at its end.
ORDER8 = Scheme(
    _TABLE,
    _TABLE[_STAGES, :_STAGES],
    _full(_C, (1, _ALL))[0],
    _full(_ERRORS, (2, _STAGES + 1)),
    _full(_DENSE, (4, _ALL)),
    8,
)


def _split(a: list[float], b: list[float]) -> Array:
    """Shares of a flow and its adjoint in turn, of a symmetric splitting a1 b1 a2 b2 .. a1 of two parts."""
    shares, left = [], 0.0
    for one, other in zip(a, b, strict=False):  # the last a1 is what is left
        shares += [one - left, other - (one - left)]
        left = shares[-1]
    return np.array(shares)


_BM_A = [0.0792036964311957, 0.353172906049774, -0.0420650803577195]
_BM_B = [0.209515106613362, -0.143851773179818]
_BM_A += [1 - 2 * sum(_BM_A), *_BM_A[::-1]]
_BM_B += [0.5 - sum(_BM_B)]
_YOSHIDA = [-1.17767998417887100695, 0.235573213359358133685, 0.784513610477557263819]

#: Shares of a step, of flows and their adjoints in turn, and the order.
COMPOSITIONS = {
    "strang": (np.array([0.5, 0.5]), 2),
    "blanes-moan": (_split(_BM_A, [*_BM_B, *_BM_B[::-1]]), 4),
    "yoshida6": (np.repeat([*_YOSHIDA[::-1], 1 - 2 * sum(_YOSHIDA), *_YOSHIDA], 2) / 2, 6),
}

"""Constants of the elementary functions in both precisions: printed by benchmarks/derive_elementary.py. Data only."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np


class Constants(NamedTuple):
    """What differs between the precisions. Polynomials have their lowest coefficient first, numbers are in parts."""

    sine: Any
    cosine: Any
    stumpff4: Any
    stumpff5: Any
    stumpff6: Any
    stumpff7: Any
    exponential: Any
    logarithm: Any
    arctangent: Any
    half_pi: Any
    ln2: Any
    ln2_pair: Any
    quarter_pi: Any
    per_half_pi: Any
    per_ln2: Any
    near: Any  # up to here products reduce an angle
    shifter: Any  # added, it leaves an integer in the lowest bits; taken off again, a number is rounded
    splitter: Any  # cuts a significand into halves
    largest: Any
    exp_range: Any  # beyond: zero, infinity
    sinh_largest: Any  # beyond: infinity
    forget: Any  # exp(-x) is nothing beside exp(x) from 2 to this power on
    below: Any  # the Stumpff functions are polynomials in w itself between this
    above: Any  # and this
    sixth: Any
    per_120: Any
    infinity: Any
    nan: Any
    zero: Any
    quarter: Any
    half: Any
    one: Any
    two: Any
    four: Any
    eight: Any


def float64(*values: str | float) -> tuple[Any, ...]:
    """Numbers, or their exact hexadecimal text."""
    return tuple(float.fromhex(v) if isinstance(v, str) else float(v) for v in values)


def float32(*values: str | float) -> tuple[Any, ...]:
    """The same in single precision."""
    return tuple(np.float32(v) for v in float64(*values))


# fmt: off
DOUBLE = Constants(
    sine=float64(
        "0x1.5555555555548p-3", "-0x1.111111110f731p-7", "0x1.a01a019be94afp-13", "-0x1.71de355556c26p-19",
        "0x1.ae5e4bae22a78p-26", "-0x1.5d8b651a58f85p-33",
    ),
    cosine=float64(
        "0x1.555555555554bp-5", "-0x1.6c16c16c15016p-10", "0x1.a01a019c8f4dbp-16", "-0x1.27e4f7f1b6a14p-22",
        "0x1.1ee9dbecb79d9p-29", "-0x1.8fa695c162261p-37",
    ),
    stumpff4=float64(
        "0x1.5555555555555p-5", "-0x1.6c16c16c16c18p-10", "0x1.a01a01a01a04bp-16", "-0x1.27e4fb778872bp-22",
        "0x1.1eed8effa9694p-29", "-0x1.93974ab77a0b2p-37", "0x1.ae7f26bb98d3ap-45", "-0x1.682cefdbfb008p-53",
        "0x1.e3f86fc34c998p-62", "-0x1.21050be12755cp-70",
    ),
    stumpff5=float64(
        "0x1.1111111111111p-7", "-0x1.a01a01a01a01ap-13", "0x1.71de3a556c748p-19", "-0x1.ae64567f5343ep-26",
        "0x1.6124613a94caep-33", "-0x1.ae7f3e9296891p-41", "0x1.952c66d90fe04p-49", "-0x1.2f4d4ce6e8219p-57",
        "0x1.70e12dc1f01c4p-66", "-0x1.9015bffb9429fp-75",
    ),
    stumpff6=float64(
        "0x1.6c16c16c16c17p-10", "-0x1.a01a01a01a017p-16", "0x1.27e4fb7789e7p-22", "-0x1.1eed8eff8e729p-29",
        "0x1.93974a8cb36aep-37", "-0x1.ae7f3e69b3d48p-45", "0x1.6827809201b73p-53", "-0x1.e5430507cea22p-62",
        "0x1.0d0b47420f91ep-70", "-0x1.f158b32758e04p-80",
    ),
    stumpff7=float64(
        "0x1.a01a01a01a01ap-13", "-0x1.71de3a556c734p-19", "0x1.ae64567f543f9p-26", "-0x1.6124613a86be5p-33",
        "0x1.ae7f3e73c2dcdp-41", "-0x1.952c7703cf5a2p-49", "0x1.2f49b07fab5d7p-57", "-0x1.71b8e86a47aeap-66",
        "0x1.764d63e887ecap-75", "-0x1.3f741b53511b8p-84",
    ),
    exponential=float64(
        "0x1.000000000000ap-1", "0x1.55555555554fap-3", "0x1.55555555508a1p-5", "0x1.1111111127c87p-7",
        "0x1.6c16c1842204bp-10", "0x1.a01a012a0de64p-13", "0x1.a0199a22544f1p-16", "0x1.71df2618d1aeap-19",
        "0x1.28ad5e73bfa76p-22", "0x1.ad7e074c994c5p-26",
    ),
    logarithm=float64(
        "0x1.5555555555592p-1", "0x1.999999997ff2ep-2", "0x1.24924941df2bdp-2", "0x1.c71c5216af335p-3",
        "0x1.74663c597373p-3", "0x1.39a1f9771520bp-3", "0x1.2f0304c405abdp-3",
    ),
    arctangent=float64(
        "0x1.5555555555518p-2", "-0x1.99999999914ddp-3", "0x1.249249216ffb5p-3", "-0x1.c71c709692423p-4",
        "0x1.745cf54f05e76p-4", "-0x1.3b11454a8ac64p-4", "0x1.10f3675c4f2e4p-4", "-0x1.dfed1097f67aep-5",
        "0x1.a3a77f5585f75p-5", "-0x1.571de4fe64645p-5", "0x1.c1fa230e68603p-6", "-0x1.4c27078eb4efbp-7",
    ),
    half_pi=float64("0x1.921fb5444p+0", "0x1.68c234c4cp-39", "0x1.98a2e03707345p-77", "0x0p+0"),
    ln2=float64("0x1.62e42fefap-1", "0x1.cf79abc9ep-40", "0x1.d9cc01f97b57ap-79", "0x0p+0"),
    ln2_pair=float64("0x1.62e42fefa38p-1", "0x1.ef35793c7673p-45"),
    quarter_pi=float64("0x1.921fb54442d18p-1", "0x1.1a62633145c07p-55"),
    per_half_pi=float64("0x1.45f306dc9c883p-1")[0],
    per_ln2=float64("0x1.71547652b82fep+0")[0],
    near=float64(102943.0)[0],
    shifter=float64("0x1.8p+52")[0],
    splitter=float64("0x1.0000002p+27")[0],
    largest=float64("0x1.fffffffffffffp+1023")[0],
    exp_range=float64(-746.0, 710.0),
    sinh_largest=float64(711.0)[0],
    forget=float64(64.0)[0],
    below=float64(-9.0)[0],
    above=float64(1.5)[0],
    sixth=float64(1.0 / 6.0)[0],
    per_120=float64(1.0 / 120.0)[0],
    infinity=float64(np.inf)[0],
    nan=float64(np.nan)[0],
    zero=float64(0.0)[0],
    quarter=float64(0.25)[0],
    half=float64(0.5)[0],
    one=float64(1.0)[0],
    two=float64(2.0)[0],
    four=float64(4.0)[0],
    eight=float64(8.0)[0],
)
SINGLE = Constants(
    sine=float32("0x1.555546p-3", "-0x1.110778p-7", "0x1.995402p-13"),
    cosine=float32("0x1.55554ap-5", "-0x1.6c0c28p-10", "0x1.99e806p-16"),
    stumpff4=float32(
        "0x1.555556p-5", "-0x1.6c16cp-10", "0x1.a019eep-16", "-0x1.27efp-22",
        "0x1.1d6d58p-29", "-0x1.bf5486p-37",
    ),
    stumpff5=float32(
        "0x1.11111p-7", "-0x1.a01a14p-13", "0x1.71e8bp-19", "-0x1.ac2de8p-26",
        "0x1.87d376p-33",
    ),
    stumpff6=float32(
        "0x1.6c16c2p-10", "-0x1.a01ap-16", "0x1.27e4cep-22", "-0x1.1eeebap-29",
        "0x1.9448bep-37", "-0x1.ac052ap-45",
    ),
    stumpff7=float32(
        "0x1.a01a02p-13", "-0x1.71ddf6p-19", "0x1.ae63e6p-26", "-0x1.61d5f6p-33",
        "0x1.af7b7cp-41",
    ),
    exponential=float32(
        "0x1.fffffcp-2", "0x1.555492p-3", "0x1.5558fp-5", "0x1.1239a8p-7",
        "0x1.6a24eep-10",
    ),
    logarithm=float32("0x1.55557ap-1", "0x1.995edap-2", "0x1.31dfep-2"),
    arctangent=float32(
        "0x1.555514p-2", "-0x1.997ba4p-3", "0x1.22513cp-3", "-0x1.a044aap-4",
        "0x1.a4cf6ep-5",
    ),
    half_pi=float32("0x1.921p+0", "0x1.f6ap-13", "0x1.11p-26", "0x1.68c234p-39"),
    ln2=float32("0x1.62ep-1", "0x1.0bfp-15", "0x1.7d1p-28", "0x1.9ef358p-41"),
    ln2_pair=float32("0x1.62e4p-1", "0x1.7f7d1cp-20"),
    quarter_pi=float32("0x1.921fbp-1", "0x1.5110b4p-23"),
    per_half_pi=float32("0x1.45f306p-1")[0],
    per_ln2=float32("0x1.715476p+0")[0],
    near=float32(3216.0)[0],
    shifter=float32("0x1.8p+23")[0],
    splitter=float32("0x1.002p+12")[0],
    largest=float32("0x1.fffffep+127")[0],
    exp_range=float32(-105.0, 89.0),
    sinh_largest=float32(90.0)[0],
    forget=float32(32.0)[0],
    below=float32(-9.0)[0],
    above=float32(1.5)[0],
    sixth=float32(1.0 / 6.0)[0],
    per_120=float32(1.0 / 120.0)[0],
    infinity=float32(np.inf)[0],
    nan=float32(np.nan)[0],
    zero=float32(0.0)[0],
    quarter=float32(0.25)[0],
    half=float32(0.5)[0],
    one=float32(1.0)[0],
    two=float32(2.0)[0],
    four=float32(4.0)[0],
    eight=float32(8.0)[0],
)

# pi/2 in two parts, and the first of them in halves.
HALF_PI = float64("0x1.921fb54442d18p+0", "0x1.1a62633145c07p-54")
HALF_PI_HALVES = float64("0x1.921fb5p+0", "0x1.110b46p-26")  # of the first part

# Places of 2/pi after the point, 32 in each word, after two words of zeros.
TWO_OVER_PI = np.array(
    [
        0x00000000, 0x00000000, 0xA2F9836E, 0x4E441529, 0xFC2757D1, 0xF534DDC0, 0xDB629599, 0x3C439041,
        0xFE5163AB, 0xDEBBC561, 0xB7246E3A, 0x424DD2E0, 0x06492EEA, 0x09D1921C, 0xFE1DEB1C, 0xB129A73E,
        0xE88235F5, 0x2EBB4484, 0xE99C7026, 0xB45F7E41, 0x3991D639, 0x835339F4, 0x9C845F8B, 0xBDF9283B,
        0x1FF897FF, 0xDE05980F, 0xEF2F118B, 0x5A0A6D1F, 0x6D367ECF, 0x27CB09B7, 0x4F463F66, 0x9E5FEA2D,
        0x7527BAC7, 0xEBE5F17B, 0x3D0739F7, 0x8A5292EA, 0x6BFB5FB1, 0x1F8D5D08, 0x56033046, 0xFC7B6BAB,
    ]
)
# fmt: on

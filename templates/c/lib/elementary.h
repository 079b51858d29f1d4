/* bladesmith: elementary functions of one instance, in the short names of instance.h. One text serves scalars,
 * vectors and CUDA, and gives the same bits on all of them (no contraction, no library call; but NaN has many).
 *
 *   SIN COS EXP LOG SINH COSH (x), ATAN2(y, x)    at most 2 ulp
 *   STUMPFF0 .. STUMPFF5 (w)                      c_k(w) = sum over n of (-w)^n / (2n + k)!; 4 ulp, c4 and c5 8 ulp
 *   FN(sincos)(x, &s, &c), FN(sinhcosh)(x, &s, &c), FN(stumpff)(w, &c0, &c1, &c2, &c3)
 *
 * Methods and measured errors: docs/elementary.md. Constants: benchmarks/derive_elementary.py. The only branch is
 * taken where some lane has a very large argument of sine or cosine (BS_NEAR): these are reduced one by one.
 */

/* Constants. Polynomials have their lowest coefficient first; a number in parts is the sum of its parts, and the
 * short first parts are exact when multiplied by the integers that meet them. */
#if BS_BITS == 64
#define BS_MANTISSA 52                       /* bits stored of a significand */
#define BS_BIAS 1023                         /* of an exponent */
#define BS_ONE (BS_INT)0x3ff0000000000000    /* bits of 1 */
#define BS_ROOT_HALF (BS_INT)0x3fe6a09e667f3bcd  /* bits of sqrt(1/2) */
#define BS_NEAR K(102943.0)                  /* 65536 half pi, less a little: up to here products reduce */
#define BS_SHIFTER K(0x1.8p+52)              /* added and taken off again, rounds to an integer */
#define BS_SPLITTER K(0x1.0000002p+27)       /* cuts a significand into halves */
#define BS_LARGEST K(0x1.fffffffffffffp+1023)
#define BS_SMALLEST K(0x1p-1022)             /* normal number */
#define BS_EXP_LARGEST K(710.0)              /* beyond: infinity, zero */
#define BS_EXP_SMALLEST K(-746.0)
#define BS_SINH_LARGEST K(711.0)             /* beyond: infinity */
#define BS_FORGET K(64.0)                    /* exp(-x) is nothing beside exp(x) from 2^64 on */
#define BS_SIN /* relative error 2^-57.9 */ \
    0x1.5555555555548p-3, -0x1.111111110f731p-7, 0x1.a01a019be94afp-13, -0x1.71de355556c26p-19, \
    0x1.ae5e4bae22a78p-26, -0x1.5d8b651a58f85p-33
#define BS_COS /* relative error 2^-63.9 */ \
    0x1.555555555554bp-5, -0x1.6c16c16c15016p-10, 0x1.a01a019c8f4dbp-16, -0x1.27e4f7f1b6a14p-22, \
    0x1.1ee9dbecb79d9p-29, -0x1.8fa695c162261p-37
#define BS_C4 /* relative error 2^-55.3 */ \
    0x1.5555555555555p-5, -0x1.6c16c16c16c18p-10, 0x1.a01a01a01a04bp-16, -0x1.27e4fb778872bp-22, \
    0x1.1eed8effa9694p-29, -0x1.93974ab77a0b2p-37, 0x1.ae7f26bb98d3ap-45, -0x1.682cefdbfb008p-53, \
    0x1.e3f86fc34c998p-62, -0x1.21050be12755cp-70
#define BS_C5 /* relative error 2^-56.7 */ \
    0x1.1111111111111p-7, -0x1.a01a01a01a01ap-13, 0x1.71de3a556c748p-19, -0x1.ae64567f5343ep-26, \
    0x1.6124613a94caep-33, -0x1.ae7f3e9296891p-41, 0x1.952c66d90fe04p-49, -0x1.2f4d4ce6e8219p-57, \
    0x1.70e12dc1f01c4p-66, -0x1.9015bffb9429fp-75
#define BS_EXP /* relative error 2^-56.3 */ \
    0x1.000000000000ap-1, 0x1.55555555554fap-3, 0x1.55555555508a1p-5, 0x1.1111111127c87p-7, \
    0x1.6c16c1842204bp-10, 0x1.a01a012a0de64p-13, 0x1.a0199a22544f1p-16, 0x1.71df2618d1aeap-19, \
    0x1.28ad5e73bfa76p-22, 0x1.ad7e074c994c5p-26
#define BS_LOG /* relative error 2^-59.5 */ \
    0x1.5555555555592p-1, 0x1.999999997ff2ep-2, 0x1.24924941df2bdp-2, 0x1.c71c5216af335p-3, \
    0x1.74663c597373p-3, 0x1.39a1f9771520bp-3, 0x1.2f0304c405abdp-3
#define BS_ATAN /* relative error 2^-57.8 */ \
    0x1.5555555555518p-2, -0x1.99999999914ddp-3, 0x1.249249216ffb5p-3, -0x1.c71c709692423p-4, \
    0x1.745cf54f05e76p-4, -0x1.3b11454a8ac64p-4, 0x1.10f3675c4f2e4p-4, -0x1.dfed1097f67aep-5, \
    0x1.a3a77f5585f75p-5, -0x1.571de4fe64645p-5, 0x1.c1fa230e68603p-6, -0x1.4c27078eb4efbp-7
#define BS_HALF_PI_1 K(0x1.921fb5444p+0)
#define BS_HALF_PI_2 K(0x1.68c234c4cp-39)
#define BS_HALF_PI_3 K(0x1.98a2e03707345p-77)
#define BS_LN2_1 K(0x1.62e42fefap-1)
#define BS_LN2_2 K(0x1.cf79abc9ep-40)
#define BS_LN2_3 K(0x1.d9cc01f97b57ap-79)
#define BS_LN2_PAIR_1 K(0x1.62e42fefa38p-1)
#define BS_LN2_PAIR_2 K(0x1.ef35793c7673p-45)
#define BS_QUARTER_PI_1 K(0x1.921fb54442d18p-1)
#define BS_QUARTER_PI_2 K(0x1.1a62633145c07p-55)
#define BS_PER_HALF_PI K(0x1.45f306dc9c883p-1)
#define BS_PER_LN2 K(0x1.71547652b82fep+0)
#define BS_HALF_PI_4 K(0) /* three parts are enough */
#define BS_LN2_4 K(0)
#else
#define BS_MANTISSA 23
#define BS_BIAS 127
#define BS_ONE (BS_INT)0x3f800000
#define BS_ROOT_HALF (BS_INT)0x3f3504f3
#define BS_NEAR K(3216.0)                    /* 2048 half pi, less a little */
#define BS_SHIFTER K(0x1.8p+23)
#define BS_SPLITTER K(0x1.002p+12)
#define BS_LARGEST K(0x1.fffffep+127)
#define BS_SMALLEST K(0x1p-126)
#define BS_EXP_LARGEST K(89.0)
#define BS_EXP_SMALLEST K(-105.0)
#define BS_SINH_LARGEST K(90.0)
#define BS_FORGET K(32.0)
#define BS_SIN /* relative error 2^-27.9 */ \
    0x1.555546p-3, -0x1.110778p-7, 0x1.995402p-13
#define BS_COS /* relative error 2^-33.0 */ \
    0x1.55554ap-5, -0x1.6c0c28p-10, 0x1.99e806p-16
#define BS_C4 /* relative error 2^-26.4 */ \
    0x1.555556p-5, -0x1.6c16cp-10, 0x1.a019eep-16, -0x1.27efp-22, \
    0x1.1d6d58p-29, -0x1.bf5486p-37
#define BS_C5 /* relative error 2^-26.3 */ \
    0x1.11111p-7, -0x1.a01a14p-13, 0x1.71e8bp-19, -0x1.ac2de8p-26, \
    0x1.87d376p-33
#define BS_EXP /* relative error 2^-27.9 */ \
    0x1.fffffcp-2, 0x1.555492p-3, 0x1.5558fp-5, 0x1.1239a8p-7, \
    0x1.6a24eep-10
#define BS_LOG /* relative error 2^-30.2 */ \
    0x1.55557ap-1, 0x1.995edap-2, 0x1.31dfep-2
#define BS_ATAN /* relative error 2^-27.5 */ \
    0x1.555514p-2, -0x1.997ba4p-3, 0x1.22513cp-3, -0x1.a044aap-4, \
    0x1.a4cf6ep-5
#define BS_HALF_PI_1 K(0x1.921p+0)
#define BS_HALF_PI_2 K(0x1.f6ap-13)
#define BS_HALF_PI_3 K(0x1.11p-26)
#define BS_HALF_PI_4 K(0x1.68c234p-39)
#define BS_LN2_1 K(0x1.62ep-1)
#define BS_LN2_2 K(0x1.0bfp-15)
#define BS_LN2_3 K(0x1.7d1p-28)
#define BS_LN2_4 K(0x1.9ef358p-41)
#define BS_LN2_PAIR_1 K(0x1.62e4p-1)
#define BS_LN2_PAIR_2 K(0x1.7f7d1cp-20)
#define BS_QUARTER_PI_1 K(0x1.921fbp-1)
#define BS_QUARTER_PI_2 K(0x1.5110b4p-23)
#define BS_PER_HALF_PI K(0x1.45f306p-1)
#define BS_PER_LN2 K(0x1.715476p+0)
#endif
#define BS_NEAR_BELOW K(-9.0)                /* Stumpff functions: between, polynomials in w itself */
#define BS_NEAR_ABOVE K(1.5)
#define BS_SMALL_SCALE (BS_MANTISSA + 2)     /* subnormal numbers are scaled by this power of two */
#define BS_INFINITY K(BS_HUGE_VALUE)
#define BS_SIXTH K(1.0 / 6.0)

#define SIN(x) FN(sin)(x)
#define COS(x) FN(cos)(x)
#define EXP(x) FN(exp)(x)
#define LOG(x) FN(log)(x)
#define SINH(x) FN(sinh)(x)
#define COSH(x) FN(cosh)(x)
#define ATAN2(y, x) FN(atan2)(y, x)
#define STUMPFF0(w) FN(stumpff0)(w)
#define STUMPFF1(w) FN(stumpff1)(w)
#define STUMPFF2(w) FN(stumpff2)(w)
#define STUMPFF3(w) FN(stumpff3)(w)
#define STUMPFF4(w) FN(stumpff4)(w)
#define STUMPFF5(w) FN(stumpff5)(w)

/* Even and odd terms by themselves: two short chains of operations instead of a long one. */
BS_INLINE V FN(horner)(V z, const S *terms, int count)
{
    V square = z * z;
    V last = SPLAT(terms[count - 1]), other = SPLAT(terms[count - 2]);
    BS_UNROLL
    for (int i = count - 3; i >= 0; i--) {
        V sum = last * square + terms[i];
        last = other, other = sum;
    }
    return other + last * z;
}

#define BS_POLYNOMIAL(name, ...)                                                            \
    BS_INLINE V FN(name)(V z)                                                               \
    {                                                                                       \
        const S terms[] = {__VA_ARGS__};                                                    \
        return FN(horner)(z, terms, (int)(sizeof terms / sizeof terms[0]));                 \
    }
BS_POLYNOMIAL(sine_terms, BS_SIN)     /* (r - sin r)/r^3 in z = r^2, |r| <= pi/4 */
BS_POLYNOMIAL(cosine_terms, BS_COS)   /* (cos r - 1 + z/2)/z^2 */
BS_POLYNOMIAL(stumpff4_terms, BS_C4)  /* c4(z), -9 <= z <= 3/2 */
BS_POLYNOMIAL(stumpff5_terms, BS_C5)  /* c5(z) */
BS_POLYNOMIAL(exp_terms, BS_EXP)      /* (exp r - 1 - r)/r^2, |r| <= ln2/2 */
BS_POLYNOMIAL(log_terms, BS_LOG)      /* (2 artanh s - 2 s)/s^3 in z = s^2, |s| <= 0.172 */
BS_POLYNOMIAL(atan_terms, BS_ATAN)    /* (q - arctan q)/q^3 in z = q^2, |q| <= 1/2 */
#undef BS_POLYNOMIAL

/* 2^n for the integer n that stands in the lowest bits of shifted = n + BS_SHIFTER. */
BS_INLINE V FN(power_of_two)(V shifted)
{
    return FROM_BITS((I)(((UI)BITS(shifted) << BS_MANTISSA) + (BS_UINT)BS_ONE));
}

BS_INLINE V FN(change_sign)(V v, I bits) /* where bit 1 is set */
{
    return FROM_BITS(BITS(v) ^ (I)(((UI)bits & 2) << (BS_BITS - 2)));
}

/* high - low = x + tail - n step to about twice the precision, for step in parts and a small tail. The first product
 * and difference are exact by the choice of the parts; what later ones lose is kept. Zero keeps its sign. */
BS_INLINE V FN(reduce_by)(V x, V n, const V *step, V tail, V *low)
{
    V rest = x - n * step[0];
    V product = n * step[1];
    V high = rest - product;
    V lost = (rest - high) - product;
#if BS_BITS == 32
    rest = high;
    product = n * step[2];
    high = rest - product;
    lost = lost + ((rest - high) - product);
    V correction = (n * step[3] - lost) - tail;
#else
    V correction = (n * step[2] - lost) - tail;
#endif
    V result = high - correction;
    *low = correction - (high - result);
    return result;
}

/* --- sin, cos --- */

typedef struct {
    V high, low; /* the reduced argument is high - low, |high| <= pi/4 and a little */
    I quadrant;  /* modulo 4, in the lowest bits */
} FN(angle);

/* Places of 2/pi after the point, 64 in each word, after a word of zeros. */
BS_TABLE uint64_t FN(two_over_pi)[] = {
    0x0000000000000000, 0xa2f9836e4e441529, 0xfc2757d1f534ddc0, 0xdb6295993c439041,
    0xfe5163abdebbc561, 0xb7246e3a424dd2e0, 0x06492eea09d1921c, 0xfe1deb1cb129a73e,
    0xe88235f52ebb4484, 0xe99c7026b45f7e41, 0x3991d639835339f4, 0x9c845f8bbdf9283b,
    0x1ff897ffde05980f, 0xef2f118b5a0a6d1f, 0x6d367ecf27cb09b7, 0x4f463f669e5fea2d,
    0x7527bac7ebe5f17b, 0x3d0739f78a5292ea, 0x6bfb5fb11f8d5d08, 0x56033046fc7b6bab,
};

BS_INLINE uint64_t FN(upper_product)(uint64_t a, uint64_t b)
{
    const uint64_t mask = 0xffffffff;
    uint64_t low = (a & mask) * (b & mask), cross = (a >> 32) * (b & mask) + (low >> 32);
    return (a >> 32) * (b >> 32) + (cross >> 32) + (((a & mask) * (b >> 32) + (cross & mask)) >> 32);
}

/* Reduction of one large number x = m 2^e, exact: m times those 192 places of 2/pi that matter modulo 4, to 126
 * places after the point, then times pi/2 in two parts. In float64 for both precisions. Returns the quadrant. */
BS_COLD int FN(reduce_far)(double x, double *high, double *low)
{
    const double half_pi = 0x1.921fb54442d18p+0, half_pi_rest = 0x1.1a62633145c07p-54;
    const double half_pi_1 = 0x1.921fb5p+0, half_pi_2 = 0x1.110b46p-26; /* the first part in halves */
    union { double x; uint64_t bits; } number;
    number.x = x < 0 ? -x : x;
    int exponent = (int)(number.bits >> 52);
    if (exponent == 2047) { /* infinity, NaN */
        *high = *low = x - x;
        return 0;
    }
    uint64_t m = (number.bits & 0xfffffffffffff) | 0x10000000000000;
    int place = exponent - 1075 - 2 + 64; /* of the first digit that matters; the word of zeros counts */
    const uint64_t *from = FN(two_over_pi) + place / 64;
    int shift = place % 64;
    uint64_t word[3];
    for (int i = 0; i < 3; i++)
        word[i] = (from[i] << shift) | ((from[i + 1] >> 1) >> (63 - shift));

    uint64_t carried = FN(upper_product)(m, word[2]);
    uint64_t fraction = m * word[1] + carried; /* lower 64 of the 126 places */
    uint64_t top = m * word[0] + FN(upper_product)(m, word[1]) + (fraction < carried);
    int quadrant = (int)(((top + ((uint64_t)1 << 61)) >> 62) & 3);
    top -= (uint64_t)quadrant << 62; /* now signed: the fraction lies in [-1/2, 1/2) */
    int negative = (int)(top >> 63);
    if (negative) {
        fraction = ~fraction + 1;
        top = ~top + (fraction == 0);
    }
    double a = (double)(int64_t)(top >> 31) * 0x1p-31;
    double b = (double)(int64_t)(top & 0x7fffffff) * 0x1p-62;
    double c = (double)(int64_t)(fraction >> 32) * 0x1p-94;
    c += (double)(int64_t)(fraction & 0xffffffff) * 0x1p-126;
    double sum = a + b, rest = ((a - sum) + b) + c;
    double f = sum + rest, f_rest = (sum - f) + rest;

    double cut = f * 0x1.0000002p+27, f_1 = cut - (cut - f), f_2 = f - f_1, product = f * half_pi;
    double error = ((f_1 * half_pi_1 - product) + f_1 * half_pi_2 + f_2 * half_pi_1) + f_2 * half_pi_2;
    error += f * half_pi_rest + f_rest * half_pi;
    *high = product + error;
    *low = (*high - product) - error;
    if (negative != (x < 0)) {
        *high = -*high;
        *low = -*low;
    }
    return x < 0 ? -quadrant : quadrant;
}

/* The same for the lanes of x that are set in far; the others keep what `near` holds. */
BS_PURE BS_COLD FN(angle) FN(reduce_far_lanes)(V x, M far, FN(angle) near)
{
    union { V v; S lane[W]; } number, high, low;
    union { I i; BS_INT lane[W]; } quadrant;
    number.v = x, high.v = near.high, low.v = near.low, quadrant.i = near.quadrant;
    for (int l = 0; l < W; l++) {
        if (BS_LANE(far, l)) {
            double most, rest;
            quadrant.lane[l] = FN(reduce_far)((double)number.lane[l], &most, &rest);
            high.lane[l] = (S)most;
            low.lane[l] = (S)(((double)high.lane[l] - most) + rest);
        }
    }
    near.high = high.v, near.low = low.v, near.quadrant = quadrant.i;
    return near;
}

BS_INLINE FN(angle) FN(reduce)(V x)
{
    const V half_pi[] = {
        SPLAT(BS_HALF_PI_1), SPLAT(BS_HALF_PI_2), SPLAT(BS_HALF_PI_3), SPLAT(BS_HALF_PI_4)};
    FN(angle) angle;
    V shifted = x * BS_PER_HALF_PI + BS_SHIFTER;
    angle.quadrant = BITS(shifted);
    angle.high = FN(reduce_by)(x, shifted - BS_SHIFTER, half_pi, SPLAT(0), &angle.low);
    M far = GT(ABS(x), BS_NEAR);
    if (ANY(far))
        angle = FN(reduce_far_lanes)(x, far, angle);
    return angle;
}

BS_INLINE void FN(sincos)(V x, V *sine, V *cosine)
{
    FN(angle) angle = FN(reduce)(x);
    V r = angle.high, low = angle.low, z = r * r, half = K(0.5) * z, most = K(1) - half;
    V s = r - ((r * z) * FN(sine_terms)(z) + low * most);
    V c = most + (((K(1) - most) - half) + ((z * z) * FN(cosine_terms)(z) + r * low));
    M odd = BIT0(angle.quadrant);
    *sine = FN(change_sign)(SELECT(odd, c, s), angle.quadrant);
    *cosine = FN(change_sign)(SELECT(odd, s, c), (I)((UI)angle.quadrant + 1));
}

BS_INLINE V FN(sin)(V x)
{
    V sine, cosine;
    FN(sincos)(x, &sine, &cosine);
    return sine;
}

BS_INLINE V FN(cos)(V x)
{
    V sine, cosine;
    FN(sincos)(x, &sine, &cosine);
    return cosine;
}

/* --- exp, log, sinh, cosh --- */

/* exp x = 2^n exp r, the power in two factors, so that results may be subnormal. */
BS_INLINE V FN(exp)(V x)
{
    x = SELECT(GT(x, BS_EXP_LARGEST), SPLAT(BS_EXP_LARGEST), x);
    x = SELECT(LT(x, BS_EXP_SMALLEST), SPLAT(BS_EXP_SMALLEST), x);
    V n = (x * BS_PER_LN2 + BS_SHIFTER) - BS_SHIFTER;
    V head = x - n * BS_LN2_PAIR_1, product = n * BS_LN2_PAIR_2;
    V r = head - product, low = (head - r) - product;
    V value = K(1) + (r + ((r * r) * FN(exp_terms)(r) + low));
    V shifted = n * K(0.5) + BS_SHIFTER;
    V other = (n - (shifted - BS_SHIFTER)) + BS_SHIFTER;
    return value * FN(power_of_two)(shifted) * FN(power_of_two)(other);
}

/* log x = k ln2 + log(1 + f), 1 + f in [sqrt(1/2), sqrt(2)). With s = f/(2 + f), log(1 + f) is 2 artanh s, written
 * f - (f^2/2 - s (f^2/2 + z R(z))), so that the largest term is exact. */
BS_INLINE V FN(log)(V x)
{
    const BS_INT mask = ((BS_INT)1 << BS_MANTISSA) - 1;
    const S digits = (S)((BS_INT)1 << BS_MANTISSA); /* an integer or'ed into its low bits is added to it */
    M tiny = LT(x, BS_SMALLEST);
    V scaled = SELECT(tiny, x * (S)((BS_INT)1 << BS_SMALL_SCALE), x);
    UI bits = (UI)BITS(scaled) + (BS_UINT)(BS_ONE - BS_ROOT_HALF);
    V number = FROM_BITS((I)(bits >> BS_MANTISSA) | BITS(SPLAT(digits)));
    V offset = SELECT(tiny, SPLAT(digits + (BS_BIAS + BS_SMALL_SCALE)), SPLAT(digits + BS_BIAS));
    V k = number - offset;
    V f = FROM_BITS(((I)bits & mask) + BS_ROOT_HALF) - K(1);
    V s = f / (f + K(2)), z = s * s, half = K(0.5) * f * f;
    V bent = s * (half + z * FN(log_terms)(z));
    V value = k * BS_LN2_PAIR_1 - ((half - (bent + k * BS_LN2_PAIR_2)) - f);
    value = SELECT(LE(x, BS_LARGEST), value, x); /* infinity, NaN */
    value = SELECT(EQ(x, K(0)), SPLAT(-BS_INFINITY), value);
    return SELECT(LT(x, K(0)), SPLAT(BS_NOT_A_NUMBER), value);
}

/* cosh x and sinh x for x = n ln2 + r not near zero, where cosh r = 1 + c and sinh r = r + s: half the sum and half
 * the difference of 2^n exp r and 2^-n exp(-r), over 16 on the way, so that they overflow only where they must. */
BS_INLINE void FN(from_powers)(V n, V r, V c, V s, V *cosh_x, V *sinh_x)
{
    V kept = SELECT(GT(n, BS_FORGET), SPLAT(BS_FORGET), n);
    V grown = (K(1) + (r + (c + s))) * FN(power_of_two)((n - K(4)) + BS_SHIFTER);
    V shrunk = (K(1) - (r - (c - s))) * FN(power_of_two)((K(-4) - kept) + BS_SHIFTER);
    *cosh_x = K(8) * (grown + shrunk);
    *sinh_x = K(8) * (grown - shrunk);
}

BS_INLINE void FN(sinhcosh)(V x, V *sinh_x, V *cosh_x)
{
    const V ln2[] = {SPLAT(BS_LN2_1), SPLAT(BS_LN2_2), SPLAT(BS_LN2_3), SPLAT(BS_LN2_4)};
    V size = ABS(x), low;
    size = SELECT(GT(size, BS_SINH_LARGEST), SPLAT(BS_SINH_LARGEST), size);
    V n = (size * BS_PER_LN2 + BS_SHIFTER) - BS_SHIFTER;
    M near = LT(size, K(1));
    n = SELECT(near, SPLAT(0), n);
    V r = FN(reduce_by)(size, n, ln2, SPLAT(0), &low);
    V z = r * r, minus = -z; /* cosh r = 1 + c, sinh r = r + s */
    V c = z * (K(0.5) + z * FN(stumpff4_terms)(minus)) - r * low;
    V s = r * (z * (BS_SIXTH + z * FN(stumpff5_terms)(minus))) - low * (K(1) + c);
    V far_cosh, far_sinh;
    FN(from_powers)(n, r, c, s, &far_cosh, &far_sinh);
    *cosh_x = SELECT(near, K(1) + c, far_cosh);
    *sinh_x = FROM_BITS(BITS(SELECT(near, r + s, far_sinh)) | (BITS(x) & BS_SIGN_BIT));
}

BS_INLINE V FN(sinh)(V x)
{
    V s, c;
    FN(sinhcosh)(x, &s, &c);
    return s;
}

BS_INLINE V FN(cosh)(V x)
{
    V s, c;
    FN(sinhcosh)(x, &s, &c);
    return c;
}

/* --- atan2 --- */

/* The angle of (x, y) is a count of eighths of a turn plus or minus arctan q, |q| <= 1/2, where q is small/big or,
 * where small > big/2, (small - big)/(small + big). One sum brings all parts together. */
BS_INLINE V FN(atan2)(V y, V x)
{
    V width = ABS(x), height = ABS(y);
    M swap = GT(height, width), left = LT(FROM_BITS((BITS(x) & BS_SIGN_BIT) | BS_ONE), K(0));
    V big = SELECT(swap, height, width), small = SELECT(swap, width, height);
    V scale = SELECT(GT(big, BS_LARGEST * K(0.25)), SPLAT(0.25), SPLAT(1)); /* their sum may overflow */
    M diagonal = OR(GT(small, K(0.5) * big), GT(small, BS_LARGEST));        /* the second: both infinite */
    big = big * scale, small = small * scale;
    V above = SELECT(diagonal, small - big, small), below = SELECT(diagonal, small + big, big);
    M plain = AND(GT(below, K(0)), LE(below, BS_LARGEST));
    V q = SELECT(plain, above / below, SPLAT(0)); /* 0/0 and infinities: the eighths say it all */
    M backward = swap ^ left;
    V eighths = SELECT(diagonal, SPLAT(1), SPLAT(0));
    eighths = SELECT(backward, -eighths, eighths) + SELECT(swap, SPLAT(2), SELECT(left, SPLAT(4), SPLAT(0)));
    V z = q * q, bend = (q * z) * FN(atan_terms)(z);
    q = SELECT(backward, -q, q), bend = SELECT(backward, -bend, bend);
    V angle = eighths * BS_QUARTER_PI_1 + (q + (eighths * BS_QUARTER_PI_2 - bend));
    angle = FROM_BITS(BITS(angle) | (BITS(y) & BS_SIGN_BIT));
    return SELECT(OR(NE(x, x), NE(y, y)), x + y, angle);
}

/* --- Stumpff functions --- */

/* With t = sqrt|w|: c0, c1 are cos t, sin t/t for w > 0 and cosh t, sinh t/t for w < 0. Both cases reduce t to r, by
 * pi/2 or by ln2, and need c0(z) = 1 - z c2(z) and r c1(z) = r - r z c3(z) at z = r^2 or -r^2: one pair of polynomials,
 * for c4 in c2 = 1/2 - z c4 and for c5 in c3 = 1/6 - z c5. Near zero they are taken at w itself. Elsewhere
 * c3 = (1 - c1)/w and c2 = (1 - c0)/w or, since this cancels near full turns, s^2/(w (1 + c0)) with s = sin t where
 * c0 > 0. The root is taken to twice the precision. The last two, found in this way, are not yet c4 and c5. */
BS_INLINE void FN(stumpff_six)(V w, V *c)
{
    const S lowest = -BS_SINH_LARGEST * BS_SINH_LARGEST;
    w = SELECT(LT(w, lowest), SPLAT(lowest), w);
    M hyperbolic = LT(w, K(0)), near = AND(GT(w, BS_NEAR_BELOW), LT(w, BS_NEAR_ABOVE));
    V size = ABS(w), root = SQRT(size);
    M far = GT(root, BS_NEAR); /* never where hyperbolic */

    V cut = root * BS_SPLITTER, first = cut - (cut - root), second = root - first, square = root * root;
    V error = ((first * first - square) + K(2) * first * second) + second * second;
    V relative_tail = ((size - square) - error) / (K(2) * size); /* the true root is root (1 + this) */
    V tail = SELECT(far, SPLAT(0), root * relative_tail);

    const V step[] = {
        SELECT(hyperbolic, SPLAT(BS_LN2_1), SPLAT(BS_HALF_PI_1)),
        SELECT(hyperbolic, SPLAT(BS_LN2_2), SPLAT(BS_HALF_PI_2)),
        SELECT(hyperbolic, SPLAT(BS_LN2_3), SPLAT(BS_HALF_PI_3)),
        SELECT(hyperbolic, SPLAT(BS_LN2_4), SPLAT(BS_HALF_PI_4))};
    V shifted = root * SELECT(hyperbolic, SPLAT(BS_PER_LN2), SPLAT(BS_PER_HALF_PI)) + BS_SHIFTER;
    V n = shifted - BS_SHIFTER;
    FN(angle) angle;
    angle.quadrant = BITS(shifted);
    angle.high = FN(reduce_by)(root, n, step, tail, &angle.low);
    if (ANY(far))
        angle = FN(reduce_far_lanes)(root, far, angle);

    V r = angle.high, low = angle.low, signed_r = SELECT(hyperbolic, -r, r);
    V z = SELECT(near, w, signed_r * r), bend = SELECT(near, SPLAT(0), signed_r * low);
    V near4 = FN(stumpff4_terms)(z), near2 = K(0.5) - z * near4;
    V near5 = FN(stumpff5_terms)(z), near3 = BS_SIXTH - z * near5, z3 = z * near3;
    V less = z * near2 - bend, cosine = K(1) - less;   /* cos r or cosh r */
    V bent = r * z3 + low * cosine, sine = r - bent;   /* sin r or sinh r */
    M odd = BIT0(angle.quadrant);
    V far0 = FN(change_sign)(SELECT(odd, sine, cosine), (I)((UI)angle.quadrant + 1));
    V far_sine = FN(change_sign)(SELECT(odd, cosine, sine), angle.quadrant);
    V cosh_root, sinh_root;
    FN(from_powers)(n, r, -less, -bent, &cosh_root, &sinh_root);
    far0 = SELECT(hyperbolic, cosh_root, far0);
    far_sine = SELECT(hyperbolic, sinh_root, far_sine);
    V far1 = far_sine / root;
    far1 = SELECT(LE(far1, BS_LARGEST), far1 - far1 * relative_tail, far1);
    M turned = AND(NOT(hyperbolic), GT(far0, K(0)));
    V far2 = SELECT(turned, far_sine * far_sine, K(1) - far0) / SELECT(turned, w * (K(1) + far0), w);
    V far3 = (K(1) - far1) / w;

    c[0] = SELECT(near, cosine, far0);
    c[1] = SELECT(near, K(1) - z3, far1);
    c[2] = SELECT(near, near2, far2);
    c[3] = SELECT(near, near3, far3);
    c[4] = SELECT(near, near4, (K(0.5) - far2) / w);
    c[5] = SELECT(near, near5, (BS_SIXTH - far3) / w);
}

BS_INLINE void FN(stumpff)(V w, V *c0, V *c1, V *c2, V *c3)
{
    V c[6];
    FN(stumpff_six)(w, c);
    *c0 = c[0], *c1 = c[1], *c2 = c[2], *c3 = c[3];
}

#define BS_STUMPFF(k)                                   \
    BS_INLINE V FN(stumpff##k)(V w)                     \
    {                                                   \
        V c[6];                                         \
        FN(stumpff_six)(w, c);                          \
        return c[k];                                    \
    }
BS_STUMPFF(0)
BS_STUMPFF(1)
BS_STUMPFF(2)
BS_STUMPFF(3)
#undef BS_STUMPFF

/* c4 and c5, which derivatives need, from a quarter of the argument: no term has the other sign. */
BS_INLINE V FN(stumpff4)(V w)
{
    V c[6];
    FN(stumpff_six)(K(0.25) * w, c);
    return K(0.125) * (c[3] * (K(1) + c[1]));
}

BS_INLINE V FN(stumpff5)(V w)
{
    V c[6];
    FN(stumpff_six)(K(0.25) * w, c);
    return K(0.0625) * ((c[4] + c[5]) + c[2] * c[3]);
}

#undef BS_ATAN
#undef BS_BIAS
#undef BS_C4
#undef BS_C5
#undef BS_COS
#undef BS_EXP
#undef BS_EXP_LARGEST
#undef BS_EXP_SMALLEST
#undef BS_FORGET
#undef BS_HALF_PI_1
#undef BS_HALF_PI_2
#undef BS_HALF_PI_3
#undef BS_HALF_PI_4
#undef BS_INFINITY
#undef BS_LARGEST
#undef BS_LN2_1
#undef BS_LN2_2
#undef BS_LN2_3
#undef BS_LN2_4
#undef BS_LN2_PAIR_1
#undef BS_LN2_PAIR_2
#undef BS_LOG
#undef BS_MANTISSA
#undef BS_NEAR
#undef BS_NEAR_ABOVE
#undef BS_NEAR_BELOW
#undef BS_ONE
#undef BS_PER_HALF_PI
#undef BS_PER_LN2
#undef BS_QUARTER_PI_1
#undef BS_QUARTER_PI_2
#undef BS_ROOT_HALF
#undef BS_SHIFTER
#undef BS_SIN
#undef BS_SINH_LARGEST
#undef BS_SIXTH
#undef BS_SMALLEST
#undef BS_SMALL_SCALE
#undef BS_SPLITTER

/* bladesmith: elementary functions of one instance, in the short names of instance.h. One text serves scalars,
 * vectors and CUDA, and gives the same bits on all of them (no contraction, no library call; but NaN has many).
 * Printed by `bladesmith generate` from codegen/elementary and templates/c/lib/elementary.h.j2. Do not edit.
 *
 *   SIN COS EXP LOG SINH COSH (x), ATAN2(y, x)    at most 2 ulp
 *   STUMPFF0 .. STUMPFF5 (w)                      c_k(w) = sum over n of (-w)^n / (2n + k)!; 4 ulp, c4 and c5 8 ulp
 *   FN(sincos)(x, &s, &c), FN(sinhcosh)(x, &s, &c), FN(stumpff)(w, &c0, &c1, &c2, &c3)
 *
 * Methods and measured errors: docs/algebra/elementary.md. The only branch is taken where some lane has a very large argument
 * of sine or cosine: these are reduced one by one.
 */
#if BS_BITS == 64
#define BS_MANTISSA 52 /* bits stored of a significand */
#define BS_BIAS 1023   /* of an exponent */
#define BS_ONE (BS_INT)0x3ff0000000000000       /* bits of 1 */
#define BS_ROOT_HALF (BS_INT)0x3fe6a09e667f3bcd /* bits of sqrt(1/2) */
#define BS_SMALLEST K(0x1p-1022)                /* normal number */
#define BS_SHIFTER K(6755399441055744.0)
#else
#define BS_MANTISSA 23
#define BS_BIAS 127
#define BS_ONE (BS_INT)0x3f800000
#define BS_ROOT_HALF (BS_INT)0x3f3504f3
#define BS_SMALLEST K(0x1p-126)
#define BS_SHIFTER K(12582912.0)
#endif
#define BS_SMALL_SCALE (BS_MANTISSA + 2) /* subnormal numbers are scaled by this power of two */

/* --- numbers and their bits: elementary/machine.py in C. A shifted integer n is the number n + BS_SHIFTER, in whose
 * lowest bits it stands. */

BS_INLINE V FN(power_of_two)(V shifted) /* 2^n */
{
    return FROM_BITS((I)(((UI)BITS(shifted) << BS_MANTISSA) + (BS_UINT)BS_ONE));
}

BS_INLINE M FN(is_odd)(V shifted)
{
    return BIT0(BITS(shifted));
}

BS_INLINE V FN(change_sign)(V v, V shifted) /* where n is 2 or 3 modulo 4 */
{
    return FROM_BITS(BITS(v) ^ (I)(((UI)BITS(shifted) & 2) << (BS_BITS - 2)));
}

BS_INLINE V FN(copy_sign)(V x, V y) /* x >= 0 with the sign of y */
{
    return FROM_BITS(BITS(x) | (BITS(y) & BS_SIGN_BIT));
}

BS_INLINE UI FN(significand_word)(V x)
{
    V scaled = SELECT(LT(x, BS_SMALLEST), x * (S)((BS_INT)1 << BS_SMALL_SCALE), x);
    return (UI)BITS(scaled) + (BS_UINT)(BS_ONE - BS_ROOT_HALF);
}

BS_INLINE V FN(exponent)(V x) /* the integer k for which x 2^-k lies between sqrt(1/2) and sqrt(2) */
{
    const S digits = (S)((BS_INT)1 << BS_MANTISSA); /* an integer or'ed into its low bits is added to it */
    V number = FROM_BITS((I)(FN(significand_word)(x) >> BS_MANTISSA) | BITS(SPLAT(digits)));
    V scale = SPLAT(digits + (BS_BIAS + BS_SMALL_SCALE));
    return number - SELECT(LT(x, BS_SMALLEST), scale, SPLAT(digits + BS_BIAS));
}

BS_INLINE V FN(significand)(V x) /* x 2^-k */
{
    return FROM_BITS(((I)FN(significand_word)(x) & (((BS_INT)1 << BS_MANTISSA) - 1)) + BS_ROOT_HALF);
}

/* --- very large angles, one by one */

/* Places of 2/pi after the point, 32 in each word, after two words of zeros. */
BS_TABLE int64_t FN(two_over_pi)[] = {
    0x00000000, 0x00000000, 0xa2f9836e, 0x4e441529, 0xfc2757d1, 0xf534ddc0, 0xdb629599, 0x3c439041,
    0xfe5163ab, 0xdebbc561, 0xb7246e3a, 0x424dd2e0, 0x06492eea, 0x09d1921c, 0xfe1deb1c, 0xb129a73e,
    0xe88235f5, 0x2ebb4484, 0xe99c7026, 0xb45f7e41, 0x3991d639, 0x835339f4, 0x9c845f8b, 0xbdf9283b,
    0x1ff897ff, 0xde05980f, 0xef2f118b, 0x5a0a6d1f, 0x6d367ecf, 0x27cb09b7, 0x4f463f66, 0x9e5fea2d,
    0x7527bac7, 0xebe5f17b, 0x3d0739f7, 0x8a5292ea, 0x6bfb5fb1, 0x1f8d5d08, 0x56033046, 0xfc7b6bab,
};

BS_INLINE int64_t FN(bits_of_double)(double x)
{
    union { double x; int64_t bits; } both;
    both.x = x;
    return both.bits;
}

/* (high, low): high - low = (f + f_rest) pi/2, in float64. */
BS_INLINE void FN(times_half_pi)(double f, double f_rest, double *result0_, double *result1_)
{
  const double cut = f * 134217729.0;
  const double f_1 = cut - (cut - f);
  const double f_2 = f - f_1;
  const double product = f * 1.5707963267948966;
  double error = f_1 * 1.5707963109016418 - product + f_1 * 1.5893254712295857e-08 + f_2 * 1.5707963109016418 + f_2 * 1.5893254712295857e-08;
  error = error + (f * 6.123233995736766e-17 + f_rest * 1.5707963267948966);
  const double high = product + error;
  *result0_ = high;
  *result1_ = high - product - error;
  return;
}

/* (high, low, quadrant) of one large number, in float64: exact, times those 192 places of 2/pi that matter. */
BS_INLINE void FN(reduce_far)(double x, const int64_t places[BS_LENGTH(40)], double *result0_, double *result1_,
    double *result2_)
{
  const double size = fabs(x);
  const int finite = size <= 1.7976931348623157e+308;
  const int64_t word = FN(bits_of_double)((finite & (size >= 1.0)) ? size : 100000.0);
  const int64_t m = ((word & 4503599627370495) | 4503599627370496);
  const int64_t upper = (m >> 27);
  const int64_t lower = (m & 134217727);
  const int64_t place = (word >> 52) - 1013;
  const int64_t first = (place >> 5);
  const int64_t shift = (place & 31);
  const int64_t back = 32 - shift;
  const int64_t t0 = (((ptrdiff_t)((uint64_t)(places[first]) << (shift)) | (places[first + 1] >> back)) & 4294967295);
  const int64_t t1 = (((ptrdiff_t)((uint64_t)(places[first + 1]) << (shift)) | (places[first + 2] >> back)) & 4294967295);
  const int64_t t2 = (((ptrdiff_t)((uint64_t)(places[first + 2]) << (shift)) | (places[first + 3] >> back)) & 4294967295);
  const int64_t t3 = (((ptrdiff_t)((uint64_t)(places[first + 3]) << (shift)) | (places[first + 4] >> back)) & 4294967295);
  const int64_t t4 = (((ptrdiff_t)((uint64_t)(places[first + 4]) << (shift)) | (places[first + 5] >> back)) & 4294967295);
  const int64_t t5 = (((ptrdiff_t)((uint64_t)(places[first + 5]) << (shift)) | (places[first + 6] >> back)) & 4294967295);
  const int64_t d5 = lower * t5 + (ptrdiff_t)((uint64_t)(((upper * t5) & 31)) << (27));
  const int64_t d4 = lower * t4 + (ptrdiff_t)((uint64_t)(((upper * t4) & 31)) << (27)) + ((upper * t5) >> 5) + (d5 >> 32);
  int64_t d3 = lower * t3 + (ptrdiff_t)((uint64_t)(((upper * t3) & 31)) << (27)) + ((upper * t4) >> 5) + (d4 >> 32);
  int64_t d2 = lower * t2 + (ptrdiff_t)((uint64_t)(((upper * t2) & 31)) << (27)) + ((upper * t3) >> 5) + (d3 >> 32);
  int64_t d1 = lower * t1 + (ptrdiff_t)((uint64_t)(((upper * t1) & 31)) << (27)) + ((upper * t2) >> 5) + (d2 >> 32);
  int64_t d0 = lower * t0 + (ptrdiff_t)((uint64_t)(((upper * t0) & 31)) << (27)) + ((upper * t1) >> 5) + (d1 >> 32);
  d0 = (d0 & 4294967295);
  d1 = (d1 & 4294967295);
  d2 = (d2 & 4294967295);
  d3 = (d3 & 4294967295);
  const int64_t quadrant = ((d0 + 536870912) >> 30);
  d0 = d0 - (ptrdiff_t)((uint64_t)(quadrant) << (30));
  const int64_t n3 = -d3;
  const int64_t n2 = (n3 >> 32) - d2;
  const int64_t n1 = (n2 >> 32) - d1;
  const int negative = d0 < 0;
  d0 = negative ? (n1 >> 32) - d0 : d0;
  d1 = negative ? (n1 & 4294967295) : d1;
  d2 = negative ? (n2 & 4294967295) : d2;
  d3 = negative ? (n3 & 4294967295) : d3;
  const double a = (double)(((ptrdiff_t)((uint64_t)(d0) << (1)) | (d1 >> 31))) * 4.656612873077393e-10;
  const double b = (double)((d1 & 2147483647)) * 2.168404344971009e-19;
  double rest = (double)(d2) * 5.048709793414476e-29 + (double)(d3) * 1.1754943508222875e-38;
  const double total = a + b;
  rest = a - total + b + rest;
  const double f = total + rest;
  double result;
  double result1;
  FN(times_half_pi)(f, total - f + rest, &result, &result1);
  const double high = result;
  const double low = result1;
  const int flip = negative != (x < 0.0);
  const double turns = (double)(quadrant);
  *result0_ = finite ? (flip ? -high : high) : x - x;
  *result1_ = finite ? (flip ? -low : low) : x - x;
  *result2_ = x < 0.0 ? -turns : turns;
  return;
}

typedef struct {
    V high, low, quadrant;
} FN(angle);

/* What was reduced, but for the lanes of x that are set in far: these are reduced anew. */
BS_PURE BS_COLD FN(angle) FN(reduce_far_lanes)(V x, M far, FN(angle) near)
{
    union { V v; S lane[W]; } number, high, low, quadrant;
    number.v = x, high.v = near.high, low.v = near.low, quadrant.v = near.quadrant;
    for (int l = 0; l < W; l++) {
        if (BS_LANE(far, l)) {
            double most, rest, turns;
            FN(reduce_far)((double)number.lane[l], FN(two_over_pi), &most, &rest, &turns);
            high.lane[l] = (S)most;
            low.lane[l] = (S)(((double)high.lane[l] - most) + rest);
            quadrant.lane[l] = (S)turns + BS_SHIFTER;
        }
    }
    near.high = high.v, near.low = low.v, near.quadrant = quadrant.v;
    return near;
}

BS_INLINE void FN(far_or_near)(V x, M far, V high, V low, V quadrant, V *new_high, V *new_low, V *new_quadrant)
{
    FN(angle) angle;
    angle.high = high, angle.low = low, angle.quadrant = quadrant;
    if (ANY(far))
        angle = FN(reduce_far_lanes)(x, far, angle);
    *new_high = angle.high, *new_low = angle.low, *new_quadrant = angle.quadrant;
}

/* --- the text of elementary/functions.py */

#if BS_BITS == 64
/* (high, low): high - low = x + tail - n step to about twice the precision, for a small tail and step in parts. */
BS_INLINE void FN(reduce_by)(V x, V n, V step0, V step1, V step2, V step3, V tail, V *result0_, V *result1_)
{
  (void)step3;
  const V rest = x - n * step0;
  const V product = n * step1;
  const V high = rest - product;
  const V lost = rest - high - product;
  const V correction = n * step2 - lost - tail;
  const V result = high - correction;
  *result0_ = result;
  *result1_ = correction - (high - result);
  return;
}

/* A polynomial: even and odd terms by themselves are two short chains of operations instead of a long one. */
BS_INLINE V FN(polynomial_sine)(V z)
{
  const V square = z * z;
  V last = SPLAT(K(-1.5895444060248838e-10));
  V other = SPLAT(K(2.505073453581755e-08));
  V before = last;
  last = other;
  other = before * square + K(-2.755731353926773e-06);
  before = last;
  last = other;
  other = before * square + K(0.00019841269829360328);
  before = last;
  last = other;
  other = before * square + K(-0.008333333333321842);
  before = last;
  last = other;
  other = before * square + K(0.1666666666666663);
  return other + last * z;
}

/* A polynomial: even and odd terms by themselves are two short chains of operations instead of a long one. */
BS_INLINE V FN(polynomial_cosine)(V z)
{
  const V square = z * z;
  V last = SPLAT(K(-1.1358756710993668e-11));
  V other = SPLAT(K(2.087570552497725e-09));
  V before = last;
  last = other;
  other = before * square + K(-2.755731421784867e-07);
  before = last;
  last = other;
  other = before * square + K(2.480158728900427e-05);
  before = last;
  last = other;
  other = before * square + K(-0.0013888888888873344);
  before = last;
  last = other;
  other = before * square + K(0.041666666666666595);
  return other + last * z;
}

/* (sine, cosine) of x, at most 1 ulp off. */
BS_INLINE void FN(sincos)(V x, V *result0_, V *result1_)
{
  V quadrant = x * K(0.6366197723675814) + K(6755399441055744.0);
  V result;
  V result1;
  FN(reduce_by)(x, quadrant - K(6755399441055744.0), SPLAT(K(1.5707963267923333)), SPLAT(K(2.5633441515839558e-12)),
      SPLAT(K(1.0562999066987428e-23)), SPLAT(K(0.0)), SPLAT(K(0.0)), &result, &result1);
  V r = result;
  V low = result1;
  V result2;
  V result3;
  V result4;
  FN(far_or_near)(x, ABS(x) > K(102943.0), r, low, quadrant, &result2, &result3, &result4);
  r = result2;
  low = result3;
  quadrant = result4;
  const V z = r * r;
  const V half = K(0.5) * z;
  const V most = K(1.0) - half;
  const V result5 = FN(polynomial_sine)(z);
  const V sine = r - (r * z * result5 + low * most);
  const V result6 = FN(polynomial_cosine)(z);
  const V cosine = most + (K(1.0) - most - half + (z * z * result6 + r * low));
  const M odd = FN(is_odd)(quadrant);
  *result0_ = FN(change_sign)(SELECT(odd, cosine, sine), quadrant);
  *result1_ = FN(change_sign)(SELECT(odd, sine, cosine), quadrant + K(1.0));
  return;
}

/* Sine. */
BS_INLINE V FN(sin)(V x)
{
  V result;
  V result1;
  FN(sincos)(x, &result, &result1);
  const V sine = result;
  return sine;
}

/* Cosine. */
BS_INLINE V FN(cos)(V x)
{
  V result;
  V result1;
  FN(sincos)(x, &result, &result1);
  const V cosine = result1;
  return cosine;
}

/* A polynomial: even and odd terms by themselves are two short chains of operations instead of a long one. */
BS_INLINE V FN(polynomial_exponential)(V z)
{
  const V square = z * z;
  V last = SPLAT(K(2.4999742097987848e-08));
  V other = SPLAT(K(2.763021946654924e-07));
  V before = last;
  last = other;
  other = before * square + K(2.755758725578459e-06);
  before = last;
  last = other;
  other = before * square + K(2.4801493176800205e-05);
  before = last;
  last = other;
  other = before * square + K(0.00019841269505759256);
  before = last;
  last = other;
  other = before * square + K(0.0013888888943558604);
  before = last;
  last = other;
  other = before * square + K(0.008333333333494742);
  before = last;
  last = other;
  other = before * square + K(0.04166666666653041);
  before = last;
  last = other;
  other = before * square + K(0.16666666666666413);
  before = last;
  last = other;
  other = before * square + K(0.5000000000000011);
  return other + last * z;
}

/* Exponential function, at most 1 ulp off: 2^n exp r, the power in two factors, for subnormal results. */
BS_INLINE V FN(exp)(V x)
{
  x = SELECT(x > K(710.0), SPLAT(K(710.0)), x);
  x = SELECT(x < K(-746.0), SPLAT(K(-746.0)), x);
  const V n = x * K(1.4426950408889634) + K(6755399441055744.0) - K(6755399441055744.0);
  const V head = x - n * K(0.6931471805598903);
  const V product = n * K(5.497923018708371e-14);
  const V r = head - product;
  const V low = head - r - product;
  const V result = FN(polynomial_exponential)(r);
  const V value = K(1.0) + (r + (r * r * result + low));
  const V first = n * K(0.5) + K(6755399441055744.0);
  return value * FN(power_of_two)(first) * FN(power_of_two)(n - (first - K(6755399441055744.0)) + K(6755399441055744.0));
}

/* A polynomial: even and odd terms by themselves are two short chains of operations instead of a long one. */
BS_INLINE V FN(polynomial_logarithm)(V z)
{
  const V square = z * z;
  V last = SPLAT(K(0.14795497630321633));
  V other = SPLAT(K(0.1531409730402092));
  V before = last;
  last = other;
  other = before * square + K(0.18183562419874866);
  before = last;
  last = other;
  other = before * square + K(0.22222198611952995);
  before = last;
  last = other;
  other = before * square + K(0.2857142874197896);
  before = last;
  last = other;
  other = before * square + K(0.3999999999941676);
  before = last;
  last = other;
  other = before * square + K(0.6666666666666734);
  return other + last * z;
}

/* Natural logarithm, at most 1 ulp off: -inf at zero, NaN below. */
BS_INLINE V FN(log)(V x)
{
  const V k = FN(exponent)(x);
  const V f = FN(significand)(x) - K(1.0);
  const V s = f / (f + K(2.0));
  const V z = s * s;
  const V half = K(0.5) * f * f;
  const V result = FN(polynomial_logarithm)(z);
  const V bent = s * (half + z * result);
  V value = k * K(0.6931471805598903) - (half - (bent + k * K(5.497923018708371e-14)) - f);
  value = SELECT(x <= K(1.7976931348623157e+308), value, x);
  value = SELECT(x == K(0.0), SPLAT(-K(BS_HUGE_VALUE)), value);
  return SELECT(x < K(0.0), SPLAT(K(BS_NOT_A_NUMBER)), value);
}

/* A polynomial: even and odd terms by themselves are two short chains of operations instead of a long one. */
BS_INLINE V FN(polynomial_stumpff4)(V z)
{
  const V square = z * z;
  V last = SPLAT(K(-9.562860113584614e-22));
  V other = SPLAT(K(4.0993892119294527e-19));
  V before = last;
  last = other;
  other = before * square + K(-1.5620123899296426e-16);
  before = last;
  last = other;
  other = before * square + K(4.779473314516066e-14);
  before = last;
  last = other;
  other = before * square + K(-1.1470745671330635e-11);
  before = last;
  last = other;
  other = before * square + K(2.0876756988340305e-09);
  before = last;
  last = other;
  other = before * square + K(-2.7557319223953103e-07);
  before = last;
  last = other;
  other = before * square + K(2.4801587301587468e-05);
  before = last;
  last = other;
  other = before * square + K(-0.0013888888888888892);
  before = last;
  last = other;
  other = before * square + K(0.041666666666666664);
  return other + last * z;
}

/* A polynomial: even and odd terms by themselves are two short chains of operations instead of a long one. */
BS_INLINE V FN(polynomial_stumpff5)(V z)
{
  const V square = z * z;
  V last = SPLAT(K(-4.136781535544396e-23));
  V other = SPLAT(K(1.9528323658975736e-20));
  V before = last;
  last = other;
  other = before * square + K(-8.22101595460829e-18);
  before = last;
  last = other;
  other = before * square + K(2.8114555429169845e-15);
  before = last;
  last = other;
  other = before * square + K(-7.647163765018825e-13);
  before = last;
  last = other;
  other = before * square + K(1.605904383696961e-10);
  before = last;
  last = other;
  other = before * square + K(-2.505210838542762e-08);
  before = last;
  last = other;
  other = before * square + K(2.7557319223985977e-06);
  before = last;
  last = other;
  other = before * square + K(-0.0001984126984126984);
  before = last;
  last = other;
  other = before * square + K(0.008333333333333333);
  return other + last * z;
}

/* (cosh, sinh) of n ln2 + r not near zero, where cosh r = 1 + a and sinh r = r + b. */
BS_INLINE void FN(from_powers)(V n, V r, V a, V b, V *result0_, V *result1_)
{
  const V kept = SELECT(n > K(64.0), SPLAT(K(64.0)), n);
  const V grown = (K(1.0) + (r + (a + b))) * FN(power_of_two)(n - K(4.0) + K(6755399441055744.0));
  const V shrunk = (K(1.0) - (r - (a - b))) * FN(power_of_two)(K(-4.0) - kept + K(6755399441055744.0));
  *result0_ = K(8.0) * (grown + shrunk);
  *result1_ = K(8.0) * (grown - shrunk);
  return;
}

/* (hyperbolic sine, hyperbolic cosine), at most 2 ulp off. */
BS_INLINE void FN(sinhcosh)(V x, V *result0_, V *result1_)
{
  V size = ABS(x);
  size = SELECT(size > K(711.0), SPLAT(K(711.0)), size);
  const M near = size < K(1.0);
  const V n = SELECT(near, SPLAT(K(0.0)), size * K(1.4426950408889634) + K(6755399441055744.0) - K(6755399441055744.0));
  V result;
  V result1;
  FN(reduce_by)(size, n, SPLAT(K(0.6931471805582987)), SPLAT(K(1.6465949582866463e-12)),
      SPLAT(K(3.061840736018652e-24)), SPLAT(K(0.0)), SPLAT(K(0.0)), &result, &result1);
  const V r = result;
  const V low = result1;
  const V z = r * r;
  const V result2 = FN(polynomial_stumpff4)(-z);
  const V a = z * (K(0.5) + z * result2) - r * low;
  const V result3 = FN(polynomial_stumpff5)(-z);
  const V b = r * (z * (K(0.16666666666666666) + z * result3)) - low * (K(1.0) + a);
  V result4;
  V result5;
  FN(from_powers)(n, r, a, b, &result4, &result5);
  const V far_cosh = result4;
  const V far_sinh = result5;
  *result0_ = FN(copy_sign)(SELECT(near, r + b, far_sinh), x);
  *result1_ = SELECT(near, K(1.0) + a, far_cosh);
  return;
}

/* Hyperbolic sine. */
BS_INLINE V FN(sinh)(V x)
{
  V result;
  V result1;
  FN(sinhcosh)(x, &result, &result1);
  const V sine = result;
  return sine;
}

/* Hyperbolic cosine. */
BS_INLINE V FN(cosh)(V x)
{
  V result;
  V result1;
  FN(sinhcosh)(x, &result, &result1);
  const V cosine = result1;
  return cosine;
}

/* A polynomial: even and odd terms by themselves are two short chains of operations instead of a long one. */
BS_INLINE V FN(polynomial_arctangent)(V z)
{
  const V square = z * z;
  V last = SPLAT(K(-0.010136488619003617));
  V other = SPLAT(K(0.027464422449730474));
  V before = last;
  last = other;
  other = before * square + K(-0.04188437199912846);
  before = last;
  last = other;
  other = before * square + K(0.051227329921117816);
  before = last;
  last = other;
  other = before * square + K(-0.05858472100199151);
  before = last;
  last = other;
  other = before * square + K(0.06663837790706456);
  before = last;
  last = other;
  other = before * square + K(-0.07692076746813964);
  before = last;
  last = other;
  other = before * square + K(0.0909089643831694);
  before = last;
  last = other;
  other = before * square + K(-0.11111110667947392);
  before = last;
  last = other;
  other = before * square + K(0.14285714276593145);
  before = last;
  last = other;
  other = before * square + K(-0.19999999999905685);
  before = last;
  last = other;
  other = before * square + K(0.33333333333332993);
  return other + last * z;
}

/* Angle of the point (x, y) in [-pi, pi], at most 2 ulp off. */
BS_INLINE V FN(atan2)(V y, V x)
{
  const V width = ABS(x);
  const V height = ABS(y);
  const M swap = height > width;
  const M left = FN(copy_sign)(SPLAT(K(1.0)), x) < K(0.0);
  V big = SELECT(swap, height, width);
  V small = SELECT(swap, width, height);
  const V scale = SELECT(big > K(4.4942328371557893e+307), SPLAT(K(0.25)), SPLAT(K(1.0)));
  const M diagonal = OR(small > K(0.5) * big, small > K(1.7976931348623157e+308));
  big = big * scale;
  small = small * scale;
  const V above = SELECT(diagonal, small - big, small);
  const V below = SELECT(diagonal, small + big, big);
  V q = SELECT(AND(below > K(0.0), below <= K(1.7976931348623157e+308)), above / below, SPLAT(K(0.0)));
  const M backward = (swap ^ left);
  V eighths = SELECT(diagonal, SPLAT(K(1.0)), SPLAT(K(0.0)));
  eighths = SELECT(backward, -eighths, eighths) + SELECT(swap, SPLAT(K(2.0)), SELECT(left, SPLAT(K(4.0)), SPLAT(K(0.0))));
  const V z = q * q;
  const V result = FN(polynomial_arctangent)(z);
  V bend = q * z * result;
  q = SELECT(backward, -q, q);
  bend = SELECT(backward, -bend, bend);
  const V angle = eighths * K(0.7853981633974483) + (q + (eighths * K(3.061616997868383e-17) - bend));
  return SELECT(OR(x != x, y != y), x + y, FN(copy_sign)(angle, y));
}

/* (root, rest): the square root of size is root (1 + rest), to about twice the precision. */
BS_INLINE void FN(root_in_two)(V size, V *result0_, V *result1_)
{
  const V root = SQRT(size);
  const V cut = root * K(134217729.0);
  const V first = cut - (cut - root);
  const V second = root - first;
  const V square = root * root;
  const V error = first * first - square + K(2.0) * first * second + second * second;
  *result0_ = root;
  *result1_ = (size - square - error) / (K(2.0) * size);
  return;
}

/* (c0, .., c5) of w, the last two not as good as they should be. */
BS_INLINE void FN(stumpff_six)(V w, V *result0_, V *result1_, V *result2_, V *result3_, V *result4_, V *result5_)
{
  w = SELECT(w < K(-505521.0), SPLAT(K(-505521.0)), w);
  const M hyperbolic = w < K(0.0);
  const M near = AND(w > K(-9.0), w < K(1.5));
  V result;
  V result1;
  FN(root_in_two)(ABS(w), &result, &result1);
  const V root = result;
  const V relative_tail = result1;
  const M far = root > K(102943.0);
  const V tail = SELECT(far, SPLAT(K(0.0)), root * relative_tail);
  const V step0 = SELECT(hyperbolic, SPLAT(K(0.6931471805582987)), SPLAT(K(1.5707963267923333)));
  const V step1 = SELECT(hyperbolic, SPLAT(K(1.6465949582866463e-12)), SPLAT(K(2.5633441515839558e-12)));
  const V step2 = SELECT(hyperbolic, SPLAT(K(3.061840736018652e-24)), SPLAT(K(1.0562999066987428e-23)));
  const V step3 = SELECT(hyperbolic, SPLAT(K(0.0)), SPLAT(K(0.0)));
  V quadrant = root * SELECT(hyperbolic, SPLAT(K(1.4426950408889634)), SPLAT(K(0.6366197723675814))) + K(6755399441055744.0);
  const V n = quadrant - K(6755399441055744.0);
  V result2;
  V result3;
  FN(reduce_by)(root, n, step0, step1, step2, step3, tail, &result2, &result3);
  V r = result2;
  V low = result3;
  V result4;
  V result5;
  V result6;
  FN(far_or_near)(root, far, r, low, quadrant, &result4, &result5, &result6);
  r = result4;
  low = result5;
  quadrant = result6;
  const V signed_r = SELECT(hyperbolic, -r, r);
  const V z = SELECT(near, w, signed_r * r);
  const V bend = SELECT(near, SPLAT(K(0.0)), signed_r * low);
  const V result7 = FN(polynomial_stumpff4)(z);
  const V result8 = FN(polynomial_stumpff5)(z);
  const V near4 = result7;
  const V near5 = result8;
  const V near2 = K(0.5) - z * near4;
  const V near3 = K(0.16666666666666666) - z * near5;
  const V z3 = z * near3;
  const V less = z * near2 - bend;
  const V cosine = K(1.0) - less;
  const V bent = r * z3 + low * cosine;
  const V sine = r - bent;
  const M odd = FN(is_odd)(quadrant);
  V result9;
  V result10;
  FN(from_powers)(n, r, -less, -bent, &result9, &result10);
  const V cosh_root = result9;
  const V sinh_root = result10;
  const V far0 = SELECT(hyperbolic, cosh_root, FN(change_sign)(SELECT(odd, sine, cosine), quadrant + K(1.0)));
  const V far_sine = SELECT(hyperbolic, sinh_root, FN(change_sign)(SELECT(odd, cosine, sine), quadrant));
  V far1 = far_sine / root;
  far1 = SELECT(far1 <= K(1.7976931348623157e+308), far1 - far1 * relative_tail, far1);
  const M turned = AND(w >= K(0.0), far0 > K(0.0));
  const V far2 = SELECT(turned, far_sine * far_sine, K(1.0) - far0) / SELECT(turned, w * (K(1.0) + far0), w);
  const V far3 = (K(1.0) - far1) / w;
  *result0_ = SELECT(near, cosine, far0);
  *result1_ = SELECT(near, K(1.0) - z3, far1);
  *result2_ = SELECT(near, near2, far2);
  *result3_ = SELECT(near, near3, far3);
  *result4_ = SELECT(near, near4, (K(0.5) - far2) / w);
  *result5_ = SELECT(near, near5, (K(0.16666666666666666) - far3) / w);
  return;
}

/* (c0, c1, c2, c3) of w, c_k(w) = sum over n of (-w)^n / (2n + k)!, at most 4 ulp off. */
BS_INLINE void FN(stumpff)(V w, V *result0_, V *result1_, V *result2_, V *result3_)
{
  V result;
  V result1;
  V result2;
  V result3;
  V result4;
  V result5;
  FN(stumpff_six)(w, &result, &result1, &result2, &result3, &result4, &result5);
  const V c0 = result;
  const V c1 = result1;
  const V c2 = result2;
  const V c3 = result3;
  *result0_ = c0;
  *result1_ = c1;
  *result2_ = c2;
  *result3_ = c3;
  return;
}

/* c0: cos sqrt(w), cosh sqrt(-w). */
BS_INLINE V FN(stumpff0)(V w)
{
  V result;
  V result1;
  V result2;
  V result3;
  V result4;
  V result5;
  FN(stumpff_six)(w, &result, &result1, &result2, &result3, &result4, &result5);
  const V c0 = result;
  return c0;
}

/* c1: sin sqrt(w) / sqrt(w), sinh sqrt(-w) / sqrt(-w). */
BS_INLINE V FN(stumpff1)(V w)
{
  V result;
  V result1;
  V result2;
  V result3;
  V result4;
  V result5;
  FN(stumpff_six)(w, &result, &result1, &result2, &result3, &result4, &result5);
  const V c1 = result1;
  return c1;
}

/* c2: (1 - c0(w)) / w. */
BS_INLINE V FN(stumpff2)(V w)
{
  V result;
  V result1;
  V result2;
  V result3;
  V result4;
  V result5;
  FN(stumpff_six)(w, &result, &result1, &result2, &result3, &result4, &result5);
  const V c2 = result2;
  return c2;
}

/* c3: (1 - c1(w)) / w. */
BS_INLINE V FN(stumpff3)(V w)
{
  V result;
  V result1;
  V result2;
  V result3;
  V result4;
  V result5;
  FN(stumpff_six)(w, &result, &result1, &result2, &result3, &result4, &result5);
  const V c3 = result3;
  return c3;
}

/* c4: (1/2 - c2(w)) / w, at most 8 ulp off: from a quarter of the argument, no term has the other sign. */
BS_INLINE V FN(stumpff4)(V w)
{
  V result;
  V result1;
  V result2;
  V result3;
  V result4;
  V result5;
  FN(stumpff_six)(K(0.25) * w, &result, &result1, &result2, &result3, &result4, &result5);
  const V c1 = result1;
  const V c3 = result3;
  return K(0.125) * (c3 * (K(1.0) + c1));
}

/* c5: (1/6 - c3(w)) / w, at most 8 ulp off. */
BS_INLINE V FN(stumpff5)(V w)
{
  V result;
  V result1;
  V result2;
  V result3;
  V result4;
  V result5;
  FN(stumpff_six)(K(0.25) * w, &result, &result1, &result2, &result3, &result4, &result5);
  const V c2 = result2;
  const V c3 = result3;
  const V c4 = result4;
  const V c5 = result5;
  return K(0.0625) * (c4 + c5 + c2 * c3);
}

/* A polynomial: even and odd terms by themselves are two short chains of operations instead of a long one. */
BS_INLINE V FN(polynomial_stumpff7)(V z)
{
  const V square = z * z;
  V last = SPLAT(K(-6.451312903203775e-26));
  V other = SPLAT(K(3.870195131672336e-23));
  V before = last;
  last = other;
  other = before * square + K(-1.9572935397697847e-20);
  before = last;
  last = other;
  other = before * square + K(8.220633630376327e-18);
  before = last;
  last = other;
  other = before * square + K(-2.811457254663018e-15);
  before = last;
  last = other;
  other = before * square + K(7.647163732379631e-13);
  before = last;
  last = other;
  other = before * square + K(-1.6059043836820859e-10);
  before = last;
  last = other;
  other = before * square + K(2.5052108385440943e-08);
  before = last;
  last = other;
  other = before * square + K(-2.7557319223985893e-06);
  before = last;
  last = other;
  other = before * square + K(0.0001984126984126984);
  return other + last * z;
}

/* c6: (1/24 - c4(w)) / w, at most 8 ulp off; c5 of the quarter by a polynomial that reaches farther. */
BS_INLINE V FN(stumpff6)(V w)
{
  const V q = K(0.25) * w;
  V result;
  V result1;
  V result2;
  V result3;
  V result4;
  V result5;
  FN(stumpff_six)(q, &result, &result1, &result2, &result3, &result4, &result5);
  const V c1 = result1;
  const V c3 = result3;
  V c5 = result5;
  const V result6 = FN(polynomial_stumpff7)(q);
  c5 = SELECT(ABS(q) < K(9.0), K(0.008333333333333333) - q * result6, c5);
  return K(0.03125) * (K(0.16666666666666666) * c3 + c5 * (K(1.0) + c1));
}

/* A polynomial: even and odd terms by themselves are two short chains of operations instead of a long one. */
BS_INLINE V FN(polynomial_stumpff6)(V z)
{
  const V square = z * z;
  V last = SPLAT(K(-1.6070131602031944e-24));
  V other = SPLAT(K(8.901921083869931e-22));
  V before = last;
  last = other;
  other = before * square + K(-4.1103272884014615e-19);
  before = last;
  last = other;
  other = before * square + K(1.561920322149305e-16);
  before = last;
  last = other;
  other = before * square + K(-4.779477326080967e-14);
  before = last;
  last = other;
  other = before * square + K(1.1470745598865471e-11);
  before = last;
  last = other;
  other = before * square + K(-2.0876756987883523e-09);
  before = last;
  last = other;
  other = before * square + K(2.755731922398464e-07);
  before = last;
  last = other;
  other = before * square + K(-2.480158730158729e-05);
  before = last;
  last = other;
  other = before * square + K(0.001388888888888889);
  return other + last * z;
}

/* c7: (1/120 - c5(w)) / w, at most 8 ulp off. */
BS_INLINE V FN(stumpff7)(V w)
{
  const V q = K(0.25) * w;
  V result;
  V result1;
  V result2;
  V result3;
  V result4;
  V result5;
  FN(stumpff_six)(q, &result, &result1, &result2, &result3, &result4, &result5);
  const V c2 = result2;
  V c4 = result4;
  V c5 = result5;
  const V result6 = FN(polynomial_stumpff6)(q);
  const V result7 = FN(polynomial_stumpff7)(q);
  const M near = ABS(q) < K(9.0);
  const V c6 = result6;
  const V c7 = result7;
  const V far = (K(0.041666666666666664) - c4 + (K(0.008333333333333333) - c5)) / SELECT(q < K(-505521.0), SPLAT(K(-505521.0)), q);
  c4 = SELECT(near, K(0.041666666666666664) - q * c6, c4);
  c5 = SELECT(near, K(0.008333333333333333) - q * c7, c5);
  return K(0.015625) * (SELECT(near, c6 + c7, far) + (K(0.16666666666666666) * c4 + c5 * c2));
}

#else
/* (high, low): high - low = x + tail - n step to about twice the precision, for a small tail and step in parts. */
BS_INLINE void FN(reduce_by)(V x, V n, V step0, V step1, V step2, V step3, V tail, V *result0_, V *result1_)
{
  V rest = x - n * step0;
  V product = n * step1;
  V high = rest - product;
  V lost = rest - high - product;
  rest = high;
  product = n * step2;
  high = rest - product;
  lost = lost + (rest - high - product);
  const V correction = n * step3 - lost - tail;
  const V result = high - correction;
  *result0_ = result;
  *result1_ = correction - (high - result);
  return;
}

/* A polynomial: even and odd terms by themselves are two short chains of operations instead of a long one. */
BS_INLINE V FN(polynomial_sine)(V z)
{
  const V square = z * z;
  V last = SPLAT(K(0.00019518287444952875));
  V other = SPLAT(K(-0.008332189172506332));
  const V before = last;
  last = other;
  other = before * square + K(0.16666655242443085);
  return other + last * z;
}

/* A polynomial: even and odd terms by themselves are two short chains of operations instead of a long one. */
BS_INLINE V FN(polynomial_cosine)(V z)
{
  const V square = z * z;
  V last = SPLAT(K(2.4432321879430674e-05));
  V other = SPLAT(K(-0.0013887309469282627));
  const V before = last;
  last = other;
  other = before * square + K(0.04166664555668831);
  return other + last * z;
}

/* (sine, cosine) of x, at most 1 ulp off. */
BS_INLINE void FN(sincos)(V x, V *result0_, V *result1_)
{
  V quadrant = x * K(0.6366197466850281) + K(12582912.0);
  V result;
  V result1;
  FN(reduce_by)(x, quadrant - K(12582912.0), SPLAT(K(1.570556640625)), SPLAT(K(0.0002396702766418457)),
      SPLAT(K(1.5890691429376602e-08)), SPLAT(K(2.5633440682570896e-12)), SPLAT(K(0.0)), &result, &result1);
  V r = result;
  V low = result1;
  V result2;
  V result3;
  V result4;
  FN(far_or_near)(x, ABS(x) > K(3216.0), r, low, quadrant, &result2, &result3, &result4);
  r = result2;
  low = result3;
  quadrant = result4;
  const V z = r * r;
  const V half = K(0.5) * z;
  const V most = K(1.0) - half;
  const V result5 = FN(polynomial_sine)(z);
  const V sine = r - (r * z * result5 + low * most);
  const V result6 = FN(polynomial_cosine)(z);
  const V cosine = most + (K(1.0) - most - half + (z * z * result6 + r * low));
  const M odd = FN(is_odd)(quadrant);
  *result0_ = FN(change_sign)(SELECT(odd, cosine, sine), quadrant);
  *result1_ = FN(change_sign)(SELECT(odd, sine, cosine), quadrant + K(1.0));
  return;
}

/* Sine. */
BS_INLINE V FN(sin)(V x)
{
  V result;
  V result1;
  FN(sincos)(x, &result, &result1);
  const V sine = result;
  return sine;
}

/* Cosine. */
BS_INLINE V FN(cos)(V x)
{
  V result;
  V result1;
  FN(sincos)(x, &result, &result1);
  const V cosine = result1;
  return cosine;
}

/* A polynomial: even and odd terms by themselves are two short chains of operations instead of a long one. */
BS_INLINE V FN(polynomial_exponential)(V z)
{
  const V square = z * z;
  V last = SPLAT(K(0.001381470705382526));
  V other = SPLAT(K(0.008368689566850662));
  V before = last;
  last = other;
  other = before * square + K(0.04166838526725769);
  before = last;
  last = other;
  other = before * square + K(0.1666652113199234);
  before = last;
  last = other;
  other = before * square + K(0.4999999403953552);
  return other + last * z;
}

/* Exponential function, at most 1 ulp off: 2^n exp r, the power in two factors, for subnormal results. */
BS_INLINE V FN(exp)(V x)
{
  x = SELECT(x > K(89.0), SPLAT(K(89.0)), x);
  x = SELECT(x < K(-105.0), SPLAT(K(-105.0)), x);
  const V n = x * K(1.4426950216293335) + K(12582912.0) - K(12582912.0);
  const V head = x - n * K(0.693145751953125);
  const V product = n * K(1.428606765330187e-06);
  const V r = head - product;
  const V low = head - r - product;
  const V result = FN(polynomial_exponential)(r);
  const V value = K(1.0) + (r + (r * r * result + low));
  const V first = n * K(0.5) + K(12582912.0);
  return value * FN(power_of_two)(first) * FN(power_of_two)(n - (first - K(12582912.0)) + K(12582912.0));
}

/* A polynomial: even and odd terms by themselves are two short chains of operations instead of a long one. */
BS_INLINE V FN(polynomial_logarithm)(V z)
{
  const V square = z * z;
  V last = SPLAT(K(0.2987055778503418));
  V other = SPLAT(K(0.399775892496109));
  const V before = last;
  last = other;
  other = before * square + K(0.6666677594184875);
  return other + last * z;
}

/* Natural logarithm, at most 1 ulp off: -inf at zero, NaN below. */
BS_INLINE V FN(log)(V x)
{
  const V k = FN(exponent)(x);
  const V f = FN(significand)(x) - K(1.0);
  const V s = f / (f + K(2.0));
  const V z = s * s;
  const V half = K(0.5) * f * f;
  const V result = FN(polynomial_logarithm)(z);
  const V bent = s * (half + z * result);
  V value = k * K(0.693145751953125) - (half - (bent + k * K(1.428606765330187e-06)) - f);
  value = SELECT(x <= K(3.4028234663852886e+38), value, x);
  value = SELECT(x == K(0.0), SPLAT(-K(BS_HUGE_VALUE)), value);
  return SELECT(x < K(0.0), SPLAT(K(BS_NOT_A_NUMBER)), value);
}

/* A polynomial: even and odd terms by themselves are two short chains of operations instead of a long one. */
BS_INLINE V FN(polynomial_stumpff4)(V z)
{
  const V square = z * z;
  V last = SPLAT(K(-1.2713888102033888e-11));
  V other = SPLAT(K(2.076755656332807e-09));
  V before = last;
  last = other;
  other = before * square + K(-2.756096364464611e-07);
  before = last;
  last = other;
  other = before * square + K(2.480156945239287e-05);
  before = last;
  last = other;
  other = before * square + K(-0.00138888880610466);
  before = last;
  last = other;
  other = before * square + K(0.0416666679084301);
  return other + last * z;
}

/* A polynomial: even and odd terms by themselves are two short chains of operations instead of a long one. */
BS_INLINE V FN(polynomial_stumpff5)(V z)
{
  const V square = z * z;
  V last = SPLAT(K(1.7818184427920158e-10));
  V other = SPLAT(K(-2.4923316743752366e-08));
  V before = last;
  last = other;
  other = before * square + K(2.756036337814294e-06);
  before = last;
  last = other;
  other = before * square + K(-0.0001984128321055323);
  before = last;
  last = other;
  other = before * square + K(0.00833333283662796);
  return other + last * z;
}

/* (cosh, sinh) of n ln2 + r not near zero, where cosh r = 1 + a and sinh r = r + b. */
BS_INLINE void FN(from_powers)(V n, V r, V a, V b, V *result0_, V *result1_)
{
  const V kept = SELECT(n > K(32.0), SPLAT(K(32.0)), n);
  const V grown = (K(1.0) + (r + (a + b))) * FN(power_of_two)(n - K(4.0) + K(12582912.0));
  const V shrunk = (K(1.0) - (r - (a - b))) * FN(power_of_two)(K(-4.0) - kept + K(12582912.0));
  *result0_ = K(8.0) * (grown + shrunk);
  *result1_ = K(8.0) * (grown - shrunk);
  return;
}

/* (hyperbolic sine, hyperbolic cosine), at most 2 ulp off. */
BS_INLINE void FN(sinhcosh)(V x, V *result0_, V *result1_)
{
  V size = ABS(x);
  size = SELECT(size > K(90.0), SPLAT(K(90.0)), size);
  const M near = size < K(1.0);
  const V n = SELECT(near, SPLAT(K(0.0)), size * K(1.4426950216293335) + K(12582912.0) - K(12582912.0));
  V result;
  V result1;
  FN(reduce_by)(size, n, SPLAT(K(0.693115234375)), SPLAT(K(3.194063901901245e-05)), SPLAT(K(5.5451891967095435e-09)),
      SPLAT(K(7.371002679751326e-13)), SPLAT(K(0.0)), &result, &result1);
  const V r = result;
  const V low = result1;
  const V z = r * r;
  const V result2 = FN(polynomial_stumpff4)(-z);
  const V a = z * (K(0.5) + z * result2) - r * low;
  const V result3 = FN(polynomial_stumpff5)(-z);
  const V b = r * (z * (K(0.1666666716337204) + z * result3)) - low * (K(1.0) + a);
  V result4;
  V result5;
  FN(from_powers)(n, r, a, b, &result4, &result5);
  const V far_cosh = result4;
  const V far_sinh = result5;
  *result0_ = FN(copy_sign)(SELECT(near, r + b, far_sinh), x);
  *result1_ = SELECT(near, K(1.0) + a, far_cosh);
  return;
}

/* Hyperbolic sine. */
BS_INLINE V FN(sinh)(V x)
{
  V result;
  V result1;
  FN(sinhcosh)(x, &result, &result1);
  const V sine = result;
  return sine;
}

/* Hyperbolic cosine. */
BS_INLINE V FN(cosh)(V x)
{
  V result;
  V result1;
  FN(sinhcosh)(x, &result, &result1);
  const V cosine = result1;
  return cosine;
}

/* A polynomial: even and odd terms by themselves are two short chains of operations instead of a long one. */
BS_INLINE V FN(polynomial_arctangent)(V z)
{
  const V square = z * z;
  V last = SPLAT(K(0.05136844143271446));
  V other = SPLAT(K(-0.10162798315286636));
  V before = last;
  last = other;
  other = before * square + K(0.14175650477409363);
  before = last;
  last = other;
  other = before * square + K(-0.19994285702705383);
  before = last;
  last = other;
  other = before * square + K(0.333332359790802);
  return other + last * z;
}

/* Angle of the point (x, y) in [-pi, pi], at most 2 ulp off. */
BS_INLINE V FN(atan2)(V y, V x)
{
  const V width = ABS(x);
  const V height = ABS(y);
  const M swap = height > width;
  const M left = FN(copy_sign)(SPLAT(K(1.0)), x) < K(0.0);
  V big = SELECT(swap, height, width);
  V small = SELECT(swap, width, height);
  const V scale = SELECT(big > K(8.5070586659632215e+37), SPLAT(K(0.25)), SPLAT(K(1.0)));
  const M diagonal = OR(small > K(0.5) * big, small > K(3.4028234663852886e+38));
  big = big * scale;
  small = small * scale;
  const V above = SELECT(diagonal, small - big, small);
  const V below = SELECT(diagonal, small + big, big);
  V q = SELECT(AND(below > K(0.0), below <= K(3.4028234663852886e+38)), above / below, SPLAT(K(0.0)));
  const M backward = (swap ^ left);
  V eighths = SELECT(diagonal, SPLAT(K(1.0)), SPLAT(K(0.0)));
  eighths = SELECT(backward, -eighths, eighths) + SELECT(swap, SPLAT(K(2.0)), SELECT(left, SPLAT(K(4.0)), SPLAT(K(0.0))));
  const V z = q * q;
  const V result = FN(polynomial_arctangent)(z);
  V bend = q * z * result;
  q = SELECT(backward, -q, q);
  bend = SELECT(backward, -bend, bend);
  const V angle = eighths * K(0.785398006439209) + (q + (eighths * K(1.5695823663008923e-07) - bend));
  return SELECT(OR(x != x, y != y), x + y, FN(copy_sign)(angle, y));
}

/* (root, rest): the square root of size is root (1 + rest), to about twice the precision. */
BS_INLINE void FN(root_in_two)(V size, V *result0_, V *result1_)
{
  const V root = SQRT(size);
  const V cut = root * K(4098.0);
  const V first = cut - (cut - root);
  const V second = root - first;
  const V square = root * root;
  const V error = first * first - square + K(2.0) * first * second + second * second;
  *result0_ = root;
  *result1_ = (size - square - error) / (K(2.0) * size);
  return;
}

/* (c0, .., c5) of w, the last two not as good as they should be. */
BS_INLINE void FN(stumpff_six)(V w, V *result0_, V *result1_, V *result2_, V *result3_, V *result4_, V *result5_)
{
  w = SELECT(w < K(-8100.0), SPLAT(K(-8100.0)), w);
  const M hyperbolic = w < K(0.0);
  const M near = AND(w > K(-9.0), w < K(1.5));
  V result;
  V result1;
  FN(root_in_two)(ABS(w), &result, &result1);
  const V root = result;
  const V relative_tail = result1;
  const M far = root > K(3216.0);
  const V tail = SELECT(far, SPLAT(K(0.0)), root * relative_tail);
  const V step0 = SELECT(hyperbolic, SPLAT(K(0.693115234375)), SPLAT(K(1.570556640625)));
  const V step1 = SELECT(hyperbolic, SPLAT(K(3.194063901901245e-05)), SPLAT(K(0.0002396702766418457)));
  const V step2 = SELECT(hyperbolic, SPLAT(K(5.5451891967095435e-09)), SPLAT(K(1.5890691429376602e-08)));
  const V step3 = SELECT(hyperbolic, SPLAT(K(7.371002679751326e-13)), SPLAT(K(2.5633440682570896e-12)));
  V quadrant = root * SELECT(hyperbolic, SPLAT(K(1.4426950216293335)), SPLAT(K(0.6366197466850281))) + K(12582912.0);
  const V n = quadrant - K(12582912.0);
  V result2;
  V result3;
  FN(reduce_by)(root, n, step0, step1, step2, step3, tail, &result2, &result3);
  V r = result2;
  V low = result3;
  V result4;
  V result5;
  V result6;
  FN(far_or_near)(root, far, r, low, quadrant, &result4, &result5, &result6);
  r = result4;
  low = result5;
  quadrant = result6;
  const V signed_r = SELECT(hyperbolic, -r, r);
  const V z = SELECT(near, w, signed_r * r);
  const V bend = SELECT(near, SPLAT(K(0.0)), signed_r * low);
  const V result7 = FN(polynomial_stumpff4)(z);
  const V result8 = FN(polynomial_stumpff5)(z);
  const V near4 = result7;
  const V near5 = result8;
  const V near2 = K(0.5) - z * near4;
  const V near3 = K(0.1666666716337204) - z * near5;
  const V z3 = z * near3;
  const V less = z * near2 - bend;
  const V cosine = K(1.0) - less;
  const V bent = r * z3 + low * cosine;
  const V sine = r - bent;
  const M odd = FN(is_odd)(quadrant);
  V result9;
  V result10;
  FN(from_powers)(n, r, -less, -bent, &result9, &result10);
  const V cosh_root = result9;
  const V sinh_root = result10;
  const V far0 = SELECT(hyperbolic, cosh_root, FN(change_sign)(SELECT(odd, sine, cosine), quadrant + K(1.0)));
  const V far_sine = SELECT(hyperbolic, sinh_root, FN(change_sign)(SELECT(odd, cosine, sine), quadrant));
  V far1 = far_sine / root;
  far1 = SELECT(far1 <= K(3.4028234663852886e+38), far1 - far1 * relative_tail, far1);
  const M turned = AND(w >= K(0.0), far0 > K(0.0));
  const V far2 = SELECT(turned, far_sine * far_sine, K(1.0) - far0) / SELECT(turned, w * (K(1.0) + far0), w);
  const V far3 = (K(1.0) - far1) / w;
  *result0_ = SELECT(near, cosine, far0);
  *result1_ = SELECT(near, K(1.0) - z3, far1);
  *result2_ = SELECT(near, near2, far2);
  *result3_ = SELECT(near, near3, far3);
  *result4_ = SELECT(near, near4, (K(0.5) - far2) / w);
  *result5_ = SELECT(near, near5, (K(0.1666666716337204) - far3) / w);
  return;
}

/* (c0, c1, c2, c3) of w, c_k(w) = sum over n of (-w)^n / (2n + k)!, at most 4 ulp off. */
BS_INLINE void FN(stumpff)(V w, V *result0_, V *result1_, V *result2_, V *result3_)
{
  V result;
  V result1;
  V result2;
  V result3;
  V result4;
  V result5;
  FN(stumpff_six)(w, &result, &result1, &result2, &result3, &result4, &result5);
  const V c0 = result;
  const V c1 = result1;
  const V c2 = result2;
  const V c3 = result3;
  *result0_ = c0;
  *result1_ = c1;
  *result2_ = c2;
  *result3_ = c3;
  return;
}

/* c0: cos sqrt(w), cosh sqrt(-w). */
BS_INLINE V FN(stumpff0)(V w)
{
  V result;
  V result1;
  V result2;
  V result3;
  V result4;
  V result5;
  FN(stumpff_six)(w, &result, &result1, &result2, &result3, &result4, &result5);
  const V c0 = result;
  return c0;
}

/* c1: sin sqrt(w) / sqrt(w), sinh sqrt(-w) / sqrt(-w). */
BS_INLINE V FN(stumpff1)(V w)
{
  V result;
  V result1;
  V result2;
  V result3;
  V result4;
  V result5;
  FN(stumpff_six)(w, &result, &result1, &result2, &result3, &result4, &result5);
  const V c1 = result1;
  return c1;
}

/* c2: (1 - c0(w)) / w. */
BS_INLINE V FN(stumpff2)(V w)
{
  V result;
  V result1;
  V result2;
  V result3;
  V result4;
  V result5;
  FN(stumpff_six)(w, &result, &result1, &result2, &result3, &result4, &result5);
  const V c2 = result2;
  return c2;
}

/* c3: (1 - c1(w)) / w. */
BS_INLINE V FN(stumpff3)(V w)
{
  V result;
  V result1;
  V result2;
  V result3;
  V result4;
  V result5;
  FN(stumpff_six)(w, &result, &result1, &result2, &result3, &result4, &result5);
  const V c3 = result3;
  return c3;
}

/* c4: (1/2 - c2(w)) / w, at most 8 ulp off: from a quarter of the argument, no term has the other sign. */
BS_INLINE V FN(stumpff4)(V w)
{
  V result;
  V result1;
  V result2;
  V result3;
  V result4;
  V result5;
  FN(stumpff_six)(K(0.25) * w, &result, &result1, &result2, &result3, &result4, &result5);
  const V c1 = result1;
  const V c3 = result3;
  return K(0.125) * (c3 * (K(1.0) + c1));
}

/* c5: (1/6 - c3(w)) / w, at most 8 ulp off. */
BS_INLINE V FN(stumpff5)(V w)
{
  V result;
  V result1;
  V result2;
  V result3;
  V result4;
  V result5;
  FN(stumpff_six)(K(0.25) * w, &result, &result1, &result2, &result3, &result4, &result5);
  const V c2 = result2;
  const V c3 = result3;
  const V c4 = result4;
  const V c5 = result5;
  return K(0.0625) * (c4 + c5 + c2 * c3);
}

/* A polynomial: even and odd terms by themselves are two short chains of operations instead of a long one. */
BS_INLINE V FN(polynomial_stumpff7)(V z)
{
  const V square = z * z;
  V last = SPLAT(K(7.664666427584232e-13));
  V other = SPLAT(K(-1.6090588583761445e-10));
  V before = last;
  last = other;
  other = before * square + K(2.5052008467696396e-08);
  before = last;
  last = other;
  other = before * square + K(-2.7557241537579102e-06);
  before = last;
  last = other;
  other = before * square + K(0.00019841270113829523);
  return other + last * z;
}

/* c6: (1/24 - c4(w)) / w, at most 8 ulp off; c5 of the quarter by a polynomial that reaches farther. */
BS_INLINE V FN(stumpff6)(V w)
{
  const V q = K(0.25) * w;
  V result;
  V result1;
  V result2;
  V result3;
  V result4;
  V result5;
  FN(stumpff_six)(q, &result, &result1, &result2, &result3, &result4, &result5);
  const V c1 = result1;
  const V c3 = result3;
  V c5 = result5;
  const V result6 = FN(polynomial_stumpff7)(q);
  c5 = SELECT(ABS(q) < K(9.0), K(0.008333333767950535) - q * result6, c5);
  return K(0.03125) * (K(0.1666666716337204) * c3 + c5 * (K(1.0) + c1));
}

/* A polynomial: even and odd terms by themselves are two short chains of operations instead of a long one. */
BS_INLINE V FN(polynomial_stumpff6)(V z)
{
  const V square = z * z;
  V last = SPLAT(K(-4.751978500906924e-14));
  V other = SPLAT(K(1.1490446615025629e-11));
  V before = last;
  last = other;
  other = before * square + K(-2.087708894649154e-09);
  before = last;
  last = other;
  other = before * square + K(2.755725461156544e-07);
  before = last;
  last = other;
  other = before * square + K(-2.48015858232975e-05);
  before = last;
  last = other;
  other = before * square + K(0.0013888889225199819);
  return other + last * z;
}

/* c7: (1/120 - c5(w)) / w, at most 8 ulp off. */
BS_INLINE V FN(stumpff7)(V w)
{
  const V q = K(0.25) * w;
  V result;
  V result1;
  V result2;
  V result3;
  V result4;
  V result5;
  FN(stumpff_six)(q, &result, &result1, &result2, &result3, &result4, &result5);
  const V c2 = result2;
  V c4 = result4;
  V c5 = result5;
  const V result6 = FN(polynomial_stumpff6)(q);
  const V result7 = FN(polynomial_stumpff7)(q);
  const M near = ABS(q) < K(9.0);
  const V c6 = result6;
  const V c7 = result7;
  const V far = (K(0.0416666679084301) - c4 + (K(0.008333333767950535) - c5)) / SELECT(q < K(-8100.0), SPLAT(K(-8100.0)), q);
  c4 = SELECT(near, K(0.0416666679084301) - q * c6, c4);
  c5 = SELECT(near, K(0.008333333767950535) - q * c7, c5);
  return K(0.015625) * (SELECT(near, c6 + c7, far) + (K(0.1666666716337204) * c4 + c5 * c2));
}

#endif
#define SIN(x) FN(sin)(x)
#define COS(x) FN(cos)(x)
#define EXP(x) FN(exp)(x)
#define LOG(x) FN(log)(x)
#define SINH(x) FN(sinh)(x)
#define COSH(x) FN(cosh)(x)
#define STUMPFF0(x) FN(stumpff0)(x)
#define STUMPFF1(x) FN(stumpff1)(x)
#define STUMPFF2(x) FN(stumpff2)(x)
#define STUMPFF3(x) FN(stumpff3)(x)
#define STUMPFF4(x) FN(stumpff4)(x)
#define STUMPFF5(x) FN(stumpff5)(x)
#define STUMPFF6(x) FN(stumpff6)(x)
#define STUMPFF7(x) FN(stumpff7)(x)
#define ATAN2(y, x) FN(atan2)(y, x)

#undef BS_BIAS
#undef BS_MANTISSA
#undef BS_ONE
#undef BS_ROOT_HALF
#undef BS_SHIFTER
#undef BS_SMALLEST
#undef BS_SMALL_SCALE

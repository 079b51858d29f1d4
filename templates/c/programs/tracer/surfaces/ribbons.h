/* Where a ray meets the carriers of a ribbon's point pairs: t in [0, 1], 0 at the first pair. Three methods with one
   signature; control flow only. No guard: one inclusion makes one instance, for one scalar type S and one degree. The
   including file defines RIBBON(name), the names of the instance, RIBBON_MEETS, RIBBON_DEGREE and RIBBON_PRINTED, and
   provides, made from formulas on rows of coefficients,
     void RIBBON(polynomial)(S *out, meets, norm, kappa)    Bernstein coefficients of p, of degree RIBBON_DEGREE
     S RIBBON(polynomial_bound)(meets, norm, kappa, a, b)   sum of the absolute values of its terms
     S RIBBON(condition)(meets, norm, kappa, a, b)          f = m B - w E, and what its error is relative to:
     S RIBBON(condition_bound)(meets, norm, kappa, a, b)
     S RIBBON(meet)(meets, norm, kappa, a, b)               f of the unit pair, for a unit ray
     void RIBBON(published_polynomial)(S *out, meets, norm, kappa)       the published polynomial by powers of t, of degree
                                                            RIBBON_PRINTED
     S RIBBON(closed_alpha)(meets)                          the root of B where it is linear
   meets: RIBBON_PAIRS coefficients of B, the rest of E.

   Results: the number of roots stored, rising, or
     BS_RIBBON_VANISHES  f is zero for all t: the ray lies in the plane of a flat ribbon, or in the surface;
     BS_RIBBON_INVALID   something is not finite.
   Ends and tangency are as roots.h has them: two roots are one where f between them is less than its rounding, for
   surfaces and rays of about unit size nearer than 5e-8 (1e-3 in single precision). Spans: four pairs (lo, hi) of t where the pairs are real. */

#ifndef BS_RIBBON_CONSTANTS
#define BS_RIBBON_CONSTANTS
enum { BS_RIBBON_VANISHES = -1, BS_RIBBON_INVALID = -2, BS_RIBBON_SPANS = 4 };
#define BS_RIBBON_FILTER 1e-6 /* the printed threshold on |f| */
/* Of what rounding may leave of a meet at the most, the share that is taken for likely where f touches zero, over
   BS_ROOTS_TOUCH. */
#define BS_RIBBON_NOISE (1.0 / 128)
/* Square root of the unit roundoff. */
#define BS_RIBBON_SQRT(T) ((T)(sizeof(T) == 4 ? 2.44140625e-4 : 1.0536712127723509e-8))
#endif

typedef struct {
    const S *meets, *norm, *kappa; /* what f is made of */
    const S *other, *other_kappa;  /* what p is made of: something else where E vanishes */
    const S *written;              /* absolute values of meets, and what rounding may have added to them */
} RIBBON(problem);

#define ROOTS(name) RIBBON(roots_##name)
#define ROOTS_DEGREE RIBBON_DEGREE
#define ROOTS_DATA RIBBON(problem)
#define ROOTS_CONDITION(d, a, b) RIBBON(condition)((d)->meets, (d)->norm, (d)->kappa, b, a)
#define ROOTS_BOUND(d, a, b) RIBBON(condition_bound)((d)->written, (d)->norm, (d)->kappa, b, a)
#define ROOTS_NOISE(d, a, b) RIBBON(polynomial_bound)((d)->other, (d)->norm, (d)->other_kappa, b, a)
#include "roots.h"

#define COMPANION(name) RIBBON(companion_##name)
#define BS_COMPANION_DEGREE RIBBON_PRINTED
#include "companion.h"

/* Largest absolute Bernstein coefficient of a polynomial given with binomials inside. */
BS_INLINE S RIBBON(size)(const S *scaled, int count)
{
    S most = 0, binomial = 1;
    BS_UNROLL
    for (int i = 0; i < count; i++) {
        const S size = BS_ABS1(scaled[i]) * (K(1) / binomial);
        most = size > most ? size : most;
        binomial = binomial * K(count - 1 - i) / K(i + 1);
    }
    return most;
}

/* Replace a polynomial by zeros if rounding is all there is of it; its size, or NaN if it is not finite. */
BS_INLINE S RIBBON(unless_noise)(S *scaled, int count, S noise)
{
    S sum = 0;
    const S size = RIBBON(size)(scaled, count);
    if (size > noise)
        return size;
    for (int i = 0; i < count; i++)
        sum += scaled[i], scaled[i] = 0;
    return sum - sum;
}

BS_INLINE int RIBBON(real)(const S *spans, S t)
{
    for (int i = 0; i < BS_RIBBON_SPANS; i++)
        if (t >= spans[2 * i] && t <= spans[2 * i + 1])
            return 1;
    return 0;
}

/* Two pairs on one circle: the carrier's meet is linear in t. */
BS_INLINE int RIBBON(closed)(S *roots, const S *meets, const S *spans)
{
    const S t = RIBBON(closed_alpha)(meets), margin = K(BS_ROOTS_MARGIN) * BS_ROOTS_UNIT(S);
    roots[0] = t < 0 ? K(0) : t > 1 ? K(1) : t;
    return t >= -margin && t <= K(1) + margin && RIBBON(real)(spans, roots[0]);
}

/* Coefficients of p with a small constant in place of E and nothing in place of K: those of S0 B. For rays and
   surfaces whose E vanishes, with which p would. */
BS_COLD void RIBBON(without_products)(S *other, const S *meets, S size)
{
    S binomial = 1;
    for (int i = 0; i < RIBBON_PAIRS; i++)
        other[i] = meets[i];
    for (int i = RIBBON_PAIRS, k = 0, degree = RIBBON_MEETS - RIBBON_PAIRS - 1; i < RIBBON_MEETS; i++, k++) {
        other[i] = BS_ROOTS_UNIT(S) * size * binomial;
        binomial = binomial * K(degree - k) / K(k + 1);
    }
}

/* Whether f is zero to rounding at an end of the curve, where it need not change its sign: so it is for rays along the
   first or the last carrier. noise: what rounding may leave of B and of E. */
BS_INLINE int RIBBON(ends_at_zero)(const S *meets, const S *noise, const S *norm, const S *kappa, S t)
{
    if (!BS_FREE) /* f is m B there */
        return BS_ABS1(meets[t > 0 ? RIBBON_PAIRS - 1 : 0]) <= noise[0];
    const S f = RIBBON(condition)(meets, norm, kappa, K(1) - t, t), m = K(2) * norm[t > 0 ? 2 * RIBBON_PAIRS - 2 : 0];
    return BS_ABS1(f) <= BS_ABS1(m) * noise[0] + noise[1];
}

/* Default: every root, no false one. noise: what rounding may leave of B and of E; sizes: of S0 and K. */
BS_INLINE int RIBBON(isolate)(S *roots, int room, S *meets, const S *noise, const S *norm, const S *kappa,
                              const S *sizes, const S *spans)
{
    S written[RIBBON_MEETS];
    RIBBON(problem) problem = {meets, norm, kappa, meets, kappa, written};
    S other[RIBBON_MEETS], nothing[RIBBON_KAPPA] = {0}, c[RIBBON_DEGREE + 1], part[RIBBON_DEGREE + 1];
    const S size_b = RIBBON(unless_noise)(meets, RIBBON_PAIRS, noise[0]);
    S size_e = RIBBON(unless_noise)(meets + RIBBON_PAIRS, RIBBON_MEETS - RIBBON_PAIRS, size_b > 0 ? K(0) : noise[1]);
    S size_k = sizes[1];
    if (size_b - size_b != 0 || size_e - size_e != 0)
        return BS_RIBBON_INVALID;
    if (size_e == 0) {
        if (size_b == 0)
            return BS_RIBBON_VANISHES;
        if (RIBBON_PAIRS == 2 && size_k == 0)
            return RIBBON(closed)(roots, meets, spans);
        RIBBON(without_products)(other, meets, size_b);
        problem.other = other, problem.other_kappa = nothing;
        size_e = BS_ROOTS_UNIT(S) * size_b, size_k = 0;
    }
    RIBBON(polynomial)(c, problem.other, norm, problem.other_kappa);
    const S terms = K(RIBBON_WEIGHT) * (size_e * size_e + size_k * size_b * size_b) + K(2) * sizes[0] * size_b * size_e;
    const S noise_p = K(BS_ROOTS_NOISE) * BS_ROOTS_UNIT(S) * terms;
    S sum = 0;
    int plus = 0, minus = 0;
    for (int i = 0; i <= RIBBON_DEGREE; i++) {
        sum += c[i];
        plus += c[i] > noise_p;
        minus += c[i] < -noise_p;
    }
    if (plus == RIBBON_DEGREE + 1 || minus == RIBBON_DEGREE + 1)
        return 0;
    if (sum - sum != 0)
        return BS_RIBBON_INVALID;
    for (int i = 0; i < RIBBON_MEETS; i++)
        written[i] = BS_ABS1(meets[i]) + K(BS_RIBBON_NOISE) / BS_ROOTS_UNIT(S) * noise[i >= RIBBON_PAIRS];
    RIBBON(roots_search) search = {&problem, roots, room, 0, 0};
    for (int i = 0; i < BS_RIBBON_SPANS; i++) {
        const S lo = spans[2 * i], hi = spans[2 * i + 1];
        if (!(lo <= hi))
            continue;
        for (int j = 0; j <= RIBBON_DEGREE; j++)
            part[j] = c[j];
        if (lo > 0)
            RIBBON(roots_cut)(part, lo, 1);
        if (hi < 1)
            RIBBON(roots_cut)(part, (hi - lo) / (K(1) - lo), 0);
        RIBBON(roots_isolate)(&search, part, noise_p, lo, hi);
    }
    return search.vanishes ? BS_RIBBON_VANISHES : search.count;
}

/* The printed method: all roots of the published polynomial, real ones in [0, 1] kept where |f| < 1e-6. */
BS_INLINE int RIBBON(companion)(S *roots, int room, const S *meets, const S *norm, const S *kappa, const S *spans)
{
    S powers[RIBBON_PRINTED + 1], re[RIBBON_PRINTED], im[RIBBON_PRINTED];
    RIBBON(published_polynomial)(powers, meets, norm, kappa);
    const int found = RIBBON(companion_roots)(re, im, powers, RIBBON_PRINTED);
    int count = 0;
    for (int i = 0; i < found; i++) {
        const S t = re[i];
        if (im[i] != 0 || !(t >= 0 && t <= 1) || !RIBBON(real)(spans, t))
            continue;
        const S f = RIBBON(meet)(meets, norm, kappa, K(1) - t, t);
        if (!(BS_ABS1(f) < K(BS_RIBBON_FILTER)) || count == room)
            continue;
        int place = count++;
        for (; place > 0 && roots[place - 1] > t; place--)
            roots[place] = roots[place - 1];
        roots[place] = t;
    }
    return count;
}

/* Root between from and from + 1, where the values have unlike signs, of the quadratic through (0, f0), (1, f1)
   and (2, f2); of the secant where the quadratic is not finite. */
BS_INLINE S RIBBON(quadratic)(S f0, S f1, S f2, int from)
{
    const S c2 = K(0.5) * (f0 + f2) - f1, c1 = f1 - f0 - c2, square = c1 * c1 - K(4) * c2 * f0;
    const S root = BS_SQRT1(square > 0 ? square : K(0)), q = K(-0.5) * (c1 < 0 ? c1 - root : c1 + root);
    const S low = f0 / q, high = q / c2, secant = from ? K(1) + f1 / (f1 - f2) : f0 / (f0 - f1);
    if (low >= from && low <= from + 1)
        return low;
    return high >= from && high <= from + 1 ? high : secant;
}

/* The sampled finder as printed: f at samples (three or more) evenly spaced from 0 to 1, and where it changes sign
   the root of the quadratic through these two and a neighbour. */
BS_INLINE int RIBBON(sampled)(S *roots, int room, const S *meets, const S *norm, const S *kappa, const S *spans,
                              int samples)
{
    const S step = K(1) / K(samples - 1);
    S f0 = 0, f1 = 0;
    int count = 0, run = 0;
    for (int i = 0; i < samples; i++) {
        const S t = i < samples - 1 ? K(i) * step : K(1), next = t + step;
        if (!RIBBON(real)(spans, t)) {
            run = 0;
            continue;
        }
        const S f2 = RIBBON(meet)(meets, norm, kappa, K(1) - t, t);
        if (run > 0 && (f1 < 0) != (f2 < 0) && count < room) {
            const int first = run == 1; /* no neighbour before: take the one behind */
            const S f3 = first ? RIBBON(meet)(meets, norm, kappa, K(1) - next, next) : K(0);
            const S x = first ? RIBBON(quadratic)(f1, f2, f3, 0) : RIBBON(quadratic)(f0, f1, f2, 1) - K(1);
            const S root = t + (x - K(1)) * step;
            roots[count] = count > 0 && root < roots[count - 1] ? roots[count - 1] : root; /* by a rounding */
            count++;
        }
        f0 = f1, f1 = f2, run++;
    }
    return count;
}

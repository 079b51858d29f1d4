/* Where a ray meets a surface evolved linearly between two circles: alpha in [0, 1], 1 at the first circle. Three
   methods with one signature; control flow only. The including file provides, made from formulas,
     void FN(evolved_octic)(S *out9, const S *ray9, const S *surface2)
         p_k of p = sum p_k a^k b^(8-k), the product of both branches of the condition over a^2 b^2
     S FN(evolved_octic_bound)(const S *ray9, const S *surface2, S a, S b)
         the sum of the absolute values of p's terms, which rises in both a and b
     S FN(evolved_condition)(const S *ray9, const S *surface2, S a, S b)
         the condition without denominators, 2 D t f = t (t u - 2 a b x) + a^2 b^2 e, with D no less than zero
     S FN(evolved_meet_square)(const S *ray9, const S *surface2, S a, S b)
         f itself, (C v L)^2 with the projected circle C; the printed methods need its size
     void FN(evolved_dodecic)(S *out13, const S *ray9, const S *surface2)
         the printed polynomial of degree 12 by powers of a, b = 1 - a
   ray9: u0 u1 u2, x0 x1 x2, e0 e1 e2 with u = u0 b^2 + u1 a b + u2 a^2; surface2: m0, kappa. All are of true size
   (nothing is lost: each term of p and f has its own power of the size of M4).

   Results: the number of roots stored, rising, at most max_roots (8 always suffice), or
     BS_EVOLVED_VANISHES  f is zero for all alpha: the ray meets every circle (it lies in the surface or in the
                          circles' common plane, or passes through a point shared by both circles);
     BS_EVOLVED_INVALID   something is not finite.
   Ends: 0 and 1 belong to the surface, with BS_ROOTS_MARGIN roundings by which a root there may be off. Tangency:
   two roots are two if f, where it is extreme between them, is more than its rounding error. If it is not, nobody
   knows whether the ray hits twice, touches or just misses: one root is reported, at the extremum. A ray in the plane
   of one circle touches in this sense: there the meet Y vanishes, and the ray may hit twice or not at all. Where the
   interpolant is imaginary (circles of one sphere, oppositely turned) nothing is found. */

#ifndef BS_EVOLVED_CONSTANTS
#define BS_EVOLVED_CONSTANTS
enum { BS_EVOLVED_VANISHES = -1, BS_EVOLVED_INVALID = -2 };
#define BS_EVOLVED_FILTER 1e-6 /* the printed threshold on |f| */
/* M4 of cospherical circles in a frame of their size was made of up to 21 roundings, relative to 1 and m0. */
#define BS_EVOLVED_COSPHERICAL 32
/* The interpolant is real to rounding only that many roundings inside the ends of an imaginary gap. */
#define BS_EVOLVED_HOLE 16
#endif

typedef struct {
    const S *ray, *surface;
    const S *octic; /* the ray of which p is made: another one where the circles are cospherical */
} FN(evolved_problem);

/* Sum of the absolute values of the condition's terms: itself, for the ray of which no term is negative. */
BS_INLINE S FN(evolved_bound)(const FN(evolved_problem) *d, S a, S b)
{
    S ray[9];
    for (int i = 0; i < 9; i++)
        ray[i] = (d->ray[i] < 0) == (i / 3 == 1) ? d->ray[i] : -d->ray[i];
    return FN(evolved_condition)(ray, d->surface, a, b);
}

#define ROOTS(name) FN(evolved_roots_##name)
#define ROOTS_DEGREE 8
#define ROOTS_DATA FN(evolved_problem)
#define ROOTS_CONDITION(d, a, b) FN(evolved_condition)((d)->ray, (d)->surface, a, b)
#define ROOTS_BOUND(d, a, b) FN(evolved_bound)(d, a, b)
#define ROOTS_NOISE(d, a, b) FN(evolved_octic_bound)((d)->octic, (d)->surface, a, b)
#include "companion.h"
#include "roots.h"

/* Largest absolute Bernstein coefficient of a quadratic q0 b^2 + q1 a b + q2 a^2. */
BS_INLINE S FN(evolved_size)(const S *q)
{
    const S q0 = BS_ABS1(q[0]), q1 = K(0.5) * BS_ABS1(q[1]), q2 = BS_ABS1(q[2]);
    const S ends = q0 > q2 ? q0 : q2;
    return ends > q1 ? ends : q1;
}

/* What rounding leaves of M4 where it should vanish. */
BS_INLINE S FN(evolved_rounding)(const S *surface2)
{
    return K(BS_EVOLVED_COSPHERICAL) * BS_ROOTS_UNIT(S) * (BS_ABS1(surface2[0]) > 1 ? BS_ABS1(surface2[0]) : K(1));
}

/* 1 if the interpolant is imaginary for gap[0] < alpha < gap[1], else 0 and an empty gap from 1 to 0. With
   kappa = k^2 >= 0, Sigma has the real eigenvalues a^2 + b^2 + a b (m0 -+ k). The smaller one is negative between
   two roots in b/a of product 1. (Of real circles only cospherical ones have m0 - k < -2, with k = 0.) */
BS_INLINE int FN(evolved_gap)(S *gap, const S *surface2)
{
    const S rounding = FN(evolved_rounding)(surface2), kappa = surface2[1];
    gap[0] = 1, gap[1] = 0;
    if (kappa < -rounding * rounding)
        return 0;
    const S q = surface2[0] - BS_SQRT1(kappa > 0 ? kappa : K(0)), above = q + K(2);
    if (above > rounding)
        return 0;
    /* The eigenvalue's slope at the ends is about root. It is zero where a circle meets its own reverse. */
    const S unit = BS_ROOTS_UNIT(S), root = BS_SQRT1(above < 0 ? above * (q - K(2)) : K(0));
    gap[0] = K(1) / (K(1) + K(0.5) * (root - q)) - K(BS_EVOLVED_HOLE) * unit / (root + BS_SQRT1(unit));
    gap[1] = K(1) - gap[0];
    return 1;
}

/* Cospherical circles, M4 = 0 to rounding: both branches are one, S0 u - a b x, and p vanishes. With a small
   constant in place of e, p is that branch times S0. Fills ray, octic and surface, and returns 1 if so. */
BS_INLINE int FN(evolved_cospherical)(S *ray, S *octic, S *surface, const S *ray9, const S *surface2)
{
    const S rounding = FN(evolved_rounding)(surface2), size_u = FN(evolved_size)(ray9), unit = BS_ROOTS_UNIT(S);
    const S size = size_u > 1 ? size_u : K(1);
    if (FN(evolved_size)(ray9 + 6) > rounding * rounding * size || BS_ABS1(surface2[1]) > rounding * rounding)
        return 0;
    const S keep = FN(evolved_size)(ray9 + 3) > rounding * size ? K(1) : K(0);
    for (int i = 0; i < 9; i++) {
        ray[i] = i < 3 ? ray9[i] : i < 6 ? keep * ray9[i] : K(0);
        octic[i] = i < 6 ? ray[i] : unit * unit * size_u * (i == 7 ? K(2) : K(1));
    }
    surface[0] = surface2[0], surface[1] = 0;
    return 1;
}

/* Default: every root, no false one. */
BS_INLINE int FN(evolved_isolate)(S *roots, int max_roots, const S *ray9, const S *surface2)
{
    /* One over the binomial coefficients of 8. */
    const S scale[9] = {K(1), K(1) / K(8), K(1) / K(28), K(1) / K(56), K(1) / K(70),
                        K(1) / K(56), K(1) / K(28), K(1) / K(8), K(1)};
    FN(evolved_problem) problem = {ray9, surface2, ray9};
    S ray[9], octic[9], surface[2], c[9], gap[2], part[9];
    if (FN(evolved_cospherical)(ray, octic, surface, ray9, surface2))
        problem.ray = ray, problem.octic = octic, problem.surface = surface;
    FN(evolved_octic)(c, problem.octic, problem.surface);
    const S size_u = FN(evolved_size)(problem.octic), size_x = FN(evolved_size)(problem.octic + 3);
    const S size_e = FN(evolved_size)(problem.octic + 6), size_k = BS_ABS1(problem.surface[1]);
    const S half_m = K(0.5) * BS_ABS1(surface2[0]), size_s = half_m > 1 ? half_m : K(1);
    const S last = K(0.5) * (size_k * size_u + size_e);
    const S first = (size_s * size_u + K(0.5) * size_x) * (size_s * size_e + K(0.5) * size_k * size_x);
    const S noise = K(BS_ROOTS_NOISE) * BS_ROOTS_UNIT(S) * (K(4) * first + last * last);
    S sum = 0;
    int plus = 0, minus = 0;
    for (int i = 0; i < 9; i++) {
        c[i] *= scale[i];
        sum += c[i];
        plus += c[i] > noise;
        minus += c[i] < -noise;
    }
    if (plus == 9 || minus == 9)
        return 0;
    if (sum - sum != 0)
        return BS_EVOLVED_INVALID;

    FN(evolved_roots_search) search = {&problem, roots, max_roots, 0, 0};
    const int holed = FN(evolved_gap)(gap, surface2);
    for (int side = 0; side <= holed; side++) {
        for (int i = 0; i < 9; i++)
            part[i] = c[i];
        if (holed)
            FN(evolved_roots_cut)(part, gap[side], side);
        FN(evolved_roots_isolate)(&search, part, noise, side ? gap[1] : K(0), side ? K(1) : gap[0]);
    }
    return search.vanishes ? BS_EVOLVED_VANISHES : search.count;
}

/* The printed method: all roots of the polynomial of degree 12, real ones in [0, 1] kept where |f| < 1e-6. */
BS_INLINE int FN(evolved_companion)(S *roots, int max_roots, const S *ray9, const S *surface2)
{
    S powers[BS_COMPANION_DEGREE + 1], re[BS_COMPANION_DEGREE], im[BS_COMPANION_DEGREE], gap[2];
    FN(evolved_gap)(gap, surface2);
    FN(evolved_dodecic)(powers, ray9, surface2);
    const int found = FN(companion_roots)(re, im, powers, BS_COMPANION_DEGREE);
    int count = 0;
    for (int i = 0; i < found; i++) {
        const S a = re[i];
        if (im[i] != 0 || !(a >= 0 && a <= 1) || (a > gap[0] && a < gap[1]))
            continue;
        const S f = FN(evolved_meet_square)(ray9, surface2, a, K(1) - a);
        if (!(BS_ABS1(f) < K(BS_EVOLVED_FILTER)) || count == max_roots)
            continue;
        int place = count++;
        for (; place > 0 && roots[place - 1] > a; place--)
            roots[place] = roots[place - 1];
        roots[place] = a;
    }
    return count;
}

/* Root between from and from + 1, where the values have unlike signs, of the quadratic through (0, f0), (1, f1)
   and (2, f2); of the secant where the quadratic is not finite. */
BS_INLINE S FN(evolved_quadratic)(S f0, S f1, S f2, int from)
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
BS_INLINE int FN(evolved_sampled)(S *roots, int max_roots, const S *ray9, const S *surface2, int samples)
{
    const S step = K(1) / K(samples - 1);
    S gap[2], f0 = 0, f1 = 0;
    int count = 0, run = 0;
    FN(evolved_gap)(gap, surface2);
    for (int i = 0; i < samples; i++) {
        const S a = K(i) * step, next = a + step;
        if (a > gap[0] && a < gap[1]) {
            run = 0;
            continue;
        }
        const S f2 = FN(evolved_meet_square)(ray9, surface2, a, K(1) - a);
        if (run > 0 && (f1 < 0) != (f2 < 0) && count < max_roots) {
            const int first = run == 1; /* no neighbour before: take the one behind */
            const S f3 = first ? FN(evolved_meet_square)(ray9, surface2, next, K(1) - next) : K(0);
            const S t = first ? FN(evolved_quadratic)(f1, f2, f3, 0) : FN(evolved_quadratic)(f0, f1, f2, 1) - K(1);
            const S root = a + (t - K(1)) * step;
            roots[count] = count > 0 && root < roots[count - 1] ? roots[count - 1] : root; /* by a rounding */
            count++;
        }
        f0 = f1, f1 = f2, run++;
    }
    return count;
}

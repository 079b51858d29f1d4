/* Where a ray meets a surface evolved along a piece of a curve of circles: its parameters t in [0, 1]. Three methods
   with one signature; control flow only. No guard: one inclusion makes one instance, for one scalar type S and one
   degree of the curve. The including file defines
     EVOLVED(name)  the instance's names
     KERNEL(name)   its kernels, made from the formulas of codegen/formulas/curves/surfaces.py
     BS_DEGREE      n, of the curve
     BS_FREE        1 where pieces may begin and end with sums that are no circles, else 0
     BS_SCENE_ISOLATE, BS_SCENE_COMPANION, BS_SCENE_SAMPLED  which methods there are
   k: the surface's row of constants; meets: those of a ray with its controls and products.

   Results: the number of roots stored, rising, at most max_roots (the polynomial's degree always suffices), or
     BS_EVOLVED_VANISHES  f is zero for all t: the ray meets every circle (it lies in the surface or in the circles'
                          common plane, or passes through a point shared by all circles);
     BS_EVOLVED_INVALID   something is not finite.
   Ends: 0 and 1 belong to the surface, with BS_ROOTS_MARGIN roundings by which a root there may be off. Tangency:
   two roots are two if f, where it is extreme between them, is more than its rounding error. If it is not, nobody
   knows whether the ray hits twice, touches or just misses: one root is reported, at the extremum. A ray in the plane
   of one circle touches in this sense: there the meet Y vanishes, and the ray may hit twice or not at all. Only where
   the row's spans say that the interpolant is real anything is looked for. */

#include "roots.h"

#ifndef BS_EVOLVED_CONSTANTS
#define BS_EVOLVED_CONSTANTS
enum { BS_EVOLVED_VANISHES = -1, BS_EVOLVED_INVALID = -2, BS_EVOLVED_SPANS = 4 };
#define BS_EVOLVED_FILTER 1e-6 /* the printed threshold on |f| */
/* Q of circles on a common sphere was made of up to that many roundings of the products of controls. */
#define BS_EVOLVED_COSPHERICAL 32
/* Square root of the unit roundoff; as many as a root may be off an end and still be that of the end's circle. */
#define BS_EVOLVED_SQRT(T) ((T)(sizeof(T) == 4 ? 2.44140625e-4 : 1.0536712127723509e-8))
#define BS_EVOLVED_BESIDE 64
#endif

/* Degree of Q, and where the parts of a row of constants stand. */
#define EVOLVED_QUAD (2 * BS_DEGREE - 2 + 2 * BS_FREE)
#define EVOLVED_CENTER 0 /* of the frame, in the world */
#define EVOLVED_UNIT 3   /* length of its unit, and one over it */
#define EVOLVED_START 5  /* parameter of the curve where the piece begins, and how long it is there */
#define EVOLVED_BOUND 7  /* centre and radius of a sphere around the surface, in the frame */
#define EVOLVED_REAL 11  /* spans of t where the interpolant is real */
#define EVOLVED_NORM (EVOLVED_REAL + 2 * BS_EVOLVED_SPANS)
#define EVOLVED_KAPPA (EVOLVED_NORM + 2 * BS_DEGREE + 1)
#define EVOLVED_CONTROLS (EVOLVED_KAPPA + 2 * EVOLVED_QUAD + 1)
#define EVOLVED_PRODUCTS (EVOLVED_CONTROLS + 10 * (BS_DEGREE + 1))
#define EVOLVED_SIZES (EVOLVED_PRODUCTS + 10 * (EVOLVED_QUAD + BS_DEGREE + 1)) /* of Q, and of p's terms */
#define EVOLVED_MEETS (3 * (2 * BS_DEGREE + EVOLVED_QUAD + 2)) /* numbers of a ray */
#define EVOLVED_ROOTS (8 * BS_DEGREE + 2 * EVOLVED_QUAD)   /* degree of p */
#define EVOLVED_PRINTED (12 * BS_DEGREE)

typedef struct {
    const S *meets, *k;
    const S *origin, *direction; /* of the ray, in the frame; for bounds on errors only */
    S u[2 * BS_DEGREE + 1];      /* coefficients of u, where all circles lie on one sphere */
} EVOLVED(problem);

/* Whether the interpolant is real at t. */
BS_INLINE int EVOLVED(is_real)(const S *k, S t)
{
    int real = 0;
    for (int i = 0; i < BS_EVOLVED_SPANS; i++)
        real |= t >= k[EVOLVED_REAL + 2 * i] && t <= k[EVOLVED_REAL + 2 * i + 1];
    return real;
}

#if BS_SCENE_ISOLATE
/* A short kernel is repeated where it is called, a long one is not. */
#if BS_DEGREE == 1
BS_INLINE
#else
BS_OUTLINED
#endif
S EVOLVED(condition)(const EVOLVED(problem) *d, S t, S rest)
{
    S f[1];
    KERNEL(evolved_condition)(f, d->meets, d->k + EVOLVED_NORM, d->k + EVOLVED_KAPPA, &rest, &t);
    return f[0];
}

#if BS_DEGREE == 1
BS_INLINE
#else
BS_OUTLINED
#endif
void EVOLVED(condition_rate)(S *f_rate, const EVOLVED(problem) *d, S t, S rest)
{
    KERNEL(evolved_condition_rate)(f_rate, d->meets, d->k + EVOLVED_NORM, d->k + EVOLVED_KAPPA, &rest, &t);
}

BS_COLD S EVOLVED(condition_bound)(const EVOLVED(problem) *d, S t, S rest)
{
    S bound[1];
    KERNEL(evolved_condition_bound)(bound, d->origin, d->direction, d->meets, d->k + EVOLVED_NORM,
                                    d->k + EVOLVED_KAPPA, &rest, &t, d->k + EVOLVED_CONTROLS,
                                    d->k + EVOLVED_PRODUCTS);
    return bound[0];
}

BS_COLD S EVOLVED(polynomial_bound)(const EVOLVED(problem) *d, S t, S rest)
{
    S bound[1];
    KERNEL(evolved_polynomial_bound)(bound, d->meets, d->k + EVOLVED_NORM, d->k + EVOLVED_KAPPA, &rest, &t);
    return bound[0];
}

#define ROOTS(name) EVOLVED(roots_##name)
#define ROOTS_DEGREE (8 * BS_DEGREE + 2 * EVOLVED_QUAD)
#define ROOTS_DATA EVOLVED(problem)
#define ROOTS_CONDITION(d, a, b) EVOLVED(condition)(d, a, b)
#define ROOTS_RATE(f_rate, d, a, b) EVOLVED(condition_rate)(f_rate, d, a, b)
#define ROOTS_BOUND(d, a, b) EVOLVED(condition_bound)(d, a, b)
#define ROOTS_NOISE(d, a, b) EVOLVED(polynomial_bound)(d, a, b)
#include "roots.h"

/* Circles of one sphere: Q = 0, both branches are one, and p vanishes. There p and f are u. */
BS_COLD S EVOLVED(shared_noise)(const EVOLVED(problem) *d, S t, S rest)
{
    S bound[1];
    KERNEL(common_sphere_bound)(bound, d->u, &rest, &t);
    return bound[0];
}

BS_COLD void EVOLVED(shared_rate)(S *f_rate, const EVOLVED(problem) *d, S t, S rest)
{
    KERNEL(common_sphere_condition)(f_rate, d->meets, d->k + EVOLVED_NORM, &rest, &t);
}

BS_COLD S EVOLVED(shared_condition)(const EVOLVED(problem) *d, S t, S rest)
{
    S f_rate[2];
    EVOLVED(shared_rate)(f_rate, d, t, rest);
    return f_rate[0];
}

BS_COLD S EVOLVED(shared_bound)(const EVOLVED(problem) *d, S t, S rest)
{
    S bound[1];
    KERNEL(common_sphere_condition_bound)(bound, d->origin, d->direction, d->meets, d->k + EVOLVED_NORM, &rest, &t,
                                          d->k + EVOLVED_CONTROLS);
    return bound[0];
}

#define ROOTS(name) EVOLVED(shared_##name)
#define ROOTS_DEGREE (2 * BS_DEGREE)
#define ROOTS_DATA EVOLVED(problem)
#define ROOTS_CONDITION(d, a, b) EVOLVED(shared_condition)(d, a, b)
#define ROOTS_RATE(f_rate, d, a, b) EVOLVED(shared_rate)(f_rate, d, a, b)
#define ROOTS_BOUND(d, a, b) EVOLVED(shared_bound)(d, a, b)
#define ROOTS_NOISE(d, a, b) EVOLVED(shared_noise)(d, a, b)
#include "roots.h"

/* Whether there is a circle at an end of the piece, but no root next to it. */
BS_INLINE int EVOLVED(misses)(const S *k, const S *roots, int count, S end)
{
    int known = !EVOLVED(is_real)(k, end);
    for (int i = 0; i < count; i++)
        known |= BS_ABS1(roots[i] - end) <= K(BS_EVOLVED_BESIDE) * BS_EVOLVED_SQRT(S);
    return !known;
}

/* The end of a piece among its roots: there f is zero to rounding, but the root may be just beyond it, at joints beyond
   the ends of both pieces. */
BS_COLD int EVOLVED(with_end)(S *roots, int count, int max_roots, S end)
{
    if (count == max_roots)
        return count;
    for (int i = count; i > 0 && end == 0; i--)
        roots[i] = roots[i - 1];
    roots[end == 0 ? 0 : count] = end;
    return count + 1;
}

BS_COLD int EVOLVED(isolate_shared)(S *roots, int max_roots, EVOLVED(problem) *problem)
{
    S c[2 * BS_DEGREE + 1], part[2 * BS_DEGREE + 1], sum = 0, size = 0;
    EVOLVED(shared_search) search = {problem, roots, max_roots, 0, 0};
    KERNEL(common_sphere_meets)(problem->u, problem->meets, problem->k + EVOLVED_NORM);
    KERNEL(common_sphere_polynomial)(c, problem->u);
    for (int i = 0; i <= 2 * BS_DEGREE; i++) {
        sum += c[i];
        size = BS_ABS1(c[i]) > size ? BS_ABS1(c[i]) : size;
    }
    const S noise = K(BS_ROOTS_NOISE) * BS_ROOTS_UNIT(S) * size;
    if (sum - sum != 0)
        return BS_EVOLVED_INVALID;
    for (int i = 0; i < BS_EVOLVED_SPANS; i++) {
        const S *span = problem->k + EVOLVED_REAL + 2 * i, lo = span[0], hi = span[1];
        if (!(lo < hi))
            continue;
        for (int j = 0; j <= 2 * BS_DEGREE; j++)
            part[j] = c[j];
        EVOLVED(shared_cut)(part, hi, 0);
        EVOLVED(shared_cut)(part, lo / hi, 1);
        EVOLVED(shared_isolate)(&search, part, noise, lo, hi);
    }
    if (search.vanishes)
        return BS_EVOLVED_VANISHES;
    for (int end = 0; end < 2; end++)
        if (BS_ABS1(c[2 * BS_DEGREE * end]) <= noise && EVOLVED(misses)(problem->k, roots, search.count, K(end))
            && EVOLVED(shared_touches)(problem, K(end), EVOLVED(shared_at)(problem, K(end))))
            search.count = EVOLVED(with_end)(roots, search.count, max_roots, K(end));
    return search.count;
}

/* Default: every root, no false one. reach: (1 + x^2)^2 for the ray's origin x, which p's terms may grow by. */
BS_INLINE int EVOLVED(isolate)(S *roots, int max_roots, EVOLVED(problem) *problem, S reach)
{
    const S *const k = problem->k;
    const S noise = K(BS_ROOTS_NOISE) * BS_ROOTS_UNIT(S) * reach * k[EVOLVED_SIZES + 1];
    S c[EVOLVED_ROOTS + 1], sum = 0, least = BS_FAR, most = -BS_FAR;
    if (k[EVOLVED_SIZES] <= K(BS_EVOLVED_COSPHERICAL) * BS_ROOTS_UNIT(S))
        return EVOLVED(isolate_shared)(roots, max_roots, problem);
    KERNEL(evolved_polynomial)(c, problem->meets, k + EVOLVED_NORM, k + EVOLVED_KAPPA);
    for (int i = 0; i <= EVOLVED_ROOTS; i++) {
        sum += c[i];
        least = c[i] < least ? c[i] : least;
        most = c[i] > most ? c[i] : most;
    }
    if (sum - sum != 0)
        return BS_EVOLVED_INVALID;
    if (least > noise || most < -noise)
        return 0;

    EVOLVED(roots_search) search = {problem, roots, max_roots, 0, 0};
    for (int i = 0; i < BS_EVOLVED_SPANS; i++) {
        const S lo = k[EVOLVED_REAL + 2 * i], hi = k[EVOLVED_REAL + 2 * i + 1];
        S part[EVOLVED_ROOTS + 1];
        if (!(lo < hi))
            continue;
        for (int j = 0; j <= EVOLVED_ROOTS; j++)
            part[j] = c[j];
        if (hi < 1)
            EVOLVED(roots_cut)(part, hi, 0);
        if (lo > 0)
            EVOLVED(roots_cut)(part, lo / hi, 1);
        EVOLVED(roots_isolate)(&search, part, noise, lo, hi);
    }
    if (search.vanishes)
        return BS_EVOLVED_VANISHES;
    for (int end = 0; end < 2; end++)
        if (BS_ABS1(c[end * EVOLVED_ROOTS]) <= noise && EVOLVED(misses)(k, roots, search.count, K(end))
            && EVOLVED(roots_touches)(problem, K(end), EVOLVED(roots_at)(problem, K(end))))
            search.count = EVOLVED(with_end)(roots, search.count, max_roots, K(end));
    return search.count;
}
#endif

#if BS_SCENE_COMPANION || BS_SCENE_SAMPLED
BS_INLINE S EVOLVED(meet_square)(const EVOLVED(problem) *d, S t)
{
    const S rest = K(1) - t;
    S f[1];
    KERNEL(evolved_meet_square)(f, d->meets, d->k + EVOLVED_NORM, d->k + EVOLVED_KAPPA, &rest, &t);
    return f[0];
}
#endif

#if BS_SCENE_COMPANION
#define COMPANION(name) EVOLVED(companion_##name)
#define BS_COMPANION_DEGREE EVOLVED_PRINTED
#include "companion.h"

/* The printed method: all roots of the polynomial of degree 12 n, real ones in [0, 1] kept where |f| < 1e-6. */
BS_OUTLINED int EVOLVED(companion)(S *roots, int max_roots, const EVOLVED(problem) *d)
{
    S powers[EVOLVED_PRINTED + 1], re[EVOLVED_PRINTED], im[EVOLVED_PRINTED];
    KERNEL(evolved_published_polynomial)(powers, d->meets, d->k + EVOLVED_NORM, d->k + EVOLVED_KAPPA);
    const int found = EVOLVED(companion_roots)(re, im, powers, EVOLVED_PRINTED);
    int count = 0;
    for (int i = 0; i < found; i++) {
        const S t = re[i];
        if (im[i] != 0 || !(t >= 0 && t <= 1) || !EVOLVED(is_real)(d->k, t))
            continue;
        const S f = EVOLVED(meet_square)(d, t);
        if (!(BS_ABS1(f) < K(BS_EVOLVED_FILTER)) || count == max_roots)
            continue;
        int place = count++;
        for (; place > 0 && roots[place - 1] > t; place--)
            roots[place] = roots[place - 1];
        roots[place] = t;
    }
    return count;
}
#endif

#if BS_SCENE_SAMPLED
/* Root between from and from + 1, where the values have unlike signs, of the quadratic through (0, f0), (1, f1)
   and (2, f2); of the secant where the quadratic is not finite. */
BS_INLINE S EVOLVED(quadratic)(S f0, S f1, S f2, int from)
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
BS_OUTLINED int EVOLVED(sampled)(S *roots, int max_roots, const EVOLVED(problem) *d, int samples)
{
    const S step = K(1) / K(samples - 1);
    S f0 = 0, f1 = 0;
    int count = 0, run = 0;
    for (int i = 0; i < samples; i++) {
        const S t = K(i) * step;
        if (!EVOLVED(is_real)(d->k, t < 1 ? t : K(1))) {
            run = 0;
            continue;
        }
        const S f2 = EVOLVED(meet_square)(d, t);
        if (run > 0 && (f1 < 0) != (f2 < 0) && count < max_roots) {
            const int first = run == 1; /* no neighbour before: take the one behind */
            const S f3 = first ? EVOLVED(meet_square)(d, t + step) : K(0);
            const S part = first ? EVOLVED(quadratic)(f1, f2, f3, 0) : EVOLVED(quadratic)(f0, f1, f2, 1) - K(1);
            const S root = t + (part - K(1)) * step;
            roots[count] = count > 0 && root < roots[count - 1] ? roots[count - 1] : root; /* by a rounding */
            count++;
        }
        f0 = f1, f1 = f2, run++;
    }
    return count;
}
#endif

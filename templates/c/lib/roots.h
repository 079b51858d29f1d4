/* Roots on [0, 1] of one branch of a polynomial: Descartes' rule on Bernstein coefficients isolates, the condition
   tells true from false and refines. Control flow only; the algebra comes in through the names below. No guard: one
   inclusion makes one instance, for one scalar type S, one degree and one kind of problem.

   The polynomial p of degree n vanishes wherever the condition f does, and at roots of other branches, where f does
   not: f is what stood there before a square root was squared away. Define before including (undefined at the end):
     ROOTS(name)               the instance's names, e.g. FN(evolved_##name)
     ROOTS_DEGREE              n
     ROOTS_DATA                type of a problem, handed on to f as a const pointer
     ROOTS_CONDITION(d, a, b)  f at a, with b = 1 - a, or any positive continuous multiple of it
     ROOTS_RATE(to, d, a, b)   optional: f and its derivative by a into to[0], to[1]; fewer steps are needed then, and
                               extrema of f are found by it (roots_rates.h; else roots_values.h)
     ROOTS_BOUND(d, a, b)      sum of the absolute values of its terms there: its rounding error is relative to it
     ROOTS_NOISE(d, a, b)      sum of the absolute values of p's terms, rising in a and b, b not bound to 1 - a
   It provides: ROOTS(search), made with {data, roots, room for how many, 0, 0}; ROOTS(isolate)(search, c, noise, begin,
   end) for p's Bernstein coefficients on [begin, end], in [0, 1], that are off by less than noise; it appends to
   roots, rising, and sets vanishes. ROOTS(cut) makes the coefficients of a part of [0, 1].

   A piece of [0, 1] is dropped when p has one certain sign on it, or at most one root and f no sign change. It
   holds one root when f changes sign and p has at most two roots. Otherwise it is halved. So no tolerance tells
   true from false. One is needed where p drowns in its own rounding errors, because roots of p lie closer together
   than about the square root of the unit roundoff: there f is asked at its extremum (ROOTS(settle)), and where it is
   zero to rounding, a touching root is reported once. And where [begin, end] begins or ends at a root: there the sign of
   f is chance, and so the end is moved inwards to where it is certain (ROOTS(trim)). */

#ifndef BS_ROOTS_CONSTANTS
#define BS_ROOTS_CONSTANTS
#define BS_ROOTS_UNIT(T) ((T)(sizeof(T) == 4 ? 5.9604644775390625e-8 : 1.1102230246251565e-16))
/* Halvings until a piece is as short as the square root of the unit roundoff. */
#define BS_ROOTS_DEPTH(T) (sizeof(T) == 4 ? 13 : 27)
/* A run of noisy pieces up to this width is two or three roots that nearly meet; a wider one is probed. */
#define BS_ROOTS_SHORT(T) ((T)(sizeof(T) == 4 ? 0.015625 : 0.000244140625))
/* Cube root of the unit roundoff: a third-order step from here is exact. */
#define BS_ROOTS_NEAR(T) ((T)(sizeof(T) == 4 ? 0.00390625 : 4.76837158203125e-6))
/* A step of third order up to this is followed by one of which the error is known; fourth root of the unit roundoff. */
#define BS_ROOTS_CLOSE(T) ((T)(sizeof(T) == 4 ? 0.015625 : 1.0264824865746e-4))
/* Most of Newton's step that its curvature may change; beyond, the series does not hold. */
#define BS_ROOTS_BENT 0.25
/* All in unit roundoffs. MARGIN: how far outside [0, 1] a root still counts, because it was rounded there. NOISE:
   errors of p's coefficients relative to the caller's bound, some ten when they are made and as many by halving;
   the rest, 8 MARGIN, is what p changes by outside its interval. TOUCH: error of f relative to its bound. */
enum { BS_ROOTS_NOISE = 288, BS_ROOTS_MARGIN = 32, BS_ROOTS_TOUCH = 16 };
/* STEPS is out of reach: bisection alone ends after 53. PATIENCE: steps after which it is asked whether f is rounding
   only. PROBES: places where f is asked in a wide run. */
#define BS_ROOTS_GOLDEN 0.3819660112501051
enum { BS_ROOTS_STEPS = 128, BS_ROOTS_PATIENCE = 4, BS_ROOTS_PROBES = 32, BS_ROOTS_STACK = 28 };
#endif

#ifdef ROOTS /* without it only the constants are wanted */
/* Unrolled, a few coefficients stay in registers; of many the compiler makes vectors. */
#if ROOTS_DEGREE <= 12
#define ROOTS_SHORT 1
#define ROOTS_UNROLL BS_UNROLL
#else
#define ROOTS_SHORT 0
#define ROOTS_UNROLL
#endif

typedef struct {
    S c[ROOTS_DEGREE + 1]; /* Bernstein coefficients on [lo, hi] */
    S lo, hi, f_lo, f_hi, noise;
    int depth, roots, unsure; /* the last two: variations of c */
} ROOTS(piece);

typedef struct {
    const ROOTS_DATA *data;
    S *roots;
    int max_roots, count;
    int vanishes; /* f is zero to rounding at every place of a wide run */
} ROOTS(search);

BS_INLINE S ROOTS(at)(const ROOTS_DATA *d, S a)
{
    return ROOTS_CONDITION(d, a, K(1) - a);
}

/* p's coefficients on both halves of the interval of c; left or right may be c. Unrolled, the triangle stays in
   registers, and sums are halved at its sides only; made of vectors it is six times slower, through misaligned reloads.
   Where there are many coefficients sums are halved as they are made, lest they grow out of range. */
BS_INLINE void ROOTS(halve)(S *left, S *right, const S *c)
{
    const S inside = ROOTS_SHORT ? K(1) : K(0.5);
    S w[ROOTS_DEGREE + 1], side = 1;
    ROOTS_UNROLL
    for (int i = 0; i <= ROOTS_DEGREE; i++)
        w[i] = c[i];
    ROOTS_UNROLL
    for (int i = 0; i <= ROOTS_DEGREE; i++) {
        left[i] = side * w[0];
        right[ROOTS_DEGREE - i] = side * w[ROOTS_DEGREE - i];
        ROOTS_UNROLL
        for (int j = 0; j < ROOTS_DEGREE - i; j++)
            w[j] = inside * (w[j] + w[j + 1]);
        side *= ROOTS_SHORT ? K(0.5) : K(1);
    }
}

/* `variations` where some coefficients are within noise of zero. Were every sign unlike the one before, there would be
   as many changes as the degree: one less for each certain sign that does not fit to the certain one before. */
BS_INLINE int ROOTS(unsure_variations)(const S *c, S noise)
{
    int misfits = 0, last = 0, known = 0;
    ROOTS_UNROLL
    for (int i = 0; i <= ROOTS_DEGREE; i++) {
        const int below = c[i] < -noise, certain = below | (c[i] > noise), turned = certain & (last ^ below ^ (i & 1));
        misfits += known & turned;
        last ^= turned;
        known |= certain;
    }
    return known ? ROOTS_DEGREE - misfits : -2;
}

/* Most sign changes of the coefficients when those within noise of zero may take either sign: no fewer than p has
   roots. -1: they all have one certain sign. -2: they are all noise. */
BS_INLINE int ROOTS(variations)(const S *c, S noise, int *unsure)
{
    UI before = (UI)BITS(c[0]);
    int changes = 0;
    S least = BS_ABS1(c[0]);
    ROOTS_UNROLL
    for (int i = 1; i <= ROOTS_DEGREE; i++) {
        const S size = BS_ABS1(c[i]);
        const UI bits = (UI)BITS(c[i]);
        least = size < least ? size : least;
        changes += (int)((bits ^ before) >> (BS_BITS - 1));
        before = bits;
    }
    *unsure = !(least > noise);
    if (!*unsure)
        return changes ? changes : -1;
    return ROOTS(unsure_variations)(c, noise);
}

BS_INLINE S ROOTS(secant)(S lo, S f_lo, S hi, S f_hi)
{
    return lo + (hi - lo) * (f_lo / (f_lo - f_hi));
}

/* Where the polygon of the coefficients first changes sign, as a fraction of its interval: near a root of p. */
BS_INLINE S ROOTS(crossing)(const S *c)
{
    int i = 0;
    while (i < ROOTS_DEGREE - 1 && (c[i] < 0) == (c[i + 1] < 0))
        i++;
    const S part = c[i] / (c[i] - c[i + 1]);
    return (K(i) + (part > 0 && part < 1 ? part : K(0.5))) / K(ROOTS_DEGREE);
}

BS_INLINE void ROOTS(append)(ROOTS(search) *s, S root)
{
    if (s->count < s->max_roots)
        s->roots[s->count++] = root < 0 ? K(0) : root > 1 ? K(1) : root;
}

/* p's coefficients from the fraction r of the interval of c to its end (upper) or from its start to there. */
BS_INLINE void ROOTS(cut)(S *c, S r, int upper)
{
    for (int n = ROOTS_DEGREE; n > 0; n--)
        for (int i = 0; i < n; i++) {
            S *low = upper ? &c[i] : &c[ROOTS_DEGREE - i - 1];
            *(upper ? low : low + 1) = (K(1) - r) * low[0] + r * low[1];
        }
}

/* Whether f at a, of value fa, is zero to rounding. */
BS_INLINE int ROOTS(touches)(const ROOTS_DATA *d, S a, S fa)
{
    return BS_ABS1(fa) <= K(BS_ROOTS_TOUCH) * BS_ROOTS_UNIT(S) * ROOTS_BOUND(d, a, K(1) - a);
}

#ifdef ROOTS_RATE
#include "roots_rates.h"
#else
#include "roots_values.h"
#endif

BS_INLINE void ROOTS(count)(ROOTS(piece) *piece)
{
    piece->roots = ROOTS(variations)(piece->c, piece->noise, &piece->unsure);
}

BS_OUTLINED void ROOTS(recount)(ROOTS(piece) *piece)
{
    ROOTS(count)(piece);
}

/* From an end of a piece inwards, by at most a quarter of it: the first place where f is more than its rounding error.
   0 if there is none. */
BS_COLD int ROOTS(certain)(const ROOTS_DATA *d, S *x, S *f, S inwards)
{
    const S end = *x, most = K(0.25) * BS_ABS1(inwards);
    for (S step = 0; step <= most; step = step == 0 ? K(BS_ROOTS_MARGIN) * BS_ROOTS_UNIT(S) : K(2) * step) {
        *x = inwards < 0 ? end - step : end + step;
        *f = ROOTS(at)(d, *x);
        if (!ROOTS(touches)(d, *x, *f))
            return 1;
    }
    return 0;
}

/* Append the root between two places, if f has unlike signs there. */
BS_COLD void ROOTS(part)(ROOTS(search) *s, S lo, S f_lo, S hi, S f_hi, S guess)
{
    if ((f_lo < 0) != (f_hi < 0))
        ROOTS(append)(s, lo < hi ? ROOTS(refine)(s->data, lo, f_lo, hi, f_hi, guess) : lo);
}

/* f at an end of [0, 1] or of a piece where p is zero to rounding may be nothing else, and its sign chance: what p tells
   of roots and f of signs would not belong together. So the piece begins and ends where f is certain; what lies beside
   it, one root or none, is appended: below at once, above by `last`, later: places and values of f. */
BS_COLD int ROOTS(trim)(ROOTS(search) *s, ROOTS(piece) *piece, S *last)
{
    S *const c = piece->c, width = piece->hi - piece->lo, x = piece->lo, f;
    if (BS_ABS1(c[0]) <= piece->noise && ROOTS(certain)(s->data, &x, &f, width)) {
        ROOTS(part)(s, piece->lo, piece->f_lo, x, f, K(0.5) * (piece->lo + x));
        ROOTS(cut)(c, (x - piece->lo) / width, 1);
        piece->lo = x, piece->f_lo = f;
    }
    x = piece->hi;
    if (!(BS_ABS1(c[ROOTS_DEGREE]) <= piece->noise && ROOTS(certain)(s->data, &x, &f, -width)))
        return 0;
    last[0] = x, last[1] = f, last[2] = piece->hi, last[3] = piece->f_hi;
    ROOTS(cut)(c, (x - piece->lo) / (piece->hi - piece->lo), 0);
    piece->hi = x, piece->f_hi = f;
    return 1;
}

/* Append the roots of f in [begin, end], rising. c: p's Bernstein coefficients there, with errors up to noise. */
BS_INLINE void ROOTS(isolate)(ROOTS(search) *s, const S *c, S noise, S begin, S end)
{
    const S margin = K(BS_ROOTS_MARGIN) * BS_ROOTS_UNIT(S);
    ROOTS(piece) stack[BS_ROOTS_STACK], run;
    ROOTS(bracket) brackets[2];
    S last[4];
    int height = 0, running = 0, pending = 0;
    for (int i = 0; i <= ROOTS_DEGREE; i++)
        stack->c[i] = c[i];
    stack->lo = begin, stack->hi = end, stack->noise = noise, stack->depth = 0;
    stack->f_lo = ROOTS(at)(s->data, begin > 0 ? begin : -margin);
    stack->f_hi = ROOTS(at)(s->data, end < 1 ? end : K(1) + margin);
    ROOTS(recount)(stack);
    const int trimmed = stack->unsure && ROOTS(trim)(s, stack, last);
    if (stack->unsure)
        ROOTS(recount)(stack);
    while (height >= 0) {
        ROOTS(piece) *now = &stack[height], *next = now + 1;
        const int unlike = (now->f_lo < 0) != (now->f_hi < 0);
        if (now->unsure && (now->roots == -2 || now->roots > 1 + unlike)) {
            const S local = K(BS_ROOTS_NOISE) * BS_ROOTS_UNIT(S) * ROOTS_NOISE(s->data, now->hi, K(1) - now->lo);
            now->noise = local < now->noise ? local : now->noise;
            ROOTS(recount)(now);
        }
        const int roots = now->roots, crowded = roots > 1 + unlike;
        const int noisy = roots == -2 || (crowded && now->depth == BS_ROOTS_DEPTH(S));
        if (crowded && !noisy) {
            ROOTS(halve)(next->c, now->c, now->c);
            next->lo = now->lo, next->f_lo = now->f_lo;
            next->hi = now->lo = K(0.5) * (now->lo + now->hi);
            next->noise = now->noise, next->depth = ++now->depth;
            ROOTS(count)(next);
            ROOTS(count)(now);
            next->f_hi = now->f_lo = ROOTS(parted)(s->data, next, now);
            height += running || next->roots != -1;
            continue;
        }
        if (running && !noisy) {
            ROOTS(settle)(s, &run, c, begin, end);
            running = 0;
        }
        if (noisy) {
            run.lo = running ? run.lo : now->lo, run.f_lo = running ? run.f_lo : now->f_lo;
            run.hi = now->hi, run.f_hi = now->f_hi;
            running = 1;
        } else if (roots >= 0 && unlike) {
            const S guess = now->lo + (now->hi - now->lo) * ROOTS(crossing)(now->c);
            brackets[pending++] = ROOTS(begin)(now->lo, now->f_lo, now->hi, now->f_hi, guess);
        }
        if (pending == 2 || (pending && (running || !height))) {
            ROOTS(finish)(s, brackets, pending);
            pending = 0;
        }
        height--;
    }
    if (running)
        ROOTS(settle)(s, &run, c, begin, end);
    if (trimmed)
        ROOTS(part)(s, last[0], last[1], last[2], last[3], K(0.5) * (last[0] + last[2]));
}

#undef ROOTS
#undef ROOTS_DEGREE
#undef ROOTS_DATA
#undef ROOTS_CONDITION
#undef ROOTS_RATE
#undef ROOTS_BOUND
#undef ROOTS_NOISE
#undef ROOTS_SHORT
#undef ROOTS_UNROLL
#endif

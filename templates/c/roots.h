/* Roots on [0, 1] of one branch of a polynomial: Descartes' rule on Bernstein coefficients isolates, the condition
   tells true from false and refines. Control flow only; the algebra comes in through the names below. No guard: one
   inclusion makes one instance, for one scalar type S and one kind of problem.

   The polynomial p of degree n vanishes wherever the condition f does, and at roots of other branches, where f does
   not: f is what stood there before a square root was squared away. Define before including (undefined at the end):
     ROOTS(name)               the instance's names, e.g. FN(evolved_##name)
     ROOTS_DEGREE              n
     ROOTS_DATA                type of a problem, handed on to f as a const pointer
     ROOTS_CONDITION(d, a, b)  f at a, with b = 1 - a, or any positive continuous multiple of it
     ROOTS_BOUND(d, a, b)      sum of the absolute values of its terms there, to which its rounding error is relative

   A piece of [0, 1] is dropped when p has one certain sign on it, or at most one root and f no sign change. It holds
   one root when f changes sign and p has at most two roots. Otherwise it is halved. So no tolerance tells true from
   false. One is needed where p drowns in its own rounding errors, because roots of p lie closer together than about
   the square root of the unit roundoff: there f is asked at the extremum of p (ROOTS(settle)), and where f only
   touches zero, to rounding, the touching root is reported once. */

#ifndef BS_ROOTS_CONSTANTS
#define BS_ROOTS_CONSTANTS
#define BS_ROOTS_UNIT(T) ((T)(sizeof(T) == 4 ? 5.9604644775390625e-8 : 1.1102230246251565e-16))
/* Halvings until a piece is as short as the square root of the unit roundoff. */
#define BS_ROOTS_DEPTH(T) (sizeof(T) == 4 ? 13 : 27)
/* A run of noisy pieces up to this width is two or three roots that nearly meet; a wider one is probed. */
#define BS_ROOTS_SHORT(T) ((T)(sizeof(T) == 4 ? 0.015625 : 0.000244140625))
/* All in unit roundoffs. NOISE: errors of p's coefficients, relative to the caller's bound; about 60 when they are
   made, the rest is for the halvings and for MARGIN. MARGIN: how far outside [0, 1] a root still counts, because it
   was rounded there. TOUCH: error of f relative to its bound, some ten roundings. */
enum { BS_ROOTS_NOISE = 256, BS_ROOTS_MARGIN = 16, BS_ROOTS_TOUCH = 16 };
/* STEPS is out of reach: bisection alone ends after 53. PROBES: places where f is asked in a wide run. */
enum { BS_ROOTS_STEPS = 128, BS_ROOTS_PROBES = 32, BS_ROOTS_STACK = 28 };
#endif

typedef struct {
    S c[ROOTS_DEGREE + 1]; /* Bernstein coefficients on [lo, hi] */
    S lo, hi, f_lo, f_hi;
    int depth;
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

BS_INLINE S ROOTS(magnitude)(S x)
{
    return x < 0 ? -x : x;
}

/* p's coefficients on [0, r] and [r, 1], r a fraction of the interval of c. right may be c. */
BS_INLINE void ROOTS(split)(S *left, S *right, const S *c, S r)
{
    for (int i = 0; i <= ROOTS_DEGREE; i++)
        right[i] = c[i];
    for (int i = 0; i <= ROOTS_DEGREE; i++) {
        left[i] = right[0];
        for (int j = 0; j < ROOTS_DEGREE - i; j++)
            right[j] = (K(1) - r) * right[j] + r * right[j + 1];
    }
}

/* Most sign changes of the coefficients when those within noise of zero may take either sign: no fewer than p has
   roots. -1: they all have one certain sign. -2: they are all noise. */
BS_INLINE int ROOTS(variations)(const S *c, S noise)
{
    int plus = 0, minus = 0, changes = 0, last = 0;
    for (int i = 0; i <= ROOTS_DEGREE; i++) {
        plus += c[i] > noise;
        minus += c[i] < -noise;
    }
    if (plus > ROOTS_DEGREE || minus > ROOTS_DEGREE)
        return -1;
    if (plus + minus == 0)
        return -2;
    for (int i = 0; i <= ROOTS_DEGREE; i++) {
        const int certain = (c[i] > noise) - (c[i] < -noise), sign = certain ? certain : -last;
        changes += sign == 0 || sign * last < 0;
        last = sign;
    }
    return changes;
}

/* The root between lo and hi, where f has unlike signs: inverse quadratic interpolation where the last three points
   are in a fit state for it (Chandrupatla's test), else bisection. */
BS_INLINE S ROOTS(refine)(const ROOTS_DATA *d, S lo, S f_lo, S hi, S f_hi)
{
    const S tolerance = K(2) * BS_ROOTS_UNIT(S);
    S a = hi, fa = f_hi, b = lo, fb = f_lo, t = fa / (fa - fb);
    for (int step = 0; step < BS_ROOTS_STEPS; step++) {
        const S width = b - a, size = ROOTS(magnitude)(width);
        if (size <= K(2) * tolerance || fa == 0)
            break;
        const S least = tolerance / size;
        t = t > least ? t : least;
        t = t < K(1) - least ? t : K(1) - least;
        const S x = a + t * width, fx = ROOTS(at)(d, x);
        S c = a, fc = fa;
        if ((fx < 0) != (fa < 0)) {
            c = b, fc = fb;
            b = a, fb = fa;
        }
        a = x, fa = fx;
        const S xi = (a - b) / (c - b), phi = (fa - fb) / (fc - fb);
        if (phi * phi < xi && (K(1) - phi) * (K(1) - phi) < K(1) - xi)
            t = fa / (fb - fa) * (fc / (fb - fc)) + (c - a) / (b - a) * (fa / (fc - fa)) * (fb / (fc - fb));
        else
            t = K(0.5);
    }
    return ROOTS(magnitude)(fa) < ROOTS(magnitude)(fb) ? a : b;
}

BS_INLINE void ROOTS(append)(ROOTS(search) *s, S root)
{
    if (s->count < s->max_roots)
        s->roots[s->count++] = root < 0 ? K(0) : root > 1 ? K(1) : root;
}

/* Derivative of p, up to a positive factor, at the fraction r of the interval of c. */
BS_INLINE S ROOTS(slope)(const S *c, S r)
{
    S w[ROOTS_DEGREE];
    for (int i = 0; i < ROOTS_DEGREE; i++)
        w[i] = c[i + 1] - c[i];
    for (int n = ROOTS_DEGREE - 1; n > 0; n--)
        for (int i = 0; i < n; i++)
            w[i] = (K(1) - r) * w[i] + r * w[i + 1];
    return w[0];
}

/* Roots of f in a wide run on which p is noise: p vanishes, and f may. Sign changes between the probes. */
BS_INLINE void ROOTS(probe)(ROOTS(search) *s, const ROOTS(piece) *run)
{
    S a = run->lo, fa = run->f_lo;
    int zeros = 0;
    for (int i = 1; i <= BS_ROOTS_PROBES; i++) {
        const S b = i < BS_ROOTS_PROBES ? run->lo + (run->hi - run->lo) * (K(i) / K(BS_ROOTS_PROBES)) : run->hi;
        const S fb = i < BS_ROOTS_PROBES ? ROOTS(at)(s->data, b) : run->f_hi;
        zeros += !(ROOTS(magnitude)(fb) > K(BS_ROOTS_TOUCH) * BS_ROOTS_UNIT(S) * ROOTS_BOUND(s->data, b, K(1) - b));
        if ((fa < 0) != (fb < 0))
            ROOTS(append)(s, ROOTS(refine)(s->data, a, fa, b, fb));
        a = b, fa = fb;
    }
    s->vanishes = s->vanishes || zeros == BS_ROOTS_PROBES;
}

/* Roots of f in a run of noisy pieces: some roots of p nearly meet there. c: p's coefficients on [begin, end]. With
   unlike signs of f one root is true. With like signs two are or none is, and f at the extremum of p between them
   tells. The extremum is a simple root of p' and known to full accuracy where p's own roots are not. */
BS_INLINE void ROOTS(settle)(ROOTS(search) *s, const ROOTS(piece) *run, const S *c, S begin, S end)
{
    const S width = end - begin, lo = (run->lo - begin) / width, hi = (run->hi - begin) / width;
    if (run->hi - run->lo > BS_ROOTS_SHORT(S)) {
        ROOTS(probe)(s, run);
        return;
    }
    if ((run->f_lo < 0) != (run->f_hi < 0)) {
        ROOTS(append)(s, ROOTS(refine)(s->data, run->lo, run->f_lo, run->hi, run->f_hi));
        return;
    }
    const S g_lo = ROOTS(slope)(c, lo), g_hi = ROOTS(slope)(c, hi);
    S x = ROOTS(magnitude)(run->f_lo) < ROOTS(magnitude)(run->f_hi) ? run->lo : run->hi;
    if ((g_lo < 0) != (g_hi < 0))
        x = begin + width * (lo + (hi - lo) * (g_lo / (g_lo - g_hi)));
    const S fx = ROOTS(at)(s->data, x);
    if ((fx < 0) != (run->f_lo < 0)) {
        ROOTS(append)(s, ROOTS(refine)(s->data, run->lo, run->f_lo, x, fx));
        ROOTS(append)(s, ROOTS(refine)(s->data, x, fx, run->hi, run->f_hi));
    } else if (ROOTS(magnitude)(fx) <= K(BS_ROOTS_TOUCH) * BS_ROOTS_UNIT(S) * ROOTS_BOUND(s->data, x, K(1) - x)) {
        ROOTS(append)(s, x);
    }
}

/* Append the roots of f in [begin, end], rising. c: p's Bernstein coefficients on it; noise: bound of their errors. */
BS_INLINE void ROOTS(isolate)(ROOTS(search) *s, const S *c, S noise, S begin, S end)
{
    const S margin = K(BS_ROOTS_MARGIN) * BS_ROOTS_UNIT(S);
    ROOTS(piece) stack[BS_ROOTS_STACK], now, run;
    int height = 0, running = 0;
    for (int i = 0; i <= ROOTS_DEGREE; i++)
        now.c[i] = c[i];
    now.lo = begin, now.hi = end, now.depth = 0;
    now.f_lo = ROOTS(at)(s->data, begin > 0 ? begin : -margin);
    now.f_hi = ROOTS(at)(s->data, end < 1 ? end : K(1) + margin);
    run = now;
    for (;;) {
        const int roots = ROOTS(variations)(now.c, noise), unlike = (now.f_lo < 0) != (now.f_hi < 0);
        const int crowded = roots > 1 + unlike, noisy = roots == -2 || (crowded && now.depth == BS_ROOTS_DEPTH(S));
        if (crowded && !noisy) {
            ROOTS(piece) *right = &stack[height++];
            const S middle = K(0.5) * (now.lo + now.hi), f_middle = ROOTS(at)(s->data, middle);
            ROOTS(split)(now.c, right->c, now.c, K(0.5));
            right->lo = middle, right->hi = now.hi, right->f_lo = f_middle, right->f_hi = now.f_hi;
            right->depth = ++now.depth;
            now.hi = middle, now.f_hi = f_middle;
            continue;
        }
        if (noisy && running) {
            run.hi = now.hi, run.f_hi = now.f_hi;
        } else if (noisy) {
            run = now, running = 1;
        } else if (running) {
            ROOTS(settle)(s, &run, c, begin, end);
            running = 0;
        }
        if (roots >= 0 && unlike && !noisy)
            ROOTS(append)(s, ROOTS(refine)(s->data, now.lo, now.f_lo, now.hi, now.f_hi));
        if (height == 0)
            break;
        now = stack[--height];
    }
    if (running)
        ROOTS(settle)(s, &run, c, begin, end);
}

#undef ROOTS
#undef ROOTS_DEGREE
#undef ROOTS_DATA
#undef ROOTS_CONDITION
#undef ROOTS_BOUND

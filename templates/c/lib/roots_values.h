/* Of roots.h: refinement from values of f alone, and what becomes of noisy runs. Included by it once an instance. */

/* f where a piece was parted. */
BS_INLINE S ROOTS(parted)(const ROOTS_DATA *d, const ROOTS(piece) *left, const ROOTS(piece) *right)
{
    (void)right;
    return ROOTS(at)(d, left->hi);
}

/* The root between lo and hi, where f has unlike signs, and where to begin. a is the last point, b the nearest one with
   f of the other sign, c the one before. Inverse quadratic interpolation where the three are fit for it (Chandrupatla's
   test), else bisection; one division. The secant through a and c tells the interpolation's error: when that is a
   rounding, and not by chance far from the root, the next value of f could not add anything. */
BS_INLINE S ROOTS(refine)(const ROOTS_DATA *d, S lo, S f_lo, S hi, S f_hi, S guess)
{
    const S tolerance = K(2) * BS_ROOTS_UNIT(S), scale = K(1) / (f_hi - f_lo);
    S a = hi, fa = f_hi * scale, b = lo, fb = f_lo * scale;
    S move = guess - a;
    for (int step = 0; step < BS_ROOTS_STEPS; step++) {
        const S x = a + move, fx = scale * ROOTS(at)(d, x);
        S c = a, fc = fa;
        if ((fx < 0) != (fa < 0)) {
            c = b, fc = fb;
            b = a, fb = fa;
        }
        a = x, fa = fx;
        const S ab = b - a, ac = c - a, fab = fb - fa, fac = fc - fa, fbc = fc - fb, w = BS_ABS1(ab - ac);
        if (fa == 0 || BS_ABS1(ab) <= tolerance)
            break;
        move = K(0.5) * ab;
        if (fab * fab * w < BS_ABS1(ab) * (fbc * fbc) && fac * fac * w < BS_ABS1(ac) * (fbc * fbc)) {
            const S weight = fa / (fab * fac * fbc), secant = ac * fab * fbc;
            const S inverse = fc * ab * fac - fb * ac * fab;
            move = -weight * inverse;
            if (BS_ABS1(weight * (secant - inverse)) <= tolerance && BS_ABS1(move) <= BS_ROOTS_NEAR(S))
                return a + move;
        }
    }
    return a;
}

/* A root between lo and hi that waits for its turn. */
typedef struct {
    S lo, f_lo, hi, f_hi, guess;
} ROOTS(bracket);

BS_INLINE ROOTS(bracket) ROOTS(begin)(S lo, S f_lo, S hi, S f_hi, S guess)
{
    const ROOTS(bracket) bracket = {lo, f_lo, hi, f_hi, guess};
    return bracket;
}

/* Append the roots of some brackets. */
BS_INLINE void ROOTS(finish)(ROOTS(search) *s, const ROOTS(bracket) *brackets, int count)
{
    for (int i = 0; i < count; i++) {
        const ROOTS(bracket) *b = &brackets[i];
        ROOTS(append)(s, ROOTS(refine)(s->data, b->lo, b->f_lo, b->hi, b->f_hi, b->guess));
    }
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

/* Whether the middle one of three values is nearest to zero. */
BS_INLINE int ROOTS(dips)(S before, S middle, S after)
{
    return BS_ABS1(middle) <= BS_ABS1(before) && BS_ABS1(middle) <= BS_ABS1(after);
}

/* f has like signs at lo and hi and is nearest to zero at a known point between. One root if it touches there,
   two if it crosses. Golden section search. */
BS_COLD void ROOTS(dip)(ROOTS(search) *s, S lo, S f_lo, S middle, S f_middle, S hi, S f_hi)
{
    for (int step = 0; step < BS_ROOTS_STEPS && (f_middle < 0) == (f_lo < 0); step++) {
        const int left = middle - lo > hi - middle;
        const S x = middle + K(BS_ROOTS_GOLDEN) * (left ? lo - middle : hi - middle), fx = ROOTS(at)(s->data, x);
        const int nearer = (fx < 0) != (f_lo < 0) || BS_ABS1(fx) < BS_ABS1(f_middle);
        if (left == nearer)
            hi = left ? middle : x, f_hi = left ? f_middle : fx;
        else
            lo = left ? x : middle, f_lo = left ? fx : f_middle;
        middle = nearer ? x : middle, f_middle = nearer ? fx : f_middle;
        if (hi - lo <= BS_ROOTS_NEAR(S) * BS_ROOTS_NEAR(S))
            break;
    }
    if (ROOTS(touches)(s->data, middle, f_middle)) {
        ROOTS(append)(s, middle);
    } else if ((f_middle < 0) != (f_lo < 0)) {
        ROOTS(append)(s, ROOTS(refine)(s->data, lo, f_lo, middle, f_middle, ROOTS(secant)(lo, f_lo, middle, f_middle)));
        ROOTS(append)(s, ROOTS(refine)(s->data, middle, f_middle, hi, f_hi, ROOTS(secant)(middle, f_middle, hi, f_hi)));
    }
}

/* Roots of f in a wide run, on which p does not help: from the sign changes and the dips between probes. */
BS_COLD void ROOTS(probe)(ROOTS(search) *s, const ROOTS(piece) *run)
{
    S x[3] = {run->lo, run->lo, run->lo}, f[3] = {run->f_lo, run->f_lo, run->f_lo};
    int zeros = 0;
    for (int i = 1; i <= BS_ROOTS_PROBES; i++) {
        for (int j = 0; j < 2; j++)
            x[j] = x[j + 1], f[j] = f[j + 1];
        x[2] = i < BS_ROOTS_PROBES ? run->lo + (run->hi - run->lo) * (K(i) / K(BS_ROOTS_PROBES)) : run->hi;
        f[2] = i < BS_ROOTS_PROBES ? ROOTS(at)(s->data, x[2]) : run->f_hi;
        zeros += ROOTS(touches)(s->data, x[2], f[2]);
        if ((f[1] < 0) != (f[2] < 0))
            ROOTS(append)(s, ROOTS(refine)(s->data, x[1], f[1], x[2], f[2], ROOTS(secant)(x[1], f[1], x[2], f[2])));
        else if (i > 1 && (f[0] < 0) == (f[1] < 0) && ROOTS(dips)(f[0], f[1], f[2]))
            ROOTS(dip)(s, x[0], f[0], x[1], f[1], x[2], f[2]);
    }
    s->vanishes = s->vanishes || zeros == BS_ROOTS_PROBES;
}

/* Roots of f in a run of noisy pieces: some roots of p nearly meet there. c: p's coefficients on [begin, end]. With
   unlike signs of f one root is true. With like signs two are or none is, and f at the extremum of p between them
   tells. The extremum is a simple root of p' and known to full accuracy where p's own roots are not. */
BS_COLD void ROOTS(settle)(ROOTS(search) *s, const ROOTS(piece) *run, const S *c, S begin, S end)
{
    const S width = end - begin, lo = (run->lo - begin) / width, hi = (run->hi - begin) / width;
    if (run->hi - run->lo > BS_ROOTS_SHORT(S)) {
        ROOTS(probe)(s, run);
        return;
    }
    if ((run->f_lo < 0) != (run->f_hi < 0)) {
        const S guess = ROOTS(secant)(run->lo, run->f_lo, run->hi, run->f_hi);
        ROOTS(append)(s, ROOTS(refine)(s->data, run->lo, run->f_lo, run->hi, run->f_hi, guess));
        return;
    }
    const S g_lo = ROOTS(slope)(c, lo), g_hi = ROOTS(slope)(c, hi);
    S x = BS_ABS1(run->f_lo) < BS_ABS1(run->f_hi) ? run->lo : run->hi;
    if ((g_lo < 0) != (g_hi < 0))
        x = begin + width * (lo + (hi - lo) * (g_lo / (g_lo - g_hi)));
    const S fx = ROOTS(at)(s->data, x);
    const int crosses = (fx < 0) != (run->f_lo < 0);
    if (ROOTS(touches)(s->data, x, fx))
        ROOTS(append)(s, x);
    else if (crosses || (x > run->lo && x < run->hi && ROOTS(dips)(run->f_lo, fx, run->f_hi)))
        ROOTS(dip)(s, run->lo, run->f_lo, x, fx, run->hi, run->f_hi);
}


/* Of roots.h: refinement from f and its derivative, and what becomes of noisy runs. Included by it once an instance. */

/* The root between lo and hi, where f has unlike signs, and where to begin. Newton's steps; bisection where they leave
   the interval or do not shrink by half. A short step is followed by one with the same slope, of which the error is
   known: the slope changed by twice that step over the one before. It is the last when that is a rounding, or when f
   is nothing but its own rounding error. */
BS_INLINE S ROOTS(refine)(const ROOTS_DATA *d, S lo, S f_lo, S hi, S f_hi, S guess)
{
    const S tolerance = K(2) * BS_ROOTS_UNIT(S);
    S x = guess, before = hi - lo;
    (void)f_hi;
    for (int step = 0; step < BS_ROOTS_STEPS; step++) {
        S f_rate[2];
        ROOTS_RATE(f_rate, d, x, K(1) - x);
        const S f = f_rate[0], move = -f / f_rate[1], next = x + move, size = BS_ABS1(move);
        if ((f < 0) == (f_lo < 0))
            lo = x;
        else
            hi = x;
        if (f == 0 || hi - lo <= tolerance)
            break;
        if (!(next > lo && next < hi && size <= K(0.5) * before)) {
            x = K(0.5) * (lo + hi), before = hi - lo;
            continue;
        }
        x = next, before = size;
        if (size > BS_ROOTS_NEAR(S) * K(0.25))
            continue;
        const S f_next = ROOTS(at)(d, next), last = -f_next / f_rate[1], rest = BS_ABS1(last);
        if ((f_next < 0) == (f_lo < 0))
            lo = next;
        else
            hi = next;
        if (next + last >= lo && next + last <= hi) {
            x = next + last;
            if (K(2) * rest * rest <= tolerance * size)
                break;
        }
        if (step >= BS_ROOTS_PATIENCE && BS_ABS1(f_next) <= BS_ROOTS_UNIT(S) * ROOTS_BOUND(d, next, K(1) - next))
            break;
    }
    return x;
}

/* f has like signs at lo and hi. If it comes nearer to zero from both ends: one root if it touches zero between, two if
   it crosses, by where its derivative vanishes: known to full accuracy where roots are not. Returns 0 if it does not. */
BS_COLD int ROOTS(dip)(ROOTS(search) *s, S lo, S f_lo, S hi, S f_hi)
{
    const S tolerance = K(4) * BS_ROOTS_UNIT(S), side = f_lo < 0 ? -K(1) : K(1);
    S low[2], high[2], f_rate[2] = {f_lo, 0}, left = lo, right = hi, x = lo;
    ROOTS_RATE(low, s->data, lo, K(1) - lo);
    ROOTS_RATE(high, s->data, hi, K(1) - hi);
    if (!(side * low[1] < 0 && side * high[1] >= 0))
        return 0;
    for (int step = 0; step < BS_ROOTS_STEPS && right - left > tolerance; step++) {
        const S secant = left + (right - left) * (low[1] / (low[1] - high[1]));
        const int plain = step % 3 == 2 || !(secant > left && secant < right);
        x = plain ? K(0.5) * (left + right) : secant;
        ROOTS_RATE(f_rate, s->data, x, K(1) - x);
        if (side * f_rate[0] < 0 || f_rate[1] == 0)
            break;
        if (side * f_rate[1] < 0)
            left = x, low[1] = f_rate[1];
        else
            right = x, high[1] = f_rate[1];
    }
    if (ROOTS(touches)(s->data, x, f_rate[0])) {
        ROOTS(append)(s, x);
    } else if (side * f_rate[0] < 0) {
        ROOTS(append)(s, ROOTS(refine)(s->data, lo, f_lo, x, f_rate[0], ROOTS(secant)(lo, f_lo, x, f_rate[0])));
        ROOTS(append)(s, ROOTS(refine)(s->data, x, f_rate[0], hi, f_hi, ROOTS(secant)(x, f_rate[0], hi, f_hi)));
    }
    return 1;
}

/* Roots of f between two places, by its signs and slopes there; 0 if it only falls or only rises and has none. */
BS_COLD int ROOTS(between)(ROOTS(search) *s, S lo, S f_lo, S hi, S f_hi)
{
    if ((f_lo < 0) == (f_hi < 0))
        return ROOTS(dip)(s, lo, f_lo, hi, f_hi);
    ROOTS(append)(s, ROOTS(refine)(s->data, lo, f_lo, hi, f_hi, ROOTS(secant)(lo, f_lo, hi, f_hi)));
    return 1;
}

/* Roots of f in a run of noisy pieces, where roots of p nearly meet: p does not help, f and its slope tell. A wide run
   is searched in parts. At the ends of a short one f may touch zero. */
BS_COLD void ROOTS(settle)(ROOTS(search) *s, const ROOTS(piece) *run, const S *c, S begin, S end)
{
    S x = run->lo, f = run->f_lo;
    int zeros = 0;
    (void)c, (void)begin, (void)end;
    if (!(run->hi - run->lo > BS_ROOTS_SHORT(S))) {
        if (!ROOTS(between)(s, run->lo, run->f_lo, run->hi, run->f_hi)) {
            const int first = BS_ABS1(run->f_lo) < BS_ABS1(run->f_hi);
            x = first ? run->lo : run->hi;
            if (ROOTS(touches)(s->data, x, first ? run->f_lo : run->f_hi))
                ROOTS(append)(s, x);
        }
        return;
    }
    for (int i = 1; i <= BS_ROOTS_PROBES; i++) {
        const S lo = x, f_lo = f;
        x = i < BS_ROOTS_PROBES ? run->lo + (run->hi - run->lo) * (K(i) / K(BS_ROOTS_PROBES)) : run->hi;
        f = i < BS_ROOTS_PROBES ? ROOTS(at)(s->data, x) : run->f_hi;
        zeros += ROOTS(touches)(s->data, x, f);
        ROOTS(between)(s, lo, f_lo, x, f);
    }
    s->vanishes = s->vanishes || zeros == BS_ROOTS_PROBES;
}

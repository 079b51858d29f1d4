/* Of roots.h: refinement from f and its derivative, and what becomes of noisy runs. Included by it once an instance. */

/* f where a piece was parted. Where p has no root in one half, f has the sign of that half's other end: no more need be
   known. */
BS_INLINE S ROOTS(parted)(const ROOTS_DATA *d, const ROOTS(piece) *left, const ROOTS(piece) *right)
{
    if (left->roots == -1)
        return left->f_lo < 0 ? -BS_FAR : BS_FAR;
    if (right->roots == -1)
        return right->f_hi < 0 ? -BS_FAR : BS_FAR;
    return ROOTS(at)(d, left->hi);
}

/* Newton's step with the curvature of f, as far as another value of f (and its slope there, if that is known) tells it.
   bend: half of f's second derivative over its first. */
BS_INLINE S ROOTS(step)(S *bend, S f, S rate, S away, S f_other, S rate_other, int known)
{
    const S inverse = K(1) / rate, over = K(1) / away, chord = (f_other - f) * over, newton = -f * inverse;
    *bend = (known ? K(3) * chord - rate_other - K(2) * rate : chord - rate) * over * inverse;
    const S part = *bend * newton;
    if (!(BS_ABS1(part) <= K(BS_ROOTS_BENT)))
        *bend = 0;
    return *bend == 0 ? newton : newton * (K(1) - part + K(2) * part * part);
}

/* A root between lo and hi, where f has unlike signs, on its way. */
typedef struct {
    S lo, hi, x, before; /* before: length of the last step */
    S other, f_other, rate_other; /* f somewhere else, and its slope after a step */
    S side; /* 1 or -1: sign of f at lo */
    int step;
} ROOTS(bracket);

BS_INLINE ROOTS(bracket) ROOTS(begin)(S lo, S f_lo, S hi, S f_hi, S guess)
{
    const int first = BS_ABS1(f_lo) < BS_FAR;
    ROOTS(bracket) b;
    b.lo = lo, b.hi = hi, b.x = guess, b.before = hi - lo;
    b.other = first ? lo : hi, b.f_other = first ? f_lo : f_hi, b.rate_other = 0;
    b.side = f_lo < 0 ? -K(1) : K(1), b.step = 0;
    return b;
}

/* One of Newton's steps, with the curvature from the place before; bisection where it leaves the interval or does not
   shrink by half. A short step is followed by one with the same slope and curvature, of which the error is known: the
   slope is off by three times that step over the one before. It is the last when that is a rounding, or when f is
   nothing but its own rounding error: 1 then, and x is the root. Of f at the ends only the sign need be known: as
   numbers those of BS_FAR have no use. */
BS_INLINE int ROOTS(advance)(ROOTS(bracket) *b, const ROOTS_DATA *d)
{
    const S tolerance = K(2) * BS_ROOTS_UNIT(S), x = b->x;
    S f_rate[2], bend, lo = b->lo, hi = b->hi;
    ROOTS_RATE(f_rate, d, x, K(1) - x);
    const S f = f_rate[0], rate = f_rate[1], left = b->side * f;
    const S move = ROOTS(step)(&bend, f, rate, b->other - x, b->f_other, b->rate_other, b->step > 0);
    const S next = x + move, size = BS_ABS1(move);
    lo = left > 0 ? x : lo;
    hi = left > 0 ? hi : x;
    b->lo = lo, b->hi = hi;
    if (f == 0 || hi - lo <= tolerance || ++b->step == BS_ROOTS_STEPS)
        return 1;
    b->other = x, b->f_other = f, b->rate_other = rate;
    if (!(next > lo && next < hi && size <= K(0.5) * b->before)) {
        b->x = K(0.5) * (lo + hi), b->before = hi - lo;
        return 0;
    }
    b->x = next, b->before = size;
    if (size > BS_ROOTS_CLOSE(S))
        return 0;
    const S f_next = ROOTS(at)(d, next), last = -f_next / (rate * (K(1) + K(2) * bend * move)), rest = BS_ABS1(last);
    lo = b->side * f_next > 0 ? next : lo;
    hi = b->side * f_next > 0 ? hi : next;
    b->lo = lo, b->hi = hi;
    if (next + last >= lo && next + last <= hi) {
        b->x = next + last;
        if (K(3) * rest * rest <= tolerance * size)
            return 1;
    }
    return b->step > BS_ROOTS_PATIENCE && BS_ABS1(f_next) <= BS_ROOTS_UNIT(S) * ROOTS_BOUND(d, next, K(1) - next);
}

/* The root between lo and hi, where f has unlike signs, and where to begin. */
BS_OUTLINED S ROOTS(refine)(const ROOTS_DATA *d, S lo, S f_lo, S hi, S f_hi, S guess)
{
    ROOTS(bracket) b = ROOTS(begin)(lo, f_lo, hi, f_hi, guess);
    while (!ROOTS(advance)(&b, d))
        ;
    return b.x;
}

/* Append the roots of some brackets. In turns: they do not wait for one another. */
BS_INLINE void ROOTS(finish)(ROOTS(search) *s, ROOTS(bracket) *brackets, int count)
{
    int done[2] = {count < 1, count < 2};
    while (!(done[0] & done[1]))
        for (int i = 0; i < count; i++)
            if (!done[i])
                done[i] = ROOTS(advance)(&brackets[i], s->data);
    for (int i = 0; i < count; i++)
        ROOTS(append)(s, brackets[i].x);
}

/* f has like signs at lo and hi. If it comes nearer to zero from both ends: one root if it touches zero between, two if
   it crosses, by where its derivative vanishes: known to full accuracy where roots are not. 0 if it does not. */
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
    /* of places inside perhaps only the sign is known yet */
    const S f_lo = run->lo > begin ? ROOTS(at)(s->data, run->lo) : run->f_lo;
    const S f_hi = run->hi < end ? ROOTS(at)(s->data, run->hi) : run->f_hi;
    S x = run->lo, f = f_lo;
    int zeros = 0;
    (void)c;
    if (!(run->hi - run->lo > BS_ROOTS_SHORT(S))) {
        if (!ROOTS(between)(s, run->lo, f_lo, run->hi, f_hi)) {
            const int first = BS_ABS1(f_lo) < BS_ABS1(f_hi);
            x = first ? run->lo : run->hi;
            if (ROOTS(touches)(s->data, x, first ? f_lo : f_hi))
                ROOTS(append)(s, x);
        }
        return;
    }
    for (int i = 1; i <= BS_ROOTS_PROBES; i++) {
        const S lo = x, before = f;
        x = i < BS_ROOTS_PROBES ? run->lo + (run->hi - run->lo) * (K(i) / K(BS_ROOTS_PROBES)) : run->hi;
        f = i < BS_ROOTS_PROBES ? ROOTS(at)(s->data, x) : f_hi;
        zeros += ROOTS(touches)(s->data, x, f);
        ROOTS(between)(s, lo, before, x, f);
    }
    s->vanishes = s->vanishes || zeros == BS_ROOTS_PROBES;
}

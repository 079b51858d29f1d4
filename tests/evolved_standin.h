/* The kernels that evolved.h asks for, by hand, and batches of them: for tests and benchmarks only. Included between
   instance.h and the next instance. */

BS_INLINE void FN(times)(S *out, const S *p, int n, const S *q, int m)
{
    for (int i = 0; i <= n + m; i++)
        out[i] = 0;
    for (int i = 0; i <= n; i++)
        for (int j = 0; j <= m; j++)
            out[i + j] += p[i] * q[j];
}

BS_INLINE void FN(evolved_octic)(S *out, const S *ray, const S *surface)
{
    const S s0[3] = {1, surface[0], 1}, *u = ray, *x = ray + 3, *e = ray + 6, kappa = surface[1];
    S p[5], q[5], d[3], dd[5];
    FN(times)(p, s0, 2, u, 2);
    FN(times)(q, s0, 2, e, 2);
    for (int i = 0; i < 3; i++)
        p[i + 1] -= x[i], q[i + 1] -= kappa * x[i], d[i] = kappa * u[i] - e[i];
    FN(times)(out, p, 4, q, 4);
    FN(times)(dd, d, 2, d, 2);
    for (int i = 0; i < 9; i++)
        out[i] = 4 * out[i] + (i >= 2 && i <= 6 ? dd[i - 2] : K(0));
}

BS_INLINE S FN(standin)(const S *ray, const S *surface, S a, S b, int whole)
{
    const S ab = a * b, aa = a * a, bb = b * b, s0 = aa + bb + ab * surface[0], quad = surface[1] * (ab * ab);
    const S square = s0 * s0 - quad, s = BS_SQRT1(square > 0 ? square : K(0));
    const S t = s0 >= 0 ? s0 + s : -quad / (s - s0);
    const S u = ray[0] * bb + ray[1] * ab + ray[2] * aa, x = ray[3] * bb + ray[4] * ab + ray[5] * aa;
    const S e = ray[6] * bb + ray[7] * ab + ray[8] * aa, f = t * (t * u - 2 * ab * x) + ab * ab * e;
    return whole ? f / (2 * (s * s) * t) : f;
}

BS_INLINE S FN(evolved_octic_bound)(const S *ray, const S *surface, S a, S b)
{
    const S kappa = BS_ABS1(surface[1]), ab = a * b, s0 = a * a + b * b + ab * BS_ABS1(surface[0]);
    S q[3];
    for (int i = 0; i < 3; i++)
        q[i] = BS_ABS1(ray[3 * i]) * (b * b) + BS_ABS1(ray[3 * i + 1]) * ab + BS_ABS1(ray[3 * i + 2]) * (a * a);
    const S last = ab * (kappa * q[0] + q[2]);
    return 4 * (s0 * q[0] + ab * q[1]) * (s0 * q[2] + kappa * ab * q[1]) + last * last;
}

BS_INLINE S FN(evolved_condition)(const S *ray, const S *surface, S a, S b)
{
    return FN(standin)(ray, surface, a, b, 0);
}

BS_INLINE S FN(evolved_meet_square)(const S *ray, const S *surface, S a, S b)
{
    return FN(standin)(ray, surface, a, b, 1);
}

BS_INLINE void FN(powers)(S *out, const S *q)
{
    out[0] = q[0], out[1] = q[1] - 2 * q[0], out[2] = q[0] - q[1] + q[2];
}

/* (P.P + D u)^2 - 4 D (P.B)^2 with P = S0 B - a b E, by powers of a from the start. */
BS_INLINE void FN(evolved_dodecic)(S *out, const S *ray, const S *surface)
{
    const S ends[3] = {1, surface[0], 1}, ab[3] = {0, 1, -1};
    S s0[3], u[3], x[3], e[3], ss[5], qq[5], sq[5], d[5], even[7], term[7], odd[5], square[9], p[13];
    FN(powers)(s0, ends), FN(powers)(u, ray), FN(powers)(x, ray + 3), FN(powers)(e, ray + 6);
    FN(times)(ss, s0, 2, s0, 2), FN(times)(qq, ab, 2, ab, 2), FN(times)(sq, s0, 2, ab, 2);
    for (int i = 0; i < 5; i++)
        d[i] = ss[i] - surface[1] * qq[i], ss[i] += d[i];
    FN(times)(even, ss, 4, u, 2), FN(times)(term, sq, 4, x, 2);
    for (int i = 0; i < 7; i++)
        even[i] -= 2 * term[i];
    FN(times)(term, qq, 4, e, 2), FN(times)(odd, s0, 2, u, 2), FN(times)(qq, ab, 2, x, 2);
    for (int i = 0; i < 7; i++)
        even[i] += term[i];
    for (int i = 0; i < 5; i++)
        odd[i] -= qq[i];
    FN(times)(square, odd, 4, odd, 4), FN(times)(p, square, 8, d, 4), FN(times)(out, even, 6, even, 6);
    for (int i = 0; i < 13; i++)
        out[i] -= 4 * p[i];
}

#include "evolved.h"

void FN(many)(int method, int samples, int most, int n, const S *rays, const S *surfaces, S *roots, int *counts)
{
    for (int i = 0; i < n; i++) {
        const S *ray = rays + 9 * i, *surface = surfaces + 2 * i;
        S *out = roots + 8 * i;
        counts[i] = method == 0   ? FN(evolved_isolate)(out, most, ray, surface)
                    : method == 1 ? FN(evolved_companion)(out, most, ray, surface)
                                  : FN(evolved_sampled)(out, most, ray, surface, samples);
    }
}

void FN(dodecics)(int n, const S *rays, const S *surfaces, S *powers)
{
    for (int i = 0; i < n; i++)
        FN(evolved_dodecic)(powers + 13 * i, rays + 9 * i, surfaces + 2 * i);
}

int FN(eigenvalues)(int n, const S *powers, S *re, S *im)
{
    return FN(companion_roots)(re, im, powers, n);
}

S FN(value)(int which, const S *ray, const S *surface, S a)
{
    return which ? FN(evolved_meet_square)(ray, surface, a, 1 - a) : FN(evolved_condition)(ray, surface, a, 1 - a);
}

#include "instance_end.h"

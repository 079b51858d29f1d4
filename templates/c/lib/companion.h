/* All roots of a polynomial as the eigenvalues of its companion matrix: balancing, then QR steps with two implicit
   shifts on the Hessenberg form, eigenvalues only. The printed method's solver, as numpy.roots has it from LAPACK.
   No guard: one inclusion makes one instance, for the scalar type S. Define before including (undefined at the end):
     COMPANION(name)         the instance's names, e.g. FN(evolved_##name)
     BS_COMPANION_DEGREE     the highest degree */

#ifndef BS_COMPANION_CONSTANTS
#define BS_COMPANION_CONSTANTS
/* PATIENCE: QR steps for one eigenvalue before giving up; after FRESH steps without success the shift changes. */
enum { BS_COMPANION_PATIENCE = 60, BS_COMPANION_FRESH = 10 };
#define BS_COMPANION_UNIT(T) ((T)(sizeof(T) == 4 ? 1.1920928955078125e-7 : 2.220446049250313e-16))
/* A shift that is no eigenvalue of a corner of the matrix, relative to its last two subdiagonal entries. */
#define BS_COMPANION_SHIFT 1.5
#endif

typedef struct {
    S m[BS_COMPANION_DEGREE][BS_COMPANION_DEGREE]; /* upper Hessenberg */
    S shift;                                       /* taken off the whole diagonal so far */
} COMPANION(matrix);

/* Scale rows and columns by powers of two until their sums of absolute values are within a factor of two. */
BS_INLINE void COMPANION(balance)(COMPANION(matrix) *h, int n)
{
    for (int changed = 1; changed;) {
        changed = 0;
        for (int i = 0; i < n; i++) {
            S column = 0, row = 0, f = 1;
            for (int j = 0; j < n; j++) {
                column += j == i ? 0 : BS_ABS1(h->m[j][i]);
                row += j == i ? 0 : BS_ABS1(h->m[i][j]);
            }
            const S before = column + row;
            if (!(column > 0 && row > 0 && before - before == 0))
                continue;
            for (; column < row * K(0.5); f *= K(2))
                column *= K(2), row *= K(0.5);
            for (; column >= row * K(2); f *= K(0.5))
                column *= K(0.5), row *= K(2);
            if (!(column + row < K(0.95) * before))
                continue;
            changed = 1;
            for (int j = 0; j < n; j++)
                h->m[i][j] /= f;
            for (int j = 0; j < n; j++)
                h->m[j][i] *= f;
        }
    }
}

/* One sweep over rows first .. last; sum and product of the two shifts. */
BS_INLINE void COMPANION(sweep)(COMPANION(matrix) *h, int first, int last, S sum, S product)
{
    S(*m)[BS_COMPANION_DEGREE] = h->m;
    /* First column of (H - s1)(H - s2). */
    S p = m[first][first] * (m[first][first] - sum) + m[first][first + 1] * m[first + 1][first] + product;
    S q = m[first + 1][first] * (m[first][first] + m[first + 1][first + 1] - sum);
    S r = m[first + 1][first] * m[first + 2][first + 1];
    for (int k = first; k < last; k++) {
        const int three = k < last - 1;
        if (k > first) {
            p = m[k][k - 1], q = m[k + 1][k - 1];
            r = three ? m[k + 2][k - 1] : K(0);
        }
        const S size = BS_ABS1(p) + BS_ABS1(q) + BS_ABS1(r);
        if (size == 0)
            continue;
        p /= size, q /= size, r /= size;
        /* The reflection 1 - v w^T that maps (p, q, r) to (-norm, 0, 0). */
        const S root = BS_SQRT1(p * p + q * q + r * r), norm = p < 0 ? -root : root;
        const S v1 = q / (p + norm), v2 = r / (p + norm);
        const S w0 = (p + norm) / norm, w1 = q / norm, w2 = r / norm;
        if (k > first) {
            m[k][k - 1] = -norm * size;
            m[k + 1][k - 1] = 0;
            if (three)
                m[k + 2][k - 1] = 0;
        }
        for (int j = k; j <= last; j++) {
            const S dot = m[k][j] + v1 * m[k + 1][j] + (three ? v2 * m[k + 2][j] : K(0));
            m[k][j] -= dot * w0, m[k + 1][j] -= dot * w1;
            if (three)
                m[k + 2][j] -= dot * w2;
        }
        const int low = k + 3 < last ? k + 3 : last;
        for (int i = first; i <= low; i++) {
            const S dot = w0 * m[i][k] + w1 * m[i][k + 1] + (three ? w2 * m[i][k + 2] : K(0));
            m[i][k] -= dot, m[i][k + 1] -= dot * v1;
            if (three)
                m[i][k + 2] -= dot * v2;
        }
    }
}

/* Real and imaginary parts of the eigenvalues; returns how many were found (all but never fewer than n). */
BS_INLINE int COMPANION(eigenvalues)(S *re, S *im, COMPANION(matrix) *h, int n)
{
    S(*m)[BS_COMPANION_DEGREE] = h->m;
    int found = 0, last = n - 1, steps = 0;
    while (last >= 0) {
        int first = last;
        for (; first > 0; first--) {
            const S near = BS_ABS1(m[first][first]) + BS_ABS1(m[first - 1][first - 1]);
            if (BS_ABS1(m[first][first - 1]) <= BS_COMPANION_UNIT(S) * near)
                break;
        }
        if (first == last) {
            re[found] = m[last][last] + h->shift, im[found++] = 0;
            last--, steps = 0;
            continue;
        }
        S sum = m[last][last] + m[last - 1][last - 1];
        S product = m[last][last] * m[last - 1][last - 1] - m[last][last - 1] * m[last - 1][last];
        if (first == last - 1) {
            const S half = K(0.5) * (m[last - 1][last - 1] - m[last][last]), mean = K(0.5) * sum + h->shift;
            const S square = half * half + m[last][last - 1] * m[last - 1][last];
            const S root = BS_SQRT1(square < 0 ? -square : square);
            /* Real: distances from the last diagonal entry, the larger one, and the other from their product. */
            const S far = half < 0 ? half - root : half + root, apart = m[last][last - 1] * m[last - 1][last];
            const S near = far == 0 ? K(0) : -apart / far, base = m[last][last] + h->shift;
            re[found] = square < 0 ? mean : base + far, im[found++] = square < 0 ? root : K(0);
            re[found] = square < 0 ? mean : base + near, im[found++] = square < 0 ? -root : K(0);
            last -= 2, steps = 0;
            continue;
        }
        if (++steps > BS_COMPANION_PATIENCE)
            break;
        if (steps % BS_COMPANION_FRESH == 0) {
            const S off = BS_ABS1(m[last][last - 1]) + BS_ABS1(m[last - 1][last - 2]);
            for (int i = 0; i <= last; i++)
                m[i][i] -= m[last][last] * (i < last ? K(1) : K(0));
            h->shift += m[last][last];
            m[last][last] = 0;
            sum = K(BS_COMPANION_SHIFT) * off, product = off * off;
        }
        COMPANION(sweep)(h, first, last, sum, product);
    }
    return found;
}

/* Roots of the sum of powers[k] x^k up to degree n <= 12. Returns their number, which is less than n if the highest
   powers are missing, or if the iteration does not end. */
BS_INLINE int COMPANION(roots)(S *re, S *im, const S *powers, int n)
{
    COMPANION(matrix) h;
    while (n > 0 && powers[n] == 0)
        n--;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            h.m[i][j] = i == 0 ? -powers[n - 1 - j] / powers[n] : K(i == j + 1);
    h.shift = 0;
    COMPANION(balance)(&h, n);
    return COMPANION(eigenvalues)(re, im, &h, n);
}

#undef COMPANION
#undef BS_COMPANION_DEGREE

/* Batches of evolved.h on given scalars, without a scene: for tests and benchmarks only. Included between instance.h
   and the next instance, after kernels.h, under what evolved.h asks for. */

#define BS_OUTLINED static __attribute__((noinline, unused))
#define BS_FAR K(BS_BITS == 64 ? 1.7976931348623157e308 : 3.4028234663852886e38)
#define EVOLVED(name) FN(BS_PASTE(BS_MEMBER, name))
#define KERNEL(name) FN(BS_PASTE(cga3d_##name, BS_SUFFIX))
#include "evolved.h"

static EVOLVED(problem) EVOLVED(asked)(const S *ray, const S *row)
{
    EVOLVED(problem) problem;
    problem.meets = ray, problem.k = row;
    problem.origin = ray + EVOLVED_MEETS, problem.direction = problem.origin + 3;
    return problem;
}

/* Roots of many rays and surfaces (rows of constants): rows of a ray's meets, then its origin and direction. */
void EVOLVED(many)(int method, int samples, int most, int n, const S *rays, const S *rows, S *roots, int *counts)
{
    for (int i = 0; i < n; i++) {
        EVOLVED(problem) problem = EVOLVED(asked)(rays + (EVOLVED_MEETS + 6) * i, rows + (EVOLVED_SIZES + 2) * i);
        S *out = roots + EVOLVED_ROOTS * i;
        counts[i] = method == 0   ? EVOLVED(isolate)(out, most, &problem, 1)
                    : method == 1 ? EVOLVED(companion)(out, most, &problem)
                                  : EVOLVED(sampled)(out, most, &problem, samples);
    }
}

void EVOLVED(printed)(int n, const S *rays, const S *rows, S *powers)
{
    for (int i = 0; i < n; i++) {
        const S *row = rows + (EVOLVED_SIZES + 2) * i;
        KERNEL(evolved_published_polynomial)(powers + (EVOLVED_PRINTED + 1) * i, rays + (EVOLVED_MEETS + 6) * i, row + EVOLVED_NORM,
                                row + EVOLVED_KAPPA);
    }
}

int EVOLVED(eigenvalues)(int n, const S *powers, S *re, S *im)
{
    return EVOLVED(companion_roots)(re, im, powers, n);
}

/* f itself, the condition and its derivative, and the bound of its terms. */
void EVOLVED(values)(const S *ray, const S *row, S t, S *square_f_rate_bound)
{
    const EVOLVED(problem) problem = EVOLVED(asked)(ray, row);
    square_f_rate_bound[0] = EVOLVED(meet_square)(&problem, t);
    EVOLVED(condition_rate)(square_f_rate_bound + 1, &problem, t, K(1) - t);
    square_f_rate_bound[3] = EVOLVED(condition_bound)(&problem, t, K(1) - t);
}

#undef EVOLVED
#undef KERNEL
#undef EVOLVED_QUAD
#undef EVOLVED_CENTER
#undef EVOLVED_UNIT
#undef EVOLVED_START
#undef EVOLVED_BOUND
#undef EVOLVED_REAL
#undef EVOLVED_NORM
#undef EVOLVED_KAPPA
#undef EVOLVED_CONTROLS
#undef EVOLVED_PRODUCTS
#undef EVOLVED_SIZES
#undef EVOLVED_MEETS
#undef EVOLVED_ROOTS
#undef EVOLVED_PRINTED
#undef BS_OUTLINED
#undef BS_FAR
#undef BS_MEMBER
#undef BS_SUFFIX
#undef BS_DEGREE
#undef BS_FREE
#include "instance_end.h"

/* Batches of the finders of roots on given scalars, without a scene: for tests and benchmarks only. Included between
   instance.h and the next instance, after the kernels and the finders of a kind of surface. */

#define EVOLVED(name) FN(BS_PASTE(BS_MEMBER, name))
#define FINDER(name) FN(BS_PASTE(name, BS_MEMBER))
#define KERNEL(name) FN(BS_PASTE(cga3d_##name, BS_SUFFIX))

/* Roots of many rays and surfaces (rows of constants): rows of a ray's meets, then its origin and direction. */
void EVOLVED(many)(int method, int samples, int most, int n, const S *rays, const S *rows, S *roots, int *counts)
{
    for (int i = 0; i < n; i++) {
        S ray[BS_RAY], *out = roots + BS_ROOTS * i;
        const S *row = rows + BS_ROW * i;
        for (int k = 0; k < BS_GIVEN; k++)
            ray[k] = rays[BS_GIVEN * i + k];
        counts[i] = (int)(method == 0   ? FINDER(isolated)(ray, row, 1, out, most)
                          : method == 1 ? FINDER(companion)(ray, row, out, most)
                                        : FINDER(sampled)(ray, row, samples, out, most));
    }
}

void EVOLVED(printed)(int n, const S *rays, const S *rows, S *powers)
{
    for (int i = 0; i < n; i++) {
        const S *row = rows + BS_ROW * i;
        KERNEL(evolved_published_polynomial)(powers + (BS_PRINTED + 1) * i, rays + BS_GIVEN * i, row + BS_NORM, row + BS_KAPPA);
    }
}

int EVOLVED(eigenvalues)(int n, const S *powers, S *re, S *im)
{
    return (int)FN(BS_PASTE(polynomial_roots, BS_PRINTED))(powers, n, re, im);
}

/* f itself, the condition and its derivative, and the bound of its terms. */
void EVOLVED(values)(const S *ray, const S *row, S t, S *square_f_rate_bound)
{
    square_f_rate_bound[0] = FINDER(meet)(ray, row, t);
    FINDER(condition_rate)(ray, row, t, K(1) - t, square_f_rate_bound + 1);
    square_f_rate_bound[3] = FINDER(condition_bound)(ray, row, t, K(1) - t);
}

#undef EVOLVED
#undef FINDER
#undef KERNEL
#include "instance_end.h"

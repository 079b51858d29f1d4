/* bladesmith: recurrences of Taylor coefficients. Coefficient k of a function from coefficients 0 to k of its arguments
   and those before k of itself, each series in one piece. See codegen/targets/c/taylor.py.
   Functions are those of elementary.h. */

#if BS_VECTORS
typedef double FN(lanes_base) __attribute__((vector_size(16), aligned(8), may_alias));
typedef double FN(lanes_wide) __attribute__((vector_size(32), aligned(8), may_alias));
#endif
typedef double FN(lanes_plain);

/* Sum of x_j y_(k - j) for j from one to another, both included. */
BS_INLINE double FN(convolved)(int k, int from, int to, const double *x, const double *y)
{
  double sum = 0;
  for (int j = from; j <= to; j++) sum += x[j] * y[k - j];
  return sum;
}

/* Sum of j x_j y_(k - j)/k likewise: the integral of x' y. */
BS_INLINE double FN(integrated)(int k, int from, int to, const double *x, const double *y)
{
  double sum = 0;
  for (int j = from; j <= to; j++) sum += j * x[j] * y[k - j];
  return sum / k;
}

/* y x = 1. */
BS_INLINE void FN(series_reciprocal)(int k, const double *x, double *y)
{
  y[k] = k ? -FN(convolved)(k, 1, k, x, y) * y[0] : 1 / x[0];
}

/* y y = x. */
BS_INLINE void FN(series_sqrt)(int k, const double *x, double *y)
{
  y[k] = k ? (x[k] - FN(convolved)(k, 1, k - 1, y, y)) / (2 * y[0]) : SQRT(x[0]);
}

/* y' = x' y. */
BS_INLINE void FN(series_exp)(int k, const double *x, double *y)
{
  y[k] = k ? FN(integrated)(k, 1, k, x, y) : EXP(x[0]);
}

/* y' x = x'. */
BS_INLINE void FN(series_log)(int k, const double *x, double *y)
{
  y[k] = k ? (x[k] - FN(integrated)(k, 1, k - 1, y, x)) / x[0] : LOG(x[0]);
}

/* s' = x' c, c' = -x' s. */
BS_INLINE void FN(series_sin_cos)(int k, const double *x, double *s, double *c)
{
  const double sine = k ? FN(integrated)(k, 1, k, x, c) : SIN(x[0]);
  c[k] = k ? -FN(integrated)(k, 1, k, x, s) : COS(x[0]);
  s[k] = sine;
}

/* a' (x x + y y) = x y' - y x'; square: room for x x + y y, and for two rows in all. */
BS_INLINE void FN(series_atan2)(int k, const double *y, const double *x, double *square, double *a)
{
  square[k] = FN(convolved)(k, 0, k, x, x) + FN(convolved)(k, 0, k, y, y);
  if (!k) {
    a[0] = ATAN2(y[0], x[0]);
    return;
  }
  a[k] = (FN(integrated)(k, 1, k, y, x) - FN(integrated)(k, 1, k, x, y) - FN(integrated)(k, 1, k - 1, a, square)) / square[0];
}

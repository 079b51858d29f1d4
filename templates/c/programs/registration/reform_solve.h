/* The motor that makes a quadratic form least: |R X - Y R|^2 summed over pairs, R = q + q' with q of n_inf free.
   Linear algebra only: q' is eliminated, q is the eigenvector of the least eigenvalue of what is left. */

enum { BS_FORM = 36, BS_MOTOR = 8, BS_HALF = 4, BS_SWEEPS = 12, BS_NUMBERS = 7, BS_RATES = 28, BS_AXES = 3 };
/* What is added to the eliminated part, relative to its size: flats leave one direction of it free. */
#define BS_FREE 1e-14

/* Cholesky factor of a symmetric positive 4 x 4 matrix in its lower half. */
BS_INLINE void FN(cholesky)(S a[4][4])
{
  for (int j = 0; j < BS_HALF; j++) {
    for (int k = 0; k < j; k++) a[j][j] -= a[j][k] * a[j][k];
    a[j][j] = BS_SQRT1(a[j][j] > 0 ? a[j][j] : K(0));
    const S inverse = a[j][j] > 0 ? K(1) / a[j][j] : K(0);
    for (int i = j + 1; i < BS_HALF; i++) {
      for (int k = 0; k < j; k++) a[i][j] -= a[i][k] * a[j][k];
      a[i][j] *= inverse;
    }
  }
}

/* b becomes (factor factor^T)^-1 b; only_half: factor^-1 b. */
BS_INLINE void FN(substitute)(S factor[4][4], S *b, int only_half)
{
  for (int i = 0; i < BS_HALF; i++) {
    for (int k = 0; k < i; k++) b[i] -= factor[i][k] * b[k];
    b[i] = factor[i][i] > 0 ? b[i] / factor[i][i] : K(0);
  }
  for (int i = BS_HALF - 1; i >= 0 && !only_half; i--) {
    for (int k = i + 1; k < BS_HALF; k++) b[i] -= factor[k][i] * b[k];
    b[i] = factor[i][i] > 0 ? b[i] / factor[i][i] : K(0);
  }
}

/* Eigenvalues of a symmetric n x n matrix on its diagonal, eigenvectors in the columns of v, by Jacobi's rotations. */
BS_INLINE void FN(jacobi)(S a[4][4], S v[4][4], int n)
{
  for (int p = 0; p < n; p++)
    for (int q = 0; q < n; q++) v[p][q] = p == q ? K(1) : K(0);
  for (int sweep = 0; sweep < BS_SWEEPS; sweep++) {
    S off = 0, on = 0;
    for (int p = 0; p < n; p++) {
      on += a[p][p] * a[p][p];
      for (int q = p + 1; q < n; q++) off += a[p][q] * a[p][q];
    }
    if (!(off > K(1e-34) * on)) break;
    for (int p = 0; p < n; p++) {
      for (int q = p + 1; q < n; q++) {
        if (!(BS_ABS1(a[p][q]) > 0)) continue;
        const S theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
        const S t = (theta < 0 ? K(-1) : K(1)) / (BS_ABS1(theta) + BS_SQRT1(theta * theta + 1));
        const S c = K(1) / BS_SQRT1(t * t + 1), s = t * c;
        for (int k = 0; k < n; k++) {
          const S kp = a[k][p], kq = a[k][q];
          a[k][p] = c * kp - s * kq, a[k][q] = s * kp + c * kq;
        }
        for (int k = 0; k < n; k++) {
          const S pk = a[p][k], qk = a[q][k], vp = v[k][p], vq = v[k][q];
          a[p][k] = c * pk - s * qk, a[q][k] = s * pk + c * qk;
          v[k][p] = c * vp - s * vq, v[k][q] = s * vp + c * vq;
        }
      }
    }
  }
}

/* Eigenvector of the least eigenvalue of a symmetric 4 x 4 matrix; gap: to the next one. */
BS_INLINE S FN(least_eigenvector)(S a[4][4], S *vector, S *gap)
{
  S v[4][4];
  FN(jacobi)(a, v, BS_HALF);
  int least = 0;
  for (int p = 1; p < BS_HALF; p++) least = a[p][p] < a[least][least] ? p : least;
  S next = K(BS_HUGE_VALUE);
  for (int p = 0; p < BS_HALF; p++) next = p != least && a[p][p] < next ? a[p][p] : next;
  for (int k = 0; k < BS_HALF; k++) vector[k] = v[k][least];
  *gap = next - a[least][least];
  return a[least][least];
}

/* The unit motor of least form, and the form there; negative if the form leaves the rotation free. */
BS_OUTLINED S FN(form_motor)(S *motor, const S *form)
{
  S outer[4][4], cross[4][4], inner[4][4], half[4][4], raw[8], whole[8], gap, trace = 0;
  for (int i = 0, k = 0; i < BS_MOTOR; i++)
    for (int j = i; j < BS_MOTOR; j++, k++) {
      if (j < BS_HALF) outer[i][j] = outer[j][i] = form[k];
      else if (i < BS_HALF) cross[i][j - BS_HALF] = form[k];
      else inner[i - BS_HALF][j - BS_HALF] = inner[j - BS_HALF][i - BS_HALF] = form[k];
    }
  for (int i = 0; i < BS_HALF; i++) trace += inner[i][i];
  for (int i = 0; i < BS_HALF; i++) inner[i][i] += K(BS_FREE) * trace;
  FN(cholesky)(inner);
  for (int i = 0; i < BS_HALF; i++) {
    for (int j = 0; j < BS_HALF; j++) half[i][j] = cross[i][j];
    FN(substitute)(inner, half[i], 1);
  }
  for (int i = 0; i < BS_HALF; i++)
    for (int j = 0; j < BS_HALF; j++)
      for (int k = 0; k < BS_HALF; k++) outer[i][j] -= half[i][k] * half[j][k];
  const S least = FN(least_eigenvector)(outer, raw, &gap);
  for (int i = 0; i < BS_HALF; i++) {
    raw[BS_HALF + i] = 0;
    for (int k = 0; k < BS_HALF; k++) raw[BS_HALF + i] -= cross[k][i] * raw[k];
  }
  FN(substitute)(inner, raw + BS_HALF, 0);
  for (int i = 0; i < BS_MOTOR; i++) whole[bs_motor_order[i]] = raw[i];
  FN(cga3d_near_motor)(motor, whole);
  return gap > K(1e-10) * trace ? (least > 0 ? least : K(0)) : K(-1);
}

/* Position, direction and radius of a unit object. */
BS_OUTLINED void FN(elements_all)(ptrdiff_t kind, const S *row, S element[BS_LENGTH(7)])
{
  if (kind == 0) {
    FN(cga3d_element_point)(element, row);
    return;
  }
  if (kind == 1) {
    FN(cga3d_element_point_pair)(element, row);
    return;
  }
  if (kind == 2) {
    FN(cga3d_element_line)(element, row);
    return;
  }
  if (kind == 3) {
    FN(cga3d_element_line)(element, row);
    return;
  }
  if (kind == 4) {
    FN(cga3d_element_circle)(element, row);
    return;
  }
  if (kind == 5) {
    FN(cga3d_element_plane)(element, row);
    return;
  }
  if (kind == 6) {
    FN(cga3d_element_sphere)(element, row);
    return;
  }
}

/* Coefficients of an object in a frame at an origin. */
BS_OUTLINED void FN(to_frame_all)(ptrdiff_t kind, const S *row, const S origin[BS_LENGTH(3)], S *found)
{
  if (kind == 0) {
    FN(cga3d_seen_point)(found, row, origin);
    return;
  }
  if (kind == 1) {
    FN(cga3d_seen_point_pair)(found, row, origin);
    return;
  }
  if (kind == 2) {
    FN(cga3d_seen_line)(found, row, origin);
    return;
  }
  if (kind == 3) {
    FN(cga3d_seen_line)(found, row, origin);
    return;
  }
  if (kind == 4) {
    FN(cga3d_seen_circle)(found, row, origin);
    return;
  }
  if (kind == 5) {
    FN(cga3d_seen_plane)(found, row, origin);
    return;
  }
  if (kind == 6) {
    FN(cga3d_seen_sphere)(found, row, origin);
    return;
  }
}

/* Weighted square of how far two elements of a kind are apart. */
BS_OUTLINED S FN(squared_distances)(const S a[BS_LENGTH(7)], const S b[BS_LENGTH(7)], const S settings[BS_LENGTH(6)],
    const S directed[BS_LENGTH(1)])
{
  S row[1];
  S row1[1];
  FN(cga3d_apart)(row, row1, a, b, settings, directed, settings + 5);
  const S square = row[0];
  return square;
}

/* The motor of the world, of one from a frame at ``back`` to a frame at ``to``. */
BS_OUTLINED void FN(motors_to_world)(const S motor[BS_LENGTH(8)], const S to[BS_LENGTH(3)],
    const S back[BS_LENGTH(3)], S found[BS_LENGTH(8)])
{
  FN(cga3d_unseen)(found, motor, to, back);
}

/* The twist of the world, of one of a frame at an origin. */
BS_OUTLINED void FN(twists_to_world)(const S twist[BS_LENGTH(6)], const S origin[BS_LENGTH(3)], S found[BS_LENGTH(6)])
{
  FN(cga3d_unseen_twist)(found, twist, origin);
}

/* The motor next to (1 + twist) motor. */
BS_OUTLINED void FN(step)(const S motor[BS_LENGTH(8)], const S twist[BS_LENGTH(6)], S found[BS_LENGTH(8)])
{
  FN(cga3d_stepped)(found, motor, twist);
}

/* Invariants of a pair of objects by their rows; kinds in order. */
BS_OUTLINED void FN(invariants_all)(ptrdiff_t first_kind, ptrdiff_t second_kind, const S *first_rows,
    const S *second_rows, ptrdiff_t first, ptrdiff_t second, S found[BS_LENGTH(4)])
{
  ptrdiff_t x;
  ptrdiff_t y;
  if (first_kind == 0 && second_kind == 0) {
    x = 5 * first;
    y = 5 * second;
    FN(cga3d_invariants_point_point)(found, first_rows + x, second_rows + y);
    return;
  }
  if (first_kind == 0 && second_kind == 1) {
    x = 5 * first;
    y = 10 * second;
    FN(cga3d_invariants_point_point_pair)(found, first_rows + x, second_rows + y);
    return;
  }
  if (first_kind == 0 && second_kind == 2) {
    x = 5 * first;
    y = 6 * second;
    FN(cga3d_invariants_point_line)(found, first_rows + x, second_rows + y);
    return;
  }
  if (first_kind == 0 && second_kind == 3) {
    x = 5 * first;
    y = 6 * second;
    FN(cga3d_invariants_point_line)(found, first_rows + x, second_rows + y);
    return;
  }
  if (first_kind == 0 && second_kind == 4) {
    x = 5 * first;
    y = 10 * second;
    FN(cga3d_invariants_point_circle)(found, first_rows + x, second_rows + y);
    return;
  }
  if (first_kind == 0 && second_kind == 5) {
    x = 5 * first;
    y = 4 * second;
    FN(cga3d_invariants_point_plane)(found, first_rows + x, second_rows + y);
    return;
  }
  if (first_kind == 0 && second_kind == 6) {
    x = 5 * first;
    y = 5 * second;
    FN(cga3d_invariants_point_sphere)(found, first_rows + x, second_rows + y);
    return;
  }
  if (first_kind == 1 && second_kind == 1) {
    x = 10 * first;
    y = 10 * second;
    FN(cga3d_invariants_point_pair_point_pair)(found, first_rows + x, second_rows + y);
    return;
  }
  if (first_kind == 1 && second_kind == 2) {
    x = 10 * first;
    y = 6 * second;
    FN(cga3d_invariants_point_pair_line)(found, first_rows + x, second_rows + y);
    return;
  }
  if (first_kind == 1 && second_kind == 3) {
    x = 10 * first;
    y = 6 * second;
    FN(cga3d_invariants_point_pair_line)(found, first_rows + x, second_rows + y);
    return;
  }
  if (first_kind == 1 && second_kind == 4) {
    x = 10 * first;
    y = 10 * second;
    FN(cga3d_invariants_point_pair_circle)(found, first_rows + x, second_rows + y);
    return;
  }
  if (first_kind == 1 && second_kind == 5) {
    x = 10 * first;
    y = 4 * second;
    FN(cga3d_invariants_point_pair_plane)(found, first_rows + x, second_rows + y);
    return;
  }
  if (first_kind == 1 && second_kind == 6) {
    x = 10 * first;
    y = 5 * second;
    FN(cga3d_invariants_point_pair_sphere)(found, first_rows + x, second_rows + y);
    return;
  }
  if (first_kind == 2 && second_kind == 2) {
    x = 6 * first;
    y = 6 * second;
    FN(cga3d_invariants_line_line)(found, first_rows + x, second_rows + y);
    return;
  }
  if (first_kind == 2 && second_kind == 3) {
    x = 6 * first;
    y = 6 * second;
    FN(cga3d_invariants_line_line)(found, first_rows + x, second_rows + y);
    return;
  }
  if (first_kind == 2 && second_kind == 4) {
    x = 6 * first;
    y = 10 * second;
    FN(cga3d_invariants_line_circle)(found, first_rows + x, second_rows + y);
    return;
  }
  if (first_kind == 2 && second_kind == 5) {
    x = 6 * first;
    y = 4 * second;
    FN(cga3d_invariants_line_plane)(found, first_rows + x, second_rows + y);
    return;
  }
  if (first_kind == 2 && second_kind == 6) {
    x = 6 * first;
    y = 5 * second;
    FN(cga3d_invariants_line_sphere)(found, first_rows + x, second_rows + y);
    return;
  }
  if (first_kind == 3 && second_kind == 3) {
    x = 6 * first;
    y = 6 * second;
    FN(cga3d_invariants_line_line)(found, first_rows + x, second_rows + y);
    return;
  }
  if (first_kind == 3 && second_kind == 4) {
    x = 6 * first;
    y = 10 * second;
    FN(cga3d_invariants_line_circle)(found, first_rows + x, second_rows + y);
    return;
  }
  if (first_kind == 3 && second_kind == 5) {
    x = 6 * first;
    y = 4 * second;
    FN(cga3d_invariants_line_plane)(found, first_rows + x, second_rows + y);
    return;
  }
  if (first_kind == 3 && second_kind == 6) {
    x = 6 * first;
    y = 5 * second;
    FN(cga3d_invariants_line_sphere)(found, first_rows + x, second_rows + y);
    return;
  }
  if (first_kind == 4 && second_kind == 4) {
    x = 10 * first;
    y = 10 * second;
    FN(cga3d_invariants_circle_circle)(found, first_rows + x, second_rows + y);
    return;
  }
  if (first_kind == 4 && second_kind == 5) {
    x = 10 * first;
    y = 4 * second;
    FN(cga3d_invariants_circle_plane)(found, first_rows + x, second_rows + y);
    return;
  }
  if (first_kind == 4 && second_kind == 6) {
    x = 10 * first;
    y = 5 * second;
    FN(cga3d_invariants_circle_sphere)(found, first_rows + x, second_rows + y);
    return;
  }
  if (first_kind == 5 && second_kind == 5) {
    x = 4 * first;
    y = 4 * second;
    FN(cga3d_invariants_plane_plane)(found, first_rows + x, second_rows + y);
    return;
  }
  if (first_kind == 5 && second_kind == 6) {
    x = 4 * first;
    y = 5 * second;
    FN(cga3d_invariants_plane_sphere)(found, first_rows + x, second_rows + y);
    return;
  }
  if (first_kind == 6 && second_kind == 6) {
    x = 5 * first;
    y = 5 * second;
    FN(cga3d_invariants_sphere_sphere)(found, first_rows + x, second_rows + y);
    return;
  }
}

/* Invariants of an object with all others from a place on, each invariant in a row of its own. */
BS_OUTLINED void FN(invariants_of_all_all)(ptrdiff_t first_kind, ptrdiff_t second_kind, const S *first_rows,
    const S *second_rows, ptrdiff_t row, ptrdiff_t start, ptrdiff_t begin, const ptrdiff_t *second,
    ptrdiff_t second_count_, S *found, ptrdiff_t found_count_)
{
  const ptrdiff_t count = bs_quotient(found_count_, 4);
  S own[4];
  for (ptrdiff_t k = start; k < second_count_; k++) {
    FN(invariants_all)(first_kind, second_kind, first_rows, second_rows, row, second[k], own);
    for (ptrdiff_t j = 0; j < 4; j++) {
      found[j * count + begin + k - start] = own[j];
    }
  }
}

/* Cost of a match given by its rows, its gradient and its Gauss-Newton matrix by the twist. */
BS_OUTLINED void FN(rates_all)(ptrdiff_t kind, const S motor[BS_LENGTH(8)], ptrdiff_t query, ptrdiff_t reference,
    const ptrdiff_t *heads, const S *reals, S found[BS_LENGTH(28)])
{
  const ptrdiff_t x = heads[10 * kind + 1] + heads[10 * kind] * query;
  const ptrdiff_t y = heads[10 * kind + 2] + heads[10 * kind] * reference;
  if (kind == 0) {
    S row[6];
    S row1[21];
    FN(cga3d_rates_point)(found, row, row1, motor, reals + x, reals + y);
    for (ptrdiff_t k = 0; k < 6; k++) {
      found[1 + k] = row[k];
    }
    for (ptrdiff_t k1 = 0; k1 < 21; k1++) {
      found[7 + k1] = row1[k1];
    }
    return;
  }
  if (kind == 1) {
    S row2[6];
    S row3[21];
    FN(cga3d_rates_point_pair)(found, row2, row3, motor, reals + x, reals + y);
    for (ptrdiff_t k2 = 0; k2 < 6; k2++) {
      found[1 + k2] = row2[k2];
    }
    for (ptrdiff_t k3 = 0; k3 < 21; k3++) {
      found[7 + k3] = row3[k3];
    }
    return;
  }
  if (kind == 2) {
    S row4[6];
    S row5[21];
    FN(cga3d_rates_line)(found, row4, row5, motor, reals + x, reals + y);
    for (ptrdiff_t k4 = 0; k4 < 6; k4++) {
      found[1 + k4] = row4[k4];
    }
    for (ptrdiff_t k5 = 0; k5 < 21; k5++) {
      found[7 + k5] = row5[k5];
    }
    return;
  }
  if (kind == 3) {
    S row6[6];
    S row7[21];
    FN(cga3d_rates_line)(found, row6, row7, motor, reals + x, reals + y);
    for (ptrdiff_t k6 = 0; k6 < 6; k6++) {
      found[1 + k6] = row6[k6];
    }
    for (ptrdiff_t k7 = 0; k7 < 21; k7++) {
      found[7 + k7] = row7[k7];
    }
    return;
  }
  if (kind == 4) {
    S row8[6];
    S row9[21];
    FN(cga3d_rates_circle)(found, row8, row9, motor, reals + x, reals + y);
    for (ptrdiff_t k8 = 0; k8 < 6; k8++) {
      found[1 + k8] = row8[k8];
    }
    for (ptrdiff_t k9 = 0; k9 < 21; k9++) {
      found[7 + k9] = row9[k9];
    }
    return;
  }
  if (kind == 5) {
    S row10[6];
    S row11[21];
    FN(cga3d_rates_plane)(found, row10, row11, motor, reals + x, reals + y);
    for (ptrdiff_t k10 = 0; k10 < 6; k10++) {
      found[1 + k10] = row10[k10];
    }
    for (ptrdiff_t k11 = 0; k11 < 21; k11++) {
      found[7 + k11] = row11[k11];
    }
    return;
  }
  if (kind == 6) {
    S row12[6];
    S row13[21];
    FN(cga3d_rates_sphere)(found, row12, row13, motor, reals + x, reals + y);
    for (ptrdiff_t k12 = 0; k12 < 6; k12++) {
      found[1 + k12] = row12[k12];
    }
    for (ptrdiff_t k13 = 0; k13 < 21; k13++) {
      found[7 + k13] = row13[k13];
    }
    return;
  }
}

/* The form of motors that take x to y, where their coefficients begin. */
BS_OUTLINED void FN(motor_form_all)(ptrdiff_t kind, const S *reals, ptrdiff_t x, ptrdiff_t y,
    const S sign[BS_LENGTH(1)], S form[BS_LENGTH(36)])
{
  if (kind == 0) {
    FN(cga3d_form_point)(form, reals + x, reals + y, sign);
    return;
  }
  if (kind == 1) {
    FN(cga3d_form_point_pair)(form, reals + x, reals + y, sign);
    return;
  }
  if (kind == 2) {
    FN(cga3d_form_line)(form, reals + x, reals + y, sign);
    return;
  }
  if (kind == 3) {
    FN(cga3d_form_line)(form, reals + x, reals + y, sign);
    return;
  }
  if (kind == 4) {
    FN(cga3d_form_circle)(form, reals + x, reals + y, sign);
    return;
  }
  if (kind == 5) {
    FN(cga3d_form_plane)(form, reals + x, reals + y, sign);
    return;
  }
  if (kind == 6) {
    FN(cga3d_form_sphere)(form, reals + x, reals + y, sign);
    return;
  }
}

/* Add the form of motors that take x to y. */
BS_OUTLINED void FN(add_form_all)(ptrdiff_t kind, const S *reals, ptrdiff_t x, ptrdiff_t y,
    const S sign[BS_LENGTH(1)], S weight, S total[BS_LENGTH(36)])
{
  S form[36];
  FN(motor_form_all)(kind, reals, x, y, sign, form);
  for (ptrdiff_t k = 0; k < 36; k++) {
    total[k] = total[k] + weight * form[k];
  }
}

/* The least pivot of a form of twists: zero if a motion is free. */
BS_OUTLINED S FN(least_pivot)(const S form[BS_LENGTH(36)])
{
  S a[64];
  ptrdiff_t at = 0;
  for (ptrdiff_t p = 0; p < 8; p++) {
    for (ptrdiff_t q = p; q < 8; q++) {
      const S value = form[at];
      a[8 * p + q] = value;
      a[8 * q + p] = value;
      at = at + 1;
    }
  }
  ptrdiff_t left[6] = {0};
  for (ptrdiff_t p = 0; p < 6; p++) {
    left[p] = p + 1;
  }
  S least = K(BS_HUGE_VALUE);
  for (ptrdiff_t count = 6; count > 0; count--) {
    ptrdiff_t top = 0;
    for (ptrdiff_t p = 1; p < count; p++) {
      top = a[8 * left[p] + left[p]] > a[8 * left[top] + left[top]] ? p : top;
    }
    const ptrdiff_t t = left[top];
    const S pivot = a[8 * t + t];
    least = pivot < least ? pivot : least;
    if (!(pivot > K(0.0))) {
      return K(0.0);
    }
    left[top] = left[count - 1];
    for (ptrdiff_t p = 0; p < count - 1; p++) {
      for (ptrdiff_t q = 0; q < count - 1; q++) {
        a[8 * left[p] + left[q]] = a[8 * left[p] + left[q]] - a[8 * left[p] + t] * a[8 * t + left[q]] / pivot;
      }
    }
  }
  return least;
}

/* The least pivot of the form |B X - X B|^2 of twists of a set of query objects; kind -1 leaves one out. */
BS_OUTLINED S FN(stiffness_all)(const ptrdiff_t *set_kinds, ptrdiff_t set_kinds_count_, const ptrdiff_t *query,
    const ptrdiff_t *heads, const S *reals)
{
  S form[36] = {0};
  for (ptrdiff_t k = 0; k < set_kinds_count_; k++) {
    const ptrdiff_t kind = set_kinds[k];
    if (kind >= 0) {
      const ptrdiff_t x = heads[10 * kind + 1] + heads[10 * kind] * query[k];
      S row[1];
      row[0] = K(1.0);
      FN(add_form_all)(kind, reals, x, x, row, K(1.0), form);
    }
  }
  const S result = FN(least_pivot)(form);
  return result;
}

/* Cholesky factor of a symmetric positive semidefinite matrix, in its lower half. */
BS_OUTLINED void FN(cholesky_4x4)(S a[BS_LENGTH(16)])
{
  for (ptrdiff_t j = 0; j < 4; j++) {
    for (ptrdiff_t k = 0; k < j; k++) {
      a[4 * j + j] = a[4 * j + j] - a[4 * j + k] * a[4 * j + k];
    }
    a[4 * j + j] = SQRT(a[4 * j + j] > K(0.0) ? a[4 * j + j] : K(0.0));
    const S inverse = a[4 * j + j] > K(0.0) ? K(1.0) / a[4 * j + j] : K(0.0);
    for (ptrdiff_t i = j + 1; i < 4; i++) {
      for (ptrdiff_t k = 0; k < j; k++) {
        a[4 * i + j] = a[4 * i + j] - a[4 * i + k] * a[4 * j + k];
      }
      a[4 * i + j] = a[4 * i + j] * inverse;
    }
  }
}

/* Replace b by L^-1 b for a lower triangular matrix L; where L has a zero on its diagonal, by zero. */
BS_OUTLINED void FN(substitute_forward_4x4_4)(const S factor[BS_LENGTH(16)], S b[BS_LENGTH(4)])
{
  for (ptrdiff_t i = 0; i < 4; i++) {
    for (ptrdiff_t k = 0; k < i; k++) {
      b[i] = b[i] - factor[4 * i + k] * b[k];
    }
    b[i] = factor[4 * i + i] > K(0.0) ? b[i] / factor[4 * i + i] : K(0.0);
  }
}

/* Eigenvalues on the diagonal and eigenvectors in the columns of v, by cyclic Jacobi (Golub and Van Loan 8.5). */
BS_OUTLINED void FN(diagonalize_4x4_4x4_4)(S a[BS_LENGTH(16)], S v[BS_LENGTH(16)])
{
  for (ptrdiff_t p = 0; p < 4; p++) {
    for (ptrdiff_t q = 0; q < 4; q++) {
      v[4 * p + q] = p == q ? K(1.0) : K(0.0);
    }
  }
  for (ptrdiff_t __ = 0; __ < 12; __++) {
    S off = K(0.0);
    S on = K(0.0);
    for (ptrdiff_t p = 0; p < 4; p++) {
      on = on + a[4 * p + p] * a[4 * p + p];
      for (ptrdiff_t q = p + 1; q < 4; q++) {
        off = off + a[4 * p + q] * a[4 * p + q];
      }
    }
    if (!(off > K(1e-34) * on)) {
      break;
    }
    for (ptrdiff_t p = 0; p < 4; p++) {
      for (ptrdiff_t q = p + 1; q < 4; q++) {
        if (!(ABS(a[4 * p + q]) > K(0.0))) {
          continue;
        }
        const S theta = (a[4 * q + q] - a[4 * p + p]) / (K(2.0) * a[4 * p + q]);
        const S t = (theta < K(0.0) ? K(-1.0) : K(1.0)) / (ABS(theta) + SQRT(theta * theta + K(1.0)));
        const S c = K(1.0) / SQRT(t * t + K(1.0));
        const S s = t * c;
        for (ptrdiff_t k = 0; k < 4; k++) {
          const S kp = a[4 * k + p];
          const S kq = a[4 * k + q];
          a[4 * k + p] = c * kp - s * kq;
          a[4 * k + q] = s * kp + c * kq;
        }
        for (ptrdiff_t k = 0; k < 4; k++) {
          const S pk = a[4 * p + k];
          const S qk = a[4 * q + k];
          const S vp = v[4 * k + p];
          const S vq = v[4 * k + q];
          a[4 * p + k] = c * pk - s * qk;
          a[4 * q + k] = s * pk + c * qk;
          v[4 * k + p] = c * vp - s * vq;
          v[4 * k + q] = s * vp + c * vq;
        }
      }
    }
  }
}

/* Eigenvector of the least eigenvalue of a symmetric matrix; that value, and the distance to the next one. */
BS_OUTLINED void FN(least_eigenvector)(S a[BS_LENGTH(16)], S vector[BS_LENGTH(4)], S *result0_, S *result1_)
{
  S v[16];
  FN(diagonalize_4x4_4x4_4)(a, v);
  ptrdiff_t least = 0;
  for (ptrdiff_t p = 1; p < 4; p++) {
    least = a[4 * p + p] < a[4 * least + least] ? p : least;
  }
  S following = K(BS_HUGE_VALUE);
  for (ptrdiff_t p = 0; p < 4; p++) {
    following = p != least && a[4 * p + p] < following ? a[4 * p + p] : following;
  }
  for (ptrdiff_t k = 0; k < 4; k++) {
    vector[k] = v[4 * k + least];
  }
  *result0_ = a[4 * least + least];
  *result1_ = following - a[4 * least + least];
  return;
}

/* Replace b by L^-T b for a lower triangular matrix L; where L has a zero on its diagonal, by zero. */
BS_OUTLINED void FN(substitute_backward_4x4_4)(const S factor[BS_LENGTH(16)], S b[BS_LENGTH(4)])
{
  for (ptrdiff_t i = 3; i > -1; i--) {
    for (ptrdiff_t k = i + 1; k < 4; k++) {
      b[i] = b[i] - factor[4 * k + i] * b[k];
    }
    b[i] = factor[4 * i + i] > K(0.0) ? b[i] / factor[4 * i + i] : K(0.0);
  }
}

/* Replace b by (L L^T)^-1 b. */
BS_OUTLINED void FN(solve_cholesky_4x4_4)(const S factor[BS_LENGTH(16)], S b[BS_LENGTH(4)])
{
  FN(substitute_forward_4x4_4)(factor, b);
  FN(substitute_backward_4x4_4)(factor, b);
}

/* Where a form is least for a unit q, as q and q', and the form there; negative if it leaves the rotation free. */
BS_OUTLINED S FN(minimize_form)(const S form[BS_LENGTH(36)], S minimizer[BS_LENGTH(8)])
{
  S outer[16];
  S cross[16];
  S inner[16];
  ptrdiff_t at = 0;
  for (ptrdiff_t i = 0; i < 8; i++) {
    for (ptrdiff_t j = i; j < 8; j++) {
      if (j < 4) {
        const S value = form[at];
        outer[4 * i + j] = value;
        outer[4 * j + i] = value;
      } else {
        if (i < 4) {
          cross[4 * i + (j - 4)] = form[at];
        } else {
          const S value1 = form[at];
          inner[4 * (i - 4) + (j - 4)] = value1;
          inner[4 * (j - 4) + (i - 4)] = value1;
        }
      }
      at = at + 1;
    }
  }
  S trace = K(0.0);
  for (ptrdiff_t i = 0; i < 4; i++) {
    trace = trace + inner[4 * i + i];
  }
  for (ptrdiff_t i = 0; i < 4; i++) {
    inner[4 * i + i] = inner[4 * i + i] + K(1e-14) * trace;
  }
  FN(cholesky_4x4)(inner);
  S reduced[16];
  for (ptrdiff_t i = 0; i < 4; i++) {
    for (ptrdiff_t k1 = 0; k1 < 4; k1++) {
      reduced[4 * i + k1] = cross[4 * i + k1];
    }
    FN(substitute_forward_4x4_4)(inner, reduced + 4 * i);
  }
  for (ptrdiff_t i = 0; i < 4; i++) {
    for (ptrdiff_t j = 0; j < 4; j++) {
      for (ptrdiff_t k = 0; k < 4; k++) {
        outer[4 * i + j] = outer[4 * i + j] - reduced[4 * i + k] * reduced[4 * j + k];
      }
    }
  }
  S result;
  S result1;
  FN(least_eigenvector)(outer, minimizer, &result, &result1);
  const S least = result;
  const S gap = result1;
  for (ptrdiff_t i = 0; i < 4; i++) {
    minimizer[4 + i] = K(0.0);
    for (ptrdiff_t k = 0; k < 4; k++) {
      minimizer[4 + i] = minimizer[4 + i] - cross[4 * k + i] * minimizer[k];
    }
  }
  FN(solve_cholesky_4x4_4)(inner, minimizer + 4);
  if (!(gap > K(1e-10) * trace)) {
    return K(-1.0);
  }
  return least > K(0.0) ? least : K(0.0);
}

/* The unit motor of least form, and the form there; negative if the form leaves the rotation free. */
BS_OUTLINED S FN(form_motor)(const S form[BS_LENGTH(36)], S motor[BS_LENGTH(8)])
{
  S minimizer[8];
  const S result = FN(minimize_form)(form, minimizer);
  const S least = result;
  S sum_of_blades[8];
  sum_of_blades[0] = minimizer[0];
  sum_of_blades[1] = minimizer[1];
  sum_of_blades[2] = minimizer[2];
  sum_of_blades[4] = minimizer[3];
  sum_of_blades[3] = minimizer[4];
  sum_of_blades[5] = minimizer[5];
  sum_of_blades[6] = minimizer[6];
  sum_of_blades[7] = minimizer[7];
  FN(cga3d_near_motor)(motor, sum_of_blades);
  return least;
}

/* The element of a moved object. */
BS_INLINE void FN(move_element_all)(ptrdiff_t kind, const S motor[BS_LENGTH(8)], const S *reals, ptrdiff_t at,
    S element[BS_LENGTH(7)])
{
  if (kind == 0) {
    FN(cga3d_moved_point)(element, motor, reals + at);
    return;
  }
  if (kind == 1) {
    FN(cga3d_moved_point_pair)(element, motor, reals + at);
    return;
  }
  if (kind == 2) {
    FN(cga3d_moved_line)(element, motor, reals + at);
    return;
  }
  if (kind == 3) {
    FN(cga3d_moved_line)(element, motor, reals + at);
    return;
  }
  if (kind == 4) {
    FN(cga3d_moved_circle)(element, motor, reals + at);
    return;
  }
  if (kind == 5) {
    FN(cga3d_moved_plane)(element, motor, reals + at);
    return;
  }
  if (kind == 6) {
    FN(cga3d_moved_sphere)(element, motor, reals + at);
    return;
  }
}

/* The cell along an axis that holds x. */
BS_OUTLINED ptrdiff_t FN(cell)(const S grid[BS_LENGTH(5)], const ptrdiff_t head[BS_LENGTH(10)], ptrdiff_t axis, S x)
{
  const S place = (x - grid[axis]) * grid[3];
  const ptrdiff_t last = head[6 + axis] - 1;
  return place > K(0.0) ? (place < (S)(last) ? (ptrdiff_t)(place) : last) : 0;
}

/* The row of the nearest reference object within the limit, or -1; its weighted square, and its sign. */
BS_INLINE void FN(nearest)(ptrdiff_t kind, const S element[BS_LENGTH(7)], const S settings[BS_LENGTH(6)],
    const S *grids, const ptrdiff_t *heads, const S *reals, const ptrdiff_t *integers, ptrdiff_t *result0_,
    S *result1_, S *result2_)
{
  const ptrdiff_t grid_at = 5 * kind;
  const ptrdiff_t head_at = 10 * kind;
  ptrdiff_t found = -1;
  S best = settings[3];
  S side = K(1.0);
  if (element[0] - element[0] != K(0.0) || heads[head_at + 9] == 0) {
    *result0_ = found;
    *result1_ = best;
    *result2_ = side;
    return;
  }
  const S reach = SQRT(settings[3] / settings[0]);
  const ptrdiff_t result = FN(cell)(grids + grid_at, heads + head_at, 0, element[0] - reach);
  const ptrdiff_t low_x = result;
  const ptrdiff_t result1 = FN(cell)(grids + grid_at, heads + head_at, 0, element[0] + reach);
  const ptrdiff_t high_x = result1;
  const ptrdiff_t result2 = FN(cell)(grids + grid_at, heads + head_at, 1, element[1] - reach);
  const ptrdiff_t low_y = result2;
  const ptrdiff_t result3 = FN(cell)(grids + grid_at, heads + head_at, 1, element[1] + reach);
  const ptrdiff_t high_y = result3;
  const ptrdiff_t result4 = FN(cell)(grids + grid_at, heads + head_at, 2, element[2] - reach);
  const ptrdiff_t low_z = result4;
  const ptrdiff_t result5 = FN(cell)(grids + grid_at, heads + head_at, 2, element[2] + reach);
  const ptrdiff_t high_z = result5;
  for (ptrdiff_t x = low_x; x < high_x + 1; x++) {
    for (ptrdiff_t y = low_y; y < high_y + 1; y++) {
      const ptrdiff_t starts = heads[head_at + 4] + (x * heads[head_at + 6 + 1] + y) * heads[head_at + 6 + 2];
      const ptrdiff_t value = integers[starts + high_z + 1];
      for (ptrdiff_t j = integers[starts + low_z]; j < value; j++) {
        const ptrdiff_t at = heads[head_at + 3] + 7 * j;
        S row[1];
        S row1[1];
        FN(cga3d_apart)(row, row1, element, reals + at, settings, grids + grid_at + 4, settings + 5);
        const S square = row[0];
        const S cosine = row1[0];
        if ((square < best) || (square == best && found > integers[heads[head_at + 5] + j])) {
          best = square;
          side = cosine;
          found = integers[heads[head_at + 5] + j];
        }
      }
    }
  }
  *result0_ = found;
  *result1_ = best;
  *result2_ = settings[5] < K(0.0) && side < K(0.0) ? K(-1.0) : K(1.0);
  return;
}

/* How well a motor lays the query over the reference; objects with a counterpart, of how many. */
BS_INLINE void FN(score_all)(const S motor[BS_LENGTH(8)], ptrdiff_t first, const ptrdiff_t *selected,
    ptrdiff_t selected_count_, const S settings[BS_LENGTH(6)], const S *grids, const ptrdiff_t *heads,
    const S *reals, const ptrdiff_t *integers, S *result0_, ptrdiff_t *result1_, ptrdiff_t *result2_)
{
  S element[7] = {0};
  const ptrdiff_t count = selected_count_;
  S total = K(0.0);
  ptrdiff_t hits = 0;
  ptrdiff_t tested = 0;
  ptrdiff_t look = 8;
  ptrdiff_t i = count > 0 ? bs_remainder(first, count) : 0;
  for (ptrdiff_t n = 0; n < count; n++) {
    if (n == look) {
      if ((S)(hits) < settings[4] * (S)(n)) {
        break;
      }
      look = look * 4;
    }
    const ptrdiff_t kind = selected[2 * i];
    const ptrdiff_t at = heads[10 * kind + 1] + heads[10 * kind] * selected[2 * i + 1];
    FN(move_element_all)(kind, motor, reals, at, element);
    ptrdiff_t result;
    S result1;
    S result2;
    FN(nearest)(kind, element, settings, grids, heads, reals, integers, &result, &result1, &result2);
    const ptrdiff_t found = result;
    const S square = result1;
    if (found >= 0) {
      total = total + (K(1.0) - square / settings[3]);
      hits = hits + 1;
    }
    tested = tested + 1;
    i = i + 1 < count ? i + 1 : 0;
  }
  *result0_ = tested < count ? K(-1.0) : total;
  *result1_ = hits;
  *result2_ = tested;
  return;
}

/* The motor of a sample of matches, and its `score`. */
BS_OUTLINED void FN(samples_all)(const ptrdiff_t *pair_kinds, ptrdiff_t pair_kinds_count_, const ptrdiff_t *query,
    const ptrdiff_t *reference, const S *signs, S residual, const ptrdiff_t *selected, ptrdiff_t selected_count_,
    const S settings[BS_LENGTH(6)], const S *grids, const ptrdiff_t *heads, const S *reals,
    const ptrdiff_t *integers, S motor[BS_LENGTH(8)], S *result0_, ptrdiff_t *result1_, ptrdiff_t *result2_)
{
  S form[36] = {0};
  ptrdiff_t first = 0;
  for (ptrdiff_t k = 0; k < pair_kinds_count_; k++) {
    const ptrdiff_t kind = pair_kinds[k];
    if (kind < 0) {
      continue;
    }
    first = first + query[k];
    const ptrdiff_t x = heads[10 * kind + 1] + heads[10 * kind] * query[k];
    const ptrdiff_t y = heads[10 * kind + 2] + heads[10 * kind] * reference[k];
    FN(add_form_all)(kind, reals, x, y, signs + k, K(1.0), form);
  }
  const S result = FN(form_motor)(form, motor);
  const S least = result;
  S total = K(-1.0);
  ptrdiff_t hits = 0;
  ptrdiff_t tested = 0;
  if (least >= K(0.0) && least <= residual * (S)(pair_kinds_count_)) {
    S result1;
    ptrdiff_t result2;
    ptrdiff_t result3;
    FN(score_all)(motor, first, selected, selected_count_, settings, grids, heads, reals, integers, &result1, &result2,
        &result3);
    total = result1;
    hits = result2;
    tested = result3;
  }
  *result0_ = total;
  *result1_ = hits;
  *result2_ = tested;
  return;
}

/* Add the forms of all matches under a motor, near ones weighing more. */
BS_OUTLINED void FN(add_matches_all)(const S motor[BS_LENGTH(8)], const ptrdiff_t *selected,
    ptrdiff_t selected_count_, const S settings[BS_LENGTH(6)], const S *grids, const ptrdiff_t *heads,
    const S *reals, const ptrdiff_t *integers, S form[BS_LENGTH(36)])
{
  S element[7] = {0};
  for (ptrdiff_t i = 0; i < selected_count_; i++) {
    const ptrdiff_t kind = selected[2 * i];
    const ptrdiff_t x = heads[10 * kind + 1] + heads[10 * kind] * selected[2 * i + 1];
    FN(move_element_all)(kind, motor, reals, x, element);
    ptrdiff_t result;
    S result1;
    S result2;
    FN(nearest)(kind, element, settings, grids, heads, reals, integers, &result, &result1, &result2);
    const ptrdiff_t row = result;
    const S square = result1;
    const S sign = result2;
    if (row >= 0) {
      const S near = K(1.0) - square / settings[3];
      const ptrdiff_t y = heads[10 * kind + 2] + heads[10 * kind] * row;
      S row1[1];
      row1[0] = sign;
      FN(add_form_all)(kind, reals, x, y, row1, near * near, form);
    }
  }
}

/* Put another motor, of the same sign, in a motor's place; the square of the change. */
BS_OUTLINED S FN(replace_motor)(S motor[BS_LENGTH(8)], const S other[BS_LENGTH(8)])
{
  S agreement = K(0.0);
  for (ptrdiff_t k = 0; k < 8; k++) {
    agreement = agreement + other[k] * motor[k];
  }
  S change = K(0.0);
  for (ptrdiff_t k = 0; k < 8; k++) {
    const S value = agreement < K(0.0) ? -other[k] : other[k];
    change = change + (value - motor[k]) * (value - motor[k]);
    motor[k] = value;
  }
  return change;
}

/* Match, and move by the motor of the matches, until it stays; the `score`, and rounds or -1 if it came to nothing. */
BS_OUTLINED void FN(refine_all)(ptrdiff_t rounds, S settled, const ptrdiff_t *selected, ptrdiff_t selected_count_,
    const S settings[BS_LENGTH(6)], const S *grids, const ptrdiff_t *heads, const S *reals,
    const ptrdiff_t *integers, S motor[BS_LENGTH(8)], S *result0_, ptrdiff_t *result1_, ptrdiff_t *result2_)
{
  ptrdiff_t taken = -1;
  for (ptrdiff_t k = 0; k < rounds; k++) {
    S form[36] = {0};
    FN(add_matches_all)(motor, selected, selected_count_, settings, grids, heads, reals, integers, form);
    S following[8];
    const S result = FN(form_motor)(form, following);
    const S least = result;
    if (!(least >= K(0.0))) {
      break;
    }
    const S result1 = FN(replace_motor)(motor, following);
    const S change = result1;
    taken = k + 1;
    if (change <= settled) {
      break;
    }
  }
  S result2;
  ptrdiff_t result3;
  ptrdiff_t result4;
  FN(score_all)(motor, 0, selected, selected_count_, settings, grids, heads, reals, integers, &result2, &result3,
      &result4);
  const S total = result2;
  const ptrdiff_t hits = result3;
  *result0_ = total;
  *result1_ = hits;
  *result2_ = taken;
  return;
}

/* Row of the counterpart of a query object or -1, the weighted square, and -1 if it has the other orientation. */
BS_OUTLINED void FN(match_all)(const ptrdiff_t selected[BS_LENGTH(2)], const S motor[BS_LENGTH(8)],
    const S settings[BS_LENGTH(6)], const S *grids, const ptrdiff_t *heads, const S *reals,
    const ptrdiff_t *integers, ptrdiff_t *result0_, S *result1_, S *result2_)
{
  S element[7] = {0};
  const ptrdiff_t at = heads[10 * selected[0] + 1] + heads[10 * selected[0]] * selected[1];
  FN(move_element_all)(selected[0], motor, reals, at, element);
  ptrdiff_t result;
  S result1;
  S result2;
  FN(nearest)(selected[0], element, settings, grids, heads, reals, integers, &result, &result1, &result2);
  const ptrdiff_t row = result;
  const S square = result1;
  const S sign = result2;
  *result0_ = row;
  *result1_ = square;
  *result2_ = sign;
  return;
}

/* The reference segment that a moved one fits best, of those whose lines are within the limit, or -1; the mean */
BS_OUTLINED void FN(fitting_segment)(ptrdiff_t kind, const S element[BS_LENGTH(7)], const S ends[BS_LENGTH(6)],
    const S *reference_ends, const S settings[BS_LENGTH(6)], const S *grids, const ptrdiff_t *heads, const S *reals,
    const ptrdiff_t *integers, ptrdiff_t *result0_, S *result1_)
{
  const ptrdiff_t grid_at = 5 * kind;
  const ptrdiff_t head_at = 10 * kind;
  ptrdiff_t found = -1;
  S best = K(0.0);
  S square = K(0.0);
  if (element[0] - element[0] != K(0.0) || heads[head_at + 9] == 0) {
    *result0_ = found;
    *result1_ = square;
    return;
  }
  const S reach = SQRT(settings[3] / settings[0]);
  const ptrdiff_t result = FN(cell)(grids + grid_at, heads + head_at, 0, element[0] - reach);
  const ptrdiff_t result1 = FN(cell)(grids + grid_at, heads + head_at, 0, element[0] + reach);
  for (ptrdiff_t x = result; x < result1 + 1; x++) {
    const ptrdiff_t result2 = FN(cell)(grids + grid_at, heads + head_at, 1, element[1] - reach);
    const ptrdiff_t result3 = FN(cell)(grids + grid_at, heads + head_at, 1, element[1] + reach);
    for (ptrdiff_t y = result2; y < result3 + 1; y++) {
      const ptrdiff_t starts = heads[head_at + 4] + (x * heads[head_at + 6 + 1] + y) * heads[head_at + 6 + 2];
      const ptrdiff_t result4 = FN(cell)(grids + grid_at, heads + head_at, 2, element[2] - reach);
      const ptrdiff_t begin = integers[starts + result4];
      const ptrdiff_t result5 = FN(cell)(grids + grid_at, heads + head_at, 2, element[2] + reach);
      const ptrdiff_t value = integers[starts + result5 + 1];
      for (ptrdiff_t j = begin; j < value; j++) {
        const ptrdiff_t at = heads[head_at + 3] + 7 * j;
        S row1[1];
        S row2[1];
        FN(cga3d_apart)(row1, row2, element, reals + at, settings, grids + grid_at + 4, settings + 5);
        const S apart__ = row1[0];
        if (!(apart__ <= settings[3])) {
          continue;
        }
        const ptrdiff_t row = integers[heads[head_at + 5] + j];
        const ptrdiff_t others_at = 6 * row;
        S row3[1];
        S row4[1];
        FN(cga3d_ends_apart)(row3, row4, ends, ends + 3, reference_ends + others_at, reference_ends + others_at + 3);
        const S off = row3[0];
        const S out = row4[0];
        const S misfit = off + FN(bs_min)(out * out, K(0.25) * reach * reach);
        if ((found < 0 || misfit < best) || (misfit == best && found > row)) {
          best = misfit;
          square = off;
          found = row;
        }
      }
    }
  }
  *result0_ = found;
  *result1_ = square;
  return;
}

/* Row of the counterpart of a query segment by its ends or -1, and the mean square by which ends are off. */
BS_OUTLINED void FN(match_segments_all)(ptrdiff_t kind, ptrdiff_t row, const S motor[BS_LENGTH(8)], const S *ends,
    const S *reference_ends, const S settings[BS_LENGTH(6)], const S *grids, const ptrdiff_t *heads, const S *reals,
    const ptrdiff_t *integers, ptrdiff_t *result0_, S *result1_)
{
  S element[7] = {0};
  FN(move_element_all)(kind, motor, reals, heads[10 * kind + 1] + heads[10 * kind] * row, element);
  S moved[6];
  S rates[18];
  const ptrdiff_t own_at = 6 * row;
  FN(cga3d_position_rates)(moved, rates, motor, ends + own_at);
  FN(cga3d_position_rates)(moved + 3, rates, motor, ends + own_at + 3);
  ptrdiff_t result;
  S result1;
  FN(fitting_segment)(kind, element, moved, reference_ends, settings, grids, heads, reals, integers, &result, &result1);
  const ptrdiff_t found = result;
  const S square = result1;
  *result0_ = found;
  *result1_ = square;
  return;
}

/* Sum of squared residuals of a match, its gradient and its Gauss-Newton matrix by the twist. */
BS_OUTLINED void FN(residual_rates)(const S motor[BS_LENGTH(8)], const S vectors[BS_LENGTH(6)], ptrdiff_t directed,
    const S residuals[BS_LENGTH(42)], S found[BS_LENGTH(28)])
{
  S moved[6];
  S moved_rates[36];
  FN(cga3d_position_rates)(moved, moved_rates, motor, vectors);
  if (directed != 0) {
    FN(cga3d_direction_rates)(moved + 3, moved_rates + 18, motor, vectors + 3);
  } else {
    FN(cga3d_position_rates)(moved + 3, moved_rates + 18, motor, vectors + 3);
  }
  for (ptrdiff_t k1 = 0; k1 < 28; k1++) {
    found[k1] = K(0.0);
  }
  S slope[6];
  for (ptrdiff_t k = 0; k < 6; k++) {
    S value = -residuals[7 * k + 6];
    for (ptrdiff_t j = 0; j < 6; j++) {
      value = value + residuals[7 * k + j] * moved[j];
    }
    for (ptrdiff_t i = 0; i < 6; i++) {
      slope[i] = K(0.0);
      for (ptrdiff_t j = 0; j < 3; j++) {
        slope[i] = slope[i] + residuals[7 * k + j] * moved_rates[3 * i + j];
        slope[i] = slope[i] + residuals[7 * k + (3 + j)] * moved_rates[18 + (3 * i + j)];
      }
    }
    found[0] = found[0] + value * value;
    ptrdiff_t at = 7;
    for (ptrdiff_t i = 0; i < 6; i++) {
      found[1 + i] = found[1 + i] + K(2.0) * value * slope[i];
      for (ptrdiff_t j = i; j < 6; j++) {
        found[at] = found[at] + K(2.0) * slope[i] * slope[j];
        at = at + 1;
      }
    }
  }
}

/* Rates of all matches times their weights, and the sum of their costs; zeros for a match without a rotor, or of */
BS_OUTLINED S FN(weighted_rates_all)(const ptrdiff_t *pair_kinds, ptrdiff_t pair_kinds_count_,
    const ptrdiff_t *query, const ptrdiff_t *reference, const S *weights, const S motor[BS_LENGTH(8)],
    const ptrdiff_t *heads, const S *reals, S *found)
{
  S total = K(0.0);
  for (ptrdiff_t i = 0; i < pair_kinds_count_; i++) {
    const ptrdiff_t row_at = 28 * i;
    FN(rates_all)(pair_kinds[i], motor, query[i], reference[i], heads, reals, found + row_at);
    S finite = K(0.0);
    for (ptrdiff_t k = 0; k < 28; k++) {
      found[row_at + k] = found[row_at + k] * weights[i];
      finite = finite + (found[row_at + k] - found[row_at + k]);
    }
    if (!(finite == K(0.0) && weights[i] > K(0.0))) {
      for (ptrdiff_t k1 = 0; k1 < 28; k1++) {
        found[row_at + k1] = K(0.0);
      }
    }
    total = total + found[row_at];
  }
  return total;
}

/* Gradient and Gauss-Newton matrix of all matches, added in their order. */
BS_OUTLINED void FN(summed_rates)(const S *rows, ptrdiff_t rows_count_, S gradient[BS_LENGTH(6)],
    S matrix[BS_LENGTH(36)])
{
  S total[28] = {0};
  for (ptrdiff_t i = 0; i < rows_count_; i++) {
    for (ptrdiff_t k = 0; k < 28; k++) {
      total[k] = total[k] + rows[28 * i + k];
    }
  }
  ptrdiff_t at = 7;
  for (ptrdiff_t i = 0; i < 6; i++) {
    gradient[i] = total[1 + i];
    for (ptrdiff_t j = i; j < 6; j++) {
      const S value = total[at];
      matrix[6 * i + j] = value;
      matrix[6 * j + i] = value;
      at = at + 1;
    }
  }
}

/* Eigenvalues on the diagonal and eigenvectors in the columns of v, by cyclic Jacobi (Golub and Van Loan 8.5). */
BS_OUTLINED void FN(diagonalize_6x6_6x6_6)(S a[BS_LENGTH(36)], S v[BS_LENGTH(36)])
{
  for (ptrdiff_t p = 0; p < 6; p++) {
    for (ptrdiff_t q = 0; q < 6; q++) {
      v[6 * p + q] = p == q ? K(1.0) : K(0.0);
    }
  }
  for (ptrdiff_t __ = 0; __ < 12; __++) {
    S off = K(0.0);
    S on = K(0.0);
    for (ptrdiff_t p = 0; p < 6; p++) {
      on = on + a[6 * p + p] * a[6 * p + p];
      for (ptrdiff_t q = p + 1; q < 6; q++) {
        off = off + a[6 * p + q] * a[6 * p + q];
      }
    }
    if (!(off > K(1e-34) * on)) {
      break;
    }
    for (ptrdiff_t p = 0; p < 6; p++) {
      for (ptrdiff_t q = p + 1; q < 6; q++) {
        if (!(ABS(a[6 * p + q]) > K(0.0))) {
          continue;
        }
        const S theta = (a[6 * q + q] - a[6 * p + p]) / (K(2.0) * a[6 * p + q]);
        const S t = (theta < K(0.0) ? K(-1.0) : K(1.0)) / (ABS(theta) + SQRT(theta * theta + K(1.0)));
        const S c = K(1.0) / SQRT(t * t + K(1.0));
        const S s = t * c;
        for (ptrdiff_t k = 0; k < 6; k++) {
          const S kp = a[6 * k + p];
          const S kq = a[6 * k + q];
          a[6 * k + p] = c * kp - s * kq;
          a[6 * k + q] = s * kp + c * kq;
        }
        for (ptrdiff_t k = 0; k < 6; k++) {
          const S pk = a[6 * p + k];
          const S qk = a[6 * q + k];
          const S vp = v[6 * k + p];
          const S vq = v[6 * k + q];
          a[6 * p + k] = c * pk - s * qk;
          a[6 * q + k] = s * pk + c * qk;
          v[6 * k + p] = c * vp - s * vq;
          v[6 * k + q] = s * vp + c * vq;
        }
      }
    }
  }
}

/* Gauss-Newton on the costs of matches; a step that makes them greater is halved. Steps that were made. */
BS_OUTLINED ptrdiff_t FN(descend_all)(ptrdiff_t steps, const ptrdiff_t *pair_kinds, ptrdiff_t pair_kinds_count_,
    const ptrdiff_t *query, const ptrdiff_t *reference, const S *weights, const ptrdiff_t *heads, const S *reals,
    S motor[BS_LENGTH(8)], S *found, ptrdiff_t found_count_, S *trial)
{
  const S result = FN(weighted_rates_all)(pair_kinds, pair_kinds_count_, query, reference, weights, motor, heads,
      reals, found);
  S cost = result;
  S size = K(BS_HUGE_VALUE);
  S gradient[6];
  S matrix[36];
  S values[6] = {0};
  S vectors[36] = {0};
  S step[6];
  S moved[8];
  for (ptrdiff_t taken = 0; taken < steps; taken++) {
    FN(summed_rates)(found, found_count_, gradient, matrix);
    if (size > K(1e-06)) {
      FN(diagonalize_6x6_6x6_6)(matrix, vectors);
      for (ptrdiff_t p = 0; p < 6; p++) {
        values[p] = matrix[6 * p + p];
      }
    }
    S most = K(0.0);
    for (ptrdiff_t p = 0; p < 6; p++) {
      most = values[p] > most ? values[p] : most;
    }
    for (ptrdiff_t k1 = 0; k1 < 6; k1++) {
      step[k1] = K(0.0);
    }
    for (ptrdiff_t p = 0; p < 6; p++) {
      if (values[p] > K(1e-09) * most) {
        S along = K(0.0);
        for (ptrdiff_t k = 0; k < 6; k++) {
          along = along + vectors[6 * k + p] * gradient[k];
        }
        for (ptrdiff_t k = 0; k < 6; k++) {
          step[k] = step[k] - vectors[6 * k + p] * (along / values[p]);
        }
      }
    }
    const S limit = cost * K(1.00000000000001) + K(1e-28);
    int is_lower = 0;
    for (ptrdiff_t __ = 0; __ < 8; __++) {
      FN(cga3d_stepped)(moved, motor, step);
      const S result1 = FN(weighted_rates_all)(pair_kinds, pair_kinds_count_, query, reference, weights, moved, heads,
          reals, trial);
      const S changed = result1;
      if (changed <= limit) {
        is_lower = 1;
        cost = changed;
        break;
      }
      for (ptrdiff_t k = 0; k < 6; k++) {
        step[k] = step[k] * K(0.5);
      }
    }
    if (!is_lower) {
      return taken + 1;
    }
    for (ptrdiff_t k2 = 0; k2 < 8; k2++) {
      motor[k2] = moved[k2];
    }
    for (ptrdiff_t i = 0; i < found_count_; i++) {
      for (ptrdiff_t k3 = 0; k3 < 28; k3++) {
        found[28 * i + k3] = trial[28 * i + k3];
      }
    }
    size = K(0.0);
    for (ptrdiff_t k = 0; k < 6; k++) {
      size = ABS(step[k]) > size ? ABS(step[k]) : size;
    }
    if (size < K(1e-14)) {
      return taken + 1;
    }
  }
  return steps;
}

/* What a match moves the twist by, in place of its error, where its influence on its own residual is removed. */
BS_OUTLINED void FN(influences)(const S rates[BS_LENGTH(28)], const S whiten[BS_LENGTH(36)],
    S influence[BS_LENGTH(6)], S *result0_, S *result1_)
{
  S half[36];
  ptrdiff_t at = 7;
  for (ptrdiff_t i = 0; i < 6; i++) {
    for (ptrdiff_t j = i; j < 6; j++) {
      const S value = rates[at];
      half[6 * i + j] = value;
      half[6 * j + i] = value;
      at = at + 1;
    }
  }
  S side[36];
  for (ptrdiff_t i = 0; i < 6; i++) {
    for (ptrdiff_t q = 0; q < 6; q++) {
      side[6 * i + q] = K(0.0);
      for (ptrdiff_t j = 0; j < 6; j++) {
        side[6 * i + q] = side[6 * i + q] + half[6 * i + j] * whiten[6 * j + q];
      }
    }
  }
  S left[36];
  S trace = K(0.0);
  S squares = K(0.0);
  for (ptrdiff_t p = 0; p < 6; p++) {
    for (ptrdiff_t q = p; q < 6; q++) {
      S own = K(0.0);
      for (ptrdiff_t i = 0; i < 6; i++) {
        own = own + whiten[6 * i + p] * side[6 * i + q];
      }
      const S value1 = (p == q ? K(1.0) : K(0.0)) - own;
      left[6 * p + q] = value1;
      left[6 * q + p] = value1;
      trace = trace + (p == q ? own : K(0.0));
      squares = squares + (p == q ? own * own : K(2.0) * own * own);
    }
  }
  S axes[36];
  FN(diagonalize_6x6_6x6_6)(left, axes);
  S gradient[6] = {0};
  for (ptrdiff_t p = 0; p < 6; p++) {
    for (ptrdiff_t i = 0; i < 6; i++) {
      gradient[p] = gradient[p] + whiten[6 * i + p] * rates[1 + i];
    }
  }
  S spread[6] = {0};
  for (ptrdiff_t p = 0; p < 6; p++) {
    S along = K(0.0);
    for (ptrdiff_t k = 0; k < 6; k++) {
      along = along + axes[6 * k + p] * gradient[k];
    }
    const S remaining = left[6 * p + p] > K(0.001) ? left[6 * p + p] : K(0.001);
    for (ptrdiff_t k = 0; k < 6; k++) {
      spread[k] = spread[k] + axes[6 * k + p] * (along / SQRT(remaining));
    }
  }
  for (ptrdiff_t i = 0; i < 6; i++) {
    influence[i] = K(0.0);
    for (ptrdiff_t p = 0; p < 6; p++) {
      influence[i] = influence[i] + whiten[6 * i + p] * spread[p];
    }
  }
  *result0_ = trace;
  *result1_ = squares;
  return;
}

/* How far a point is off an object, squared, and halves of the first and second rates by the point. */
BS_OUTLINED void FN(square_off_all)(ptrdiff_t kind, const S point[BS_LENGTH(3)], const S element[BS_LENGTH(7)],
    S square[BS_LENGTH(1)], S gradient[BS_LENGTH(3)], S matrix[BS_LENGTH(6)])
{
  if (kind == 0) {
    FN(cga3d_off_position)(square, gradient, matrix, point, element);
    return;
  }
  if (kind == 1) {
    FN(cga3d_off_position)(square, gradient, matrix, point, element);
    return;
  }
  if (kind == 2) {
    FN(cga3d_off_line)(square, gradient, matrix, point, element);
    return;
  }
  if (kind == 3) {
    FN(cga3d_off_line)(square, gradient, matrix, point, element);
    return;
  }
  if (kind == 4) {
    FN(cga3d_off_position)(square, gradient, matrix, point, element);
    return;
  }
  if (kind == 5) {
    FN(cga3d_off_plane)(square, gradient, matrix, point, element);
    return;
  }
  if (kind == 6) {
    FN(cga3d_off_position)(square, gradient, matrix, point, element);
    return;
  }
}

/* Eigenvalues on the diagonal and eigenvectors in the columns of v, by cyclic Jacobi (Golub and Van Loan 8.5). */
BS_OUTLINED void FN(diagonalize_3x3_3x3_3)(S a[BS_LENGTH(9)], S v[BS_LENGTH(9)])
{
  for (ptrdiff_t p = 0; p < 3; p++) {
    for (ptrdiff_t q = 0; q < 3; q++) {
      v[3 * p + q] = p == q ? K(1.0) : K(0.0);
    }
  }
  for (ptrdiff_t __ = 0; __ < 12; __++) {
    S off = K(0.0);
    S on = K(0.0);
    for (ptrdiff_t p = 0; p < 3; p++) {
      on = on + a[3 * p + p] * a[3 * p + p];
      for (ptrdiff_t q = p + 1; q < 3; q++) {
        off = off + a[3 * p + q] * a[3 * p + q];
      }
    }
    if (!(off > K(1e-34) * on)) {
      break;
    }
    for (ptrdiff_t p = 0; p < 3; p++) {
      for (ptrdiff_t q = p + 1; q < 3; q++) {
        if (!(ABS(a[3 * p + q]) > K(0.0))) {
          continue;
        }
        const S theta = (a[3 * q + q] - a[3 * p + p]) / (K(2.0) * a[3 * p + q]);
        const S t = (theta < K(0.0) ? K(-1.0) : K(1.0)) / (ABS(theta) + SQRT(theta * theta + K(1.0)));
        const S c = K(1.0) / SQRT(t * t + K(1.0));
        const S s = t * c;
        for (ptrdiff_t k = 0; k < 3; k++) {
          const S kp = a[3 * k + p];
          const S kq = a[3 * k + q];
          a[3 * k + p] = c * kp - s * kq;
          a[3 * k + q] = s * kp + c * kq;
        }
        for (ptrdiff_t k = 0; k < 3; k++) {
          const S pk = a[3 * p + k];
          const S qk = a[3 * q + k];
          const S vp = v[3 * k + p];
          const S vq = v[3 * k + q];
          a[3 * p + k] = c * pk - s * qk;
          a[3 * q + k] = s * pk + c * qk;
          v[3 * k + p] = c * vp - s * vq;
          v[3 * k + q] = s * vp + c * vq;
        }
      }
    }
  }
}

/* The nearest point to objects that are near; it starts between them, and stays where they say nothing. */
BS_OUTLINED void FN(nearest_point_all)(const ptrdiff_t *object_kinds, ptrdiff_t object_kinds_count_,
    const S *elements, const ptrdiff_t *near, S rank_tolerance, S point[BS_LENGTH(3)])
{
  S about[3] = {0};
  ptrdiff_t count = 0;
  for (ptrdiff_t i = 0; i < object_kinds_count_; i++) {
    if (near[i] != 0) {
      for (ptrdiff_t k = 0; k < 3; k++) {
        about[k] = about[k] + elements[7 * i + k];
      }
      count = count + 1;
    }
  }
  for (ptrdiff_t k = 0; k < 3; k++) {
    about[k] = about[k] / (S)(count);
  }
  S pull[3] = {0};
  S a[9] = {0};
  S square[1];
  S gradient[3];
  S matrix[6];
  for (ptrdiff_t i = 0; i < object_kinds_count_; i++) {
    if (near[i] != 0) {
      FN(square_off_all)(object_kinds[i], about, elements + 7 * i, square, gradient, matrix);
      ptrdiff_t at = 0;
      for (ptrdiff_t p = 0; p < 3; p++) {
        pull[p] = pull[p] + gradient[p];
        for (ptrdiff_t q = p; q < 3; q++) {
          a[3 * p + q] = a[3 * p + q] + matrix[at];
          at = at + 1;
        }
      }
    }
  }
  for (ptrdiff_t p = 0; p < 3; p++) {
    for (ptrdiff_t q = 0; q < p; q++) {
      a[3 * p + q] = a[3 * q + p];
    }
  }
  S v[9];
  FN(diagonalize_3x3_3x3_3)(a, v);
  S most = K(0.0);
  for (ptrdiff_t p = 0; p < 3; p++) {
    most = a[3 * p + p] > most ? a[3 * p + p] : most;
  }
  for (ptrdiff_t k1 = 0; k1 < 3; k1++) {
    point[k1] = about[k1];
  }
  for (ptrdiff_t p = 0; p < 3; p++) {
    if (!(a[3 * p + p] > rank_tolerance * most)) {
      continue;
    }
    S along = K(0.0);
    for (ptrdiff_t k = 0; k < 3; k++) {
      along = along + v[3 * k + p] * pull[k];
    }
    for (ptrdiff_t k = 0; k < 3; k++) {
      point[k] = point[k] - v[3 * k + p] * (along / a[3 * p + p]);
    }
  }
}

/* The value that stands at a rank once values are in order; they are put in another order (Hoare's FIND). */
BS_OUTLINED S FN(select_rank_n)(S *values, ptrdiff_t values_count_, ptrdiff_t rank)
{
  ptrdiff_t low = 0;
  ptrdiff_t high = values_count_ - 1;
  while (low < high) {
    const S pivot = values[rank];
    ptrdiff_t i = low;
    ptrdiff_t j = high;
    while (i <= j) {
      while (values[i] < pivot) {
        i = i + 1;
      }
      while (pivot < values[j]) {
        j = j - 1;
      }
      if (i > j) {
        break;
      }
      const S value = values[j];
      const S value1 = values[i];
      values[i] = value;
      values[j] = value1;
      i = i + 1;
      j = j - 1;
    }
    if (j < rank) {
      low = i;
    }
    if (rank < i) {
      high = j;
    }
  }
  return values[rank];
}

/* The center of least squared distances from all objects except outliers, which are left out in rounds. */
BS_OUTLINED void FN(robust_center_all)(const ptrdiff_t *object_kinds, ptrdiff_t object_kinds_count_,
    const S *elements, ptrdiff_t rounds, ptrdiff_t rank, S outlier_factor, S rounding, S rank_tolerance, S *squares,
    S *ordered, ptrdiff_t ordered_count_, ptrdiff_t *near, S point[BS_LENGTH(3)])
{
  S smallest = K(0.0);
  for (ptrdiff_t i = 0; i < object_kinds_count_; i++) {
    near[i] = 1;
    for (ptrdiff_t k = 0; k < 3; k++) {
      const S far = ABS(elements[7 * i + k]);
      smallest = far > smallest ? far : smallest;
    }
  }
  smallest = smallest * rounding;
  S square[1];
  S gradient[3];
  S matrix[6];
  for (ptrdiff_t __ = 0; __ < rounds; __++) {
    FN(nearest_point_all)(object_kinds, object_kinds_count_, elements, near, rank_tolerance, point);
    for (ptrdiff_t i = 0; i < object_kinds_count_; i++) {
      FN(square_off_all)(object_kinds[i], point, elements + 7 * i, square, gradient, matrix);
      const S value = square[0];
      squares[i] = value;
      ordered[i] = value;
    }
    const S result = FN(select_rank_n)(ordered, ordered_count_, rank);
    const S usual = result;
    const S least = smallest * smallest;
    const S limit = outlier_factor * outlier_factor * (usual > least ? usual : least);
    ptrdiff_t changed = 0;
    for (ptrdiff_t i = 0; i < object_kinds_count_; i++) {
      const ptrdiff_t is_near = squares[i] <= limit ? 1 : 0;
      changed = is_near != near[i] ? 1 : changed;
      near[i] = is_near;
    }
    if (changed == 0) {
      break;
    }
  }
}

/* Whether all coefficients are. */
BS_OUTLINED int FN(is_finite)(const S motor[BS_LENGTH(8)])
{
  S total = K(0.0);
  for (ptrdiff_t k = 0; k < 8; k++) {
    total = total + motor[k];
  }
  return total - total == K(0.0);
}

/* Half of the way of a match of a kind without a direction, with another one that gives it an axis. */
BS_OUTLINED int FN(half_step_of_two_all)(ptrdiff_t kind, const S motor[BS_LENGTH(8)], const S *reals, ptrdiff_t x,
    ptrdiff_t y, ptrdiff_t x2, ptrdiff_t y2, S following[BS_LENGTH(8)])
{
  int is_done;
  if (kind == 0) {
    FN(cga3d_half_two_point)(following, motor, reals + x, reals + y, reals + x2, reals + y2);
    const int result = FN(is_finite)(following);
    is_done = result;
    return is_done;
  }
  if (kind == 6) {
    FN(cga3d_half_two_sphere)(following, motor, reals + x, reals + y, reals + x2, reals + y2);
    const int result1 = FN(is_finite)(following);
    is_done = result1;
    return is_done;
  }
  return 0;
}

/* Half of the way of a match; where it is not finite, objects face each other or their centres are one. */
BS_OUTLINED int FN(half_step_all)(ptrdiff_t kind, const S motor[BS_LENGTH(8)], const S *reals, ptrdiff_t x,
    ptrdiff_t y, const S sign[BS_LENGTH(1)], S following[BS_LENGTH(8)])
{
  if (kind == 0) {
    FN(cga3d_half_point)(following, motor, reals + x, reals + y, sign);
  }
  if (kind == 1) {
    FN(cga3d_half_point_pair)(following, motor, reals + x, reals + y, sign);
  }
  if (kind == 2) {
    FN(cga3d_half_line)(following, motor, reals + x, reals + y, sign);
  }
  if (kind == 3) {
    FN(cga3d_half_line)(following, motor, reals + x, reals + y, sign);
  }
  if (kind == 4) {
    FN(cga3d_half_circle)(following, motor, reals + x, reals + y, sign);
  }
  if (kind == 5) {
    FN(cga3d_half_plane)(following, motor, reals + x, reals + y, sign);
  }
  if (kind == 6) {
    FN(cga3d_half_sphere)(following, motor, reals + x, reals + y, sign);
  }
  const int result = FN(is_finite)(following);
  const int is_done = result;
  return is_done;
}

/* Rounds until the motor stays, as many as there are changes to note; steps of the last that were not finite. */
BS_OUTLINED void FN(direct_all)(const ptrdiff_t *pair_kinds, ptrdiff_t pair_kinds_count_, const ptrdiff_t *query,
    const ptrdiff_t *reference, const ptrdiff_t *partners, const S *signs, S tolerance, const ptrdiff_t *heads,
    const S *reals, S motor[BS_LENGTH(8)], S mean[BS_LENGTH(8)], S *changes, ptrdiff_t changes_count_,
    ptrdiff_t *result0_, ptrdiff_t *result1_)
{
  S following[8];
  ptrdiff_t taken = 0;
  ptrdiff_t skipped = 0;
  while (taken < changes_count_) {
    S before[8];
    for (ptrdiff_t k1 = 0; k1 < 8; k1++) {
      before[k1] = motor[k1];
    }
    S total[8] = {0};
    skipped = 0;
    for (ptrdiff_t i = 0; i < pair_kinds_count_; i++) {
      const ptrdiff_t kind = pair_kinds[i];
      const ptrdiff_t head_at = 10 * kind;
      const ptrdiff_t x = heads[head_at + 1] + heads[head_at] * query[i];
      const ptrdiff_t y = heads[head_at + 2] + heads[head_at] * reference[i];
      int is_done = 0;
      if (partners[i] >= 0) {
        const ptrdiff_t x2 = heads[head_at + 1] + heads[head_at] * query[partners[i]];
        const ptrdiff_t y2 = heads[head_at + 2] + heads[head_at] * reference[partners[i]];
        const int result = FN(half_step_of_two_all)(kind, motor, reals, x, y, x2, y2, following);
        is_done = result;
      }
      if (!is_done) {
        const int result1 = FN(half_step_all)(kind, motor, reals, x, y, signs + i, following);
        is_done = result1;
      }
      if (is_done) {
        for (ptrdiff_t k2 = 0; k2 < 8; k2++) {
          motor[k2] = following[k2];
        }
      } else {
        skipped = skipped + 1;
      }
      for (ptrdiff_t k = 0; k < 8; k++) {
        total[k] = total[k] + motor[k];
      }
    }
    FN(cga3d_near_motor)(mean, total);
    S row[1];
    FN(cga3d_change)(row, motor, before);
    const S distance = row[0];
    changes[taken] = distance;
    taken = taken + 1;
    if (distance < tolerance) {
      break;
    }
  }
  *result0_ = taken;
  *result1_ = skipped;
  return;
}

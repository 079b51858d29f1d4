/* Where a model's frame stands: the point nearest to all its objects together, in the sense of least squares, but for
   a few far ones. */

/* The value that stands at a place once values are in order; they are put in another order (C. A. R. Hoare's FIND). */
BS_OUTLINED S FN(in_place)(S *values, ptrdiff_t count, ptrdiff_t place)
{
  ptrdiff_t low = 0, high = count - 1;
  while (low < high) {
    const S pivot = values[place];
    ptrdiff_t i = low, j = high;
    while (i <= j) {
      while (values[i] < pivot) i++;
      while (pivot < values[j]) j--;
      if (i > j) break;
      const S value = values[i];
      values[i++] = values[j], values[j--] = value;
    }
    if (j < place) low = i;
    if (place < i) high = j;
  }
  return values[place];
}

/* The nearest point to objects that are near, from where the middle of their positions is; directions in which they
   say nothing stay as they are. */
BS_OUTLINED void FN(nearest_point)(const bs_center *m, S *point)
{
  S about[BS_AXES] = {0}, pull[BS_AXES] = {0}, a[4][4] = {{0}}, v[4][4], square, gradient[BS_AXES], matrix[6], most = 0;
  ptrdiff_t count = 0;
  for (ptrdiff_t i = 0; i < m->count; i++) {
    if (!m->near[i]) continue;
    for (int k = 0; k < BS_AXES; k++) about[k] += m->elements[BS_NUMBERS * i + k];
    count++;
  }
  for (int k = 0; k < BS_AXES; k++) about[k] /= (S)count;
  for (ptrdiff_t i = 0; i < m->count; i++) {
    if (!m->near[i]) continue;
    FN(off)(m->kinds[i], &square, gradient, matrix, about, m->elements + BS_NUMBERS * i);
    for (int p = 0, k = 0; p < BS_AXES; p++) {
      pull[p] += gradient[p];
      for (int q = p; q < BS_AXES; q++) a[p][q] += matrix[k++];
    }
  }
  for (int p = 0; p < BS_AXES; p++)
    for (int q = 0; q < p; q++) a[p][q] = a[q][p];
  FN(jacobi)(a, v, BS_AXES);
  for (int p = 0; p < BS_AXES; p++) most = a[p][p] > most ? a[p][p] : most;
  for (int k = 0; k < BS_AXES; k++) point[k] = about[k];
  for (int p = 0; p < BS_AXES; p++) {
    S along = 0;
    if (!(a[p][p] > m->rank_tolerance * most)) continue;
    for (int k = 0; k < BS_AXES; k++) along += v[k][p] * pull[k];
    for (int k = 0; k < BS_AXES; k++) point[k] -= v[k][p] * (along / a[p][p]);
  }
}

BS_OUTLINED void FN(robust_center)(const bs_center *m)
{
  S least = 0, gradient[BS_AXES], matrix[6];
  for (ptrdiff_t i = 0; i < m->count; i++) {
    m->near[i] = 1;
    for (int k = 0; k < BS_AXES; k++) {
      const S far = BS_ABS1(m->elements[BS_NUMBERS * i + k]);
      least = far > least ? far : least;
    }
  }
  least *= m->rounding;
  for (ptrdiff_t round = 0; round < m->rounds; round++) {
    int changed = 0;
    FN(nearest_point)(m, m->point);
    for (ptrdiff_t i = 0; i < m->count; i++) {
      FN(off)(m->kinds[i], m->squares + i, gradient, matrix, m->point, m->elements + BS_NUMBERS * i);
      m->ordered[i] = m->squares[i];
    }
    const S usual = FN(in_place)(m->ordered, m->count, m->place), smallest = least * least;
    const S limit = m->far * m->far * (usual > smallest ? usual : smallest);
    for (ptrdiff_t i = 0; i < m->count; i++) {
      const int32_t near = m->squares[i] <= limit;
      changed |= near != m->near[i];
      m->near[i] = near;
    }
    if (!changed) break;
  }
}

/* What is done with a motor: how well it lays the query over the reference, and how it gets better. Samples and
   candidates are independent of each other; one call does a range of them. */

/* The cells along an axis from the one that holds x. */
BS_INLINE int32_t FN(cell)(const bs_grid *grid, int axis, S x)
{
  const S place = (x - (S)grid->corner[axis]) * (S)grid->scale;
  const int32_t last = grid->sides[axis] - 1;
  return place > 0 ? (place < (S)last ? (int32_t)place : last) : 0;
}

/* The row of the nearest reference object of a kind within the limit, or -1; its weighted square, and its sign. */
BS_OUTLINED ptrdiff_t FN(nearest)(const bs_reform *s, int kind, const S *e, S *square, S *sign)
{
  const bs_grid *const grid = &s->grids[kind];
  const S whole = FN(has_direction)(kind), other = s->align ? K(-1) : K(1);
  const S weights[3] = {s->weights[0], 2 * s->weights[1], s->weights[2]}; /* angle^2 = 2 (1 - cos), nearly */
  const S reach = BS_SQRT1(s->limit / s->weights[0]);
  int32_t low[3], high[3];
  ptrdiff_t found = -1;
  S best = s->limit, side = K(1);
  *square = s->limit, *sign = K(1);
  if (!(e[0] - e[0] == 0) || s->reference.counts[kind] == 0) return -1;
  for (int i = 0; i < 3; i++) low[i] = FN(cell)(grid, i, e[i] - reach), high[i] = FN(cell)(grid, i, e[i] + reach);
  for (int32_t x = low[0]; x <= high[0]; x++) {
    for (int32_t y = low[1]; y <= high[1]; y++) {
      const int32_t *const starts = grid->starts + ((ptrdiff_t)x * grid->sides[1] + y) * grid->sides[2];
      for (int32_t j = starts[low[2]]; j < starts[high[2] + 1]; j++) {
        const S *const r = grid->elements + (ptrdiff_t)BS_NUMBERS * j;
        S d, cosine;
        FN(cga3d_apart)(&d, &cosine, e, r, weights, &whole, &other);
        if (!(d < best) && !(d == best && found > grid->order[j])) continue;
        best = d, side = cosine;
        found = grid->order[j];
      }
    }
  }
  *square = best, *sign = s->align && side < 0 ? K(-1) : K(1);
  return found;
}

BS_INLINE const S *FN(asked_row)(const bs_reform *s, ptrdiff_t i)
{
  const int kind = s->asked_kinds[i];
  return s->query.rows[kind] + (ptrdiff_t)s->asked_rows[i] * FN(row_size)(kind);
}

/* How well a motor lays the query over the reference. It is given up where too few of the first 8, 32, 128 ...
   objects have a counterpart; they are asked in turn from a first one on, which should differ between samples: else
   a query whose first few objects have no counterpart is never found. */
BS_OUTLINED S FN(score)(const bs_reform *s, const S *motor, ptrdiff_t first, int32_t *hits, int32_t *tested)
{
  S total = 0, square, sign, element[BS_NUMBERS];
  ptrdiff_t look = 8, i = s->asked > 0 ? first % s->asked : 0;
  *hits = 0, *tested = 0;
  for (ptrdiff_t n = 0; n < s->asked; n++, i = i + 1 < s->asked ? i + 1 : 0) {
    if (n == look) {
      if (*hits < s->least * (S)n) break;
      look *= 4;
    }
    FN(moved_element)(s->asked_kinds[i], element, motor, FN(asked_row)(s, i));
    const int hit = FN(nearest)(s, s->asked_kinds[i], element, &square, &sign) >= 0;
    total += hit ? K(1) - square / s->limit : K(0);
    *hits += hit, *tested += 1;
  }
  return *tested < s->asked ? K(-1) : total;
}

BS_INLINE void FN(add_form)(S *sum, int kind, const S *x, const S *y, S sign, S weight)
{
  S form[BS_FORM];
  FN(motor_form)(kind, form, x, y, &sign);
  for (int k = 0; k < BS_FORM; k++) sum[k] += weight * form[k];
}

/* One sample: the motor of its pairs, and its score. */
BS_OUTLINED void FN(sample)(const bs_reform *s, const bs_samples *c, ptrdiff_t i)
{
  S form[BS_FORM] = {0};
  S *motor = c->motors + BS_MOTOR * i;
  ptrdiff_t first = 0;
  for (ptrdiff_t k = i * c->size; k < (i + 1) * c->size; k++) {
    const int kind = c->kinds[k];
    if (kind < 0) continue; /* a smaller sample */
    first += c->query[k];
    const ptrdiff_t size = FN(row_size)(kind);
    FN(add_form)(form, kind, s->query.rows[kind] + size * c->query[k], s->reference.rows[kind] + size * c->reference[k],
                 c->signs[k], K(1));
  }
  const S least = FN(form_motor)(motor, form);
  c->scores[i] = -1, c->hits[i] = c->tested[i] = 0;
  if (least >= 0 && least <= c->residual * (S)c->size) c->scores[i] = FN(score)(s, motor, first, c->hits + i, c->tested + i);
}

/* The least pivot of the form of twists of a set: how stiff it is against the motion that it hinders least. */
BS_OUTLINED S FN(stiffness)(const bs_reform *s, const bs_sets *c, ptrdiff_t i)
{
  S form[BS_FORM] = {0}, a[BS_MOTOR][BS_MOTOR], least = K(BS_HUGE_VALUE);
  for (ptrdiff_t k = i * c->size; k < (i + 1) * c->size; k++) {
    const int kind = c->kinds[k];
    if (kind < 0) continue;
    const S *x = s->query.rows[kind] + FN(row_size)(kind) * c->query[k];
    FN(add_form)(form, kind, x, x, K(1), K(1));
  }
  for (int p = 0, k = 0; p < BS_MOTOR; p++)
    for (int q = p; q < BS_MOTOR; q++, k++) a[p][q] = a[q][p] = form[k];
  int left[BS_MOTOR - 2];
  for (int p = 0; p < BS_MOTOR - 2; p++) left[p] = p + 1; /* without 1 and the pseudoscalar, the first and the last */
  for (int count = BS_MOTOR - 2; count > 0; count--) {
    int top = 0;
    for (int p = 1; p < count; p++) top = a[left[p]][left[p]] > a[left[top]][left[top]] ? p : top;
    const int t = left[top];
    const S pivot = a[t][t];
    least = pivot < least ? pivot : least;
    if (!(pivot > 0)) return 0;
    left[top] = left[count - 1];
    for (int p = 0; p < count - 1; p++)
      for (int q = 0; q < count - 1; q++) a[left[p]][left[q]] -= a[left[p]][t] * a[t][left[q]] / pivot;
  }
  return least;
}

/* One candidate: match, and move by the motor of the matches, near ones weighing more, until it stays. */
BS_OUTLINED void FN(refine)(const bs_reform *s, const bs_refined *c, ptrdiff_t n)
{
  S *motor = c->motors + BS_MOTOR * n, next[BS_MOTOR], element[BS_NUMBERS], square, sign;
  c->taken[n] = -1;
  for (ptrdiff_t round = 0; round < c->rounds; round++) {
    S form[BS_FORM] = {0}, change = 0, agree = 0;
    for (ptrdiff_t i = 0; i < s->asked; i++) {
      const int kind = s->asked_kinds[i];
      const S *x = FN(asked_row)(s, i);
      FN(moved_element)(kind, element, motor, x);
      const ptrdiff_t j = FN(nearest)(s, kind, element, &square, &sign);
      if (j < 0) continue;
      const S near = K(1) - square / s->limit;
      FN(add_form)(form, kind, x, s->reference.rows[kind] + FN(row_size)(kind) * j, sign, near * near);
    }
    if (!(FN(form_motor)(next, form) >= 0)) break;
    for (int k = 0; k < BS_MOTOR; k++) agree += next[k] * motor[k];
    for (int k = 0; k < BS_MOTOR; k++) {
      const S value = agree < 0 ? -next[k] : next[k];
      change += (value - motor[k]) * (value - motor[k]);
      motor[k] = value;
    }
    c->taken[n] = (int32_t)round + 1;
    if (change <= c->settled) break;
  }
  int32_t tested;
  c->scores[n] = FN(score)(s, motor, 0, c->hits + n, &tested);
}

BS_OUTLINED void FN(match)(const bs_reform *s, const bs_matching *m, ptrdiff_t i)
{
  S element[BS_NUMBERS];
  FN(moved_element)(s->asked_kinds[i], element, m->motor, FN(asked_row)(s, i));
  m->indices[i] = (int32_t)FN(nearest)(s, s->asked_kinds[i], element, m->distances + i, m->signs + i);
}

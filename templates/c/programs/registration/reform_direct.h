/* Algorithm 1 of the thesis, corrected: over and over through the matches, at each one half of the way that is left. */

BS_INLINE int FN(is_motor_finite)(const S *motor)
{
  S total = 0;
  for (int k = 0; k < BS_MOTOR; k++) total += motor[k];
  return total - total == 0;
}

/* One match: what is not finite (objects that face each other, centres that are one) changes nothing; 0 then. */
BS_OUTLINED int FN(direct_step)(const bs_reform *s, const bs_direct *d, ptrdiff_t i)
{
  const int kind = d->kinds[i];
  const ptrdiff_t size = FN(row_size)(kind), other = d->partners[i];
  const S *x = s->query.rows[kind] + size * d->query[i], *y = s->reference.rows[kind] + size * d->reference[i];
  S next[BS_MOTOR];
  int done = 0;
  if (other >= 0)
    done = FN(half_step_of_two)(kind, next, d->motor, x, y, s->query.rows[kind] + size * d->query[other],
                                s->reference.rows[kind] + size * d->reference[other]);
  if (!done || !FN(is_motor_finite)(next)) FN(half_step)(kind, next, d->motor, x, y, d->signs + i);
  if (!FN(is_motor_finite)(next)) return 0;
  for (int k = 0; k < BS_MOTOR; k++) d->motor[k] = next[k];
  return 1;
}

BS_OUTLINED void FN(direct)(const bs_reform *s, bs_direct *d)
{
  d->taken = d->skipped = 0;
  while (d->taken < d->rounds) {
    S before[BS_MOTOR], sum[BS_MOTOR] = {0}, change;
    for (int k = 0; k < BS_MOTOR; k++) before[k] = d->motor[k];
    d->skipped = 0;
    for (ptrdiff_t i = 0; i < d->count; i++) {
      d->skipped += !FN(direct_step)(s, d, i);
      for (int k = 0; k < BS_MOTOR; k++) sum[k] += d->motor[k];
    }
    FN(cga3d_near_motor)(d->mean, sum);
    FN(cga3d_change)(&change, d->motor, before);
    d->changes[d->taken++] = change;
    if (change < d->tolerance) break;
  }
}

/* Whether the row that is asked goes before that of the hit found so far, which is as near. */
BS_OUTLINED int FN(precedes)(const ptrdiff_t state[BS_LENGTH(10)], const ptrdiff_t *integers)
{
  const ptrdiff_t own = integers[integers[16 + 4 * state[2] + 3] + state[3]];
  const ptrdiff_t other = integers[integers[16 + 4 * state[4] + 3] + state[5]];
  const int found = (own < other) || (own == other && state[3] < state[5]);
  return found;
}

/* The place of a hit at t, if it is wanted, else -1: the caller fills in its points. */
BS_INLINE ptrdiff_t FN(accept_hit)(S t, S alpha, S search[BS_LENGTH(4)], S *hits, ptrdiff_t state[BS_LENGTH(10)],
    const ptrdiff_t *integers)
{
  if (!(t > search[0] && t <= search[1])) {
    return -1;
  }
  if (state[0] == 1) {
    if (t == search[1]) {
      if (state[1] == 0) {
        return -1;
      }
      const int result = FN(precedes)(state, integers);
      if (!result) {
        return -1;
      }
    }
    state[1] = 0;
    search[1] = t;
    state[4] = state[2];
    state[5] = state[3];
  } else {
    if (state[1] == state[0]) {
      return -1;
    }
  }
  const ptrdiff_t place = state[1];
  state[1] = place + 1;
  const ptrdiff_t hit_at = 9 * place;
  hits[hit_at] = t;
  hits[hit_at + 1] = alpha;
  return place;
}

/* Length of a vector. */
BS_INLINE S FN(length)(const S x[BS_LENGTH(3)])
{
  return SQRT(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
}

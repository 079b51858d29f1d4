/* bladesmith: kernels called by number. Before it: `bs_tables`, the loop in use of each, double and single precision. */
void bs_run(int kernel, int single, ptrdiff_t begin, ptrdiff_t end, void *const *outs, const void *const *ins,
    const ptrdiff_t *strides)
{
  bs_tables[single][kernel](begin, end, outs, ins, strides);
}

void bs_run1(int kernel, int single, ptrdiff_t n, void *out, const void *a, ptrdiff_t sa)
{
  bs_tables[single][kernel](0, n, &out, &a, &sa);
}

void bs_run2(int kernel, int single, ptrdiff_t n, void *out, const void *a, ptrdiff_t sa, const void *b, ptrdiff_t sb)
{
  const void *const ins[2] = {a, b};
  const ptrdiff_t strides[2] = {sa, sb};
  bs_tables[single][kernel](0, n, &out, ins, strides);
}

/* A bound call: pointers kept by the caller. */
typedef struct { int kernel, single; ptrdiff_t n; void *outs[8]; const void *ins[16]; ptrdiff_t strides[16]; } bs_plan;

void bs_run_plan(const bs_plan *plan)
{
  bs_tables[plan->single][plan->kernel](0, plan->n, plan->outs, plan->ins, plan->strides);
}

/* A kernel as a function of single items: where its results stand in the memory of a call, in bytes from its beginning,
 * and their numbers of numbers; 0 of a status. */
typedef struct { int kernel, single, count; ptrdiff_t places[8], sizes[8]; } bs_item;

/* One item of a kernel of up to four operands; returns 1 for a number that is not finite, 2 for a status, 0 for neither. */
int bs_run_item(const bs_item *item, void *out, const void *a, const void *b, const void *c, const void *d)
{
  const void *const ins[4] = {a, b, c, d};
  const ptrdiff_t strides[4] = {0, 0, 0, 0};
  char *const first = (char *)out;
  void *outs[8];
  int found = 0;
  for (int o = 0; o < item->count; o++) outs[o] = &first[item->places[o]];
  bs_tables[item->single][item->kernel](0, 1, outs, ins, strides);
  for (int o = 0; o < item->count; o++) {
    const ptrdiff_t size = item->sizes[o];
    if (!size && *(const unsigned char *)outs[o]) found |= 2;
    for (ptrdiff_t i = 0; i < size; i++) {
      if (!isfinite(item->single ? ((const float *)outs[o])[i] : ((const double *)outs[o])[i])) found |= 1;
    }
  }
  return found;
}

/* Rows of b at a time: they stay in the nearest cache while the rows of a pass by. */
#define BS_TILE 256

/* A kernel of two operands on all pairs: rows [begin, end) of a, each with all m rows of b. A row of a has row_a bytes;
 * each of the `count` results is (n, m) items of that many bytes as its width says. */
void bs_run_pairs(int kernel, int single, ptrdiff_t begin, ptrdiff_t end, ptrdiff_t m, int count, void *const *outs,
    const ptrdiff_t *widths, const void *a, ptrdiff_t row_a, const void *b)
{
  const ptrdiff_t strides[2] = {0, 1};
  for (ptrdiff_t first = 0; first < m; first += BS_TILE) {
    const ptrdiff_t last = m - first > BS_TILE ? first + BS_TILE : m;
    for (ptrdiff_t i = begin; i < end; i++) {
      const void *const ins[2] = {(const char *)a + i * row_a, b};
      void *places[8];
      for (int o = 0; o < count; o++) places[o] = (char *)outs[o] + i * m * widths[o];
      bs_tables[single][kernel](first, last, places, ins, strides);
    }
  }
}

static void bs_nearest_double(bs_batch batch, ptrdiff_t begin, ptrdiff_t end, ptrdiff_t m, int64_t *index,
    double *least, const char *a, ptrdiff_t row_a, const char *b, ptrdiff_t row_b)
{
  const ptrdiff_t strides[2] = {0, 1};
  double values[BS_TILE];
  void *const out = values;
  for (ptrdiff_t i = begin; i < end; i++) {
    index[i] = -1;
    least[i] = HUGE_VAL;
  }
  for (ptrdiff_t first = 0; first < m; first += BS_TILE) {
    const ptrdiff_t count = m - first > BS_TILE ? BS_TILE : m - first;
    for (ptrdiff_t i = begin; i < end; i++) {
      const void *const ins[2] = {a + i * row_a, b + first * row_b};
      batch(0, count, &out, ins, strides);
      for (ptrdiff_t j = 0; j < count; j++) {
        if (values[j] < least[i]) {
          least[i] = values[j];
          index[i] = first + j;
        }
      }
    }
  }
}

static void bs_nearest_float(bs_batch batch, ptrdiff_t begin, ptrdiff_t end, ptrdiff_t m, int64_t *index,
    float *least, const char *a, ptrdiff_t row_a, const char *b, ptrdiff_t row_b)
{
  const ptrdiff_t strides[2] = {0, 1};
  float values[BS_TILE];
  void *const out = values;
  for (ptrdiff_t i = begin; i < end; i++) {
    index[i] = -1;
    least[i] = HUGE_VALF;
  }
  for (ptrdiff_t first = 0; first < m; first += BS_TILE) {
    const ptrdiff_t count = m - first > BS_TILE ? BS_TILE : m - first;
    for (ptrdiff_t i = begin; i < end; i++) {
      const void *const ins[2] = {a + i * row_a, b + first * row_b};
      batch(0, count, &out, ins, strides);
      for (ptrdiff_t j = 0; j < count; j++) {
        if (values[j] < least[i]) {
          least[i] = values[j];
          index[i] = first + j;
        }
      }
    }
  }
}

/* For rows [begin, end) of a, the row of b with the least value of a kernel of two operands and one number, and that
 * value: of equal ones the first, never NaN; -1 and +infinity where none is left. No (n, m) values are stored. */
void bs_run_nearest(int kernel, int single, ptrdiff_t begin, ptrdiff_t end, ptrdiff_t m, int64_t *index, void *least,
    const void *a, ptrdiff_t row_a, const void *b, ptrdiff_t row_b)
{
  const bs_batch batch = bs_tables[single][kernel];
  if (single) bs_nearest_float(batch, begin, end, m, index, (float *)least, a, row_a, b, row_b);
  else bs_nearest_double(batch, begin, end, m, index, (double *)least, a, row_a, b, row_b);
}

/* bladesmith: the table-driven product of sparse multivectors, for one instance (precision and vector width).
 *
 * out[k] = sum over the terms of k of weight * (a[left] * b[right]), in the order of the table: any bilinear
 * product of any algebra. Items are taken GENERAL_BLOCKS * W at a time, transposed, so that the table is read once
 * for all of them; single items and the tail read their rows directly. All ways give the same bits.
 */
#define GENERAL_BLOCKS (BS_BYTES == 64 ? 1 : 2) /* as much of the cache */
#define GENERAL_ITEMS (GENERAL_BLOCKS * W)

static void FN(product_rows)(const bs_product *p, S *out, const S *a, const S *b)
{
  for (int k = 0; k < p->size; k++) {
    S sum = 0;
    for (int t = p->starts[k]; t < p->starts[k + 1]; t++) sum += (S)p->weights[t] * (a[p->left[t]] * b[p->right[t]]);
    out[k] = sum;
  }
}

/* Rows of GENERAL_ITEMS items to columns: tile[j * GENERAL_BLOCKS + c] holds coefficient j of block c. */
static void FN(product_load)(V *tile, const S *rows, ptrdiff_t stride, int size)
{
  for (int item = 0; item < GENERAL_ITEMS; item++)
    for (int j = 0; j < size; j++) ((S *)tile)[j * GENERAL_ITEMS + item] = rows[item * stride + j];
}

static void FN(product_tile)(const bs_product *p, S *out, const V *a, const V *b)
{
  for (int k = 0; k < p->size; k++) {
    V sum[GENERAL_BLOCKS];
    for (int c = 0; c < GENERAL_BLOCKS; c++) sum[c] = SPLAT(0);
    for (int t = p->starts[k]; t < p->starts[k + 1]; t++) {
      const V *const x = a + (ptrdiff_t)p->left[t] * GENERAL_BLOCKS;
      const V *const y = b + (ptrdiff_t)p->right[t] * GENERAL_BLOCKS;
      const V weight = SPLAT(p->weights[t]);
      for (int c = 0; c < GENERAL_BLOCKS; c++) sum[c] += weight * (x[c] * y[c]);
    }
    for (int item = 0; item < GENERAL_ITEMS; item++) out[(ptrdiff_t)item * p->size + k] = ((const S *)sum)[item];
  }
}

/* A stride is 0 (one operand for all items) or the number of coefficients of a row. */
static void FN(product_batch)(const bs_product *p, ptrdiff_t begin, ptrdiff_t end, void *outs, const void *as,
    ptrdiff_t stride_a, const void *bs, ptrdiff_t stride_b)
{
  S *const out = (S *)outs;
  const S *const a = (const S *)as, *const b = (const S *)bs;
  ptrdiff_t i = begin;
  void *memory = NULL; /* without it, item by item */
  if (end - begin >= GENERAL_ITEMS)
    memory = malloc(sizeof(V) * (GENERAL_BLOCKS * ((size_t)p->size_a + (size_t)p->size_b) + 1));
  if (memory != NULL) {
    V *const tile_a = (V *)(((uintptr_t)memory + sizeof(V) - 1) & ~(uintptr_t)(sizeof(V) - 1));
    V *const tile_b = tile_a + (size_t)p->size_a * GENERAL_BLOCKS;
    if (!stride_a) FN(product_load)(tile_a, a, 0, p->size_a);
    if (!stride_b) FN(product_load)(tile_b, b, 0, p->size_b);
    for (; i + GENERAL_ITEMS <= end; i += GENERAL_ITEMS) {
      if (stride_a) FN(product_load)(tile_a, a + i * stride_a, stride_a, p->size_a);
      if (stride_b) FN(product_load)(tile_b, b + i * stride_b, stride_b, p->size_b);
      FN(product_tile)(p, out + i * p->size, tile_a, tile_b);
    }
    free(memory);
  }
  for (; i < end; i++) FN(product_rows)(p, out + i * p->size, a + i * stride_a, b + i * stride_b);
}

#undef GENERAL_BLOCKS
#undef GENERAL_ITEMS

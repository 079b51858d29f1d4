/* bladesmith: what printed algorithms need beside instance.h. Integers behave as in Python: quotients are rounded
 * down; by zero they are zero. */
#ifndef BLADESMITH_LOOPS_H
#define BLADESMITH_LOOPS_H

#ifndef BS_OUTLINED
#define BS_OUTLINED static
#endif

BS_INLINE ptrdiff_t bs_min(ptrdiff_t a, ptrdiff_t b) { return b < a ? b : a; }
BS_INLINE ptrdiff_t bs_max(ptrdiff_t a, ptrdiff_t b) { return b > a ? b : a; }
BS_INLINE ptrdiff_t bs_magnitude(ptrdiff_t a) { return a < 0 ? -a : a; }

BS_INLINE ptrdiff_t bs_quotient(ptrdiff_t a, ptrdiff_t b)
{
  if (b == 0) return 0;
  if (b == -1) return -a;
  return a / b - (a % b != 0 && (a < 0) != (b < 0));
}

BS_INLINE ptrdiff_t bs_remainder(ptrdiff_t a, ptrdiff_t b)
{
  if (b == 0 || b == -1) return 0;
  const ptrdiff_t r = a % b;
  return r != 0 && (r < 0) != (b < 0) ? r + b : r;
}

#endif

/* Of one instance: as min and max of Python, the first unless the second is less or greater. */
BS_INLINE S FN(bs_min)(S a, S b) { return b < a ? b : a; }
BS_INLINE S FN(bs_max)(S a, S b) { return b > a ? b : a; }

#ifdef BS_LANES /* With rows.h: of W items, each a lane of a V; beyond the last item the last again. */
/* Numbers of a row from each item, rows a stride apart. */
BS_INLINE void FN(bs_gather)(V *to, const S *rows, ptrdiff_t stride, ptrdiff_t size, int lanes)
{
  ptrdiff_t start[W], k = 0;
  for (int l = 0; l < W; l++) start[l] = (l < lanes ? l : lanes - 1) * stride;
#if BS_BITS == 64 && BS_BYTES >= 32
  for (; k + 4 <= size; k += 4) FN(load_square)(to + k, rows + k, start, 0);
#endif
#if BS_BYTES != 0
  for (; k + 128 / BS_BITS <= size; k += 128 / BS_BITS) FN(load_block)(to + k, rows + k, start, 0);
#endif
  for (; k < size; k++)
    for (int l = 0; l < W; l++) ((S *)(to + k))[l] = rows[start[l] + k];
}

/* And back. */
BS_INLINE void FN(bs_scatter)(const V *from, S *rows, ptrdiff_t stride, ptrdiff_t size, int lanes)
{
  ptrdiff_t start[W], k = 0;
  for (int l = 0; l < W; l++) start[l] = (l < lanes ? l : lanes - 1) * stride;
#if BS_BITS == 64 && BS_BYTES >= 32
  for (; k + 4 <= size; k += 4) FN(store_square)(rows + k, from + k, start, 0);
#endif
#if BS_BYTES != 0
  for (; k + 128 / BS_BITS <= size; k += 128 / BS_BITS) FN(store_block)(rows + k, from + k, start, 0);
#endif
  for (; k < size; k++)
    for (int l = 0; l < W; l++) rows[start[l] + k] = ((const S *)(from + k))[l];
}
#endif

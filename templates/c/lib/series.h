/* bladesmith: products of power series in vector lanes: algorithms/series/recurrences.py. The bits do not depend on the
   width. BS_SERIES_BYTES: of a vector; where it is not given, what every machine has. */
#ifndef BS_SERIES_BYTES
#define BS_SERIES_BYTES (BS_VECTORS ? 16 : 8)
#endif
#if BS_VECTORS
typedef S FN(series_lanes) __attribute__((vector_size(BS_SERIES_BYTES), aligned(sizeof(S)), may_alias));
#else
typedef S FN(series_lanes);
#endif

/* So many vectors of them, in registers: 8 are half the registers of every machine. */
#define BS_LANES(row, i) ((FN(series_lanes) *)(row))[i]
#define BS_BEGIN(i) FN(series_lanes) c##i = BS_LANES(x, i) * BS_LANES(y, i);
#define BS_ADD(i) c##i += BS_LANES(x, i) * BS_LANES(y, i);
#define BS_END(i) BS_LANES(products, i) = c##i;
#define BS_CONVOLVE(n, EACH)                                                                         \
  BS_OUTLINED BS_UNUSED void FN(convolve_##n)(ptrdiff_t k, ptrdiff_t count, S *x, S *y, S *products) \
  {                                                                                                  \
    y += count * k;                                                                                  \
    EACH(BS_BEGIN)                                                                                   \
    for (ptrdiff_t j = 0; j < k; j++) {                                                              \
      x += count, y -= count;                                                                        \
      EACH(BS_ADD)                                                                                   \
    }                                                                                                \
    EACH(BS_END)                                                                                     \
  }
#define BS_EACH_1(DO) DO(0)
#define BS_EACH_2(DO) BS_EACH_1(DO) DO(1)
#define BS_EACH_3(DO) BS_EACH_2(DO) DO(2)
#define BS_EACH_4(DO) BS_EACH_3(DO) DO(3)
#define BS_EACH_5(DO) BS_EACH_4(DO) DO(4)
#define BS_EACH_6(DO) BS_EACH_5(DO) DO(5)
#define BS_EACH_7(DO) BS_EACH_6(DO) DO(6)
#define BS_EACH_8(DO) BS_EACH_7(DO) DO(7)
BS_CONVOLVE(1, BS_EACH_1)
BS_CONVOLVE(2, BS_EACH_2)
BS_CONVOLVE(3, BS_EACH_3)
BS_CONVOLVE(4, BS_EACH_4)
BS_CONVOLVE(5, BS_EACH_5)
BS_CONVOLVE(6, BS_EACH_6)
BS_CONVOLVE(7, BS_EACH_7)
BS_CONVOLVE(8, BS_EACH_8)

/* Products of pairs of series, which stand beside each other in rows of count numbers, a multiple of four. */
BS_INLINE void FN(convolve)(ptrdiff_t k, ptrdiff_t count, S *x, S *y, S *products)
{
  const ptrdiff_t lanes = sizeof(FN(series_lanes)) / sizeof(S), whole = count / (8 * lanes) * (8 * lanes);
  for (ptrdiff_t i = 0; i < whole; i += 8 * lanes) FN(convolve_8)(k, count, x + i, y + i, products + i);
  x += whole, y += whole, products += whole;
  switch ((count - whole) / lanes) {
  case 1: FN(convolve_1)(k, count, x, y, products); break;
  case 2: FN(convolve_2)(k, count, x, y, products); break;
  case 3: FN(convolve_3)(k, count, x, y, products); break;
  case 4: FN(convolve_4)(k, count, x, y, products); break;
  case 5: FN(convolve_5)(k, count, x, y, products); break;
  case 6: FN(convolve_6)(k, count, x, y, products); break;
  case 7: FN(convolve_7)(k, count, x, y, products); break;
  default: break;
  }
}

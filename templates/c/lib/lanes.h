/* bladesmith: what algorithms on W items at once need beside loops.h and rows.h. Of each item a lane of a V, of an I
 * (integers of as many bits) or of an M (a mask). Elements whose places differ between items are read and written one
 * by one; a place that no item means is in the array.
 */
#if BS_BYTES == 0
#define BS_EACH 1
#define BS_NONE 0
#define BS_SET(v, l, x) ((v) = (x))
#else
#define BS_EACH (~(M){0})
#define BS_NONE ((M){0})
#define BS_SET(v, l, x) ((v)[l] = (x))
#endif
#if BS_BITS == 64
#define BS_MOST_INTEGER 9223372036854774784.0
#else
#define BS_MOST_INTEGER 2147483520.0f
#endif

/* One integer, or truth value, for all items. */
BS_INLINE I FN(bs_spread)(ptrdiff_t x)
{
#if BS_BYTES == 0
  return (I)x;
#else
  return (I){0} + (BS_INT)x;
#endif
}

BS_INLINE M FN(bs_mask)(int holds)
{
#if BS_BYTES == 0
  return holds != 0;
#else
  return FN(bs_spread)(holds ? -1 : 0);
#endif
}

BS_INLINE I FN(bs_choose)(M m, I a, I b)
{
#if BS_BYTES == 0
  return m ? a : b;
#else
  return (m & a) | (~m & b);
#endif
}

BS_INLINE V FN(bs_least)(V a, V b) { return SELECT(LT(b, a), b, a); }
BS_INLINE V FN(bs_most)(V a, V b) { return SELECT(GT(b, a), b, a); }
BS_INLINE I FN(bs_least_of)(I a, I b) { return FN(bs_choose)(b < a, b, a); }
BS_INLINE I FN(bs_most_of)(I a, I b) { return FN(bs_choose)(b > a, b, a); }
BS_INLINE I FN(bs_magnitudes)(I a) { return FN(bs_choose)(a < 0, -a, a); }
BS_INLINE I FN(bs_shifted)(I a, I b) { return (I)((UI)a << ((UI)b % BS_BITS)); }
BS_INLINE I FN(bs_shifted_back)(I a, I b) { return a >> (I)((UI)b % BS_BITS); }

#define BS_EACH_LANE for (int l = 0; l < W; l++)

BS_INLINE V FN(bs_reals)(I a)
{
  V v = SPLAT(0);
  BS_UNROLL
  BS_EACH_LANE BS_SET(v, l, (S)BS_LANE(a, l));
  return v;
}

/* Without what follows the point; zero for what no integer is. */
BS_INLINE I FN(bs_cut)(V v)
{
  I a = FN(bs_spread)(0);
  BS_UNROLL
  BS_EACH_LANE
  {
    const S x = BS_LANE(v, l);
    BS_SET(a, l, x >= -BS_MOST_INTEGER && x <= BS_MOST_INTEGER ? (BS_INT)x : 0);
  }
  return a;
}

/* Not inlined: gcc 12 makes -1 of the quotient a / a of lanes (its vectorizer takes the 1 for a mask). */
BS_COLD ptrdiff_t FN(bs_quotient_of_lane)(ptrdiff_t a, ptrdiff_t b) { return bs_quotient(a, b); }
BS_COLD ptrdiff_t FN(bs_remainder_of_lane)(ptrdiff_t a, ptrdiff_t b) { return bs_remainder(a, b); }

BS_INLINE I FN(bs_quotients)(I a, I b)
{
  I c = a;
  BS_UNROLL
  BS_EACH_LANE BS_SET(c, l, (BS_INT)FN(bs_quotient_of_lane)(BS_LANE(a, l), BS_LANE(b, l)));
  return c;
}

BS_INLINE I FN(bs_remainders)(I a, I b)
{
  I c = a;
  BS_UNROLL
  BS_EACH_LANE BS_SET(c, l, (BS_INT)FN(bs_remainder_of_lane)(BS_LANE(a, l), BS_LANE(b, l)));
  return c;
}

/* Elements of arrays that each item has, and of one that they share. */
#define BS_TAKE(name, type, vector, number)                         \
  BS_INLINE vector FN(name)(const type *from, I places)             \
  {                                                                 \
    vector v = {0};                                                 \
    BS_UNROLL                                                       \
    BS_EACH_LANE BS_SET(v, l, (number)BS_ELEMENT(from, l, places)); \
    return v;                                                       \
  }
#define BS_ELEMENT(from, l, places) BS_LANE(from[BS_LANE(places, l)], l)
BS_TAKE(bs_take, V, V, S)
BS_TAKE(bs_take_integers, I, I, BS_INT)
#undef BS_ELEMENT
#define BS_ELEMENT(from, l, places) from[BS_LANE(places, l)]
BS_TAKE(bs_take_common, S, V, S)
BS_TAKE(bs_take_common64, ptrdiff_t, I, BS_INT)
BS_TAKE(bs_take_common32, int32_t, I, BS_INT)
BS_TAKE(bs_take_common8, uint8_t, I, BS_INT)
#undef BS_ELEMENT
#undef BS_TAKE

BS_INLINE void FN(bs_put)(V *to, I places, V v)
{
  BS_UNROLL
  BS_EACH_LANE BS_SET(to[BS_LANE(places, l)], l, BS_LANE(v, l));
}

BS_INLINE void FN(bs_put_integers)(I *to, I places, I v)
{
  BS_UNROLL
  BS_EACH_LANE BS_SET(to[BS_LANE(places, l)], l, BS_LANE(v, l));
}

/* Where the row of each item starts, rows a stride apart; beyond the last item that of the last again. */
BS_INLINE void FN(bs_starts)(ptrdiff_t *start, ptrdiff_t stride, int lanes)
{
  for (int l = 0; l < W; l++) start[l] = (l < lanes ? l : lanes - 1) * stride;
}

/* Numbers of a row from each item. */
BS_INLINE void FN(bs_gather)(V *to, const S *rows, ptrdiff_t stride, ptrdiff_t size, int lanes)
{
  ptrdiff_t start[W], k = 0;
  FN(bs_starts)(start, stride, lanes);
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
  FN(bs_starts)(start, stride, lanes);
#if BS_BITS == 64 && BS_BYTES >= 32
  for (; k + 4 <= size; k += 4) FN(store_square)(rows + k, from + k, start, 0);
#endif
#if BS_BYTES != 0
  for (; k + 128 / BS_BITS <= size; k += 128 / BS_BITS) FN(store_block)(rows + k, from + k, start, 0);
#endif
  for (; k < size; k++)
    for (int l = 0; l < W; l++) rows[start[l] + k] = ((const S *)(from + k))[l];
}

/* The same of integers, by the type in which they are stored. */
#define BS_ROWS(type, bits)                                                                                   \
  BS_INLINE void FN(bs_gather##bits)(I to[], const type *rows, ptrdiff_t stride, ptrdiff_t size, int lanes)   \
  {                                                                                                           \
    ptrdiff_t start[W];                                                                                       \
    FN(bs_starts)(start, stride, lanes);                                                                      \
    for (ptrdiff_t k = 0; k < size; k++) BS_EACH_LANE BS_SET(to[k], l, (BS_INT)rows[start[l] + k]);           \
  }                                                                                                           \
  BS_INLINE void FN(bs_scatter##bits)(const I *from, type *rows, ptrdiff_t stride, ptrdiff_t size, int lanes) \
  {                                                                                                           \
    ptrdiff_t start[W];                                                                                       \
    FN(bs_starts)(start, stride, lanes);                                                                      \
    for (ptrdiff_t k = 0; k < size; k++) BS_EACH_LANE rows[start[l] + k] = (type)BS_LANE(from[k], l);         \
  }
BS_ROWS(ptrdiff_t, 64)
BS_ROWS(int32_t, 32)
BS_ROWS(uint8_t, 8)
#undef BS_ROWS
#undef BS_EACH_LANE
#undef BS_MOST_INTEGER

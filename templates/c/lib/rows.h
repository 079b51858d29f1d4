/* bladesmith: rows of an ordinary C-contiguous (n, k) array to one vector per column, and back.
 *
 * load_rows reads W consecutive rows of k numbers: lane l of dst[j] is number j of row l. Transposes are made in
 * registers, on blocks of 16 bytes x 16 bytes; where k is not a multiple of the block, the last block overlaps the
 * one before. The _tail forms take fewer rows than W: missing rows are read from the last real one, and nothing
 * beyond it is touched. k is a constant at each call, so that all loops unroll and the arrays become registers.
 */
#if BS_BYTES == 0

BS_INLINE void FN(load_rows)(V *dst, const S *src, int k)
{
  BS_UNROLL
  for (int j = 0; j < k; j++) dst[j] = src[j];
}

BS_INLINE void FN(store_rows)(S *dst, const V *src, int k)
{
  BS_UNROLL
  for (int j = 0; j < k; j++) dst[j] = src[j];
}

BS_INLINE void FN(load_tail)(V *dst, const S *src, int k, int rows)
{
  (void)rows; /* one row is all there is */
  FN(load_rows)(dst, src, k);
}

BS_INLINE void FN(store_tail)(S *dst, const V *src, int k, int rows)
{
  (void)rows;
  FN(store_rows)(dst, src, k);
}

#else

/* A block is as many numbers as 16 bytes hold: 2 of 64 bits or 4 of 32. Wider vectors hold row l of a block in their
 * first 16 bytes, row l + BS_BLOCK in the next, because shuffles are cheap within 16 bytes only. Four numbers of 64 bits
 * in vectors of 32 or 64 bytes have a square block besides, in pieces of 32 bytes, with fewer loads: BS_SQUARE. */
#define BS_BLOCK (128 / BS_BITS)
#define BS_PIECES (BS_BYTES / 16)
#define BS_SQUARE (BS_BITS == 64 && BS_BYTES >= 32)
#define BS_THREES (BS_BITS == 32 || BS_BYTES == 32) /* rows of three numbers have a way of their own */

#if BS_BYTES >= 32
typedef S FN(half) __attribute__((vector_size(16)));
#define BS_HALF FN(half)
#else
#define BS_HALF V
#endif
typedef S FN(loose) __attribute__((vector_size(16), aligned(sizeof(S)), may_alias)); /* 16 bytes anywhere */
typedef S FN(loose_vector) __attribute__((vector_size(BS_BYTES), aligned(sizeof(S)), may_alias));

#if defined(__clang__)
#define BS_SHUFFLE(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#else
#define BS_SHUFFLE(a, b, ...) __builtin_shuffle(a, b, (I){__VA_ARGS__})
#endif

/* LOW and HIGH interleave the lower and the upper parts of each 16 bytes, LOW2 and HIGH2 by pairs of numbers;
 * FIRST and SECOND interleave whole vectors, EVEN and ODD undo that. */
#if BS_BITS == 64 && BS_BYTES == 16
#define BS_LOW(a, b) BS_SHUFFLE(a, b, 0, 2)
#define BS_HIGH(a, b) BS_SHUFFLE(a, b, 1, 3)
#elif BS_BITS == 64 && BS_BYTES == 64
#define BS_LOW(a, b) BS_SHUFFLE(a, b, 0, 8, 2, 10, 4, 12, 6, 14)
#define BS_HIGH(a, b) BS_SHUFFLE(a, b, 1, 9, 3, 11, 5, 13, 7, 15)
#define BS_LOW_OF_FOUR(a, b) BS_SHUFFLE(a, b, 0, 1, 8, 9, 4, 5, 12, 13)
#define BS_HIGH_OF_FOUR(a, b) BS_SHUFFLE(a, b, 2, 3, 10, 11, 6, 7, 14, 15)
#elif BS_BITS == 64
#define BS_LOW_OF_FOUR(a, b) BS_SHUFFLE(a, b, 0, 1, 4, 5)
#define BS_HIGH_OF_FOUR(a, b) BS_SHUFFLE(a, b, 2, 3, 6, 7)
#define BS_LOW(a, b) BS_SHUFFLE(a, b, 0, 4, 2, 6)
#define BS_HIGH(a, b) BS_SHUFFLE(a, b, 1, 5, 3, 7)
#elif BS_BYTES == 16
#define BS_LOW(a, b) BS_SHUFFLE(a, b, 0, 4, 1, 5)
#define BS_HIGH(a, b) BS_SHUFFLE(a, b, 2, 6, 3, 7)
#define BS_LOW2(a, b) BS_SHUFFLE(a, b, 0, 1, 4, 5)
#define BS_HIGH2(a, b) BS_SHUFFLE(a, b, 2, 3, 6, 7)
#define BS_EVEN(a, b) BS_SHUFFLE(a, b, 0, 2, 4, 6)
#define BS_ODD(a, b) BS_SHUFFLE(a, b, 1, 3, 5, 7)
#define BS_FIRST(a, b) BS_LOW(a, b)
#define BS_SECOND(a, b) BS_HIGH(a, b)
#elif BS_BYTES == 64
#define BS_LOW(a, b) BS_SHUFFLE(a, b, 0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29)
#define BS_HIGH(a, b) BS_SHUFFLE(a, b, 2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31)
#define BS_LOW2(a, b) BS_SHUFFLE(a, b, 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29)
#define BS_HIGH2(a, b) BS_SHUFFLE(a, b, 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31)
#define BS_EVEN(a, b) BS_SHUFFLE(a, b, 0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30)
#define BS_ODD(a, b) BS_SHUFFLE(a, b, 1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31)
#define BS_FIRST(a, b) BS_SHUFFLE(a, b, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23)
#define BS_SECOND(a, b) BS_SHUFFLE(a, b, 8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31)
#else
#define BS_LOW(a, b) BS_SHUFFLE(a, b, 0, 8, 1, 9, 4, 12, 5, 13)
#define BS_HIGH(a, b) BS_SHUFFLE(a, b, 2, 10, 3, 11, 6, 14, 7, 15)
#define BS_LOW2(a, b) BS_SHUFFLE(a, b, 0, 1, 8, 9, 4, 5, 12, 13)
#define BS_HIGH2(a, b) BS_SHUFFLE(a, b, 2, 3, 10, 11, 6, 7, 14, 15)
#define BS_EVEN(a, b) BS_SHUFFLE(a, b, 0, 2, 4, 6, 8, 10, 12, 14)
#define BS_ODD(a, b) BS_SHUFFLE(a, b, 1, 3, 5, 7, 9, 11, 13, 15)
#define BS_FIRST(a, b) BS_SHUFFLE(a, b, 0, 8, 1, 9, 2, 10, 3, 11)
#define BS_SECOND(a, b) BS_SHUFFLE(a, b, 4, 12, 5, 13, 6, 14, 7, 15)
#endif

BS_INLINE void FN(transpose)(V *r) /* the block in each half of r[0 .. BS_BLOCK - 1]; its own inverse */
{
#if BS_BITS == 64
  V low = BS_LOW(r[0], r[1]), high = BS_HIGH(r[0], r[1]);
  r[0] = low, r[1] = high;
#else
  V low01 = BS_LOW(r[0], r[1]), high01 = BS_HIGH(r[0], r[1]);
  V low23 = BS_LOW(r[2], r[3]), high23 = BS_HIGH(r[2], r[3]);
  r[0] = BS_LOW2(low01, low23), r[1] = BS_HIGH2(low01, low23);
  r[2] = BS_LOW2(high01, high23), r[3] = BS_HIGH2(high01, high23);
#endif
}

BS_INLINE BS_HALF FN(load_half)(const S *src) { return (BS_HALF)(*(const FN(loose) *)src); }

BS_INLINE void FN(store_half)(S *dst, BS_HALF v) { *(FN(loose) *)dst = (FN(loose))v; }

#if BS_BYTES >= 32 /* gcc folds a memory operand into the instruction only when it is called by name */
typedef S FN(piece32) __attribute__((vector_size(32)));

BS_INLINE FN(piece32) FN(join)(BS_HALF a, BS_HALF b)
{
#if defined(__clang__) && BS_BITS == 64
  return __builtin_shufflevector(a, b, 0, 1, 2, 3);
#elif defined(__clang__)
  return __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7);
#elif BS_BITS == 64
  return __builtin_ia32_vinsertf128_pd256(__builtin_ia32_pd256_pd(a), b, 1);
#else
  return __builtin_ia32_vinsertf128_ps256(__builtin_ia32_ps256_ps(a), b, 1);
#endif
}

BS_INLINE BS_HALF FN(lower)(FN(piece32) v)
{
#if defined(__clang__) && BS_BITS == 64
  return __builtin_shufflevector(v, v, 0, 1);
#elif defined(__clang__)
  return __builtin_shufflevector(v, v, 0, 1, 2, 3);
#elif BS_BITS == 64
  return __builtin_ia32_pd_pd256(v);
#else
  return __builtin_ia32_ps_ps256(v);
#endif
}

BS_INLINE BS_HALF FN(upper)(FN(piece32) v)
{
#if defined(__clang__) && BS_BITS == 64
  return __builtin_shufflevector(v, v, 2, 3);
#elif defined(__clang__)
  return __builtin_shufflevector(v, v, 4, 5, 6, 7);
#elif BS_BITS == 64
  return __builtin_ia32_vextractf128_pd256(v, 1);
#else
  return __builtin_ia32_vextractf128_ps256(v, 1);
#endif
}
#endif

#if BS_BYTES == 64
typedef S FN(loose32) __attribute__((vector_size(32), aligned(sizeof(S)), may_alias));

BS_INLINE V FN(join32)(FN(piece32) a, FN(piece32) b)
{
#if defined(__clang__) && BS_BITS == 64
  return __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7);
#elif defined(__clang__)
  return __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
#elif BS_BITS == 64
  const V whole = __builtin_ia32_pd512_256pd(a);
  return __builtin_ia32_insertf64x4_mask(whole, b, 1, whole, (unsigned char)-1);
#else
  const V whole = __builtin_ia32_ps512_256ps(a);
  return __builtin_ia32_insertf32x8_mask(whole, b, 1, whole, (unsigned short)-1);
#endif
}

BS_INLINE FN(piece32) FN(half32)(V v, int upper)
{
#if defined(__clang__) && BS_BITS == 64
  return upper ? __builtin_shufflevector(v, v, 4, 5, 6, 7) : __builtin_shufflevector(v, v, 0, 1, 2, 3);
#elif defined(__clang__)
  return upper ? __builtin_shufflevector(v, v, 8, 9, 10, 11, 12, 13, 14, 15)
               : __builtin_shufflevector(v, v, 0, 1, 2, 3, 4, 5, 6, 7);
#elif BS_BITS == 64
  const FN(piece32) none = {0};
  return upper ? __builtin_ia32_extractf64x4_mask(v, 1, none, (unsigned char)-1)
               : __builtin_ia32_extractf64x4_mask(v, 0, none, (unsigned char)-1);
#else
  const FN(piece32) none = {0};
  return upper ? __builtin_ia32_extractf32x8_mask(v, 1, none, (unsigned char)-1)
               : __builtin_ia32_extractf32x8_mask(v, 0, none, (unsigned char)-1);
#endif
}
#endif

/* A vector of 16 bytes of each of BS_PIECES rows; and piece l of a vector. */
BS_INLINE V FN(join_pieces)(const BS_HALF *p)
{
#if BS_BYTES == 64
  return FN(join32)(FN(join)(p[0], p[1]), FN(join)(p[2], p[3]));
#elif BS_BYTES == 32
  return FN(join)(p[0], p[1]);
#else
  return p[0];
#endif
}

BS_INLINE BS_HALF FN(piece_of)(V v, int l)
{
#if BS_BYTES == 64
  return l & 1 ? FN(upper)(FN(half32)(v, l >> 1)) : FN(lower)(FN(half32)(v, l >> 1));
#elif BS_BYTES == 32
  return l ? FN(upper)(v) : FN(lower)(v);
#else
  (void)l;
  return v;
#endif
}

/* Columns j .. j + BS_BLOCK - 1 of the rows that start at src + start[l]. */
BS_INLINE void FN(load_block)(V *dst, const S *src, const ptrdiff_t *start, int j)
{
  V r[BS_BLOCK];
  BS_UNROLL
  for (int l = 0; l < BS_BLOCK; l++) {
    BS_HALF pieces[BS_PIECES];
    BS_UNROLL
    for (int p = 0; p < BS_PIECES; p++) pieces[p] = FN(load_half)(src + start[l + p * BS_BLOCK] + j);
    r[l] = FN(join_pieces)(pieces);
  }
  FN(transpose)(r);
  BS_UNROLL
  for (int i = 0; i < BS_BLOCK; i++) dst[j + i] = r[i];
}

/* The last row first: where several lanes share a row, the one that lies in it writes last. */
BS_INLINE void FN(store_block)(S *dst, const V *src, const ptrdiff_t *start, int j)
{
  V r[BS_BLOCK];
  BS_UNROLL
  for (int i = 0; i < BS_BLOCK; i++) r[i] = src[j + i];
  FN(transpose)(r);
  BS_UNROLL
  for (int l = W - 1; l >= 0; l--) FN(store_half)(dst + start[l] + j, FN(piece_of)(r[l % BS_BLOCK], l / BS_BLOCK));
}

#if BS_SQUARE
BS_INLINE void FN(transpose_square)(V *r) /* four by four in each 32 bytes */
{
  V low01 = BS_LOW(r[0], r[1]), high01 = BS_HIGH(r[0], r[1]);
  V low23 = BS_LOW(r[2], r[3]), high23 = BS_HIGH(r[2], r[3]);
  r[0] = BS_LOW_OF_FOUR(low01, low23), r[1] = BS_LOW_OF_FOUR(high01, high23);
  r[2] = BS_HIGH_OF_FOUR(low01, low23), r[3] = BS_HIGH_OF_FOUR(high01, high23);
}

BS_INLINE V FN(load_fours)(const S *src, const ptrdiff_t *start, int l)
{
#if BS_BYTES == 64
  return FN(join32)(
      (FN(piece32))(*(const FN(loose32) *)(src + start[l])), (FN(piece32))(*(const FN(loose32) *)(src + start[l + 4])));
#else
  return (V)(*(const FN(loose_vector) *)(src + start[l]));
#endif
}

BS_INLINE void FN(load_square)(V *dst, const S *src, const ptrdiff_t *start, int j)
{
  V r[4];
  BS_UNROLL
  for (int l = 0; l < 4; l++) r[l] = FN(load_fours)(src + j, start, l);
  FN(transpose_square)(r);
  BS_UNROLL
  for (int i = 0; i < 4; i++) dst[j + i] = r[i];
}

BS_INLINE void FN(store_square)(S *dst, const V *src, const ptrdiff_t *start, int j)
{
  V r[4];
  BS_UNROLL
  for (int i = 0; i < 4; i++) r[i] = src[j + i];
  FN(transpose_square)(r);
#if BS_BYTES == 64
  BS_UNROLL
  for (int l = W - 1; l >= 0; l--) *(FN(loose32) *)(dst + start[l] + j) = (FN(loose32))FN(half32)(r[l % 4], l / 4);
#else
  BS_UNROLL
  for (int l = W - 1; l >= 0; l--) *(FN(loose_vector) *)(dst + start[l] + j) = (FN(loose_vector))r[l];
#endif
}
#endif

/* Number by number: rows shorter than a block, where they need not lie one behind the other. */
BS_INLINE void FN(load_narrow)(V *dst, const S *src, const ptrdiff_t *start, int k)
{
  BS_UNROLL
  for (int j = 0; j < k; j++) {
    V column = SPLAT(src[start[0] + j]);
    BS_UNROLL
    for (int l = 1; l < W; l++) column[l] = src[start[l] + j];
    dst[j] = column;
  }
}

BS_INLINE void FN(store_narrow)(S *dst, const V *src, const ptrdiff_t *start, int k)
{
  BS_UNROLL
  for (int j = 0; j < k; j++) {
    BS_UNROLL
    for (int l = W - 1; l >= 0; l--) dst[start[l] + j] = src[j][l];
  }
}

BS_INLINE void FN(load_at)(V *dst, const S *src, const ptrdiff_t *start, int k)
{
  int j = 0;
  if (k < BS_BLOCK) {
    FN(load_narrow)(dst, src, start, k);
    return;
  }
#if BS_SQUARE
  BS_UNROLL
  for (; j + 4 <= k; j += 4) FN(load_square)(dst, src, start, j);
#endif
  BS_UNROLL
  for (; j + BS_BLOCK <= k; j += BS_BLOCK) FN(load_block)(dst, src, start, j);
  if (j < k) FN(load_block)(dst, src, start, k - BS_BLOCK);
}

BS_INLINE void FN(store_at)(S *dst, const V *src, const ptrdiff_t *start, int k)
{
  int j = 0;
  if (k < BS_BLOCK) {
    FN(store_narrow)(dst, src, start, k);
    return;
  }
#if BS_SQUARE
  BS_UNROLL
  for (; j + 4 <= k; j += 4) FN(store_square)(dst, src, start, j);
#endif
  BS_UNROLL
  for (; j + BS_BLOCK <= k; j += BS_BLOCK) FN(store_block)(dst, src, start, j);
  if (j < k) FN(store_block)(dst, src, start, k - BS_BLOCK);
}

#if BS_BITS == 32
/* Two numbers a row: W rows are two vectors. */
BS_INLINE void FN(load_twos)(V *dst, const S *src)
{
  V a = (V)(*(const FN(loose_vector) *)src), b = (V)(*(const FN(loose_vector) *)(src + W));
  dst[0] = BS_EVEN(a, b), dst[1] = BS_ODD(a, b);
}

BS_INLINE void FN(store_twos)(S *dst, const V *src)
{
  *(FN(loose_vector) *)dst = (FN(loose_vector))BS_FIRST(src[0], src[1]);
  *(FN(loose_vector) *)(dst + W) = (FN(loose_vector))BS_SECOND(src[0], src[1]);
}

/* Three numbers a row: a block of four reaches into the next row. The last row has none behind it: it is loaded
 * from one number earlier and shifted, and stored number by number. Rows are stored in order, so that each one
 * overwrites what the row before left in it. */
BS_INLINE void FN(load_threes)(V *dst, const S *src)
{
  BS_HALF piece[W];
  V r[BS_BLOCK];
  BS_UNROLL
  for (int l = 0; l < W - 1; l++) piece[l] = FN(load_half)(src + 3 * l);
  BS_HALF last = FN(load_half)(src + 3 * (W - 1) - 1);
  piece[W - 1] = (BS_HALF){last[1], last[2], last[3], last[3]};
  BS_UNROLL
  for (int l = 0; l < BS_BLOCK; l++) {
    BS_HALF pieces[BS_PIECES];
    BS_UNROLL
    for (int p = 0; p < BS_PIECES; p++) pieces[p] = piece[l + p * BS_BLOCK];
    r[l] = FN(join_pieces)(pieces);
  }
  FN(transpose)(r);
  dst[0] = r[0], dst[1] = r[1], dst[2] = r[2];
}

BS_INLINE void FN(store_threes)(S *dst, const V *src)
{
  V r[BS_BLOCK] = {src[0], src[1], src[2], src[2]};
  FN(transpose)(r);
  BS_UNROLL
  for (int l = 0; l < W - 1; l++) FN(store_half)(dst + 3 * l, FN(piece_of)(r[l % BS_BLOCK], l / BS_BLOCK));
  BS_UNROLL
  for (int j = 0; j < 3; j++) dst[3 * (W - 1) + j] = src[j][W - 1];
}
#endif

#if BS_THREES && BS_BITS == 64
/* Three numbers a row: four rows are three vectors. */
BS_INLINE void FN(load_threes)(V *dst, const S *src)
{
  const V a = (V)(*(const FN(loose_vector) *)src), b = (V)(*(const FN(loose_vector) *)&src[W]);
  const V c = (V)(*(const FN(loose_vector) *)&src[2 * W]);
  const V of_01 = BS_SHUFFLE(a, b, 0, 1, 6, 7), of_20 = BS_SHUFFLE(a, c, 2, 3, 4, 5),
          of_12 = BS_SHUFFLE(b, c, 0, 1, 6, 7);
  dst[0] = BS_SHUFFLE(of_01, of_20, 0, 5, 2, 7);
  dst[1] = BS_SHUFFLE(of_01, of_12, 1, 4, 3, 6);
  dst[2] = BS_SHUFFLE(of_20, of_12, 0, 5, 2, 7);
}

BS_INLINE void FN(store_threes)(S *dst, const V *src)
{
  const V of_01 = BS_LOW(src[0], src[1]), of_20 = BS_SHUFFLE(src[2], src[0], 0, 5, 2, 7),
          of_12 = BS_HIGH(src[1], src[2]);
  *(FN(loose_vector) *)dst = (FN(loose_vector))BS_LOW_OF_FOUR(of_01, of_20);
  *(FN(loose_vector) *)&dst[W] = (FN(loose_vector))BS_SHUFFLE(of_12, of_01, 0, 1, 6, 7);
  *(FN(loose_vector) *)&dst[2 * W] = (FN(loose_vector))BS_HIGH_OF_FOUR(of_20, of_12);
}
#endif

BS_INLINE void FN(load_rows)(V *dst, const S *src, int k)
{
  if (k == 1) {
    dst[0] = (V)(*(const FN(loose_vector) *)src);
    return;
  }
#if BS_BITS == 32
  if (k == 2) {
    FN(load_twos)(dst, src);
    return;
  }
#endif
#if BS_THREES
  if (k == 3) {
    FN(load_threes)(dst, src);
    return;
  }
#endif
  ptrdiff_t start[W];
  BS_UNROLL
  for (int l = 0; l < W; l++) start[l] = (ptrdiff_t)l * k;
  FN(load_at)(dst, src, start, k);
}

BS_INLINE void FN(store_rows)(S *dst, const V *src, int k)
{
  if (k == 1) {
    *(FN(loose_vector) *)dst = (FN(loose_vector))src[0];
    return;
  }
#if BS_BITS == 32
  if (k == 2) {
    FN(store_twos)(dst, src);
    return;
  }
#endif
#if BS_THREES
  if (k == 3) {
    FN(store_threes)(dst, src);
    return;
  }
#endif
  ptrdiff_t start[W];
  BS_UNROLL
  for (int l = 0; l < W; l++) start[l] = (ptrdiff_t)l * k;
  FN(store_at)(dst, src, start, k);
}

BS_INLINE void FN(load_tail)(V *dst, const S *src, int k, int rows)
{
  ptrdiff_t start[W];
  BS_UNROLL
  for (int l = 0; l < W; l++) start[l] = (ptrdiff_t)(l < rows ? l : rows - 1) * k;
  FN(load_at)(dst, src, start, k);
}

BS_INLINE void FN(store_tail)(S *dst, const V *src, int k, int rows)
{
  ptrdiff_t start[W];
  BS_UNROLL
  for (int l = 0; l < W; l++) start[l] = (ptrdiff_t)(l < rows ? l : rows - 1) * k;
  FN(store_at)(dst, src, start, k);
}

#undef BS_BLOCK
#undef BS_SQUARE
#undef BS_THREES
#undef BS_PIECES
#undef BS_LOW_OF_FOUR
#undef BS_HIGH_OF_FOUR
#undef BS_HALF
#undef BS_SHUFFLE
#undef BS_LOW
#undef BS_HIGH
#undef BS_LOW2
#undef BS_HIGH2
#undef BS_EVEN
#undef BS_ODD
#undef BS_FIRST
#undef BS_SECOND
#endif

BS_INLINE void FN(load_broadcast)(V *dst, const S *src, int k)
{
  BS_UNROLL
  for (int j = 0; j < k; j++) dst[j] = SPLAT(src[j]);
}

/* And back: what all lanes have. */
BS_INLINE void FN(store_lane)(S *dst, const V *src, int k)
{
  BS_UNROLL
  for (int j = 0; j < k; j++) dst[j] = BS_LANE(src[j], 0);
}

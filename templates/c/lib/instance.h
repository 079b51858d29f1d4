/* bladesmith: the short names of one instance (precision x vector width). instance_end.h undefines them.
 *
 * Defined before: BS_BITS (64 or 32), BS_BYTES (vector bytes: 0 plain scalar, 16, 32, 64) and BS_TAG (name suffix).
 *   S scalar; V vector of W lanes; I and UI signed and unsigned integers of the same lanes; M mask.
 *   K(x) constant of type S, good in arithmetic with a V; SPLAT(x) a V with x in all lanes.
 *   SELECT(m, a, b): a where m, else b, lane by lane, no arithmetic. Comparisons with NaN are false (NE: true).
 * The same text serves scalars, vectors and CUDA: write bodies with these names only.
 */
#if !defined(BS_BITS) || !defined(BS_BYTES) || !defined(BS_TAG)
#error "define BS_BITS, BS_BYTES and BS_TAG before instance.h"
#endif
#if BS_BYTES != 0 && (BS_BYTES != 16 && BS_BYTES != 32 && BS_BYTES != 64)
#error "BS_BYTES is 0, 16, 32 or 64"
#endif
#if BS_BYTES != 0 && !BS_VECTORS
#error "this compiler has no GNU vector extensions: use BS_BYTES 0"
#endif

#define FN(name) BS_PASTE(name, BS_TAG)

#if BS_BITS == 64
#define S double
#define BS_INT int64_t
#define BS_UINT uint64_t
#define BS_SQRT1 sqrt
#define BS_FMA1 __builtin_fma
#define BS_ABS1 fabs
#define BS_SIGN_BIT (-(int64_t)0x7fffffffffffffff - 1)
#define BS_EPSILON 2.220446049250313e-16
#define BS_GREATEST 1.7976931348623157e308
#elif BS_BITS == 32
#define S float
#define BS_INT int32_t
#define BS_UINT uint32_t
#define BS_SQRT1 sqrtf
#define BS_FMA1 __builtin_fmaf
#define BS_ABS1 fabsf
#define BS_SIGN_BIT (-(int32_t)0x7fffffff - 1)
#define BS_EPSILON 1.1920928955078125e-07
#define BS_GREATEST 3.4028234663852886e38
#else
#error "BS_BITS is 64 or 32"
#endif

#define K(x) ((S)(x))
#define LT(a, b) ((a) < (b))
#define LE(a, b) ((a) <= (b))
#define GT(a, b) ((a) > (b))
#define GE(a, b) ((a) >= (b))
#define EQ(a, b) ((a) == (b))
#define NE(a, b) ((a) != (b))

#if BS_BYTES == 0

#define W 1
#define V S
#define I BS_INT
#define UI BS_UINT
#define M int
#define AND(a, b) ((a) & (b))
#define OR(a, b) ((a) | (b))
#define NOT(m) (!(m))
#define SPLAT(x) ((S)(x))
#define SELECT(m, a, b) ((m) ? (a) : (b))
#define SQRT(v) BS_SQRT1(v)
#define ABS(v) BS_ABS1(v)
#define ANY(m) (m)
#define BS_LANE(m, l) (m)
#define BIT0(i) ((int)((i) & 1))

#if defined(__CUDACC__) && BS_BITS == 64
#define BITS(v) __double_as_longlong(v)
#define FROM_BITS(i) __longlong_as_double(i)
#elif defined(__CUDACC__)
#define BITS(v) __float_as_int(v)
#define FROM_BITS(i) __int_as_float(i)
#else
BS_INLINE I FN(bits)(V v)
{
  union {
    V v;
    I i;
  } both;
  both.v = v;
  return both.i;
}

BS_INLINE V FN(from_bits)(I i)
{
  union {
    V v;
    I i;
  } both;
  both.i = i;
  return both.v;
}
#define BITS(v) FN(bits)(v)
#define FROM_BITS(i) FN(from_bits)(i)
#endif

#else /* vectors */

#define W (BS_BYTES * 8 / BS_BITS)
#define V FN(vector)
#define I FN(integers)
#define UI FN(naturals)
#define M I

typedef S V __attribute__((vector_size(BS_BYTES)));
typedef BS_INT I __attribute__((vector_size(BS_BYTES)));
typedef BS_UINT UI __attribute__((vector_size(BS_BYTES)));

#define NOT(m) (~(m))
#define SPLAT(x) FN(splat)((S)(x))
#define SELECT(m, a, b) FN(select)(m, a, b)
#define SQRT(v) FN(sqrt)(v)
#define ABS(v) FROM_BITS(BITS(v) & ~BS_SIGN_BIT)
#define ANY(m) FN(any)(m)
#define BS_LANE(m, l) ((m)[l])
#define BIT0(i) EQ(FROM_BITS((I)(((UI)(i) & 1) << (BS_BITS - 2))), K(2)) /* mask: lane's lowest bit is set */
#define BITS(v) ((I)(v))
#define FROM_BITS(i) ((V)(i))

BS_INLINE V FN(splat)(S x)
{
#if BS_BYTES * 8 / BS_BITS == 2
  return (V){x, x};
#elif BS_BYTES * 8 / BS_BITS == 4
  return (V){x, x, x, x};
#elif BS_BYTES * 8 / BS_BITS == 8
  return (V){x, x, x, x, x, x, x, x};
#else
  return (V){x, x, x, x, x, x, x, x, x, x, x, x, x, x, x, x};
#endif
}

/* Selections and masks of masks. Compilers make one blend of the plain form where there is one. On SSE2 gcc, looking
 * for a blend of 64-bit lanes, would take them apart: there it is told what to do. */
#if defined(__x86_64__) && !defined(__clang__) && BS_BYTES == 16 && BS_BITS == 64
#define AND(a, b) ((M)__builtin_ia32_andpd((V)(a), (V)(b)))
#define OR(a, b) ((M)__builtin_ia32_orpd((V)(a), (V)(b)))
BS_INLINE V FN(select)(M m, V a, V b)
{
  return __builtin_ia32_orpd(__builtin_ia32_andpd((V)m, a), __builtin_ia32_andnpd((V)m, b));
}
#else
#define AND(a, b) ((a) & (b))
#define OR(a, b) ((a) | (b))
BS_INLINE V FN(select)(M m, V a, V b) { return (V)((m & (I)a) | (~m & (I)b)); }
#endif

BS_INLINE V FN(sqrt)(V v) /* compilers make one instruction of it */
{
  V root = v; /* each lane is replaced */
  BS_UNROLL
  for (int l = 0; l < W; l++) root[l] = BS_SQRT1(v[l]);
  return root;
}

#if BS_BYTES == 64 /* AVX-512 has it: the exact rounding error of a b, which is p, in place of Dekker's sums */
#define BS_PRODUCT_ERROR(a, b, p) FN(product_error)(a, b, p)
BS_INLINE V FN(product_error)(V a, V b, V p)
{
  V rest = p; /* each lane is replaced */
  BS_UNROLL
  for (int l = 0; l < W; l++) rest[l] = BS_FMA1(a[l], b[l], -p[l]);
  return rest;
}
#endif

BS_INLINE int FN(any)(M m)
{
#if defined(__x86_64__) && BS_BYTES == 64 && BS_BITS == 64
  typedef long long whole __attribute__((vector_size(64)));
  return __builtin_ia32_cvtq2mask512((whole)m);
#elif defined(__x86_64__) && BS_BYTES == 64
  typedef int whole __attribute__((vector_size(64)));
  return __builtin_ia32_cvtd2mask512((whole)m) != 0;
#elif defined(__x86_64__) && BS_BYTES == 32 && BS_BITS == 64
  return __builtin_ia32_movmskpd256((V)m);
#elif defined(__x86_64__) && BS_BYTES == 32
  return __builtin_ia32_movmskps256((V)m);
#elif defined(__x86_64__) && BS_BITS == 64
  return __builtin_ia32_movmskpd((V)m);
#elif defined(__x86_64__)
  return __builtin_ia32_movmskps((V)m);
#else
  BS_INT some = 0;
  BS_UNROLL
  for (int l = 0; l < W; l++) some |= m[l];
  return some != 0;
#endif
}

#endif

/* bladesmith: what differs between compilers and machines, in one place. Included once per translation unit.
 *
 * Understood: gcc and clang (vectors of 16 bytes on x86-64 and AArch64, of 32 bytes where the processor has
 * AVX2), CUDA (through NVRTC or nvcc) and any other C99 compiler, which takes the plain scalar form.
 * Needed flags: no contraction of a*b + c (-ffp-contract=off, for CUDA --fmad=false), no -ffast-math.
 */
#ifndef BLADESMITH_PLATFORM_H
#define BLADESMITH_PLATFORM_H

#if defined(__CUDACC_RTC__) /* no libc under NVRTC; its mathematical functions are built in */
typedef unsigned char uint8_t;
typedef int int32_t;
typedef unsigned int uint32_t;
typedef long long int64_t;
typedef unsigned long long uint64_t;
#define INT32_C(x) x
#define INT64_C(x) x##LL
#else
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#endif

/* BS_VECTORS: GNU vector extensions are there. BS_UNROLL: before a loop of constant length.
 * BS_COLD: a function of the rare path, never inlined. BS_PURE: its result depends on its arguments alone, so that
 * two calls are one. BS_TABLE: constants for it. BS_UNUSED: not every program needs it. */
#if defined(__CUDACC__)
#define BS_VECTORS 0
#define RESTRICT __restrict__
#define BS_INLINE static __device__ __forceinline__
#define BS_COLD static __device__ __noinline__
#define BS_PURE
#define BS_TABLE static __device__ const
#define BS_UNROLL _Pragma("unroll")
#elif defined(__GNUC__) /* clang too */
#define BS_VECTORS 1
#define RESTRICT __restrict__
#define BS_INLINE static inline __attribute__((always_inline, unused))
#define BS_COLD static __attribute__((noinline, cold, unused))
#define BS_PURE __attribute__((const))
#define BS_TABLE static const
#define BS_UNUSED __attribute__((unused))
#if defined(__clang__)
#define BS_UNROLL _Pragma("clang loop unroll(full)")
#else
#define BS_UNROLL _Pragma("GCC unroll 128")
#endif
#elif defined(_MSC_VER)
#define BS_VECTORS 0
#define RESTRICT __restrict
#define BS_INLINE static __forceinline
#define BS_COLD static __declspec(noinline)
#define BS_PURE
#define BS_TABLE static const
#define BS_UNROLL
#else
#define BS_VECTORS 0
#define RESTRICT restrict
#define BS_INLINE static inline
#define BS_COLD static
#define BS_PURE
#define BS_TABLE static const
#define BS_UNROLL
#endif
#ifndef BS_UNUSED
#define BS_UNUSED
#endif

/* Vector bytes that every machine of this target has. */
#if BS_VECTORS && (defined(__x86_64__) || defined(__aarch64__))
#define BS_BASELINE_BYTES 16
#else
#define BS_BASELINE_BYTES 0
#endif

/* The x86-64-v3 instance: everything between BS_V3_BEGIN and BS_V3_END is compiled for AVX2, and may be called
 * only where BS_CPU_HAS_V3() holds. FMA is left out on purpose: nothing is contracted. x86-64-v4, between BS_V4_BEGIN
 * and BS_V3_END, is AVX-512: the same with BS_CPU_HAS_V4(). */
#if BS_VECTORS && defined(__x86_64__)
#include <cpuid.h>

/* AVX2, and a system that keeps its registers. Not by __builtin_cpu_supports: the libraries of some compilers (zig's)
 * answer no to everything. */
static inline BS_UNUSED int bs_cpu_has_v3(void)
{
  unsigned a, b, c, d, kept;
  if (!__get_cpuid(1, &a, &b, &c, &d) || !(c & bit_OSXSAVE) || !(c & bit_AVX)) return 0;
  __asm__("xgetbv" : "=a"(kept), "=d"(d) : "c"(0));
  return (kept & 6) == 6 && __get_cpuid_count(7, 0, &a, &b, &c, &d) && (b & bit_AVX2) != 0;
}

/* AVX-512 as servers have it (F, DQ, BW, VL), and a system that keeps its registers. */
static inline BS_UNUSED int bs_cpu_has_v4(void)
{
  const unsigned needed = bit_AVX512F | bit_AVX512DQ | bit_AVX512BW | bit_AVX512VL;
  unsigned a, b, c, d, kept;
  if (!bs_cpu_has_v3()) return 0;
  __asm__("xgetbv" : "=a"(kept), "=d"(d) : "c"(0));
  return (kept & 0xe6) == 0xe6 && __get_cpuid_count(7, 0, &a, &b, &c, &d) && (b & needed) == needed;
}

#define BS_HAVE_V3 1
#define BS_CPU_HAS_V3() bs_cpu_has_v3()
#define BS_CPU_HAS_V4() bs_cpu_has_v4()
#if defined(__clang__)
#define BS_V3_BEGIN _Pragma("clang attribute push(__attribute__((target(\"avx2\"))), apply_to = function)")
/* A pragma is one literal. */
/* clang-format off */
#define BS_V4_BEGIN \
  _Pragma("clang attribute push(__attribute__((target(\"avx512f,avx512dq,avx512bw,avx512vl\"))), apply_to = function)")
/* clang-format on */
#define BS_V3_END _Pragma("clang attribute pop")
#else
#define BS_V3_BEGIN _Pragma("GCC push_options") _Pragma("GCC target(\"avx2\")")
#define BS_V4_BEGIN _Pragma("GCC push_options") _Pragma("GCC target(\"avx512f,avx512dq,avx512bw,avx512vl\")")
#define BS_V3_END _Pragma("GCC pop_options")
#endif
#else
#define BS_HAVE_V3 0
#define BS_CPU_HAS_V3() 0
#define BS_CPU_HAS_V4() 0
#define BS_V3_BEGIN
#define BS_V4_BEGIN
#define BS_V3_END
#endif

#if !defined(__CUDACC__)
/* Whether this processor runs what is compiled for a level of x86-64: 0 for all, 3 and 4 as above. */
static inline BS_UNUSED int bs_cpu_runs(int level)
{
  return level == 0 || (level == 3 && BS_CPU_HAS_V3()) || (level == 4 && BS_CPU_HAS_V4());
}
#endif

/* gcc notes that passing vectors by value changed between its versions 4.5 and 4.6. Nothing passes them across
 * a file's border here: every function that takes one is inlined. */
#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wpsabi"
#endif

#if defined(__CUDACC__)
#define BS_HUGE_VALUE __longlong_as_double(0x7ff0000000000000)
#define BS_NOT_A_NUMBER __longlong_as_double(0x7ff8000000000000)
#else
#define BS_HUGE_VALUE HUGE_VAL /* infinity */
#define BS_NOT_A_NUMBER NAN
#endif

/* Length of an array that a function takes, which compilers of C check; and such an array that no other one overlaps. */
#if defined(__cplusplus) || defined(_MSC_VER)
#define BS_LENGTH(n) n
#define BS_APART(type, name, n) type *RESTRICT name
#else
#define BS_LENGTH(n) static n
#define BS_APART(type, name, n) type name[RESTRICT static n]
#endif

#define BS_PASTE_(a, b) a##_##b
#define BS_PASTE(a, b) BS_PASTE_(a, b)

#endif

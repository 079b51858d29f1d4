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

/* bladesmith: very long and very short directions of rays, scaled to about length 1 (scalars and vectors alike). Their
   squares are no numbers, and products with them lose what is hit. By a power of two: no bit of a point, a distance or
   a normal depends on it. Directions that are zero or not finite stay so, and are none. */
#if BS_BITS == 64
#define BS_FRACTION_BITS 52
#define BS_EXPONENTS 2047
#define BS_LEAST_NORMAL 2.2250738585072014e-308
#define BS_PLAIN 1.8446744073709552e+19 /* squares of lengths from one over it to it: nothing is to be done */
#else
#define BS_FRACTION_BITS 23
#define BS_EXPONENTS 255
#define BS_LEAST_NORMAL 1.1754943508222875e-38
#define BS_PLAIN 65536
#endif

BS_INLINE V FN(scene_square)(const V *direction)
{
  return direction[0] * direction[0] + direction[1] * direction[1] + direction[2] * direction[2];
}

/* The squared length of a direction, which is scaled before if that is called for. */
BS_INLINE V FN(scene_scaled)(V *direction)
{
  const V square = FN(scene_square)(direction);
  const M plain = AND(LT(square, SPLAT(BS_PLAIN)), GT(square, SPLAT(1.0 / BS_PLAIN)));
  if (!ANY(NOT(plain))) return square;
  const V x = ABS(direction[0]), y = ABS(direction[1]), z = ABS(direction[2]), least = SPLAT(BS_LEAST_NORMAL);
  const V first = SELECT(GT(x, y), x, y), second = SELECT(GT(z, least), z, least);
  const UI exponent = (UI)BITS(SELECT(GT(first, second), first, second)) >> BS_FRACTION_BITS;
  const V power = FROM_BITS((I)((BS_EXPONENTS - exponent) << BS_FRACTION_BITS)), scale = SELECT(plain, SPLAT(1), power);
  for (int i = 0; i < 3; i++) direction[i] = scale * direction[i];
  return FN(scene_square)(direction);
}

#undef BS_FRACTION_BITS
#undef BS_EXPONENTS
#undef BS_LEAST_NORMAL
#undef BS_PLAIN

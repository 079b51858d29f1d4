/* bladesmith: rays, hits and searches of one instance. A kind of surface `name` provides, on rows `k` of constants,
     int FN(name_prepare)(S *k, const S *parameters)
         constants from the user's parameters; 0 where there is no such surface
     int FN(name_hits)(hit *hits, const S *k, const ray *, S t_min, S t_max, search *)
         all points with t_min < t < t_max, in any order, at most BS_HITS_MOST
     void FN(name_normal)(S *normal, const S *k, const ray *, const hit *)
         unit normal, either side
   t counts in units of the ray's direction, which may have any length. */

#define BS_FLOOR1(x) ((S)floor((double)(x)))
#define BS_FAR K(BS_BITS == 64 ? 1.7976931348623157e308 : 3.4028234663852886e38)

typedef struct {
  S origin[3], direction[3];
} FN(ray);

typedef struct {
  S t, alpha;         /* alpha: parameter of the surface's curve, where it has one */
  S point[3];         /* in the world */
  S local[3];         /* in the surface's own frame */
  int kind;
  ptrdiff_t index;    /* among the surfaces of its kind */
} FN(hit);

typedef struct {
  int method, samples, status;
} FN(search);

BS_INLINE void FN(copy)(S *to, const S *from, int n)
{
  for (int i = 0; i < n; i++) to[i] = from[i];
}

BS_INLINE S FN(nothing)(void) /* NaN, also where there is no math.h */
{
  const S zero = 0;
  return zero / zero;
}

/* A point of the ray at t, if it is between the bounds; the local point is relative to a centre. */
BS_INLINE int FN(keep)(FN(hit) *hit, S t, S t_min, S t_max, const S *center, const S *local)
{
  if (!(t > t_min && t < t_max)) return 0;
  hit->t = t;
  hit->alpha = FN(nothing)();
  for (int i = 0; i < 3; i++) {
    hit->local[i] = local[i];
    hit->point[i] = center[i] + local[i];
  }
  return 1;
}

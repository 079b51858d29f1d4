/* bladesmith: triangles. A row: three corners. A ray that passes through an edge or a corner meets every triangle there:
   none is lost between two. Smooth ones (scene_smooth_facet.h) are hit in the same way. */
#ifndef BS_FACETS
#define BS_FACETS

/* The axes in a cyclic order in which the largest coordinate of a vector is the last. */
BS_INLINE void FN(facet_order)(int *axes, const S *v)
{
  const S x = ABS(v[0]), y = ABS(v[1]), z = ABS(v[2]);
  const int last = x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
  axes[0] = last == 2 ? 0 : last + 1;
  axes[1] = last == 0 ? 2 : last - 1;
  axes[2] = last;
}

/* A vector with its coordinates in that order. */
BS_INLINE void FN(facet_load)(S *to, const S *from, const int *axes)
{
  for (int i = 0; i < 3; i++) to[i] = from[axes[i]];
}

BS_INLINE int FN(facet_prepare)(S *k, const S *parameters)
{
  FN(copy)(k, parameters, 9);
  return 1;
}

BS_INLINE void FN(facet_offer)(FN(search) *search, const S *k, const int *axes, const S *t, const S *shares,
                               const S *local)
{
  FN(hit) *const hit = FN(accept)(search, t[0], FN(nothing)());
  if (!hit) return;
  FN(copy)(hit->local, shares, 3);
  for (int i = 0; i < 3; i++) hit->point[axes[i]] = k[axes[i]] + local[i];
}

BS_OUTLINED void FN(facet_hits)(FN(search) *search, const S *k, const FN(ray) *ray)
{
  S origin[3], direction[3], corners[9], sides[3], t[1], shares[3], local[3];
  int axes[3];
  FN(facet_order)(axes, ray->direction);
  FN(facet_load)(origin, ray->origin, axes);
  FN(facet_load)(direction, ray->direction, axes);
  for (int i = 0; i < 9; i += 3) FN(facet_load)(corners + i, k + i, axes);
  FN(cga3d_facet_sides)(sides, origin, direction, corners, corners + 3, corners + 6);
  if ((sides[0] < 0 || sides[1] < 0 || sides[2] < 0) && (sides[0] > 0 || sides[1] > 0 || sides[2] > 0)) return;
  FN(cga3d_facet_hit)(t, shares, local, origin, direction, corners, corners + 3, corners + 6, sides);
  FN(facet_offer)(search, k, axes, t, shares, local);
}

BS_INLINE void FN(facet_normal)(S *normal, const S *k, const FN(ray) *ray, const FN(hit) *hit)
{
  (void)ray, (void)hit;
  FN(cga3d_facet_normal)(normal, k, k + 3, k + 6);
}
#endif

/* bladesmith: spheres. A row: centre, radius. */

BS_INLINE int FN(sphere_prepare)(S *k, const S *parameters)
{
  FN(copy)(k, parameters, 4);
  return 1;
}

BS_OUTLINED void FN(sphere_hits)(FN(search) *search, const S *k, const FN(ray) *ray)
{
  S t[2], first[3], last[3];
  FN(cga3d_sphere_hit)(t, first, last, ray->origin, ray->direction, k, k + 3);
  FN(offer)(search, t[0], k, first);
  FN(offer)(search, t[1], k, last);
}

BS_INLINE void FN(sphere_normal)(S *normal, const S *k, const FN(ray) *ray, const FN(hit) *hit)
{
  (void)ray;
  for (int i = 0; i < 3; i++) normal[i] = hit->local[i] / k[3];
}

/* bladesmith: spheres. A row: centre, radius. */

BS_INLINE int FN(sphere_prepare)(S *k, const S *parameters)
{
  FN(copy)(k, parameters, 4);
  return 1;
}

BS_OWN int FN(sphere_hits)(FN(hit) *hits, const S *k, const FN(ray) *ray, S t_min, S t_max, FN(search) *search)
{
  S t[2], first[3], last[3];
  (void)search;
  FN(cga3d_sphere_hit)(t, first, last, ray->origin, ray->direction, k, k + 3);
  const int n = FN(keep)(hits, t[0], t_min, t_max, k, first);
  return n + FN(keep)(hits + n, t[1], t_min, t_max, k, last);
}

BS_INLINE void FN(sphere_normal)(S *normal, const S *k, const FN(ray) *ray, const FN(hit) *hit)
{
  (void)ray;
  for (int i = 0; i < 3; i++) normal[i] = hit->local[i] / k[3];
}

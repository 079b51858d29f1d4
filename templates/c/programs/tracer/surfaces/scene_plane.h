/* bladesmith: planes. A row: unit normal, offset. */

BS_INLINE int FN(plane_prepare)(S *k, const S *parameters)
{
  FN(copy)(k, parameters, 4);
  return 1;
}

BS_OUTLINED void FN(plane_hits)(FN(search) *search, const S *k, const FN(ray) *ray)
{
  S t[1], local[3];
  FN(cga3d_plane_hit)(t, ray->origin, ray->direction, k, k + 3);
  for (int i = 0; i < 3; i++) local[i] = t[0] * ray->direction[i];
  FN(offer)(search, t[0], ray->origin, local);
}

BS_INLINE void FN(plane_normal)(S *normal, const S *k, const FN(ray) *ray, const FN(hit) *hit)
{
  (void)ray, (void)hit;
  FN(copy)(normal, k, 3);
}

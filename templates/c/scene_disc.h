/* bladesmith: discs. A row: centre, unit normal, radius. */

BS_INLINE int FN(disc_prepare)(S *k, const S *parameters)
{
  FN(copy)(k, parameters, 7);
  return 1;
}

BS_OWN void FN(disc_hits)(FN(search) *search, const S *k, const FN(ray) *ray)
{
  S t_square[2], local[3];
  FN(cga3d_disc_hit)(t_square, local, ray->origin, ray->direction, k, k + 3, k + 6);
  if (t_square[1] <= 0) FN(offer)(search, t_square[0], k, local);
}

BS_INLINE void FN(disc_normal)(S *normal, const S *k, const FN(ray) *ray, const FN(hit) *hit)
{
  (void)ray, (void)hit;
  FN(copy)(normal, k + 3, 3);
}

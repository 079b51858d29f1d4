/* bladesmith: discs. A row: centre, unit normal, radius. */

BS_INLINE int FN(disc_prepare)(S *k, const S *parameters)
{
  FN(copy)(k, parameters, 7);
  return 1;
}

/* A ray in the disc's plane meets the rim: nowhere, once where it touches, or twice. */
BS_OUTLINED void FN(disc_rim)(FN(search) *search, const S *k, const FN(ray) *ray)
{
  S t[2], first[3], last[3];
  FN(cga3d_rim_hit)(t, first, last, ray->origin, ray->direction, k, k + 3, k + 6);
  FN(offer)(search, t[0], k, first);
  FN(offer)(search, t[1], k, last);
}

/* A ray that only grazes the disc. */
BS_COLD void FN(disc_grazed)(FN(search) *search, const S *k, const FN(ray) *ray)
{
  S t[1], local[3];
  FN(cga3d_disc_graze)(t, local, ray->origin, ray->direction, k, k + 3, k + 6);
  FN(offer)(search, t[0], k, local);
}

BS_OUTLINED void FN(disc_hits)(FN(search) *search, const S *k, const FN(ray) *ray)
{
  S t_square_along[3], local[3];
  FN(cga3d_disc_hit)(t_square_along, local, ray->origin, ray->direction, k, k + 3, k + 6);
  if (t_square_along[2] > 0) {
    FN(disc_rim)(search, k, ray);
  } else if (t_square_along[1] <= 0 && t_square_along[2] < 0) {
    FN(disc_grazed)(search, k, ray);
  } else if (t_square_along[1] <= 0) {
    FN(offer)(search, t_square_along[0], k, local);
  }
}

BS_INLINE void FN(disc_normal)(S *normal, const S *k, const FN(ray) *ray, const FN(hit) *hit)
{
  (void)ray, (void)hit;
  FN(copy)(normal, k + 3, 3);
}

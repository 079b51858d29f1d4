/* bladesmith: triangles that are shaded with the normals of their corners. A row: three corners, three unit normals. */
#include "scene_facet.h"

BS_INLINE int FN(smooth_facet_prepare)(S *k, const S *parameters)
{
  FN(copy)(k, parameters, 18);
  return 1;
}

BS_INLINE void FN(smooth_facet_hits)(FN(search) *search, const S *k, const FN(ray) *ray)
{
  FN(facet_hits)(search, k, ray);
}

BS_INLINE void FN(smooth_facet_normal)(S *normal, const S *k, const FN(ray) *ray, const FN(hit) *hit)
{
  FN(cga3d_smooth_normal)(normal, ray->direction, k, k + 3, k + 6, k + 9, k + 12, k + 15, hit->local);
}

/* bladesmith: one ray against all surfaces of a scene: constants of their rows, the nearest hit, its normal. */

/* Constants of rows of one kind; the number of the first row that is no surface, else the number of rows. */
BS_OUTLINED ptrdiff_t FN(scene_prepare)(int kind, ptrdiff_t rows, const S *parameters, S *constants)
{
  ptrdiff_t i = 0;
#define BS_EACH(number, name, given, size) \
  if (kind == number) \
    while (i < rows && FN(name##_prepare)(constants + i * (size), parameters + i * (given))) i++;
  BS_SCENE_KINDS(BS_EACH)
#undef BS_EACH
  (void)kind, (void)rows, (void)parameters, (void)constants; /* of a scene without surfaces */
  return i;
}

/* The row of a surface. */
#define BS_ROW(scene, number, size, i) ((const S *)(scene)->surfaces[number].constants + (i) * (size))

/* Unit normal at a hit, on the side that the ray comes from. */
BS_INLINE void FN(scene_normal)(S *normal, const bs_scene *scene, const FN(ray) *ray, const FN(hit) *hit)
{
  S either[3] = {0, 0, 0};
#define BS_EACH(number, name, given, size) \
  if (hit->kind == number) FN(name##_normal)(either, BS_ROW(scene, number, size, hit->index), ray, hit);
  BS_SCENE_KINDS(BS_EACH)
#undef BS_EACH
  (void)scene, (void)hit;
  FN(cga3d_facing)(normal, either, ray->direction);
}

#include "scene_gather.h"

/* The row that was asked could not tell: keep what it said with the place where its box begins. */
BS_OUTLINED void FN(scene_note)(FN(search) *search, const bs_scene *scene, const FN(ray) *ray)
{
  S begin = -BS_FAR;
#if BS_SCENE_BOXES
  const S *const boxes = (const S *)scene->surfaces[search->kind].boxes;
  if (boxes) {
    const S *const low = boxes + 6 * search->index, *const high = low + 3, reach = (S)scene->tree.reach;
    S near[3], far[3], inverse[3], first[3], last[3], span[2];
    const S bounds[2] = {-BS_FAR, BS_FAR};
    FN(cga3d_box_ray)(near, far, inverse, ray->origin, ray->direction, &reach);
    for (int i = 0; i < 3; i++) {
      first[i] = ray->direction[i] < 0 ? high[i] : low[i];
      last[i] = ray->direction[i] < 0 ? low[i] : high[i];
    }
    FN(cga3d_box_span)(span, near, far, inverse, first, last, bounds);
    begin = span[0];
  }
#else
  (void)scene, (void)ray;
#endif
  S *const kept = search->status == BS_STATUS_SINGULAR ? &search->singular : &search->invalid;
  if (begin < *kept) *kept = begin;
  search->status = BS_STATUS_OK;
}

/* After each row that was asked. */
BS_INLINE void FN(scene_asked)(FN(search) *search, const bs_scene *scene, const FN(ray) *ray)
{
  search->cost++;
  if (search->status != BS_STATUS_OK) FN(scene_note)(search, scene, ray);
  if (search->gather && search->count) FN(scene_gather)(search, scene, ray);
}

#if BS_SCENE_TREE
#include "scene_tree.h"
#else

/* Ask every surface of the scene; or, where any hit will do, until there is one. */
BS_INLINE void FN(scene_ask)(FN(search) *search, const bs_scene *scene, const FN(ray) *ray, int any)
{
#define BS_EACH(number, name, given, size) \
  search->kind = number; \
  for (search->index = 0; search->index < scene->surfaces[number].count; search->index++) { \
    if (any && search->count) return; \
    FN(name##_hits)(search, BS_ROW(scene, number, size, search->index), ray); \
    FN(scene_asked)(search, scene, ray); \
  }
  BS_SCENE_KINDS(BS_EACH)
#undef BS_EACH
  (void)search, (void)scene, (void)ray, (void)any;
}
#endif

/* Points on all surfaces of the scene. */
BS_INLINE void FN(scene_search)(FN(search) *search, const bs_scene *scene, const FN(ray) *ray)
{
  FN(scene_ask)(search, scene, ray, 0);
}

#if BS_SCENE_PICTURES
/* 1 if anything lies on the ray between its origin and t = 1. */
BS_INLINE int FN(scene_shadowed)(const bs_scene *scene, const FN(ray) *ray)
{
  FN(hit) hit;
  FN(search) search = FN(search_for)(scene, &hit, 1);
  search.t_max = 1;
  FN(scene_ask)(&search, scene, ray, 1);
  return search.count;
}
#endif

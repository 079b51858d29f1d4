/* bladesmith: the loops over rays. Each works on items [begin, end) and keeps no state. */
#include "scene_scale.h"

/* Ray i of two arrays; 0 where it is no ray. */
BS_INLINE int FN(scene_load)(FN(ray) *ray, const bs_rays *rays, ptrdiff_t i)
{
  FN(copy)(ray->origin, (const S *)rays->origins + i * rays->origin_stride, 3);
  FN(copy)(ray->direction, (const S *)rays->directions + i * rays->direction_stride, 3);
  const S reach = FN(scene_reach)(ray), square = FN(scene_scaled)(ray->direction);
  return reach - reach == 0 && square > 0 && square - square == 0;
}

/* What a ray has found. */
BS_INLINE void FN(scene_found)(const bs_hits *out, ptrdiff_t i, const bs_scene *scene, const FN(search) *search,
                               const FN(ray) *ray, int valid)
{
  const FN(hit) *const hit = search->hits;
  const int within = search->count && FN(scene_within)(ray, hit);
  out->status[i] = (uint8_t)(valid && within == search->count ? FN(search_status)(search) : BS_STATUS_INVALID);
  if (within) {
    out->surface[i] = scene->surfaces[hit->kind].ids[hit->index];
    FN(scene_store)(out, i, scene, ray, hit);
  } else {
    FN(scene_blank)(out, i);
  }
}

#if BS_SCENE_TREE
/* Several rays take a step by turns: while one waits for a node, the others are busy. */
typedef struct {
  FN(ray) ray;
  FN(hit) hit;
  FN(search) search;
  FN(traversal) traversal;
  ptrdiff_t place; /* of the ray, -1 for none */
  int valid;
} FN(active_ray);

BS_INLINE void FN(active_ray_begin)(FN(active_ray) *active, const bs_scene *scene, const bs_rays *rays, ptrdiff_t i)
{
  active->search = FN(search_for)(scene, &active->hit, 1);
  active->place = i, active->traversal.count = 0;
  active->valid = FN(scene_load)(&active->ray, rays, i);
  if (active->valid) FN(traversal_begin)(&active->traversal, &active->search, scene, &active->ray, 0);
}

static void FN(scene_first)(const bs_scene *scene, ptrdiff_t begin, ptrdiff_t end, const bs_rays *rays,
                            const bs_hits *out)
{
  FN(active_ray) rays_in_work[BS_RAYS_IN_WORK];
  ptrdiff_t next = begin, left = end - begin;
  for (int w = 0; w < BS_RAYS_IN_WORK; w++) rays_in_work[w].place = -1, rays_in_work[w].traversal.count = 0;
  while (left > 0) {
    for (int w = 0; w < BS_RAYS_IN_WORK; w++) {
      FN(active_ray) *const active = &rays_in_work[w];
      if (active->traversal.count > 0) {
        FN(traversal_step)(&active->traversal, &active->search, scene, &active->ray);
        continue;
      }
      if (active->place >= 0) {
        FN(scene_found)(out, active->place, scene, &active->search, &active->ray, active->valid);
        active->place = -1, left--;
      }
      if (next < end) FN(active_ray_begin)(active, scene, rays, next++);
    }
  }
}
#else
static void FN(scene_first)(const bs_scene *scene, ptrdiff_t begin, ptrdiff_t end, const bs_rays *rays,
                            const bs_hits *out)
{
  for (ptrdiff_t i = begin; i < end; i++) {
    FN(ray) ray;
    FN(hit) hit;
    FN(search) search = FN(search_for)(scene, &hit, 1);
    const int valid = FN(scene_load)(&ray, rays, i);
    if (valid) FN(scene_search)(&search, scene, &ray);
    FN(scene_found)(out, i, scene, &search, &ray, valid);
  }
}
#endif

/* All points of each ray's line on the only surface of the scene, in the order of t; also behind the origin. */
static void FN(scene_all)(const bs_scene *scene, ptrdiff_t begin, ptrdiff_t end, const bs_rays *rays,
                          const bs_hits *out)
{
  for (ptrdiff_t i = begin; i < end; i++) {
    FN(ray) ray;
    FN(hit) hits[BS_HITS_MOST];
    FN(search) search = FN(search_for)(scene, hits, BS_HITS_MOST);
    search.gather = out, search.place = i;
    const int valid = FN(scene_load)(&ray, rays, i);
    if (valid) FN(scene_search)(&search, scene, &ray);
    if (search.lost) search.total = 0;
    out->count[i] = search.total;
    out->status[i] = (uint8_t)(valid && !search.lost ? FN(search_status)(&search) : BS_STATUS_INVALID);
    for (ptrdiff_t j = search.total; j < out->roots; j++) FN(scene_blank)(out, i * out->roots + j);
  }
}

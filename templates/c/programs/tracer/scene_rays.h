/* bladesmith: what Python calls, of one instance: constants of rows, and loops over items [begin, end), which keep no
   state. */

#if BS_SCENE_TREE
/* Several rays take a step by turns: while one waits for a node, the others are busy. */
typedef struct {
  S ray[BS_RAY_SIZE], search[BS_SEARCH_SIZE], hit[BS_HIT_SIZE];
  ptrdiff_t state[BS_STATE_SIZE];
  bs_traversal traversal;
  ptrdiff_t place; /* of the ray, -1 for none */
  int valid;
} FN(active_ray);

BS_INLINE void FN(active_ray_begin)(FN(active_ray) * active, const bs_scene *scene, const bs_rays *rays, ptrdiff_t i)
{
  const S *const reals = (const S *)scene->reals;
  const ptrdiff_t *const layout = scene->integers;
  FN(begin_search)(layout, 1, active->search, active->state);
  active->place = i, active->traversal.count = 0;
  active->valid = FN(load_ray)((const S *)rays->origins, rays->origin_stride, (const S *)rays->directions,
      rays->direction_stride, i, active->ray);
  if (!active->valid) return;
  for (ptrdiff_t item = layout[BS_LAYOUT_UNBOUNDED]; item < layout[BS_LAYOUT_ITEMS]; item++)
    FN(ask_row)(item, layout, layout, reals, active->ray, active->search, active->hit, active->state);
  FN(traversal_begin)(&active->traversal, layout, reals, active->ray, active->search, active->state);
}

static void FN(scene_first)(
    const bs_scene *scene, ptrdiff_t begin, ptrdiff_t end, const bs_rays *rays, const bs_hits *out)
{
  const S *const reals = (const S *)scene->reals;
  const ptrdiff_t *const layout = scene->integers;
  FN(active_ray) rays_in_work[BS_RAYS_IN_WORK];
  ptrdiff_t next = begin, left = end - begin;
  for (int w = 0; w < BS_RAYS_IN_WORK; w++) rays_in_work[w].place = -1, rays_in_work[w].traversal.count = 0;
  while (left > 0) {
    for (int w = 0; w < BS_RAYS_IN_WORK; w++) {
      FN(active_ray) *const active = &rays_in_work[w];
      if (active->traversal.count > 0) {
        const ptrdiff_t item = bs_traversal_step(&active->traversal, layout, active->state);
        if (item >= 0) {
          FN(ask_row)(item, layout, layout, reals, active->ray, active->search, active->hit, active->state);
          FN(traversal_narrow)(&active->traversal, active->search);
        }
        continue;
      }
      if (active->place >= 0) {
        FN(store_first)(active->place, active->valid, layout, reals, active->ray, active->search, active->hit,
            active->state, (S *)out->t, (S *)out->alpha, (S *)out->point, (S *)out->normal, out->surface, out->status);
        active->place = -1, left--;
      }
      if (next < end) FN(active_ray_begin)(active, scene, rays, next++);
    }
  }
}
#else
static void FN(scene_first)(
    const bs_scene *scene, ptrdiff_t begin, ptrdiff_t end, const bs_rays *rays, const bs_hits *out)
{
  FN(first_hits)(begin, end, scene->integers, scene->integers, (const S *)scene->reals, (const S *)rays->origins,
      rays->origin_stride, (const S *)rays->directions, rays->direction_stride, (S *)out->t, (S *)out->alpha,
      (S *)out->point, (S *)out->normal, out->surface, out->status);
}
#endif

#if BS_SCENE_LINES
static void FN(scene_all)(
    const bs_scene *scene, ptrdiff_t begin, ptrdiff_t end, const bs_rays *rays, const bs_hits *out)
{
  FN(all_hits)(begin, end, out->roots, scene->integers, scene->integers, (const S *)scene->reals,
      (const S *)rays->origins, rays->origin_stride, (const S *)rays->directions, rays->direction_stride, (S *)out->t,
      (S *)out->alpha, (S *)out->point, (S *)out->normal, out->surface, out->count, out->status);
}
#endif

#if BS_SCENE_PICTURES
static void FN(scene_render)(const bs_scene *scene, ptrdiff_t begin, ptrdiff_t end, const bs_picture *picture)
{
  FN(render)(begin, end, scene->integers, scene->integers, (const S *)scene->reals, picture->layout,
      (S *)picture->color, (S *)picture->normal, (S *)picture->depth, (S *)picture->alpha, picture->cost);
}
#endif

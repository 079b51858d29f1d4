/* bladesmith: the loops over rays. Each works on items [begin, end) and keeps no state. */

/* Ray i of two arrays; 0 where it is no ray. */
BS_INLINE int FN(scene_load)(FN(ray) *ray, const bs_rays *rays, ptrdiff_t i)
{
  FN(copy)(ray->origin, (const S *)rays->origins + i * rays->origin_stride, 3);
  FN(copy)(ray->direction, (const S *)rays->directions + i * rays->direction_stride, 3);
  S sum = 0, square = 0;
  for (int j = 0; j < 3; j++) {
    sum += ray->origin[j];
    square += ray->direction[j] * ray->direction[j];
  }
  return sum - sum == 0 && square > 0 && square - square == 0;
}

BS_INLINE S FN(scene_length)(const S *x)
{
  return SQRT(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
}

BS_INLINE void FN(scene_store)(const bs_hits *out, ptrdiff_t place, const bs_scene *scene, const FN(ray) *ray,
                               const FN(hit) *hit)
{
  ((S *)out->t)[place] = hit->t * FN(scene_length)(ray->direction);
  ((S *)out->alpha)[place] = hit->alpha;
  FN(copy)((S *)out->point + 3 * place, hit->point, 3);
  FN(scene_normal)((S *)out->normal + 3 * place, scene, ray, hit);
}

BS_INLINE void FN(scene_blank)(const bs_hits *out, ptrdiff_t place)
{
  const S nan = FN(nothing)();
  ((S *)out->t)[place] = ((S *)out->alpha)[place] = nan;
  for (int j = 0; j < 3; j++) ((S *)out->point)[3 * place + j] = ((S *)out->normal)[3 * place + j] = nan;
}

static void FN(scene_first)(const bs_scene *scene, ptrdiff_t begin, ptrdiff_t end, const bs_rays *rays,
                            const bs_hits *out)
{
  for (ptrdiff_t i = begin; i < end; i++) {
    FN(ray) ray;
    FN(hit) hit;
    FN(search) search = FN(search_for)(scene, &hit, 1);
    const int valid = FN(scene_load)(&ray, rays, i);
    if (valid) FN(scene_search)(&search, scene, &ray);
    out->status[i] = (uint8_t)(valid ? search.status : BS_STATUS_INVALID);
    out->surface[i] = search.count ? scene->surfaces[hit.kind].ids[hit.index] : -1;
    if (search.count) {
      FN(scene_store)(out, i, scene, &ray, &hit);
    } else {
      FN(scene_blank)(out, i);
    }
  }
}

/* All points of each ray's line on the only surface of the scene, in the order of t; also behind the origin. */
static void FN(scene_all)(const bs_scene *scene, ptrdiff_t begin, ptrdiff_t end, const bs_rays *rays,
                          const bs_hits *out)
{
  for (ptrdiff_t i = begin; i < end; i++) {
    FN(ray) ray;
    FN(hit) hits[BS_HITS_MOST];
    FN(search) search = FN(search_for)(scene, hits, BS_HITS_MOST);
    const int valid = FN(scene_load)(&ray, rays, i);
    if (valid) FN(scene_search)(&search, scene, &ray);
    const int n = search.count;
    for (int j = 1; j < n; j++) {
      const FN(hit) moved = hits[j];
      int place = j;
      for (; place > 0 && hits[place - 1].t > moved.t; place--) hits[place] = hits[place - 1];
      hits[place] = moved;
    }
    out->count[i] = n; /* may be more than there is room for */
    out->status[i] = (uint8_t)(valid ? search.status : BS_STATUS_INVALID);
    for (int j = 0; j < out->roots; j++) {
      if (j < n) {
        FN(scene_store)(out, i * out->roots + j, scene, &ray, &hits[j]);
      } else {
        FN(scene_blank)(out, i * out->roots + j);
      }
    }
  }
}

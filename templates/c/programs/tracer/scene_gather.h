/* bladesmith: hits as rows of arrays, and all points of a line on the rows of one surface, in order. */

/* How far the origin of a ray is from that of the world, or further; no number if one of its own is none. */
BS_INLINE S FN(scene_reach)(const FN(ray) *ray)
{
  return ABS(ray->origin[0]) + ABS(ray->origin[1]) + ABS(ray->origin[2]);
}

/* 1 if the distance of a hit, and its point, are numbers. */
BS_INLINE int FN(scene_within)(const FN(ray) *ray, const FN(hit) *hit)
{
  return ABS(hit->t) * FN(scene_length)(ray->direction) + FN(scene_reach)(ray) <= BS_FAR;
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
  out->surface[place] = -1;
  ((S *)out->t)[place] = ((S *)out->alpha)[place] = nan;
  for (int j = 0; j < 3; j++) ((S *)out->point)[3 * place + j] = ((S *)out->normal)[3 * place + j] = nan;
}

BS_INLINE void FN(scene_move)(const bs_hits *out, ptrdiff_t to, ptrdiff_t from)
{
  out->surface[to] = out->surface[from];
  ((S *)out->t)[to] = ((S *)out->t)[from];
  ((S *)out->alpha)[to] = ((S *)out->alpha)[from];
  FN(copy)((S *)out->point + 3 * to, (const S *)out->point + 3 * from, 3);
  FN(copy)((S *)out->normal + 3 * to, (const S *)out->normal + 3 * from, 3);
}

/* How far the parameter of a curve runs, from the first to the last row of the surface that is asked. */
BS_INLINE S FN(scene_period)(const bs_scene *scene, const FN(hit) *hit)
{
  const S *first = 0, *last = 0;
#define BS_EACH(number, name, given, size) \
  if (hit->kind == number) { \
    first = BS_ROW(scene, number, size, 0); \
    last = BS_ROW(scene, number, size, scene->surfaces[number].count - 1); \
  }
  BS_SCENE_KINDS(BS_EACH)
#undef BS_EACH
  (void)scene, (void)hit; /* of a scene without surfaces */
  return last ? last[BS_ROW_START] + last[BS_ROW_START + 1] - first[BS_ROW_START] : K(0);
}

/* Where two pieces of a curve join, both find the points of the common circle, and so do the first and the last of a
   closed curve, or both ends of its only one: the place, among `kept` ones from `begin`, of the other point that is
   this one; -1 for none. */
BS_INLINE ptrdiff_t FN(scene_joint)(const bs_hits *out, ptrdiff_t begin, ptrdiff_t kept, const bs_scene *scene,
                                    const FN(ray) *ray, const FN(hit) *hit, S t)
{
  if (!(kept > 0 && hit->alpha - hit->alpha == 0)) return -1;
  const S *const times = (const S *)out->t + begin, *const alphas = (const S *)out->alpha + begin;
  const S size = ABS(t) + FN(scene_length)(ray->origin), period = FN(scene_period)(scene, hit);
  for (ptrdiff_t i = 0; i < kept; i++) {
    const S apart = ABS(alphas[i] - hit->alpha), near = BS_JOINT_ALPHA(S) * (K(1) + ABS(hit->alpha));
    const int joins = out->surface[begin + i] != hit->index && apart <= near;
    if ((joins || ABS(apart - period) <= near) && ABS(times[i] - t) <= BS_JOINT_PLACE(S) * size) return i;
  }
  return -1;
}

/* Add the points of the row that was asked to those of a line: by t, and by row where t is the same. Those for which
   there is no room are counted. */
BS_OUTLINED void FN(scene_gather)(FN(search) *search, const bs_scene *scene, const FN(ray) *ray)
{
  const bs_hits *const out = search->gather;
  const ptrdiff_t begin = search->place * out->roots;
  const S length = FN(scene_length)(ray->direction);
  const S *const times = (const S *)out->t + begin;
  const int32_t *const rows = out->surface + begin;
  for (int j = 0; j < search->count; j++) {
    const FN(hit) *const hit = &search->hits[j];
    const S t = hit->t * length;
    if (!FN(scene_within)(ray, hit)) {
      search->lost = 1;
      continue;
    }
    ptrdiff_t kept = search->total < out->roots ? search->total : out->roots;
    const ptrdiff_t joint = FN(scene_joint)(out, begin, kept, scene, ray, hit, t);
    if (joint >= 0) { /* the piece of the lower row keeps it */
      if (rows[joint] <= hit->index) continue;
      for (ptrdiff_t i = joint; i + 1 < kept; i++) FN(scene_move)(out, begin + i, begin + i + 1);
      kept--, search->total--;
    }
    ptrdiff_t place = kept;
    while (place > 0 && (times[place - 1] > t || (times[place - 1] == t && rows[place - 1] > hit->index))) place--;
    for (ptrdiff_t i = kept < out->roots ? kept : out->roots - 1; i > place; i--)
      FN(scene_move)(out, begin + i, begin + i - 1);
    search->total++;
    if (place >= out->roots) continue;
    out->surface[begin + place] = (int32_t)hit->index;
    FN(scene_store)(out, begin + place, scene, ray, hit);
  }
  search->count = 0;
}

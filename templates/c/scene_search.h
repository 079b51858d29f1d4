/* bladesmith: one ray against all surfaces of a scene: constants of their rows, the nearest hit, its normal. */

/* Constants of rows of one kind; the number of the first row that is no surface, else the number of rows. */
BS_OWN ptrdiff_t FN(scene_prepare)(int kind, ptrdiff_t rows, const S *parameters, S *constants)
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

/* Ask every surface of the scene. */
BS_INLINE void FN(scene_search)(FN(search) *search, const bs_scene *scene, const FN(ray) *ray)
{
#define BS_EACH(number, name, given, size) \
  search->kind = number; \
  for (search->index = 0; search->index < scene->surfaces[number].count; search->index++) \
    FN(name##_hits)(search, BS_ROW(scene, number, size, search->index), ray);
  BS_SCENE_KINDS(BS_EACH)
#undef BS_EACH
  (void)search, (void)scene, (void)ray;
}

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

#if BS_SCENE_PICTURES
/* 1 if anything lies on the ray between its origin and t = 1. */
BS_INLINE int FN(scene_shadowed)(const bs_scene *scene, const FN(ray) *ray)
{
  FN(hit) hit;
  FN(search) search = FN(search_for)(scene, &hit, 1);
  search.t_max = 1;
#define BS_EACH(number, name, given, size) \
  for (ptrdiff_t i = 0; i < scene->surfaces[number].count && !search.count; i++) \
    FN(name##_hits)(&search, BS_ROW(scene, number, size, i), ray);
  BS_SCENE_KINDS(BS_EACH)
#undef BS_EACH
  (void)ray;
  return search.count;
}
#endif

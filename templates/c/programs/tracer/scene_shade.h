/* bladesmith: light and color: what is seen along one ray, with shadows and the path of reflections. */

/* Size of the numbers that a hit was made of: its errors are relative to it. */
BS_INLINE S FN(scene_size)(const FN(ray) *ray, const FN(hit) *hit)
{
  S size = 0;
  for (int i = 0; i < 3; i++)
    size += ABS(ray->origin[i]) + ABS(hit->point[i]) + ABS(hit->t * ray->direction[i]);
  return size;
}

/* The same, with the numbers of the surface. */
BS_OUTLINED S FN(scene_extent)(const bs_scene *scene, const FN(ray) *ray, const FN(hit) *hit)
{
  const S *const boxes = (const S *)scene->surfaces[hit->kind].boxes;
  S size = FN(scene_size)(ray, hit);
  for (int i = 0; i < 6 && boxes; i++) {
    const S side = ABS(boxes[6 * hit->index + i]);
    size += side <= BS_FAR ? side : K(0);
  }
  return size;
}

/* What a camera sees along a ray, but for what it stands on. */
BS_INLINE FN(search) FN(scene_seen)(const bs_scene *scene, FN(hit) *hit, const FN(ray) *ray)
{
  const S most = K(8) * BS_LEAST(S) * (FN(scene_reach)(ray) + (S)scene->tree.reach); /* of all surfaces */
  FN(search) search = FN(search_for)(scene, hit, 1);
  FN(scene_search)(&search, scene, ray);
  while (search.count && hit->t <= most) {
    const S least = BS_LEAST(S) * FN(scene_extent)(scene, ray, hit) / FN(scene_length)(ray->direction);
    if (!(hit->t <= least)) break;
    const int cost = search.cost;
    search = FN(search_for)(scene, hit, 1);
    search.t_min = least, search.cost = cost;
    FN(scene_search)(&search, scene, ray);
  }
  return search;
}

/* The color of a surface where it is hit. */
BS_INLINE void FN(scene_color)(S *color, const S *material, const S *point)
{
  FN(copy)(color, material + BS_MATERIAL_COLOR, 3);
#if BS_SCENE_CHECKER
  const S *const across = material + BS_MATERIAL_ACROSS;
  const S u = across[0] * point[0] + across[1] * point[1] + across[2] * point[2];
  const S v = across[3] * point[0] + across[4] * point[1] + across[5] * point[2];
  const S half = K(0.5) * (BS_FLOOR1(u) + BS_FLOOR1(v));
  if (half != BS_FLOOR1(half)) FN(copy)(color, material + BS_MATERIAL_SECOND, 3);
#else
  (void)point;
#endif
}

/* 1 if a lamp sees a point. The way ends before the lamp by the error of a hit: a lamp on a surface is not in the
   shadow of that surface, and shines to both of its sides. */
BS_INLINE int FN(scene_lit)(const bs_scene *scene, const S *lamp, const S *start, const S *towards)
{
  FN(ray) shadow;
  S size = 0;
  for (int i = 0; i < 3; i++) size += ABS(start[i]) + ABS(lamp[i]);
  const S margin = BS_OFFSET(S) * size, distance = FN(scene_length)(towards);
  if (!(distance > margin)) return 1;
  FN(copy)(shadow.origin, start, 3);
  for (int i = 0; i < 3; i++) shadow.direction[i] = (K(1) - margin / distance) * towards[i];
  return !FN(scene_shadowed)(scene, &shadow);
}

/* Light that a surface sends back along a ray, without its reflection (Blinn and Phong). */
BS_INLINE void FN(scene_shade)(S *light, const bs_scene *scene, const S *material, const FN(ray) *ray,
                               const S *start, const S *normal)
{
  S color[3];
  FN(scene_color)(color, material, start);
  for (int i = 0; i < 3; i++) light[i] = material[BS_MATERIAL_AMBIENT] * color[i];
  for (ptrdiff_t l = 0; l < scene->light_count; l++) {
    const S *const lamp = (const S *)scene->lights + l * BS_LIGHT_SIZE;
    S towards[3], factors[2];
    FN(cga3d_light_terms)(towards, factors, start, normal, ray->direction, lamp, material + BS_MATERIAL_SHININESS);
    if (!(factors[0] > 0 && FN(scene_lit)(scene, lamp, start, towards))) continue;
    for (int i = 0; i < 3; i++)
      light[i] += lamp[BS_LIGHT_COLOR + i] * (material[BS_MATERIAL_DIFFUSE] * factors[0] * color[i]
                                 + material[BS_MATERIAL_SPECULAR] * factors[1]);
  }
}

BS_INLINE void FN(scene_sky)(S *light, const bs_scene *scene, const S *direction)
{
  const S *const sky = (const S *)scene->sky;
  const S up = direction[2] > 0 ? direction[2] : K(0);
  for (int i = 0; i < 3; i++) light[i] = (K(1) - up) * sky[i] + up * sky[3 + i];
}

/* Color seen along a ray of unit direction; reflections are followed one after the other. */
BS_INLINE void FN(scene_color_of)(S *seen, const bs_scene *scene, FN(ray) ray)
{
  S weight = 1, light[3];
  for (int i = 0; i < 3; i++) seen[i] = 0;
  for (int bounce = 0;; bounce++) {
    FN(hit) hit;
    FN(search) search = FN(search_for)(scene, &hit, 1);
    S normal[3], start[3];
    if (bounce) FN(scene_search)(&search, scene, &ray);
    else search = FN(scene_seen)(scene, &hit, &ray);
    if (!search.count) {
      FN(scene_sky)(light, scene, ray.direction);
      for (int i = 0; i < 3; i++) seen[i] += weight * light[i];
      return;
    }
    const ptrdiff_t id = scene->surfaces[hit.kind].ids[hit.index];
    const S *const material = (const S *)scene->materials + id * BS_MATERIAL_SIZE;
    const S mirror = bounce < scene->depth ? material[BS_MATERIAL_REFLECTIVITY] : K(0);
    const S offset = BS_OFFSET(S) * FN(scene_size)(&ray, &hit);
    FN(scene_normal)(normal, scene, &ray, &hit);
    for (int i = 0; i < 3; i++) start[i] = hit.point[i] + offset * normal[i];
    if (mirror < 1) {
      FN(scene_shade)(light, scene, material, &ray, start, normal);
      for (int i = 0; i < 3; i++) seen[i] += weight * (K(1) - mirror) * light[i];
    }
#if BS_SCENE_REFLECTION
    if (mirror > 0) {
      S onward[3];
      FN(cga3d_reflected_direction)(onward, ray.direction, normal);
      FN(copy)(ray.origin, start, 3);
      FN(copy)(ray.direction, onward, 3);
      weight *= mirror;
      continue;
    }
#endif
    return;
  }
}

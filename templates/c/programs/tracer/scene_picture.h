/* bladesmith: the loop over the pixels of a picture: items [begin, end), no state. */

/* The ray through a point of the image plane, in pixels from the left and from the top. */
BS_INLINE void FN(picture_ray)(FN(ray) *ray, const bs_scene *scene, const bs_picture *picture, S x, S y)
{
  const S *const camera = (const S *)scene->camera;
  const S place[2] = {K(2) * x / K(picture->width) - K(1), K(1) - K(2) * y / K(picture->height)};
  FN(cga3d_camera_direction)(ray->direction, camera, camera + BS_CAMERA_LENS, place);
}

#if BS_SCENE_LAYERS
BS_INLINE S FN(infinity)(void)
{
  const S zero = 0;
  return K(1) / zero;
}

/* What the ray through the middle of a pixel meets. Nothing is infinitely far away, and has no normal. */
BS_INLINE void FN(picture_layers)(const bs_scene *scene, const bs_picture *picture, ptrdiff_t place,
                                  const FN(ray) *ray)
{
  FN(hit) hit;
  const FN(search) search = FN(scene_seen)(scene, &hit, ray);
  if (picture->cost) picture->cost[place] = search.cost;
  if (picture->depth)
    ((S *)picture->depth)[place] = search.count ? hit.t * FN(scene_length)(ray->direction) : FN(infinity)();
  if (picture->alpha) ((S *)picture->alpha)[place] = search.count ? hit.alpha : FN(nothing)();
  if (picture->normal) {
    S *const normal = (S *)picture->normal + 3 * place;
    for (int i = 0; i < 3; i++) normal[i] = FN(nothing)();
    if (search.count) FN(scene_normal)(normal, scene, ray, &hit);
  }
}
#endif

/* The mean of what is seen along the rays through a pixel. */
BS_INLINE void FN(picture_color)(S *pixel, const bs_scene *scene, const bs_picture *picture, FN(ray) ray,
                                 ptrdiff_t column, ptrdiff_t line)
{
  const S share = K(1) / K(scene->grid * scene->grid);
  for (int i = 0; i < 3; i++) pixel[i] = 0;
  for (int s = 0; s < scene->grid * scene->grid; s++) {
    S seen[3];
    FN(picture_ray)(&ray, scene, picture, K(column) + (K(s % scene->grid) + K(0.5)) / K(scene->grid),
                    K(line) + (K(s / scene->grid) + K(0.5)) / K(scene->grid));
    FN(scene_color_of)(seen, scene, ray);
    for (int i = 0; i < 3; i++) pixel[i] += share * seen[i];
  }
}

static void FN(scene_render)(const bs_scene *scene, ptrdiff_t begin, ptrdiff_t end, const bs_picture *picture)
{
  FN(ray) ray;
  FN(cga3d_camera_position)(ray.origin, (const S *)scene->camera);
  for (ptrdiff_t p = begin; p < end; p++) {
    const ptrdiff_t column = p % picture->width, line = p / picture->width, place = p - picture->first;
#if BS_SCENE_LAYERS
    FN(picture_ray)(&ray, scene, picture, K(column) + K(0.5), K(line) + K(0.5));
    FN(picture_layers)(scene, picture, place, &ray);
#endif
    if (picture->color) FN(picture_color)((S *)picture->color + 3 * place, scene, picture, ray, column, line);
  }
}

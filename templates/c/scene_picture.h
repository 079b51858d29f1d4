/* bladesmith: the loop over the pixels of a picture: items [begin, end), no state. */

/* Pixels in reading order: row 0 is the top. */
static void FN(scene_render)(const bs_scene *scene, ptrdiff_t begin, ptrdiff_t end, ptrdiff_t width, ptrdiff_t height,
                             void *image)
{
  const S *const camera = (const S *)scene->camera;
  const S share = K(1) / K(scene->grid * scene->grid);
  FN(ray) ray;
  FN(cga3d_camera_position)(ray.origin, camera);
  for (ptrdiff_t p = begin; p < end; p++) {
    S *const pixel = (S *)image + 3 * p, seen[3];
    const ptrdiff_t column = p % width, line = p / width;
    for (int i = 0; i < 3; i++) pixel[i] = 0;
    for (int s = 0; s < scene->grid * scene->grid; s++) {
      const S x = K(column) + (K(s % scene->grid) + K(0.5)) / K(scene->grid);
      const S y = K(line) + (K(s / scene->grid) + K(0.5)) / K(scene->grid);
      const S place[2] = {K(2) * x / K(width) - K(1), K(1) - K(2) * y / K(height)};
      FN(cga3d_camera_direction)(ray.direction, camera, camera + BS_CAMERA_LENS, place);
      FN(scene_color_of)(seen, scene, ray);
      for (int i = 0; i < 3; i++) pixel[i] += share * seen[i];
    }
  }
}

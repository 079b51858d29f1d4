/* bladesmith: the structures and functions of a scene driver, as C and cffi read them. The layouts of arrays are in
   codegen/programs/tracer/records.py. */

typedef struct {
  const void *reals;
  const ptrdiff_t *integers;
} bs_scene;

typedef struct { /* arrays to fill; rows of `roots` entries where all roots are asked for */
  void *t, *point, *normal, *alpha;
  int32_t *surface; /* place in the scene's list, -1 for none; of all roots the row of the surface */
  int32_t *count; /* for all roots only: of all there are, also if rows have less room */
  uint8_t *status;
  uint64_t *checksum; /* of the rays that were read, one for 4096; null where nobody asks */
  ptrdiff_t roots;
} bs_hits;

typedef struct { /* rays: a stride is 0 (one for all) or 3 */
  const void *origins, *directions;
  ptrdiff_t origin_stride, direction_stride;
} bs_rays;

typedef struct { /* a picture, or a band of its pixels */
  const ptrdiff_t *layout;
  void *color; /* linear red, green, blue */
  void *normal, *depth, *alpha; /* of what the ray through the middle of a pixel meets first */
  int32_t *cost; /* surfaces and boxes that this ray asked */
} bs_picture;

const char *bs_source_hash(void);
ptrdiff_t bs_scene_build(ptrdiff_t count, double *boxes, ptrdiff_t *numbers, double *nodes, int32_t *parts);
void bs_scene_prepare(int kind, ptrdiff_t rows, const double *parameters, double *constants);
void bs_scene_first(
    const bs_scene *scene, int single, ptrdiff_t begin, ptrdiff_t end, const bs_rays *rays, const bs_hits *hits);
int bs_scene_wide(
    const bs_scene *scene, int single, ptrdiff_t begin, ptrdiff_t end, const bs_rays *rays, const bs_hits *hits);
void bs_scene_all(
    const bs_scene *scene, int single, ptrdiff_t begin, ptrdiff_t end, const bs_rays *rays, const bs_hits *hits);
void bs_scene_render(const bs_scene *scene, int single, ptrdiff_t begin, ptrdiff_t end, const bs_picture *picture);

/* bladesmith: the structures and functions of a scene driver, as C and cffi read them. */

typedef struct {
  ptrdiff_t count;          /* surfaces of one kind */
  const void *constants;    /* a row for each */
  const int32_t *ids;       /* their places in the scene's list */
} bs_surfaces;

typedef struct {
  bs_surfaces surfaces[32]; /* by kind */
  const void *materials;    /* a row for each surface of the scene's list */
  const void *lights;       /* rows: position, color */
  ptrdiff_t light_count;
  const void *camera;       /* motor (8), focal length, width and height of the image plane */
  const void *sky;          /* colors of the horizon and of the zenith */
  int depth;                /* reflections that are followed */
  int grid;                 /* rays per pixel along each side */
  int method;               /* of ray and evolved surface: 0 isolate, 1 companion, 2 sampled */
  int samples;              /* of the sampled method */
} bs_scene;

typedef struct {            /* arrays to fill; rows of `roots` entries where all roots are asked for */
  void *t, *point, *normal, *alpha;
  int32_t *surface;         /* place in the scene's list, -1 for none; not for all roots */
  int32_t *count;           /* for all roots only */
  uint8_t *status;
  ptrdiff_t roots;
} bs_hits;

typedef struct {            /* rays: a stride is 0 (one for all) or 3 */
  const void *origins, *directions;
  ptrdiff_t origin_stride, direction_stride;
} bs_rays;

const char *bs_source_hash(void);
ptrdiff_t bs_scene_prepare(int kind, ptrdiff_t rows, const double *parameters, double *constants);
void bs_scene_first(const bs_scene *scene, int single, ptrdiff_t begin, ptrdiff_t end, const bs_rays *rays,
                    const bs_hits *hits);
void bs_scene_all(const bs_scene *scene, int single, ptrdiff_t begin, ptrdiff_t end, const bs_rays *rays,
                  const bs_hits *hits);
void bs_scene_render(const bs_scene *scene, int single, ptrdiff_t begin, ptrdiff_t end, ptrdiff_t width,
                     ptrdiff_t height, void *image);

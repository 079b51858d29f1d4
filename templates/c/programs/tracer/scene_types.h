/* bladesmith: the structures and functions of a scene driver, as C and cffi read them. */

typedef struct {
  ptrdiff_t count;          /* rows of one kind: a surface is one or more */
  const void *constants;    /* a row for each */
  const int32_t *ids;       /* their surfaces' places in the scene's list */
  const void *boxes;        /* low and high corner of each row, in the world; null where nobody needs them */
} bs_surfaces;

typedef struct {            /* a node of a tree, 128 bytes: its four parts' boxes, seen from the tree's centre in its unit */
  float boxes[24];          /* x, y, z of the low corners, then of the high ones; inside out where there is no part */
  int32_t parts[4];         /* the number of a node, ~item of a row, or BS_NO_PART */
  int32_t unused[4];
} bs_node;

typedef struct {            /* a tree over the boxes of rows; scene_build.h makes it */
  const bs_node *nodes;
  const int32_t *items;     /* kind and row of each item */
  ptrdiff_t node_count, item_count;
  ptrdiff_t unbounded;          /* items from here to the end have no box: they are always asked */
  double reach;             /* largest absolute coordinate of a box */
  double whole[6];          /* box around all */
  double center[3], unit;   /* a point x of the world is (x - center) * unit for nodes */
} bs_tree;

typedef struct {
  bs_surfaces surfaces[40]; /* by kind: room for all that there are, of every degree */
  bs_tree tree;             /* for programs with one */
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
  int32_t *surface;         /* place in the scene's list, -1 for none; of all roots the row of the surface */
  int32_t *count;           /* for all roots only: of all there are, also if rows have less room */
  uint8_t *status;
  uint64_t *checksum;           /* of the rays that were read, one for 4096; null where nobody asks */
  ptrdiff_t roots;
} bs_hits;

typedef struct {            /* rays: a stride is 0 (one for all) or 3 */
  const void *origins, *directions;
  ptrdiff_t origin_stride, direction_stride;
} bs_rays;

typedef struct {            /* a picture, or a band of its pixels; arrays that are null are not asked for */
  ptrdiff_t width, height;  /* of the whole picture */
  ptrdiff_t first;          /* pixel that the arrays begin with, in reading order: row 0 is the top */
  void *color;              /* linear red, green, blue */
  void *normal, *depth, *alpha; /* of what the ray through the middle of a pixel meets first */
  int32_t *cost;            /* surfaces and boxes that this ray asked */
} bs_picture;

const char *bs_source_hash(void);
ptrdiff_t bs_scene_build(ptrdiff_t count, const double *boxes, double *node_boxes, int32_t *parts, void *room);
ptrdiff_t bs_scene_prepare(int kind, ptrdiff_t rows, const double *parameters, double *constants);
void bs_scene_first(const bs_scene *scene, int single, ptrdiff_t begin, ptrdiff_t end, const bs_rays *rays,
                    const bs_hits *hits);
int bs_scene_wide(const bs_scene *scene, int single, ptrdiff_t begin, ptrdiff_t end, const bs_rays *rays,
                  const bs_hits *hits);
void bs_scene_all(const bs_scene *scene, int single, ptrdiff_t begin, ptrdiff_t end, const bs_rays *rays,
                  const bs_hits *hits);
void bs_scene_render(const bs_scene *scene, int single, ptrdiff_t begin, ptrdiff_t end, const bs_picture *picture);

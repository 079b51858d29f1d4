/* bladesmith: rays, hits and searches of one instance. A kind of surface `name` provides, on rows `k` of constants,
     int FN(name_prepare)(S *k, const S *parameters)
         constants from the user's parameters; 0 where there is no such surface
     void FN(name_hits)(search *, const S *k, const ray *)
         offers every point of the ray to the search; points beyond its bounds need not be looked for, but what is
         found must not depend on them in any bit. Sets search->status where it cannot tell.
     void FN(name_normal)(S *normal, const S *k, const ray *, const hit *)
         unit normal, either side
   t counts in units of the ray's direction, which may have any length. */

#define BS_FLOOR1(x) ((S)floor((double)(x)))
#define BS_FAR K(BS_BITS == 64 ? 1.7976931348623157e308 : 3.4028234663852886e38)

typedef struct {
  S origin[3], direction[3];
} FN(ray);

typedef struct {
  S t, alpha;         /* alpha: parameter of the surface's curve, where it has one */
  S at;               /* and that of its piece, from 0 to 1 */
  S point[3];         /* in the world */
  S local[3];         /* in the surface's own frame */
  int kind;
  ptrdiff_t index;    /* among the surfaces of its kind */
} FN(hit);

/* What is looked for: points with t_min < t < t_max. With room for one hit it is the nearest: t_max falls. Of points at
   the same t that of the lowest surface number counts, and of one surface that of the lowest row, in whatever order
   they are asked. */
typedef struct {
  S t_min, t_max;
  FN(hit) *hits;
  int room, count;
  int kind;           /* of the row that is asked */
  ptrdiff_t index;
  int method, samples;
  int status;         /* of that row: its functions set it where they cannot tell */
  S singular, invalid; /* where the nearest row that said so begins; BS_FAR if none did */
  int cost;           /* rows and boxes that were asked */
  const bs_scene *scene;
  const bs_hits *gather; /* for all points of a line: arrays to fill, the ray's place in them, points so far */
  ptrdiff_t place;
  int total;
  int lost;           /* one of them is too far away for a number: nothing is told of that line */
} FN(search);

BS_INLINE FN(search) FN(search_for)(const bs_scene *scene, FN(hit) *hits, int room)
{
  FN(search) search;
  search.t_min = room > 1 ? -BS_FAR : K(0), search.t_max = BS_FAR;
  search.hits = hits, search.room = room, search.count = 0;
  search.kind = 0, search.index = 0;
  search.method = scene->method, search.samples = scene->samples, search.status = BS_STATUS_OK;
  search.singular = search.invalid = BS_FAR;
  search.cost = 0, search.scene = scene;
  search.gather = 0, search.place = 0, search.total = 0, search.lost = 0;
  return search;
}

/* Status of a ray that has been asked: rows that begin behind its first hit have no say. */
BS_INLINE int FN(search_status)(const FN(search) *search)
{
  if (search->invalid < search->t_max) return BS_STATUS_INVALID;
  return search->singular < search->t_max ? BS_STATUS_SINGULAR : BS_STATUS_OK;
}

BS_INLINE void FN(copy)(S *to, const S *from, int n)
{
  for (int i = 0; i < n; i++) to[i] = from[i];
}

BS_INLINE S FN(nothing)(void) /* NaN, also where there is no math.h */
{
  const S zero = 0;
  return zero / zero;
}

/* 1 if the row that is asked goes before that of the hit found so far, which is as near. */
BS_OUTLINED int FN(precedes)(const FN(search) *search)
{
  const FN(hit) *const hit = search->hits;
  const int32_t id = search->scene->surfaces[search->kind].ids[search->index];
  const int32_t other = search->scene->surfaces[hit->kind].ids[hit->index];
  return id < other || (id == other && search->index < hit->index);
}

BS_INLINE S FN(scene_length)(const S *x)
{
  return SQRT(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
}

/* A place for a hit at t, if it is wanted: the caller fills in its points. */
BS_INLINE FN(hit) *FN(accept)(FN(search) *search, S t, S alpha)
{
  if (!(t > search->t_min && t <= search->t_max)) return 0;
  if (search->room == 1) {
    if (t == search->t_max && !(search->count && FN(precedes)(search))) return 0;
    search->count = 0;
    search->t_max = t;
  } else if (search->count == search->room) {
    return 0;
  }
  FN(hit) *const hit = &search->hits[search->count++];
  hit->t = t, hit->alpha = alpha;
  hit->kind = search->kind, hit->index = search->index;
  return hit;
}

/* A point of the ray, given relative to a centre. */
BS_INLINE void FN(offer)(FN(search) *search, S t, const S *center, const S *local)
{
  FN(hit) *const hit = FN(accept)(search, t, FN(nothing)());
  if (!hit) return;
  for (int i = 0; i < 3; i++) {
    hit->local[i] = local[i];
    hit->point[i] = center[i] + local[i];
  }
}

/* bladesmith: rays, hits and searches of one instance. A kind of surface `name` provides, on rows `k` of constants,
     int FN(name_prepare)(S *k, const S *parameters)
         constants from the user's parameters; 0 where there is no such surface
     void FN(name_hits)(search *, const S *k, const ray *)
         offers every point of the ray to the search; points beyond its bounds need not be looked for
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
  S point[3];         /* in the world */
  S local[3];         /* in the surface's own frame */
  int kind;
  ptrdiff_t index;    /* among the surfaces of its kind */
} FN(hit);

/* What is looked for: points with t_min < t < t_max. With room for one hit it is the nearest: t_max falls. */
typedef struct {
  S t_min, t_max;
  FN(hit) *hits;
  int room, count;
  int kind;           /* of the surface that is asked */
  ptrdiff_t index;
  int method, samples, status;
} FN(search);

BS_INLINE FN(search) FN(search_for)(const bs_scene *scene, FN(hit) *hits, int room)
{
  FN(search) search;
  search.t_min = room > 1 ? -BS_FAR : K(0), search.t_max = BS_FAR;
  search.hits = hits, search.room = room, search.count = 0;
  search.kind = 0, search.index = 0;
  search.method = scene->method, search.samples = scene->samples, search.status = BS_STATUS_OK;
  return search;
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

/* A place for a hit at t, if it is wanted: the caller fills in its points. */
BS_INLINE FN(hit) *FN(accept)(FN(search) *search, S t, S alpha)
{
  if (!(t > search->t_min && t < search->t_max)) return 0;
  if (search->room == 1) {
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

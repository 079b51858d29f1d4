/* bladesmith: ribbons, surfaces evolved along curves of point pairs. Everything is done in the surface's own frame,
   moved and scaled to about unit size; its constants are made there once. ribbons.h finds the roots; here they become
   points. One inclusion makes one member of the family: BS_MEMBER is its name, BS_SUFFIX that of its kernels. */

#define RIBBON(name) FN(BS_PASTE(ribbon_##name, BS_SUFFIX))
#define RIBBON_KERNEL(name) FN(BS_PASTE(cga3d_ribbon_##name, BS_SUFFIX))
#define RIBBON_FN(name) FN(BS_PASTE(BS_MEMBER, name))
#define RIBBON_PAIRS (BS_DEGREE + 1)
#define RIBBON_NORM (2 * BS_DEGREE + 1)
#define RIBBON_PRINTED (6 * BS_DEGREE)
#if BS_FREE
#define RIBBON_WEIGHT 1
#define RIBBON_DEGREE (6 * BS_DEGREE)
#define RIBBON_KAPPA (4 * BS_DEGREE + 1)
#define RIBBON_PRODUCTS (3 * BS_DEGREE + 1)
#else
#define RIBBON_WEIGHT 0.5 /* largest Bernstein coefficient of w = a b */
#define RIBBON_DEGREE (6 * BS_DEGREE - 2)
#define RIBBON_KAPPA (4 * BS_DEGREE - 3)
#define RIBBON_PRODUCTS (3 * BS_DEGREE - 1)
#endif
#define RIBBON_MEETS (RIBBON_PAIRS + RIBBON_PRODUCTS)

enum {
  RIBBON(CENTER) = 0,   /* of the frame, in the world */
  RIBBON(SCALE) = 3,    /* length of its unit, and one over it */
  RIBBON(START) = 5,    /* the curve's parameter where the piece begins, and how long it is there */
  RIBBON(BOUND) = 7,    /* centre and radius of a sphere around the surface, in the frame */
  RIBBON(SPANS) = 11,   /* where the pairs are real */
  RIBBON(NORM) = 19,
  RIBBON(KAPPA) = RIBBON(NORM) + RIBBON_NORM,
  RIBBON(CONTROLS) = RIBBON(KAPPA) + RIBBON_KAPPA,
  RIBBON(PRODUCTS) = RIBBON(CONTROLS) + 10 * RIBBON_PAIRS,
  RIBBON(SIZES) = RIBBON(PRODUCTS) + 10 * RIBBON_PRODUCTS, /* of norm and kappa */
  RIBBON(LEVERS) = RIBBON(SIZES) + 2, /* of B and E: what rounding may leave of them, for a ray's length */
  RIBBON(GIVEN) = 15    /* parameters before the controls */
};

/* What ribbons.h asks for. Of a method that the program leaves out, only the name remains. */
#define RIBBON_VALUE(name, has) \
  BS_INLINE S RIBBON(name)(const S *meets, const S *norm, const S *kappa, S a, S b) \
  { \
    S value[1] = {0}; \
    has(RIBBON_KERNEL(name)(value, meets, norm, kappa, &a, &b);) \
    (void)meets, (void)norm, (void)kappa, (void)a, (void)b; \
    return value[0]; \
  }
#define RIBBON_ROW(name, has) \
  BS_INLINE void RIBBON(name)(S *out, const S *meets, const S *norm, const S *kappa) \
  { \
    has(RIBBON_KERNEL(name)(out, meets, norm, kappa);) \
    (void)out, (void)meets, (void)norm, (void)kappa; \
  }
#define RIBBON_HAS(call) call
#define RIBBON_LACKS(call)
#if BS_SCENE_ISOLATE
#define RIBBON_ISOLATE RIBBON_HAS
#else
#define RIBBON_ISOLATE RIBBON_LACKS
#endif
#if BS_SCENE_COMPANION
#define RIBBON_COMPANION RIBBON_HAS
#else
#define RIBBON_COMPANION RIBBON_LACKS
#endif
#if BS_SCENE_COMPANION || BS_SCENE_SAMPLED
#define RIBBON_PRINTS RIBBON_HAS
#else
#define RIBBON_PRINTS RIBBON_LACKS
#endif
RIBBON_VALUE(condition, RIBBON_ISOLATE)
RIBBON_VALUE(condition_bound, RIBBON_ISOLATE)
RIBBON_VALUE(polynomial_bound, RIBBON_ISOLATE)
RIBBON_VALUE(meet, RIBBON_PRINTS)
RIBBON_ROW(polynomial, RIBBON_ISOLATE)
RIBBON_ROW(published_polynomial, RIBBON_COMPANION)

BS_INLINE S RIBBON(closed_alpha)(const S *meets)
{
  S alpha[1] = {0};
#if BS_DEGREE == 1 && BS_SCENE_ISOLATE
  RIBBON_KERNEL(closed_alpha)(alpha, meets);
#endif
  (void)meets;
  return alpha[0];
}

#include "ribbons.h"

#ifndef BS_RIBBON_HIT_CONSTANTS
#define BS_RIBBON_HIT_CONSTANTS
/* Roundings, relative to the frame's unit and the way along the ray, by which a point past the end of a segment still
   counts. */
#define BS_RIBBON_MARGIN 32
/* Squared sine between ray and carrier below which the point is refined: t from the root alone loses its square. */
#define BS_RIBBON_FLAT 1e-4
/* In square roots of the unit roundoff: how far from a carrier a ray may be that lies in it, and off its direction; how
   far apart both roots may be that rounding makes of one; how far from the root refining starts where it cannot at the
   root itself. */
#define BS_RIBBON_BESIDE 64
/* COCIRCULAR: roundings that 4-vectors of pairs on one circle are off zero, relative to their terms. STEPS: of Newton
   from a root to the point. SAME: roundings within which points or directions are one. BLUR: roundings, over the sine
   between ray and carrier, up to which a last step is none. AROUND: as many, over that by which the ribbon is not flat,
   within which places along the ray are one. ALONG: steps to the carrier nearest to a ray. */
enum {
  BS_RIBBON_COCIRCULAR = 16, BS_RIBBON_STEPS = 6, BS_RIBBON_SAME = 4096, BS_RIBBON_BLUR = 256, BS_RIBBON_AROUND = 8,
  BS_RIBBON_ALONG = 3
};
/* Of half of the segment: a step along the ray that is none, and one that leaves the place in doubt. */
#define BS_RIBBON_SETTLED(T) ((T)(sizeof(T) == 4 ? 1e-2 : 1e-4))
#define BS_RIBBON_DOUBT 1e-2
#endif

/* Replace Q by nothing where rounding is all there is of it: pairs on one circle need no projection (4.7.3). Squares of
   the ends are 1 where they are to rounding: of a short pair, rounding would be all that is left of its length. */
BS_INLINE void RIBBON(without_rounding)(S *k, const S *near)
{
  const S least = K(BS_RIBBON_COCIRCULAR) * BS_ROOTS_UNIT(S);
  S *const ends[2] = {k + RIBBON(NORM), k + RIBBON(KAPPA) - 1};
  for (int i = 0; i < RIBBON_KAPPA && near[0] <= least * least * near[1]; i++) k[RIBBON(KAPPA) + i] = 0;
  for (int i = 0; i < 10 * RIBBON_PRODUCTS && near[0] <= least * least * near[1]; i++) k[RIBBON(PRODUCTS) + i] = 0;
  for (int i = 0; i < 2; i++)
    if (ABS(*ends[i] - K(1)) <= near[2 + i]) *ends[i] = 1;
}

/* Parameters of a surface: frame (centre, unit, one over it), start, length, spans, controls. */
BS_INLINE int RIBBON_FN(prepare)(S *k, const S *parameters)
{
  S near[8];
  FN(copy)(k, parameters, 7);
  for (int i = 0; i < 3; i++) k[RIBBON(BOUND) + i] = 0;
  k[RIBBON(BOUND) + 3] = BS_FAR; /* unbounded, until somebody knows better */
  FN(copy)(k + RIBBON(SPANS), parameters + 7, 2 * BS_RIBBON_SPANS);
  RIBBON_KERNEL(constants)(k + RIBBON(NORM), k + RIBBON(KAPPA), k + RIBBON(CONTROLS), k + RIBBON(PRODUCTS), near,
                           parameters + RIBBON(GIVEN));
  RIBBON(without_rounding)(k, near);
  k[RIBBON(SIZES)] = RIBBON(size)(k + RIBBON(NORM), RIBBON_NORM);
  k[RIBBON(SIZES) + 1] = RIBBON(size)(k + RIBBON(KAPPA), RIBBON_KAPPA);
  FN(copy)(k + RIBBON(LEVERS), near + 4, 4);
  return 1;
}

typedef struct {
  const S *k;
  S origin[3];      /* of the ray, in the frame, moved along it to where the surface is */
  S moved;          /* by this parameter */
  const S *direction;
  S near_t[5 * (RIBBON_DEGREE + 2)], near_b[5 * (RIBBON_DEGREE + 2)]; /* points found by refining, and how well t */
  S near_blur[5 * (RIBBON_DEGREE + 2)];                               /* is known */
  int near_count;
  S along[RIBBON_DEGREE + 2]; /* roots whose segments lie in the ray */
  int along_count;
} RIBBON(meeting);

BS_INLINE void RIBBON(offer)(FN(search) *search, const RIBBON(meeting) *m, S t, S b, const S *position)
{
  const S unit = m->k[RIBBON(SCALE)];
  FN(hit) *const hit = FN(accept)(search, (t + m->moved) * unit, m->k[RIBBON(START)] + m->k[RIBBON(START) + 1] * b);
  if (!hit) return;
  hit->at = b;
  for (int i = 0; i < 3; i++) {
    hit->local[i] = position[i];
    hit->point[i] = m->k[i] + unit * position[i];
  }
}

/* 1 if a point, so far from the middle of its segment, is within half of it: the ends belong to the surface. */
BS_INLINE int RIBBON(within)(const RIBBON(meeting) *m, S t, const S *place)
{
  const S *const d = m->direction;
  const S way = K(1) + ABS(t) * FN(scene_length)(d);
  return ABS(place[0]) <= place[1] + K(BS_RIBBON_MARGIN) * BS_ROOTS_UNIT(S) * way;
}

/* t and b of a point where a ray meets a carrier, refined from a start; 0 where it does not settle. last: the last step
   of t, which near the carrier's direction is rounding; apart: the squared sine that this rounding is over. */
BS_INLINE int RIBBON(refined)(const RIBBON(meeting) *m, S *t, S *b, S *last, S *apart)
{
  const S *const k = m->k;
  S step[3] = {0, 0, 0};
  for (int i = 0; i < BS_RIBBON_STEPS; i++) {
    const S a = K(1) - *b;
    RIBBON_KERNEL(polish)(step, m->origin, m->direction, t, k + RIBBON(NORM), k + RIBBON(KAPPA), &a, b,
                          k + RIBBON(CONTROLS), k + RIBBON(PRODUCTS));
    *t += step[0], *b += step[1];
  }
  *last = ABS(step[0]), *apart = step[2];
  return ABS(step[1]) <= BS_ROOTS_NEAR(S) * BS_ROOTS_NEAR(S) && *last < BS_FAR;
}

/* A point of a ray that is nearly parallel to the carrier of its pair, refined from a start: offered, unless it was
   before. 0 where it does not settle. half: of the segment, in t. */
BS_OUTLINED int RIBBON(near_point)(FN(search) *search, RIBBON(meeting) *m, S half, S t, S b)
{
  const S *const k = m->k, *const d = m->direction, settled = BS_ROOTS_NEAR(S) * BS_ROOTS_NEAR(S);
  const S margin = K(BS_ROOTS_MARGIN) * BS_ROOTS_UNIT(S);
  S place[3], position[3], last, apart;
  if (!RIBBON(refined)(m, &t, &b, &last, &apart)) return 0;
  const S on = b < 0 ? K(0) : b > 1 ? K(1) : b, a = K(1) - on;
  for (int i = 0; i < 3; i++) position[i] = m->origin[i] + t * d[i];
  RIBBON_KERNEL(position)(place, position, d, k + RIBBON(NORM), k + RIBBON(KAPPA), &a, &on, k + RIBBON(CONTROLS),
                       k + RIBBON(PRODUCTS));
  const S way = K(1) / FN(scene_length)(d) + ABS(t);
  const S rounding = BS_ROOTS_UNIT(S) * way / SQRT(place[2]), doubt = K(BS_RIBBON_DOUBT) * half;
  const S around = K(BS_RIBBON_AROUND) * rounding / SQRT(apart), least = BS_RIBBON_SETTLED(S) * half;
  const S spread = around < doubt ? around : doubt, known = spread > least ? spread : least;
  const S blur = last > known ? last : known;
  if (!(last <= doubt || last <= K(BS_RIBBON_BLUR) * rounding)) return 0;
  if (!(b >= -margin && b <= K(1) + margin)) return 1;
  if (!(place[2] <= K(BS_RIBBON_FLAT)) || !RIBBON(real)(k + RIBBON(SPANS), on)) return 1; /* another root's */
  for (int i = 0; i < m->near_count; i++)
    if (ABS(m->near_t[i] - t) <= blur + m->near_blur[i] && ABS(m->near_b[i] - on) <= settled) return 1;
  m->near_t[m->near_count] = t, m->near_b[m->near_count] = on, m->near_blur[m->near_count++] = blur;
  if (RIBBON(within)(m, t, place)) RIBBON(offer)(search, m, t, on, position);
  return 1;
}

/* The ends of a segment that lies in the ray, once: a root that touches may be found as two. */
BS_OUTLINED void RIBBON(offer_ends)(FN(search) *search, RIBBON(meeting) *m, S b, const S *ends)
{
  S position[3];
  for (int i = 0; i < m->along_count; i++)
    if (ABS(m->along[i] - b) <= K(BS_RIBBON_BESIDE) * BS_RIBBON_SQRT(S)) return;
  m->along[m->along_count++] = b;
  for (int side = -1; side <= 1; side += 2) {
    const S t = ends[0] + K(side) * ends[1];
    for (int i = 0; i < 3; i++) position[i] = m->origin[i] + t * m->direction[i];
    RIBBON(offer)(search, m, t, b, position);
  }
}

/* The points of a ray that is nearly parallel to the carrier of a root. Two roots may lie closer than numbers tell, of
   points far apart: each t that the root's pair and its motion allow is refined together with the root; where none can
   be, from beside the root. A ray that cannot be told from the carrier has the whole segment in common with the surface:
   its two ends are offered. */
BS_OUTLINED void RIBBON(near_hit)(FN(search) *search, RIBBON(meeting) *m, S t, S root)
{
  const S *const norm = m->k + RIBBON(NORM), *const kappa = m->k + RIBBON(KAPPA), *const d = m->direction;
  const S *const c = m->k + RIBBON(CONTROLS), *const qc = m->k + RIBBON(PRODUCTS);
  const S beside = K(BS_RIBBON_BESIDE) * BS_RIBBON_SQRT(S), same = K(BS_RIBBON_SAME) * BS_ROOTS_UNIT(S);
  S a = K(1) - root, b = root, ends[7];
  RIBBON_KERNEL(ends)(ends, m->origin, d, norm, kappa, &a, &b, c, qc);
  const S starts[5][2] = {{t, root}, {ends[3], root}, {ends[4], root}, {ends[0], root - beside}, {ends[0], root + beside}};
  const int is_along = ends[2] <= beside && ends[6] <= beside * beside;
  for (int i = 0; i < BS_RIBBON_ALONG && is_along; i++) {
    b += ends[5];
    b = b < 0 ? K(0) : b > 1 ? K(1) : b, a = K(1) - b;
    RIBBON_KERNEL(ends)(ends, m->origin, d, norm, kappa, &a, &b, c, qc);
  }
  const S way = K(1) + ABS(ends[0]) * FN(scene_length)(d);
  if (is_along && ends[2] <= same * way && ends[6] <= same * same) {
    RIBBON(offer_ends)(search, m, b, ends);
    return;
  }
  int found = 0;
  for (int i = 0; i < 5 && (i < 3 || !found); i++)
    found |= RIBBON(near_point)(search, m, ends[1], starts[i][0], starts[i][1]);
  if (!found && is_along) RIBBON(offer_ends)(search, m, b, ends);
}

/* A ray that meets all carriers meets all in one point where they have one in common, as the corner of a facet. 0 where
   there is none. */
BS_COLD int RIBBON(common)(FN(search) *search, const RIBBON(meeting) *m)
{
  S t_place[3][4], position[3][3], sine_square[1];
  for (int i = 0; i < 3; i++) {
    const S b = K(0.5) * K(i), a = K(1) - b;
    RIBBON_KERNEL(point)(t_place[i], position[i], sine_square, m->origin, m->direction, m->k + RIBBON(NORM),
                         m->k + RIBBON(KAPPA), &a, &b, m->k + RIBBON(CONTROLS), m->k + RIBBON(PRODUCTS));
    const S apart = ABS(t_place[i][0] - t_place[0][0]), size = K(1) + ABS(t_place[0][0]);
    if (!(sine_square[0] > K(BS_RIBBON_FLAT) && apart <= K(BS_RIBBON_SAME) * BS_ROOTS_UNIT(S) * size)) return 0;
  }
  if (RIBBON(within)(m, t_place[0][0], t_place[0] + 1)) RIBBON(offer)(search, m, t_place[0][0], K(0), position[0]);
  return 1;
}

BS_INLINE int RIBBON(roots)(S *roots, S *meets, const S *noise, const S *k, const S *direction,
                            const FN(search) *search)
{
  const S *const norm = k + RIBBON(NORM), *const kappa = k + RIBBON(KAPPA), *const spans = k + RIBBON(SPANS);
#if BS_SCENE_ISOLATE
  if (search->method == 0)
    return RIBBON(isolate)(roots, RIBBON_DEGREE, meets, noise, norm, kappa, k + RIBBON(SIZES), spans);
#endif
  /* The printed methods look at the size of f. */
  const S over = K(1) / FN(scene_length)(direction);
  for (int i = 0; i < RIBBON_MEETS; i++) meets[i] *= over;
#if BS_SCENE_COMPANION
  if (search->method == 1) return RIBBON(companion)(roots, RIBBON_DEGREE, meets, norm, kappa, spans);
#endif
#if BS_SCENE_SAMPLED
  if (search->method == 2) return RIBBON(sampled)(roots, RIBBON_DEGREE, meets, norm, kappa, spans, search->samples);
#endif
  (void)roots, (void)noise, (void)norm, (void)kappa, (void)spans, (void)search;
  return 0;
}

#if BS_SCENE_ISOLATE
/* Where a ray meets the first or the last segment to rounding and no root says so: roots may be just beyond the end, of
   rays along the carrier, and of those through the joint of two pieces beyond the ends of both. */
BS_OUTLINED void RIBBON(end_hits)(FN(search) *search, RIBBON(meeting) *m, const S *meets, const S *noise, const S *roots,
                             int count)
{
  const S *const norm = m->k + RIBBON(NORM), *const kappa = m->k + RIBBON(KAPPA), *const d = m->direction;
  const S beside = K(BS_RIBBON_BESIDE) * BS_RIBBON_SQRT(S);
  for (int end = 0; end < 2; end++) {
    const S b = K(end), a = K(1) - b;
    S t_place[4], position[3], sine_square[1];
    int known = 0;
    for (int i = 0; i < count; i++) known |= ABS(roots[i] - b) <= beside;
    if (known || !RIBBON(ends_at_zero)(meets, noise, norm, kappa, b) || !RIBBON(real)(m->k + RIBBON(SPANS), b)) continue;
    RIBBON_KERNEL(point)(t_place, position, sine_square, m->origin, d, norm, kappa, &a, &b, m->k + RIBBON(CONTROLS),
                         m->k + RIBBON(PRODUCTS));
    const S way = K(1) + ABS(t_place[0]) * FN(scene_length)(d);
    if (!(sine_square[0] > K(BS_RIBBON_FLAT)))
      RIBBON(near_hit)(search, m, t_place[0], b);
    else if (t_place[3] <= K(BS_RIBBON_MARGIN) * BS_ROOTS_UNIT(S) * way && RIBBON(within)(m, t_place[0], t_place + 1))
      RIBBON(offer)(search, m, t_place[0], b, position);
  }
}
#endif

BS_OUTLINED void RIBBON_FN(hits)(FN(search) *search, const S *k, const FN(ray) *ray)
{
  const S *const norm = k + RIBBON(NORM), *const kappa = k + RIBBON(KAPPA);
  const S *const c = k + RIBBON(CONTROLS), *const qc = k + RIBBON(PRODUCTS);
  const S *const bound = k + RIBBON(BOUND), *const unit = k + RIBBON(SCALE);
  S meets[RIBBON_MEETS], noise[2], roots[RIBBON_DEGREE];
  RIBBON(meeting) m;
  m.k = k, m.direction = ray->direction, m.near_count = 0, m.along_count = 0, m.moved = 0;
  for (int i = 0; i < 3; i++) m.origin[i] = (ray->origin[i] - k[i]) * unit[1];
  if (bound[3] < BS_FAR) {
    S middle_half[2];
    FN(cga3d_evolved_approach)(middle_half, m.origin, m.direction, bound, bound + 3);
    const S first = middle_half[0] - middle_half[1], last = middle_half[0] + middle_half[1];
    if (!(last * unit[0] > search->t_min && first * unit[0] < search->t_max)) return;
    m.moved = middle_half[0];
    for (int i = 0; i < 3; i++) m.origin[i] += m.moved * m.direction[i];
  }
  RIBBON_KERNEL(ray)(meets, noise, m.origin, m.direction, c, qc, k + RIBBON(LEVERS));
  const int count = RIBBON(roots)(roots, meets, noise, k, m.direction, search);
  if (count == BS_RIBBON_INVALID) search->status = BS_STATUS_INVALID;
  if (count == BS_RIBBON_VANISHES && !RIBBON(common)(search, &m)) search->status = BS_STATUS_SINGULAR;
  for (int i = 0; i < count; i++) {
    const S a = K(1) - roots[i], b = roots[i];
    S t_place[4], position[3], sine_square[1];
    RIBBON_KERNEL(point)(t_place, position, sine_square, m.origin, m.direction, norm, kappa, &a, &b, c, qc);
    if (!(sine_square[0] > K(BS_RIBBON_FLAT))) {
      RIBBON(near_hit)(search, &m, t_place[0], b);
    } else if (RIBBON(within)(&m, t_place[0], t_place + 1)) {
      RIBBON(offer)(search, &m, t_place[0], b, position);
    }
  }
#if BS_SCENE_ISOLATE
  if (search->method == 0 && count >= 0) RIBBON(end_hits)(search, &m, meets, noise, roots, count);
#endif
}

BS_OUTLINED void RIBBON_FN(normal)(S *normal, const S *k, const FN(ray) *ray, const FN(hit) *hit)
{
  const S b = hit->at, a = K(1) - b;
  (void)ray;
  RIBBON_KERNEL(normal)(normal, hit->local, k + RIBBON(NORM), k + RIBBON(KAPPA), &a, &b, k + RIBBON(CONTROLS),
                        k + RIBBON(PRODUCTS));
}

#undef RIBBON
#undef RIBBON_KERNEL
#undef RIBBON_FN
#undef RIBBON_PAIRS
#undef RIBBON_NORM
#undef RIBBON_PRINTED
#undef RIBBON_WEIGHT
#undef RIBBON_DEGREE
#undef RIBBON_KAPPA
#undef RIBBON_PRODUCTS
#undef RIBBON_MEETS
#undef RIBBON_VALUE
#undef RIBBON_ROW
#undef RIBBON_HAS
#undef RIBBON_LACKS
#undef RIBBON_ISOLATE
#undef RIBBON_COMPANION
#undef RIBBON_PRINTS
#undef BS_MEMBER
#undef BS_SUFFIX
#undef BS_DEGREE
#undef BS_FREE

/* bladesmith: surfaces evolved along pieces of curves of circles, of one degree. No guard: included once for each, under
   BS_MEMBER (the kind), BS_SUFFIX (of its kernels), BS_DEGREE and BS_FREE. Everything is done in the piece's own frame,
   moved and scaled to about unit size; its constants are made there once. evolved.h finds the roots; here they become
   points. */
#define EVOLVED(name) FN(BS_PASTE(BS_MEMBER, name))
#define KERNEL(name) FN(BS_PASTE(cga3d_##name, BS_SUFFIX))

#include "evolved.h"

#ifndef BS_EVOLVED_HIT_CONSTANTS
#define BS_EVOLVED_HIT_CONSTANTS
/* Squared cosine between ray and axis below which a ray counts as near the plane of the circle: the meet's point
   loses a digit for each of the cosine. As many roundings are the cosine below which nothing is left of the meet. */
#define BS_EVOLVED_FLAT 1e-4
#define BS_EVOLVED_NO_MEET 1024
/* Squared distance, in lengths of the frame, of hits that come from the far end of the meet where there is one. */
#define BS_EVOLVED_DISTANT 1e10
/* Newton steps from a root to the point; three are enough, the fourth confirms. */
enum { BS_EVOLVED_STEPS = 4 };
#endif

/* S0, K, the controls with their binomials inside, and Q C': sums over products of two coefficients. */
BS_OUTLINED void EVOLVED(constants)(S *k, const S *controls)
{
  S *const norm = k + EVOLVED_NORM, *const kappa = k + EVOLVED_KAPPA;
  S *const c = k + EVOLVED_CONTROLS, *const products = k + EVOLVED_PRODUCTS;
  S squares[5 * (2 * BS_DEGREE + 1)] = {0}, binomial = 1, sum[10];
  const S *const quad = squares + (BS_FREE ? 0 : 5); /* between circles the ends of w Q vanish */
  for (int i = 0; i <= BS_DEGREE; i++) {
    for (int j = 0; j < 10; j++) c[10 * i + j] = binomial * controls[10 * i + j];
    binomial = binomial * K(BS_DEGREE - i) / K(i + 1);
  }
  for (int i = 0; i < EVOLVED_SIZES - EVOLVED_PRODUCTS; i++) products[i] = 0;
  for (int i = 0; i < EVOLVED_CONTROLS - EVOLVED_NORM; i++) norm[i] = 0;
  for (int i = 0; i <= BS_DEGREE; i++)
    for (int j = i; j <= BS_DEGREE; j++) {
      const S weight = i < j ? K(2) : K(1);
      S *const to = squares + 5 * (i + j);
      FN(cga3d_square_term)(sum, sum + 1, norm + i + j, to, c + 10 * i, c + 10 * j, &weight);
      norm[i + j] = sum[0];
      FN(copy)(to, sum + 1, 5);
    }
  for (int i = 0; i <= EVOLVED_QUAD; i++) {
    for (int j = i; j <= EVOLVED_QUAD; j++) {
      const S weight = i < j ? K(2) : K(1);
      FN(cga3d_kappa_term)(sum, kappa + i + j, quad + 5 * i, quad + 5 * j, &weight);
      kappa[i + j] = sum[0];
    }
    for (int j = 0; j <= BS_DEGREE; j++) {
      S *const to = products + 10 * (i + j);
      FN(cga3d_product_term)(sum, to, quad + 5 * i, c + 10 * j);
      FN(copy)(to, sum, 10);
    }
  }
  KERNEL(evolved_sizes)(k + EVOLVED_SIZES, norm, kappa, quad, c, products);
}

/* Parameters of a piece: frame (centre, unit, one over it), where it begins on the curve and how long it is, spans, controls. */
BS_INLINE int EVOLVED(prepare)(S *k, const S *parameters)
{
  FN(copy)(k, parameters, EVOLVED_BOUND);
  for (int i = 0; i < 3; i++) k[EVOLVED_BOUND + i] = 0;
  k[EVOLVED_BOUND + 3] = BS_FAR; /* unbounded, until somebody knows better */
  FN(copy)(k + EVOLVED_REAL, parameters + EVOLVED_BOUND, 2 * BS_EVOLVED_SPANS);
  EVOLVED(constants)(k, parameters + EVOLVED_BOUND + 2 * BS_EVOLVED_SPANS);
  return 1;
}

typedef struct {
  const S *k;
  S origin[3];      /* of the ray, in the frame, moved along it to where it is nearest to the frame's */
  S moved;          /* by this parameter */
  const S *direction;
  const S *roots;
  int root_count;
  S flat_t[2 * EVOLVED_ROOTS], flat_at[2 * EVOLVED_ROOTS]; /* points found by flat_hits, and their parameters */
  int flat_count;
} EVOLVED(meeting);

BS_INLINE void EVOLVED(offer)(FN(search) *search, const EVOLVED(meeting) *m, S t, S at, const S *position)
{
  const S unit = m->k[EVOLVED_UNIT];
  FN(hit) *const hit = FN(accept)(search, (t + m->moved) * unit, m->k[EVOLVED_START] + m->k[EVOLVED_START + 1] * at);
  if (!hit) return;
  hit->at = at;
  for (int i = 0; i < 3; i++) {
    hit->local[i] = position[i];
    hit->point[i] = m->k[i] + unit * position[i];
  }
}

/* 1 if no other root has found the same point near the plane of its circle: each counts once. */
BS_INLINE int EVOLVED(fresh)(EVOLVED(meeting) *m, S t, S at)
{
  const S settled = BS_ROOTS_NEAR(S) * BS_ROOTS_NEAR(S);
  for (int i = 0; i < m->flat_count; i++)
    if (ABS(m->flat_t[i] - t) <= settled * (K(1) + ABS(t)) && ABS(m->flat_at[i] - at) <= settled) return 0;
  m->flat_t[m->flat_count] = t, m->flat_at[m->flat_count++] = at;
  return 1;
}

/* 1 if the nearest root to a parameter is this one. */
BS_INLINE int EVOLVED(own)(const EVOLVED(meeting) *m, int root, S at)
{
  const S settled = BS_ROOTS_NEAR(S) * BS_ROOTS_NEAR(S);
  for (int i = 0; i < m->root_count; i++)
    if (ABS(m->roots[i] - at) < ABS(m->roots[root] - at) - settled) return 0;
  return 1;
}

/* Hits of a ray that lies near the plane of the circle of a root, where the meet vanishes: its points on the circle's
   sphere, refined. A root that only touches has two. */
BS_COLD void EVOLVED(flat_hits)(FN(search) *search, EVOLVED(meeting) *m, int root)
{
  const S *const norm = m->k + EVOLVED_NORM, *const kappa = m->k + EVOLVED_KAPPA;
  const S *const c = m->k + EVOLVED_CONTROLS, *const products = m->k + EVOLVED_PRODUCTS;
  S at = m->roots[root], rest = K(1) - at, start[2];
  KERNEL(evolved_sphere)(start, m->origin, m->direction, norm, kappa, &rest, &at, c, products);
  for (int side = 0; side < 2; side++) {
    S t = start[side], step[3] = {0, 0, 0}, position[3];
    at = m->roots[root];
    for (int i = 0; i < BS_EVOLVED_STEPS; i++) {
      rest = K(1) - at;
      KERNEL(evolved_polish)(step, m->origin, m->direction, &t, norm, kappa, &rest, &at, c, products);
      t += step[0], at += step[1];
    }
    const S margin = K(BS_ROOTS_MARGIN) * BS_ROOTS_UNIT(S), settled = BS_ROOTS_NEAR(S) * BS_ROOTS_NEAR(S);
    if (!(at >= -margin && at <= K(1) + margin && ABS(step[1]) < settled)) continue;
    at = at < 0 ? K(0) : at > 1 ? K(1) : at;
    if (!EVOLVED(own)(m, root, at) || !EVOLVED(fresh)(m, t, at)) continue;
    for (int i = 0; i < 3; i++) position[i] = m->origin[i] + t * m->direction[i];
    EVOLVED(offer)(search, m, t, at, position);
  }
}

/* The hit of a root whose circle's plane the ray crosses at a small angle: where it is nearest to the circle. */
BS_COLD void EVOLVED(slanted_hit)(FN(search) *search, EVOLVED(meeting) *m, S t, S at)
{
  const S *const k = m->k, rest = K(1) - at;
  S step[3], position[3];
  for (int i = 0; i < BS_EVOLVED_STEPS; i++) {
    KERNEL(evolved_polish)(step, m->origin, m->direction, &t, k + EVOLVED_NORM, k + EVOLVED_KAPPA, &rest, &at,
                           k + EVOLVED_CONTROLS, k + EVOLVED_PRODUCTS);
    if (!(step[2] - step[2] == 0)) break;
    t += step[2];
  }
  if (!EVOLVED(fresh)(m, t, at)) return;
  for (int i = 0; i < 3; i++) position[i] = m->origin[i] + t * m->direction[i];
  EVOLVED(offer)(search, m, t, at, position);
}

BS_INLINE int EVOLVED(find)(S *roots, const S *meets, const EVOLVED(meeting) *m, const FN(search) *search)
{
  EVOLVED(problem) problem;
  problem.meets = meets, problem.k = m->k, problem.origin = m->origin, problem.direction = m->direction;
#if BS_SCENE_COMPANION
  if (search->method == 1) return EVOLVED(companion)(roots, EVOLVED_ROOTS, &problem);
#endif
#if BS_SCENE_SAMPLED
  if (search->method == 2) return EVOLVED(sampled)(roots, EVOLVED_ROOTS, &problem, search->samples);
#endif
#if BS_SCENE_ISOLATE
  if (search->method == 0) {
    const S *const x = m->origin, reach = K(1) + x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
    return EVOLVED(isolate)(roots, EVOLVED_ROOTS, &problem, reach * reach);
  }
#endif
  return 0;
}

BS_OUTLINED void EVOLVED(hits)(FN(search) *search, const S *k, const FN(ray) *ray)
{
  const S *const c = k + EVOLVED_CONTROLS, *const products = k + EVOLVED_PRODUCTS;
  const S *const bound = k + EVOLVED_BOUND, *const unit = k + EVOLVED_UNIT;
  S local[3], meets[EVOLVED_MEETS], roots[EVOLVED_ROOTS];
  EVOLVED(meeting) m;
  m.k = k, m.direction = ray->direction, m.roots = roots, m.flat_count = 0;
  for (int i = 0; i < 3; i++) local[i] = (ray->origin[i] - k[i]) * unit[1];
  FN(cga3d_evolved_nearest)(&m.moved, m.origin, local, m.direction);
  if (bound[3] < BS_FAR) {
    S middle_half[2];
    FN(cga3d_evolved_approach)(middle_half, m.origin, m.direction, bound, bound + 3);
    const S middle = m.moved + middle_half[0], half = middle_half[1];
    if (!((middle + half) * unit[0] > search->t_min && (middle - half) * unit[0] < search->t_max)) return;
  }
  KERNEL(evolved_meets)(meets, m.origin, m.direction, c, products);
  m.root_count = EVOLVED(find)(roots, meets, &m, search);
  if (m.root_count < 0)
    search->status = m.root_count == BS_EVOLVED_VANISHES ? BS_STATUS_SINGULAR : BS_STATUS_INVALID;
  for (int i = 0; i < m.root_count; i++) {
    const S at = roots[i], rest = K(1) - at;
    S t_cosine[5], position[3];
    KERNEL(evolved_point)(t_cosine, position, m.origin, m.direction, meets, k + EVOLVED_NORM, k + EVOLVED_KAPPA, &rest,
                          &at, c, products);
    if (t_cosine[1] > K(BS_EVOLVED_FLAT)) {
      EVOLVED(offer)(search, &m, t_cosine[0], at, position);
    } else if (t_cosine[4] > K(BS_EVOLVED_FLAT) && t_cosine[3] > K(BS_EVOLVED_DISTANT) && t_cosine[3] < BS_FAR) {
      for (int j = 0; j < 3; j++) position[j] = m.origin[j] + t_cosine[2] * m.direction[j];
      EVOLVED(offer)(search, &m, t_cosine[2], at, position);
    } else if (t_cosine[1] > K(BS_EVOLVED_NO_MEET) * K(BS_EVOLVED_NO_MEET) * BS_ROOTS_UNIT(S) * BS_ROOTS_UNIT(S)) {
      EVOLVED(slanted_hit)(search, &m, t_cosine[0], at);
    } else {
      EVOLVED(flat_hits)(search, &m, i);
    }
  }
}

BS_OUTLINED void EVOLVED(normal)(S *normal, const S *k, const FN(ray) *ray, const FN(hit) *hit)
{
  const S at = hit->at, rest = K(1) - at;
  (void)ray;
  KERNEL(evolved_normal)(normal, hit->local, k + EVOLVED_NORM, k + EVOLVED_KAPPA, &rest, &at, k + EVOLVED_CONTROLS,
                         k + EVOLVED_PRODUCTS);
}

#undef EVOLVED
#undef KERNEL
#undef EVOLVED_QUAD
#undef EVOLVED_CENTER
#undef EVOLVED_UNIT
#undef EVOLVED_START
#undef EVOLVED_BOUND
#undef EVOLVED_REAL
#undef EVOLVED_NORM
#undef EVOLVED_KAPPA
#undef EVOLVED_CONTROLS
#undef EVOLVED_PRODUCTS
#undef EVOLVED_SIZES
#undef EVOLVED_MEETS
#undef EVOLVED_ROOTS
#undef EVOLVED_PRINTED
#undef BS_MEMBER
#undef BS_SUFFIX
#undef BS_DEGREE
#undef BS_FREE
